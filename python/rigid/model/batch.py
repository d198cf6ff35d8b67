"""Values of one body, or of a batch of bodies in one object: with leading axes.

The value of one body is a number or a tuple. The values of many bodies are a read-only array with
the axes of the bodies first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arrays import Floats

Shape: TypeAlias = tuple[int, ...]
Index: TypeAlias = Any
"""Whatever NumPy takes as an index of the leading axes."""

Vector: TypeAlias = tuple[float, float, float]


def three(values: ArrayLike) -> Vector:
    """Three numbers as a tuple."""
    first, second, third = np.asarray(values, dtype=np.float64).tolist()
    return first, second, third


def vector_of(array: Floats) -> Vector | Floats:
    """The vector of one body as a tuple, the vectors of many bodies as a read-only array."""
    return three(array) if array.ndim == 1 else frozen(array)


def frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """A read-only copy of the array."""
    copy = np.array(array)
    copy.flags.writeable = False
    return copy


def holds(shape: Shape) -> int:
    """The length of the first axis of the bodies; TypeError if there is one body."""
    if not shape:
        raise TypeError("one body has no length; bodies of moments (n, 3) have")
    return shape[0]


def axes_of(value: Any, width: int) -> Shape:
    """The axes of the bodies of a part; of an array all axes before the last ``width`` ones.

    The part of one body is a number or a tuple.
    """
    return value.shape[: value.ndim - width] if isinstance(value, np.ndarray) else ()


def batch_shape(shapes: Mapping[str, Shape]) -> Shape:
    """The axes of the bodies whose parts have these leading axes.

    Raises
    ------
    ValueError
        If they do not broadcast.
    """
    if not any(shapes.values()):
        return ()
    known = {name: shape for name, shape in shapes.items() if shape}
    try:
        return np.broadcast_shapes(*known.values())
    except ValueError:
        words = ", ".join(f"{name} {shape}" for name, shape in known.items())
        raise ValueError(f"{words}: the axes of the bodies do not broadcast") from None


def index_of_bodies(shape: Shape, index: Index) -> Shape:
    """The axes that an index leaves of the axes of bodies.

    Raises
    ------
    TypeError, IndexError
        If there is one body, or none at the index.
    """
    holds(shape)
    return np.shape(np.broadcast_to(np.False_, shape)[index])


def taken(value: Any, width: int, shape: Shape, index: Index) -> Any:
    """The value of some bodies, which has ``width`` axes after the axes of the bodies.

    ``shape`` has the axes of all bodies; a value of one body holds for all bodies.
    """
    array = np.asarray(value)
    tail = array.shape[array.ndim - width :]
    if array.ndim == width:
        return value
    every = np.broadcast_to(array, (*shape, *tail))
    where = index if isinstance(index, tuple) else (index,)
    # Whole axes at the end, which an Ellipsis in the index must not take for axes of bodies.
    return every[(*where, *(slice(None),) * width)]


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


class ByValue:
    """A dataclass whose objects are equal if all values are, arrays of many bodies included."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(map(_same, _compared(self), _compared(other)))

    def __hash__(self) -> int:
        values = [one.shape if isinstance(one, np.ndarray) else one for one in _compared(self)]
        return hash((type(self), *values))


def _compared(value: Any) -> list[Any]:
    return [getattr(value, own.name) for own in fields(value) if own.compare]


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        return np.array_equal(first, second)
    return bool(first == second)
