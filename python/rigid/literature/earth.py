"""The Earth: free precession, and the part of the Sun in the precession of the equinoxes."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from .. import earth
from ..model.body import Body
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..solve.simulate import simulate

FLATTENING = 0.0032737949
"""``(C - A) / C`` of the Earth."""

OBLIQUITY = 0.40909280
"""Angle of the ecliptic (rad)."""

ECCENTRICITY = 0.016708634
"""Of the orbit of the Earth."""

YEAR = 365.25636 * earth.SOLAR_DAY
"""The sidereal year (s)."""


def euler_days(ellipticity: float) -> float:
    """Euler's period in sidereal days."""
    return float(earth.euler_period(ellipticity, earth.rotation_rate()) / earth.SIDEREAL_DAY)


def rigid_days() -> float:
    """Euler's period of a rigid Earth in sidereal days."""
    return euler_days(FLATTENING / (1.0 - FLATTENING))


def rigid_days_by_formula() -> float:
    """The same by the formula ``A / (C - A)``."""
    return 1.0 / FLATTENING - 1.0


def precession_by_the_sun() -> float:
    """Precession of the axis by the torque of the Sun (arc seconds a year), from the motion.

    After a whole year nothing is left of the nutation.
    """
    moments = np.array([1.0 - FLATTENING, 1.0 - FLATTENING, 1.0])
    scene = FreeBody(Body(moments), orbit=Orbit(2.0 * pi / YEAR, ECCENTRICITY))
    tilted = [cos(0.5 * OBLIQUITY), sin(0.5 * OBLIQUITY), 0.0, 0.0]
    spin = [0.0, 0.0, float(earth.rotation_rate())]
    run = simulate(scene, spin, tilted, t=[0.0, YEAR], accuracy=1e-10)
    first, last = run.momentum("space")
    turned = np.arctan2(first[0] * last[1] - first[1] * last[0], first[:2] @ last[:2])
    return -float(np.degrees(turned)) * 3600.0
