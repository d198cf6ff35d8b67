r"""
Free rotation
=============

From the moments of inertia to the cones of a symmetric body, and to the polhode of a body with
three different moments.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

# %%
# A body with :math:`I_1 = I_2 = 1` and :math:`I_3 = 1.6` turns with :math:`\omega = (0.9, 0,
# 2.3)`. Seen in the body, :math:`\omega` goes round axis 3 at the rate
# :math:`k = \omega_3 (I_3 - I_1)/I_1`; the axis goes round :math:`L` at :math:`\dot\phi = L/I_1`.
disk = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.6)))
omega = np.array([0.9, 0.0, 2.3])
momentum = np.array(disk.body.moments) * omega
k = omega[2] * 0.6
angle = np.arctan2(momentum[0], momentum[2])
precession = np.linalg.norm(momentum)
# sphinx_gallery_start_ignore
assert abs(2.0 * np.pi / k - 4.55303283129) < 1e-10
assert abs(angle - 0.239857068984) < 1e-11
assert abs(precession - 3.7884561499) < 1e-9
# sphinx_gallery_end_ignore
print(f"rate in the body {k:.3f} rad/s, precession {precession:.4f} rad/s, angle {angle:.4f} rad")

# %%
# The motion shows the same: after one period in the body, the rates are again the rates of the
# start.
period = 2.0 * np.pi / k
run = rigid.simulate(disk, omega, t=np.linspace(0.0, period, 201))
# sphinx_gallery_start_ignore
assert np.allclose(run.omega[-1], omega, atol=1e-12)
# sphinx_gallery_end_ignore
print("after one period:", run.omega[-1].round(9))

# %%
# Three different moments: 1, 2 and 3. The rates after 10 s agree with a computation in 40 digits.
asymmetric = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
state = rigid.simulate(asymmetric, [0.3, 0.2, 1.2], t=[10.0]).omega[-1]
# sphinx_gallery_start_ignore
assert np.allclose(state, [0.360501364129, -0.00622627184467, 1.20553739518], atol=1e-11)
# sphinx_gallery_end_ignore
print(state)

# %%
# Poinsot: the ellipsoid of inertia rolls on a plane across :math:`L`. The component of
# :math:`\omega` along :math:`L` is the distance of this plane, :math:`2E/L`, and stays constant.
body = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
omega = np.array([1.1, 0.3, 0.4])
rolling = rigid.simulate(body, omega, t=np.linspace(0.0, 20.0, 801))
momenta = rolling.omega * np.array(body.body.moments)
distance = np.sum(rolling.omega * momenta, axis=1) / np.linalg.norm(momenta, axis=1)
# sphinx_gallery_start_ignore
assert np.ptp(distance) < 1e-14
# sphinx_gallery_end_ignore
print(f"distance {distance[0]:.6f}; it changes by {np.ptp(distance):.0e}")
figures.poinsot(rolling, frame=455).plot()
plt.show()
