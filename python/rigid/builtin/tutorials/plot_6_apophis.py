r"""
Apophis passes the Earth
========================

On 13 April 2029 the asteroid (99942) Apophis passes the Earth at 38 000 km from its centre. The
asteroid tumbles, and the gravity of the Earth will change its rotation. How much? That depends on
the attitude in the passage, which is not known well: the answer is a distribution.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

# %%
# The rotation today
# ------------------
#
# Observers see two periods: the long axis goes round the angular momentum in 27.38 h, and the body
# oscillates about the long axis in 263 h (Pravec and others, *Icarus* 233 (2014) 48). With the
# ratios of the moments these periods determine energy and angular velocity. The mode is ``"SAM"``,
# the short-axis mode. The unit of time is the hour here.
body = rigid.Body((0.61, 0.965, 1.0))
periods = {"precession": 27.38, "rotation": 263.0, "mode": "SAM"}
today = rigid.free.spin_state(body, **periods)
print(f"energy over the least energy with this momentum: {float(today.energy):.3f}")
# sphinx_gallery_start_ignore
assert abs(float(today.energy) - 1.024) < 0.013
# sphinx_gallery_end_ignore

# %%
# The passage
# -----------
#
# The least distance and the speed far away give the hyperbola. Its plane and periapsis, in the
# axes of the ecliptic, follow from the position and the velocity there in the ephemeris of JPL
# (solution 218). The passage is after three days.
nearest = np.array([-19187.2474, 32258.7828, 6007.9699])  # km
velocity = np.array([6.332190, 3.405197, 1.844468])  # km/s
normal = np.cross(nearest, velocity)
flyby = rigid.Orbit.flyby(
    gm=398600.44 * 3600.0**2,
    periapsis=float(np.linalg.norm(nearest)),
    speed=5.8414 * 3600.0,
    time=72.0,
    normal=normal / np.linalg.norm(normal),
    towards=nearest / np.linalg.norm(nearest),
)
print(f"eccentricity {float(flyby.eccentricity):.3f}")
# sphinx_gallery_start_ignore
assert abs(float(flyby.eccentricity) - 4.254) < 0.001
# sphinx_gallery_end_ignore

# %%
# Two thousand starts
# -------------------
#
# The angular momentum points near the south pole of the ecliptic, here to the longitude 278° and
# the latitude −86°. The phases of precession and rotation in the passage are taken as unknown: each
# is uniform. The moments are known to some percent: ``sample_bodies`` draws them too. Bodies with
# other moments have other periods at the same angular velocity; the few that are in the long-axis
# mode before the passage are left out below.
longitude, latitude = np.radians([278.0, -86.0])
east, north = np.cos(longitude), np.sin(longitude)
pole = np.array([np.cos(latitude) * east, np.cos(latitude) * north, np.sin(latitude)])
phases = np.random.default_rng(2029).uniform(0.0, 2.0 * np.pi, size=(2000, 2))
starts = rigid.free.spin_state(body, **periods, pole=pole, phases=phases)

bodies = rigid.sample_bodies(
    rigid.FreeBody(body, orbit=flyby),
    vary={"I1": rigid.normal(0.03), "I2": rigid.normal(0.005)},
    count=len(phases),
    rng=2029,
)
run = rigid.simulate(bodies, starts.omega, starts.attitude, t=[0.0, 144.0])
print(f"largest estimated error: {run.error.max():.0e}")
# sphinx_gallery_start_ignore
assert run.error.max() < 1e-7
# sphinx_gallery_end_ignore

# %%
# What becomes of them
# --------------------
#
# Three days after the passage each body is free again, and ``spin_periods`` has its mode and its
# periods. The effective spin rate is :math:`2E/L`; the pole is the direction of :math:`L`.
after = rigid.free.spin_periods(bodies.body, run.omega[:, 1])
L = run.momentum("space")
size = np.linalg.norm(L, axis=-1)
effective = np.sum(run.omega * run.momentum(), axis=-1) / size
ratio = effective[:, 1] / effective[:, 0]
shift = np.degrees(np.arccos(np.sum(L[:, 0] * L[:, 1], axis=-1) / (size[:, 0] * size[:, 1])))
nearer = np.abs(L[:, 1, 2] / size[:, 1]) < np.abs(L[:, 0, 2] / size[:, 0])
short = rigid.free.spin_periods(bodies.body, run.omega[:, 0]).mode == "SAM"
ratio, shift, nearer, kept = ratio[short], shift[short], nearer[short], after.mode[short] == "SAM"
print(f"short-axis mode kept: {kept.mean():.0%}")
print(f"effective spin rate: {ratio.min():.2f} to {ratio.max():.2f} of the rate before")
print(f"shift of the pole: median {np.median(shift):.0f}°, above 10° for {(shift > 10).mean():.0%}")
print(f"pole nearer to the ecliptic: {nearer.mean():.0%}")
# sphinx_gallery_start_ignore
assert 0.65 < kept.mean() < 0.85
assert 0.4 < ratio.min() < 0.65
assert 1.5 < ratio.max() < 2.1
assert 7.0 < np.median(shift) < 13.0
assert nearer.mean() > 0.75
# sphinx_gallery_end_ignore

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), sharey=True, layout="constrained")
for axis, values, edges in (
    (left, ratio, np.linspace(0.5, 1.8, 40)),
    (right, shift, np.linspace(0.0, 40.0, 41)),
):
    colours = [HUES["blue"], HUES["orange"]]
    names = ["short-axis mode", "long-axis mode"]
    axis.hist([values[kept], values[~kept]], edges, stacked=True, color=colours, label=names)
left.set(xlabel="effective spin rate, after over before", ylabel="bodies")
right.set(xlabel="shift of the pole (degrees)")
right.legend()
figure.suptitle("Apophis after the passage, with unknown phases")
plt.show()

# %%
# Benson and others (*Icarus* 390 (2023) 115324) found with the attitude that they expect: Apophis
# is "likely to remain" in the short-axis mode, its effective spin rate "could halve or double", and
# its pole "is likely to shift by 10 degrees or more" and towards the ecliptic. A later study of the
# light curves says that the mode "will be preserved with a high likelihood" (*A&A* 709 (2026)
# A278). With unknown phases a quarter of the bodies leaves the mode.
#
# ``rigid map apophis`` shows how the mode depends on the distance of the passage and on the
# tumbling before it. ``run.animate("apophis.html", body=7)`` writes a film of one body, if ``t``
# has more times.
