"""Rows: the numbers of units of work, and their computation, which any process may repeat.

The values of the measures of a map are bins, some for each unit, beside the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.data import COLUMNS
from ..maps.job import of_pixels, spans, to_core
from ..maps.measured import BIN
from ..maps.sequential import Looks
from ..maps.spec import MapPart, MapSpec
from .head import Head, StoreError

_TYPES = {one.name: np.dtype(one.dtype).newbyteorder("<") for one in COLUMNS if one.reproducible}

FIELDS = tuple(_TYPES)
"""The columns of a row."""

ROW = np.dtype([("unit", "<i8"), *((name, kind.str) for name, kind in _TYPES.items())])
"""The type of a row: number of the unit, then the columns."""

_IN_BIN = (
    *("unit", "measure", "key", "count", "least", "largest"),
    *("sum_low", "sum_high", "squares_low", "squares_high", "error"),
)
BIN_ROW = np.dtype([(name, "<i8") for name in _IN_BIN])
"""The type of a bin of a measure: number of the unit, place of the measure in the specification,
numbers of the bin; see :mod:`rigid.maps.measured`."""

Ints = NDArray[np.int64]
Columns = dict[str, Any]
"""Arrays by the name of their column, and the bins of the ``measures``."""

Rows = NDArray[np.void]
Bins = NDArray[np.int64]
"""Bins as numbers, shape (n, 11), in the order of unit, measure and key."""

NO_BINS: Bins = np.empty((0, 1 + BIN), np.int64)

_WHOLE = np.dtype((np.void, ROW.itemsize))
"""A row as bytes: NumPy copies records field by field, which takes ten times as long."""


class Block(NamedTuple):
    """Rows of some units.

    Attributes
    ----------
    rows : ndarray of ROW
    nanoseconds : ndarray of float32
        The processor time of each.
    bins : ndarray of int64, shape (n, 11)
        The values of the measures in the order of the units; none if the map measures nothing.
    """

    rows: Rows
    nanoseconds: NDArray[np.float32]
    bins: Bins = NO_BINS

    def some(self, which: NDArray[np.bool_]) -> Block:
        """The block of some of the rows."""
        mine = np.isin(self.bins[:, 0], self.rows["unit"][which])
        return Block(self.rows[which], self.nanoseconds[which], self.bins[mine])

    def each(self) -> Iterator[Bins]:
        """The bins of each row."""
        units = self.rows["unit"]
        ends = (np.searchsorted(self.bins[:, 0], units, side=side) for side in ("left", "right"))
        for begin, end in zip(*ends, strict=True):
            yield self.bins[begin:end]


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


def bins_of(units: NDArray[np.int64], measures: Sequence[Bins]) -> Bins:
    """Bins of ascending units from the bins of each measure, numbered by the place of the unit."""
    parts = [
        np.insert(of_pixels(bins, units), 1, number, axis=1) for number, bins in enumerate(measures)
    ]
    return parts[0] if len(parts) == 1 else _sorted(np.concatenate([NO_BINS, *parts]))


def _sorted(bins: Bins) -> Bins:
    """In the order of the units."""
    ordered: Bins = bins[np.argsort(bins[:, 0], kind="stable")]
    return ordered


def compute(
    head: Head, units: Ints, threads: int = 1, stop: Callable[[], bool] | None = None
) -> Block | None:
    """The rows of units, sorted, with their processor time.

    Parameters
    ----------
    head : Head
        The specification, with its functions, and its units.
    units : ndarray of int64
        Numbers of possible units.
    threads : int
        Threads of the core.
    stop : callable, optional
        Asked twenty times a second; True ends the work.

    Returns
    -------
    Block or None
        None if ``stop()`` was true.
    """
    spec, units = head.spec, np.sort(units)
    pixels, place = np.divmod(units, head.segments)
    first, counts = place * head.segment, head.samples_of(units)

    blocks = []
    for part, at, own in spec.by_part(pixels):
        for count in np.unique(counts[at]).tolist():  # the last unit of a pixel may be shorter
            mine = at[counts[at] == count]
            of_units = own[counts[at] == count]
            columns_of = partial(_columns_of, part, threads=threads, stop=stop)
            if spec.looks is None:
                columns = columns_of(of_units, first[mine], count)
            else:
                columns = _sequential(spec, spec.looks, of_units, columns_of)
            if columns is None:
                return None
            costs = columns["nanoseconds"].astype("<f4")
            bins = bins_of(units[mine], columns["measures"])
            blocks.append(Block(rows_of(units[mine], columns), costs, bins))
    if len(blocks) == 1:
        return blocks[0]
    rows, costs, bins = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    order = np.argsort(rows["unit"], kind="stable")
    return Block(rows[order], costs[order], bins[np.argsort(bins[:, 0], kind="stable")])


def _columns_of(
    part: MapPart,
    pixels: Ints,
    first: int | Ints,
    count: int,
    *,
    threads: int,
    stop: Callable[[], bool] | None,
) -> Columns | None:
    """The columns of so many samples of pixels of a part, from the first."""
    job = to_core(part.spec, pixels, count, first, part.fixed)
    return job.run(0, len(pixels) * count, threads, stop)


def _sequential(
    spec: MapSpec,
    looks: Looks,
    pixels: Ints,
    columns_of: Callable[[Ints, int, int], Columns | None],
) -> Columns | None:
    """The columns of pixels, each with as many samples as it needs.

    All samples until the next look at which a pixel can stop are computed at once: the looks
    between cannot stop it.
    """
    statistics = _core.MapStatistics(len(pixels), len(spec.measure))
    samples = np.zeros(len(pixels), np.int64)
    active = np.ones(len(pixels), np.bool_)
    while active.any():
        columns = statistics.arrays()
        stable, unknown = columns["stable"], columns["undecided"] + columns["failed"]
        until = np.where(active, looks.following(stable, unknown, samples), 0)
        pairs = np.unique(np.stack([samples[active], until[active]]), axis=1).T.tolist()
        for begin, end in pairs:
            mine = np.flatnonzero(active & (samples == begin) & (until == end))
            for span in spans(spec, range(begin, end)):
                part = columns_of(pixels[mine], span.start, len(span))
                if part is None:
                    return None
                statistics.merge({**part, "pixels": mine})
        samples = np.where(active, until, samples)
        columns = statistics.arrays()
        unknown = columns["undecided"] + columns["failed"]
        active &= ~looks.stops(columns["stable"], unknown, samples)
    return {**statistics.arrays(), "measures": statistics.bins()}


class Table:
    """The known rows by unit.

    Attributes
    ----------
    head : Head
    rows : ndarray of ROW, shape (units,)
    known : ndarray of bool, shape (units,)
    nanoseconds : ndarray of float32, shape (units,)
        Processor time, NaN where it is not known.
    twice : int
        Rows that came a second time, with the same bytes.
    """

    def __init__(self, head: Head) -> None:
        self.head = head
        try:
            self.rows: Rows = np.zeros(head.units, ROW)
        except MemoryError:
            needed = head.units * ROW.itemsize / 2**30
            raise MemoryError(
                f"axes: the columns of {head.units:,} pixels need {needed:,.0f} GiB; take fewer "
                "values"
            ) from None
        self.known = np.zeros(head.units, np.bool_)
        self.nanoseconds = np.full(head.units, np.nan, np.float32)
        self.twice = 0
        self._bins: list[Bins] = []

    def add(self, new: Block, source: object) -> None:
        """Add rows; those that are known already must be equal.

        Raises
        ------
        StoreError
            Naming the source, the unit and the fields, if they are not; or for a unit that the map
            does not have.
        """
        rows, costs, bins = new
        units = rows["unit"]
        if ((units < 0) | (units >= len(self.rows))).any():
            raise StoreError(f"{source}: a row of a unit that the map does not have")
        again = self.known[units]
        if again.any():
            known = units[again]
            found = unequal(self.block(known), new.some(again), self.head.spec.measure)
            if found:
                raise StoreError(f"{source}: {found}")
            self.twice += int(again.sum())
        self.rows.view(_WHOLE)[units] = rows.view(_WHOLE)
        self.known[units] = True
        self.nanoseconds[units] = np.where(np.isnan(costs), self.nanoseconds[units], costs)
        if self.head.spec.measure:
            self._bins.append(new.some(~again).bins if again.any() else bins)

    def block(self, units: NDArray[np.int64]) -> Block:
        """The known rows of units."""
        bins = NO_BINS
        if self._bins:
            self._bins = [np.concatenate(self._bins)]
            bins = _sorted(self._bins[0][np.isin(self._bins[0][:, 0], units)])
        return Block(self.rows.view(_WHOLE)[units].view(ROW), self.nanoseconds[units], bins)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which units belong to the map: for a pixel all units before the first unknown one.

        So the bodies of a pixel are its first ones, and are computed again without the units.
        """
        known = self.known.reshape(-1, self.head.segments)
        return np.logical_and.accumulate(known, axis=1).ravel()

    def merged(self) -> tuple[dict[str, NDArray[Any]], list[Bins]]:
        """The columns of the map and the bins of each measure, over the segments of each pixel."""
        segments, measures = self.head.segments, range(len(self.head.spec.measure))
        every = _sorted(np.concatenate([NO_BINS, *self._bins]))
        bins = [np.delete(every[every[:, 1] == number], 1, axis=1) for number in measures]
        columns = {**{name: self.rows[name] for name in FIELDS}, "nanoseconds": self.nanoseconds}
        if segments == 1:
            none = _core.MapStatistics(1).arrays()
            return {name: np.where(self.known, columns[name], none[name]) for name in none}, bins
        units, place = np.flatnonzero(self.counted), np.full(len(self.rows), -1)
        place[units] = np.arange(len(units))
        statistics = _core.MapStatistics(len(self.rows) // segments, len(measures))
        part: dict[str, Any] = {name: column[units] for name, column in columns.items()}
        part["nanoseconds"] = part["nanoseconds"].astype(np.float64)
        for own in bins:
            own[:, 0] = place[own[:, 0]]
        of_rows = [own[own[:, 0] >= 0] for own in bins]
        statistics.merge({**part, "pixels": units // segments, "measures": of_rows})
        return statistics.arrays(), statistics.bins()


def unequal(old: Block, new: Block, measures: Sequence[object]) -> str:
    """Which of the rows of equal units differ first, in what, and how; empty if none does."""
    if old.rows.tobytes() == new.rows.tobytes() and np.array_equal(old.bins, new.bins):
        return ""
    told = zip(new.rows["unit"], differences(old, new, measures), strict=True)
    differ = [f"unit {unit} has two results: {text}" for unit, text in told if text]
    return f"{differ[0]} ({len(differ)} units differ)" if differ else ""


def differences(
    old: Block, new: Block, measures: Sequence[object], words: str = "{} {} and {}"
) -> Iterator[str]:
    """Of the rows of equal units, how each differs; empty if its bytes are equal."""
    for one, other, mine, theirs in zip(old.rows, new.rows, old.each(), new.each(), strict=True):
        if one.tobytes() == other.tobytes() and np.array_equal(mine, theirs):
            yield ""
            continue
        fields = [
            words.format(name, one[name], other[name])
            for name in FIELDS
            if one[name].tobytes() != other[name].tobytes()
        ]
        for number, measure in enumerate(measures):
            first, second = (bins[bins[:, 1] == number] for bins in (mine, theirs))
            if not np.array_equal(first, second):
                fields.append(f"values of {measure}")
        yield ", ".join(fields)
