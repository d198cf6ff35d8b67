"""Is what a run says of its error true? One of :data:`VERDICTS` for each random run."""

from dataclasses import dataclass
from typing import Any

import numpy as np

import quad_motion
import rigid
from adversarial import KINDS, Case, Kinds, random_case
from physics import ROUNDOFF, Floats, energy, gamma_of
from quad_motion import Motion
from rigid.model.bodies import bodies_of, time_ranges

VERDICTS = ("right", "within 4uκ", "flagged", "refused", "status", "no truth", "UNDETECTED")

#: A body whose rates are all below this share of what it could reach is at rest. It is twice that
#: of :attr:`rigid.Run.error`: the run knows only its own rates.
REST = 2e-13

#: How a run ended whose stated error is to be believed.
JUDGED = (rigid.Status.OK, rigid.Status.COARSE)

#: Most steps of the truth; a body that needs more has none.
LIMIT = 2500

#: Relative roundings of all inputs that a right answer may be off by.
ROUNDINGS = 4.0

#: An error above this is not "ok" where no accuracy was asked.
LOOSE = 1e-3


@dataclass(frozen=True)
class Finding:
    """What was said of a run and what was true.

    ``early`` is the largest error before the time from which on the run is called lost,
    ``unbalanced`` by how much the drift of the energy exceeds the stated one.
    """

    number: int
    case: Case
    verdict: str
    method: str
    true: float = np.nan
    stated: float = np.nan
    asked: float = 0.0
    within: float = np.nan
    early: float = 0.0
    unbalanced: float = -np.inf
    status: int = 0

    @property
    def excess(self) -> float:
        """The true error over the larger of what was asked and what was stated."""
        return self.true / max(self.asked, self.stated)

    @property
    def loose(self) -> bool:
        """Whether ``ok`` stands beside an error above 1e-3, and nothing was asked."""
        ok = self.status == rigid.Status.OK and self.verdict in ("right", "within 4uκ")
        return ok and not self.asked and self.true > LOOSE


def reach(case: Case) -> float:
    """The fastest rate that the body can reach, as :attr:`rigid.Run.error` counts it."""
    bodies = bodies_of(case.scene, case.omega, case.attitude)
    rate = float(bodies.fastest_rates(time_ranges(case.t))[0])
    return max(rate, np.finfo(np.float64).tiny)


def fastest(case: Case, truth: Motion) -> float:
    """The fastest rate at the output times; of a body at rest a rate that it could reach."""
    swing = np.linalg.norm(case.scene.weight) / min(case.scene.body.moments)
    largest = max(reach(case), float(np.sqrt(swing)))
    rate = float(np.linalg.norm(truth.omega, axis=-1).max())
    return rate if rate > REST * largest else largest


def true_errors(case: Case, run: rigid.Run, row: int | None, truth: Motion) -> Floats:
    """The largest error at each output time, shape (m,).

    Of the rates relative to the fastest of them, of the vertical and the attitude in rad, of the
    work relative to the largest kinetic energy that the body can reach.
    """

    def of_body(values: Floats) -> Floats:
        return values if row is None else values[row]

    worst = [truth.rates_off(of_body(run.omega)) / fastest(case, truth)]
    if run.gamma is not None:
        worst.append(truth.gamma_off(of_body(run.gamma)))
    if run.attitude is not None:
        worst.append(truth.attitude_off(of_body(run.attitude)))
    if run.work is not None:
        # Under a function nothing bounds the rates, and those that were met count.
        met = float(np.linalg.norm(truth.omega, axis=-1).max())
        rate = max(reach(case), met) if "function" in case.scene.forces else reach(case)
        energy = 0.5 * min(case.scene.body.moments) * rate**2
        worst.append(truth.work_off(of_body(run.work)) / energy)
    largest: Floats = np.max(worst, axis=0)
    return largest


def unbalanced(case: Case, run: rigid.Run, row: int | None) -> float:
    """The drift of energy less work, computed anew from the states, less the stated one."""

    def of_body(values: Floats) -> Floats:
        return values if row is None else values[row]

    scene, omega = case.scene, of_body(run.omega)
    gamma = None if run.gamma is None else of_body(run.gamma)
    if run.work is None or (gamma is None and scene.weight.any()):
        return -np.inf
    work = of_body(run.work)
    before = energy(scene, case.omega, None if gamma is None else gamma_of(case.attitude))
    scale = 0.5 * min(scene.body.moments) * reach(case) ** 2 + np.linalg.norm(scene.weight)
    reached: Floats = scale + energy(scene, case.omega) + energy(scene, omega) + np.abs(work)
    drift = np.abs(energy(scene, omega, gamma) - before - work)
    drift /= np.where(reached > 0, reached, 1.0)
    return float(drift.max(initial=0.0)) - float(of_body(run.energy_drift))


