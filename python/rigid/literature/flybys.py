"""Apophis passes the Earth in 2029: its hyperbola, its period and its mode after the passage."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from ..model.body import Body
from ..model.bounds import no_flip
from ..model.noise import uniform, uniform_attitude
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..model.start import Start
from ..solve.simulate import simulate
from ..store.call import stability_map

GM = 398600.44
"""Of the Earth, km³/s²."""

MOMENTS = (0.729, 0.947, 1.0)
"""Ratios of the moments of Apophis by radar, Brozović et al. (2018)."""

HOUR, DAY = 3600.0, 86400.0


def at_perigee() -> Orbit:
    """The hyperbola with the distance and the speed of the perigee that the source has; km, s."""
    nearest, fastest = 5.96 * 6378.137, 7.43
    speed = sqrt(fastest**2 - 2.0 * GM / nearest)
    return Orbit.flyby(gm=GM, periapsis=nearest, speed=speed, time=0.0)


def eccentricity() -> float:
    """Eccentricity of the hyperbola by distance and speed of the perigee."""
    return float(at_perigee().eccentricity)


def semi_major_axis() -> float:
    """Semi-major axis of the same hyperbola (1e4 km)."""
    return float(np.cbrt(GM / np.asarray(at_perigee().rate) ** 2) / 1e4)


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
