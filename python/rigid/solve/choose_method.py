"""Choose the method for states of a scene, the closed form or steps, and the steps."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, one_of, positive_int
from ..model.body import Body
from ..model.forces import forces_in_words
from ..model.scene import Scene, check_scene
from .closed_form import (
    FORCED_RULE,
    NO_FORM,
    RECORDS,
    Codes,
    all_have,
    are_slowed_evenly,
    closed_forms,
    moment_rows,
    question_words,
    rule,
    weight_rows,
    why_not,
)
from .cost_model import (
    calibrated,
    calibration_class_of_forces,
    cheapest,
    check_attainable,
    some_of,
    steps_for,
)
from .methods import EXACT, FALLBACK, FUNCTION, STIFF, methods_under, plain_methods, series_methods
from .plan import LazyPlan, Plan
from .planned import UNKNOWN, damping_rate, plan_of, stepped_record, why_unforeseen
from .problem import USUAL_ACCURACY, Problem
from .second_run import SERIES, SERIES_TOLERANCE
from .starts import bodies_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["NO_BOUND", "Choice", "choose_method", "has_closed_form", "plan_states"]

Floats = NDArray[np.float64]

USUAL_ANGLE, USUAL_RATIO = 100.0, 0.1
"""Angle (rad) and ratio of the weight at which methods are compared if the true ones are
unknown."""

LOST_ANGLE = 1e15
"""A body that turns by a larger angle (rad) has lost all digits of its phase."""

NO_BOUND = (
    "step: is needed, because the rates have no known bound under the torque of a function; or "
    "give fastest=..., their bound, to Torque.call"
)

STIFFNESS = 10.0
"""Damping is strong if it slows a body this many times faster than the body turns."""


def plan_states(
    scene: Scene | Body,
    record: str,
    *,
    omega: ArrayLike | None = None,
    attitude: ArrayLike | Rotation | None = None,
    t_end: float | None = None,
    accuracy: float | None = None,
    method: str | None = None,
    step: float | None = None,
    bodies: int | None = None,
    times: int | None = None,
) -> Plan:
    """The plan of :func:`rigid.plan` for states at given times."""
    scene = check_scene(scene, many=True)
    if omega is None and attitude is not None:
        raise ValueError("attitude: says nothing without omega; give both")
    known = None if omega is None else bodies_of(scene, omega, attitude, rod=True)
    span = None if t_end is None else finite_float("t_end", t_end, positive=True)
    problem = Problem(
        scene=scene,
        record=one_of("question", record, RECORDS),
        bodies=known,
        end=span,
        accuracy=accuracy,
        method=method,
        step=step,
        states=1 if times is None else positive_int("times", times),
        number=None if bodies is None else positive_int("bodies", bodies),
    )
    chosen = choose_method(problem).plan()
    if known is not None and chosen.method == EXACT and chosen.error is not None:
        unforeseen = why_unforeseen(known, problem.times)
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
    plan : LazyPlan
    """

    method: str
    steps: Floats | None
    tolerance: float | None
    plan: LazyPlan


def choose_method(problem: Problem) -> Choice:
    """The method for the bodies of a problem, its steps, and the plan."""
    scene = problem.scene
    _check_rates_are_known(problem)
    asked = problem.method
    # A requested method does not depend on them.
    forms = _known_closed_forms(problem) if asked in (None, EXACT) else np.empty(0, np.uint8)
    if scene.torque is not None and problem.span is not None:
        scene.torque.at(np.ravel(problem.times))  # ValueError outside the times of its table
    method, why = _preferred(problem, forms)
    steps = None
    accuracy = problem.accuracy
    if accuracy is None and _takes_usual_accuracy(problem, method):
        accuracy = USUAL_ACCURACY
    tolerance = problem.adaptive_tolerance
    if tolerance is not None:
        if problem.tolerance is None:
            why.append(f"each body takes its own steps, the error of each below {tolerance:g}")
        problem = replace(problem, tolerance=tolerance)
    elif _is_followed_on_its_orbit(problem, method):
        _check_attainable(problem)
        problem = replace(problem, method=SERIES, tolerance=SERIES_TOLERANCE)
        method = SERIES
        why.append(f"{SERIES} leaves rounding alone, by steps that are short near the periapsis")
    elif accuracy is not None and (problem.accuracy is not None or problem.knows_angles):
        method, steps = _accurate(problem, accuracy, method, why)
    elif accuracy is not None:
        method = _usually_cheapest(problem, method, why)
    elif problem.step is not None and method != EXACT and problem.bodies is not None:
        steps = np.full(len(problem.bodies), problem.step)
    plan = LazyPlan(plan_of, problem, method, steps, forms, accuracy, tuple(why))
    return Choice(method, steps, problem.tolerance, plan)


