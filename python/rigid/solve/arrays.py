"""Rows of bodies, ranges of times, lengths of vectors and roots of numbers."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats


def lengths(vectors: Floats) -> Floats:
    """Lengths of the vectors along the last axis, faster than by ``numpy.linalg.norm``."""
    squares: Floats = np.einsum("...i,...i->...", vectors, vectors)
    return np.sqrt(squares)


def roots(numbers: Floats, order: int) -> Floats:
    """The roots of an order, with the same bits on every processor and beside other numbers.

    Square roots are rounded alike everywhere. Powers of an array are not, so powers of single
    floats make the roots of other orders.
    """
    if order & (order - 1):
        return np.array([number ** (1.0 / order) for number in numbers.tolist()])
    for _ in range(order.bit_length() - 1):
        numbers = np.sqrt(numbers)
    return numbers


Range: TypeAlias = tuple[float, float] | tuple[Floats, Floats]
"""First and last of some times and 0 (s), or of the times of each body with shape (n,)."""


def time_ranges(times: Floats) -> Range:
    """First and last of ascending times and 0 (s), or of the times (n, m) of each body."""
    if times.ndim == 1:
        return (min(float(times[0]), 0.0), max(float(times[-1]), 0.0)) if len(times) else (0.0, 0.0)
    if not times.shape[1]:
        return np.zeros(len(times)), np.zeros(len(times))
    return np.minimum(times[:, 0], 0.0), np.maximum(times[:, -1], 0.0)


def in_rows(array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The rows (n, N) of bodies of this shape; one row if it holds for all bodies."""
    if array.ndim == 1:
        return array[np.newaxis]
    return rows_of_each(array, shape)


def rows_of_each(array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The rows (n, N) of bodies of this shape, one row for each body."""
    if array.ndim == 1 and not shape:
        return array[np.newaxis]
    width = array.shape[-1]
    if array.shape[:-1] != shape:
        array = np.broadcast_to(array, (*shape, width))
    return np.ascontiguousarray(array).reshape(math.prod(shape), width)
