"""Two maps compared: their specifications, and their numbers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..maps.data import COLUMNS, MapData
from ..maps.identity import head_of, key_of, spec_differences
from .result import StabilityMap, load_map
from .resume import result_of
from .running import Folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """The differences of two maps; ``str()`` describes these in words.

    Attributes
    ----------
    same : bool
        Whether all numbers that determine the maps, and all that both have, are equal.
    specification : list of str
        Where the specifications differ.
    numbers : list of str
        How the numbers differ.
    """

    same: bool
    specification: list[str]
    numbers: list[str]

    def __str__(self) -> str:
        lines = [*self.specification, *self.numbers]
        return "\n".join(lines) or "no difference"


def read_any(path: str | os.PathLike[str]) -> StabilityMap:
    """The map in a folder of a running map or in a saved file."""
    return result_of(Folder(path), StabilityMap) if Path(path).is_dir() else load_map(path)


def diff(one: StabilityMap, other: StabilityMap) -> Difference:
    """The differences of two maps."""
    specification = spec_differences(one.spec, other.spec)
    keys = [key_of(head_of(data.spec)) for data in (one, other)]
    if keys[0] == keys[1]:
        numbers = _bytes(one, other)
        return Difference(same=not numbers, specification=specification, numbers=numbers)
    if one.spec.axes != other.spec.axes:
        numbers = ["the axes differ: the pixels cannot be compared"]
    else:
        numbers = _intervals(one, other)
    return Difference(same=False, specification=specification, numbers=numbers)


def _bytes(one: MapData, other: MapData) -> list[str]:
    """The differences of two maps of one specification: equal seeds give equal bits."""
    lines = []
    done = [data.samples > 0 for data in (one, other)]
    for mine, theirs, which in (*zip(done, done[::-1], ("first", "second"), strict=True),):
        alone = int((mine & ~theirs).sum())
        if alone:
            lines.append(f"{alone:,} pixels are in the {which} only")
    both = done[0] & done[1]
    for column in COLUMNS:
        if not column.reproducible:
            continue
        old, new = one.columns[column.name], other.columns[column.name]
        nan = np.isnan(old) & np.isnan(new)
        unequal = both & (old != new) & ~nan
        if unequal.any():
            place = tuple(int(i) for i in np.argwhere(unequal)[0])
            lines.append(
                f"{column.name}: {int(unequal.sum()):,} pixels differ, "
                f"the first at {place}: {old[place]} and {new[place]}"
            )
    for name in one.measures:
        first, second = (
            bins[both.ravel()[bins[:, 0]]]
            for bins in (data.measures[name].bins for data in (one, other))
        )
        if not np.array_equal(first, second):
            lines.append(f"values of {name}: they differ")
    return lines


def _intervals(one: MapData, other: MapData) -> list[str]:
    """The differences of two maps with other samples: their intervals should overlap."""
    known = ~(np.isnan(one.share) | np.isnan(other.share))
    apart = known & ((one.lower > other.upper) | (other.lower > one.upper))
    lines = [
        f"{int(apart.sum()):,} of {int(known.sum()):,} pixels have intervals that do not meet "
        "(of equal shares up to 1 in 400 by chance)"
    ]
    if known.any():
        distance = np.where(known, np.abs(one.share - other.share), -1.0)
        place = tuple(int(i) for i in np.unravel_index(int(np.argmax(distance)), distance.shape))
        lines.append(
            f"largest difference of shares: {distance[place]:.3g} at {place}: "
            f"{one.share[place]:.6g} and {other.share[place]:.6g}"
        )
    return lines
