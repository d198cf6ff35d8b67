"""What a plan costs and how far it can be believed: models of time and error."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .criteria import Criterion, NoFlip
from .methods import EXACT, angle_per_step, order_of

__all__ = ["ROUNDING", "Scheme", "cheapest", "check_attainable", "numbers", "schemes", "steps_for"]

Floats = NDArray[np.float64]

ROUNDING = 1e-15
"""Error of an attitude per radian turned that float64 leaves even to a closed form (rad)."""

WATCHING: Mapping[str, float] = {"flips": 0.5, "tilt": 0.8}
"""Nanoseconds a step that watching costs."""


@dataclass(frozen=True, slots=True)
class Scheme:
    """What is known by measurement of a scheme on a class of bodies.

    The error of a run is about ``factor theta**order`` per radian turned, ``theta`` being the angle
    that the body turns in a step, up to ``largest``.
    """

    order: int
    factor: float
    largest: float
    nanoseconds: Mapping[str, float]


@cache
def schemes() -> dict[tuple[str, str], Scheme]:
    """All that is measured, by name and class; ``benches/calibrate.py`` wrote it."""
    text = resources.files("rigid").joinpath("calibration.json").read_text(encoding="utf-8")
    return {
        (name, kind): Scheme(order_of(name), **entry)
        for name, kinds in json.loads(text)["methods"].items()
        for kind, entry in kinds.items()
    }


@np.errstate(all="ignore")
def cheapest(
    accuracy: float, kind: str, question: str | Criterion, angles: Mapping[str, float]
) -> str:
    """The scheme that needs the least time for this error after these angles (rad).

    Explicit steps follow the damping too: to them what it slows down is an angle.
    """

    def time(name: str) -> float:
        scheme, angle = schemes()[name, kind], angles[name]
        turn = _turn(scheme, accuracy, np.array(angle)).item()
        return _step_cost(scheme, question) * max(angle, 1e-300) / turn

    return min((name for name, known in schemes() if known == kind and name in angles), key=time)


# Nanoseconds on one core: a body, a state of it and its class by closed form. The states pay for
# their way into arrays of Python.
CLOSED_FORM_COST: Mapping[str, tuple[float, float, float]] = {
    "axis spin": (100.0, 70.0, 30.0),
    "free symmetric": (100.0, 70.0, 60.0),
    "free asymmetric": (130.0, 110.0, 75.0),
    "lagrange": (190.0, 120.0, 120.0),
    "pendulum": (200.0, 130.0, 120.0),
}


def check_attainable(accuracy: float, angles: Floats) -> None:
    """Raise ValueError if rounding alone leaves more."""
    floor = ROUNDING * (1.0 + angles.max(initial=0.0))
    if accuracy <= floor:
        raise ValueError(
            f"accuracy = {accuracy:g}: must be above {floor:.1e}, which rounding leaves of "
            f"{angles.max(initial=0.0):.3g} rad turned"
        )


@np.errstate(all="ignore")
def steps_for(accuracy: float, scheme: Scheme, rates: Floats, span: float) -> Floats:
    """The step of each body whose error at the end is ``accuracy``."""
    # What does not turn needs no step.
    return np.where(rates > 0.0, _turn(scheme, accuracy, rates * span) / rates, np.inf)


def _turn(scheme: Scheme, accuracy: float, angles: Floats) -> Floats:
    """The angle turned in a step for this error after these angles."""
    left = np.maximum(accuracy - ROUNDING * (1.0 + angles), 0.5 * accuracy)
    turn = (left / (scheme.factor * angles)) ** (1.0 / scheme.order)
    shorter: Floats = np.minimum(turn, scheme.largest)
    return shorter


@np.errstate(all="ignore")
def numbers(
    kind: str,
    question: str | Criterion,
    method: str,
    forms: NDArray[np.str_],
    rates: Floats | None,
    span: float | None,
    steps: Floats | None,
    step: float | None,
    states: int,
) -> dict[str, Any]:
    """Step, steps, cost and error of the worst body, as far as they are known."""
    angles = None if rates is None or span is None else rates * span
    error = None if angles is None else ROUNDING * (1.0 + angles)
    if method == EXACT:
        costs = [CLOSED_FORM_COST[form] for form in set(forms.tolist())]
        by_form = (
            setup + states * state if isinstance(question, str) else verdict
            for setup, state, verdict in costs
        )
        cost = max(by_form, default=0.0)
        return {"step": None, "steps": 0, "cost": cost, "error": _worst(error)}
    if rates is None:
        return {"step": step, "steps": None, "cost": None, "error": None}
    if steps is None:
        steps = angle_per_step(method) / rates
    shortest = float(steps.min(initial=np.inf))
    taken = math.inf if span is None or shortest == 0.0 else span / shortest
    counted = taken < 2.0**63
    scheme = schemes()[method, kind]
    if angles is not None and error is not None:
        turn = np.where(rates > 0.0, rates * steps, 0.0)
        error = error + angles * scheme.factor * turn**scheme.order
    return {
        "step": shortest if shortest < np.inf else None,
        "steps": math.ceil(taken) if counted else None,
        "cost": math.ceil(taken) * _step_cost(scheme, question) if counted else None,
        "error": _worst(error),
    }


def _step_cost(scheme: Scheme, question: str | Criterion) -> float:
    """Nanoseconds a step."""
    if isinstance(question, str):
        return scheme.nanoseconds[question]
    if isinstance(question, NoFlip):
        return scheme.nanoseconds["rates"] + WATCHING["flips"]
    return scheme.nanoseconds["axis"] + WATCHING["tilt"]


def _worst(errors: Floats | None) -> float | None:
    """The largest error, None if none is known."""
    worst = None if errors is None else float(errors.max(initial=0.0))
    return worst if worst is not None and math.isfinite(worst) else None
