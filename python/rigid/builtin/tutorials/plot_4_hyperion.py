r"""
Hyperion tumbles
================

Hyperion is a long moon of Saturn on an eccentric orbit. Wisdom, Peale and Mignard predicted in 1984
(*Icarus* 58, 137) that it tumbles chaotically, and observations since 1989 agree. This page draws
the section of their paper, shows why the moon leaves the plane of its orbit, and asks whether it is
chaotic today.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import CLASSES

# %%
# The moon and its orbit
# ----------------------
#
# Hyperion measures about 360 km by 266 km by 205 km and goes round Saturn in 21.28 days, with the
# eccentricity 0.1236. With a mean motion of 1, angular velocities are turns an orbit, and an orbit
# takes the time :math:`2\pi`.
body = rigid.Body.ellipsoid(180.0, 133.0, 102.5)
moments = np.array(body.moments) / max(body.moments)
orbit = rigid.Orbit(1.0, eccentricity=0.1236)
hyperion = rigid.FreeBody(rigid.Body(tuple(moments)), orbit=orbit)
print("moments over the largest:", moments.round(3))
# sphinx_gallery_start_ignore
assert np.allclose(moments, [0.563, 0.857, 1.0], atol=1e-3)
# sphinx_gallery_end_ignore

# %%
# Small librations in the plane of the orbit have the frequency :math:`\omega_0`, in units of the
# mean motion. The resonances of rotation and orbit overlap for
# :math:`\omega_0 > 1/(2 + \sqrt{14 e})`.
ratio = np.sqrt(3.0 * (moments[1] - moments[0]) / moments[2])
overlap = 1.0 / (2.0 + np.sqrt(14.0 * orbit.eccentricity))
print(f"omega_0 = {ratio:.2f}; resonances overlap above {overlap:.2f}")
# sphinx_gallery_start_ignore
assert ratio > 2.0 * overlap
# sphinx_gallery_end_ignore

# %%
# A section at each periapsis
# ---------------------------
#
# At each periapsis we mark the angle of the long axis from the direction away from Saturn, and the
# angular velocity. Regular motions (yellow) lie on curves. All others (blue) fill one chaotic sea,
# up to 2.7 turns an orbit. The island in it is the synchronous rotation.
turns = np.array([0.3, 0.42, 0.55, 0.7, 1.0, 1.5, 2.39, 2.45, 2.78, 3.0, 3.2, 3.4])
starts = np.stack([0.0 * turns, 0.0 * turns, turns], axis=-1)
points = rigid.poincare(hyperion, starts, every=orbit.period, t_end=400.0 * orbit.period)
in_plane = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
times = orbit.period * np.array([150.0, 300.0])
verdicts = rigid.lyapunov(hyperion, starts, t=times, start=in_plane, check=False).verdict
colour = np.array([CLASSES[word] for word in verdicts.tolist()])[points.body]
angle = np.mod(points.component("angle1") + 0.5 * np.pi, np.pi) - 0.5 * np.pi

figure, ax = plt.subplots(figsize=(8, 6), layout="constrained")
ax.scatter(np.degrees(angle), points.omega[:, 2], c=colour, s=2.0)
ax.set(xlabel="angle of the long axis (degrees)", ylabel="turns an orbit")
ax.set_title("Hyperion at its periapsis: islands in a chaotic sea")
plt.show()

# %%
# In the sea a deviation in the plane grows by a factor e in little more than an orbit. In the
# island it does not grow.
pair = np.array([[0.0, 0.0, 1.5], [0.0, 0.0, 0.42]])  # sea, island
growth = rigid.lyapunov(hyperion, pair, t=times, start=in_plane, check=False)
orbits = 1.0 / (growth.exponent[0, -1] * orbit.period)
print(f"{growth.verdict}; a factor e in {orbits:.1f} orbits, {21.28 * orbits:.0f} days")
# sphinx_gallery_start_ignore
assert growth.verdict.tolist() == ["chaotic", "regular"]
assert 1.0 < orbits < 2.0
# sphinx_gallery_end_ignore

# %%
# Out of the plane
# ----------------
#
# Hyperion does not stay in the plane. A tilt of a thousandth of a radian grows from both starts,
# also from the island: within thirty orbits, or 21 months, the moon tumbles.
t = orbit.period * np.linspace(0.0, 40.0, 2001)
tilted = rigid.rotations.euler_to_quaternion([0.0, 1e-3, 0.0])
run = rigid.simulate(hyperion, pair, tilted, t=t, method="taylor20", check=False)
obliquity = np.degrees(np.arccos(np.clip(run.rotation().as_matrix()[..., 2, 2], -1.0, 1.0)))
# sphinx_gallery_start_ignore
assert obliquity[:, t < 5.0 * orbit.period].max() < 1.0
assert (obliquity.max(axis=1) > 90.0).all()
# sphinx_gallery_end_ignore
figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
for values, word, name in zip(obliquity, ("chaotic", "regular"), ("sea", "island"), strict=True):
    ax.semilogy(t / orbit.period, values, color=CLASSES[word], label=f"from the {name}")
ax.set(xlabel="orbits", ylabel="obliquity (degrees)")
ax.set_title("Hyperion leaves the plane of its orbit")
ax.legend()
plt.show()

# %%
# A map answers the question for every spin and every obliquity: yellow rotations are regular, dark
# ones chaotic, hatched ones undecided over fifty orbits.
result = rigid.stability_map(
    hyperion,
    axes={"spin": np.linspace(0.25, 5.75, 23), "tilt": np.linspace(0.0, np.pi, 17)},
    start=rigid.Start(spin=0.0, axis=3),
    stable=rigid.regular(),
    t_end=50.0 * orbit.period,
    time_unit="orbit",
    samples=1,
    rng=2026,
    progress=False,
)
# sphinx_gallery_start_ignore
slow = np.array(result.spec.axes[0].values) < 2.5
upright = np.array(result.spec.axes[1].values) < 1.5
assert (result.stable[np.ix_(upright, slow)] == 0).all()  # prograde and slow: none is regular
assert (result.stable[-1, 2:] == 1).mean() > 0.9  # retrograde: nearly all are
# sphinx_gallery_end_ignore
figure, ax = plt.subplots(figsize=(8, 6), layout="constrained")
result.plot(ax=ax)
ax.set(xlabel="turns an orbit", ylabel="obliquity (rad)")
ax.set_title("Regular rotations of Hyperion over fifty orbits", loc="left")
plt.show()

# %%
# Is it chaotic today?
# --------------------
#
# In 2005 Cassini saw a spin of 4.2 to 4.5 turns an orbit, about an axis at 30° from the long one
# (Harbison, Thomas and Nicholson 2011). Here are such rotations in 60 random attitudes.
count = 60
around = 2.0 * np.pi * np.arange(count) / count
across = np.sin(np.radians(30.0))
axes = np.stack(
    [np.full(count, np.cos(np.radians(30.0))), across * np.cos(around), across * np.sin(around)],
    axis=-1,
)
attitudes = np.random.default_rng(2026).normal(size=(count, 4))
times = orbit.period * np.array([100.0, 200.0])
seen = rigid.lyapunov(hyperion, 4.35 * axes, attitudes, t=times, check=False)
counts = {word: int((seen.verdict == word).sum()) for word in ("regular", "chaotic", "undecided")}
slower = growth.exponent[0, -1] / np.median(seen.exponent[:, -1])
print(f"{counts}; the median exponent is {slower:.0f} times smaller than in the sea")
# sphinx_gallery_start_ignore
assert counts["regular"] > 5
assert counts["chaotic"] > 5
assert slower > 4.0
# sphinx_gallery_end_ignore

# %%
# So the attitude decides. Many of these rotations are regular over 200 orbits, which are twelve
# years, and the chaos of the others is slow. Goldberg and Batygin doubt that Hyperion is chaotic
# today (*Astronomy & Astrophysics* 692 (2024) A9).
