"""The exact coverage of intervals that are reported at the first look at which they are narrow."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid.maps.data import interval
from rigid.maps.sequential import CONFIDENCE, LOOK, Looks

Floats = NDArray[np.float64]


class Stopping:
    """A table of looks with the intervals that are reported at each."""

    def __init__(self, looks: Looks) -> None:
        self.looks = looks
        self.tables = []
        for samples in looks.samples.tolist():
            stable = np.arange(samples + 1)
            trials, unknown = np.full(samples + 1, samples), np.zeros(samples + 1, np.int64)
            lower, upper = interval(stable, trials, CONFIDENCE)
            stops = looks.stops(stable, unknown, trials)
            self.tables.append((lower, upper, stops))

    def coverage(self, p: float) -> tuple[float, float]:
        """The chance that the reported interval holds a share, and the mean number of samples.

        A recursion over the numbers of samples and of stable ones: the chance of each state that
        has not stopped. It is banded: chances below 1e-17 are dropped.
        """
        draw = binomial(LOOK, p)
        chances, first, covered, mean = np.ones(1), 0, 0.0, 0.0
        for samples, (lower, upper, stops) in zip(self.looks.samples, self.tables, strict=True):
            chances = np.convolve(chances, draw)
            stable = np.arange(first, first + len(chances))
            stopped = stops[stable]
            holds = (lower[stable] <= p) & (p <= upper[stable])
            mean += float(samples * chances[stopped].sum())
            covered += float(chances[stopped & holds].sum())
            chances = np.where(stopped, 0.0, chances)
            kept = np.flatnonzero(chances > 1e-17)
            if not kept.size:
                break
            first += int(kept[0])
            chances = chances[kept[0] : kept[-1] + 1]
        return covered, mean

    def ends(self) -> Floats:
        """The ends of the intervals that can be reported: the coverage dips beside them."""
        return np.unique(
            np.concatenate([end[stops] for *both, stops in self.tables for end in both])
        )


def binomial(trials: int, p: float) -> Floats:
    """The chances of 0 .. n successes."""
    from math import comb

    k = np.arange(trials + 1)
    ways = np.array([float(comb(trials, i)) for i in range(trials + 1)])
    chances: Floats = ways * p**k * (1.0 - p) ** (trials - k)
    return chances


def shares(count: int) -> Floats:
    """True shares, dense near 0; the rule is symmetric in p and 1 - p."""
    few = count // 3
    return np.concatenate([np.geomspace(1e-5, 0.02, few), np.linspace(0.02, 0.5, count - few)])


def some(values: Floats, count: int) -> Floats:
    """At most so many of the values, evenly spaced."""
    return values[:: -(-len(values) // count) or 1]


def least_coverage(half_widths: Sequence[float], count: int) -> dict[float, float]:
    """The least coverage over true shares, and over both sides of some ends of intervals.

    Most of these lie next to shares of twice the half width. There pixels stop at each of the first
    looks with few stable bodies, or none, and the coverage is least.
    """
    from rigid.maps.sequential import stop_table

    found = {}
    for half_width in half_widths:
        stopping = Stopping(stop_table(half_width))
        ends = stopping.ends()
        twice = (ends > 1.7 * half_width) & (ends < 2.5 * half_width) & (ends <= 0.5)
        ends = np.concatenate(
            [some(ends[(ends > 0.0) & (ends <= 0.5)], count // 2), some(ends[twice], count // 2)]
        )
        sides = np.concatenate([np.nextafter(ends, 0.0), np.nextafter(ends, 1.0)])
        tried = np.concatenate([shares(count), sides])
        found[half_width] = min(stopping.coverage(float(p))[0] for p in tried)
    return found
