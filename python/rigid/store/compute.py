"""The work: a pure function of the specification and the units. Any process may call it, twice."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.grid import nominal_starts
from ..maps.identity import SEGMENT
from ..maps.job import to_core
from ..maps.spec import MapSpec
from .rows import FIELDS, Rows, rows_of

__all__ = ["Block", "compute", "moment_status"]

Block = tuple[Rows, NDArray[np.float32]]
"""Rows and the processor time of each, ns."""

PIXELS_TOGETHER = 2**16
"""Pixels whose moments are made at a time."""


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
    segments = -(-spec.samples // SEGMENT)
    rows, costs = [], []
    for segment in np.unique(units % segments):
        mine = units[units % segments == segment]
        samples = range(int(segment) * SEGMENT, min((int(segment) + 1) * SEGMENT, spec.samples))
        job = to_core(spec, mine // segments, samples)
        part = job.run(0, len(mine) * len(samples), threads, stop)
        if part is None:
            return None
        rows.append(rows_of(mine, {name: part[name] for name in FIELDS}))
        costs.append(part["nanoseconds"].astype("<f4"))
    together = np.concatenate(rows)
    order = np.argsort(together["unit"], kind="stable")
    return together[order], np.concatenate(costs)[order]


def moment_status(spec: MapSpec) -> NDArray[np.uint8]:
    """The status of the moments of each pixel in C order: 0 where the body is possible."""
    pixels = int(np.prod(spec.shape))
    status = np.empty(pixels, np.uint8)
    for begin in range(0, pixels, PIXELS_TOGETHER):
        index = np.arange(begin, min(begin + PIXELS_TOGETHER, pixels))
        starts = nominal_starts(spec.scene, spec.start, spec.axes, index)
        status[index] = _core.moment_status(starts.moments)
    return status
