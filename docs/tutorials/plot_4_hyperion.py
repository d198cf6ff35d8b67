r"""
Hyperion tumbles
================

A long moon on an eccentric orbit: its resonances overlap, its rotation is chaotic, and it does not
stay in the plane of its orbit.

Wisdom, Peale and Mignard predicted this in 1984 (*Icarus* 58, 137), and observations since 1989
agree. Is the rotation of today still chaotic? Goldberg and Batygin doubt it (*Astronomy &
Astrophysics* 692 (2024) A9).
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import CLASSES

# %%
# Hyperion is about 360 km x 266 km x 205 km large and goes round Saturn in 21.28 days, on an orbit
# of the eccentricity 0.1236. The time unit here is one orbit.
body = rigid.Body.ellipsoid(180.0, 133.0, 102.5)
moments = np.array(body.moments) / max(body.moments)
orbit = rigid.Orbit(2.0 * np.pi, eccentricity=0.1236)
hyperion = rigid.FreeBody(rigid.Body(tuple(moments)), orbit=orbit)
print("moments over the largest:", moments.round(3))
# sphinx_gallery_start_ignore
assert np.allclose(moments, [0.563, 0.857, 1.0], atol=1e-3)
# sphinx_gallery_end_ignore

# %%
# In the plane of the orbit the rotation has one angle. The frequency of small librations,
# :math:`\omega_0`, says how elongated the moon is. The resonances are so wide that they overlap for
# :math:`\omega_0 > 1/(2 + \sqrt{14 e})`, in units of the mean motion.
ratio = np.sqrt(3.0 * (moments[1] - moments[0]) / moments[2])
overlap = 1.0 / (2.0 + np.sqrt(14.0 * orbit.eccentricity))
print(f"omega_0 = {ratio:.2f} n; resonances overlap above {overlap:.2f} n")
# sphinx_gallery_start_ignore
assert ratio > 2.0 * overlap
# sphinx_gallery_end_ignore

# %%
# At each periapsis mark the angle of the long axis from the direction away from Saturn, and the
# rate: a section. Regular motions (yellow) lie on curves. The others (blue) fill one sea, up to 2.7
# turns an orbit.
# The island in it is the synchronous rotation; the islands of 3/2 and 2 turns an orbit are gone.
rates = np.array([0.3, 0.42, 0.55, 0.7, 1.0, 1.5, 2.39, 2.45, 2.78, 3.0, 3.2, 3.4])
starts = 2.0 * np.pi * np.stack([0.0 * rates, 0.0 * rates, rates], axis=-1)
points = rigid.poincare(hyperion, starts, every=orbit.period, t_end=400.0)
in_plane = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
verdict = rigid.lyapunov(
    hyperion, starts, t=[150.0, 300.0], start=in_plane, check=False
).verdict.tolist()
ink = np.array([CLASSES[word] for word in verdict])[points.body]
turned = np.mod(points.component("angle1") + 0.5 * np.pi, np.pi) - 0.5 * np.pi

figure, ax = plt.subplots()
ax.scatter(np.degrees(turned), points.omega[:, 2] / (2.0 * np.pi), c=ink, s=2.0)
ax.set(
    xlabel="angle of the long axis (degrees)",
    ylabel="turns an orbit",
    title="Hyperion at its periapsis: islands in a chaotic sea",
)
plt.show()

# %%
# How fast do motions part? In the sea a deviation in the plane grows by :math:`e` in little more
# than an orbit. In the island of the synchronous rotation it does not grow.
in_plane = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
sea, island = (2.0 * np.pi * np.array([0.0, 0.0, rate]) for rate in (1.5, 0.42))
growth = rigid.lyapunov(
    hyperion, np.stack([sea, island]), t=[150.0, 300.0], start=in_plane, check=False
)
time = 1.0 / growth.exponent[0, -1]
print(f"{growth.verdict}; a factor e in {time:.1f} orbits, {21.28 * time:.0f} days")
# sphinx_gallery_start_ignore
assert growth.verdict.tolist() == ["chaotic", "regular"]
assert 1.0 < time < 2.0
# sphinx_gallery_end_ignore

# %%
# But Hyperion does not stay in the plane. A tilt of a thousandth of a radian grows from both
# starts, also from the island: within thirty orbits, which are 21 months, the moon tumbles.
t = np.linspace(0.0, 40.0, 2001)
figure, ax = plt.subplots()
for start, colour, name in (
    (sea, CLASSES["chaotic"], "sea"),
    (island, CLASSES["regular"], "island"),
):
    tilted = rigid.rotations.euler_to_quaternion([0.0, 1e-3, 0.0])
    run = rigid.simulate(hyperion, start, tilted, t=t, method="taylor20", check=False)
    pole = run.rotation().apply([0.0, 0.0, 1.0])
    obliquity = np.degrees(np.arctan2(np.hypot(pole[:, 0], pole[:, 1]), pole[:, 2]))
    # sphinx_gallery_start_ignore
    assert obliquity[t < 5.0].max() < 1.0
    assert obliquity.max() > 90.0
    # sphinx_gallery_end_ignore
    ax.semilogy(t, obliquity, color=colour, label=f"from the {name}")
ax.set(
    xlabel="orbits", ylabel="obliquity (degrees)", title="Hyperion leaves the plane of its orbit"
)
ax.legend()
plt.show()

# %%
# A map answers the question for every spin and every obliquity: yellow rotations are regular, dark
# ones chaotic, hatched ones undecided over fifty orbits. ``rigid map hyperion`` draws it finer.
result = rigid.stability_map(
    hyperion,
    axes={"spin": 2.0 * np.pi * np.linspace(0.25, 5.75, 23), "tilt": np.linspace(0.0, np.pi, 17)},
    start=rigid.Start(spin=0.0, axis=3),
    stable=rigid.regular(),
    t_end=50.0,
    samples=1,
    rng=2026,
    progress=False,
)
# sphinx_gallery_start_ignore
slow = np.array(result.spec.axes[0].values) < 2.0 * np.pi * 2.5
upright = np.array(result.spec.axes[1].values) < 1.5
assert (result.stable[np.ix_(upright, slow)] == 0).all()  # prograde and slow: none is regular
assert (result.stable[-1, 2:] == 1).mean() > 0.9  # retrograde: nearly all are
# sphinx_gallery_end_ignore
ax = result.plot()
ax.set(xlabel="spin (rad an orbit; 6.28 is synchronous)", ylabel="obliquity (rad)")
plt.show()

# %%
# And today? In 2005 Cassini saw a spin of 4.2 to 4.5 turns an orbit, about an axis at 30° from the
# long one (Harbison, Thomas and Nicholson 2011). Take such rotations, in 60 random attitudes.
count = 60
around = 2.0 * np.pi * np.arange(count) / count
axes = np.stack(
    [
        np.full(count, np.cos(np.radians(30.0))),
        np.sin(np.radians(30.0)) * np.cos(around),
        np.sin(np.radians(30.0)) * np.sin(around),
    ],
    axis=-1,
)
attitudes = np.random.default_rng(2026).normal(size=(count, 4))
attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
seen = rigid.lyapunov(hyperion, 2.0 * np.pi * 4.35 * axes, attitudes, t=[100.0, 200.0], check=False)
verdicts = {name: int((seen.verdict == name).sum()) for name in ("regular", "chaotic", "undecided")}
median = np.median(seen.exponent[:, -1])
print(verdicts, f"median exponent {median:.2f} an orbit, {growth.exponent[0, -1]:.2f} in the sea")
# sphinx_gallery_start_ignore
assert verdicts["regular"] > 5
assert verdicts["chaotic"] > 5
assert median < 0.25 * growth.exponent[0, -1]
# sphinx_gallery_end_ignore

# %%
# So the attitude decides. Many of these rotations are regular over 200 orbits, which are twelve
# years, and the chaos of the others is some ten times slower than in the sea. Slow rotations of
# Hyperion are chaotic; whether its rotation of today is chaotic depends on its attitude.
