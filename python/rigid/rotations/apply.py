"""Components of vectors in space from components in the body, and back, by unit quaternions."""

from __future__ import annotations

import numpy as np

from .._checks.arrays import Floats


def to_space(attitude: Floats, vector: Floats) -> Floats:
    """``R v`` of unit quaternions ``(w, u)``: ``v + 2 w u × v + 2 u × (u × v)``."""
    scalar, axis = attitude[..., :1], attitude[..., 1:]
    across = 2.0 * np.cross(axis, vector)
    return vector + scalar * across + np.cross(axis, across)


def to_body(attitude: Floats, vector: Floats) -> Floats:
    """``R.T v`` of unit quaternions: components in the body of vectors in space."""
    return to_space(attitude * np.array([1.0, -1.0, -1.0, -1.0]), vector)
