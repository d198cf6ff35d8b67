"""Satellites without control: the precession of Envisat by the gravity gradient."""

from __future__ import annotations

from math import cos, exp, pi, radians, sin, sqrt

import numpy as np

from ..model.body import Body
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..solve.simulate import simulate


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
