"""A run from the columns of the core: statuses, ends of records, axes of bodies."""

from __future__ import annotations

from collections.abc import MutableMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .bodies import Bodies
from .error_estimate import ErrorEstimate
from .events import FoundEvents
from .lazy import Lazy
from .plan import LazyPlan
from .run import Run
from .status import Status, is_accurate, status_by_error
from .target import COLUMNS

__all__ = ["end_records", "made_steps", "to_run"]


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


def to_run(
    states: MutableMapping[str, Any],
    times: NDArray[np.float64],
    estimate: ErrorEstimate | _core.States,
    accuracy: float | None,
    spec: Lazy[dict[str, Any]],
    plan: LazyPlan,
    bodies: Bodies,
    parameters: tuple[str, ...] = (),
    found: FoundEvents | None = None,
) -> Run:
    """The run of these bodies, from the columns of the core."""
    worst = estimate.worst if isinstance(estimate, _core.States) else None
    if worst is None or not is_accurate(worst, accuracy):
        error, lost_from = estimate.error, estimate.lost_from
        if np.count_nonzero(states["status"]):
            unknown = np.isin(states["status"], (Status.STEP_LIMIT, Status.NOT_FINITE))
            error, lost_from = (np.where(unknown, np.nan, values) for values in (error, lost_from))
        states["status"] = status_by_error(states["status"], error, accuracy)
        states["error"], states["lost_from"] = error, lost_from
    if found is not None:
        ended = found.stopped & np.isin(states["status"], (Status.OK, Status.UNCHECKED))
        states["status"] = np.where(ended, Status.STOPPED, states["status"]).astype(np.uint8)
        states["end"] = found.end
    attitude, count = bodies.attitude, len(bodies.omega)
    if len(attitude) != count:
        attitude = np.broadcast_to(attitude, (count, 4))
    states["t"], states["start_omega"], states["start_attitude"] = times, bodies.omega, attitude
    return Run(
        _parameters=parameters,
        _events=() if found is None else found.events,
        _spec=spec,
        _shape=bodies.shape,
        _columns=states,
        _plan=plan,
    )
