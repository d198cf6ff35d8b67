"""States by steps, with their estimated errors, and with shorter steps until they are accurate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import spread_indices, time_range
from .error_estimate import ErrorEstimate, estimate_error, unknown_error
from .methods import order_of
from .request import Request, select_states
from .separatrix import separatrix_error

__all__ = ["integrate"]

Floats = NDArray[np.float64]

SAMPLE = 32
"""Number of bodies of a large call that are integrated again: the lanes of a group."""

ATTEMPTS = 4
"""Largest number of times that the steps of a body are shortened to reach an accuracy."""


def integrate(
    request: Request, steps: Floats | None, accuracy: float | None, *, check: bool
) -> tuple[dict[str, Any], ErrorEstimate]:
    """The states by steps, and their estimated errors.

    Parameters
    ----------
    request : Request
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None leaves them to the core.
    accuracy : float or None
        Largest error: the steps of a body are shortened until its estimated error is smaller.
    check : bool
        Whether errors are estimated; an accuracy requires the estimate.
    """
    states = request.states(steps)
    if accuracy is not None and steps is not None:
        estimate = _refine(request, states, steps, accuracy)
    elif check or accuracy is not None:
        estimate = _sampled_estimate(request, states)
    else:
        estimate = unknown_error(len(request.batch))
    delay, lost = separatrix_error(request.batch, states, time_range(request.times))
    error = np.where(delay > 0.0, np.fmax(estimate.error, delay), estimate.error)
    earlier = ~(np.abs(estimate.lost_from) < np.abs(lost))
    return states, ErrorEstimate(error, np.where(earlier, lost, estimate.lost_from))


def _sampled_estimate(request: Request, states: dict[str, Any]) -> ErrorEstimate:
    """The errors of all bodies, of a large call from a sample of them."""
    count = len(request.batch)
    sample = spread_indices(count, SAMPLE)
    seen = estimate_error(request.select(sample), select_states(states, sample))
    if count <= SAMPLE:
        return seen
    if np.any(seen.error >= 1.0):
        # Where some are lost, each body needs an estimate of its own.
        return estimate_error(request, states)
    known = seen.error[~np.isnan(seen.error)]
    error = np.full(count, known.max() if len(known) else np.nan)
    lost_from = np.full(count, seen.lost_from.min())
    error[sample], lost_from[sample] = seen.error, seen.lost_from
    return ErrorEstimate(error, lost_from)


def _refine(
    request: Request, states: dict[str, Any], steps: Floats, accuracy: float
) -> ErrorEstimate:
    """Shorten the steps of inaccurate bodies, and write their better states over the others."""
    estimate = estimate_error(request, states)
    steps, order = steps.copy(), order_of(request.method)
    pending = np.flatnonzero(estimate.error > accuracy)
    for _ in range(ATTEMPTS):
        if not len(pending):
            break
        steps[pending] /= [
            _step_reduction(float(estimate.error[body]), accuracy, order) for body in pending
        ]
        some = request.select(pending)
        shorter = some.states(steps[pending])
        again = estimate_error(some, shorter)
        # Shorter steps do not help where rounding or chaos dominates.
        better = again.error < estimate.error[pending]
        states["nanoseconds"] += shorter["nanoseconds"]
        _replace_states(states, pending[better], select_states(shorter, np.flatnonzero(better)))
        estimate.error[pending[better]] = again.error[better]
        estimate.lost_from[pending[better]] = again.lost_from[better]
        pending = pending[better & (again.error > accuracy)]
    return estimate


def _step_reduction(error: float, accuracy: float, order: int) -> float:
    """The factor by which steps must shrink for an error to fall below the accuracy."""
    return float(np.clip((2.0 * error / accuracy) ** (1.0 / order), 1.05, 8.0))


def _replace_states(
    states: dict[str, Any], bodies: NDArray[np.intp], others: Mapping[str, Any]
) -> None:
    """Write the states of some bodies over."""
    for name, values in others.items():
        if values is not None:
            states[name][bodies] = values
