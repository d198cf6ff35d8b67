"""Rotations whose rates are known."""

import numpy as np

from physics import Floats


def prescribed(t: Floats) -> Floats:
    return np.stack([np.cos(3.0 * t), np.sin(2.0 * t) + 0.3, 0.0 * t + 2.0], axis=-1)
