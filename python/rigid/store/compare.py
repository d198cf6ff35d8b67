"""Maps compared: with each other, and with the same numbers computed again."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .._checks.arguments import finite_float
from .._checks.progress import ProgressOption, reporting
from ..maps.data import COLUMNS, MapData
from ..maps.job import of_pixels
from .head import Head, spec_differences
from .result import StabilityMap, load_map
from .resume import result_of
from .rows import FIELDS, Block, bins_of, compute, differences, rows_of
from .running import Folder

TOGETHER = 1024
"""Number of units that are computed at once."""


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


def diff(
    one: StabilityMap | str | os.PathLike[str], other: StabilityMap | str | os.PathLike[str]
) -> Difference:
    """Compare two maps: their specifications and their numbers.

    Maps of one specification are compared bit by bit, in the pixels that both have; of pixels
    that lack bodies in one map, the number is told. Maps with the same axes are compared by the
    intervals of their shares.

    Parameters
    ----------
    one, other : StabilityMap or path-like
        Results, saved files, or folders of running maps.

    Returns
    -------
    Difference
        ``same``, ``specification``, ``numbers``; ``str()`` describes them.

    Raises
    ------
    ValueError
        If a path holds neither a map nor a running map, or the content is damaged.
    OSError
        If a file cannot be read.

    Examples
    --------
    >>> import rigid
    >>> ask = dict(axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0, stable=rigid.no_flip())
    >>> one, other = (rigid.stability_map(rigid.FreeBody, rng=rng, **ask) for rng in (1, 2))
    >>> rigid.diff(one, one).same
    True
    >>> rigid.diff(one, other).specification
    ['seed: 1 and 2']
    """
    here, there = _map_of(one), _map_of(other)
    specification = spec_differences(here.spec, there.spec)
    if Head.of(here.spec).key == Head.of(there.spec).key:
        numbers = _bytes(here, there)
        return Difference(same=not numbers, specification=specification, numbers=numbers)
    if here.spec.axes != there.spec.axes:
        numbers = ["the axes differ: the pixels cannot be compared"]
    else:
        numbers = _intervals(here, there)
    return Difference(same=False, specification=specification, numbers=numbers)


def _map_of(data: StabilityMap | str | os.PathLike[str]) -> StabilityMap:
    if isinstance(data, StabilityMap):
        return data
    return result_of(Folder(data), StabilityMap) if Path(data).is_dir() else load_map(data)


def _bytes(one: MapData, other: MapData) -> list[str]:
    """The differences of two maps of one specification: equal seeds give equal bits."""
    lines = []
    both = (one.samples > 0) & (other.samples > 0)
    for less, more, which in ((other, one, "first"), (one, other, "second")):
        fewer = (less.samples < more.samples) & ~less.finished
        for pixels, words in (
            (fewer & ~both, f"are in the {which} only"),
            (fewer & both, f"have more bodies in the {which}"),
        ):
            if pixels.any():
                lines.append(f"{int(pixels.sum()):,} pixels {words}")
        both &= ~fewer
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """The result of a verification; ``str()`` describes it.

    Attributes
    ----------
    units, checked : int
        Units that are stored, and those that were computed again.
    wrong : list of str
        The units that came out otherwise: pixel, fields, stored and computed numbers.
    damage : list of str
        What could not be read in the logs, and where.
    """

    units: int
    checked: int
    wrong: list[str] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether all numbers agree with the stored ones, and all rows could be read."""
        return not (self.wrong or self.damage)

    def __str__(self) -> str:
        lines = [
            f"{self.checked:,} of {self.units:,} units were computed again: "
            f"{len(self.wrong):,} differ",
            *self.wrong[:20],
            *([f"and {len(self.wrong) - 20:,} more"] if self.wrong[20:] else []),
            *(f"damage: {text}" for text in self.damage),
        ]
        return "\n".join(lines)


def verify(
    stored: str | os.PathLike[str] | Folder,
    *,
    share: float = 0.01,
    seed: int = 0,
    threads: int = 1,
    progress: ProgressOption = None,
) -> Verification:
    """Compute a random share of the units of a running map, or of a saved map, again."""
    share = finite_float("share", share, positive=True)
    if share > 1.0:
        raise ValueError(f"share = {share}: must be at most 1")
    block, head, damage = _rows(stored)
    units = len(block.rows)
    count = min(units, int(np.ceil(share * units * (1.0 - 1e-12))))
    chosen = np.zeros(units, np.bool_)
    chosen[np.random.default_rng(seed).choice(units, count, replace=False)] = True
    places = np.flatnonzero(chosen)
    wrong: list[str] = []
    with reporting(progress, count, unit=" units") as report:
        for begin in range(0, count, TOGETHER):
            mine = np.zeros(units, np.bool_)
            mine[places[begin : begin + TOGETHER]] = True
            old = block.some(mine)
            again = compute(head, old.rows["unit"].copy(), threads)
            assert again is not None
            wrong += [
                f"pixel {int(unit) // head.segments}: {text}"
                for unit, text in zip(
                    old.rows["unit"],
                    differences(old, again, head.spec.measure, "{} is {}, computed {}"),
                    strict=True,
                )
                if text
            ]
            report(min(begin + TOGETHER, count), len(wrong))
    return Verification(units=units, checked=count, wrong=wrong, damage=damage)


def _rows(stored: str | os.PathLike[str] | Folder) -> tuple[Block, Head, list[str]]:
    """The rows of complete units, their head, and the damaged rows."""
    if isinstance(stored, Folder) or Path(stored).is_dir():
        folder = stored if isinstance(stored, Folder) else Folder(stored)
        folder.read()
        block = folder.table.block(np.flatnonzero(folder.table.known))
        return block, folder.head, folder.damage
    result = load_map(stored)
    pixels = np.flatnonzero((result.finished & (result.status == 0)).ravel())
    columns = {name: result.columns[name].ravel()[pixels] for name in FIELDS}
    place = np.full(result.status.size, -1)
    place[pixels] = np.arange(len(pixels))
    finished = [
        measured.bins[place[measured.bins[:, 0]] >= 0] for measured in result.measures.values()
    ]
    bins = bins_of(pixels, [of_pixels(one, place) for one in finished])
    costs = np.full(len(pixels), np.nan, np.float32)
    head = Head(result.spec, result.spec.samples)
    return Block(rows_of(pixels, columns), costs, bins), head, []
