"""The columns of a run: a row for each body, converted to the axes of the bodies when read."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any, Generic, Self, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from ..model.leading import Shape

__all__ = ["Column", "Columns", "columns_of_arrays"]

Columns: TypeAlias = Mapping[str, Any]
"""Arrays of shape (n, ...) by their names in the core, None if not recorded; and the time taken
(ns)."""

Array = TypeVar("Array")


class HasColumns:
    """Bodies of a shape, and their columns."""

    __slots__ = ()

    _columns: Columns
    _shape: Shape


class Column(Generic[Array]):
    """An attribute of a run: the row of the only body, or the rows of all bodies in their axes.

    Few of the columns of a run are read, and a view takes as long as it takes to check the input.
    """

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...
    @overload
    def __get__(self, owner: HasColumns, kind: type) -> Array: ...
    def __get__(self, owner: HasColumns | None, kind: type) -> Self | Array:
        if owner is None:
            return self
        rows: Any = owner._columns.get(self.name)
        if rows is not None:
            shape = owner._shape
            rows = rows.reshape(*shape, *rows.shape[1:]) if shape else rows[0]
        view: Array = rows
        return view


def columns_of_arrays(arrays: Mapping[str, Any], shape: Shape) -> dict[str, NDArray[Any] | None]:
    """Columns from arrays that have the axes of the bodies.

    Raises
    ------
    ValueError
        If an array has other axes.
    """
    columns: dict[str, NDArray[Any] | None] = {}
    for name, array in arrays.items():
        if array is None:
            columns[name] = None
            continue
        own = np.shape(array)
        if own[: len(shape)] != shape:
            wanted = ", ".join(map(str, (*shape, "...")))
            raise ValueError(f"{name}: expected shape ({wanted}), got {own}")
        columns[name] = np.reshape(array, (prod(shape), *own[len(shape) :]))
    return columns
