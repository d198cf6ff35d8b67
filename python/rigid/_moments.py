"""Principal moments of boxes, and the rule which moments a body can have."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

__all__ = ["box_moments", "possible", "refuse_tensor"]

SYMMETRIC = 1e-5
"""Products of inertia are equal to this share of the largest number: files have five digits."""


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


def refuse_tensor(name: str, array: NDArray[np.float64]) -> None:
    """Raise ValueError for a tensor of inertia, a matrix, where the rows are bodies.

    A tensor is symmetric and positive definite. Its rows are three bodies only if no body has the
    tensor: then the sum of its products is at least half of its trace, and a body has at most a
    quarter. So the refusal hides no error of other moments.
    """
    if array.shape != (3, 3) or not np.isfinite(array).all():
        return
    largest = np.abs(array).max()
    if largest == 0.0 or np.abs(array - array.T).max() > SYMMETRIC * largest:
        return
    (a, d, e), (_, b, f), (_, _, c) = (array / largest).tolist()
    minor = a * b - d * d
    if a > 0.0 and minor > 0.0 and c * minor > a * f * f - 2.0 * d * e * f + b * e * e:
        raise ValueError(
            f"{name} = {array.tolist()}: a symmetric matrix is a tensor of inertia, and here rows "
            "are bodies; take rigid.Body.from_tensor, or give three bodies in another order"
        )
