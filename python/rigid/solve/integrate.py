"""States by steps with their estimated errors, repeated with shorter steps until accurate."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import intervals, lengths, spread_indices, time_ranges, time_span
from .bodies import Bodies
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
from .problem import LEAST_TOLERANCE, USUAL_ACCURACY
from .request import Request, select_states
from .second_run import (
    HALVINGS,
    HALVINGS_AGAIN,
    RUNGE_KUTTA,
    SERIES,
    SERIES_TOLERANCE,
    coarser_series,
    has_its_order,
    is_damped_stiffly,
    is_refined_alike,
    longest_steps,
    step_ratio,
)
from .separatrix import separatrix_error
from .target import PLAIN, Target

__all__ = ["BY_SERIES", "compute_states", "integrate"]

Floats = NDArray[np.float64]

ONE_DIRECTION = 1e-9
"""Angle (rad) between the rates of a body that turns about one direction: far above rounding."""

BY_SERIES = "by_series"
"""The column of states that says of which bodies :data:`SERIES` made them, if of any."""

SAMPLE = 32
"""Number of bodies of a large call that are integrated again: they fill the lanes of a group."""

ATTEMPTS = 8
"""Largest number of times that the steps of a body are shortened to reach an accuracy."""

FALLS = 2.0
"""Least factor by which an attempt must lower an error for another to be made. Where rounding or
chaos does not keep the error, an attempt lowers it by :data:`MARGIN` at least."""

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

TIGHTENED = 30.0
"""Factor by which each attempt tightens a tolerance: 1.5 times the steps of order 8."""

DIVISION = 8.0
"""Factor by which each attempt divides all steps under strong damping."""


def compute_states(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    *,
    check: bool,
    every: bool = False,
    free: bool = False,
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
            request, steps, accuracy, check=check, every=every, free=free, out=target.exact
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
    free: bool = False,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by steps, and their estimated errors.

    Parameters
    ----------
    request : Request
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None leaves them to the core.
    accuracy : float or None
        Largest error asked for: the steps of a body are shortened until its estimated error is
        smaller.
    check : bool
        Whether errors are estimated; an accuracy requires the estimate.
    every : bool
        Whether the errors of all bodies are estimated, not only of a sample.
    free : bool
        Whether no method was given: the steps of many bodies for an accuracy may follow from the
        errors of a few, and a series integrates the bodies whose error is above the accuracy. The
        series has the tolerance of a request without a method.
    out : mapping, optional
        Arrays for columns, in double precision.
    """
    forced = request.bodies.under_forces()
    if forced.any() and not forced.all():
        return _in_parts(request, steps, accuracy, forced, check=check, every=every, free=free)
    if request.tolerance is not None and free:
        return _by_series(request, accuracy, check=check or accuracy is not None, out=out)
    if request.tolerance is not None and accuracy is not None:
        return _tightened(request, accuracy, out)
    if accuracy is not None and steps is not None:
        return _refined(request, steps, accuracy, free=free, out=out)
    states = request.states(steps, out=out)
    if check or accuracy is not None:
        most = len(request.bodies) if every else SAMPLE
        estimate = _sampled_estimate(request, states, steps, most)
    else:
        estimate = unknown_error(len(request.bodies))
    return states, _with_separatrix(request, states, estimate)


def _with_separatrix(
    request: Request, states: Mapping[str, Any], estimate: ErrorEstimate
) -> ErrorEstimate:
    """The estimate with the phase error from drift beside the separatrix."""
    near = separatrix_error(request.bodies, states, time_ranges(request.times))
    if near is None:
        return estimate
    delay, lost = near
    # Of a body that was not run again no error is known, but that its phase is lost.
    known = ~np.isnan(estimate.error) | np.isfinite(lost)
    error = np.where(known & (delay > 0.0), np.fmax(estimate.error, delay), estimate.error)
    earlier = known & ~(np.abs(estimate.lost_from) < np.abs(lost))
    return ErrorEstimate(error, np.where(earlier, lost, estimate.lost_from))


