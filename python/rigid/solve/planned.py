"""The plan of a problem whose method is chosen."""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import TypeAlias

import numpy as np

from .. import _core
from .arrays import Floats, lengths
from .bodies import Bodies
from .closed_form import Codes, names, question_words
from .methods import EXACT
from .plan import Plan, carried, left_out, not_left_out
from .request import Problem

Reason: TypeAlias = str | Callable[[], str]
"""A reason of a plan, or how to word it."""

UNKNOWN = "error unknown: {}"
"""The sentence of a plan whose error is unknown."""

SLOW = 10.0
"""A body this many times slower than the rate that its weight can give it is nearly at rest."""

MAGNIFIED = 100.0
"""A saddle that magnifies the rounding of the start by more makes the error unknown."""


def plan_of(
    problem: Problem,
    method: str,
    steps: Floats | None,
    forms: Codes,
    accuracy: float | None,
    why: tuple[Reason, ...],
) -> Plan:
    """The plan of a method, made only on demand: it takes longer than the choice of the method.

    Parameters
    ----------
    problem : Problem
    method : str
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None if there are none or if they are left to the core.
    forms : ndarray of uint8
        The closed forms of the bodies, by their codes; empty if a method was requested.
    accuracy : float or None
        The error for which method and steps were chosen.
    why : tuple of str or callable
        The reasons; functions without arguments return those that take time to word.
    """
    scene, record, error = problem.scene, problem.record, None
    words = tuple(reason if isinstance(reason, str) else reason() for reason in why)
    step: float | None
    count: int | None
    if method == EXACT:
        step, count = None, 0
        error = closed_form_error(problem.rates(), problem.span)
    else:
        step, count = _step_and_count(problem, method, steps, accuracy)
    if scene.torque is not None and scene.torque.function is not None:
        words = (*words, *scene.torque.function.reasons)
    done = carried(scene, record, method, scene.forces)
    return Plan(
        scene=scene.words(),
        question=question_words(record),
        closed_form=", ".join(names(forms)) or None if method == EXACT else None,
        method=method,
        carried=done,
        why=(*words, *not_left_out(done, scene.forces)),
        left_out=left_out(scene, record, method, problem.step, forms, scene.forces),
        step=step,
        steps=count,
        tolerance=problem.tolerance,
        error=error,
        accuracy=accuracy,
        memory=_memory(problem),
    )


def _step_and_count(
    problem: Problem, method: str, steps: Floats | None, accuracy: float | None
) -> tuple[float | None, int | None]:
    """The shortest step (s) and the most steps, as far as they are known before a run."""
    if problem.tolerance is not None or (steps is None and accuracy is not None):
        return None, None
    bodies = problem.bodies
    if bodies is None or (problem.span is None and problem.scene.forces):
        return problem.step, None
    own, time = bodies.planned_steps(method, problem.times, "states")
    if problem.step is not None:
        own = np.full(len(bodies), problem.step)
    elif steps is not None:
        own = steps
    return shortest_and_most(own, None if problem.span is None else time, problem.states)


@np.errstate(all="ignore")
def shortest_and_most(
    steps: Floats, times: Floats | None, states: int = 1
) -> tuple[float | None, int | None]:
    """The shortest step (s), and about how many steps the body with the most of them takes.

    Parameters
    ----------
    steps : ndarray, shape (n,)
        The longest step of each body (s), infinite for a body at rest.
    times : ndarray, shape (n,), or None
        In which steps of that length are as many as those of the run (s), None if not known.
    states : int
        Number of output times: each interval between them has a whole number of steps.
    """
    shortest = float(steps.min(initial=np.inf))
    most = np.inf
    if times is not None:
        each = np.ceil(times / steps + 0.5 * (states - 1))
        most = float(np.maximum(each, max(states, 1)).max(initial=0.0))
    return shortest if shortest < np.inf else None, int(most) if most < 2.0**63 else None


def closed_form_error(rates: Floats | None, span: float | Floats | None) -> float | None:
    """The largest error of closed forms (rad) for bounds of the rates, shape (n,), if known."""
    if rates is None or span is None:
        return None
    if isinstance(span, float):
        angle = float(rates.max(initial=0.0)) * span
    else:
        with np.errstate(all="ignore"):
            angle = float((rates * span).max(initial=0.0))
    worst = _core.ROUNDING * (1.0 + angle)
    return worst if worst < np.inf else None


@np.errstate(all="ignore")
def why_unforeseen(bodies: Bodies, end: float) -> str | None:
    """Why the error of closed forms until a time (s) is not known before the run; None if it is."""
    if not np.count_nonzero(bodies.weight):
        return None
    tops = np.flatnonzero(np.broadcast_to(bodies.weight.any(axis=1), len(bodies)))
    if not len(tops):
        return None
    some = bodies.select(tops)
    if np.any(some.fastest_rates((0.0, end)) > SLOW * _fastest_above_rest(some)):
        return "a body is nearly at rest, and its small rates are what the error is relative to"
    distance, exponent = some.separatrices()
    growth = np.exp(exponent * end)
    if np.any(np.fmin(growth, 1.0 / distance) > MAGNIFIED):
        return "a body passes a saddle, which magnifies it"
    return None


def _fastest_above_rest(bodies: Bodies) -> Floats:
    """The fastest rate (rad/s) that a top can reach by its energy above hanging; shape (n,)."""
    size = lengths(bodies.weight)
    kinetic = 0.5 * np.sum(bodies.moments * bodies.omega**2, axis=1)
    # A difference of unit vectors: small angles lose no digits.
    raised = 0.5 * np.sum((bodies.gammas() + bodies.weight / size[:, None]) ** 2, axis=1)
    fastest: Floats = np.sqrt(2.0 * (kinetic + size * raised) / bodies.moments.min(axis=1))
    return fastest


def _memory(problem: Problem) -> int | None:
    """Bytes of the states of the bodies, if their number is known."""
    number = problem.number
    if number is None and problem.bodies is not None:
        number = len(problem.bodies)
    if number is None and problem.scene.shape:
        number = prod(problem.scene.shape)
    if number is None:
        return None
    forces = problem.scene.acting() if problem.bodies is None else problem.bodies.forces
    return _core.state_bytes(
        scene=problem.scene.kind,
        record=problem.record,
        bodies=number,
        times=problem.states,
        forces=forces,
    )
