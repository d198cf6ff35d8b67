"""Satellites without control: the precession of Envisat by the gravity gradient."""

from __future__ import annotations

from math import cos, exp, pi, radians, sin, sqrt

import numpy as np

from ..model.body import Body
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..solve.simulate import simulate
from .entry import Entry

LIN = (
    "H.-Y. Lin, C.-Y. Zhao, An estimation of Envisat's rotational state accounting for the "
    "precession of its rotational axis caused by gravity-gradient torque, Adv. Space Res. 61 "
    "(2018) 182-188"
)
ABSTRACT = (
    "the abstract; spin 120.674 exp(4.5095e-4 t) s with t in days from 2013, angle 8.53 degrees "
    "from the negative normal of the orbit, ratio 0.0818 of the least and largest moments: the "
    "same; two moments are equal in the model of the source"
)


def precession(days: float) -> float:
    """Period (days) of the precession of Envisat so many days after the begin of 2013."""
    rate = sqrt(398600.44 / (6378.137 + 765.0) ** 3)
    spin, tilt = 2.0 * pi / (120.674 * exp(4.5095e-4 * days)), radians(8.53)
    scene = FreeBody(Body((0.0818, 1.0, 1.0)), orbit=Orbit(rate))
    t = np.linspace(0.0, 20.0 * 2.0 * pi / rate, 41)  # twenty orbits
    # Axis 3 leans from the negative normal towards the first axis of space.
    half = 0.5 * (pi - tilt)
    run = simulate(scene, [0.0, 0.0, spin], [cos(half), 0.0, sin(half), 0.0], t=t, check=False)
    momentum = run.momentum("space")
    longitude = np.unwrap(np.arctan2(momentum[:, 1], momentum[:, 0]))
    return float(2.0 * pi / abs(np.polyfit(t, longitude, 1)[0]) / 86400.0)


ENTRIES = (
    Entry(
        name="envisat-2013",
        quantity="Envisat: period of the precession of its spin by the gravity gradient, in the "
        "middle of 2013",
        printed="4.8",
        within=0.4,
        interval="half a year, in which the spin slows by 8 %",
        unit="d",
        source=LIN,
        seen=ABSTRACT,
        compute=lambda: precession(182.0),
    ),
    Entry(
        name="envisat-2015",
        quantity="Envisat: period of the precession of its spin by the gravity gradient, in the "
        "middle of 2015",
        printed="3.4",
        within=0.28,
        interval="half a year, in which the spin slows by 8 %",
        unit="d",
        source=LIN,
        seen=ABSTRACT,
        compute=lambda: precession(912.0),
    ),
)
