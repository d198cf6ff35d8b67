"""The motion of the bodies of a problem: each kind of bodies by its own method.

A body is solved as if it were alone: neither its method nor its steps depend on other bodies of the
call.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .. import _core
from .._checks.arguments import brief, one_of, two_digits_above
from .._checks.arrays import Floats
from ..model.bodies import Bodies, Range, time_ranges
from .choose_method import Choice, bodies_alike, choose_method
from .events import FoundEvents, events_of_parts, find_events
from .methods import EXACT, SERIES, SERIES_TOLERANCE
from .plan import Lazy, Plan, plan_of_parts
from .request import Problem, Request
from .status import Status
from .surfaces import Watched
from .tangent import parameter_changes, tangent_of

COLUMNS: Mapping[str, int] = {
    **{"omega": 3, "gamma": 3, "attitude": 4, "work": 1},
    **{"energy": 1, "momentum": 3},
}
"""The numbers in a row of the arrays of a run with an axis of times."""

DERIVED = ("energy", "momentum")
"""Those that follow from the others, and are recorded if they are asked for."""

SINGLE = 2.0**-23
"""Angle (rad) by which single precision rounds an attitude: twice as much as for a vector."""

SLOWEST, FASTEST = 1e-30, 1e30
"""Rates between these are rounded to single precision relative to their size (rad/s)."""


@dataclass(frozen=True, slots=True)
class Target:
    """The arrays for the states of a run.

    Attributes
    ----------
    single : bool
        Whether new arrays have single precision.
    given : dict of str to ndarray
        Arrays of shape (n, m, k) by their names.
    """

    single: bool
    given: dict[str, NDArray[Any]]

    @classmethod
    def of(
        cls,
        dtype: DTypeLike,
        out: Mapping[str, NDArray[Any]] | None,
        shape: tuple[int, ...],
        recorded: tuple[str, ...],
    ) -> Self:
        """The target of a call.

        Parameters
        ----------
        dtype : dtype
            ``float64`` or ``float32``.
        out : mapping or None
            Arrays by the names of their attributes of a run.
        shape : tuple of int
            ``(..., m)``, or ``(m,)`` of a single body.
        recorded : tuple of str
            Names of the recorded arrays.

        Raises
        ------
        TypeError
            If an array is none.
        ValueError
            If the type is another one, a name is not recorded, or an array cannot be filled.
        """
        if np.dtype(dtype) not in (np.float64, np.float32):
            raise ValueError(f"dtype = {np.dtype(dtype)}: must be float64 or float32")
        count = prod(shape[:-1])
        given = {}
        for name, array in (out or {}).items():
            width = COLUMNS[one_of("out", name, recorded)]
            wanted = shape if width == 1 else (*shape, width)
            given[name] = _fillable(name, array, wanted).reshape(count, shape[-1], width)
        return cls(np.dtype(dtype) == np.float32, given)

    def check(self, bodies: Bodies, reached: Range, accuracy: float | None) -> None:
        """Raise ValueError for numbers that single precision cannot hold."""
        if not self._rounds:
            return
        if accuracy is not None and accuracy <= SINGLE:
            least = two_digits_above(SINGLE)
            raise ValueError(f"accuracy = {accuracy:g}: must be at least {least} in float32")
        rates = bodies.fastest_rates(reached)
        outside = np.flatnonzero((rates > 0.0) & ~((rates > SLOWEST) & (rates < FASTEST)))
        if len(outside):
            raise ValueError(
                f"dtype = float32: the rates of body {outside[0]} reach "
                f"{rates[outside[0]]:.3g} rad/s; they must be zero or between {SLOWEST:g} and "
                f"{FASTEST:g}: count the time in another unit"
            )

    @property
    def _rounds(self) -> bool:
        return self.single or any(array.dtype == np.float32 for array in self.given.values())

    @property
    def exact(self) -> dict[str, NDArray[Any]]:
        """The given arrays of double precision, in which steps are compared before rounding."""
        return {name: array for name, array in self.given.items() if array.dtype == np.float64}

    def finish(self, made: MutableMapping[str, Any]) -> dict[str, Any]:
        """All states stored, and the columns with these arrays and with errors of the rounding."""
        states = dict(made)
        for name, width in COLUMNS.items():
            array, given = states.get(name), self.given.get(name)
            try:
                with np.errstate(over="raise" if name in DERIVED else None):
                    if given is not None:
                        given = given if width > 1 else given[..., 0]
                        if not np.may_share_memory(given, array):
                            given[:] = array
                        states[name] = given
                    elif self.single and array is not None and name != "work":
                        states[name] = array.astype(np.float32, copy=False)
            except FloatingPointError:
                most = np.nanmax(np.abs(states[name]))
                raise ValueError(
                    f"dtype = float32: {name} reaches {most:.3g}; the largest "
                    f"number is {np.finfo(np.float32).max:.3g}: take other units, or float64"
                ) from None
        if self._rounds:
            states["error"] = states["error"] + SINGLE
        return states


PLAIN = Target(single=False, given={})
"""All arrays are new and of double precision."""


def _fillable(name: str, array: object, shape: tuple[int, ...]) -> NDArray[Any]:
    """The array of ``out``, if states can be written into it."""
    if not isinstance(array, np.ndarray):
        raise TypeError(f"out[{name!r}] = {brief(array)}: must be an array")
    flags = array.flags
    if (
        array.shape != shape
        or array.dtype not in (np.float64, np.float32)
        or not (flags.c_contiguous and flags.writeable and flags.aligned)
    ):
        raise ValueError(
            f"out[{name!r}]: must be writeable and C-contiguous, of shape {shape} and float64 or "
            f"float32; got {array.shape} of {array.dtype}"
        )
    return array


def end_records(
    states: MutableMapping[str, Any], times: NDArray[np.float64], last: NDArray[np.float64]
) -> None:
    """Write NaN over the states at times (m,) or (n, m) after the last of each body, (n, 1)."""
    after = times > last
    if not after.any():
        return
    for name in (*COLUMNS, "states", "tangent", "sensitivity"):
        if states.get(name) is not None:
            states[name][after] = np.nan


@dataclass(slots=True, eq=False)
class Solution:
    """The motion of the bodies of a problem.

    Attributes
    ----------
    states : mapping
        The columns of the core, with ``error`` and ``lost_from`` where they are known.
    method : str
        The method of bodies without a closed form; ``"exact"`` if all have one.
    tolerance : float or None
    plan : Lazy of Plan
    found : FoundEvents or None
    """

    states: MutableMapping[str, Any]
    method: str
    tolerance: float | None
    plan: Lazy[Plan]
    found: FoundEvents | None = None


def solve(
    problem: Problem,
    *,
    check: bool = True,
    watched: Watched | None = None,
    parameters: Sequence[str] | None = None,
    target: Target = PLAIN,
) -> Solution:
    """The motion of the bodies of a problem, by the methods that it asks for.

    Parameters
    ----------
    problem : Problem
        With bodies and output times.
    check : bool
        Whether errors are estimated.
    watched : Watched, optional
    parameters : sequence of str, optional
        Parameters by which the states are differentiated; an empty sequence for the tangent alone.
    target : Target
        Arrays for the states.
    """
    problems = [] if problem.is_plain else bodies_alike(problem)
    if len(problems) < 2:
        return _solve_alike(problem, check, watched, parameters, target)
    parts = [_solve_alike(own, check, watched, parameters, PLAIN) for own, _ in problems]
    return _merged(problem, parts, [some for _, some in problems])


def _solve_alike(
    problem: Problem,
    check: bool,
    watched: Watched | None,
    parameters: Sequence[str] | None,
    target: Target,
) -> Solution:
    """The motion of bodies that one method solves."""
    choice = choose_method(problem)
    request, found = choice.request(problem), None
    if watched is not None:
        found = find_events(problem, watched, choice.method, check=check)
        if found.stopped.any():
            # States are computed up to the end of a body, and so are their errors.
            request = replace(request, times=np.minimum(request.times, found.last))
    if choice.method == EXACT:
        made = _by_closed_form(request, choice, target)
    else:
        made = _by_steps(problem, request, choice, check=check, target=target)
    made.found = found
    states, scale_exponent = made.states, request.bodies.scale_exponent
    if states["work"] is not None:
        np.ldexp(states["work"], scale_exponent[:, np.newaxis], out=states["work"])
    if parameters is not None:
        change = None
        if parameters:
            change = parameter_changes(problem.scene, request.bodies, parameters)
        states["tangent"], states["sensitivity"], words = tangent_of(
            request, problem.method, change
        )
        made.plan.amend(words)
    return made


def _by_closed_form(request: Request, choice: Choice, target: Target) -> Solution:
    """The motion in closed form."""
    states = request.states(out=target.given or None, single=target.single)
    worst = states.worst
    if worst is None:
        bodies = request.bodies
        bodies.note_rates(states.pop("fastest_rate"))
        known = _core.errors_of_closed_forms(bodies, request.times, states["omega"])
        states["error"], states["lost_from"] = known
        worst = _largest(known[0])
    choice.plan.amend(error=worst if worst < 1.0 else None)
    return Solution(states, EXACT, None, choice.plan)


def _by_steps(
    problem: Problem, request: Request, choice: Choice, *, check: bool, target: Target
) -> Solution:
    """The motion by steps; the plan tells which."""
    states = request.solve(
        choice.accuracy,
        check=check or problem.accuracy is not None,
        free=problem.method is None,
        out=target.exact,
    )
    by_series = states.pop("by_series", None)
    made = Solution(states, choice.method, choice.tolerance, choice.plan)
    taken, worst = states["steps"], states.worst
    worst = _largest(states.error) if worst is None else worst
    made.plan.amend(steps=int(taken.max(initial=0)), error=worst if worst < 1.0 else None)
    if choice.accuracy is None or choice.steps is None:
        return made
    if by_series is None:
        by_series = np.zeros(len(request.bodies), dtype=bool)
    if by_series.size and by_series.all():
        made.method, made.tolerance = SERIES, SERIES_TOLERANCE
        made.plan.amend(method=SERIES, tolerance=SERIES_TOLERANCE, step=None)
        return made
    if by_series.any():
        some = np.count_nonzero(by_series)
        made.plan.amend(f"{some} of {len(by_series)} bodies by {SERIES}")
    ended = np.isin(states["status"], (Status.STEP_LIMIT, Status.NOT_FINITE))
    whole = ~by_series & ~ended & (taken > 0)
    if whole.any():
        first, last = time_ranges(request.times)
        spans = np.broadcast_to(last - first, taken.shape)
        made.plan.amend(step=float((spans[whole] / taken[whole]).min()))
    return made


def _merged(
    problem: Problem, parts: Sequence[Solution], groups: Sequence[NDArray[np.intp]]
) -> Solution:
    """The solutions of groups of bodies as one of all."""
    assert problem.bodies is not None
    count = len(problem.bodies)
    states: dict[str, Any] = {"nanoseconds": 0}
    for part, mine in zip(parts, groups, strict=True):
        states["nanoseconds"] += part.states.pop("nanoseconds")
        for name, values in part.states.items():
            if values is None:
                states.setdefault(name, None)
                continue
            if states.get(name) is None:
                # What is recorded of some bodies only is zero of others, as the work of no force.
                states[name] = np.zeros((count, *values.shape[1:]), values.dtype)
            states[name][mine] = values
    found = [part.found for part in parts if part.found is not None]
    plan = Lazy(plan_of_parts, problem.scene, [part.plan for part in parts], groups)
    by_steps = min(parts, key=lambda part: part.method == EXACT)
    return Solution(
        states,
        by_steps.method,
        by_steps.tolerance,
        plan,
        events_of_parts(problem.bodies, found, groups) if found else None,
    )


def _largest(values: Floats) -> float:
    """The largest of some numbers and 0, without a reduction, which is slow, for one number."""
    return max(float(values[0]), 0.0) if len(values) == 1 else float(values.max(initial=0.0))
