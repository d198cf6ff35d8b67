"""Matrices that are rotations, to rounding or to a few decimals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .arguments import first_place, shaped
from .arrays import Floats

ROTATION_SLACK = 3.1e-4
"""Largest orthogonality error of a matrix that is accepted as a rotation: four decimals, off by
0.5e-4 in each of nine entries, give at most 3e-4."""

_ROUNDED = 1e-14
"""Orthogonality error of products of rotations; such a matrix stays as it is."""


def rotation_matrices(name: str, value: ArrayLike) -> Floats:
    """``value`` as the nearest rotations ``(..., 3, 3)`` to matrices that are rotations to 3.1e-4.

    Each step ``R (3 - R.T R) / 2`` towards the orthogonal factor squares the error: three steps
    leave rounding (N. J. Higham, *SIAM J. Sci. Stat. Comput.* 7 (1986) 1160).
    """
    r = shaped(name, value, 3, 3)
    error, determinant = orthogonality(r)
    bad = (error > ROTATION_SLACK) | (determinant < 0.0)
    if np.any(bad):
        index, place = first_place(bad)
        raise ValueError(
            f"{name}{place}: not a rotation: |R.T R - 1| = {error[index]:.3g}, must be at most "
            f"{ROTATION_SLACK:g}, det R = {determinant[index]:.3g} (nearest_rotation corrects "
            "other errors)"
        )
    if not np.any(error > _ROUNDED):
        return r
    near = r
    for _ in range(3):
        near = 1.5 * near - 0.5 * _product(near, _product(np.swapaxes(near, -1, -2), near))
    return np.where((error > _ROUNDED)[..., np.newaxis, np.newaxis], near, r)


def orthogonality(r: Floats) -> tuple[Floats, Floats]:
    """Frobenius norm of ``R.T R - 1`` and determinant of matrices, shape (..., 3, 3)."""
    gram = _product(np.swapaxes(r, -1, -2), r) - np.eye(3)
    return np.linalg.norm(gram, axis=(-2, -1)), np.asarray(np.linalg.det(r))


def _product(a: Floats, b: Floats) -> Floats:
    """``a @ b`` of 3×3 matrices; a BLAS has other bits on other machines."""
    parts = (a[..., :, k, np.newaxis] * b[..., np.newaxis, k, :] for k in range(3))
    first, second, third = parts
    return first + second + third
