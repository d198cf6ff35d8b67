r"""
The heavy top
=============

A top with :math:`I_1 = I_2 = 1`, :math:`I_3 = 1/2` and :math:`mgl = 1` leans at 60°: nutation,
steady precession, sleep.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)

# %%
# The axis is released at rest with a spin of 5 rad/s about it. The axis falls, precesses, and comes
# to rest again: a cusp. :math:`u = \cos\theta` runs between the roots of a cubic.
tilt = np.radians(60.0)
attitude = rigid.rotations.euler_to_quaternion([0.0, tilt, 0.0])
period = 2.76392864943
run = rigid.simulate(top, [0.0, 0.0, 5.0], attitude, t=np.linspace(0.0, 2.0 * period, 801))
axis = run.rotation().apply([0.0, 0.0, 1.0])
# sphinx_gallery_start_ignore
assert abs(axis[:, 2].min() - 0.191767987534) < 1e-9
assert abs(axis[400, 2] - 0.5) < 1e-9
# sphinx_gallery_end_ignore
turned = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))[400] - np.arctan2(axis[0, 1], axis[0, 0])
# sphinx_gallery_start_ignore
assert abs(turned - 1.14228871898) < 1e-8
# sphinx_gallery_end_ignore
print(f"a nutation takes {period:.4f} s and carries the axis by {np.degrees(turned):.2f} degrees")

figure, ax = plt.subplots()
ax.plot(axis[:, 0], axis[:, 1], color=HUES["blue"], label="end of the axis")
turn = np.linspace(0.0, 2.0 * np.pi, 181)
for u, style in ((0.5, "k--"), (0.191767987534, "k:")):  # roots of the cubic
    sine = np.sqrt(1.0 - u * u)
    ax.plot(sine * np.cos(turn), sine * np.sin(turn), style, linewidth=1.0, label=f"$u = {u:.3g}$")
ax.set(xlabel="$x'$", ylabel="$y'$", aspect="equal", title="The axis of the top from above: cusps")
ax.legend(loc="center")

# %%
# Two rates of precession are steady at 60°, the roots of
# :math:`I_1\cos\theta\,\Omega^2 - I_3\omega_3\,\Omega + mgl = 0`.
roots = np.sort(np.roots([0.5, -2.5, 1.0]))
# sphinx_gallery_start_ignore
assert np.allclose(roots, [0.438447187191, 4.56155281281])
# sphinx_gallery_end_ignore
spin = float(rigid.exact.sleeping_spin(top))
# sphinx_gallery_start_ignore
assert spin == 4.0
# sphinx_gallery_end_ignore
print(f"steady precession at {roots} rad/s; upright it sleeps above {spin} rad/s")

# %%
# Which tops sleep? A map over the spin and over the first push.
result = rigid.stability_map(
    top,
    axes={"spin": np.linspace(2.0, 6.0, 40), "attitude_noise": np.geomspace(1e-3, 0.3, 30)},
    start=rigid.Start(spin=5.0, attitude_noise=rigid.normal(1e-3)),
    stable=rigid.tilt_below(0.5),
    t_end=20.0,
    samples=32,
    rng=2026,
    progress=False,
)
result.plot()
plt.show()
