r"""
The heavy top
=============

A top that leans does not fall: it precesses and nutates. An upright top sleeps if its spin is fast
enough. This page computes the three motions of one top, with :math:`I_1 = I_2 = 1`,
:math:`I_3 = 1/2` and :math:`mgl = 1`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)

# %%
# Nutation
# --------
#
# The axis leans at 60° and is released at rest with a spin of 5 rad/s about it. It falls, turns
# aside, and comes to rest again: a cusp. The height of its tip, :math:`u = \cos\theta`, moves
# between two roots of a cubic, here 0.5 and 0.192.
attitude = rigid.rotations.euler_to_quaternion([0.0, np.radians(60.0), 0.0])
known = rigid.top.heavy_constants(top, [0.0, 0.0, 5.0], attitude)
period = float(rigid.top.nutation_period(a=known.a, b=known.b, alpha=known.alpha, beta=known.beta))
run = rigid.simulate(top, [0.0, 0.0, 5.0], attitude, t=np.linspace(0.0, 2.0 * period, 801))
axis = run.rotation().apply([0.0, 0.0, 1.0])
turned = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
angle = np.degrees(turned[400] - turned[0])
print(f"a nutation takes {period:.4f} s and carries the axis by {angle:.2f} degrees")
# sphinx_gallery_start_ignore
assert abs(period - 2.76392864943) < 1e-10
assert abs(axis[:, 2].min() - 0.191767987534) < 1e-9
assert abs(axis[400, 2] - 0.5) < 1e-9
assert abs(np.radians(angle) - 1.14228871898) < 1e-8
# sphinx_gallery_end_ignore

figure, ax = plt.subplots(figsize=(6, 6), layout="constrained")
ax.plot(axis[:, 0], axis[:, 1], color=HUES["blue"])
for u in (0.5, 0.191767987534):
    sine = np.sqrt(1.0 - u * u)
    ax.add_patch(plt.Circle((0.0, 0.0), sine, fill=False, linestyle="dashed", color=HUES["black"]))
ax.text(0.0, 0.8, "highest: u = 0.5", ha="center", va="top")
ax.text(0.0, 1.01, "lowest: u = 0.192", ha="center")
ax.set(xlabel="$x'$", ylabel="$y'$", aspect="equal", ylim=(-1.05, 1.15))
ax.set_title("The tip of the axis from above")
plt.show()

# %%
# Steady precession
# -----------------
#
# At 60° two precessions keep the tilt, a slow and a fast one: the roots of
# :math:`I_1\cos\theta\,\Omega^2 - I_3\omega_3\,\Omega + mgl = 0`. Started with the slow one, the
# top leans by the same angle for ever.
slow, fast = np.sort(np.roots([0.5, -2.5, 1.0]))
steady = rigid.simulate(
    top,
    [slow * np.sin(np.radians(60.0)), 0.0, 5.0],
    rigid.rotations.euler_to_quaternion([0.0, np.radians(60.0), np.pi / 2]),
    t=np.linspace(0.0, 50.0, 501),
)
tilt = np.degrees(np.arccos(steady.gamma[:, 2]))
print(
    f"precession at {slow:.4f} or {fast:.4f} rad/s; the tilt changes by {np.ptp(tilt):.0e} degrees"
)
# sphinx_gallery_start_ignore
assert np.allclose([slow, fast], [0.438447187191, 4.56155281281])
assert np.ptp(tilt) < 1e-11
# sphinx_gallery_end_ignore

# %%
# Sleep
# -----
#
# An upright top is stable above the spin :math:`2\sqrt{mgl\,I_1}/I_3`. Two tops begin with a tilt
# of 3°: the slow one falls and rises again and again, the fast one hardly moves. There is no table:
# a top may swing below its fixed point.
bound = float(rigid.exact.sleeping_spin(top))
print(f"a top sleeps above {bound} rad/s")
upright = rigid.rotations.euler_to_quaternion([0.0, np.radians(3.0), 0.0])
t = np.linspace(0.0, 30.0, 1501)
both = rigid.simulate(top, [[0.0, 0.0, 3.6], [0.0, 0.0, 4.6]], upright, t=t)
tilts = np.degrees(np.arccos(both.gamma[..., 2]))
# sphinx_gallery_start_ignore
assert bound == 4.0
assert tilts[0].max() > 40.0
assert tilts[1].max() < 10.0
# sphinx_gallery_end_ignore
figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
for values, colour, spin in zip(tilts, ("blue", "vermilion"), (3.6, 4.6), strict=True):
    ax.plot(t, values, color=HUES[colour], label=f"spin {spin} rad/s")
ax.set(xlabel="t (s)", ylabel="tilt (degrees)", title="Below and above the sleeping spin")
ax.legend(loc="upper right")
plt.show()

# %%
# A real push and a real time blur this border: :doc:`a stability map </maps>` shows how.
