"""States by steps with their estimated errors, repeated with shorter steps until accurate."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import intervals, spread_indices, time_ranges, time_span
from .error_estimate import (
    SAFETY,
    ErrorEstimate,
    checked_states,
    closed_form_error,
    distances,
    estimate_error,
    safety_of_finer,
    unknown_error,
)
from .methods import EXACT, order_of, preserves_groups
from .request import Request, select_states
from .second_run import (
    HALVINGS,
    HALVINGS_AGAIN,
    has_its_order,
    is_damped_stiffly,
    is_refined_alike,
    step_ratio,
)
from .separatrix import separatrix_error
from .target import PLAIN, Target

__all__ = ["compute_states", "integrate"]

Floats = NDArray[np.float64]

SAMPLE = 32
"""Number of bodies of a large call that are integrated again: they fill the lanes of a group."""

ATTEMPTS = 4
"""Largest number of times that the steps of a body are shortened to reach an accuracy."""

MARGIN = 4.0
"""Aim of shorter steps: the accuracy over this. Another attempt costs more than these steps."""

LEAST, MOST = 1.2, 8.0
"""Least and largest factor by which an attempt shortens the steps."""

MUCH = 2.0
"""Steps shorter by a smaller factor may have larger errors: errors of few steps do not fall
evenly."""

MULTIPLIED = 5.0
"""Errors this many times larger than in the model are multiplied by the motion."""

PILOTED = 512
"""Number of bodies from which on a few are integrated first, to choose the steps of all."""

SPARED = 1.2
"""Factor from the error of the bodies integrated first to the error that steps are made for.

Others may err more, and the errors of longer steps do not fall evenly. Of 150 clouds of 512 alike
tops a tenth of the bodies or more were integrated again in 38 at 1.05, in 18 at 1.1, in 5 at 1.2
and in 3 at 1.35; 1.2 took the least time."""

LONGEST = 1.5
"""Largest factor by which steps are longer than in the model, whatever the first bodies show.

The steps of methods that preserve the group are no longer: a step of Moser and Veselov has no
solution beyond an angle."""

LOST = 0.1
"""Distance of two runs that shows no order: the motion is lost in one of them."""

AGAIN = 1.1
"""Work of another attempt over the work of the first with the same steps: 1 + 2**(4/8) over 1 +
1.2."""

DIVISION = 8.0
"""Factor by which each attempt divides all steps under strong damping."""


def compute_states(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    *,
    check: bool,
    every: bool = False,
    pilot: bool = False,
    target: Target = PLAIN,
) -> tuple[MutableMapping[str, Any], ErrorEstimate | _core.States]:
    """The states in closed form or by steps, their work (J), and their estimated errors.

    The arguments are as for :func:`integrate`; ``target`` holds the states. The states are their
    own estimate where the core knows the errors, and that all bodies have arrived.
    """
    bodies = request.bodies
    states: MutableMapping[str, Any]
    if request.method == EXACT:
        exact = request.states(None, out=target.given or None, single=target.single)
        if exact.worst is not None:
            return exact, exact
        bodies.note_rates(exact.pop("fastest_rate"))
        states, estimate = exact, closed_form_error(bodies, request.times, exact["omega"])
    else:
        states, estimate = integrate(
            request, steps, accuracy, check=check, every=every, pilot=pilot, out=target.exact
        )
    if states["work"] is not None:
        np.ldexp(states["work"], bodies.scale_exponent[:, np.newaxis], out=states["work"])
    return states, estimate


def integrate(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    *,
    check: bool,
    every: bool = False,
    pilot: bool = False,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
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
    every : bool
        Whether the errors of all bodies are estimated, not only of a sample.
    pilot : bool
        Whether the steps of many bodies for an accuracy may follow from the errors of a few.
    out : mapping, optional
        Arrays for columns, in double precision.
    """
    forced = request.bodies.under_forces()
    if forced.any() and not forced.all():
        return _in_parts(request, steps, accuracy, forced, check=check, every=every, pilot=pilot)
    if accuracy is not None and steps is not None:
        states, estimate = _refined(request, steps, accuracy, pilot=pilot, out=out)
    else:
        states = request.states(steps, out=out)
        if check or accuracy is not None:
            most = len(request.bodies) if every else SAMPLE
            estimate = _sampled_estimate(request, states, steps, most)
        else:
            estimate = unknown_error(len(request.bodies))
    near = separatrix_error(request.bodies, states, time_ranges(request.times))
    if near is None:
        return states, estimate
    delay, lost = near
    # Of a body that was not run again no error is known, but that its phase is lost.
    known = ~np.isnan(estimate.error) | np.isfinite(lost)
    error = np.where(known & (delay > 0.0), np.fmax(estimate.error, delay), estimate.error)
    earlier = known & ~(np.abs(estimate.lost_from) < np.abs(lost))
    return states, ErrorEstimate(error, np.where(earlier, lost, estimate.lost_from))


