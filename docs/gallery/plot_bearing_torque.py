"""What the bearings of an unbalanced wheel supply
===============================================

A body that turns about an axis which is no principal axis has an angular momentum beside the axis,
that goes around with it. The bearings must supply the torque for this: it turns with the body, and
its size rises as the square of the rate. Only the part about the axis, ``I_zz omega'``, is that of
the drive; with a drive that speeds the body up, the products of inertia load the bearings as soon
as it starts.
"""

import matplotlib.pyplot as plt

from rigid import figures

tensor = [[2.0, 0.0, -0.5], [0.0, 2.0, 0.2], [-0.5, 0.2, 1.5]]
figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
figures.bearing_torque(tensor, 10.0, omega_dot=8.0, axes=axes)

plt.show()
