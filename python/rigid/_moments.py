"""Principal moments of boxes, and the rule which moments a body can have."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

__all__ = ["box_moments", "possible"]


def box_moments(a: ArrayLike, b: ArrayLike, c: ArrayLike, mass: ArrayLike) -> NDArray[np.float64]:
    """Moments of homogeneous boxes, ``(..., 3)``; the arguments broadcast."""
    a, b, c, mass = np.broadcast_arrays(a, b, c, mass)
    with np.errstate(over="ignore"):  # the check of moments reports an overflow
        squares = np.stack([b * b + c * c, a * a + c * c, a * a + b * b], axis=-1)
        moments: NDArray[np.float64] = np.asarray(mass)[..., None] / 12.0 * squares
    return moments


def possible(moments: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether a rigid body can have these moments, shape (..., 3), by the rules of the core."""
    rows = np.ascontiguousarray(moments, dtype=np.float64).reshape(-1, 3)
    bodies: NDArray[np.bool_] = _core.moment_status(rows) == 0
    return bodies.reshape(moments.shape[:-1])
