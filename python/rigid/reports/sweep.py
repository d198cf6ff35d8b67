"""The measurement of a report: cost and error of each method for ever shorter steps.

Time is the processor time that the core needed on one thread: neither the way into Python and back
nor other people's work on the machine counts. For a method by steps the horizon is lengthened until
a call works for at least 4 ms; a closed form costs nothing per step, so it is evaluated for 1024
bodies. Rows are measured in turns, in an order that is shuffled anew each round; the result is the
median of the rounds with the distance of the quartiles.

Over revolutions the steps of a method have given angles. All methods run over the first horizon,
then each step over longer ones, the cheapest first; each run is timed once.
"""

from __future__ import annotations

import heapq
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .._checks.arrays import Floats
from ..model.scene import Scene
from ..solve.methods import EXACT
from ..solve.request import MOST_STEPS
from ..solve.run import Run
from ..solve.status import ARRIVED
from .data import AT_UNCERTAINTY, FAILED, REFERENCE, USELESS, Row, at_common_time
from .ensemble import Ensemble
from .reference import LOST, Horizon, Reference

WORK = 4e6
"""Processor time (ns) that a timed call should take at least."""

CLOSED_FORM_BODIES = 1024

LEAST = 1.0
"""Least processor time (ns) of a body; a shorter time is an error of the measurement."""

MOST_ROUNDS = 9

PLATEAU_ANGLE = 0.1
"""A method that stagnates with steps longer than this (rad) may still converge."""

PLATEAU_ERROR = 1e-8
"""A method that stagnates with an error below this limit counts as converged."""

ANGLES = tuple(2.0**-k for k in range(-4, 5))
"""Angles (rad) turned in a step over revolutions, from long steps to short ones."""

LOST_ENERGY = 1e-3
"""Steps with a larger error of the energy after the first revolutions are omitted."""

ROUNDING = 1e-13
"""Errors of energy and momentum below this limit are rounding; shorter steps do not reduce them."""

GROWTH = 0.6
"""Share of the time within which the steps that take the common time are run over longer
horizons."""


