"""A chosen method, and the plan that describes it."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.scene import Scene
from .closed_form import Codes, moment_rows, names, question_words
from .cost_model import Estimate, closed_form_estimate, costliest, steps_estimate
from .foresight import motions_of, why_unforeseen
from .methods import EXACT
from .plan import Plan, carried, left_out
from .problem import Problem

__all__ = ["UNKNOWN", "Choice", "damping_rate", "stepped_record"]

Floats = NDArray[np.float64]

UNKNOWN = "error unknown: {}"
"""How a plan says why its error is unknown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The method for the bodies of a problem.

    Attributes
    ----------
    problem : Problem
    method : str
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None if there are none or if they are left to the core.
    forms : ndarray of uint8
        The closed forms of the bodies, by their codes; empty if a scheme was asked for.
    accuracy : float or None
        The error for which method and steps were chosen.
    why : tuple of str
        The reasons.
    """

    problem: Problem
    method: str
    steps: Floats | None
    forms: Codes
    accuracy: float | None
    why: tuple[str, ...]

    def plan(self) -> Plan:
        """The plan: it takes longer than the choice, and no run needs it."""
        problem, method, why = self.problem, self.method, self.why
        scene, record = problem.scene, problem.record
        estimate = self._estimate()
        error = estimate.error
        if "function" in scene.forces and error is not None:
            error, why = None, (*why, UNKNOWN.format("the torque is that of a function"))
        if estimate.unknown is not None:
            why = (*why, UNKNOWN.format(estimate.unknown))
        if error is not None and problem.batch is not None and method != EXACT:
            unforeseen = why_unforeseen(problem.batch, problem.times, by_steps=True)
            if unforeseen is not None:
                error, why = None, (*why, UNKNOWN.format(unforeseen))
        if error is not None and problem.accuracy is not None:
            # The steps of the run are shortened until it is met.
            error = min(error, problem.accuracy)
        return Plan(
            scene=scene.words(),
            question=question_words(record),
            closed_form=", ".join(names(self.forms)) or None if method == EXACT else None,
            method=method,
            carried=carried(scene, record, method),
            why=why,
            left_out=left_out(scene, record, method, problem.step, self.forms),
            step=estimate.step,
            steps=estimate.steps,
            work=estimate.work,
            error=error,
            accuracy=self.accuracy,
            memory=_memory(problem),
        )

    def _estimate(self) -> Estimate:
        """Work and error."""
        problem = self.problem
        if self.method == EXACT:
            rates, forms = problem.rates(), self.forms
            return closed_form_estimate(
                problem.record, forms, problem.states, rates, problem.span, problem.count
            )
        if self.accuracy is not None and not problem.knows_angles:
            return Estimate(None, None, None, None)
        return _steps_estimate(problem, self.method, self.steps)


def _steps_estimate(problem: Problem, method: str, steps: Floats | None) -> Estimate:
    """Work and error of a scheme, the largest of all classes of bodies."""
    rates = problem.rates(method)
    if problem.batch is None or rates is None:
        return Estimate(problem.step, None, None, None)
    longest = steps if problem.step is None else np.full(len(rates), problem.step)
    motions = motions_of(
        problem.batch,
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
    bodies = len(problem.batch) if problem.batch is not None else problem.bodies
    if bodies is None and problem.scene.shape:
        bodies = prod(problem.scene.shape)
    if bodies is None:
        return None
    forces = problem.scene.acting() if problem.batch is None else problem.batch.forces
    return _core.state_bytes(
        scene=problem.scene.kind,
        record=problem.record,
        bodies=bodies if problem.bodies is None else problem.bodies,
        times=problem.states,
        forces=forces,
    )


def stepped_record(problem: Problem, method: str) -> str:
    """A record whose steps have the same cost: forced rates may need a larger state."""
    scene, record = problem.scene, problem.record
    if not scene.forces:
        return record
    return "attitude" if "gamma" in carried(scene, record, method) else "rates"