def _truth(case: Case, **changes: Any) -> Motion | None:
    given = {"omega": case.omega, "attitude": case.attitude, **changes}
    return quad_motion.motion(case.scene, times=case.t, limit=LIMIT, **given)


def rounding(case: Case, truth: Motion, run: rigid.Run) -> float:
    """What one rounding of each input changes at most: rates, attitude, moments and weight."""
    body, weight = np.array(case.scene.body.moments), case.scene.weight
    swing = np.linalg.norm(weight) / body.min()
    size = float(np.sqrt(case.omega @ case.omega + swing))
    changes: list[dict[str, Floats | float]] = []
    for step in np.eye(3) * size * ROUNDOFF:
        changes.append({"omega": case.omega + step})
    unit = case.attitude / np.linalg.norm(case.attitude)
    for turn in np.eye(4) * 2.0 * ROUNDOFF:
        changes.append({"attitude": unit + turn})
    for moment in np.unique(body):
        changes.append({"moments": np.where(body == moment, np.nextafter(moment, np.inf), body)})
    if weight.any():
        changes += [
            {"weight": np.where(np.eye(3)[k] > 0.0, np.nextafter(weight, np.inf), weight)}
            for k in np.flatnonzero(weight)
        ]
    shifts = []
    for change in changes:
        origin = _truth(case, attitude=unit) if "attitude" in change else truth
        other = _truth(case, **change)
        if other is None or origin is None:
            return np.inf
        shifts.append(_apart(case, other, origin, run))
    return float(np.linalg.norm(shifts))


def _apart(case: Case, one: Motion, other: Motion, run: rigid.Run) -> float:
    """Distance of two motions, in the quantities that a run recorded."""
    off = Motion(other.high - one.low, other.low)
    worst = [off.rates_off(one.omega) / fastest(case, other)]
    if run.gamma is not None:
        worst.append(off.gamma_off(one.high[:, 7:10]))
    if run.attitude is not None:
        worst.append(off.attitude_off(one.high[:, 3:7]))
    return float(np.max(worst))


def judge(number: int, seed: int, kinds: Kinds = KINDS) -> Finding:
    """The verdict of one random run; the same for the same numbers."""
    case = random_case(np.random.default_rng([seed, number]), kinds)
    method = str(case.options.get("method", "default"))
    try:
        run, row = case.run()
    except ValueError:
        return Finding(number, case, "refused", method)
    if "method" not in case.options:
        method = f"default: {run.plan.method}"
    stated = float(np.max(run.error if row is None else run.error[row]))
    asked = float(case.options.get("accuracy", 0.0))
    status = int(run.status if row is None else run.status[row])
    if status not in (*JUDGED, rigid.Status.FLAGGED):
        return Finding(number, case, "status", method, status=status)
    true = np.inf
    for kind in (quad_motion.FAST, {}):
        if np.isfinite(true) and 2.0 * true <= max(asked, stated):
            break  # clearly right: 128 bits would say the same
        found = _truth(case, **kind)
        if found is None or not np.isfinite(found.high).all():
            return Finding(number, case, "no truth", method)
        truth, errors = found, true_errors(case, run, row, found)
        true = float(np.max(errors))
    lost_from = float(run.lost_from if row is None else run.lost_from[row])
    early = float(np.max(errors, where=np.abs(case.t) < np.abs(lost_from), initial=0.0))
    within = np.nan
    if status == rigid.Status.FLAGGED:
        verdict = "flagged"
    elif true <= max(asked, stated):
        verdict = "right"
    else:
        within = ROUNDINGS * rounding(case, truth, run)
        verdict = "UNDETECTED"
        if true <= within:
            verdict = "within 4uκ"
        else:
            again = _truth(case, tolerance=1e-4 * quad_motion.TOLERANCE)
            if again is None or not _apart(case, again, truth, run) < 0.1 * true:
                verdict = "no truth"
    off = unbalanced(case, run, row)
    numbers = true, stated, asked, within, early, off
    return Finding(number, case, verdict, method, *numbers, status=status)
