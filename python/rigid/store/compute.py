"""The work: a pure function of the specification and the units. Any process may call it, twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.job import of_pixels, spans, to_core
from ..maps.sequential import Looks
from ..maps.spec import MapSpec
from .rows import Block, bins_of, rows_of

__all__ = ["compute"]

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
        Most samples of a unit; by default those of a pixel.

    Returns
    -------
    Block or None
        None if ``stop()`` was true.
    """
    units = np.sort(units)
    size = spec.samples if segment is None else segment
    segments = -(-spec.samples // size)
    blocks = []
    for place in np.unique(units % segments) if segments > 1 else (0,):
        mine = units[units % segments == place] if segments > 1 else units
        samples = range(int(place) * size, min((int(place) + 1) * size, spec.samples))
        if spec.looks is None:
            columns = _columns(spec, mine // segments, samples, threads, stop)
        else:
            columns = _sequential(spec, spec.looks, mine, threads, stop)
        if columns is None:
            return None
        costs = columns["nanoseconds"].astype("<f4")
        blocks.append(Block(rows_of(mine, columns), costs, bins_of(mine, columns["measures"])))
    if len(blocks) == 1:
        return blocks[0]
    rows, costs, bins = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    order = np.argsort(rows["unit"], kind="stable")
    return Block(rows[order], costs[order], bins[np.argsort(bins[:, 0], kind="stable")])


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
    measures = len(one["measures"])
    statistics = _core.MapStatistics(len(one["nanoseconds"]), measures)
    for part in (one, other):
        statistics.merge({**part, "first": 0})
    return {**statistics.arrays(), "measures": statistics.bins()}


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
    nothing = _core.MapStatistics(len(pixels)).arrays()
    all_columns = {name: values.copy() for name, values in nothing.items()}
    values = _core.MapStatistics(len(pixels), len(spec.measure))
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
            if spec.measure:
                bins = [of_pixels(own, mine) for own in part["measures"]]
                values.merge({**nothing, "first": 0, "measures": bins})
            old = {name: all_columns[name][mine] for name in all_columns}
            merged = _merged({**old, "measures": []}, {**part, "measures": []})
            for name, column in all_columns.items():
                column[mine] = merged[name]
        samples = np.where(active, until, samples)
        unknown = all_columns["undecided"] + all_columns["failed"]
        active &= ~looks.stops(all_columns["stable"], unknown, samples)
    return {**all_columns, "measures": values.bins()}
