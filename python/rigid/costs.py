"""What a plan costs and how far it can be believed: models of time and error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .criteria import Criterion, NoFlip
from .methods import EXACT

__all__ = ["check_attainable", "numbers", "steps_for"]

Floats = NDArray[np.float64]

ANGLE_PER_STEP = 1.0 / 16.0
"""The angle (rad) that a body turns at most in a step that is left to the core."""

LARGEST_ANGLE_PER_STEP = 0.5
"""No accuracy is so low that a longer step is trusted to the model of its error."""

ROUNDING = 1e-15
"""Error of an attitude per radian turned that float64 leaves even to a closed form (rad)."""

PHASE_ERROR: Mapping[str, tuple[int, float]] = {
    "rk4": (4, 1.0 / 120.0),
    "splitting": (2, 1.0 / 24.0),
    "splitting4": (4, 3e-4),
    "splitting6": (6, 8e-5),
    "splitting8": (8, 1e-7),
    "chin4a": (4, 6e-5),
    "srkn6": (4, 7e-7),
    "srkn11": (6, 2e-8),
    "srkn14": (6, 2e-9),
    "pmlf4": (4, 2e-4),
    "pmlf6": (6, 3e-6),
    "dmv2": (2, 0.2),
    "dmv4": (4, 1e-2),
    "dmv6": (6, 2e-4),
    "dmv8": (8, 3e-6),
    "dmv10": (10, 3e-8),
}
"""Order p and factor c of the error ``c (h w)^p`` per radian turned at rate w with step h.

Of the compositions the worst of 60 random bodies of each kind."""

# Nanoseconds on one core: a body, a state of it and its class by closed form; a step by scene and
# question. The states pay for their way into arrays of Python.
CLOSED_FORM_COST: Mapping[str, tuple[float, float, float]] = {
    "axis spin": (100.0, 70.0, 30.0),
    "free symmetric": (100.0, 70.0, 60.0),
    "free asymmetric": (130.0, 110.0, 75.0),
    "lagrange": (190.0, 120.0, 120.0),
    "pendulum": (200.0, 130.0, 120.0),
}
STEP_COST: Mapping[tuple[str, str], Mapping[str, float]] = {
    ("rk4", "free"): {"rates": 1.3, "axis": 2.6, "attitude": 3.9, "flips": 1.6, "tilt": 3.3},
    ("rk4", "top"): {"rates": 3.3, "axis": 3.3, "attitude": 6.0, "flips": 3.9, "tilt": 4.0},
    ("splitting", "free"): {"rates": 4.4, "axis": 6.6, "attitude": 8.9, "flips": 4.7, "tilt": 7.0},
    ("splitting", "top"): {"rates": 5.8, "axis": 5.8, "attitude": 10.0, "flips": 6.1, "tilt": 6.5},
}


def _times(cost: Mapping[str, float], passes: int) -> dict[str, float]:
    return {question: passes * nanoseconds for question, nanoseconds in cost.items()}


# Compositions repeat the flows of "splitting"; of the others only drifts count.
_PASSES = {"splitting4": 6, "splitting6": 9, "splitting8": 17}
_DRIFTS = {"chin4a": 2, "srkn6": 6, "srkn11": 11, "srkn14": 15, "pmlf4": 1, "pmlf6": 3}
_FREE_PASS = {"rates": 3.9, "axis": 4.4, "attitude": 7.4, "flips": 3.9, "tilt": 4.4}
_TOP_PASS = {"rates": 5.0, "axis": 5.0, "attitude": 8.7, "flips": 5.1, "tilt": 5.1}
_FREE_DRIFT = {"rates": 9.8, "axis": 10.9, "attitude": 11.4, "flips": 10.2, "tilt": 11.4}
_TOP_DRIFT = {"rates": 11.2, "axis": 11.2, "attitude": 12.0, "flips": 11.6, "tilt": 11.6}
STEP_COST = {
    **STEP_COST,
    **{(name, "free"): _times(_FREE_PASS, n) for name, n in _PASSES.items()},
    **{(name, "top"): _times(_TOP_PASS, n) for name, n in _PASSES.items()},
    **{(name, "free"): _FREE_DRIFT for name in (*_DRIFTS, "dmv2", "dmv4", "dmv6", "dmv8", "dmv10")},
    **{(name, "top"): _times(_TOP_DRIFT, n) for name, n in _DRIFTS.items()},
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
def steps_for(accuracy: float, method: str, rates: Floats | None, span: float | None) -> Floats:
    """The step of each body whose phase error at the end is ``accuracy``."""
    if rates is None or span is None:
        missing = "omega" if rates is None else "t_end"
        raise ValueError(
            f"accuracy = {accuracy:g}: the step of {method!r} follows from the rates and the "
            f"horizon; {missing} is missing"
        )
    order, factor = PHASE_ERROR[method]
    angles = rates * span
    turn = ((accuracy - ROUNDING * (1.0 + angles)) / (factor * angles)) ** (1.0 / order)
    # What does not turn needs no step.
    return np.where(rates > 0.0, np.minimum(turn, LARGEST_ANGLE_PER_STEP) / rates, np.inf)


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
        steps = ANGLE_PER_STEP / rates
    shortest = float(steps.min(initial=np.inf))
    taken = math.inf if span is None or shortest == 0.0 else span / shortest
    counted = taken < 2.0**63
    if angles is not None and error is not None:
        order, factor = PHASE_ERROR[method]
        error = error + angles * factor * np.where(rates > 0.0, rates * steps, 0.0) ** order
    return {
        "step": shortest if shortest < np.inf else None,
        "steps": math.ceil(taken) if counted else None,
        "cost": math.ceil(taken) * STEP_COST[method, kind][_cost_of(question)] if counted else None,
        "error": _worst(error),
    }


def _cost_of(question: str | Criterion) -> str:
    """The question as the table of costs names it."""
    if isinstance(question, str):
        return question
    return "flips" if isinstance(question, NoFlip) else "tilt"


def _worst(errors: Floats | None) -> float | None:
    """The largest error, None if none is known."""
    worst = None if errors is None else float(errors.max(initial=0.0))
    return worst if worst is not None and math.isfinite(worst) else None
