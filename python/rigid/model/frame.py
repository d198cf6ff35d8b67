"""Axes of a drawing: vectors and attitudes in body axes that are not principal axes.

A frame is a rotation matrix as :meth:`rigid.Body.from_tensor` returns it: column k is the direction
of principal axis k + 1 in the axes of the drawing. Sums are written out: products of matrices by a
BLAS have other bits on other machines.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arrays import Floats
from ..rotations import matrix_to_quaternion, quaternion_to_matrix
from ..rotations.quaternions import product_of_checked


def checked_frame(frame: ArrayLike) -> Floats:
    """``frame`` as a rotation matrix, orthogonal to rounding.

    Raises
    ------
    ValueError
        If it is no rotation matrix of shape (3, 3) to 3.1e-4; within, it is the nearest one.
    """
    shape = np.shape(frame)
    if shape != (3, 3):
        raise ValueError(
            f"frame: expected shape (3, 3), as Body.from_tensor returns it, got {shape}"
        )
    try:
        quaternion = matrix_to_quaternion(frame)
    except ValueError as error:
        raise ValueError(str(error).replace("matrix", "frame", 1)) from None
    return quaternion_to_matrix(quaternion)


def turned(axes: Floats, vectors: Floats) -> Floats:
    """``axes @ v`` of vectors (..., 3), in the precision of the vectors.

    With a frame: components along the axes of the drawing, of principal components; with its
    transpose: the other way.
    """
    x, y, z = np.moveaxis(vectors, -1, 0)
    parts = [row[0] * x + row[1] * y + row[2] * z for row in axes]
    return np.stack(parts, axis=-1).astype(vectors.dtype, copy=False)


def turned_matrix(axes: Floats, matrices: Floats) -> Floats:
    """``axes @ M @ axes.T`` of symmetric matrices (..., 3, 3), exactly symmetric."""
    left = turned(axes, np.swapaxes(matrices, -1, -2))
    both = turned(axes, np.swapaxes(left, -1, -2))
    return 0.5 * (both + np.swapaxes(both, -1, -2))


def attitudes_in_principal_axes(axes: Floats, attitude: Floats) -> Floats:
    """Attitudes of the principal axes, from the attitudes of the axes of the drawing."""
    frame = matrix_to_quaternion(axes)
    return product_of_checked(attitude, frame).astype(attitude.dtype, copy=False)


def attitudes_in_frame(axes: Floats, attitude: Floats) -> Floats:
    """Attitudes of the axes of the drawing, from the attitudes of the principal axes."""
    back = matrix_to_quaternion(axes) * [1.0, -1.0, -1.0, -1.0]
    return product_of_checked(attitude, back).astype(attitude.dtype, copy=False)
