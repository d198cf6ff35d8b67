"""The error of a run, estimated from a second run with shorter steps.

Steps that are shorter by ``2**(2/p)``, and at least by a sixth, leave a quarter or less of the
truncation error of a method of order ``p``: the difference of the two runs is nearly all of it.
Where bodies are integrated again they are shorter by ``2**(4/p)``. Where rounding dominates, or
chaos amplifies it, the two runs differ by about as much as each of them errs. In both cases three
times the difference is stated: nearly always more than the error, and seldom much more. The
extrapolation is Richardson's (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*,
§ II.4).

For an accuracy the finer of the two runs is returned. It errs by a third of the difference, and
twice the difference is stated; three times where the second run errs by a sixteenth, because there
the motion multiplies errors.

The second run divides the steps of the first: between any two output times it takes at least one
step more. The run that is not returned begins at a start that is rounded otherwise. The runs are
compared at every output time.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import Range, time_range, time_span
from .bodies import Bodies
from .request import Request, select_states
from .second_run import (
    HALVINGS,
    is_refined_alike,
    second_run,
    step_ratio,
)
from .status import Status
from .tolerances import is_ruled_by_rounding

__all__ = [
    "ErrorEstimate",
    "checked_states",
    "closed_form_error",
    "estimate_error",
    "known_rates",
    "safety_of_finer",
    "unchecked_states",
    "unknown_error",
]

Floats = NDArray[np.float64]

SAFETY = 3.0
"""Factor from the difference of two runs to the stated error."""

SAFETY_OF_FINER = 2.0
"""Factor for the finer of two runs, if its error is a quarter of the error of the other."""

BETWEEN = 64
"""Most times besides output times at which runs that may differ by whole turns are compared."""


@dataclass(slots=True, eq=False)
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

    def of(self, bodies: NDArray[np.intp]) -> ErrorEstimate:
        """A copy of the estimate of some bodies."""
        return ErrorEstimate(self.error[bodies], self.lost_from[bodies])

    def write(self, bodies: NDArray[np.intp], other: ErrorEstimate) -> None:
        """Replace the estimate of some bodies."""
        self.error[bodies], self.lost_from[bodies] = other.error, other.lost_from


def unknown_error(count: int) -> ErrorEstimate:
    """The estimate of bodies whose error is unknown."""
    return ErrorEstimate(np.full(count, np.nan), np.full(count, np.nan))


def closed_form_error(bodies: Bodies, times: Floats, omega: NDArray[Any]) -> ErrorEstimate:
    """The error of a closed form: 1e-15 for each radian turned, or its growth at a saddle.

    The rates ``omega`` have the shape (n, m, 3).
    """
    return ErrorEstimate(*_core.errors_of_closed_forms(bodies, times, omega))


def safety_of_finer(halvings: float) -> float:
    """Factor from the difference of two runs to the stated error of the finer run."""
    return SAFETY_OF_FINER if halvings == HALVINGS else SAFETY


def checked_states(
    request: Request,
    steps: Floats,
    refinement: float = 1.0,
    halvings: float = HALVINGS,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states of the second run, whose steps are shorter than these (s), and their errors.

    Where the second run differs in more than shorter steps, the states of the first run are
    returned.
    """
    if not is_refined_alike(request.bodies, request.method):
        states = request.states(steps, refinement, out=out)
        return states, estimate_error(request, states, steps, refinement, halvings)
    ratio = step_ratio(request.bodies, request.method, halvings)
    otherwise = replace(request, bodies=request.bodies.rounded_otherwise())
    coarser = otherwise.states(steps, refinement)
    states = request.states(steps, refinement * ratio, out=out)
    return states, estimate_error(request, states, steps, refinement, halvings, coarser)


def unchecked_states(
    request: Request, steps: Floats, out: Mapping[str, NDArray[Any]] | None = None
) -> MutableMapping[str, Any]:
    """The states that :func:`checked_states` returns, without their errors."""
    refined = is_refined_alike(request.bodies, request.method)
    ratio = step_ratio(request.bodies, request.method) if refined else 1.0
    return request.states(steps, ratio, out=out)


def estimate_error(
    request: Request,
    states: Mapping[str, Any],
    steps: Floats | None,
    refinement: float = 1.0,
    halvings: float = HALVINGS,
    coarser: Mapping[str, Any] | None = None,
    coarser_tolerance: float | None = None,
) -> ErrorEstimate:
    """The error of states from a second run, which halves the truncation error so many times.

    The states were made with these longest steps (s) and this :meth:`refinement <Request.states>`;
    or ``coarser`` was, and the states belong to the second run. A coarser run by a tolerance names
    it.
    """
    ended = states["status"] != Status.STEP_LIMIT
    if not ended.all():
        estimate = unknown_error(len(ended))
        some = np.flatnonzero(ended)
        if len(some):
            longest = None if steps is None else steps[some]
            parts = request.select(some), select_states(states, some), longest
            other = None if coarser is None else select_states(coarser, some)
            own = estimate_error(*parts, refinement, halvings, other, coarser_tolerance)
            estimate.write(some, own)
        return estimate
    if not np.count_nonzero(time_span(request.times)):
        return ErrorEstimate(np.zeros(len(ended)), np.full(len(ended), np.inf))
    taken = (states if coarser is None else coarser)["steps"]
    if coarser is not None:
        others, safety = [coarser], safety_of_finer(halvings)
    else:
        roundings = _core.ROUNDINGS if is_ruled_by_rounding(request) else 1
        others, safety = [], SAFETY
        for rounding in range(roundings):
            again = second_run(request, steps, refinement, taken, halvings, rounding)
            others.append(again)
    error, lost_from, looks = _core.estimate(
        request, states, others, taken, safety, coarser_tolerance
    )
    estimate = ErrorEstimate(error, lost_from)
    if np.count_nonzero(looks):
        _count_turns(request, taken, looks, estimate)
    return estimate


def known_rates(bodies: Bodies, reached: Range, met: Floats) -> Floats:
    """Bounds of the rates, under a function at least the rates met: it may have no bound."""
    rates = bodies.fastest_rates(reached)
    is_called = bodies.forces is not None and bodies.forces.calls
    return np.fmax(rates, met) if is_called else rates


def _count_turns(
    request: Request, taken: NDArray[np.uint64], looks: Floats, estimate: ErrorEstimate
) -> None:
    """Compare runs that may differ by whole turns at more times; replaces smaller errors.

    The steps of a run are equal between output times. So that no bit of its states depends on the
    estimate, a pair of further runs is compared. ``looks`` is how many more times each body needs.
    """
    some = np.flatnonzero(looks)
    if request.times.ndim == 2:
        for body in np.split(some, len(some)):
            one, own = request.select(body), estimate.of(body)
            _count_turns(replace(one, times=one.times[0]), taken[body], looks[body], own)
            estimate.write(body, own)
        return
    most = int(min(looks[some].max(), BETWEEN))
    between = np.linspace(*time_range(request.times), most + 2)[1:-1]
    dense = replace(request.select(some), times=np.union1d(request.times, between))
    steps = time_span(request.times) / taken[some]
    states = dense.states(steps)
    other = second_run(dense, steps, 1.0, taken[some].astype(np.float64))
    pair = dense, states, [other]
    error, lost_from, _ = _core.estimate(*pair, taken[some], SAFETY, alone=True)
    larger = error > estimate.error[some]
    estimate.write(some[larger], ErrorEstimate(error[larger], lost_from[larger]))
