"""The work: a pure function of the specification and the units. Any process may call it, twice."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.identity import segment_of
from ..maps.job import spans, to_core
from ..maps.sequential import Looks
from ..maps.spec import MapSpec
from .rows import Rows, rows_of

__all__ = ["Block", "compute"]

Columns = dict[str, NDArray[Any]]
"""Arrays by the name of their column."""

Block = tuple[Rows, NDArray[np.float32]]
"""Rows and the processor time of each, ns."""


@lru_cache(maxsize=4)
def _spec(text: str) -> MapSpec:
    return MapSpec.from_json(text)


def compute(
    text: str,
    units: NDArray[np.int64],
    threads: int = 1,
    stop: Callable[[], bool] | None = None,
) -> Block | None:
    """The rows of units, sorted, and their processor time.

    Parameters
    ----------
    text : str
        The specification as JSON.
    units : ndarray of int64
        Numbers of possible units.
    threads : int
        Threads of the core.
    stop : callable, optional
        Asked twenty times a second; True ends the work.

    Returns
    -------
    tuple or None
        None if ``stop()`` was true.
    """
    spec, units = _spec(text), np.sort(units)
    size = segment_of(spec)
    segments = -(-spec.samples // size)
    blocks = []
    for segment in np.unique(units % segments) if segments > 1 else (0,):
        mine = units[units % segments == segment] if segments > 1 else units
        samples = range(int(segment) * size, min((int(segment) + 1) * size, spec.samples))
        if spec.looks is None:
            columns = _columns(spec, mine // segments, samples, threads, stop)
        else:
            columns = _sequential(spec, spec.looks, mine, threads, stop)
        if columns is None:
            return None
        blocks.append((rows_of(mine, columns), columns["nanoseconds"].astype("<f4")))
    if len(blocks) == 1:
        return blocks[0]
    rows, costs = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    order = np.argsort(rows["unit"], kind="stable")
    return rows[order], costs[order]


def _columns(
    spec: MapSpec,
    pixels: NDArray[np.int64],
    samples: range,
    threads: int,
    stop: Callable[[], bool] | None,
) -> Columns | None:
    """The columns of these samples of pixels; None if ``stop()`` was true."""
    merged: Columns | None = None
    for span in spans(spec, samples):
        part = to_core(spec, pixels, span).run(0, len(pixels) * len(span), threads, stop)
        if part is None:
            return None
        merged = part if merged is None else _merged(merged, part)
    return merged


def _merged(one: Columns, other: Columns) -> Columns:
    statistics = _core.MapStatistics(len(one["nanoseconds"]))
    for part in (one, other):
        statistics.merge({**part, "first": 0})
    return statistics.arrays()


def _sequential(
    spec: MapSpec,
    looks: Looks,
    pixels: NDArray[np.int64],
    threads: int,
    stop: Callable[[], bool] | None,
) -> Columns | None:
    """The columns of pixels, each with as many samples as it needs.

    All samples until the next look at which a pixel can stop are computed at once: the looks
    between cannot stop it.
    """
    all_columns = _core.MapStatistics(len(pixels)).arrays()
    samples = np.zeros(len(pixels), np.int64)
    active = np.ones(len(pixels), np.bool_)
    while active.any():
        stable, unknown = (
            all_columns["stable"],
            all_columns["undecided"] + all_columns["failed"],
        )
        until = np.where(active, looks.following(stable, unknown, samples), 0)
        pairs = np.unique(np.stack([samples[active], until[active]]), axis=1).T.tolist()
        for begin, end in pairs:
            mine = np.flatnonzero(active & (samples == begin) & (until == end))
            part = _columns(spec, pixels[mine], range(begin, end), threads, stop)
            if part is None:
                return None
            old = {name: all_columns[name][mine] for name in all_columns}
            for name, values in _merged(old, part).items():
                all_columns[name][mine] = values
        samples = np.where(active, until, samples)
        unknown = all_columns["undecided"] + all_columns["failed"]
        active &= ~looks.stops(all_columns["stable"], unknown, samples)
    return all_columns
