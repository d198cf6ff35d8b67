"""The cloud of bodies that a report runs, and how far a run of it is from the truth."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .columns import columns, fastest_rates
from .costs import ROUNDING
from .methods import EXACT, methods
from .reportspec import ReportSpec
from .simulate import Run, Status, simulate

__all__ = ["Cloud", "Reference", "attitude_angle", "cloud_of", "find_reference"]

Floats = NDArray[np.float64]

PERTURBATION = 1e-3
"""Standard deviation of the relative perturbation of each rate."""

FIRST_ANGLE = 0.5
"""Angle (rad) turned in a step of the first run of a search for a reference."""

CONVERGED = 1e-6
"""Two runs that are further apart have not converged, whether or not the next is any closer."""


@dataclass(frozen=True, slots=True)
class Cloud:
    """The bodies of a report: the given start, and others close to it.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    omega : ndarray, shape (n, 3)
        Rates at the start (rad/s): those given times ``1 + 1e-3 N(0, 1)``, the first row without.
        What is zero stays zero, so that a swing in a plane remains one.
    rates : ndarray, shape (n,)
        Bound of the rate of each body (rad/s).
    """

    spec: ReportSpec
    omega: Floats
    rates: Floats

    @property
    def angle(self) -> float:
        """Bound of the angle that the fastest body turns until ``t_end`` (rad)."""
        return float(self.rates.max()) * self.spec.t_end

    def step(self, steps: int) -> float:
        """A step that makes that many of ``t_end``: at least the quotient, so never one more."""
        return float(np.nextafter(self.spec.t_end / steps, np.inf))

    def run(self, method: str, steps: int = 0, *, times: int = 1) -> Run:
        """The cloud until ``times`` horizons, each of that many steps, on one thread."""
        step = None if method == EXACT else self.step(steps)
        return simulate(
            self.spec.scene,
            self.omega,
            self.spec.attitude,
            t=[times * self.spec.t_end],
            method=method,
            step=step,
            check=False,
            max_steps=2**62,
            threads=1,
        )

    def distance(self, run: Run, truth: Run) -> tuple[Floats, Floats]:
        """How far the last states of two runs are from each other, shape (n,) each.

        The largest component of the difference of the rates, relative to the larger ``|omega|`` of
        start and end; and the angle between the attitudes (rad). Infinite for a body that did not
        arrive.
        """
        here, there = run.omega[:, -1], truth.omega[:, -1]
        lengths = [np.linalg.norm(rates, axis=1) for rates in (self.omega, there)]
        scale = np.maximum(*lengths)
        scale = np.where(scale > 0.0, scale, np.where(self.rates > 0.0, self.rates, 1.0))
        assert run.attitude is not None
        assert truth.attitude is not None
        with np.errstate(all="ignore"):
            of_rates = np.abs(here - there).max(axis=1) / scale
            of_attitude = attitude_angle(run.attitude[:, -1], truth.attitude[:, -1])
        arrived = np.isin(run.status, (Status.OK, Status.FLAGGED))
        known = arrived & np.isfinite(of_rates) & np.isfinite(of_attitude)
        return np.where(known, of_rates, np.inf), np.where(known, of_attitude, np.inf)

    def rounding(self) -> Floats:
        """What rounding leaves of each body's attitude at the end, as plans estimate it (rad)."""
        left: Floats = ROUNDING * (1.0 + self.rates * self.spec.t_end)
        return left


@dataclass(frozen=True, slots=True)
class Reference:
    """What errors are measured against.

    Attributes
    ----------
    method : str
        ``"exact"`` or the scheme with the highest order.
    steps : int
        Its steps; 0 by closed form.
    uncertainty, worst : float
        By how much the reference itself may be off: median and largest of the cloud. By closed
        form: the difference between one leap and two; of a scheme: the larger difference to half
        and twice its step, or, if the time was over, to twice its step. At least what rounding
        leaves, ``1e-15`` per radian turned.
    """

    method: str
    steps: int
    uncertainty: float
    worst: float


def cloud_of(spec: ReportSpec) -> Cloud:
    """The cloud of a specification; equal specifications have equal clouds."""
    generator = np.random.Generator(np.random.Philox(key=spec.seed))
    factors = 1.0 + PERTURBATION * generator.standard_normal((spec.bodies, 3))
    factors[0] = 1.0
    omega = np.array(spec.omega) * factors
    table, _ = columns(spec.scene, omega, spec.attitude)
    return Cloud(spec, omega, fastest_rates(table, (0.0, spec.t_end)))


def attitude_angle(attitude: ArrayLike, reference: ArrayLike) -> Floats:
    """Angle of the rotation between attitudes (..., 4), rad; their lengths and signs are free.

    From the sine and the cosine of its half, so that small angles keep their digits.
    """
    a, b = np.asarray(attitude), np.asarray(reference)
    w, u = a[..., 0], a[..., 1:]
    v, s = b[..., 1:], b[..., 0]
    sine = np.linalg.norm(s[..., None] * u - w[..., None] * v - np.cross(v, u), axis=-1)
    angle: Floats = 2.0 * np.arctan2(sine, np.abs((a * b).sum(axis=-1)))
    return angle


def find_reference(
    cloud: Cloud, usable: Sequence[str], allowed: Callable[[float], bool]
) -> tuple[Reference, Run]:
    """The closed form where the cloud has one, else the scheme with the highest order, converged.

    Parameters
    ----------
    cloud : Cloud
        The bodies.
    usable : sequence of str
        Methods that accept the scene.
    allowed : callable
        Tells whether there is time for a run of so many seconds.
    """
    if EXACT in usable:
        truth = cloud.run(EXACT)
        return _reference(EXACT, 0, _in_two_leaps(cloud, truth), cloud), truth
    orders = {method.name: method.order for method in methods()}
    name = max(usable, key=lambda method: orders[method])
    steps = max(1, int(np.ceil(cloud.angle / FIRST_ANGLE)))
    before, apart = cloud.run(name, steps), []
    while True:
        begun = time.perf_counter()
        steps *= 2
        truth = cloud.run(name, steps)
        apart.append(np.maximum(*cloud.distance(before, truth)))
        medians = [float(np.median(one)) for one in apart[-2:]]
        if len(apart) > 2 and medians[1] < CONVERGED and medians[1] > 0.5 * medians[0]:
            # Only rounding is left, and the more of it the more steps: the run before is better,
            # and stands between two that show how far it is off.
            return _reference(name, steps // 2, np.maximum(*apart[-2:]), cloud), before
        if len(apart) > 1 and not allowed(2.0 * (time.perf_counter() - begun)):
            return _reference(name, steps, apart[-1], cloud), truth
        before = truth


def _in_two_leaps(cloud: Cloud, truth: Run) -> Floats:
    """Difference of the closed form over ``t_end`` and twice over half of it."""
    scene, half = cloud.spec.scene, 0.5 * cloud.spec.t_end
    middle = simulate(scene, cloud.omega, cloud.spec.attitude, t=[half], method=EXACT, threads=1)
    assert middle.attitude is not None
    there = (middle.omega[:, 0], middle.attitude[:, 0])
    end = simulate(scene, *there, t=[cloud.spec.t_end - half], method=EXACT, threads=1)
    return np.maximum(*cloud.distance(end, truth))


def _reference(method: str, steps: int, apart: Floats, cloud: Cloud) -> Reference:
    off = np.maximum(apart, cloud.rounding())
    return Reference(method, steps, float(np.median(off)), float(off.max()))
