"""The ensemble of bodies that a report runs, and the distance between two of its runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..solve.methods import EXACT
from ..solve.run import Run
from ..solve.simulate import simulate
from ..solve.starts import bodies_of
from ..solve.status import ARRIVED
from .spec import ReportSpec

__all__ = ["Ensemble", "attitude_angle", "ensemble_of"]

Floats = NDArray[np.float64]

PERTURBATION = 1e-3
"""Standard deviation of the relative perturbation of each rate."""


@dataclass(frozen=True, slots=True)
class Ensemble:
    """The bodies of a report: the given start, and others close to it.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    omega : ndarray, shape (n, 3)
        Rates at the start (rad/s): the given rates times ``1 + 1e-3 N(0, 1)``; the first row is not
        perturbed. A rate of zero stays zero, so that planar motion remains planar.
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
        """The step that makes so many of ``t_end``: at least the quotient, so never one more."""
        return float(np.nextafter(self.spec.t_end / steps, np.inf))

    def run(self, method: str, steps: int = 0, *, times: int = 1) -> Run:
        """The ensemble until ``times`` horizons, each of that many steps, on one thread."""
        step = None if method == EXACT else self.step(steps)
        return self.run_until(times * self.spec.t_end, method, step)

    def run_until(self, end: float, method: str, step: float | None) -> Run:
        """The ensemble until some time, in steps of at most this length, on one thread."""
        return simulate(
            self.spec.scene,
            self.omega,
            self.spec.attitude,
            t=[end],
            method=method,
            step=step,
            check=False,
            max_steps=2**62,
            threads=1,
        )

    def distance(self, run: Run, truth: Run) -> tuple[Floats, Floats]:
        """Distances of the last states of two runs, shape (n,) each.

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
        arrived = np.isin(run.status, ARRIVED)
        known = arrived & np.isfinite(of_rates) & np.isfinite(of_attitude)
        return np.where(known, of_rates, np.inf), np.where(known, of_attitude, np.inf)

    def rounding(self) -> Floats:
        """Rounding error of the attitude of each body at the end, as plans estimate it (rad)."""
        left: Floats = _core.ROUNDING * (1.0 + self.rates * self.spec.t_end)
        return left


def ensemble_of(spec: ReportSpec) -> Ensemble:
    """The ensemble of a specification; equal specifications have equal ensembles."""
    generator = np.random.Generator(np.random.Philox(key=spec.seed))
    factors = 1.0 + PERTURBATION * generator.standard_normal((spec.bodies, 3))
    factors[0] = 1.0
    omega = np.array(spec.omega) * factors
    bodies = bodies_of(spec.scene, omega, spec.attitude)
    return Ensemble(spec, omega, bodies.fastest_rates((0.0, spec.t_end)))


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