def _by_series(
    request: Request,
    accuracy: float | None,
    *,
    check: bool = True,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by a series that leaves rounding alone, and their errors.

    Bodies that drag may stop are integrated in equal steps, for an accuracy in shorter ones.
    """
    request = replace(request, method=SERIES, tolerance=SERIES_TOLERANCE)
    states = request.states(None, out=out)
    stops = _may_stop(request.bodies, states["omega"])
    estimate = unknown_error(len(stops))
    if check:
        smooth = replace(request, bodies=replace(request.bodies, may_stop=False))
        shown = USUAL_ACCURACY if accuracy is None else accuracy
        estimate = _series_error(smooth, states, shown, ~stops)
    if stops.any():
        some = np.flatnonzero(stops)
        stopping = replace(request.select(some), method=RUNGE_KUTTA, tolerance=None)
        longest = longest_steps(stopping, RUNGE_KUTTA)
        equal, own = integrate(stopping, longest, accuracy, check=check, every=True)
        states["nanoseconds"] += equal["nanoseconds"]
        _replace_states(states, some, select_states(equal, np.arange(len(some))))
        estimate.write(some, own)
    return states, _with_separatrix(request, states, estimate)


def _series_error(
    request: Request, states: Mapping[str, Any], accuracy: float, which: NDArray[np.bool_]
) -> ErrorEstimate:
    """The errors of states by the series, of bodies for which they are asked.

    A coarser series shows that they are accurate, or else series that are rounded otherwise show
    how accurate they are.
    """
    coarser = coarser_series(request)
    estimate = estimate_error(request, states, None, halvings=HALVINGS_AGAIN, coarser=coarser)
    rough = np.flatnonzero(~(estimate.error <= accuracy) & which)
    if len(rough):
        own = estimate_error(request.select(rough), select_states(states, rough), None)
        estimate.write(rough, own)
    return estimate


def _may_stop(bodies: Bodies, omega: Floats) -> NDArray[np.bool_]:
    """Which bodies drag may stop: those that turn about one direction at all times (n, m, 3).

    The rates of others vanish one after another, and their speed is a series.
    """
    if not bodies.may_stop:
        return np.zeros(len(bodies), dtype=bool)
    rates = np.concatenate([bodies.omega[:, np.newaxis], omega], axis=1)
    fastest = np.take_along_axis(rates, lengths(rates).argmax(axis=1)[:, None, None], axis=1)
    across = lengths(np.cross(rates, fastest)) <= ONE_DIRECTION * lengths(fastest) ** 2
    return np.asarray(across.all(axis=1))


def _has_series(request: Request) -> bool:
    """Whether the bodies can be integrated by a series, in not too many steps."""
    return not request.bodies.may_stop and not is_damped_stiffly(request.bodies, request.method)


def _in_parts(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    forced: NDArray[np.bool_],
    *,
    check: bool,
    every: bool,
    free: bool,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """Bodies under torque and damping, and the other bodies: each part as if it were alone."""
    states: dict[str, Any] = {}
    estimate = unknown_error(len(forced))
    for mine in (np.flatnonzero(forced), np.flatnonzero(~forced)):
        longest = None if steps is None else steps[mine]
        part, own = integrate(
            request.select(mine), longest, accuracy, check=check, every=every, free=free
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
    free: bool,
    out: Mapping[str, NDArray[Any]] | None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by about these steps, or by shorter ones until they are accurate; their errors."""
    order, halvings = order_of(request.method), HALVINGS
    if has_its_order(request.bodies, request.method):
        error = 1.0
        if free and len(steps) >= PILOTED:
            error = _error_of_a_few(request, steps, accuracy) / accuracy
            if error > MULTIPLIED:
                halvings = HALVINGS_AGAIN
        stated = _stated(request, halvings) * error
        # Longer steps err by more than the order says: the next term of the error grows faster.
        shorter = stated ** (1.0 / (order if stated >= 1.0 else order + 1))
        longest = 1.0 if preserves_groups(request.method) else LONGEST
        steps = steps / min(max(shorter, 1.0 / longest), MOST)
    # Steps longer than any interval between output times are cut to the interval.
    steps = np.minimum(steps, intervals(request.times).max(axis=-1, initial=0.0))
    states, estimate = checked_states(request, steps, halvings=halvings, out=out)
    estimate = _with_separatrix(request, states, estimate)
    pending = np.flatnonzero(estimate.error > accuracy)
    if free and len(pending) and _has_series(request):
        series, own = _by_series(request.select(pending), accuracy)
        better = _take_better(states, estimate, pending, series, own)
        states[BY_SERIES] = np.isin(np.arange(len(steps)), pending[better])
        return states, estimate
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
        again = _with_separatrix(some, shorter, again)
        better = _take_better(states, estimate, pending, shorter, again)
        helped = again.error < before / FALLS
        helped |= better & (stiffly | (before >= 1.0))
        helped |= (shortened < MUCH) & (attempt == 1)
        pending = pending[helped & (again.error > accuracy)]
    return states, estimate


def _tightened(
    request: Request, accuracy: float, out: Mapping[str, NDArray[Any]] | None
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by a tolerance, or by smaller ones until they are accurate; their errors."""
    states = request.states(None, out=out)
    estimate = estimate_error(request, states, None)
    pending, tolerance = np.flatnonzero(estimate.error > accuracy), request.tolerance
    assert tolerance is not None
    while len(pending) and tolerance > LEAST_TOLERANCE:
        # The same for all bodies: the bits of none depend on the others.
        tolerance = max(tolerance / TIGHTENED, LEAST_TOLERANCE)
        some = replace(request.select(pending), tolerance=tolerance)
        finer = some.states(None)
        again = estimate_error(some, finer, None)
        states["nanoseconds"] += finer["nanoseconds"]
        better = np.flatnonzero(again.error < estimate.error[pending])
        _replace_states(states, pending[better], select_states(finer, better))
        estimate.write(pending[better], again.of(better))
        pending = pending[better[again.error[better] > accuracy]]
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


def _take_better(
    states: MutableMapping[str, Any],
    estimate: ErrorEstimate,
    bodies: NDArray[np.intp],
    others: MutableMapping[str, Any],
    own: ErrorEstimate,
) -> NDArray[np.bool_]:
    """Replace the states of some bodies where others are better; where they are."""
    better = own.error < estimate.error[bodies]
    states["nanoseconds"] += others["nanoseconds"]
    some = bodies[better]
    _replace_states(states, some, select_states(others, np.flatnonzero(better)))
    estimate.error[some], estimate.lost_from[some] = own.error[better], own.lost_from[better]
    return better


def _replace_states(
    states: MutableMapping[str, Any], bodies: NDArray[np.intp], others: Mapping[str, Any]
) -> None:
    """Replace the states of some bodies."""
    for name, values in others.items():
        if values is not None:
            states[name][bodies] = values
