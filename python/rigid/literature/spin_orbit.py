"""Moons and planets on eccentric orbits: resonances, librations and chaos of their rotation."""

from __future__ import annotations

from functools import cache
from math import degrees, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arrays import Floats
from ..model.body import Body
from ..model.bounds import librates, pointing_within
from ..model.measures import spin_orbit_ratio
from ..model.noise import normal
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..model.start import Start
from ..solve.frequencies import frequencies
from ..solve.lyapunov import lyapunov
from ..solve.simulate import simulate
from ..store.call import stability_map

HYPERION = (0.5956, 0.8594, 1.0)
"""Moments of a homogeneous ellipsoid of 190 km x 145 km x 114 km, as in 1984."""

MERCURY = 4.0 * 1.0e-5 / 0.34
"""``(B - A)/C`` of Mercury: ``4 C22 M R² / C``."""

E_MERCURY = 0.2056
YEAR_OF_MERCURY = 87.969 / 365.25
"""Eccentricity, and period in years."""

E_WIDTH = 0.2
"""Eccentricity of the resonance whose width is measured."""


def in_orbits(moments: ArrayLike, eccentricity: float = 0.0) -> FreeBody:
    """Moons on an orbit that takes the time 1, from the periapsis."""
    return FreeBody(Body(moments), orbit=Orbit(2.0 * pi, eccentricity))


def about_normal(turns: ArrayLike) -> Floats:
    """Rates of spins about axis 3, in turns an orbit."""
    rate = 2.0 * pi * np.asarray(turns, dtype=np.float64)
    return np.stack([0.0 * rate, 0.0 * rate, rate], axis=-1)


def ellipsoid(ab: ArrayLike, bc: float) -> Floats:
    """Moments over the largest of homogeneous ellipsoids with these ratios of the semi-axes."""
    long, short = np.asarray(ab) ** 2, 1.0 / bc**2
    return np.stack(
        [(1.0 + short) / (1.0 + long), (long + short) / (1.0 + long), 1.0 + 0.0 * long], -1
    )


def angles(attitude: Floats) -> Floats:
    """Angle of axis 1 from the periapsis of bodies that turn about axis 3."""
    return np.asarray(2.0 * np.arctan2(attitude[..., 3], attitude[..., 0]))


def wrapped(angle: Floats) -> Floats:
    """Angles from -pi to pi."""
    return np.asarray(angle - 2.0 * pi * np.round(angle / (2.0 * pi)))


def swing(scene: FreeBody, rate: float, t: Floats, turns: float, method: str | None) -> Floats:
    """Angles from a steady rotation with so many turns an orbit, of motions in the plane."""
    run = simulate(scene, about_normal(rate), t=t, method=method, check=False)
    assert run.attitude is not None
    return wrapped(angles(run.attitude) - 2.0 * pi * turns * t)


def swing_with_orbit(scene: FreeBody, turns: float, *, orbits: int, count: int) -> float:
    """Amplitude (rad) with the period of the orbit, among so many frequencies of the swing."""
    t = np.linspace(0.0, orbits, 40 * orbits + 1)
    found = frequencies(t, swing(scene, turns, t, turns, "taylor20"), count=count)
    nearest = np.argmin(np.abs(np.abs(found.frequency) - 2.0 * pi))
    return float(np.abs(found.amplitude[nearest]))


def chaotic_time() -> float:
    """Time of growth by a factor e in the plane (orbits), the median of 13 spins."""
    scene, starts = in_orbits(HYPERION, 0.1), about_normal(np.linspace(1.0, 2.2, 13))
    in_plane = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
    growth = lyapunov(scene, starts, t=[300.0], start=in_plane, check=False)
    return float(1.0 / np.median(growth.exponent[:, -1]))


def growing_states(moments: tuple[float, float, float] = HYPERION) -> float:
    """How many of the spins 1/2 and 1 an orbit leave the plane, on an orbit of e = 0.1.

    A state that is the same after an orbit has by symmetry half of its turn at the apoapsis; the
    long axis points to the planet at the periapsis for 1, and across it for 1/2. It grows if a
    multiplier of the four deviations out of the plane exceeds 1.
    """
    scene, growing = in_orbits(moments, 0.1), 0
    swing = 3.0 * (moments[1] - moments[0]) / moments[2]
    out = np.ix_([0, 1, 3, 4], [0, 1, 3, 4])
    for turns, first, guess in ((1.0, 0.0, 1.0 - 0.5 * swing), (0.5, 0.5 * pi, 0.5)):
        attitude = [np.cos(0.5 * first), 0.0, 0.0, np.sin(0.5 * first)]
        rate = about_normal(guess)
        for _ in range(10):  # by Newton
            run = simulate(scene, rate, attitude, t=[0.5], tangent=True, check=False)
            assert run.attitude is not None
            assert run.tangent is not None
            off = wrapped(angles(run.attitude[-1]) - first - pi * turns)
            rate = rate - np.array([0.0, 0.0, off / run.tangent[-1, 5, 2]])
        run = simulate(scene, rate, attitude, t=[1.0], tangent=True, check=False)
        assert run.tangent is not None
        growing += bool(np.abs(np.linalg.eigvals(run.tangent[-1][out])).max() > 1.01)
    return float(growing)