def _is_followed_on_its_orbit(problem: Problem, method: str) -> bool:
    """Whether a series takes adaptive steps: at the periapsis equal steps would be too long.

    Equal steps as short as the periapsis asks are so many that their rounding, which the motion
    magnifies, is the error.
    """
    asked = (problem.method, problem.step, problem.tolerance) != (None, None, None)
    return "orbit" in problem.scene.forces and not asked and method == FALLBACK


def _check_attainable(problem: Problem) -> None:
    """Raise ValueError if the error that rounding leaves exceeds a requested accuracy."""
    span, turning = problem.span, problem.rates()
    if problem.accuracy is not None and turning is not None and span is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            check_attainable(problem.accuracy, turning * span)


def _check_rates_are_known(problem: Problem) -> None:
    """Raise ValueError if steps should follow from rates that nothing bounds."""
    follows = problem.step is None and problem.adaptive_tolerance is None
    if follows and problem.bodies is not None and not problem.scene.bounds_rates:
        raise ValueError(f"{NO_BOUND}, or leave the method out: {FUNCTION} chooses its steps")


def has_closed_form(scene: Scene) -> bool:
    """Whether the scene is one body without torque and damping, whose states have a closed form.

    From any start: of a top that swings as a pendulum from some it is false.
    """
    return scene.once(_has_closed_form)


def _has_closed_form(scene: Scene) -> bool:
    if scene.shape or scene.forces:
        return False
    return bool(closed_forms("rates", moment_rows(scene), weight_rows(scene)).all())


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
        forces = scene.acting() if problem.bodies is None else problem.bodies.forces
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


def _preferred(problem: Problem, forms: Codes) -> tuple[str, list[str]]:
    """The method unless an accuracy needs another one, and the reasons."""
    scene = problem.scene
    if problem.method is not None:
        return problem.method, [f"method = {problem.method!r} was asked for"]
    if problem.adaptive_tolerance is not None:
        return FUNCTION, [f"{FUNCTION} alone chooses its steps under the torque of a function"]
    if all_have(forms):
        if problem.step is not None:
            return _by_steps(problem, ["a step was asked for"])
        if not forms.size:
            return EXACT, ["there are no bodies: nothing is done"]
        return EXACT, ["every body has a closed form"]
    if scene.forces:
        return _by_steps(problem, [f"no closed form under {forces_in_words(scene.forces)}"])
    moments, weight = np.broadcast_arrays(*problem.inertia())
    # Of bodies that differ, the first without a closed form.
    body = int(np.flatnonzero(forms == NO_FORM)[0]) if len(moments) > 1 else 0
    return _by_steps(problem, [why_not(problem.record, moments[body], weight[body])])


def _by_steps(problem: Problem, why: list[str]) -> tuple[str, list[str]]:
    """The method of bodies without a closed form; for strong damping the method made for it."""
    slowing = damping_rate(problem.scene)
    if slowing == 0.0 or problem.scene.has_further or "function" in problem.scene.forces:
        return FALLBACK, why
    turning = problem.rates()
    if problem.step is not None:
        # An explicit method would have the error of the damping, not of the motion.
        is_stiff = problem.step * slowing > 1.0
    elif turning is None:
        is_stiff = False
    else:
        is_stiff = slowing > STIFFNESS * float(turning.max(initial=0.0)) > 0.0
    if not is_stiff:
        return FALLBACK, why
    return STIFF, [*why, f"strong damping, at a rate of {slowing:.3g} 1/s: {STIFF}"]


