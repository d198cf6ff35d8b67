"""The reference solution over each horizon of a report: the closed form, or a converged run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from .. import _core
from .._checks.arrays import Floats
from ..solve.methods import EXACT, order_of
from ..solve.run import Run
from ..solve.simulate import simulate
from .ensemble import SHORT, Ensemble, ensemble_of
from .spec import ReportSpec

FIRST_ANGLE = 0.5
"""Angle (rad) turned in a step of the first run of a search for a reference."""

CONVERGED = 1e-6
"""Largest distance of two runs that have converged, whether or not the next run is closer."""

TRIAL = 10.0
"""Revolutions of the first search for a reference over revolutions: it shows what one costs."""

LOST = 1.0
"""A reference that may be off by more (rad) is lost, and none is looked for over a longer time."""


Unbounded: TypeAlias = float
"""An error, which is infinite where nothing is known; a file has null for it."""


@dataclass(frozen=True, slots=True)
class Reference:
    """The solution against which errors are measured.

    Attributes
    ----------
    method : str
        ``"exact"`` or the method with the highest order; empty if there was no time to find one.
    steps : int
        Number of steps of the reference; 0 by closed form.
    uncertainty, worst : float
        Estimated error of the reference: median and largest of the ensemble. For a closed form it
        is the difference between one evaluation and two in a row; for a method, the larger
        difference to half and twice the step, or, if the time limit was reached, to twice the
        step. It is at least the rounding error, ``1e-15`` per radian turned.
    """

    method: str
    steps: int
    uncertainty: Unbounded
    worst: Unbounded


UNKNOWN = Reference("", 0, math.inf, math.inf)


class Horizon(NamedTuple):
    """The bodies until the end of a horizon, and their true motion as far as it is known."""

    revolutions: float
    ensemble: Ensemble
    reference: Reference
    truth: Run | None


def find_horizons(
    spec: ReportSpec,
    usable: Sequence[str],
    allowed: Callable[[float], bool],
    told: Callable[[], object],
) -> list[Horizon]:
    """The horizons of a specification, from short to long.

    Over revolutions a method is compared with one of twice the step, and none is looked for if it
    was lost before, or if there is no time. ``told()`` is called after each horizon.
    """
    if not spec.revolutions:
        ensemble = ensemble_of(spec)
        return [Horizon(spec.horizons[0], ensemble, *find_reference(ensemble, usable, allowed))]
    found: list[Horizon] = []
    seconds, worst = 0.0, 0.0
    for count in (min(TRIAL, spec.revolutions[0]), *spec.revolutions):
        ensemble = ensemble_of(spec, spec.time_of(count))
        begun = time.perf_counter()
        reference, truth = UNKNOWN, None
        expected = seconds * count / found[-1].revolutions if found else 0.0
        if EXACT in usable or (worst < LOST and (not found or allowed(expected))):
            reference, truth = find_reference(ensemble, usable, lambda _: False)
            seconds = time.perf_counter() - begun
        worst = reference.worst
        found.append(Horizon(count, ensemble, reference, truth))
        told()
    return found[1:]


def find_reference(
    ensemble: Ensemble, usable: Sequence[str], allowed: Callable[[float], bool]
) -> tuple[Reference, Run]:
    """The closed form where the ensemble has one, else a converged run of the highest order.

    Parameters
    ----------
    ensemble : Ensemble
        The bodies.
    usable : sequence of str
        Methods that accept the scene.
    allowed : callable
        ``allowed(seconds)`` is whether there is time for a run of that length.
    """
    if EXACT in usable:
        truth = ensemble.run(EXACT)
        return _reference(EXACT, 0, _in_two_evaluations(ensemble, truth), ensemble), truth
    name = max(usable, key=order_of)
    steps = max(1, int(np.ceil(ensemble.angle / FIRST_ANGLE)))
    while True:
        try:
            before, apart = ensemble.run(name, steps), []
            break
        except ValueError:  # so long a step would be unstable
            if ensemble.angle < SHORT * steps:
                raise
            steps *= 2
    while True:
        begun = time.perf_counter()
        steps *= 2
        truth = ensemble.run(name, steps)
        apart.append(np.maximum(*ensemble.distance(before, truth)))
        medians = [float(np.median(one)) for one in apart[-2:]]
        if len(apart) > 2 and medians[1] < CONVERGED and medians[1] >= 0.5 * medians[0]:
            # Only rounding errors are left, and they grow with the steps: the run before is better,
            # and the runs with half and twice its steps show its error.
            return _reference(name, steps // 2, np.maximum(*apart[-2:]), ensemble), before
        if len(apart) > 1 and not allowed(2.0 * (time.perf_counter() - begun)):
            return _reference(name, steps, apart[-1], ensemble), truth
        before = truth


def _in_two_evaluations(ensemble: Ensemble, truth: Run) -> Floats:
    """Difference of the closed form at ``t_end`` and two evaluations in a row, each over half."""
    scene, attitude, half = ensemble.spec.scene, ensemble.spec.attitude, 0.5 * ensemble.spec.t_end
    middle = simulate(scene, ensemble.omega, attitude, t=[half], method=EXACT, threads=1)
    assert middle.attitude is not None
    there = (middle.omega[:, 0], middle.attitude[:, 0])
    end = simulate(scene, *there, t=[ensemble.spec.t_end - half], method=EXACT, threads=1)
    return np.maximum(*ensemble.distance(end, truth))


def _reference(method: str, steps: int, apart: Floats, ensemble: Ensemble) -> Reference:
    turned = ensemble.rates * ensemble.spec.t_end
    off = np.maximum(apart, _core.ROUNDING * (1.0 + turned))  # as plans estimate rounding
    return Reference(method, steps, float(np.median(off)), float(off.max()))
