"""Ends of records, and steps of a run."""

from __future__ import annotations

from collections.abc import MutableMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .target import COLUMNS

__all__ = ["end_records", "made_steps"]


def end_records(
    states: MutableMapping[str, Any], times: NDArray[np.float64], last: NDArray[np.float64]
) -> None:
    """Write NaN over the states at times (m,) or (n, m) after the last of each body, (n, 1)."""
    after = times > last
    if not after.any():
        return
    for name in (*COLUMNS, "tangent", "sensitivity"):
        if states.get(name) is not None:
            states[name][after] = np.nan


def made_steps(
    taken: NDArray[np.uint64], span: float | NDArray[np.float64], accurate: NDArray[np.bool_]
) -> tuple[float | None, int]:
    """The shortest step (s) of the accurate bodies that cover this time, and the most steps."""
    moved = accurate & (taken > 0)
    made = np.broadcast_to(span, taken.shape)[moved] / taken[moved]
    return float(made.min()) if len(made) else None, int(taken[accurate].max(initial=0))