def _takes_usual_accuracy(problem: Problem, method: str) -> bool:
    """Whether steps are needed and neither method, step nor accuracy is given."""
    asked = problem.method is not None or problem.step is not None
    # Under strong damping the model of the error does not hold.
    return not asked and method not in (EXACT, STIFF)


def _applicable(scene: Scene) -> list[str]:
    """The methods from which the cheapest is chosen."""
    if not scene.forces:
        return plain_methods()
    known = methods_under(scene.forces)
    if scene.may_stop:  # beside the rest the speed is no series
        known = [name for name in known if name not in series_methods()]
    return known


def _usually_cheapest(problem: Problem, method: str, why: list[str]) -> str:
    """The method that mostly is the cheapest, where rates or horizon are not known."""
    names = _applicable(problem.scene)
    usual = cheapest(
        USUAL_ACCURACY,
        str(problem.classes()[0]),
        stepped_record(problem, method),
        dict.fromkeys(names, USUAL_ANGLE),
        USUAL_RATIO,
    )
    why.append(f"{usual} is mostly the cheapest method for an error of {USUAL_ACCURACY:g}")
    return usual


def _accurate(
    problem: Problem, accuracy: float, method: str, why: list[str]
) -> tuple[str, Floats | None]:
    """The requested method or the cheapest one for the accuracy, and its steps; adds to why."""
    _check_attainable(problem)
    if method == EXACT:
        return method, None
    span, turning = problem.span, problem.rates()
    if turning is None or span is None:
        raise ValueError(
            f"accuracy = {accuracy:g}: the step follows from the rates and the horizon; "
            f"{'omega' if turning is None else 't_end'} is missing"
        )
    assert problem.bodies is not None  # the rates are known
    classes = problem.classes()
    # Of bodies of several classes the most decide about the method, each class about its steps.
    kinds, counts = np.unique(classes, return_counts=True)
    scene = problem.scene
    kind = calibration_class_of_forces(scene) if scene.forces else str(kinds[counts.argmax()])
    ratios = problem.bodies.weight_ratios(turning)
    if problem.method is None:
        if problem.scene.forces:
            angles = {
                name: _largest_angle(problem.bodies.fastest_rates(problem.times, name), span)
                for name in _applicable(problem.scene)
            }
        else:
            angles = dict.fromkeys(plain_methods(), _largest_angle(turning, span))
        record = stepped_record(problem, method)
        method = cheapest(accuracy, kind, record, angles, _median(ratios))
        why.append(f"{method} is the cheapest method for an error of {accuracy:g}")
    why.append(f"the step follows from the error of {accuracy:g} at the end")
    rates = problem.bodies.fastest_rates(problem.times, method)
    steps = np.empty_like(rates)
    for own in kinds.tolist():
        mine = slice(None) if len(classes) == 1 else np.flatnonzero(classes == own)
        steps[mine] = steps_for(
            accuracy, calibrated()[method, own], rates[mine], some_of(span, mine), ratios[mine]
        )
    return method, np.minimum(steps, problem.bodies.longest_unseen(span))


def _median(ratios: Floats) -> float:
    """The median of the ratios of the weight; 0 for no bodies."""
    return float(np.median(ratios)) if len(ratios) else 0.0


def _largest_angle(rates: Floats, span: float | Floats) -> float:
    """The largest angle (rad) that a body turns, among bodies that keep their phase."""
    with np.errstate(invalid="ignore", over="ignore"):
        angles = rates * span
    return float(angles[angles < LOST_ANGLE].max(initial=0.0))
