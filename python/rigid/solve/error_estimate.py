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
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Range, intervals, lengths, time_range, time_ranges, time_span
from .bodies import Bodies
from .cost_model import ROUNDING, phase_error
from .request import Request, select_states
from .rounding import REST, common_rounding, rounding_of_damping
from .saddle import RateSizes, departure, homoclinic, separatrices
from .second_run import (
    HALVINGS,
    ROUNDINGS,
    is_damped_stiffly,
    is_refined_alike,
    is_ruled_by_rounding,
    rounded_start,
    second_run,
    step_ratio,
)
from .status import Status

__all__ = [
    "ErrorEstimate",
    "checked_states",
    "closed_form_error",
    "distances",
    "estimate_error",
    "known_rates",
    "safety_of_finer",
    "unknown_error",
]

Floats = NDArray[np.float64]

SAFETY = 3.0
"""Factor from the difference of two runs to the stated error."""

SAFETY_OF_FINER = 2.0
"""Factor for the finer of two runs, if its error is a quarter of the error of the other."""

RINGING = "midpoint"
"""The method whose rates change sign at each step and hardly decay under strong damping: it is not
L-stable."""

PART_OF_A_TURN = 0.5
"""Phase (rad) by which two runs may part between two compared times; a whole turn would not show"""

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


@np.errstate(all="ignore")
def closed_form_error(bodies: Bodies, times: Floats, omega: Floats) -> ErrorEstimate:
    """The error of a closed form: 1e-15 for each radian turned, or its growth at a saddle.

    A top beside the separatrix of its nutation magnifies rounding by ``exp(exponent t)``, at each
    passage of the saddle at most by one over the relative distance from the separatrix. Rounding
    of the attitude moves a top that hangs all but still as much as it would move any: of its
    small rates ``omega``, of shape (n, m, 3), it is a larger share.
    """
    reached = time_ranges(times)
    first, last = reached
    rates = bodies.fastest_rates(reached)
    error = ROUNDING * (1.0 + rates * (last - first))
    since = 1.0 / (ROUNDING * rates)
    if bodies.forces is None and bodies.weight.any():
        scale = _fastest_or_swing(bodies, rates)
        rows = omega.reshape(len(bodies), omega.shape[-2], 3)
        fastest = lengths(rows).max(axis=1, initial=0.0)
        moves = (fastest > REST * scale) & bodies.weight.any(axis=1)
        share = np.where(moves, scale / fastest, 1.0)
        distance, exponent = separatrices(bodies)
        saddle = exponent * np.maximum(-first, last)
        factor = np.fmin(np.exp(saddle), (1.0 + saddle) / distance)
        factor *= np.where(moves, np.fmax(exponent / fastest, 1.0), 1.0)
        error = ROUNDING * np.maximum(share + rates * (last - first), factor)
        by_saddle = np.fmax(-np.log(ROUNDING), distance / ROUNDING - 1.0) / exponent
        since = np.fmin(since, by_saddle)
    lost = np.where(error >= 1.0, np.fmin(since, np.maximum(-first, last)), np.inf)
    backward = np.greater(-first, last)
    return ErrorEstimate(error, np.where(backward & (lost < np.inf), -lost, lost))


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
    otherwise = replace(request, bodies=rounded_start(request.bodies))
    coarser = otherwise.states(steps, refinement)
    states = request.states(steps, refinement * ratio, out=out)
    return states, estimate_error(request, states, steps, refinement, halvings, coarser)