@cache
def period_of_mercury() -> float:
    """Period (years) of the free libration in longitude of a rigid Mercury."""
    scene = in_orbits((1.0 - MERCURY, 1.0, 1.0 + 0.5 * MERCURY), E_MERCURY)
    orbits = np.arange(1.0, 1025.0)  # sixteen periods
    found = frequencies(orbits, swing(scene, 1.5 + 1e-5, orbits, 1.5, "taylor20"))
    return float(YEAR_OF_MERCURY * 2.0 * pi / found.frequency[0])


@cache
def forced_libration_of_mercury() -> float:
    """Amplitude (arcseconds) of the libration of the mantle of Mercury in 88 days."""
    strength = 4.0 * 8.088e-6 / (0.346 * 0.431)  # (B - A) / C of the mantle
    scene = in_orbits((1.0 - strength, 1.0, 1.0 + 0.5 * strength), E_MERCURY)
    return 3600.0 * degrees(swing_with_orbit(scene, 1.5, orbits=200, count=3))


def formula_of_mercury() -> float:
    """Period (years) of the free libration by the series of the torque averaged over the orbit."""
    return YEAR_OF_MERCURY / width(E_MERCURY, 3.0 * MERCURY)


def width(eccentricity: float, strength: float) -> float:
    """Half of the width of 3:2 (turns an orbit) by the series of the averaged torque."""
    return sqrt(strength * (3.5 * eccentricity - 123.0 / 16.0 * eccentricity**3))


def measured_width() -> float:
    """Width of 3:2 over its width by the series, from spins that keep 3/2 on average."""
    strength = 3e-4
    half = width(E_WIDTH, strength)
    places = np.linspace(0.9, 1.1, 21)
    share = np.concatenate([-places[::-1], places])
    scene = in_orbits((1.0 - strength / 3.0, 1.0, 1.0 + strength / 6.0), E_WIDTH)
    time = 20.0 / half  # orbits: twenty periods of the libration
    result = stability_map(
        scene,
        axes={"spin": 2.0 * pi * (1.5 + half * share)},
        start=Start(spin=0.0),
        stable=librates(),
        measure=spin_orbit_ratio(3),
        samples=1,
        t_end=time,
        check=0.0,
        rng=1,
        progress=False,
    )
    # A libration ends within half a turn of where the mean spin would bring it.
    inside = np.abs(result.measures["spin_orbit_ratio(3)"].mean - 1.5) < 0.5 / time
    spacing = places[1] - places[0]
    return float((share[inside].max() - share[inside].min() + spacing) / 2.0)


def forced_libration(moments: ArrayLike, eccentricity: float) -> float:
    """Amplitude (rad) of the swing with the orbit of a synchronous moon."""
    return swing_with_orbit(in_orbits(moments, eccentricity), 1.0, orbits=40, count=4)


def libration_over_eccentricity() -> float:
    """Amplitude over the eccentricity of a moon with a/b = 1.2, from its motion."""
    return forced_libration(ellipsoid(1.2, 1.2), 1e-4) / 1e-4


def libration_of_phobos() -> float:
    """Amplitude (degrees) of the swing of Phobos, 13.0 km x 11.4 km x 9.1 km."""
    return degrees(forced_libration(ellipsoid(13.0 / 11.4, 11.4 / 9.1), 0.0151))


def formula_of_libration() -> float:
    """Amplitude over the eccentricity of a moon with a/b = 1.2, by the linear equation."""
    first, second, _ = ellipsoid(1.2, 1.2)
    return float(2.0 / (1.0 / (3.0 * (second - first)) - 1.0))


def resonant_elongation() -> float:
    """``a/b`` at which the libration has the period of the orbit, from motions on a circle."""
    ab = np.linspace(1.38, 1.44, 7)
    t = np.linspace(0.0, 40.0, 801)
    found = frequencies(t, swing(in_orbits(ellipsoid(ab, 1.2)), 1.001, t, 1.0, None))
    return float(np.interp(2.0 * pi, found.frequency[:, 0], ab))


def missing_elongation() -> float:
    """``a/b`` of moons on a slightly eccentric orbit whose pole leaves the normal."""
    ab = np.linspace(1.03, 1.15, 13)
    result = stability_map(
        in_orbits((1.0, 1.0, 1.0), 0.02),
        axes={"a/b": ab, "b/c": [1.1, 1.15]},
        start=Start(omega=(0.0, 0.0, 2.0 * pi), attitude_noise=normal(0.01)),
        stable=pointing_within(0.5, axis=3, of="normal"),
        samples=8,
        t_end=150.0,
        rng=2026,
        progress=False,
    )
    leaving = 1.0 - result.share.mean(axis=0)
    return float(np.sum(ab * leaving) / leaving.sum())
