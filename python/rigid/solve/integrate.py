"""States by steps with their estimated errors, repeated with shorter steps until accurate."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import intervals, lengths, roots
from .bodies import Bodies
from .error_estimate import (
    ErrorEstimate,
    checked_states,
    estimate_error,
    unchecked_states,
    unknown_error,
)
from .methods import FUNCTION, order_of
from .request import Request, replace_states, select_states
from .second_run import (
    HALVINGS,
    HALVINGS_AGAIN,
    RUNGE_KUTTA,
    is_damped_stiffly,
    longest_steps,
)
from .separatrix import with_separatrix
from .tolerances import (
    APART,
    COARSER_TOLERANCE,
    SERIES,
    SERIES_TOLERANCE,
    coarser_run,
    finest_tolerance,
    is_ruled_by_rounding,
)

__all__ = ["BY_SERIES", "integrate"]

Floats = NDArray[np.float64]

ONE_DIRECTION = 1e-9
"""Angle (rad) between the rates of a body that turns about one direction: far above rounding."""

BY_SERIES = "by_series"
"""The column of states that says of which bodies :data:`SERIES` made them, where steps did not."""

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

DIVISION = 8.0
"""Factor by which each attempt divides all steps under strong damping."""


def integrate(
    request: Request,
    steps: Floats | None,
    accuracy: float | None,
    *,
    check: bool,
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
        Largest error: tolerance or steps of a body are made smaller until its estimated error is
        smaller. None for a tolerance or a step that the user chose.
    check : bool
        Whether errors are estimated; without it there is one run.
    free : bool
        Whether no method was given: a series follows where equal steps are not accurate.
    out : mapping, optional
        Arrays for columns, in double precision.
    """
    if request.tolerance is not None and accuracy is not None:
        if free and request.method == SERIES:
            return _by_series(request, accuracy, check=check, out=out)
        return _by_tolerance(request, accuracy, check=check, out=out)
    if accuracy is not None and steps is not None:
        return _by_equal_steps(request, steps, accuracy, check=check, free=free, out=out)
    states = request.states(steps, out=out)
    estimate = (
        estimate_error(request, states, steps) if check else unknown_error(len(request.bodies))
    )
    return states, with_separatrix(request, states, estimate)