@dataclass(slots=True)
class Sweep:
    """One method, from long steps to short ones.

    Attributes
    ----------
    method : str
        Name of the method.
    runs : dict of int to list of Measured
        The runs over each horizon, by their number of steps over the first.
    ended : str or None
        Why there are no shorter steps.
    """

    method: str
    runs: dict[int, list[Measured]] = field(default_factory=dict)
    ended: str | None = None

    def next_steps(self, horizon: Horizon) -> tuple[int, float | None] | None:
        """The steps of the next run; None if a further run would show nothing new.

        Over revolutions also the angle (rad) by which the body turns in a step.
        """
        ensemble, reference = horizon.ensemble, horizon.reference
        if ensemble.spec.revolutions:
            return self._next_angle(horizon)
        errors = ensemble.spec.errors
        if not self.runs:
            return (0 if self.method == EXACT else max(1, math.ceil(ensemble.angle))), None
        if self.method == EXACT:
            self.ended = "closed form"
            return None
        fewest, most = min(self.runs), max(self.runs)
        if fewest > 1 and self.runs[fewest][0].error < errors[0]:
            return max(1, fewest // 2), None  # even longer steps would do
        error = self.runs[most][0].error
        if error <= reference.uncertainty:
            self.ended = "reference uncertainty"
        elif error < errors[-1]:
            self.ended = "smallest wanted error"
        elif self._stagnates(ensemble.angle / most):
            self.ended = "rounding"
        elif 2 * most > MOST_STEPS:
            self.ended = "number of steps"
        return None if self.ended else (2 * most, None)

    def _stagnates(self, angle: float) -> bool:
        errors = [self.runs[steps][0].error for steps in sorted(self.runs)]
        best = min(errors[:-2], default=math.inf)
        settled = angle < PLATEAU_ANGLE or best < PLATEAU_ERROR
        return len(errors) > 2 and settled and min(errors[-2:]) > 0.5 * best

    def _next_angle(self, horizon: Horizon) -> tuple[int, float] | None:
        """Half the angle of the last step, until shorter steps make no error smaller."""
        tried = [run for run, *_ in self.runs.values()]
        kept = [run for run in tried if not run.energy_drift >= LOST_ENERGY]
        if kept and kept[-1] is tried[-1]:
            *before, last = [run.lasting_errors(horizon.reference) for run in kept]
            if not (last < 0.5 * np.min(before, axis=0, initial=np.inf)).any():
                self.ended = "rounding"
                return None
        for angle in ANGLES:
            steps = math.ceil(math.tau * horizon.revolutions / angle)
            if steps not in self.runs:
                return steps, angle
        self.ended = "shortest step"
        return None

    def kept(self) -> list[list[Measured]]:
        """The runs that the report has, from long steps to short ones."""
        runs = [self.runs[steps] for steps in sorted(self.runs)]
        runs = [one for one in runs if one[0].call > 0.0]  # no step was too long to be stable
        return [
            one for one in runs if one[0].angle is None or not one[0].energy_drift >= LOST_ENERGY
        ]

    def rows(self, horizons: Sequence[Horizon]) -> list[Row]:
        """The rows of a report over each horizon, from long steps to short ones."""
        rows = []
        for k, horizon in enumerate(horizons):
            ordered = [runs[k] for runs in self.kept() if k < len(runs)]
            rounding = self._rounding([run.error for run in ordered])
            floor = 10.0 * max(rounding, horizon.reference.uncertainty)
            for run, coarse in zip(ordered, [None, *ordered], strict=False):
                order = None
                if coarse and floor < run.error < coarse.error < 0.1:
                    order = math.log(coarse.error / run.error) / math.log(run.steps / coarse.steps)
                rows.append(run.row(self.method, horizon, order))
        return rows

    def _rounding(self, errors: Sequence[float]) -> float:
        """The error to which these have come down by rounding; zero if they have not."""
        if self.ended == "time" and len(errors) > 2:
            # Rounding is unseen then. Each step is half the last: if an error falls as the one
            # before it did, rounding is at most a tenth of it.
            before, coarse, last = errors[-3:]
            if last * before <= 1.1 * coarse**2:
                return 0.0
        return min(errors, default=0.0) if self.ended in ("rounding", "time") else 0.0


@dataclass(slots=True)
class Measured:
    """One method with one step over a horizon: its errors at the end, and the times so far.

    Attributes
    ----------
    steps : int
        Steps until the horizon.
    rates, attitude : ndarray, shape (n,)
        Errors of each body.
    energy_drift, momentum_drift : float
        Worst of the ensemble; NaN if none is known, as on the clock of an orbit.
    call : float
        Processor time of the run that gave the errors (ns).
    angle : float or None
        Angle turned in a step at the rate of the start (rad), over revolutions.
    times : list of float
        Processor time of a body until ``t_end`` (ns), once each round.
    """

    steps: int
    rates: Floats
    attitude: Floats
    energy_drift: float
    momentum_drift: float
    call: float
    angle: float | None = None
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        """Median over the bodies of the larger of the two errors."""
        return float(np.median(np.maximum(self.rates, self.attitude)))

    def phase(self, reference: Reference) -> float:
        """Largest error of the attitude, at least the uncertainty of the reference."""
        return max(float(self.attitude.max()), reference.worst)

    def lasting_errors(self, reference: Reference) -> Floats:
        """Energy, momentum and phase; at least rounding, and infinite if lost or not known."""
        errors = [
            max(self.energy_drift, ROUNDING),
            max(self.momentum_drift, ROUNDING),
            self.phase(reference),
        ]
        return np.array([error if error < LOST else math.inf for error in errors])

    def row(self, method: str, horizon: Horizon, order: float | None) -> Row:
        """The row of a report; its errors are at least the uncertainty of the reference."""
        ensemble, reference = horizon.ensemble, horizon.reference
        spec = ensemble.spec
        errors = np.maximum(self.rates, self.attitude)
        floor, mark = 0.0, ""
        if method == EXACT:
            floor, mark = reference.uncertainty, REFERENCE
        elif horizon.truth is None:
            mark = AT_UNCERTAINTY
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
        bound = ensemble.angle / self.steps if self.steps else None
        return Row(
            method=method,
            revolutions=horizon.revolutions,
            steps=self.steps,
            step=spec.t_end / self.steps if self.steps else None,
            angle=bound if self.angle is None else self.angle,
            nanoseconds=middle / spec.t_end,
            spread=(high - low) / spec.t_end if len(self.times) > 1 else None,
            total=middle,
            error=max(self.error, floor),
            worst=max(float(errors.max()), reference.worst if floor else 0.0),
            rates_error=max(float(np.median(self.rates)), floor),
            attitude_error=max(float(np.median(self.attitude)), floor),
            phase=self.phase(reference),
            energy_drift=math.inf if math.isnan(self.energy_drift) else self.energy_drift,
            momentum_drift=math.inf if math.isnan(self.momentum_drift) else self.momentum_drift,
            order=order,
            mark=mark,
        )


def sweep_methods(
    horizon: Horizon,
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
        following = sweep.next_steps(horizon)
        if following is None:
            continue
        if sweep.runs and not allowed(expected):
            sweep.ended = "time"
            continue
        begun = time.perf_counter()
        sweep.runs[following[0]] = [_measure(horizon, sweep.method, *following)]
        told()
        heapq.heappush(queue, (2.0 * (time.perf_counter() - begun), k))


def lengthen(
    horizons: Sequence[Horizon],
    sweeps: Sequence[Sweep],
    until: Callable[[float], Callable[[float], bool]],
    told: Callable[[], object],
) -> None:
    """Run each step over the longer horizons, the cheapest run first, while there is time.

    First the steps that take the common time. ``until(share)(seconds)`` is whether a run of that
    length ends within a share of the time, ``told()`` is called after each run.
    """
    rows = at_common_time([row for sweep in sweeps for row in sweep.rows(horizons)])
    shown = {(row.method, row.angle) for row in rows}
    steps = [(sweep.method, runs) for sweep in sweeps for runs in sweep.kept()]
    first = [(method, runs) for method, runs in steps if (method, runs[0].angle) in shown]

    def expected(step: tuple[str, list[Measured]]) -> float:
        _, runs = step
        ratio = horizons[len(runs)].revolutions / horizons[len(runs) - 1].revolutions
        return 1e-9 * runs[-1].call * ratio

    for some, share in ((first, GROWTH), (steps, 1.0)):
        while short := [step for step in some if len(step[1]) < len(horizons)]:
            step = min(short, key=expected)
            if not until(share)(expected(step)):
                break
            method, runs = step
            runs.append(_longer(horizons[len(runs)], method, runs[-1], 1e9 * expected(step)))
            told()


def _longer(horizon: Horizon, method: str, before: Measured, call: float) -> Measured:
    """A step over the next horizon; not run if the energy is lost already."""
    assert before.angle is not None
    steps = math.ceil(math.tau * horizon.revolutions / before.angle)
    if before.energy_drift >= LOST:
        return replace(_failed(horizon, steps, before.angle), call=call)
    now = _measure(horizon, method, steps, before.angle)
    # Output times of a longer run are sparser: what was seen before was there too.
    now.energy_drift = max(before.energy_drift, now.energy_drift)
    now.momentum_drift = max(before.momentum_drift, now.momentum_drift)
    return now


def _measure(horizon: Horizon, method: str, steps: int, angle: float | None) -> Measured:
    ensemble, truth = horizon.ensemble, horizon.truth
    try:
        run = ensemble.run(method, steps)
    except ValueError:  # so long a step would be unstable
        return _failed(horizon, steps, angle)
    rates = attitude = np.full(len(ensemble.omega), np.inf)
    if truth is not None:
        rates, attitude = ensemble.distance(run, truth)
    drifts = run.energy_drift, run.momentum_drift
    if angle is not None:
        drifts = run.energy_drift, _momentum_errors(ensemble.spec.scene, run)
    arrived = np.isin(run.status, ARRIVED)
    energy, momentum = (float(np.fmax.reduce(np.where(arrived, one, np.inf))) for one in drifts)
    taken = int(run.steps.max())
    return Measured(taken, rates, attitude, energy, momentum, float(run.nanoseconds), angle)


def _failed(horizon: Horizon, steps: int, angle: float | None) -> Measured:
    lost = np.full(len(horizon.ensemble.omega), np.inf)
    return Measured(steps, lost, lost, math.inf, math.inf, 0.0, angle)


def _momentum_errors(scene: Scene, run: Run) -> Floats:
    """Largest error of the angular momentum of each body: see :class:`Row`."""
    if scene.forces:
        return run.momentum_drift
    weight = np.linalg.norm(scene.weight)
    with np.errstate(all="ignore"):  # some have flown apart
        in_body, momentum = run.momentum(), run.momentum("space")
        conserved = [momentum]
        if weight:
            conserved = [momentum[..., 2:]]
            axis = scene.body.symmetry_axis
            if axis is not None and abs(scene.weight[axis - 1]) == weight:
                conserved.append(in_body[..., axis - 1 : axis])
        size = np.linalg.norm(momentum[:, 0], axis=-1)
        errors = [np.linalg.norm(one - one[:, :1], axis=-1).max(axis=1) for one in conserved]
        scale = size + math.sqrt(weight * max(scene.body.moments))
        worst: Floats = np.maximum.reduce(errors) / scale
    return worst


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
    pairs = [(sweep, run) for sweep in sweeps for (run,) in sweep.kept()]
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
    reach = ensemble.spec.scene.known_until / ensemble.spec.t_end
    times = int(min(times, max(1.0, min(MOST_STEPS // steps, reach))))
    run = ensemble.run(method, steps, times=times)
    return run.nanoseconds * steps / (float(run.steps.mean()) * ensemble.spec.bodies)


def _time_closed_form(ensemble: Ensemble) -> float:
    """Processor time of a body (ns)."""
    many = replace(ensemble, omega=np.resize(ensemble.omega, (CLOSED_FORM_BODIES, 3)))
    return many.run(EXACT).nanoseconds / CLOSED_FORM_BODIES
