"""A chosen method, and the plan that describes it."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.scene import Scene
from .closed_form import Codes, Question, moment_rows, names, question_words
from .cost_model import Estimate, closed_form_estimate, costliest, steps_estimate
from .foresight import nearness_of_poles, why_unforeseen
from .methods import EXACT
from .plan import Plan, carried, left_out
from .problem import Problem

__all__ = ["UNKNOWN", "Choice", "damping_rate", "some_of", "stepped_question"]

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
        scene, question = problem.scene, problem.question
        estimate = self._estimate()
        error = estimate.error
        if scene.is_called and error is not None:
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
            question=question_words(question),
            closed_form=", ".join(names(self.forms)) or None if method == EXACT else None,
            method=method,
            carried=carried(scene, question, method),
            why=why,
            left_out=left_out(scene, question, method, problem.step, self.forms),
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
                problem.question, forms, problem.states, rates, problem.span, problem.count
            )
        if self.accuracy is not None and not problem.knows_angles:
            return Estimate(None, None, None, None)
        return _steps_estimate(problem, self.method, self.steps)


def _steps_estimate(problem: Problem, method: str, steps: Floats | None) -> Estimate:
    """Work and error of a scheme, the largest of all classes of bodies."""
    classes, rates = problem.classes(), problem.rates(method)
    nearness: float | Floats = 1.0
    if problem.batch is not None and rates is not None:
        nearness = nearness_of_poles(problem.batch, rates)
    parts = []
    for kind in sorted(set(classes.tolist())):
        mine = slice(None) if len(classes) == 1 else np.flatnonzero(classes == kind)
        longest = steps if problem.step is None else problem.step
        part = steps_estimate(
            stepped_question(problem, method),
            method,
            kind,
            None if rates is None else rates[mine],
            None if problem.span is None else some_of(problem.span, mine),
            longest[mine] if isinstance(longest, np.ndarray) else longest,
            damping_rate(problem.scene),
            some_of(nearness, mine),
            states=problem.states,
            bodies=problem.count,
        )
        parts.append(part)
    return costliest(parts)


def some_of(values: float | Floats, mine: slice | NDArray[np.intp]) -> float | Floats:
    """The values of some bodies, or that of all."""
    return values[mine] if isinstance(values, np.ndarray) and values.ndim else values


def damping_rate(scene: Scene) -> float:
    """The largest rate at which damping slows a body (1/s)."""
    forcing = scene.forcing
    if forcing is None:
        return 0.0
    return float(forcing.damping_rates(moment_rows(scene)).max(initial=0.0))


def _memory(problem: Problem) -> int | None:
    """Bytes of the states of the bodies, if their number is known."""
    bodies = len(problem.batch) if problem.batch is not None else problem.bodies
    if bodies is None and problem.scene.shape:
        bodies = prod(problem.scene.shape)
    if bodies is None or not isinstance(problem.question, str):
        return None
    forcing = problem.scene.forcing if problem.batch is None else problem.batch.forcing
    return _core.state_bytes(
        scene=problem.scene.kind,
        record=problem.question,
        bodies=bodies if problem.bodies is None else problem.bodies,
        times=problem.states,
        forcing=forcing,
    )


def stepped_question(problem: Problem, method: str) -> Question:
    """A question whose steps have the same cost: forced rates may need a larger state."""
    scene, question = problem.scene, problem.question
    if not scene.is_driven or not isinstance(question, str):
        return question
    return "attitude" if "gamma" in carried(scene, question, method) else "rates"
