"""Apophis passes the Earth in 2029: its hyperbola, its period and its mode after the passage."""

from __future__ import annotations

from functools import cache
from math import pi, sqrt

import numpy as np

from ..model.body import Body
from ..model.criteria import no_flip
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..model.start import Start, uniform, uniform_attitude
from ..solve.simulate import simulate
from ..store.call import stability_map
from .entry import Entry

DEMARTINI = (
    "J. V. DeMartini et al., Using a discrete element method to investigate seismic response and "
    "spin change of 99942 Apophis during its 2029 tidal encounter with Earth, Icarus 328 (2019) 93"
)
TABLE = "table 1 and appendix A of the manuscript: perigee 5.96 Earth radii, 7.43 km/s there"
BENSON = (
    "C. J. Benson, D. J. Scheeres, M. Brozović, S. R. Chesley, P. Pravec, P. Scheirich, Spin state "
    "evolution of (99942) Apophis during its 2029 Earth encounter, Icarus 390 (2023) 115324, "
    "arXiv:2210.13365"
)

GM = 398600.44
"""Of the Earth, km³/s²."""

MOMENTS = (0.729, 0.947, 1.0)
"""Ratios of the moments of Apophis by radar, Brozović et al. (2018)."""

HOUR, DAY = 3600.0, 86400.0


@cache
def at_perigee() -> Orbit:
    """The hyperbola with the distance and the speed of the perigee that the source has; km, s."""
    nearest, fastest = 5.96 * 6378.137, 7.43
    speed = sqrt(fastest**2 - 2.0 * GM / nearest)
    return Orbit.flyby(gm=GM, periapsis=nearest, speed=speed, time=0.0)


def share_of_changes() -> float:
    """Share of random attitudes whose change of period lies between the published extremes."""
    orbit = Orbit.flyby(gm=GM, periapsis=38011.4, speed=5.8414, time=3.0 * DAY)
    attitudes = np.random.default_rng(1).normal(size=(2000, 4))
    spin = 2.0 * pi / (30.56 * HOUR)
    run = simulate(FreeBody(Body(MOMENTS), orbit=orbit), [0.0, 0.0, spin], attitudes, t=[6.0 * DAY])
    period = 2.0 * pi / np.linalg.norm(run.omega[:, 0], axis=1) / HOUR
    change = period - 30.56
    return float(np.mean((change > -7.603) & (change < 14.440)))


def share_of_short_axis_mode() -> float:
    """Share of bodies like Apophis, in random attitudes and phases, that keep the mode."""
    orbit = Orbit(5.0006e-4, 4.254, -518.5)  # the passage is after twelve days
    result = stability_map(
        FreeBody(Body(MOMENTS), orbit=orbit),
        axes={"tilt": [0.35]},
        vary={"anomaly": uniform(240.0)},
        start=Start(spin=6.5e-5, axis=3, attitude_noise=uniform_attitude()),
        stable=no_flip(3),
        samples=400,
        t_end=3.6e6,
        rng=1,
        progress=False,
    )
    return float(result.share[0])


ENTRIES = (
    Entry(
        name="apophis-eccentricity",
        quantity="(99942) Apophis in 2029: eccentricity at the Earth, from distance and speed of "
        "the perigee",
        printed="4.25",
        within=0.0165,
        interval="rounding of distance, speed and number",
        source=DEMARTINI,
        seen=TABLE,
        compute=lambda: float(at_perigee().eccentricity),
    ),
    Entry(
        name="apophis-axis",
        quantity="(99942) Apophis in 2029: semi-major axis at the Earth, from distance and speed "
        "of the perigee",
        printed="1.17",
        within=0.008,
        interval="rounding of distance, speed and number",
        unit="1e4 km",
        source=DEMARTINI,
        seen=TABLE,
        compute=lambda: float(np.cbrt(GM / np.asarray(at_perigee().rate) ** 2) / 1e4),
    ),
    Entry(
        name="apophis-period-change",
        quantity="(99942) Apophis in 2029, 30.56 h about its short axis: share of random attitudes "
        "whose period changes by -7.603 to 14.440 h, the extremes of 32 runs with a rubble pile",
        printed="31/33",
        value=31.0 / 33.0,
        within=0.082,
        interval="two standard deviations of what lies between the extremes of 32 draws",
        source=DEMARTINI,
        seen="table 2 and section 5 of the manuscript",
        compute=share_of_changes,
    ),
    Entry(
        name="apophis-mode",
        quantity="(99942) Apophis in 2029: share of random attitudes and phases of its tumbling "
        "that keep the short-axis mode",
        printed="likely",
        value=1.0,
        within=0.1,
        interval="the source says *likely*",
        source=BENSON,
        seen="the abstract",
        compute=share_of_short_axis_mode,
    ),
)
