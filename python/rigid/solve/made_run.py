"""A run from the columns of the core: statuses, ends of records, axes of bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.leading import Shape
from .batch import Batch
from .error_estimate import ErrorEstimate
from .events import FoundEvents
from .plan import LazyPlan
from .run import Run
from .status import Status, judged_status
from .target import COLUMNS

__all__ = ["end_records", "to_run"]


def end_records(
    states: dict[str, Any], times: NDArray[np.float64], last: NDArray[np.float64]
) -> None:
    """Write NaN over the states at times (m,) or (n, m) after the last of each body, (n, 1)."""
    after = times > last
    if not after.any():
        return
    for name in (*(column for column, _ in COLUMNS.values()), "tangent", "sensitivity"):
        if states.get(name) is not None:
            states[name][after] = np.nan


def to_run(
    states: dict[str, Any],
    times: NDArray[np.float64],
    estimate: ErrorEstimate,
    spec: dict[str, Any],
    plan: LazyPlan,
    batch: Batch,
    shape: Shape,
    parameters: tuple[str, ...] = (),
    found: FoundEvents | None = None,
) -> Run:
    """The run of bodies of this shape, from the columns of the core."""

    def of_body(values: Any) -> Any:
        if values is None:
            return None
        return values.reshape(*shape, *values.shape[1:]) if shape else values[0]

    error, lost_from = estimate.error, estimate.lost_from
    if np.count_nonzero(states["status"]):
        unknown = np.isin(states["status"], (Status.STEP_LIMIT, Status.NOT_FINITE))
        error, lost_from = (np.where(unknown, np.nan, values) for values in (error, lost_from))
    states["status"] = judged_status(states["status"], error, spec)
    if found is not None:
        ended = found.stopped & np.isin(states["status"], (Status.OK, Status.UNCHECKED))
        states["status"] = np.where(ended, Status.STOPPED, states["status"]).astype(np.uint8)
    attitude = batch.attitude
    if len(attitude) != len(batch):
        attitude = np.broadcast_to(attitude, (len(batch), 4))
    return Run(
        t=times,
        omega=of_body(states["omega"]),
        gamma=of_body(states["vertical"]),
        attitude=of_body(states["attitude"]),
        work=of_body(states["work"]),
        tangent=of_body(states["tangent"]),
        sensitivity=of_body(states.get("sensitivity")),
        parameters=parameters,
        events=() if found is None else found.events,
        end=None if found is None else of_body(found.end),
        start_omega=of_body(batch.omega),
        start_attitude=of_body(attitude),
        energy_drift=of_body(states["energy_drift"]),
        momentum_drift=of_body(states["momentum_drift"]),
        unit_drift=of_body(states["unit_drift"]),
        status=of_body(states["status"]),
        steps=of_body(states["steps"]),
        error=of_body(error),
        lost_from=of_body(lost_from),
        nanoseconds=states["nanoseconds"],
        spec=spec,
        _plan=plan,
    )
