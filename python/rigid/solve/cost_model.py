"""Calibrated models of the work and the error of a plan."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import two_digits_above
from ..model.criteria import Criterion
from ..model.scene import Scene
from .arrays import time_ranges, time_span
from .bodies import Bodies
from .closed_form import Codes, lagrange_axes, names
from .methods import is_processed, is_stiff, order_of
from .work import LANES, MANY, Work

__all__ = [
    "ROUNDING",
    "Constants",
    "Estimate",
    "Motions",
    "calibrated",
    "calibration_class_of_any",
    "calibration_class_of_forces",
    "calibration_classes",
    "cheapest",
    "check_attainable",
    "closed_form_estimate",
    "costliest",
    "joined",
    "phase_error",
    "some_of",
    "steps_estimate",
    "steps_for",
]

Floats = NDArray[np.float64]

ROUNDING = _core.ROUNDING
"""Rounding error of an attitude per radian turned (rad) in float64, even in closed form."""

PROCESSOR = 1e-12
"""Rounding (rad) of the change of variables before and after the steps of a processed method."""

ROUNDED = 1.01
"""Largest turn in a step, over the largest angle of a model: a turn has roundings."""

LAYER = 0.1
"""Longest step, over the damping time, that resolves how damping ends the motion of the start."""


@dataclass(frozen=True, slots=True)
class Constants:
    """Calibrated constants of a method for a class of bodies.

    The error of a run is about ``factor theta**order`` per radian turned, ``theta`` being the angle
    that the body turns in a step, up to ``largest``. Of many bodies 95 % err by at most ``margin``
    times as much. The constants of tops are known at some :meth:`ratios <.Bodies.weight_ratios>` of
    their weight, in ascending order; the constants of other bodies do not depend on it.
    """

    order: int
    ratios: Floats
    factors: Floats
    margins: Floats
    largests: Floats
    work: Mapping[str, Work]

    def factor(self, ratios: Floats) -> Floats:
        """The factors of bodies with these ratios of their weight: (n,), or (1,) of all."""
        return self._at(ratios, self.factors)

    def margin(self, ratios: Floats) -> Floats:
        """The margins for these ratios of the weight."""
        return self._at(ratios, self.margins)

    def largest(self, ratios: Floats) -> Floats:
        """The largest angles for these ratios of the weight."""
        return self._at(ratios, self.largests)

    def _at(self, ratios: Floats, values: Floats) -> Floats:
        return values if len(values) == 1 else np.interp(ratios, self.ratios, values)


@cache
def _calibration() -> dict[str, Any]:
    """All measured constants, which ``benches/calibrate.py`` wrote."""
    text = resources.files("rigid").joinpath("calibration.json").read_text(encoding="utf-8")
    calibration: dict[str, Any] = json.loads(text)
    return calibration


def _works(by_record: Mapping[str, list[float]]) -> dict[str, Work]:
    return {record: Work(*parts) for record, parts in by_record.items()}


@cache
def calibrated() -> dict[tuple[str, str], Constants]:
    """The constants of the methods, by name and class of bodies."""
    ratios = _calibration()["ratios"]
    return {
        (name, kind): Constants(
            order=order_of(name),
            ratios=np.array(ratios.get(kind, [0.0])),
            factors=np.array(entry["factor"]),
            margins=np.array(entry["margin"]),
            largests=np.array(entry["largest"]),
            work=_works(entry["work"]),
        )
        for name, kinds in _calibration()["methods"].items()
        for kind, entry in kinds.items()
    }


@cache
def _closed_form_work() -> dict[str, dict[str, Work]]:
    """The work of states by closed form, by class of bodies and record."""
    closed = _calibration()["closed forms"]
    return {kind: _works(by_record) for kind, by_record in closed.items()}


def calibration_classes(
    scene: Scene, moments: Floats, weight: Floats, forced: NDArray[np.bool_]
) -> NDArray[np.str_]:
    """The class of bodies on which the methods that move each body are calibrated, shape (n,).

    Of one element if all bodies are alike; the rows of a column may serve all.
    """
    forces = calibration_class_of_forces(scene)
    known = np.array([calibration_class_of_any(scene), "lagrange", forces])
    # By numbers, which are compared faster than names.
    classes = np.where(forced, 2, (lagrange_axes(moments, weight) > 0).astype(np.intp))
    if not len(classes):
        classes = np.array([2 if scene.forces else 0])
    same = bool(np.all(classes == classes[0]))
    return known[classes[:1] if same else classes]


def calibration_class_of_any(scene: Scene) -> str:
    """The class of bodies of any moments on which the methods that move this scene are calibrated.

    Nothing is applied. What a step costs depends on whether a direction is carried for the torque.
    """
    return "top" if scene.directions else "free"


def calibration_class_of_forces(scene: Scene) -> str:
    """The class of the bodies of this scene on which forces act.

    A step under further forces computes all of them.
    """
    return "further" if scene.has_further else "forced"


@np.errstate(all="ignore")
def cheapest(
    accuracy: float,
    kind: str,
    record: str,
    angles: Mapping[str, float],
    ratio: float,
) -> str:
    """The method that needs the least time for this error after these angles.

    Explicit steps follow the damping too: the angles include what damping takes away. The ratio is
    the ratio of the weight.
    """
    names = tuple(name for name, known in calibrated() if known == kind and name in angles)
    methods = _compared(names, kind, record)
    factors, largests = methods.at(ratio)
    each = np.array([angles[name] for name in names])
    turn = _turn(accuracy, each, factors, largests, methods.orders)
    times = np.where(turn > 0.0, methods.steps * np.maximum(each, 1e-300) / turn, np.inf)
    return names[int(times.argmin())]


@dataclass(frozen=True, slots=True)
class _Methods:
    """Constants of k methods for a class of bodies, known at r ratios of the weight.

    Attributes
    ----------
    ratios : ndarray, shape (r,)
    orders, steps : ndarray, shape (k,)
        The orders, and the work of a step.
    factors, largests : ndarray, shape (r, k)
    """

    ratios: Floats
    orders: Floats
    steps: Floats
    factors: Floats
    largests: Floats

    def at(self, ratio: float) -> tuple[Floats, Floats]:
        """Factors and largest angles, interpolated once for all methods."""
        last = len(self.ratios) - 1
        place = float(np.interp(ratio, self.ratios, np.arange(last + 1)))
        low, high = int(place), min(int(place) + 1, last)
        known = (self.factors, self.largests)
        factors, largests = (rows[low] + (place - low) * (rows[high] - rows[low]) for rows in known)
        return factors, largests


@cache
def _compared(names: tuple[str, ...], kind: str, record: str) -> _Methods:
    """The constants of some methods, to be compared at once."""
    each = [calibrated()[name, kind] for name in names]
    return _Methods(
        ratios=each[0].ratios,
        orders=np.array([float(known.order) for known in each]),
        steps=np.array([known.work[record].step for known in each]),
        factors=np.stack([known.factors for known in each], axis=1),
        largests=np.stack([known.largests for known in each], axis=1),
    )


CLASS_WORK: Mapping[str, float] = {
    "axis spin": 0.7,
    "free symmetric": 0.75,
    "free asymmetric": 0.83,
    "lagrange": 1.2,
    "pendulum": 1.2,
}
"""Work of a sample of a map by closed form, its start included."""


def check_attainable(accuracy: float, angles: Floats) -> None:
    """Raise ValueError if the error from rounding exceeds the accuracy."""
    floor = ROUNDING * (1.0 + angles.max(initial=0.0))
    if accuracy <= floor:
        raise ValueError(
            f"accuracy = {accuracy:g}: must be at least {two_digits_above(floor)}; rounding errs "
            f"by {floor:.2e} in {angles.max(initial=0.0):.3g} rad"
        )


@np.errstate(all="ignore")
def steps_for(
    accuracy: float, constants: Constants, rates: Floats, span: float | Floats, ratios: Floats
) -> Floats:
    """The step of each body whose error at the end is ``accuracy``."""
    # What does not turn needs no step.
    known = constants.factor(ratios), constants.largest(ratios)
    turn = _turn(accuracy, rates * span, *known, constants.order)
    return np.where(rates > 0.0, turn / rates, np.inf)


def _turn(
    accuracy: float, angles: Floats, factors: Floats, largests: Floats, orders: Floats | int
) -> Floats:
    """The angle turned in a step for this error after these angles, at most the largest known."""
    left = np.maximum(accuracy - ROUNDING * (1.0 + angles), 0.5 * accuracy)
    turn = (left / (factors * angles)) ** (1.0 / orders)
    shorter: Floats = np.minimum(turn, largests)
    return shorter


@dataclass(frozen=True, slots=True)
class Estimate:
    """Work and error of a plan; the error is the largest of its bodies, None if unknown.

    Attributes
    ----------
    step : float or None
        The shortest step (s).
    steps : int or None
        Number of steps of the body.
    work : float or None
        Work of a body, in units.
    error : float or None
        Error of the attitude at the end (rad).
    unknown : str or None
        Why the model does not know the error.
    """

    step: float | None
    steps: int | None
    work: float | None
    error: float | None
    unknown: str | None = None


def closed_form_estimate(
    question: str | Criterion,
    forms: Codes,
    states: int,
    rates: Floats | None,
    span: float | Floats | None,
    bodies: int = MANY,
) -> Estimate:
    """Work and error of closed forms.

    Parameters
    ----------
    question : str or Criterion
    forms : ndarray
        The closed forms that occur, by their codes.
    states : int
        Number of requested states of a body.
    rates : ndarray, shape (n,), or None
        Bounds of the rates (rad/s), None if they are not known.
    span : float, ndarray of shape (n,), or None
        How much time is covered (s).
    bodies : int
        Number of bodies of the call.
    """
    of_forms = [
        _closed_form_work()["lagrange" if form in ("lagrange", "pendulum") else "free"][
            question
        ].of_a_body(bodies, states, 0.0)
        if isinstance(question, str)
        else CLASS_WORK[form]
        for form in names(forms)
    ]
    if rates is None or span is None:
        error = None
    elif len(rates) == 1 and isinstance(span, float):
        # One number is multiplied faster outside of an array.
        error = _finite(ROUNDING * (1.0 + float(rates[0]) * span))
    else:
        with np.errstate(all="ignore"):
            error = _worst(ROUNDING * (1.0 + rates * span))
    return Estimate(None, 0, max(of_forms, default=0.0), error)


@np.errstate(all="ignore")
def phase_error(
    bodies: Bodies, method: str, times: Floats, taken: Floats, tolerance: float | None
) -> Floats:
    """The error (rad) of some bodies after so many steps, from the model; shape (n,)."""
    angles = bodies.fastest_rates(time_ranges(times), method) * time_span(times)
    if tolerance is not None:
        return tolerance * angles
    weighs = np.where(bodies.weight.any(axis=1), "top", "free")
    kinds = np.where(lagrange_axes(bodies.moments, bodies.weight), "lagrange", weighs)
    if bodies.forces is not None:
        kinds = np.where(bodies.under_forces(), "forced", kinds)
    known, which = np.unique(kinds, return_inverse=True)
    ratios = bodies.weight_ratios(bodies.fastest_rates(time_ranges(times)))
    factors = np.empty(len(bodies))
    for number, kind in enumerate(known.tolist()):
        # A row that serves all bodies has one class.
        mine = slice(None) if len(known) == 1 else which == number
        factors[mine] = calibrated()[method, kind].factor(ratios[mine])
    error: Floats = angles * factors * (angles / taken) ** order_of(method)
    return error


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """The quantities of n bodies from which steps and their error follow.

    Attributes
    ----------
    rates : ndarray, shape (n,)
        The rates (rad/s) that the steps follow.
    ratios : ndarray, shape (n,)
        The ratios of the weight of the bodies.
    steps : ndarray, shape (n,)
        The longest steps (s).
    span : float, ndarray of shape (n,), or None
        How much time is covered (s); None if it is not known.
    states : int
        Number of requested states of a body.
    damping : ndarray, shape (n,), or float
        The largest damping rates (1/s). The error of a stiff method is not known unless its steps
        follow the damping: the model does not contain the layer in which the start is forgotten.
    nearness : ndarray, shape (n,), or float
        How many times the angle of a step counts, from the poles of the motion of free bodies.
    slowness : ndarray, shape (n,), or float
        How many times slower a body starts than weight or torque can make it: they change its rates
        at once by a share of them, which in less than a radian errs by more than its attitude.
    rounding : ndarray, shape (n,), or float
        Error from the rounding of steps, besides the error of each radian turned.
    """

    rates: Floats
    ratios: Floats
    steps: Floats
    span: float | Floats | None
    states: int = 1
    damping: Floats | float = 0.0
    nearness: Floats | float = 1.0
    slowness: Floats | float = 1.0
    rounding: Floats | float = 0.0

    @property
    def taken(self) -> Floats:
        """About how many steps each body takes, shape (n,) or (1,)."""
        if self.span is None:
            return np.full(1, np.inf)
        # Each interval between output times has a whole number of steps.
        least = max(self.states, 1)
        with np.errstate(all="ignore"):
            each = np.ceil(self.span / self.steps + 0.5 * (self.states - 1))
        taken: Floats = np.maximum(each, least)
        return taken

    def of(self, bodies: slice | NDArray[np.intp]) -> Motions:
        """The motions of some bodies."""
        return replace(self, **{name: some_of(getattr(self, name), bodies) for name in _OF_EACH})


_OF_EACH = ("rates", "ratios", "steps", "span", "damping", "nearness", "slowness", "rounding")


def joined(parts: Sequence[Motions]) -> Motions:
    """All motions of some parts, each of which covers a known time."""

    def every(name: str) -> Floats:
        each = (np.broadcast_to(getattr(part, name), len(part.rates)) for part in parts)
        return np.concatenate([np.zeros(0), *each])

    columns: dict[str, Any] = {name: every(name) for name in _OF_EACH}
    return Motions(**columns)


def some_of(values: Any, mine: slice | NDArray[np.intp]) -> Any:
    """The values of some bodies, or the value of all."""
    return values[mine] if isinstance(values, np.ndarray) and values.ndim else values


@np.errstate(all="ignore")
def steps_estimate(
    question: str | Criterion, method: str, kind: str, motions: Motions, bodies: int = MANY
) -> Estimate:
    """Work and error of a method.

    The error is the error of the model times its margin; it is None for longer steps than the model
    covers.

    Parameters
    ----------
    question : str or Criterion
    method, kind : str
        A method and the class of bodies that it is calibrated on.
    motions : Motions
    bodies : int
        Number of bodies of the call.
    """
    rates, span, states = motions.rates, motions.span, motions.states
    shortest = float(motions.steps.min(initial=np.inf))
    each = motions.taken
    taken = float(each.max(initial=0.0))
    counted = taken < 2.0**63
    constants = calibrated()[method, kind]
    largest = constants.largest(motions.ratios)
    error, unknown = None, None
    turn = np.where(rates > 0.0, rates * motions.steps, 0.0)
    too_wide = turn > ROUNDED * largest
    if is_stiff(method) and np.any(motions.steps * motions.damping > LAYER):
        unknown = f"the steps are longer than {LAYER:g} of the time of the damping"
    elif np.any(too_wide):
        body = int(np.argmax(too_wide))
        most = np.broadcast_to(largest, turn.shape)[body]
        unknown = f"a step turns a body by {turn[body]:.3g} rad, and the model of {method} holds \
up to {most:.3g} rad"
    elif span is not None:
        if is_stiff(method):
            # The rates that other steps follow contain the damping.
            rates = rates + motions.damping
        angles = rates * span
        error = ROUNDING * (1.0 + angles) + motions.rounding + PROCESSOR * is_processed(method)
        counts = np.maximum(angles, np.minimum(angles * motions.slowness, 1.0))
        truncation = (
            constants.factor(motions.ratios)
            * (rates * motions.steps * motions.nearness) ** constants.order
        )
        error += constants.margin(motions.ratios) * counts * truncation
    return Estimate(
        step=shortest if shortest < np.inf else None,
        steps=int(taken) if counted else None,
        work=_work(constants, question).of_a_body(
            bodies, states, _by_group(each), _ends(each / max(states, 1))
        )
        if counted
        else None,
        error=_worst(error),
        unknown=unknown,
    )


def costliest(parts: Sequence[Estimate]) -> Estimate:
    """The largest of some estimates, and the shortest step; unknown if one of these is unknown."""

    def of_all(name: str, choose: Callable[[list[Any]], Any]) -> Any:
        values = [getattr(part, name) for part in parts]
        return None if None in values else choose(values)

    return Estimate(
        step=of_all("step", min),
        steps=of_all("steps", max),
        work=of_all("work", max),
        error=of_all("error", max),
        unknown=next((part.unknown for part in parts if part.unknown is not None), None),
    )


def _by_group(steps: Floats) -> float:
    """The mean number of steps of groups, each of which takes the most steps of its bodies.

    Groups are formed by the numbers of steps.
    """
    if not len(steps):
        return 0.0
    return float(np.maximum.reduceat(np.sort(steps), np.arange(0, len(steps), LANES)).mean())


def _ends(steps: Floats) -> float:
    """The mean number of distinct numbers of steps of the bodies of a group."""
    if not len(steps) or steps.min() == steps.max():
        return 1.0
    groups = np.full((math.ceil(len(steps) / LANES), LANES), np.nan)
    groups.flat[: len(steps)] = np.sort(np.ceil(steps))
    return 1.0 + float(np.count_nonzero(np.diff(groups, axis=1) > 0.0)) / len(groups)


def _work(constants: Constants, question: str | Criterion) -> Work:
    """The parts of the work; a criterion is watched at each step."""
    if isinstance(question, str):
        return constants.work[question]
    known = constants.work[question.record]
    return replace(known, step=question.watched(known.step))


def _worst(errors: Floats | None) -> float | None:
    """The largest error; None if no error is known."""
    return None if errors is None else _finite(float(errors.max(initial=0.0)))


def _finite(number: float) -> float | None:
    """The number, None if it is not finite."""
    return number if math.isfinite(number) else None
