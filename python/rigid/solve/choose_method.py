"""Choose the method for states of a scene, the closed form or steps, and the steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import two_digits_above
from .._checks.arrays import Floats
from ..model.forces import forces_in_words
from ..model.sampled import reached
from .closed_form import (
    FORCED_RULE,
    NO_FORM,
    Codes,
    all_have,
    are_slowed_evenly,
    closed_forms,
    question_words,
    rule,
    why_not,
)
from .methods import (
    EXACT,
    FALLBACK,
    FUNCTION,
    MAP_FALLBACK,
    SERIES,
    SERIES_TOLERANCE,
    STIFF,
    adaptive_methods,
    order_of,
)
from .plan import UNKNOWN, Lazy, Plan, Reason, plan_of, plan_of_parts, why_unforeseen
from .request import USUAL_ACCURACY, Problem, Request
from .surfaces import default_method

FIRST = 13.0
"""Angle (rad) of the first steps for an accuracy, ``FIRST * (accuracy / angle)**(1 / order)``.

Of 1024 tops at four spins and four accuracies 13 takes the least time by dop853: steps of 8 are
twice as many, and by steps of 15 one top in three needs a second run. Steps of rk4 are shortened
once more: its number is 6."""

LONGEST = 1.5
"""Longest of these steps (rad): at 2 rad dop853 errs by more than 1e-4."""

NO_BOUND = (
    "step: is needed, because the rates have no known bound under the torque of a function; or "
    "give fastest=..., their bound, to Torque.call"
)

OTHER_FORCES = np.uint64(2**64 - 4)
"""The kinds of forces, as bits, that no method for strong damping integrates: all but an applied
torque and damping."""

STIFFNESS = 10.0
"""Damping is strong if it slows a body this many times faster than the body turns."""


def plan_states(problem: Problem) -> Plan:
    """The plan of states at given times, of bodies that may need several methods."""
    known = problem.bodies
    if known is None:
        return choose_method(problem).plan()
    parts = bodies_alike(problem)
    plans = [choose_method(one).plan for one, _ in parts]
    groups = [mine for _, mine in parts]
    chosen = plans[0]() if len(plans) == 1 else plan_of_parts(problem.scene, plans, groups)
    if chosen.method == EXACT and chosen.error is not None:
        assert isinstance(problem.span, float)
        unforeseen = why_unforeseen(known, problem.span)
        if unforeseen is not None:
            why = (*chosen.why, UNKNOWN.format(unforeseen))
            chosen = replace(chosen, error=None, why=why)
    return chosen


class Choice(NamedTuple):
    """How a problem is solved.

    Attributes
    ----------
    method : str
    steps : ndarray, shape (n,), or None
        The longest step of each body (s). None in closed form, by a tolerance, and where the steps
        are left to the core.
    tolerance : float or None
        The tolerance of adaptive steps.
    accuracy : float or None
        The largest error, for which tolerance or steps are made smaller where they must be; None
        where the user chose them.
    plan : Lazy of Plan
    """

    method: str
    steps: Floats | None
    tolerance: float | None
    accuracy: float | None
    plan: Lazy[Plan]

    def request(self, problem: Problem, strides: Sequence[int] | None = None) -> Request:
        """The call of the core for the states of the problem."""
        assert problem.bodies is not None
        assert problem.times is not None
        # By position, and so in half the time: it is 4 % of a call of one body.
        return Request(
            problem.bodies,
            problem.times,
            self.method,
            problem.record,
            problem.max_steps,
            problem.threads,
            self.tolerance,
            self.steps,
            strides,
        )


def bodies_alike(problem: Problem) -> list[tuple[Problem, NDArray[np.intp]]]:
    """The problems of groups of bodies that one method solves, and the indices of each group.

    One kind of forces acts on all bodies of a group. If the problem leaves the method open, all
    have a closed form or none has, and all are damped strongly or none is.
    """
    bodies = problem.bodies
    assert bodies is not None
    every = np.arange(len(bodies))
    if len(every) < 2:
        return [(problem, every)]
    kinds = bodies.kinds_of_forces()
    columns = [kinds, np.broadcast_to(bodies.weight.any(axis=1), len(every))]
    if problem.method is None:
        strongly = _are_damped_strongly(problem) & (kinds & OTHER_FORCES == 0)
        has_form = np.zeros(len(every), dtype=bool)
        if problem.step is None:
            has_form |= bodies.closed_forms() != NO_FORM
            if bodies.forces is not None:
                forms = closed_forms(problem.record, bodies.moments, bodies.weight)
                evenly = are_slowed_evenly(problem.scene, bodies.forces, bodies.moments)
                has_form |= (kinds != 0) & evenly & (forms != NO_FORM)
        columns += [has_form, strongly & ~has_form]
    if all((column == column[0]).all() for column in columns):
        return [(problem, every)]
    _, of_group = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    groups = [np.flatnonzero(of_group == group) for group in range(of_group.max() + 1)]
    return [(problem.select(some), some) for some in groups]


def choose_method(problem: Problem) -> Choice:
    """The method for bodies of a problem that are solved alike, its steps, and the plan."""
    if problem.is_plain:
        return Choice(EXACT, None, None, None, Lazy(_plan_of_any_start, problem))
    scene = problem.scene
    asked = problem.method
    # A requested method does not depend on them.
    forms = _known_closed_forms(problem) if asked in (None, EXACT) else np.empty(0, np.uint8)
    for name, times in scene.tables:
        reached(name, times, np.ravel(problem.reach or 0.0))
    method, why = _preferred(problem, forms)
    steps, accuracy = None, problem.accuracy
    if accuracy is None and _takes_usual_accuracy(problem, method):
        accuracy = USUAL_ACCURACY
    if accuracy is None or method == EXACT:
        _check_rates_are_known(problem)
        if problem.step is not None and method != EXACT and problem.bodies is not None:
            steps = np.full(len(problem.bodies), problem.step)
    elif method in adaptive_methods(scene.forces):
        if asked is None and method == SERIES:
            problem = replace(problem, tolerance=SERIES_TOLERANCE)
            short = (
                ", by steps that are short near the periapsis" if "orbit" in scene.forces else ""
            )
            why.append(f"{SERIES} leaves rounding alone{short}")
        else:
            problem = replace(problem, tolerance=_core.first_tolerance(accuracy, method))
            why.append(f"the tolerance follows from the error of {accuracy:g}")
    else:
        _check_rates_are_known(problem)
        known = problem.bodies is not None and problem.span is not None
        if problem.accuracy is not None or known:
            steps = _first_steps(problem, accuracy, method)
        why.append(f"the step follows from the error of {accuracy:g} at the end")
        if asked is None and method != STIFF:
            finer = "shorter steps" if scene.may_stop else f"{SERIES}, down to rounding"
            why.append(f"a body that its second run finds above it: {finer}")
    if problem.tolerance is not None:
        what = "last terms" if method != FUNCTION else "the error of each"
        why.append(f"each body takes its own steps, {what} below {problem.tolerance:g}")
        if asked is None and method == SERIES and scene.may_stop:
            why.append(f"a body that drag stops: {MAP_FALLBACK} in equal steps")
    _check_attainable(problem)
    plan = Lazy(plan_of, problem, method, steps, forms, accuracy, tuple(why))
    return Choice(method, steps, problem.tolerance, accuracy, plan)


def _takes_usual_accuracy(problem: Problem, method: str) -> bool:
    """Whether neither method, step nor tolerance is given, and steps are needed.

    Under strong damping the error of steps is not known before a run.
    """
    if problem.step is not None or problem.tolerance is not None:
        return False
    if "function" in problem.scene.forces and method == FUNCTION:
        return True
    return problem.method is None and method not in (EXACT, STIFF)


def _check_attainable(problem: Problem) -> None:
    """Raise ValueError if the error that rounding leaves exceeds a requested accuracy."""
    span, turning = problem.span, problem.rates()
    if problem.accuracy is not None and turning is not None and span is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            largest = float((turning * span).max(initial=0.0))
        floor = _core.ROUNDING * (1.0 + largest)
        if problem.accuracy <= floor:
            raise ValueError(
                f"accuracy = {problem.accuracy:g}: must be at least {two_digits_above(floor)}; "
                f"rounding errs by {floor:.2e} in {largest:.3g} rad"
            )


def _check_rates_are_known(problem: Problem) -> None:
    """Raise ValueError if steps should follow from rates that nothing bounds."""
    follows = problem.step is None and problem.tolerance is None
    if follows and problem.bodies is not None and not problem.scene.bounds_rates:
        raise ValueError(f"{NO_BOUND}, or leave the method out: {FUNCTION} chooses its steps")


def _plan_of_any_start(problem: Problem) -> Plan:
    """The plan of a scene whose motions all have a closed form."""
    assert problem.bodies is not None
    number = max(len(problem.bodies), 1)
    own = replace(problem, bodies=None, times=None, number=number)
    return choose_method(own).plan()


def _known_closed_forms(problem: Problem) -> Codes:
    """The code of the closed form of each body.

    Raises
    ------
    ValueError
        If closed forms were requested and a body has none.
    """
    scene, record, method = problem.scene, problem.record, problem.method
    moments, weight = problem.inertia()
    forms = closed_forms(record, moments, weight)
    if scene.forces:
        forces = problem.forces()
        assert forces is not None
        evenly = are_slowed_evenly(scene, forces, moments)
        forms = np.where(evenly, forms, np.uint8(NO_FORM))
    elif problem.bodies is not None and not all_have(forms):
        wanted = method == EXACT or (method is None and problem.step is None)
        # Whether a top swings as a pendulum depends on the start.
        forms = problem.bodies.closed_forms() if wanted else forms
    if method == EXACT and not all_have(forms):
        body = int(np.flatnonzero(forms == NO_FORM)[0])
        which = f"body {body} of the" if forms.size > 1 else "the"
        raise ValueError(
            f"method = {EXACT!r}: no closed form of {question_words(record)} for {which} "
            f"{scene.words()}; {FORCED_RULE if scene.forces else rule(record)}"
        )
    return forms


def _preferred(problem: Problem, forms: Codes) -> tuple[str, list[Reason]]:
    """The method unless an accuracy needs another one, and the reasons."""
    method, why = _usual(problem, forms)
    if problem.inside and method not in (EXACT, *adaptive_methods(problem.scene.forces)):
        why = why[:-1] if method == STIFF else why
        method = default_method(problem.scene.forces)
        why.append(f"{method} knows the motion inside its steps, where events are")
    return method, why


def _usual(problem: Problem, forms: Codes) -> tuple[str, list[Reason]]:
    """The method of a motion that is not looked at inside its steps, and the reasons."""
    scene = problem.scene
    if problem.method is not None:
        return problem.method, [f"method = {problem.method!r} was asked for"]
    if "function" in scene.forces and problem.step is None:
        return FUNCTION, [f"{FUNCTION} alone chooses its steps under the torque of a function"]
    if all_have(forms):
        if problem.step is not None:
            return _by_steps(problem, ["a step was asked for"])
        if not forms.size:
            return EXACT, ["there are no bodies: nothing is done"]
        return EXACT, ["every body has a closed form"]
    if scene.forces:
        return _by_steps(problem, [f"no closed form under {forces_in_words(scene.forces)}"])
    return _by_steps(problem, [partial(_why_not, problem, forms)])


def _why_not(problem: Problem, forms: Codes) -> str:
    """The reason why there is no closed form: of bodies that differ, of the first without one."""
    moments, weight = np.broadcast_arrays(*problem.inertia())
    body = int(np.flatnonzero(forms == NO_FORM)[0]) if len(moments) > 1 else 0
    return why_not(problem.record, moments[body], weight[body])


def _by_steps(problem: Problem, why: list[Reason]) -> tuple[str, list[Reason]]:
    """The method of bodies without a closed form; for strong damping the method made for it.

    The periapsis of an orbit asks for short steps, and a series knows the balance of energy there.
    """
    usual = FALLBACK
    if problem.step is None:
        usual = SERIES if "orbit" in problem.scene.forces else MAP_FALLBACK
    scene = problem.scene
    others = bool(scene.further()) or "function" in scene.forces
    if others or not _are_damped_strongly(problem).any():
        return usual, why
    forces = problem.forces()
    assert forces is not None  # damping is one of them
    slowing = float(forces.damping_rates(problem.inertia()[0]).max(initial=0.0))
    return STIFF, [*why, f"strong damping, at a rate of {slowing:.3g} 1/s: {STIFF}"]


@np.errstate(all="ignore")
def _are_damped_strongly(problem: Problem) -> NDArray[np.bool_]:
    """Whether damping slows each body much faster than it turns; shape (n,) or (1,).

    A given step is compared instead: an explicit method would have the error of the damping in it,
    not of the motion.
    """
    forces, turning = problem.forces(), problem.rates()
    if forces is None:
        return np.zeros(1, dtype=bool)
    slowing = forces.damping_rates(problem.inertia()[0])
    if problem.step is not None:
        return np.asarray(problem.step * slowing > 1.0)
    if turning is None:
        return np.zeros(1, dtype=bool)
    return np.asarray((slowing > STIFFNESS * turning) & (turning > 0.0))


@np.errstate(all="ignore")
def _first_steps(problem: Problem, accuracy: float, method: str) -> Floats:
    """Equal steps of each body about as long as the accuracy allows; the run shortens them."""
    span, rates = problem.span, problem.rates(method)
    if rates is None or span is None:
        raise ValueError(
            f"accuracy = {accuracy:g}: the step follows from the rates and the horizon; "
            f"{'omega' if rates is None else 't_end'} is missing"
        )
    assert problem.bodies is not None  # the rates are known
    forces = problem.bodies.forces
    # The torque of a function is looked at often enough.
    longest = span / _core.FEWEST_STEPS if forces is not None and forces.calls else np.inf
    turn = np.minimum(FIRST * roots(accuracy / (rates * span), order_of(method)), LONGEST)
    # What does not turn needs no step.
    steps = np.where(rates > 0.0, turn / rates, np.inf)
    return np.minimum(steps, longest)


def roots(numbers: Floats, order: int) -> Floats:
    """The roots of an order, with the same bits on every processor and beside other numbers.

    Square roots are rounded alike everywhere. Powers of an array are not, so powers of single
    floats make the roots of other orders.
    """
    if order & (order - 1):
        return np.array([number ** (1.0 / order) for number in numbers.tolist()])
    for _ in range(order.bit_length() - 1):
        numbers = np.sqrt(numbers)
    return numbers
