"""Tidy tables: a row for each observation, a column for each number, as comma-separated text."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import TABLE, published

__all__ = ["COMPONENTS", "body_columns", "parts", "write_table"]

COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "omega": ("omega1", "omega2", "omega3"),
    "gamma": ("gamma1", "gamma2", "gamma3"),
    "attitude": ("w", "x", "y", "z"),
}
"""Names of the columns of vectors and quaternions."""

ROWS = 65536
"""Number of rows that are written at once."""


def parts(name: str, array: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The components of vectors, along the last axis, as columns by their names."""
    return {part: array[..., k] for k, part in enumerate(COMPONENTS[name])}


def body_columns(shape: tuple[int, ...], extra: int) -> dict[str, NDArray[Any]]:
    """The indices of bodies of some leading axes, beside ``extra`` axes of observations."""
    grids = np.indices(shape, sparse=True)
    return {
        f"body{k or ''}": grid.reshape(grid.shape + (1,) * extra) for k, grid in enumerate(grids)
    }


def write_table(path: str | os.PathLike[str], columns: Mapping[str, NDArray[Any]]) -> Path:
    """Write arrays that broadcast as columns of a text; the file appears whole or not at all.

    A number has the digits that give its bits back; the lines end as RFC 4180 has it.
    """
    arrays = np.broadcast_arrays(*columns.values())
    flat = [array.reshape(-1) for array in arrays]

    def lines(rows: Iterable[Iterable[Any]]) -> bytes:
        text = StringIO(newline="")
        csv.writer(text).writerows(rows)
        return text.getvalue().encode()

    with published(path, TABLE) as file:
        file.write(lines([columns]))
        for start in range(0, flat[0].size, ROWS):
            part = [column[start : start + ROWS].tolist() for column in flat]
            file.write(lines(zip(*part, strict=True)))
    return Path(path)
