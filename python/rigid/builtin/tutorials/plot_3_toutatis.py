r"""
A tumbling asteroid
===================

The asteroid (4179) Toutatis turns about no fixed axis. Two periods describe its rotation. They
follow from its moments of inertia and its angular velocity on one day.

Radar showed in 1992 that Toutatis turns about its long axis in 5.41 days, while the long axis goes
round the angular momentum in 7.35 days on average (Hudson and Ostro, *Science* 270 (1995) 84).
From the flyby of Chang'e-2 Zhao and others found 5.38 ± 0.03 and 7.40 ± 0.03 days (IAU Symposium
318 (2016) 156).
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

# %%
# The motion
# ----------
#
# Ratios of the moments and the angular velocity of 9 November 1992 are from Takahashi, Busch and
# Scheeres (*Astronomical Journal* 146 (2013) 95). Axis 3 is the long one. The unit of time is the
# day. The motion is torque-free, so it has a closed form.
asteroid = rigid.FreeBody(rigid.Body((3.0836, 3.235, 1.0)))
omega = np.radians([14.5, 33.7, -98.5])
run = rigid.simulate(asteroid, omega, t=np.linspace(0.0, 1500.0, 30001))

# %%
# The rotation: the angle of the angular momentum about the long axis, seen in the body.
momentum = run.omega * np.array(asteroid.body.moments)
turned = np.unwrap(np.arctan2(momentum[:, 1], momentum[:, 0]))
rotation = 2.0 * np.pi * run.t[-1] / abs(turned[-1] - turned[0])

# %%
# The precession: the angle of the long axis about the angular momentum, seen in space.
attitude = run.rotation()
pole = attitude[0].apply(momentum[0])
pole /= np.linalg.norm(pole)
across = np.cross(pole, [1.0, 0.0, 0.0])
across /= np.linalg.norm(across)
long_axis = attitude.apply([0.0, 0.0, 1.0])
carried = np.unwrap(np.arctan2(long_axis @ np.cross(pole, across), long_axis @ across))
precession = 2.0 * np.pi * run.t[-1] / abs(carried[-1] - carried[0])
print(f"rotation {rotation:.2f} d, precession {precession:.2f} d")
# sphinx_gallery_start_ignore
assert abs(rotation - 5.38) < 0.03
assert abs(precession - 7.40) < 0.03
# sphinx_gallery_end_ignore

# %%
# Both periods follow from the state of one day without a run.
found = rigid.free.spin_periods(asteroid, omega)
print(f"rotation {found.rotation:.4f} d, precession {found.precession:.4f} d, {found.mode}")
# sphinx_gallery_start_ignore
assert abs(found.rotation - rotation) < 0.01
assert abs(found.precession - precession) < 0.01
# sphinx_gallery_end_ignore

# %%
# In space
# --------
#
# The tip of the long axis goes round the angular momentum in a narrow band. The tip of axis 1,
# which the rotation about the long axis carries around, never comes back to its start. These are
# the paths of two months.
days = run.t < 60.0
side = attitude[days].apply([1.0, 0.0, 0.0])
towards = np.array([across, np.cross(pole, across), pole])  # the angular momentum points up

figure = plt.figure(figsize=(7, 7), layout="constrained")
ax = figure.add_subplot(projection="3d", proj_type="ortho")
ax.set_axis_off()
ax.plot(*towards @ long_axis[days].T, color=HUES["vermilion"], label="tip of the long axis")
ax.plot(*towards @ side.T, color=HUES["blue"], linewidth=0.6, label="tip of axis 1")
ax.quiver(0.0, 0.0, 0.0, 0.0, 0.0, 1.35, color=HUES["black"], arrow_length_ratio=0.08)
ax.text(0.0, 0.0, 1.42, "L", ha="center")
ax.quiver(0.0, 0.0, 0.0, *towards @ long_axis[0], color=HUES["vermilion"], arrow_length_ratio=0.1)
ax.view_init(elev=20.0, azim=-60.0)
ax.set_box_aspect((1.0, 1.0, 1.0), zoom=1.3)
ax.set(xlim=(-1.0, 1.0), ylim=(-1.0, 1.0), zlim=(-0.9, 1.1), title="Toutatis in two months")
ax.legend(loc="lower right")
plt.show()

# %%
# :func:`rigid.free.spin_state` goes the other way: from two observed periods to the angular
# velocity. :doc:`plot_6_apophis` begins so.
