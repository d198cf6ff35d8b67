"""The ensemble of bodies that a report runs: which methods move it, and how far runs are apart."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arrays import Floats
from ..model.bodies import bodies_of
from ..solve.methods import EXACT, order_of
from ..solve.run import Run
from ..solve.simulate import simulate
from ..solve.status import ARRIVED
from .spec import ReportSpec

PERTURBATION = 1e-3
"""Standard deviation of the relative perturbation of each rate."""

OUTPUT_TIMES = 256
"""Number of times of a run over revolutions at which its errors are measured."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Its multiples, modulo 1, shift the output times, so that these keep step with no period of the
motion."""

SHORT = 1.0 / 16.0
"""Angle (rad) turned in a step that every method takes."""

ANGLES = tuple(2.0**k for k in range(-2, 5))
"""Angles (rad) turned in the steps that are compared bit for bit. Series of high orders agree in
short steps; in long ones not every method arrives."""

STEPS = 4
"""Steps of each length; the rounding of the first step may hide a difference."""


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
        """Bound of the angle that the fastest body turns until ``t_end`` (rad).

        Over revolutions the angle at the rate of the start.
        """
        rate = math.hypot(*self.spec.omega) if self.spec.revolutions else float(self.rates.max())
        return rate * self.spec.t_end

    def run(self, method: str, steps: int = 0, *, times: int = 1) -> Run:
        """The ensemble until ``times`` horizons, each of that many steps, on one thread.

        Over revolutions it has states at the ends of some of the steps.
        """
        end = times * self.spec.t_end
        if method == EXACT:
            return self.run_until(end, method, None)
        step = self.spec.t_end / steps
        seen = np.empty(0)
        if self.spec.revolutions:
            k = np.arange(OUTPUT_TIMES)
            seen = np.unique(np.rint(steps * (k + GOLDEN * k % 1.0) / OUTPUT_TIMES))
        if method in self.spec.schemes:
            own, at = self.spec.schemes[method], [*seen[seen < steps].astype(int), times * steps]
            return own.run(self.spec.scene, self.omega, self.spec.attitude, step, at)
        if not self.spec.revolutions:
            # At least the quotient, so never one step more.
            return self.run_until(end, method, float(np.nextafter(step, np.inf)))
        # Times are rounded, and must not need one step more.
        return self.run_until(end, method, step * (1.0 + 1e-9), step * seen[seen < steps])

    def run_until(
        self, end: float, method: str, step: float | None, before: Iterable[float] = ()
    ) -> Run:
        """The ensemble until some time, in steps of at most this length, on one thread."""
        return simulate(
            self.spec.scene,
            self.omega,
            self.spec.attitude,
            t=[*before, end],
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


def ensemble_of(spec: ReportSpec, t_end: float | None = None) -> Ensemble:
    """The ensemble of a specification, by default until its end; equal ones have equal bodies."""
    spec = spec if t_end is None else replace(spec, t_end=t_end)
    generator = np.random.Generator(np.random.Philox(key=spec.seed))
    factors = 1.0 + PERTURBATION * generator.standard_normal((spec.bodies, 3))
    factors[0] = 1.0
    omega = np.array(spec.omega) * factors
    bodies = bodies_of(spec.scene, omega, spec.attitude)
    return Ensemble(spec, omega, bodies.fastest_rates((0.0, spec.t_end)))


def probe(ensemble: Ensemble, names: Iterable[str]) -> tuple[list[str], dict[str, str]]:
    """The methods that accept the scene, and why the others do not."""
    spec = ensemble.spec
    short = ensemble_of(spec, min(spec.t_end, spec.time_of(SHORT / math.tau)))
    usable, refused = [], {}
    for method in names:
        try:
            short.run(method, 1)
        except ValueError as error:
            refused[method] = " ".join(str(error).split())
        else:
            usable.append(method)
    return usable, refused


def same_steps(ensemble: Ensemble, names: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
    """Each method that differs from all others on these bodies, and its other names.

    Many methods are one on simple bodies: without damping exponential Runge-Kutta is Runge-Kutta,
    and whatever moves a symmetric free body by its exact flow makes the same steps. The name of the
    highest order stands for all, of equal orders the first.
    """
    groups: dict[object, list[str]] = {}
    for name in names:
        groups.setdefault(_bits(ensemble, name), []).append(name)
    same = {}
    for group in groups.values():
        best = group[0] if len(group) == 1 else max(group, key=order_of)
        same[best] = tuple(name for name in group if name != best)
    return {name: same[name] for name in names if name in same}


def _bits(ensemble: Ensemble, method: str) -> object:
    """The bits of the states after some steps of several lengths."""
    if method == EXACT or method in ensemble.spec.schemes:
        return method
    rate, known = float(ensemble.rates.max()), ensemble.spec.scene.known_until
    every: list[tuple[bytes, bytes] | None] = []
    for angle in ANGLES:
        step = min(angle / rate if rate > 0.0 else ensemble.spec.t_end, known / STEPS)
        try:
            run = ensemble.run_until(STEPS * step, method, step)
        except ValueError:  # so long a step would be unstable
            every.append(None)
            continue
        assert run.attitude is not None
        every.append((run.omega.tobytes(), run.attitude.tobytes()))
    return method if all(bits is None for bits in every) else tuple(every)


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
