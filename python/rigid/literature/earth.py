"""The Earth: free precession, and the part of the Sun in the precession of the equinoxes."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from .. import earth
from ..model.body import Body
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..solve.simulate import simulate
from .entry import Entry

SMITH = (
    "M. L. Smith, A normal mode study of wobble and nutation, in: Nutation and the Earth's "
    "Rotation, IAU Symposium 78 (1980) 195-202"
)

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


ENTRIES = (
    Entry(
        name="earth-euler",
        quantity="the Earth as a rigid body: Euler's period for (I3 - I1)/I1 = 0.00327",
        printed="305.81",
        unit="sid. days",
        source="H. Goldstein, C. Poole, J. Safko, Classical Mechanics, 3rd edition (2002), section "
        "5.6",
        seen="from memory of the textbook",
        compute=lambda: euler_days(0.00327),
    ),
    Entry(
        name="earth-rigid",
        quantity="the Earth as a rigid body: Euler's period for (C - A)/C = 0.0032737949",
        printed="about 305",
        value=305.0,
        within=1.0,
        interval="the source says 'about'",
        unit="sid. days",
        source=SMITH,
        seen="the abstract",
        compute=lambda: euler_days(FLATTENING / (1.0 - FLATTENING)),
    ),
    Entry(
        name="earth-chandler",
        quantity="the Earth: observed period of the free polar motion, beside the period of a "
        "rigid body",
        printed="435.2",
        unit="sid. days",
        source=SMITH,
        seen="the abstract",
        compute=lambda: euler_days(FLATTENING / (1.0 - FLATTENING)),
        reason="the Earth is not rigid: mantle and oceans yield, and the core does not follow",
        model=1.0 / FLATTENING - 1.0,
    ),
    Entry(
        name="earth-solar-precession",
        quantity="the Earth: precession of the axis by the torque of the Sun alone, from its "
        "motion in a year",
        printed="15.948870",
        within=2e-4,
        interval="the ellipticity (C - A)/C of two models of the Earth differs by 1e-5",
        unit="arcsec/a",
        source="J. G. Williams, Contributions to the Earth's obliquity rate, precession, and "
        "nutation, Astron. J. 108 (1994) 711-724, doi 10.1086/117108",
        seen="from memory of the article 'Axial precession' of Wikipedia, which quotes it",
        compute=precession_by_the_sun,
    ),
)
