"""Moons and satellites under a gravity gradient on a circular orbit."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from .._checks.arrays import Floats
from ..free import libration
from ..model.body import Body
from ..model.bounds import tilt_below
from ..model.noise import normal
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..model.start import Start
from ..solve.frequencies import frequencies
from ..solve.simulate import simulate
from ..store.call import stability_map

AT_REST = (0.5, 0.5, -0.5, -0.5)
"""Roll along the motion, pitch along the normal, yaw to the centre, in ``on_orbit``."""

NEEDLE = (1.0, 1.0 + 0.5e-4, 1e-4)
"""Moments of a dumbbell: roll, pitch, and yaw along its length."""

K3 = -0.5
"""``(I2 - I1) / I3`` of the bodies near the border of DeBra and Delp."""

STEP_OF_K1 = 0.001
"""Distance of these bodies in ``k1 = (I2 - I3) / I1``."""

HALF_STEP = 0.5 * STEP_OF_K1
"""How well these bodies tell where the border is."""


def on_orbit(moments: tuple[float, float, float] | Floats) -> FreeBody:
    """Satellites on a circular orbit of the rate 1 rad/s."""
    return FreeBody(Body(moments), orbit=Orbit(1.0))


def moon(mode: str) -> float:
    """Period (d) of a free mode of the Moon: longitude, latitude or wobble.

    In the body the mode in latitude is nearly a month; the literature refers it to the node of the
    orbit, whose month is the draconic one.
    """
    beta, gamma = 6.310e-4, 2.277e-4  # (C - A)/B and (B - A)/C
    # With A = 1: B = 1 + gamma C and C = 1 + beta B.
    largest = (1.0 + beta) / (1.0 - beta * gamma)
    middle = 1.0 + gamma * largest
    found = libration((middle, largest, 1.0), 2.0 * pi / 27.321661)
    latitude = 2.0 * pi / 27.212221 - float(found.roll_yaw[0])
    longitude, wobble = float(found.pitch), float(found.roll_yaw[1])
    return 2.0 * pi / {"longitude": longitude, "latitude": latitude, "wobble": wobble}[mode]


def frequency_of_dumbbell(axis: int, lines: int) -> float:
    """Highest frequency of a dumbbell that swings about a body axis, over the rate of the orbit.

    Pitch has one line, roll and yaw together have two.
    """
    rest = np.array([0.0, 1.0, 0.0])
    swing = 1e-5 * np.eye(3)[axis - 1]
    t = np.linspace(0.0, 100.0, 1001)
    run = simulate(on_orbit(NEEDLE), rest + swing, AT_REST, t=t, record="rates")
    found = frequencies(t, run.omega[:, axis - 1] - rest[axis - 1], count=lines)
    return float(found.frequency.max())


def border_by_formula() -> float:
    """``k1`` at the border of DeBra and Delp: the roots of roll and yaw meet.

    ``1 + 3 k1 + k1 k3 = 4 sqrt(k1 k3)``, a quadratic equation for the root of ``-k1``.
    """
    a, b = 3.0 + K3, 2.0 * sqrt(-K3)
    root = (sqrt(b * b + a) - b) / a
    return -root * root


def border_by_motion() -> float:
    """``k1`` of the first of a row of satellites that leaves its rest."""
    k1 = border_by_formula() + STEP_OF_K1 * (15.25 - np.arange(30.0))
    roll = (1.0 - K3) / (1.0 - k1 * K3)
    moments = np.stack([roll, np.ones(30), 1.0 - k1 * roll], axis=-1)
    run = simulate(
        on_orbit(moments),
        [1e-6, 1.0, 1e-6],
        AT_REST,
        t=np.linspace(0.0, 1500.0, 76),
        record="rates",
    )
    leaves = np.abs(run.omega[..., [0, 2]]).max(axis=(1, 2)) > 1e-2
    return float(k1[leaves].max()) + HALF_STEP


def wrong_pixels() -> float:
    """Pixels of a map of satellites whose motions the linear theory predicts wrongly."""
    ratios = np.linspace(0.1, 2.3, 23)
    result = stability_map(
        FreeBody(Body((1.0, 1.0, 1.0)), orbit=Orbit(1.0)),
        axes={"I1/I3": ratios, "I2/I3": ratios},
        start=Start(omega=(0.0, 0.0, 1.0), noise=normal(1e-4)),
        stable=tilt_below(0.5, axis=3, reference="vertical"),
        t_end=100.0,
        samples=4,
        rng=2026,
        progress=False,
    )
    return float(result.disagreement().sum())
