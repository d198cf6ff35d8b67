"""What the bearings of an unbalanced wheel supply
===============================================

If a body rotates about an axis that is not a principal axis, its angular momentum is not parallel
to the axis and rotates with the body. The bearings must supply the torque for this change. The
torque rotates with the body and grows with the square of the rate. Only the component about the
axis, ``I_zz omega'``, is the torque of the drive. If the drive speeds the body up, the products of
inertia load the bearings from the start.

How to: :doc:`balance a rotor </bodies>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

tensor = [[2.0, 0.0, -0.5], [0.0, 2.0, 0.2], [-0.5, 0.2, 1.5]]
figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
figures.bearing_torque(tensor, 10.0, omega_dot=8.0).plot(axes)

plt.show()
