"""The plan of a problem whose method is chosen."""

from __future__ import annotations

from math import prod

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.scene import Scene
from .closed_form import Codes, moment_rows, names, question_words
from .cost_model import Estimate, closed_form_estimate, costliest, steps_estimate
from .foresight import motions_of, why_unforeseen
from .methods import EXACT
from .plan import Plan, carried, left_out, not_left_out
from .problem import Problem

__all__ = ["UNKNOWN", "damping_rate", "plan_of", "stepped_record"]

Floats = NDArray[np.float64]

UNKNOWN = "error unknown: {}"
"""The sentence of a plan whose error is unknown."""


def plan_of(
    problem: Problem,
    method: str,
    steps: Floats | None,
    forms: Codes,
    accuracy: float | None,
    why: tuple[str, ...],
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
    why : tuple of str
        The reasons.
    """
    scene, record = problem.scene, problem.record
    estimate = _estimate(problem, method, steps, forms, accuracy)
    error = estimate.error
    if "function" in scene.forces and error is not None:
        error, why = None, (*why, UNKNOWN.format("a function gives the torque"))
    if scene.torque is not None and scene.torque.function is not None:
        why = (*why, *scene.torque.function.reasons)
    if estimate.unknown is not None:
        why = (*why, UNKNOWN.format(estimate.unknown))
    if error is not None and problem.bodies is not None and method != EXACT:
        unforeseen = why_unforeseen(problem.bodies, problem.times, by_steps=True)
        if unforeseen is not None:
            error, why = None, (*why, UNKNOWN.format(unforeseen))
    if error is not None and problem.accuracy is not None:
        # The steps of the run are shortened until it is met.
        error = min(error, problem.accuracy)
    done = carried(scene, record, method)
    return Plan(
        scene=scene.words(),
        question=question_words(record),
        closed_form=", ".join(names(forms)) or None if method == EXACT else None,
        method=method,
        carried=done,
        why=(*why, *not_left_out(done, scene.forces)),
        left_out=left_out(scene, record, method, problem.step, forms),
        step=estimate.step,
        steps=estimate.steps,
        work=estimate.work,
        error=error,
        accuracy=accuracy,
        memory=_memory(problem),
    )


def _estimate(
    problem: Problem, method: str, steps: Floats | None, forms: Codes, accuracy: float | None
) -> Estimate:
    """Work and error."""
    if method == EXACT:
        return closed_form_estimate(
            problem.record, forms, problem.states, problem.rates(), problem.span, problem.count
        )
    if problem.tolerance is not None or (accuracy is not None and not problem.knows_angles):
        return Estimate(None, None, None, None)
    return _steps_estimate(problem, method, steps)


def _steps_estimate(problem: Problem, method: str, steps: Floats | None) -> Estimate:
    """Work and error of a method, the largest of all classes of bodies."""
    rates = problem.rates(method)
    if problem.bodies is None or rates is None:
        return Estimate(problem.step, None, None, None)
    longest = steps if problem.step is None else np.full(len(rates), problem.step)
    motions = motions_of(
        problem.bodies,
        method,
        problem.times,
        problem.span,
        _core.default_steps(method, rates) if longest is None else longest,
        states=problem.states,
    )
    classes, record = problem.classes(), stepped_record(problem, method)
    if len(classes) == 1:
        return steps_estimate(record, method, str(classes[0]), motions, problem.count)
    return costliest(
        [
            steps_estimate(
                record, method, kind, motions.of(np.flatnonzero(classes == kind)), problem.count
            )
            for kind in sorted(set(classes.tolist()))
        ]
    )


def damping_rate(scene: Scene) -> float:
    """The largest rate at which damping slows a body (1/s)."""
    forces = scene.acting()
    if forces is None:
        return 0.0
    return float(forces.damping_rates(moment_rows(scene)).max(initial=0.0))


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


def stepped_record(problem: Problem, method: str) -> str:
    """A record whose steps have the same cost: forced rates may need more state variables."""
    scene, record = problem.scene, problem.record
    if not scene.forces:
        return record
    return "attitude" if "gamma" in carried(scene, record, method) else "rates"