def _in_parts(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    forced: NDArray[np.bool_],
    *,
    check: bool,
    every: bool,
    pilot: bool,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """Bodies under torque and damping, and the other bodies: each part as if it were alone."""
    states: dict[str, Any] = {}
    estimate = unknown_error(len(forced))
    for mine in (np.flatnonzero(forced), np.flatnonzero(~forced)):
        longest = None if steps is None else steps[mine]
        part, own = integrate(
            request.select(mine), longest, accuracy, check=check, every=every, pilot=pilot
        )
        estimate.write(mine, own)
        states["nanoseconds"] = states.get("nanoseconds", 0) + part.pop("nanoseconds")
        for name, values in part.items():
            if values is not None:
                column = states.setdefault(
                    name, np.zeros((len(forced), *values.shape[1:]), values.dtype)
                )
                column[mine] = values
            else:
                states.setdefault(name, None)
    return states, estimate


def _sampled_estimate(
    request: Request, states: MutableMapping[str, Any], steps: Floats | None, most: int
) -> ErrorEstimate:
    """The errors of all bodies; for a large call of a sample, unless a body of it is lost."""
    count = len(request.bodies)
    if count <= most:
        return estimate_error(request, states, steps)
    sample = spread_indices(count, most)
    longest = None if steps is None else steps[sample]
    seen = estimate_error(request.select(sample), select_states(states, sample), longest)
    if np.any(seen.error >= 1.0):
        return estimate_error(request, states, steps)
    estimate = unknown_error(count)
    estimate.write(sample, seen)
    return estimate


def _refined(
    request: Request,
    steps: Floats,
    accuracy: float,
    *,
    pilot: bool,
    out: Mapping[str, NDArray[Any]] | None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by about these steps, or by shorter ones until they are accurate; their errors."""
    order, halvings = order_of(request.method), HALVINGS
    if has_its_order(request.bodies, request.method):
        error = 1.0
        if pilot and len(steps) >= PILOTED:
            error = _error_of_a_few(request, steps, accuracy) / accuracy
            if error > MULTIPLIED:
                halvings = HALVINGS_AGAIN
        shorter = (_stated(request, halvings) * error) ** (1.0 / order)
        longest = 1.0 if preserves_groups(request.method) else LONGEST
        steps = steps / min(max(shorter, 1.0 / longest), MOST)
    # Steps longer than any interval between output times are cut to the interval.
    steps = np.minimum(steps, intervals(request.times).max(axis=-1, initial=0.0))
    states, estimate = checked_states(request, steps, halvings=halvings, out=out)
    pending = np.flatnonzero(estimate.error > accuracy)
    stiffly = is_damped_stiffly(request.bodies, request.method)
    for attempt in range(1, ATTEMPTS + 1):
        if not len(pending):
            break
        before = estimate.error[pending]
        if stiffly:
            # What the start forgets at once needs short steps there, not everywhere.
            refinement, shortened = DIVISION**attempt, np.full_like(before, DIVISION)
        else:
            refinement, shortened = 1.0, _step_reductions(before, accuracy, order)
            steps[pending] /= shortened
        some = request.select(pending)
        shorter, again = checked_states(some, steps[pending], refinement, HALVINGS_AGAIN)
        better = again.error < before
        states["nanoseconds"] += shorter["nanoseconds"]
        _replace_states(states, pending[better], select_states(shorter, np.flatnonzero(better)))
        estimate.error[pending[better]] = again.error[better]
        estimate.lost_from[pending[better]] = again.lost_from[better]
        # Where half of the digits are still missing, rounding or chaos keeps them.
        helped = again.error < np.sqrt(before * accuracy)
        helped |= better & (stiffly | (before >= 1.0))
        helped |= (shortened < MUCH) & (attempt == 1)
        pending = pending[helped & (again.error > accuracy)]
    return states, estimate


def _stated(request: Request, halvings: float) -> float:
    """Ratio of the error stated for the returned run to the error of the first run."""
    if not is_refined_alike(request.bodies, request.method):
        return SAFETY
    left: float = 2.0**-halvings
    return safety_of_finer(halvings) * (1.0 - left)


def _error_of_a_few(request: Request, steps: Floats, accuracy: float) -> float:
    """The error, among a few bodies with these steps, for which the steps of all are best made.

    Steps with which one of the few is just accurate are compared: bodies with larger errors need
    another attempt. The few are spread over the angles that the bodies turn. The error of the
    model, the accuracy, is taken where an eighth of the few or more are lost: they show nothing
    about others.
    """
    angles = request.bodies.fastest_rates(time_ranges(request.times)) * time_span(request.times)
    few = np.argsort(angles, kind="stable")[spread_indices(len(steps), SAMPLE)]
    some, ratio = request.select(few), step_ratio(request.bodies, request.method)
    apart = distances(some.states(steps[few]), some.states(steps[few], ratio))
    errors = apart.max(axis=1, initial=0.0) / (1.0 - ratio ** -order_of(request.method))
    known = np.isfinite(errors) & (apart.max(axis=1, initial=0.0) < LOST)
    if np.count_nonzero(known) <= 0.875 * len(few):
        return accuracy
    ascending = np.sort(errors[known]).tolist()
    power = 1.0 / order_of(request.method)
    again = [AGAIN * (MARGIN * error) ** power for error in ascending]
    works = [
        len(ascending) * (SPARED * error) ** power + sum(again[number + 1 :])
        for number, error in enumerate(ascending)
    ]
    return SPARED * float(ascending[works.index(min(works))])


def _step_reductions(errors: Floats, accuracy: float, order: int) -> Floats:
    """The factors by which steps must shrink for errors to fall well below the accuracy."""
    # Powers of single floats: powers of an array have other bits on other processors.
    factors = [(MARGIN * error / accuracy) ** (1.0 / order) for error in errors.tolist()]
    reductions: Floats = np.clip(np.array(factors), LEAST, MOST)
    return reductions


def _replace_states(
    states: MutableMapping[str, Any], bodies: NDArray[np.intp], others: Mapping[str, Any]
) -> None:
    """Replace the states of some bodies."""
    for name, values in others.items():
        if values is not None:
            states[name][bodies] = values
