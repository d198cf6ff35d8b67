"""Rows: the numbers of units of work. They follow from the columns of a map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.data import COLUMNS
from .head import Head, StoreError

__all__ = ["FIELDS", "ROW", "Rows", "Table", "rows_of"]

FIELDS = tuple(column.name for column in COLUMNS if column.reproducible)
"""The columns of a row."""

ROW = np.dtype(
    [
        ("unit", "<i8"),
        *(
            (column.name, np.dtype(column.dtype).newbyteorder("<").str)
            for column in COLUMNS
            if column.reproducible
        ),
    ]
)
"""The type of a row: number of the unit, then the columns."""

Rows = NDArray[np.void]

_WHOLE = np.dtype((np.void, ROW.itemsize))
"""A row as bytes: NumPy copies records field by field, which takes ten times as long."""


def rows_of(units: NDArray[np.int64], columns: dict[str, NDArray[Any]]) -> Rows:
    """Rows of units from arrays of the columns. All NaN have the same bits."""
    rows = np.empty(len(units), ROW)
    rows["unit"] = units
    for name in FIELDS:
        values = columns[name]
        rows[name] = (
            np.where(np.isnan(values), np.nan, values) if values.dtype.kind == "f" else values
        )
    return rows


class Table:
    """The rows that are known, by unit.

    Attributes
    ----------
    rows : ndarray of ROW, shape (units,)
    known : ndarray of bool, shape (units,)
    nanoseconds : ndarray of float32, shape (units,)
        Processor time, NaN where it is not known.
    twice : int
        Rows that came a second time, with the same bytes.
    """

    def __init__(self, head: Head) -> None:
        self._head = head
        self.rows: Rows = np.zeros(head.units, ROW)
        self.known = np.zeros(head.units, np.bool_)
        self.nanoseconds = np.full(head.units, np.nan, np.float32)
        self.twice = 0

    def add(self, rows: Rows, nanoseconds: NDArray[np.float32] | None, source: object) -> None:
        """Add rows; those that are known already must be equal.

        Raises
        ------
        StoreError
            Naming the source, the unit and the fields, if they are not; or for a unit that the map
            does not have.
        """
        units = rows["unit"]
        if units.size == 0:
            return
        if units.min() < 0 or units.max() >= len(self.rows):
            raise StoreError(f"{source}: a row of a unit that the map does not have")
        again = self.known[units]
        if again.any():
            old, new = self.rows[units[again]], rows[again]
            if old.tobytes() != new.tobytes():
                raise StoreError(f"{source}: {unequal(old, new)}")
            self.twice += int(again.sum())
        self.rows.view(_WHOLE)[units] = rows.view(_WHOLE)
        self.known[units] = True
        if nanoseconds is not None:
            self.nanoseconds[units] = nanoseconds

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The columns of the map, merged over the segments of each pixel."""
        segments = self._head.segments
        if segments == 1:
            return self._segment(slice(None))
        statistics = _core.MapStatistics(len(self.rows) // segments)
        for segment in range(segments):
            statistics.merge({**self._segment(slice(segment, None, segments)), "first": 0})
        return statistics.arrays()

    def _segment(self, units: slice) -> dict[str, NDArray[Any]]:
        """The columns of units, one a pixel; those of no bodies where a unit is not known."""
        known = self.known[units]
        # Those of one pixel repeated: a million pixels are not held twice.
        none = _core.MapStatistics(1).arrays()
        columns = {name: np.full(len(known), value[0], value.dtype) for name, value in none.items()}
        for name in FIELDS:
            np.copyto(columns[name], self.rows[name][units], where=known)
        np.copyto(columns["nanoseconds"], self.nanoseconds[units], where=known)
        return columns


def unequal(old: Rows, new: Rows) -> str:
    """Which of rows that should be equal differ first, in what, and how."""
    differ = [one.tobytes() != other.tobytes() for one, other in zip(old, new, strict=True)]
    first = differ.index(True)
    fields = ", ".join(
        f"{name} {old[name][first]} and {new[name][first]}"
        for name in FIELDS
        if old[name][first].tobytes() != new[name][first].tobytes()
    )
    return f"unit {new['unit'][first]} has two results: {fields} ({sum(differ)} units differ)"
