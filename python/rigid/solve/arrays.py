"""Ranges of times and evenly spread indices, as planning, integration and estimates need them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["spread_indices", "time_range", "time_span"]

Floats = NDArray[np.float64]


def time_range(times: Floats) -> tuple[float, float]:
    """First and last of the times and 0 (s)."""
    return float(times.min(initial=0.0)), float(times.max(initial=0.0))


def time_span(times: Floats) -> float:
    """Sum of the times covered from 0 backward and forward (s)."""
    first, last = time_range(times)
    return last - first


def spread_indices(count: int, most: int) -> NDArray[np.intp]:
    """At most ``most`` indices below ``count``, evenly spread, the last one among them."""
    # From the last to the first: a single one is the last.
    spread = (count - 1) - np.linspace(0, count - 1, min(count, most))
    indices: NDArray[np.intp] = np.unique(spread.round().astype(np.intp))
    return indices
