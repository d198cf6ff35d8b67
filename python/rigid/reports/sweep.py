"""The measurement of a report: cost and error of each method for ever shorter steps.

Time is the processor time that the core needed on one thread: neither the way into Python and back
nor other people's work on the machine counts. For a method by steps the horizon is lengthened until
a call works for at least 4 ms; a closed form costs nothing per step, so it is evaluated for 1024
bodies. Rows are measured in turns, in an order that is shuffled anew each round; the result is the
median of the rounds with the distance of the quartiles.
"""

from __future__ import annotations

import heapq
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..solve.methods import EXACT
from ..solve.run import Run
from ..solve.simulate import simulate
from .ensemble import Ensemble
from .reference import Reference
from .row import AT_UNCERTAINTY, FAILED, REFERENCE, USELESS, Row

__all__ = ["Sweep", "probe", "sweep_methods", "time_sweeps"]

WORK = 4e6
"""Processor time (ns) that a timed call should take at least."""

CLOSED_FORM_BODIES = 1024

LEAST = 1.0
"""Least processor time (ns) of a body; a shorter time is an error of the measurement."""

MOST_ROUNDS = 9

MOST_STEPS = 10**9

PLATEAU_ANGLE = 0.1
"""A method that stagnates with steps longer than this (rad) may still converge."""

PLATEAU_ERROR = 1e-8
"""A method that stagnates with an error below this limit counts as converged."""


