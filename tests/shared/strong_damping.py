"""Random runs under strong damping: matrices of damping with fast and slow directions.

A fast direction stops within a layer much shorter than the run, while a slow one still turns.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

import rigid
import stiff_motion
from adversarial import Case
from forced_starts import torque
from hard_starts import decades, direction, moments, turned_to
from physics import Floats
from verdicts import JUDGED, true_errors

#: How a run was asked for.
WAYS = ("default", "accuracy", "etd4", "etd4 with accuracy", "etd4 with a step")
SHARES = (0.25, 0.2, 0.1, 0.25, 0.2)


@dataclass(frozen=True)
class Judged:
    """What a run said of its error and what was true; None of a body that the truth gave up."""

    number: int
    case: Case
    way: str
    method: str
    strength: float
    status: int
    stated: float
    asked: float
    true: float
    steps: int

    @property
    def is_claimed(self) -> bool:
        """Whether the run claims its stated error."""
        return self.status in JUDGED

    @property
    def excess(self) -> float:
        """The true error over the larger of what was asked and what was stated."""
        return self.true / max(self.asked, self.stated)


def rotation(rng: np.random.Generator) -> Floats:
    """A random orthogonal matrix; one in four is nearly the unit matrix, or is."""
    if rng.random() < 0.25:
        off = float(rng.choice([0.0, decades(rng, -6.0, -1.0)]))
        return np.linalg.qr(np.eye(3) + off * rng.normal(size=(3, 3)))[0]
    return np.linalg.qr(rng.normal(size=(3, 3)))[0]


def damping(rng: np.random.Generator, rate: float, shape: Floats) -> Floats:
    """A matrix whose fastest rate is given: one or two slow directions, or rates of any size."""
    kind = rng.choice(["one slow", "two slow", "any", "alike"], p=[0.45, 0.2, 0.2, 0.15])
    slow = decades(rng, -7.0, 0.0) if rng.random() < 0.9 else 0.0
    shares = {
        "one slow": np.array([1.0, decades(rng, -1.5, 0.0), slow]),
        "two slow": np.array([1.0, slow * rng.uniform(), slow]),
        "any": np.array([1.0, *(10.0 ** rng.uniform(-6.0, 0.0, 2))]),
        "alike": np.array([1.0, rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0)]),
    }[str(kind)]
    axes = rotation(rng) * np.sqrt(shares * rate)
    rows = np.sqrt(shape)[:, None] * axes[:, rng.permutation(3)]
    matrix: Floats = rows @ rows.T
    return 0.5 * (matrix + matrix.T)


def rates(rng: np.random.Generator, matrix: Floats, size: float) -> Floats:
    """Rates about one axis, along a mode of the damping, or any."""
    kind = rng.choice(["axis", "mode", "any"], p=[0.4, 0.2, 0.4])
    if kind == "axis":
        axis: Floats = size * rng.choice([-1.0, 1.0]) * np.eye(3)[rng.integers(3)]
        return axis
    if kind == "mode":
        mode: Floats = size * np.linalg.eigh(matrix)[1][:, rng.integers(3)]
        return mode + size * decades(rng, -6.0, 0.0) * rng.normal(size=3) * rng.integers(0, 2)
    return size * direction(rng)


def random_case(rng: np.random.Generator) -> tuple[Case, str, float]:
    """A run, how it was asked for, and its damping rate times its length."""
    shape = moments(rng)
    body = rigid.Body(shape)
    speed, strength = decades(rng, -1.0, 1.0), decades(rng, 0.0, 6.0)
    # At most 300 rad at the first rate; damping from a third of that rate on.
    rate = speed * max(decades(rng, -0.5, 5.0), strength / 300.0)
    span = strength / rate
    matrix = damping(rng, rate, np.array(body.moments))
    omega = rates(rng, matrix, speed)
    outside: dict[str, Any] = {"damping": matrix}
    resistance = float(np.trace(matrix)) / 3.0
    if rng.random() < 0.5:
        outside["torque"] = torque(rng, decades(rng, -4.0, 0.0) * resistance * speed, 1.01 * span)
    if rng.random() < 0.35:
        com = direction(rng) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
        mgl = decades(rng, -4.0, 0.0) * resistance * speed
        scene: Any = rigid.HeavyTop(body, mgl=mgl, com=com, **outside)
        tilt = rng.choice([decades(rng, -3.0, 0.0), rng.uniform(0.0, np.pi)])
        attitude = turned_to(com, float(tilt), rng.uniform(0.0, 7.0))
    else:
        scene, attitude = rigid.FreeBody(body, **outside), rng.normal(size=4)
    way = str(rng.choice(WAYS, p=SHARES))
    options: dict[str, Any] = {"method": "etd4"} if way.startswith("etd4") else {}
    if way.endswith("accuracy"):
        options["accuracy"] = float(rng.choice([1e-6, decades(rng, -9.0, -2.0)]))
    if way.endswith("step"):
        options["step"] = decades(rng, -2.5, 0.3) / speed
    return (
        Case("damped", scene, omega, attitude, output_times(rng, span, rate), options),
        way,
        strength,
    )


def output_times(rng: np.random.Generator, span: float, rate: float) -> Floats:
    """Times of the states: the end alone, some at random, or in the first layer too."""
    kind = rng.choice(["end", "even", "random", "layer"], p=[0.4, 0.15, 0.2, 0.25])
    count = int(rng.integers(1, 9))
    if kind == "end":
        return np.array([span])
    if kind == "even":
        return np.linspace(0.0, span, count + 1)
    if kind == "random":
        return np.append(np.sort(rng.uniform(0.0, span, count)), span)
    first = min(decades(rng, -2.0, 1.0) / rate, 0.5 * span)
    return np.geomspace(first, span, count + 1)


def judge(number: int, seed: int) -> Judged | None:
    """One random run, the same for the same numbers; None where the truth is not known."""
    case, way, strength = random_case(np.random.default_rng([seed, number]))
    try:
        run, row = case.run()
    except ValueError:
        return None  # an accuracy beyond rounding
    true = np.nan
    if run.status in JUDGED:
        truth = stiff_motion.motion(case.scene, case.omega, case.attitude, case.t)
        if truth is None or not np.isfinite(truth.high).all():
            return None
        true = float(true_errors(case, run, row, truth).max())
    return Judged(
        number=number,
        case=case,
        way=way,
        method=run.plan.method,
        strength=strength,
        status=int(run.status),
        stated=float(run.error),
        asked=float(case.options.get("accuracy", 0.0)),
        true=true,
        steps=int(run.steps),
    )