def _by_tolerance(
    request: Request,
    accuracy: float,
    *,
    check: bool,
    out: Mapping[str, NDArray[Any]] | None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by the tolerance of the request, or down to rounding; their errors."""
    states: MutableMapping[str, Any] = request.states(None, out=out)
    if not check:
        return states, with_separatrix(request, states, unknown_error(len(request.bodies)))
    estimate = _compared(request, states, accuracy)
    finest = finest_tolerance(request.method)
    assert request.tolerance is not None
    pending = np.flatnonzero(estimate.error > accuracy)
    if len(pending) and request.tolerance > finest:
        finer = replace(request.select(pending), tolerance=finest)
        others = finer.states(None)
        own = _compared(finer, others, accuracy)
        _take_better(states, estimate, pending, others, own)
    return states, estimate


def _by_series(
    request: Request,
    accuracy: float,
    *,
    check: bool = True,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by a series that leaves rounding alone, and their errors.

    Bodies that drag may stop are integrated in equal steps, for an accuracy in shorter ones.
    """
    request = replace(request, method=SERIES, tolerance=SERIES_TOLERANCE)
    states: MutableMapping[str, Any] = request.states(None, out=out)
    stops = _may_stop(request.bodies, states)
    estimate = unknown_error(len(stops))
    if check:
        smooth = replace(request, bodies=replace(request.bodies, may_stop=False))
        estimate = _compared(smooth, states, accuracy, ~stops)
    if stops.any():
        some = np.flatnonzero(stops)
        stopping = replace(request.select(some), method=RUNGE_KUTTA, tolerance=None)
        longest = longest_steps(stopping, RUNGE_KUTTA)
        equal, own = integrate(stopping, longest, accuracy, check=check)
        states["nanoseconds"] += equal["nanoseconds"]
        replace_states(states, some, select_states(equal, np.arange(len(some))))
        estimate.write(some, own)
    return states, with_separatrix(request, states, estimate)


def _compared(
    request: Request,
    states: MutableMapping[str, Any],
    accuracy: float,
    which: NDArray[np.bool_] | None = None,
) -> ErrorEstimate:
    """The errors of states by a tolerance, from a run by a larger one; its time is added to them.

    Where rounding is the error, and the coarser run does not show that ``which`` bodies are
    accurate, several finer runs do. Where a torque or a stop by drag may have corners, one finer
    run does.
    """
    if request.method == FUNCTION or request.bodies.may_stop:
        return with_separatrix(request, states, estimate_error(request, states, None))
    assert request.tolerance is not None
    to_rounding = is_ruled_by_rounding(request)
    tolerance = COARSER_TOLERANCE if to_rounding else APART * request.tolerance
    coarser = coarser_run(request, tolerance)
    states["nanoseconds"] += coarser["nanoseconds"]
    estimate = estimate_error(
        request, states, None, 1.0, HALVINGS_AGAIN, coarser, None if to_rounding else tolerance
    )
    rough = ~(estimate.error <= accuracy)
    rough &= to_rounding if which is None else which
    if rough.any():
        some = np.flatnonzero(rough)
        own = estimate_error(request.select(some), select_states(states, some), None)
        estimate.write(some, own)
    return with_separatrix(request, states, estimate)


def _may_stop(bodies: Bodies, states: Mapping[str, Any]) -> NDArray[np.bool_]:
    """Which bodies drag may stop: those that turn about one direction at all times.

    The rates of others vanish one after another, and their speed is a series.
    """
    if not bodies.may_stop:
        return np.zeros(len(bodies), dtype=bool)
    rates = np.concatenate([bodies.omega[:, np.newaxis], states["omega"]], axis=1)
    fastest = np.take_along_axis(rates, lengths(rates).argmax(axis=1)[:, None, None], axis=1)
    across = lengths(np.cross(rates, fastest)) <= ONE_DIRECTION * lengths(fastest) ** 2
    return np.asarray(across.all(axis=1))


def _by_equal_steps(
    request: Request,
    steps: Floats,
    accuracy: float,
    *,
    check: bool,
    free: bool,
    out: Mapping[str, NDArray[Any]] | None,
) -> tuple[MutableMapping[str, Any], ErrorEstimate]:
    """The states by about these steps; of bodies that are not accurate by shorter ones.

    Without a method a series follows that leaves rounding alone, not shorter steps: chaos or a
    saddle magnifies errors. The speed of a body that drag may stop is no series.
    """
    # Steps longer than any interval between output times are cut to the interval.
    steps = np.minimum(steps, intervals(request.times).max(axis=-1, initial=0.0))
    states: MutableMapping[str, Any]
    if not check:
        states = unchecked_states(request, steps, out=out)
        return states, with_separatrix(request, states, unknown_error(len(steps)))
    states, estimate = checked_states(request, steps, halvings=HALVINGS, out=out)
    estimate = with_separatrix(request, states, estimate)
    pending = np.flatnonzero(estimate.error > accuracy)
    stiffly = is_damped_stiffly(request.bodies, request.method)
    if free and len(pending) and not (stiffly or request.bodies.may_stop):
        others, own = _by_series(request.select(pending), accuracy)
        better = _take_better(states, estimate, pending, others, own)
        states[BY_SERIES] = np.isin(np.arange(len(steps)), pending[better])
        return states, estimate
    for attempt in range(1, ATTEMPTS + 1):
        if not len(pending):
            break
        before = estimate.error[pending]
        if stiffly:
            # What the start forgets at once needs short steps there, not everywhere.
            refinement, shortened = DIVISION**attempt, np.full_like(before, DIVISION)
        else:
            refinement = 1.0
            shortened = _step_reductions(before, accuracy, order_of(request.method))
            steps[pending] /= shortened
        some = request.select(pending)
        shorter, again = checked_states(some, steps[pending], refinement, HALVINGS_AGAIN)
        again = with_separatrix(some, shorter, again)
        better = _take_better(states, estimate, pending, shorter, again)
        helped = again.error < before / FALLS
        helped |= better & (stiffly | (before >= 1.0))
        helped |= (shortened < MUCH) & (attempt == 1)
        pending = pending[helped & (again.error > accuracy)]
    return states, estimate


def _step_reductions(errors: Floats, accuracy: float, order: int) -> Floats:
    """The factors by which steps must shrink for errors to fall well below the accuracy."""
    reductions: Floats = np.clip(roots(MARGIN * errors / accuracy, order), LEAST, MOST)
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
    replace_states(states, some, select_states(others, np.flatnonzero(better)))
    estimate.write(some, own.of(np.flatnonzero(better)))
    return better
