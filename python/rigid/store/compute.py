"""The work: a pure function of the specification and the units. Any process may call it, twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.job import spans, to_core
from ..maps.sequential import Looks
from ..maps.spec import MapSpec
from .rows import Block, bins_of, rows_of

Ints = NDArray[np.int64]
Columns = dict[str, Any]
"""Arrays by the name of their column, and the bins of the ``measures``."""


def compute(
    spec: MapSpec,
    units: NDArray[np.int64],
    threads: int = 1,
    stop: Callable[[], bool] | None = None,
    *,
    segment: int | None = None,
) -> Block | None:
    """The rows of units, sorted, with their processor time.

    Parameters
    ----------
    spec : MapSpec
        The specification, with its functions.
    units : ndarray of int64
        Numbers of possible units.
    threads : int
        Threads of the core.
    stop : callable, optional
        Asked twenty times a second; True ends the work.
    segment : int, optional
        Most samples of a unit; by default all samples of a pixel.

    Returns
    -------
    Block or None
        None if ``stop()`` was true.
    """
    units = np.sort(units)
    size = spec.samples if segment is None else segment
    pixels, place = np.divmod(units, -(-spec.samples // size))
    first = place * size
    counts = np.minimum(spec.samples - first, size)
    blocks = []
    for count in np.unique(counts).tolist():  # the last unit of a pixel may be shorter
        mine = counts == count
        if spec.looks is None:
            columns = _columns(spec, pixels[mine], first[mine], count, threads, stop)
        else:
            columns = _sequential(spec, spec.looks, pixels, threads, stop)
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


def _columns(
    spec: MapSpec,
    pixels: Ints,
    first: int | Ints,
    count: int,
    threads: int,
    stop: Callable[[], bool] | None,
) -> Columns | None:
    """The columns of so many samples of pixels, from the first; None if ``stop()`` was true."""
    job = to_core(spec, pixels, count, first)
    return job.run(0, len(pixels) * count, threads, stop)


def _sequential(
    spec: MapSpec,
    looks: Looks,
    pixels: Ints,
    threads: int,
    stop: Callable[[], bool] | None,
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
                part = _columns(spec, pixels[mine], span.start, len(span), threads, stop)
                if part is None:
                    return None
                statistics.merge({**part, "pixels": mine})
        samples = np.where(active, until, samples)
        columns = statistics.arrays()
        unknown = columns["undecided"] + columns["failed"]
        active &= ~looks.stops(columns["stable"], unknown, samples)
    return {**statistics.arrays(), "measures": statistics.bins()}
