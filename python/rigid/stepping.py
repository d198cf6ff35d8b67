"""States by steps or closed form, with what is believed of their errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .belief import SAMPLE, Belief, ahead, around, believe, evenly, span_of, taken_from
from .columns import fastest_rates
from .costs import ROUNDING
from .methods import order_of
from .separatrix import next_to_separatrix

__all__ = ["Request", "by_steps", "of_closed_form"]

Floats = NDArray[np.float64]

ATTEMPTS = 4
"""How often the steps of a body are shortened for an accuracy before it is given up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What a call asks of the core, for any of its bodies and with any steps."""

    table: Mapping[str, Any]
    times: Floats
    method: str
    record: str
    max_steps: int
    threads: int
    tolerance: float | None

    def states(self, table: Mapping[str, Any], steps: Floats | None) -> dict[str, Any]:
        """The states of some bodies, each with its longest step."""
        return _core.simulate(
            **table,
            method=self.method,
            record=self.record,
            step=steps,
            max_steps=self.max_steps,
            threads=self.threads,
            times=self.times.tolist(),
            tolerance=self.tolerance,
        )

    def belief(self, table: Mapping[str, Any], states: Mapping[str, Any]) -> Belief:
        """What is believed of the errors of these states."""
        return believe(
            table,
            self.times,
            states,
            method=self.method,
            record=self.record,
            order=order_of(self.method),
            max_steps=self.max_steps,
            threads=self.threads,
            tolerance=self.tolerance,
        )


def by_steps(
    request: Request, steps: Floats | None, accuracy: float | None, *, check: bool
) -> tuple[dict[str, Any], Belief]:
    """The states, and what is believed of their errors."""
    states, belief = _stepped(request, steps, accuracy, check=check)
    delay, lost = next_to_separatrix(request.table, states, around(request.times))
    error = np.where(delay > 0.0, np.fmax(belief.error, delay), belief.error)
    earlier = ~(np.abs(belief.lost_from) < np.abs(lost))
    return states, Belief(error, np.where(earlier, lost, belief.lost_from))


def _stepped(
    request: Request, steps: Floats | None, accuracy: float | None, *, check: bool
) -> tuple[dict[str, Any], Belief]:
    table = request.table
    states = request.states(table, steps)
    count = len(table["omega"])
    if accuracy is None and not check:
        return states, Belief(np.full(count, np.nan), np.full(count, np.nan))
    if accuracy is None or steps is None:
        sample = evenly(count, SAMPLE)
        seen = request.belief(taken_from(table, sample), _rows(states, sample))
        if count <= SAMPLE:
            return states, seen
        if np.any(seen.error >= 1.0):
            # Where some are lost, each body is to know of itself.
            return states, request.belief(table, states)
        known = seen.error[~np.isnan(seen.error)]
        error = np.full(count, known.max() if len(known) else np.nan)
        lost_from = np.full(count, seen.lost_from.min())
        error[sample], lost_from[sample] = seen.error, seen.lost_from
        return states, Belief(error, lost_from)
    belief = request.belief(table, states)
    steps, order = steps.copy(), order_of(request.method)
    pending = np.flatnonzero(belief.error > accuracy)
    for _ in range(ATTEMPTS):
        if not len(pending):
            break
        steps[pending] /= [ahead(float(belief.error[i]), accuracy, order) for i in pending]
        some = taken_from(table, pending)
        shorter = request.states(some, steps[pending])
        again = request.belief(some, shorter)
        # Shorter steps that do not help: rounding or chaos rules.
        better = again.error < belief.error[pending]
        states["nanoseconds"] += shorter["nanoseconds"]
        _replace(states, pending[better], _rows(shorter, np.flatnonzero(better)))
        belief.error[pending[better]] = again.error[better]
        belief.lost_from[pending[better]] = again.lost_from[better]
        pending = pending[better & (again.error > accuracy)]
    return states, belief


def of_closed_form(table: Mapping[str, Any], times: Floats) -> Belief:
    """What is believed of the errors of a closed form: 1e-15 for each radian turned."""
    rates = fastest_rates(table, around(times))
    error = ROUNDING * (1.0 + rates * span_of(times))
    with np.errstate(divide="ignore"):
        lost = np.where(error >= 1.0, 1.0 / (ROUNDING * rates), np.inf)
    first, last = around(times)
    return Belief(error, np.where((-first > last) & (lost < np.inf), -lost, lost))


def _rows(states: Mapping[str, Any], bodies: NDArray[np.intp]) -> dict[str, Any]:
    """The states of some bodies."""
    columns = ((name, values) for name, values in states.items() if name != "nanoseconds")
    return {name: None if values is None else values[bodies] for name, values in columns}


def _replace(states: dict[str, Any], bodies: NDArray[np.intp], others: Mapping[str, Any]) -> None:
    """Writes the states of some bodies over."""
    for name, values in others.items():
        if values is not None:
            states[name][bodies] = values
