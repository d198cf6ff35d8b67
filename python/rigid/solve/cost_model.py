"""Cost and error of a plan: calibrated models."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.criteria import Criterion
from ..model.scene import Scene
from .arrays import time_range, time_span
from .batch import Batch
from .closed_form import lagrange_axis_of
from .methods import is_processed, is_stiff, order_of

__all__ = [
    "ROUNDING",
    "Estimate",
    "Scheme",
    "calibration_class",
    "calibration_class_of_any",
    "cheapest",
    "check_attainable",
    "closed_form_estimate",
    "phase_error",
    "schemes",
    "steps_estimate",
    "steps_for",
]

Floats = NDArray[np.float64]

ROUNDING = 1e-15
"""Error of an attitude per radian turned that float64 leaves even to a closed form (rad)."""


MARGIN = 5.0
"""The error of the model is that of a body in the middle of many; a plan states this times it."""

PROCESSOR = 1e-12
"""Rounding (rad) of the change of variables before and after the steps of a processed scheme."""

LAYER = 0.1
"""Steps longer than this share of the damping time do not resolve how damping forgets a start."""


@dataclass(frozen=True, slots=True)
class Scheme:
    """Calibrated constants of a scheme for a class of bodies.

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


def calibration_class(scene: Scene) -> str:
    """The class of bodies on which the schemes that move this scene are calibrated."""
    if scene.is_driven:
        return "driven"
    lagrange = lagrange_axis_of(scene.body.moments, scene.weight)
    return "lagrange" if lagrange else calibration_class_of_any(scene)


def calibration_class_of_any(scene: Scene) -> str:
    """The class of bodies of any moments on which the schemes that move this scene are calibrated.

    Nothing is applied. What a step costs depends on whether a direction is carried for the torque.
    """
    return "top" if scene.directions else "free"


@np.errstate(all="ignore")
def cheapest(
    accuracy: float, kind: str, question: str | Criterion, angles: Mapping[str, float]
) -> str:
    """The scheme that needs the least time for this error after these angles (rad).

    Explicit steps follow the damping too: the angles include what damping takes away.
    """

    def time(name: str) -> float:
        scheme, angle = schemes()[name, kind], angles[name]
        turn = _turn(scheme, accuracy, np.array(angle)).item()
        return _step_cost(scheme, question) * max(angle, 1e-300) / turn

    return min((name for name, known in schemes() if known == kind and name in angles), key=time)


# Nanoseconds on one core: a body, a state of the body and its class by closed form. The time of a
# state includes the copy into arrays of Python.
CLOSED_FORM_COST: Mapping[str, tuple[float, float, float]] = {
    "axis spin": (100.0, 70.0, 30.0),
    "free symmetric": (100.0, 70.0, 60.0),
    "free asymmetric": (130.0, 110.0, 75.0),
    "lagrange": (190.0, 120.0, 120.0),
    "pendulum": (200.0, 130.0, 120.0),
}


def check_attainable(accuracy: float, angles: Floats) -> None:
    """Raise ValueError if the error from rounding exceeds the accuracy."""
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


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost and error of a plan, the largest of its bodies; None if unknown.

    Attributes
    ----------
    step : float or None
        The shortest step (s).
    steps : int or None
        Number of steps of the body.
    cost : float or None
        Processor time of a body (ns).
    error : float or None
        Error of the attitude at the end (rad).
    """

    step: float | None
    steps: int | None
    cost: float | None
    error: float | None


@np.errstate(all="ignore")
def closed_form_estimate(
    question: str | Criterion,
    forms: NDArray[np.str_],
    states: int,
    rates: Floats | None,
    span: float | None,
) -> Estimate:
    """Cost and error of closed forms.

    Parameters
    ----------
    question : str or Criterion
    forms : ndarray of str
        The closed forms that occur.
    states : int
        Number of requested states of a body.
    rates : ndarray, shape (n,), or None
        Bounds of the rates (rad/s), None if they are not known.
    span : float or None
        How much time is covered (s).
    """
    costs = [CLOSED_FORM_COST[form] for form in set(forms.tolist())]
    by_form = (
        setup + states * state if isinstance(question, str) else classification
        for setup, state, classification in costs
    )
    error = None if rates is None or span is None else ROUNDING * (1.0 + rates * span)
    return Estimate(None, 0, max(by_form, default=0.0), _worst(error))


@np.errstate(all="ignore")
def phase_error(
    batch: Batch, method: str, times: Floats, taken: Floats, tolerance: float | None
) -> Floats:
    """The error (rad) of some bodies after so many steps, from the model; shape (n,)."""
    angles = batch.fastest_rates(time_range(times), method) * time_span(times)
    if tolerance is not None:
        return tolerance * angles
    if batch.forcing is not None:
        kind = "driven"
    elif lagrange_axis_of(batch.moments[0], batch.weight[0]):
        kind = "lagrange"
    else:
        kind = "top" if batch.weight.any() else "free"
    scheme = schemes()[method, kind]
    return angles * scheme.factor * (angles / taken) ** scheme.order


@np.errstate(all="ignore")
def steps_estimate(
    question: str | Criterion,
    method: str,
    kind: str,
    rates: Floats | None,
    span: float | None,
    steps: Floats | float | None,
    damping: float = 0.0,
) -> Estimate:
    """Cost and error of a scheme.

    The error is that of the model times a margin.

    Parameters
    ----------
    question : str or Criterion
    method, kind : str
        A scheme and the class of bodies that it is calibrated on.
    rates : ndarray, shape (n,), or None
        The rates (rad/s) that the steps follow, None if they are not known.
    span : float or None
        How much time is covered (s).
    steps : ndarray, shape (n,), float or None
        The longest step of each body or of all (s); None leaves them to the method.
    damping : float
        The largest damping rate (1/s). The error of a stiff scheme is not known unless its steps
        follow the damping: the model does not contain the layer in which the start is forgotten.
    """
    if rates is None:
        return Estimate(steps if isinstance(steps, float) else None, None, None, None)
    if steps is None:
        steps = _core.default_steps(method, rates)
    steps = np.broadcast_to(steps, rates.shape)
    shortest = float(steps.min(initial=np.inf))
    taken = math.inf if span is None or shortest == 0.0 else span / shortest
    counted = taken < 2.0**63
    scheme = schemes()[method, kind]
    error = None
    layer = is_stiff(method) and bool(np.any(steps * damping > LAYER))
    if span is not None and not layer:
        angles = rates * span
        turn = np.where(rates > 0.0, rates * steps, 0.0)
        error = ROUNDING * (1.0 + angles) + PROCESSOR * is_processed(method)
        error += MARGIN * angles * scheme.factor * turn**scheme.order
    return Estimate(
        step=shortest if shortest < np.inf else None,
        steps=math.ceil(taken) if counted else None,
        cost=math.ceil(taken) * _step_cost(scheme, question) if counted else None,
        error=_worst(error),
    )


def _step_cost(scheme: Scheme, question: str | Criterion) -> float:
    """Nanoseconds a step."""
    if isinstance(question, str):
        return scheme.nanoseconds[question]
    return scheme.nanoseconds[question.record] + question.watch_cost


def _worst(errors: Floats | None) -> float | None:
    """The largest error, None if none is known."""
    worst = None if errors is None else float(errors.max(initial=0.0))
    return worst if worst is not None and math.isfinite(worst) else None
