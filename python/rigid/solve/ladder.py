"""Adaptive steps of a named series or under a function, by smaller tolerances until accurate.

Each rung is two runs: one by a tolerance, and one from the start rounded otherwise by a tolerance
:data:`APART` times as large, or under a function by a smaller one. Where the error of a rung is
above the accuracy the next rung has a smaller tolerance. Rungs end where the error does not fall:
rounding or chaos is the error.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .error_estimate import ErrorEstimate, estimate_error, unknown_error
from .methods import FUNCTION, TO_ROUNDING
from .problem import LEAST_TOLERANCE
from .request import Request, replace_states, select_states
from .second_run import is_ruled_by_rounding, rounded_start
from .separatrix import with_separatrix

__all__ = ["climb", "first_tolerance"]

Floats = NDArray[np.float64]

APART = 900.0
"""Factor between the tolerances of the two runs of a rung.

Where the motion magnifies errors, the errors of both runs have signs and sizes at random, the
coarser one APART times as large. The runs are then nearer to each other than half of the finer
error in about ``1 / (2.5 APART)`` of all cases. On 2000 eccentric orbits 0.5 % erred by more than
twice the stated error with a factor of 30."""

SHARE = 2e-4
"""First tolerance over the accuracy. The tolerance of the coarser run is a fifth of the accuracy:
the stated error is below the accuracy unless the motion magnifies errors three times."""

SHARE_UNDER_FUNCTION = 0.01
"""The same under a function: some steps err, and three times the distance is stated."""

LARGEST = 1e-6
"""Largest first tolerance: the coarser run has nearly 1e-3, where orders just show."""

RUNG = 30.0
"""Factor between the tolerances of two rungs. Steps of order 16 differ by 1.2 times, of order 8 by
1.5 times."""

RUNGS = 3
"""Most rungs after the first: three divisions by ``RUNG**3`` go from the largest tolerance to the
finest."""

FALLS = 2.0
"""Least factor by which a rung must lower an error for another to be made."""

MARGIN = 4.0
"""Aim of a rung: the accuracy over this. Another rung costs more than a smaller tolerance."""

FINEST = 1e-16
"""Least tolerance of a series: there is nothing but rounding below it."""


def first_tolerance(accuracy: float, method: str) -> float:
    """The tolerance of the first rung."""
    if method == FUNCTION:
        return max(SHARE_UNDER_FUNCTION * accuracy, LEAST_TOLERANCE)
    return min(max(SHARE * accuracy, FINEST), LARGEST)


def _finest(method: str) -> float:
    return LEAST_TOLERANCE if method == FUNCTION else FINEST


def climb(
    request: Request,
    accuracy: float,
    *,
    check: bool,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by the tolerance of the request, or by smaller ones; their errors.

    Parameters
    ----------
    request : Request
    accuracy : float
        Largest error asked for.
    check : bool
        Whether errors are estimated; without it there is one run.
    out : mapping, optional
        Arrays for columns, in double precision.
    """
    states: MutableMapping[str, Any] = request.states(None, out=out)
    if not check:
        unknown = unknown_error(len(request.bodies))
        return states, with_separatrix(request, states, unknown)
    estimate = _compared(request, states)
    pending = np.flatnonzero(estimate.error > accuracy)
    tolerances = np.full(len(pending), request.tolerance)
    for _ in range(RUNGS):
        if not len(pending):
            break
        before = estimate.error[pending]
        tolerances = _tightened(tolerances, before, accuracy, _finest(request.method))
        for tolerance in np.unique(tolerances):
            mine = pending[tolerances == tolerance]
            rung = replace(request.select(mine), tolerance=float(tolerance))
            finer = rung.states(None)
            own = _compared(rung, finer)
            states["nanoseconds"] += finer["nanoseconds"]
            coarse = estimate.error[mine]
            better = np.flatnonzero(own.error <= coarse)
            replace_states(states, mine[better], select_states(finer, better))
            estimate.write(mine[better], own.of(better))
            # Where errors do not fall they are at random, and the smaller one is luck.
            lucky = np.flatnonzero(own.error >= coarse / FALLS)
            estimate.error[mine[lucky]] = np.maximum(own.error, coarse)[lucky]
        now = estimate.error[pending]
        falls = (now < before / FALLS) | (before >= 1.0)
        again = (now > accuracy) & falls & (tolerances > _finest(request.method))
        pending, tolerances = pending[again], tolerances[again]
    return states, estimate


def _compared(request: Request, states: MutableMapping[str, Any]) -> ErrorEstimate:
    """The errors of states, by a run of a larger tolerance; its time is added to the states.

    Where rounding is the error, several finer runs show it; where a torque or a stop by drag may
    have corners, one finer run does.
    """
    assert request.tolerance is not None
    has_corners = request.method == FUNCTION or request.bodies.may_stop
    if has_corners or is_ruled_by_rounding(request):
        return with_separatrix(request, states, estimate_error(request, states, None))
    tolerance = APART * request.tolerance
    # Two series of high order may err alike: their errors do not fall evenly with the tolerance.
    bodies = rounded_start(request.bodies)
    coarser = replace(request, bodies=bodies, method=TO_ROUNDING, tolerance=tolerance)
    other = coarser.states(None)
    states["nanoseconds"] += other["nanoseconds"]
    estimate = estimate_error(request, states, None, coarser=other, coarser_tolerance=tolerance)
    return with_separatrix(request, states, estimate)


def _tightened(tolerances: Floats, errors: Floats, accuracy: float, finest: float) -> Floats:
    """Tolerances divided once, twice or three times by the factor of a rung."""
    falls = MARGIN * errors / accuracy
    times = 1.0 + (falls > RUNG) + (falls > RUNG * RUNG)
    smaller: Floats = np.maximum(tolerances / RUNG**times, finest)
    return smaller
