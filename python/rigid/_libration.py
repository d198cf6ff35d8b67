"""Small oscillations of a body at rest on a circular orbit: the squares of their frequencies."""

from __future__ import annotations

import numpy as np

from ._checks.arrays import Floats


def squares(roll: Floats, pitch: Floats, yaw: Floats) -> tuple[Floats, Floats, Floats]:
    """The square of pitch, and half the sum and the product of both squares of roll and yaw.

    In units of the squared rate of the orbit, for moments about the axes along the motion, along
    the normal, and along the line to the planet. The squares of roll and yaw are the roots of
    ``x² - (1 + 3 k1 + k1 k3) x + 4 k1 k3`` with ``k1 = (pitch - yaw)/roll`` and
    ``k3 = (pitch - roll)/yaw`` (Hughes, *Spacecraft Attitude Dynamics*, 1986, § 9.2).
    """
    k1, k3 = (pitch - yaw) / roll, (pitch - roll) / yaw
    return 3.0 * (roll - yaw) / pitch, 0.5 * (1.0 + 3.0 * k1 + k1 * k3), 4.0 * k1 * k3


def frequencies(roll: Floats, pitch: Floats, yaw: Floats) -> tuple[Floats, Floats, Floats]:
    """Pitch, and the larger and the smaller frequency of roll and yaw, over the rate of the orbit.

    NaN where rest is unstable in pitch, and in roll and yaw.
    """
    square, half, product = squares(roll, pitch, yaw)
    with np.errstate(invalid="ignore"):
        swing = np.where(square > 0.0, np.sqrt(square), np.nan)
        larger = half + np.sqrt(half * half - product)
        is_real = (product > 0.0) & (half > 0.0) & (half * half > product)
        fast = np.where(is_real, np.sqrt(larger), np.nan)
        slow = np.where(is_real, np.sqrt(product / larger), np.nan)
    return swing, fast, slow
