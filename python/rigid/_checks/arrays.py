"""Arrays with any leading axes, checked."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .arguments import first_place, numbers, of_shape

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]

AttitudeLike: TypeAlias = "ArrayLike | Rotation"
"""Attitudes of an argument: quaternions, scalar first, or a SciPy ``Rotation``."""

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""The attitude of a body whose axes coincide with the space axes."""
IDENTITY.flags.writeable = False

UNIT = 1e-4
"""Largest error of the length of a unit vector: three components with four decimals, each off by
0.5e-4, give 0.9e-4. Single precision gives 1e-7."""


def of_size_one(
    vectors: Floats, axis: int | tuple[int, ...] = -1
) -> tuple[Floats, NDArray[np.intc]]:
    """Vectors over powers of two, so that their squares stay in the range of doubles; the powers.

    The powers keep the axes. The division changes no digit.
    """
    power = np.frexp(np.abs(vectors).max(axis=axis, keepdims=True, initial=0.0))[1]
    return np.ldexp(vectors, -power), power


def lengths(vectors: Floats) -> Floats:
    """Lengths of the vectors along the last axis, faster than by ``numpy.linalg.norm``."""
    squares: Floats = np.einsum("...i,...i->...", vectors, vectors)
    return np.sqrt(squares)


def vectors(name: str, value: ArrayLike, width: int = 3) -> Floats:
    """``value`` as finite floats of shape (..., width)."""
    plain: Floats | None = _core.plain_numbers(value, width)
    if plain is not None:
        return plain
    array = numbers(name, value)
    return np.empty((0, width)) if array.shape == (0,) else of_shape(name, array, width)


def attitudes(attitude: AttitudeLike | None, name: str = "attitude") -> Floats:
    """Quaternions or a SciPy ``Rotation`` as unit quaternions, scalar first, shape (..., 4).

    By default the axes of body and space coincide.
    """
    if attitude is None:
        return IDENTITY
    if hasattr(attitude, "as_quat"):
        attitude = attitude.as_quat(scalar_first=True)
    try:
        return unit_quaternions(name, vectors(name, attitude, 4))
    except ValueError as error:
        if numbers(name, attitude).shape[-1:] != (3,):
            raise
        raise ValueError(
            f"{error}; rigid.rotations.euler_to_quaternion takes angles, matrix_to_quaternion a "
            "matrix"
        ) from None


def unit_quaternions(
    name: str, quaternions: Floats, rule: str = "a zero quaternion is no attitude"
) -> Floats:
    """Finite quaternions of shape (..., 4) divided by their lengths; the sign is kept.

    The core divides, for the whole package: all functions start from the same bits.

    Raises
    ------
    ValueError
        If a quaternion is zero.
    """
    rows = np.ascontiguousarray(quaternions).reshape(-1, 4)
    unit = _core.unit_quaternions(rows)
    if unit is None:
        _, place = first_place((quaternions == 0.0).all(axis=-1))
        raise ValueError(f"{name}{place} = {[0.0] * 4}: {rule}")
    return unit.reshape(quaternions.shape)


def unit_vectors(name: str, value: ArrayLike) -> Floats:
    """``value`` as vectors of length one, shape (..., 3): their lengths are near one, and made one.

    A vector whose length is 1 to rounding stays as it is: a saved vector is read back bit for bit.
    """
    array = vectors(name, value)
    flat = array.reshape(-1, 3)
    norms = np.array(list(map(math.hypot, *flat.T.tolist())) if len(flat) else [])
    off = np.abs(norms - 1.0)
    if np.any(off > UNIT):
        index, place = first_place((off > UNIT).reshape(array.shape[:-1]))
        norm = norms.reshape(array.shape[:-1])[index]
        raise ValueError(
            f"{name}{place} = {array[index].tolist()}: must be a unit vector to {UNIT:g}, its "
            f"length is {norm:.9g}"
        )
    scaled = np.where((off > sys.float_info.epsilon)[:, np.newaxis], flat / norms[:, None], flat)
    return scaled.reshape(array.shape)
