"""The reference solution of a report: the closed form, or a converged run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..solve.methods import EXACT, methods
from ..solve.run import Run
from ..solve.simulate import simulate
from .ensemble import Ensemble

__all__ = ["Reference", "find_reference"]

Floats = NDArray[np.float64]

FIRST_ANGLE = 0.5
"""Angle (rad) turned in a step of the first run of a search for a reference."""

CONVERGED = 1e-6
"""Largest distance of two runs that have converged, whether or not the next run is closer."""


@dataclass(frozen=True, slots=True)
class Reference:
    """The solution against which errors are measured.

    Attributes
    ----------
    method : str
        ``"exact"`` or the method with the highest order.
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
    uncertainty: float
    worst: float


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
    orders = {method.name: method.order for method in methods()}
    name = max(usable, key=lambda method: orders[method])
    steps = max(1, int(np.ceil(ensemble.angle / FIRST_ANGLE)))
    before, apart = ensemble.run(name, steps), []
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
    off = np.maximum(apart, ensemble.rounding())
    return Reference(method, steps, float(np.median(off)), float(off.max()))