@np.errstate(all="ignore")
def estimate_error(
    request: Request,
    states: Mapping[str, Any],
    steps: Floats | None,
    refinement: float = 1.0,
    halvings: float = HALVINGS,
    coarser: Mapping[str, Any] | None = None,
) -> ErrorEstimate:
    """The error of states from a second run, which halves the truncation error so many times.

    The states were made with these longest steps (s) and this :meth:`refinement <Request.states>`;
    or ``coarser`` was, and the states belong to the second run.
    """
    bodies, times, method = request.bodies, request.times, request.method
    ended = states["status"] != Status.STEP_LIMIT
    if not ended.all():
        estimate = unknown_error(len(bodies))
        some = np.flatnonzero(ended)
        if len(some):
            longest = None if steps is None else steps[some]
            parts = request.select(some), select_states(states, some), longest
            other = None if coarser is None else select_states(coarser, some)
            estimate.write(some, estimate_error(*parts, refinement, halvings, other))
        return estimate
    span = time_span(times)
    if not np.any(span) or not times.shape[-1]:
        return ErrorEstimate(np.zeros(len(bodies)), np.full(len(bodies), np.inf))
    taken = (states if coarser is None else coarser)["steps"].astype(np.float64)
    fastest = lengths(states["omega"]).max(axis=1)
    rates = known_rates(bodies, time_ranges(times), fastest)
    scale = _fastest_or_swing(bodies, rates)
    floor = common_rounding(request, states, rates, scale, span)
    if coarser is None:
        error = np.zeros(())
        for rounding in range(ROUNDINGS if is_ruled_by_rounding(request) else 1):
            again = second_run(request, steps, refinement, taken, halvings, rounding)
            apart = _stated_distances(bodies, states, again, rates, times, SAFETY)
            error = np.maximum(error, np.where(np.isnan(apart), np.inf, apart))
    else:
        error = _stated_distances(bodies, states, coarser, rates, times, safety_of_finer(halvings))
    sizes = RateSizes(fastest, REST * scale, scale)
    error += (
        floor[:, None]
        + departure(bodies, times, sizes)
        + homoclinic(bodies, times, sizes, states["energy_drift"])
    )
    if bodies.forces is not None:
        error += rounding_of_damping(bodies, states["omega"], times)
        if method == RINGING:
            error += _ringing(bodies, states, times)
    # An error that is not a number is unknown.
    error = np.where(np.isfinite(error), error, np.inf)
    if is_damped_stiffly(bodies, method) and request.tolerance is None:
        # Damping can stop a body within a step: both runs lose the angle it turned meanwhile.
        error[rates * span > np.pi * taken] = np.inf
    # Nothing moves in no time.
    error[np.broadcast_to(span, len(error)) == 0.0] = 0.0
    estimate = ErrorEstimate(error.max(axis=1), _lost_from(error, times))
    _count_turns(request, taken, estimate)
    return estimate


def _stated_distances(
    bodies: Bodies,
    states: Mapping[str, Any],
    again: Mapping[str, Any],
    rates: Floats,
    times: Floats,
    safety: float,
) -> Floats:
    """The errors stated for the distance of the states of two runs, with their work, (n, m)."""
    scale = _fastest_or_swing(bodies, rates)
    rest = REST * scale
    apart = safety * distances(states, again, rest, scale)
    # Relative to the rates of the runs: relative to the true ones it may be as much larger.
    of_rates = safety * _rate_distances(states, again, rest, scale)
    apart = np.where(of_rates < 1.0, np.maximum(apart, of_rates / (1.0 - of_rates)), apart)
    lost = np.flatnonzero(~np.all(apart < 1.0, axis=1))
    if len(lost):
        pair = states["omega"][lost], again["omega"][lost]
        own = np.broadcast_to(times, apart.shape)[lost]
        apart[lost] = _before_the_loss(apart[lost], pair, own, rest[lost], scale[lost], safety)
    if states["work"] is None:
        return apart
    # The fastest rate is reached about the axis of the least moment.
    energy = 0.5 * bodies.moments.min(axis=1) * rates**2
    work = np.abs(states["work"] - again["work"]) / np.where(energy > 0.0, energy, 1.0)[:, None]
    largest: Floats = np.maximum(apart, safety * work)
    return largest


def _before_the_loss(
    error: Floats,
    pair: tuple[Floats, Floats],
    times: Floats,
    rest: Floats,
    scale: Floats,
    safety: float,
) -> Floats:
    """Errors of lost bodies, before the loss relative to the rates until then; shape (n, m).

    Later rates belong to a wrong motion and may be larger than the true ones ever are.
    """
    # Each round but the last loses one time more, so there are at most as many rounds as times.
    while True:
        lost = ~(error < 1.0)
        since = np.where(lost, np.abs(times), np.inf).min(axis=1, keepdims=True)
        before = np.abs(times) < since
        one, other = ({"omega": np.where(before[..., None], rates, 0.0)} for rates in pair)
        nearer = np.where(before, safety * _rate_distances(one, other, rest, scale), 0.0)
        error = np.maximum(error, nearer)
        if not np.any(nearer >= 1.0):
            return error


def known_rates(bodies: Bodies, reached: Range, met: Floats) -> Floats:
    """Bounds of the rates, under a function at least the rates met: it may have no bound."""
    rates = bodies.fastest_rates(reached)
    is_called = bodies.forces is not None and bodies.forces.calls
    return np.fmax(rates, met) if is_called else rates


def _fastest_or_swing(bodies: Bodies, rates: Floats) -> Floats:
    """The larger of the fastest possible rate of a body and the rate of its swing."""
    swing = np.sqrt(lengths(bodies.weight) / bodies.moments.min(axis=1))
    larger: Floats = np.maximum(rates, swing)
    return larger


