"""The values that a map has collected in each pixel: exact moments, extremes, and quantiles.

The core hands over bins: numbers of one sign, one exponent and six leading bits of the mantissa,
with the exact sums of what their values exceed the bin by. Whole numbers are merged exactly, so no
number here depends on threads or the order of the bodies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, numbers
from .._checks.arrays import Floats
from ..model.measures import Measure

Ints = NDArray[np.int64]

BIN = 10
"""Numbers of a bin: pixel, key, count, least and largest offset, the sums of the offsets and of
their squares, and the largest error. Each sum is stored as two halves of 64 bits; the error as its
bits, or -1 if none is known."""

NUMBERS = ("mean", "std", "least", "largest", "count", "error")
"""The numbers of a measure that tables have."""

_REST = 46
"""Bits of the mantissa that are offsets in a bin."""


class Measured:
    """The values of one measure in each pixel; arrays have the shape of the grid.

    Attributes
    ----------
    measure : Measure
    bins : ndarray of int64, shape (n, 10)
        The histogram as the core gives it, sorted by pixel and value.
    """

    def __init__(self, measure: Measure, bins: Ints, shape: tuple[int, ...]) -> None:
        self.measure = measure
        self.bins = bins
        self._shape = shape

    def _where(self, values: Floats) -> Floats:
        """One value for each pixel that has bins, NaN for the others."""
        all_ = np.full(math.prod(self._shape), np.nan)
        all_[self.bins[self._first, 0]] = values
        return all_.reshape(self._shape)

    @cached_property
    def _first(self) -> NDArray[np.intp]:
        """The first row of each pixel that has bins."""
        return np.flatnonzero(np.diff(self.bins[:, 0], prepend=-1))

    @cached_property
    def _last(self) -> NDArray[np.intp]:
        """The last row of each pixel that has bins."""
        return np.flatnonzero(np.diff(self.bins[:, 0], append=-1))

    @cached_property
    def count(self) -> Ints:
        """Number of bodies that have the value."""
        counts = np.zeros(math.prod(self._shape), dtype=np.int64)
        np.add.at(counts, self.bins[:, 0], self.bins[:, 2])
        return counts.reshape(self._shape)

    @cached_property
    def least(self) -> Floats:
        """The least value, NaN without values."""
        rows = self.bins[self._first]
        return self._where(_values(rows[:, 1], np.where(rows[:, 1] < 0, rows[:, 4], rows[:, 3])))

    @cached_property
    def largest(self) -> Floats:
        """The largest value, NaN without values."""
        rows = self.bins[self._last]
        return self._where(_values(rows[:, 1], np.where(rows[:, 1] < 0, rows[:, 3], rows[:, 4])))

    @cached_property
    def error(self) -> Floats:
        """The largest difference of the two runs of a body; NaN where no body was run twice."""
        # Bits of -1 are a NaN, and the bits of positive numbers have their order.
        return self._where(np.maximum.reduceat(self.bins[:, 9], self._first).view(np.float64))

    @property
    def mean(self) -> Floats:
        """Mean of the values, rounded once; NaN without values."""
        return self._moments[0]

    @property
    def std(self) -> Floats:
        """Standard deviation with the divisor ``count - 1``; NaN for fewer than two values."""
        return self._moments[1]

    @cached_property
    def _moments(self) -> tuple[Floats, Floats]:
        means, deviations = [], []
        for first, last in zip(self._first, self._last, strict=True):
            mean, deviation = _moments_of(self.bins[first : last + 1])
            means.append(mean)
            deviations.append(deviation)
        return self._where(np.array(means)), self._where(np.array(deviations))

    def totals(self) -> tuple[int, float, float, float]:
        """Bodies of the whole map that have the value, and its mean, least and largest."""
        bodies = int(self.count.sum())
        if not bodies:
            return 0, math.nan, math.nan, math.nan
        mean, _ = _moments_of(self.bins)
        return bodies, mean, float(np.nanmin(self.least)), float(np.nanmax(self.largest))

    def quantile(self, q: ArrayLike) -> Floats:
        """The least value that a share ``q`` of the bodies does not exceed.

        Parameters
        ----------
        q : array_like
            Shares in [0, 1].

        Returns
        -------
        ndarray, shape (*q.shape, *grid)
            Relative error at most 1/64, the width of a bin: the value is the mean of the bin that
            holds the quantile. Exact where all values of the bin are equal. NaN without values.

        Raises
        ------
        ValueError
            If a share lies outside [0, 1].

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=100, t_end=50.0,
        ...     stable=rigid.no_flip(), measure=rigid.time_to_leave(), rng=2026,
        ... )
        >>> times = result.measures["time_to_leave"]
        >>> times.quantile([0.1, 0.5, 0.9]).shape
        (3, 2)
        >>> bool((times.least <= times.mean).all())
        True
        """
        shares = numbers("q", q)
        outside = ~((shares >= 0.0) & (shares <= 1.0))
        if outside.any():
            raise ValueError(f"q = {brief(float(shares[outside].flat[0]))}: must lie in [0, 1]")
        through = np.cumsum(self.bins[:, 2])
        before = through[self._first] - self.bins[self._first, 2]
        counts = through[self._last] - before
        values = _means(self.bins)
        each = []
        for share in shares.ravel():
            # 0.07 * 100 is a little more than 7.
            rank = np.maximum(np.ceil(share * counts * (1.0 - 1e-12)).astype(np.int64), 1)
            each.append(self._where(values[np.searchsorted(through, before + rank)]))
        return np.array(each).reshape(shares.shape + self._shape)

    def __repr__(self) -> str:
        return f"<{self.measure} of {int(self.count.sum()):,} bodies>"


class Measures(Mapping[str, Measured]):
    """The measures of a map by name: ``"flips(2)"``, or ``"flips"`` if this name occurs once.

    Without bins no body has a value.
    """

    def __init__(
        self,
        measures: Sequence[Measure],
        bins: Sequence[Ints] | None,
        shape: tuple[int, ...],
    ) -> None:
        if bins is None:
            bins = [np.empty((0, BIN), np.int64) for _ in measures]
        self._known = {
            str(measure): Measured(measure, rows, shape)
            for measure, rows in zip(measures, bins, strict=True)
        }

    def __getitem__(self, name: str) -> Measured:
        if name in self._known:
            return self._known[name]
        named = [one for one in self._known.values() if one.measure.name == name]
        if len(named) == 1:
            return named[0]
        known = ", ".join(self._known) or "none"
        raise KeyError(f"{brief(name)} is not measured once (measured: {known})")

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def __repr__(self) -> str:
        return f"<measures: {', '.join(self._known) or 'none'}>"


def _values(keys: Ints, offsets: Ints) -> Floats:
    """The numbers with these offsets in these bins."""
    magnitude = np.where(keys < 0, -1 - keys, keys)
    values: Floats = (magnitude << _REST | offsets).view(np.float64)
    return np.where(keys < 0, -values, values)


def _means(bins: Ints) -> Floats:
    """The mean of the values of each bin, rounded a few times."""
    sums = _wide(bins[:, 5]) + np.ldexp(_wide(bins[:, 6]), 64)
    mean = np.clip(np.rint(sums / bins[:, 2]), bins[:, 3], bins[:, 4]).astype(np.int64)
    return _values(bins[:, 1], mean)


def _wide(half: Ints) -> Floats:
    return half.view(np.uint64).astype(np.float64)


def _moments_of(bins: Ints) -> tuple[float, float]:
    """Mean and standard deviation of the values of bins, from sums in whole numbers.

    The unit of the sum is 2^-1074, the unit of the squares 2^-2148.
    """
    count = total = squares = 0
    for _, key, number, _, _, low, high, square_low, square_high, _ in bins.tolist():
        magnitude = -1 - key if key < 0 else key
        field, lead = magnitude >> 6, magnitude & 63
        begin, shift = (lead | (64 if field else 0)) << _REST, max(field - 1, 0)
        over = (low & MASK) | (high & MASK) << 64
        over2 = (square_low & MASK) | (square_high & MASK) << 64
        sign = -1 if key < 0 else 1
        count += number
        total += sign * (number * begin + over) << shift
        squares += (number * begin * begin + 2 * begin * over + over2) << 2 * shift
    mean = total / (count << 1074)
    if count < 2:
        return mean, math.nan
    spread = count * squares - total * total
    return mean, math.sqrt(spread / ((count * (count - 1)) << 2148))


MASK = 2**64 - 1
