"""The calibrated model of errors and costs, by which a method is chosen."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import two_digits_above
from ..model.scene import Scene
from .arrays import time_ranges, time_span
from .bodies import Bodies
from .closed_form import lagrange_axes
from .methods import order_of

__all__ = [
    "ROUNDING",
    "Constants",
    "calibrated",
    "calibration_class_of_any",
    "calibration_class_of_forces",
    "calibration_classes",
    "cheapest",
    "check_attainable",
    "phase_error",
    "some_of",
    "steps_for",
]

Floats = NDArray[np.float64]

ROUNDING = _core.ROUNDING
"""Rounding error of an attitude per radian turned (rad) in float64, even in closed form."""


@dataclass(frozen=True, slots=True)
class Constants:
    """Calibrated constants of a method for a class of bodies.

    The error of a run is about ``factor theta**order`` per radian turned, ``theta`` being the angle
    that the body turns in a step, up to ``largest``. The constants of tops are known at some
    :meth:`ratios <.Bodies.weight_ratios>` of their weight, in ascending order; the constants of
    other bodies do not depend on it.
    """

    order: int
    ratios: Floats
    factors: Floats
    largests: Floats
    step_costs: Mapping[str, float]

    def factor(self, ratios: Floats) -> Floats:
        """The factors of bodies with these ratios of their weight: (n,), or (1,) of all."""
        return self._at(ratios, self.factors)

    def largest(self, ratios: Floats) -> Floats:
        """The largest angles for these ratios of the weight."""
        return self._at(ratios, self.largests)

    def _at(self, ratios: Floats, values: Floats) -> Floats:
        return values if len(values) == 1 else np.interp(ratios, self.ratios, values)


@cache
def _calibration() -> dict[str, Any]:
    """All measured constants."""
    text = resources.files("rigid").joinpath("calibration.json").read_text(encoding="utf-8")
    calibration: dict[str, Any] = json.loads(text)
    return calibration


@cache
def calibrated() -> dict[tuple[str, str], Constants]:
    """The constants of the methods, by name and class of bodies."""
    ratios = _calibration()["ratios"]
    return {
        (name, kind): Constants(
            order=order_of(name),
            ratios=np.array(ratios.get(kind, [0.0])),
            factors=np.array(entry["factor"]),
            largests=np.array(entry["largest"]),
            step_costs={record: parts[5] for record, parts in entry["work"].items()},
        )
        for name, kinds in _calibration()["methods"].items()
        for kind, entry in kinds.items()
    }


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
        steps=np.array([known.step_costs[record] for known in each]),
        factors=np.stack([known.factors for known in each], axis=1),
        largests=np.stack([known.largests for known in each], axis=1),
    )


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


def some_of(values: Any, mine: slice | NDArray[np.intp]) -> Any:
    """The values of some bodies, or the value of all."""
    return values[mine] if isinstance(values, np.ndarray) and values.ndim else values