def _ringing(bodies: Bodies, states: Mapping[str, Any], times: Floats) -> Floats:
    """The remaining rates of the start after damping should have ended them, shape (n, m).

    After an even number of steps it has its first sign again: two runs may agree in it.
    """
    assert bodies.forces is not None
    rate = bodies.forces.damping_rates(bodies.moments)[:, np.newaxis]
    span, steps = np.reshape(time_span(times), (-1, 1)), states["steps"][:, None]
    taken = steps * np.maximum(times, 0.0) / span
    damped = 0.5 * rate * span / steps
    left = np.where(damped > 1.0, ((damped - 1.0) / (damped + 1.0)) ** taken, 0.0)
    size = lengths(states["omega"]).max(axis=1)
    start = lengths(bodies.omega)
    ratio: Floats = np.where(size > 0.0, start / size, 0.0)
    # At the start itself nothing should have ended.
    rings: Floats = np.where(times > 0.0, left * ratio[:, None], 0.0)
    return rings


def _count_turns(request: Request, taken: Floats, estimate: ErrorEstimate) -> None:
    """Compare runs that may differ by whole turns at more times; replaces smaller errors.

    The steps of a run are equal between output times. So that no bit of its states depends on the
    estimate, a pair of further runs is compared.
    """
    gaps = intervals(request.times)
    phase = phase_error(request.bodies, request.method, request.times, taken, request.tolerance)
    parting = phase * gaps.max(axis=-1) / gaps.sum(axis=-1)
    some = np.flatnonzero((parting > PART_OF_A_TURN) & (estimate.error < 1.0))
    if not len(some):
        return
    if request.times.ndim == 2:
        for body in np.split(some, len(some)):
            one, own = request.select(body), estimate.of(body)
            _count_turns(replace(one, times=one.times[0]), taken[body], own)
            estimate.write(body, own)
        return
    most = int(np.clip(np.ceil(phase[some].max() / PART_OF_A_TURN), 1, BETWEEN))
    between = np.linspace(*time_range(request.times), most + 2)[1:-1]
    dense = replace(request.select(some), times=np.union1d(request.times, between))
    steps = gaps.sum() / taken[some]
    both = dense.states(steps), second_run(dense, steps, 1.0, taken[some])
    rates = known_rates(
        dense.bodies, time_range(dense.times), lengths(both[0]["omega"]).max(axis=1)
    )
    apart = _stated_distances(dense.bodies, *both, rates, dense.times, SAFETY)
    error = np.where(np.isfinite(apart), apart, np.inf)
    largest = error.max(axis=1)
    larger = largest > estimate.error[some]
    found = ErrorEstimate(largest, _lost_from(error, dense.times))
    estimate.write(some[larger], ErrorEstimate(found.error[larger], found.lost_from[larger]))


def _lost_from(error: Floats, times: Floats) -> Floats:
    """The time nearest to 0, with its sign, at which the error is 1 or more; shape (n,)."""
    lost = np.where(error >= 1.0, np.abs(times), np.inf)
    nearest = lost.argmin(axis=1)
    when = np.take_along_axis(np.broadcast_to(times, error.shape), nearest[:, None], axis=1)[:, 0]
    return np.where(np.isfinite(lost.min(axis=1)), when, np.inf)


def distances(
    states: Mapping[str, Any],
    other: Mapping[str, Any],
    rest: Floats | float = 0.0,
    scale: Floats | float = 1.0,
) -> Floats:
    """Relative distance of the states of two runs, shape (n, m).

    The largest of ``|d omega|`` over the largest ``|omega|`` of the two, of the angle between the
    verticals and of the angle between the attitudes. Rates that are all below ``rest`` are compared
    with ``scale``.
    """
    parts = [_rate_distances(states, other, rest, scale)]
    if states["gamma"] is not None:
        parts.append(lengths(states["gamma"] - other["gamma"]))
    if states["attitude"] is not None:
        a, b = states["attitude"], other["attitude"]
        apart = np.minimum(lengths(a - b), lengths(a + b))
        parts.append(2.0 * apart)
    largest: Floats = reduce(np.maximum, parts)
    return largest


def _rate_distances(
    states: Mapping[str, Any],
    other: Mapping[str, Any],
    rest: Floats | float,
    scale: Floats | float,
) -> Floats:
    """``|d omega|`` over the largest ``|omega|`` of two runs, or over ``scale`` at rest; (n, m)."""
    rates, others = states["omega"], other["omega"]
    size = np.maximum(*(lengths(run).max(axis=1, initial=0.0) for run in (rates, others)))
    size = np.where(size > rest, size, np.where(np.asarray(scale) > 0.0, scale, 1.0))
    apart: Floats = lengths(rates - others) / size[:, None]
    return apart
