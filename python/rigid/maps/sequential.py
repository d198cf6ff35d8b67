"""Sequential stopping: a pixel gets samples until the interval of its share is narrow enough.

Its counts are looked at after each 64 samples. It stops at the first look at which the
Clopper-Pearson interval of confidence 97 % is no wider than twice the requested half width, and
this interval is reported. Looking again and again costs confidence: the least chance, over all
shares, that the reported interval holds the true one was computed exactly, by summing over all ways
through the looks, and is 95 % or more. See M. J. Frey, "Fixed-width sequential confidence intervals
for a proportion", *The American Statistician* 64 (2010) 242.

The width grows with ``min(s, n - s)`` for s stable samples of n, so the rule is a table of whole
numbers: at look n a pixel stops if ``min(s, n - s)`` is at most ``m[n]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import finite_float

LOOK = 64
"""Samples between two looks; a multiple of the samples with common audits."""

CONFIDENCE = 0.97
"""Confidence of the interval at a look. The confidence of the reported interval is at least 0.95.
With 0.965 it falls to 0.9475 next to shares of twice the half width, where each of the first looks
may stop too early."""

NARROWEST, WIDEST = 0.002, 0.25
"""Bounds of the half width: 0.002 takes up to 294,848 samples."""

Counts = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """A table of looks.

    Attributes
    ----------
    samples : ndarray of int64, shape (k,)
        Samples at each look: 64, 128, ...
    most : ndarray of int64, shape (k,)
        A pixel stops at a look if the smaller of its counts is at most this; -1: none stops. At the
        last look all stop.
    """

    samples: Counts
    most: Counts

    @property
    def last(self) -> int:
        """The most samples that a pixel gets."""
        return int(self.samples[-1])

    def smaller(self, stable: Counts, unknown: Counts, samples: Counts) -> Counts:
        """The smaller count, with the unknown samples counted so that it is largest."""
        most = np.minimum(stable + unknown, samples - stable)
        smaller: Counts = np.minimum(most, samples // 2)
        return smaller

    def stops(self, stable: Counts, unknown: Counts, samples: Counts) -> NDArray[np.bool_]:
        """Which pixels have enough samples; the numbers of samples are numbers of looks, or 0."""
        most = np.concatenate([[-1], self.most])[samples // LOOK]
        enough = self.smaller(stable, unknown, samples) <= most
        stops: NDArray[np.bool_] = enough & (samples % LOOK == 0)
        return stops

    def following(self, stable: Counts, unknown: Counts, samples: Counts) -> Counts:
        """The next look at which each pixel can stop: its smaller count does not shrink.

        The last look for pixels that are beyond.
        """
        smaller = self.smaller(stable, unknown, samples)
        able = np.searchsorted(np.maximum.accumulate(self.most), smaller)
        at = np.minimum(np.maximum(able, samples // LOOK), len(self.samples) - 1)
        following: Counts = self.samples[at]
        return following


def checked_half_width(value: object) -> float:
    """A half width, checked.

    Raises
    ------
    TypeError, ValueError
    """
    half_width = finite_float("half_width", value, positive=True)
    if not NARROWEST <= half_width <= WIDEST:
        raise ValueError(f"half_width = {half_width}: must lie in [{NARROWEST}, {WIDEST}]")
    return half_width


@lru_cache(maxsize=16)
def stop_table(half_width: float) -> Looks:
    """The looks of a half width.

    Examples
    --------
    >>> from rigid.maps.sequential import stop_table
    >>> looks = stop_table(0.05)
    >>> dict(zip(looks.samples.tolist(), looks.most.tolist(), strict=True))
    {64: 1, 128: 7, 192: 19, 256: 37, 320: 64, 384: 101, 448: 158, 512: 256}
    """
    # Of the widest interval, at s = n / 2: a normal distribution has 1.18 / half_width² samples.
    # The correction of the exact one, some 2 / half_width, is less than what is added here.
    bound = (1.3 / half_width) ** 2 + 4 * LOOK
    samples = np.arange(LOOK, bound, LOOK, dtype=np.int64)
    low, high = np.full(len(samples), -1), samples // 2  # the largest that stops, by bisection
    while (low < high).any():
        middle = (low + high + 1) // 2
        lower, upper = _core.clopper_pearson(np.maximum(middle, 0), samples, CONFIDENCE)
        narrow = (upper - lower <= 2.0 * half_width) & (middle >= 0)
        low, high = np.where(narrow, middle, low), np.where(narrow, high, middle - 1)
    end = int(np.argmax(low == samples // 2)) + 1
    return Looks(samples[:end], low[:end])
