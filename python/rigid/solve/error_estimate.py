"""The error of a run, estimated from a second run with shorter steps.

Steps that are shorter by ``2**(2/p)``, and at least by a sixth, leave a quarter or less of the
truncation error of a method of order ``p``: the difference of the two runs is nearly all of it.
Where rounding dominates, or chaos amplifies it, the two runs differ by about as much as each of
them errs. In both cases three times the difference is stated: nearly always more than the error,
and seldom much more. The extrapolation is Richardson's (Hairer, Nørsett, Wanner, *Solving Ordinary
Differential Equations I*, § II.4).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import spread_indices, time_range, time_span
from .batch import Batch
from .cost_model import ROUNDING
from .methods import order_of, rotations, stiff_methods
from .request import Request

__all__ = ["ErrorEstimate", "closed_form_error", "distances", "estimate_error", "unknown_error"]

Floats = NDArray[np.float64]

SAFETY = 3.0
"""The difference of two runs times this is stated as the error."""

CHECKS = 16
"""Times of a run, at most, at which the two runs are compared."""

REST = 1e-6
"""Rates below this share of the fastest that a body can reach are those of a body at rest."""

EQUAL_RUNS = 5e-16
"""Error per radian turned (rad) that rounding may leave in two runs that agree to the bit."""

ROTATION = 1.6e-17
"""Error (rad) that rounding leaves in each rotation of a splitting.

Equal rotations err in both runs alike, all in one direction."""


@dataclass(frozen=True, slots=True)
class ErrorEstimate:
    """Estimated errors of some bodies.

    Attributes
    ----------
    error : ndarray, shape (n,)
        The largest error at the compared times; NaN if it is not known.
    lost_from : ndarray, shape (n,)
        The time (s) nearest to 0 from which on the error is 1 or more; infinite if there is none.
    """

    error: Floats
    lost_from: Floats


def unknown_error(count: int) -> ErrorEstimate:
    """The estimate of bodies whose error is unknown."""
    return ErrorEstimate(np.full(count, np.nan), np.full(count, np.nan))


def closed_form_error(batch: Batch, times: Floats) -> ErrorEstimate:
    """The error of a closed form: 1e-15 for each radian turned."""
    rates = batch.fastest_rates(time_range(times))
    error = ROUNDING * (1.0 + rates * time_span(times))
    with np.errstate(divide="ignore"):
        lost = np.where(error >= 1.0, 1.0 / (ROUNDING * rates), np.inf)
    first, last = time_range(times)
    return ErrorEstimate(error, np.where((-first > last) & (lost < np.inf), -lost, lost))


@np.errstate(all="ignore")
def estimate_error(request: Request, states: Mapping[str, Any]) -> ErrorEstimate:
    """The error of states that were made by steps, from a second run with shorter ones."""
    batch, times, method = request.batch, request.times, request.method
    taken = states["steps"].astype(np.float64)
    span = time_span(times)
    if span == 0.0 or not len(times):
        return ErrorEstimate(np.zeros(len(taken)), np.full(len(taken), np.inf))
    if not taken.any():
        return unknown_error(len(taken))
    checks = _compared_times(times, taken)
    rates = batch.fastest_rates(time_range(times))
    again = _shorter_run(request, checks, taken)
    seen = {
        name: None if states[name] is None else states[name][:, checks]
        for name in ("omega", "vertical", "attitude")
    }
    floor = EQUAL_RUNS * (1.0 + rates * span) + ROTATION * rotations(method) * taken
    error = SAFETY * distances(seen, again, REST * rates) + floor[:, None]
    # What is not a number is not known; a body that was not run has no error.
    error = np.where(np.isfinite(error), error, np.inf)
    if _is_damped_stiffly(request) and request.tolerance is None:
        # Damping can stop a body within a step: both runs lose the angle it turned meanwhile.
        error[rates * span > np.pi * taken] = np.inf
    error[taken == 0] = np.nan
    return ErrorEstimate(error.max(axis=1), _lost_from(error, times[checks]))


def _compared_times(times: Floats, taken: Floats) -> NDArray[np.intp]:
    """Indices of the times at which the runs are compared."""
    # Several steps lie between two of them, so that the shorter steps differ from the others.
    most = int(np.clip(taken[taken > 0].min() // 4, 1, CHECKS))
    checks = spread_indices(len(times), most)
    return np.union1d(checks, [0]) if times[0] < 0.0 else checks


def _shorter_run(request: Request, checks: NDArray[np.intp], taken: Floats) -> dict[str, Any]:
    """The states of the same bodies at some of the times, with shorter steps."""
    order = order_of(request.method)
    ratio = max(2.0 ** (2.0 / order), 1.2)
    if _is_damped_stiffly(request):
        # Under strong damping the order of these methods falls, to one at worst.
        ratio = max(ratio, 2.0)
    second = replace(
        request,
        times=request.times[checks],
        max_steps=min(4 * request.max_steps, 2**63),
        # Steps that follow a tolerance go with its power of one over the order.
        tolerance=None if request.tolerance is None else request.tolerance / ratio**order,
    )
    return second.states(time_span(request.times) / np.maximum(taken, 1.0) / ratio)


def _is_damped_stiffly(request: Request) -> bool:
    """Whether a method for strong damping integrates forced bodies."""
    return request.batch.forcing is not None and request.method in stiff_methods()


def _lost_from(error: Floats, times: Floats) -> Floats:
    """The time nearest to 0, with its sign, at which the error is 1 or more; shape (n,)."""
    lost = np.where(error >= 1.0, np.abs(times), np.inf)
    nearest = lost.argmin(axis=1)
    return np.where(np.isfinite(lost.min(axis=1)), times[nearest], np.inf)


def distances(
    states: Mapping[str, Any], other: Mapping[str, Any], rest: Floats | float = 0.0
) -> Floats:
    """Relative distance of the states of two runs, shape (n, m).

    The largest of ``|d omega|`` over the largest ``|omega|`` of the body, of the angle between the
    verticals and of the angle between the attitudes. Rates below ``rest`` are compared with that.
    """
    rates, others = states["omega"], other["omega"]
    size = np.maximum(np.linalg.norm(others, axis=-1).max(axis=1, initial=0.0), rest)
    moving = np.where(size > 0.0, size, 1.0)
    parts = [np.linalg.norm(rates - others, axis=-1) / moving[:, None]]
    if states["vertical"] is not None:
        parts.append(np.linalg.norm(states["vertical"] - other["vertical"], axis=-1))
    if states["attitude"] is not None:
        a, b = states["attitude"], other["attitude"]
        apart = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
        parts.append(2.0 * apart)
    largest: Floats = np.max(parts, axis=0)
    return largest