@dataclass(slots=True)
class Sweep:
    """One method, from long steps to short ones.

    Attributes
    ----------
    method : str
        Name of the method.
    runs : dict of int to Measured
        The runs by their number of steps.
    ended : str or None
        Why there are no shorter steps.
    """

    method: str
    runs: dict[int, Measured] = field(default_factory=dict)
    ended: str | None = None

    @property
    def failures(self) -> int:
        """Runs in which half of the bodies did not arrive."""
        return sum(not math.isfinite(run.error) for run in self.runs.values())

    def next_steps(self, ensemble: Ensemble, reference: Reference) -> int | None:
        """The steps of the next run; None if a further run would show nothing new."""
        errors = ensemble.spec.errors
        if not self.runs:
            return 0 if self.method == EXACT else max(1, math.ceil(ensemble.angle))
        if self.method == EXACT:
            self.ended = "closed form"
            return None
        fewest, most = min(self.runs), max(self.runs)
        if fewest > 1 and self.runs[fewest].error < errors[0]:
            return max(1, fewest // 2)  # even longer steps would do
        error = self.runs[most].error
        if error <= reference.uncertainty:
            self.ended = "reference uncertainty"
        elif error < errors[-1]:
            self.ended = "smallest wanted error"
        elif self._stagnates(ensemble.angle / most):
            self.ended = "rounding"
        elif 2 * most > MOST_STEPS:
            self.ended = "number of steps"
        return None if self.ended else 2 * most

    def _stagnates(self, angle: float) -> bool:
        errors = [self.runs[steps].error for steps in sorted(self.runs)]
        best = min(errors[:-2], default=math.inf)
        settled = angle < PLATEAU_ANGLE or best < PLATEAU_ERROR
        return len(errors) > 2 and settled and min(errors[-2:]) > 0.5 * best

    def rows(self, ensemble: Ensemble, reference: Reference) -> list[Row]:
        """The rows of a report, from long steps to short ones."""
        ordered = [self.runs[steps] for steps in sorted(self.runs)]
        # A sweep that ran out of time may have come down to rounding unseen.
        at_rounding = self.ended in ("rounding", "time")
        lowest = min(run.error for run in ordered) if at_rounding else 0.0
        floor = 10.0 * max(lowest, reference.uncertainty)
        rows = []
        for k, run in enumerate(ordered):
            coarse = ordered[k - 1] if k else None
            order = None
            if coarse and floor < run.error < coarse.error < 0.1:
                order = math.log(coarse.error / run.error) / math.log(run.steps / coarse.steps)
            rows.append(run.row(self.method, ensemble, reference, order))
        return rows


@dataclass(slots=True)
class Measured:
    """One method with one step: its errors at the end, and the times measured so far.

    Attributes
    ----------
    steps : int
        Steps until ``t_end``.
    rates, attitude : ndarray, shape (n,)
        Errors of each body.
    energy_drift, momentum_drift : float
        Worst of the ensemble.
    call : float
        Processor time of the run that gave the errors (ns).
    times : list of float
        Processor time of a body until ``t_end`` (ns), once each round.
    """

    steps: int
    rates: NDArray[np.float64]
    attitude: NDArray[np.float64]
    energy_drift: float
    momentum_drift: float
    call: float
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        """Median over the bodies of the larger of the two errors."""
        return float(np.median(np.maximum(self.rates, self.attitude)))

    def row(
        self, method: str, ensemble: Ensemble, reference: Reference, order: float | None
    ) -> Row:
        """The row of a report; its errors are at least the uncertainty of the reference."""
        spec = ensemble.spec
        errors = np.maximum(self.rates, self.attitude)
        floor, mark = 0.0, ""
        if method == EXACT:
            floor, mark = reference.uncertainty, REFERENCE
        elif not math.isfinite(self.error):
            mark = FAILED
        elif self.error >= 1.0:
            mark = USELESS
        elif self.error <= 2.0 * reference.uncertainty:
            floor, mark = reference.uncertainty, AT_UNCERTAINTY
        times = self.times or [self.call / spec.bodies]
        low, middle, high = np.percentile(times, (25.0, 50.0, 75.0)).tolist()
        # A difference of two times that is lost in its spread is known to be no more than that.
        middle = max(middle, high - low, LEAST)
        return Row(
            method=method,
            steps=self.steps,
            step=spec.t_end / self.steps if self.steps else None,
            angle=ensemble.angle / self.steps if self.steps else None,
            nanoseconds=middle / spec.t_end,
            spread=(high - low) / spec.t_end if len(self.times) > 1 else None,
            total=middle,
            error=max(self.error, floor),
            worst=max(float(errors.max()), reference.worst if floor else 0.0),
            rates_error=max(float(np.median(self.rates)), floor),
            attitude_error=max(float(np.median(self.attitude)), floor),
            energy_drift=self.energy_drift,
            momentum_drift=self.momentum_drift,
            order=order,
            mark=mark,
        )


def probe(ensemble: Ensemble, names: Iterable[str]) -> tuple[list[str], dict[str, str]]:
    """The methods that accept the scene, and why the others do not."""
    usable, refused = [], {}
    for method in names:
        try:
            ensemble.run(method, 1)
        except ValueError as error:
            refused[method] = " ".join(str(error).split())
        else:
            usable.append(method)
    return usable, refused


def sweep_methods(
    ensemble: Ensemble,
    truth: Run,
    reference: Reference,
    sweeps: Sequence[Sweep],
    allowed: Callable[[float], bool],
    told: Callable[[], object],
) -> None:
    """Fill the sweeps, always with the run that is estimated to be the cheapest.

    When the time is over, all methods have had the same chance. ``allowed(seconds)`` is whether
    there is time for a run of that length, ``told()`` is called after each run.
    """
    queue = [(0.0, k) for k in range(len(sweeps))]
    while queue:
        expected, k = heapq.heappop(queue)
        sweep = sweeps[k]
        steps = sweep.next_steps(ensemble, reference)
        if steps is None:
            continue
        if sweep.runs and not allowed(expected):
            sweep.ended = "time"
            continue
        begun = time.perf_counter()
        sweep.runs[steps] = _measure(ensemble, truth, sweep.method, steps)
        told()
        heapq.heappush(queue, (2.0 * (time.perf_counter() - begun), k))


def _measure(ensemble: Ensemble, truth: Run, method: str, steps: int) -> Measured:
    run = ensemble.run(method, steps)
    rates, attitude = ensemble.distance(run, truth)
    taken = int(run.steps.max())
    # A drift that is not a number is infinite.
    drifts = [np.where(np.isnan(d), np.inf, d) for d in (run.energy_drift, run.momentum_drift)]
    energy, momentum = (float(drift.max()) for drift in drifts)
    return Measured(taken, rates, attitude, energy, momentum, float(run.nanoseconds))


def time_sweeps(
    ensemble: Ensemble,
    sweeps: Sequence[Sweep],
    allowed: Callable[[float], bool],
    told: Callable[[float], object],
) -> None:
    """Add rounds of timings to all runs until nine are done or the time is over.

    ``told(share)`` is called with the share of the rounds that is done.
    """
    generator = np.random.Generator(np.random.Philox(key=ensemble.spec.seed))
    pairs = [(sweep, run) for sweep in sweeps for run in sweep.runs.values()]
    for number in range(MOST_ROUNDS):
        begun = time.perf_counter()
        for done, k in enumerate(generator.permutation(len(pairs)).tolist()):
            sweep, run = pairs[k]
            if sweep.method == EXACT:
                spent = _time_closed_form(ensemble)
            else:
                spent = _time_steps(ensemble, sweep.method, run.steps, run.call)
            run.times.append(spent)
            told((number + done / len(pairs)) / MOST_ROUNDS)
        if not allowed(time.perf_counter() - begun):
            break


def _time_steps(ensemble: Ensemble, method: str, steps: int, work: float) -> float:
    """Processor time of a body until ``t_end`` (ns); ``work`` is about the time of the ensemble."""
    times = max(1, math.ceil(WORK / max(work, 1.0)))
    times = min(times, max(1, MOST_STEPS // steps))
    run = ensemble.run(method, steps, times=times)
    return run.nanoseconds * steps / (float(run.steps.mean()) * ensemble.spec.bodies)


def _time_closed_form(ensemble: Ensemble) -> float:
    """Processor time of a body (ns)."""
    spec = ensemble.spec
    omega = np.resize(ensemble.omega, (CLOSED_FORM_BODIES, 3))
    run = simulate(spec.scene, omega, spec.attitude, t=[spec.t_end], method=EXACT, threads=1)
    return run.nanoseconds / CLOSED_FORM_BODIES
