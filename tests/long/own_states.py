"""Is the error true of bodies with own states under functions of the user? Against SciPy.

    pip install numba && python -P tests/long/own_states.py [--runs 2000] [--seed 1] [--from 0]

Without -P numba takes the script coverage.py beside this one for the package of that name.
Wheels that saturate, filters, springs and thrusters that switch, with random numbers. The truth
is SciPy's DOP853 at 3e-14 and at 1e-12: a run is judged if the two tell it from its stated error.
Fails if more than one run in 2000 by adaptive steps claims an error that it exceeds. Runs of
``rk4`` are counted only: two runs in equal steps may err alike at a jump.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import rigid

Floats = NDArray[np.float64]

MOST_UNDETECTED = 1 / 2000
WAYS: dict[str, dict[str, Any]] = {
    "default": {},
    "accuracy": {"accuracy": 1e-7},
    "tolerance": {"tolerance": 1e-9},
    "loose": {"tolerance": 1e-6},
    "rk4": {"method": "rk4"},
}
SMALL = 1e-6, 1e-9
"""Sizes below which no error of a state is relative to it: see ``Torque.call``."""

ROUNDING = 1e-11
"""Error that both truths may share: a corner of the torque is met by SciPy's steps by chance."""

MOST_STEPS = 20_000
"""A spring that spins the body up takes endless steps: the run then claims nothing."""


def wheel(t, omega, attitude, data, torque, states, rates):  # type: ignore[no-untyped-def]
    """A wheel whose motor saturates, behind a filter."""
    asked = -data[0] * omega[2]
    rates[0] = data[1] * (asked - states[0])
    motor = min(max(states[0], -data[2]), data[2])
    torque[0], torque[1], torque[2] = -omega[1] * states[1], omega[0] * states[1], motor
    rates[1] = -motor


def spring(t, omega, attitude, data, torque, states, rates):  # type: ignore[no-untyped-def]
    """A mass on a spring that the third rate drives, and that acts back."""
    pull = data[0] * states[0] + data[1] * states[1]
    rates[0], rates[1] = states[1], -pull + data[2] * omega[0]
    torque[0], torque[1], torque[2] = data[2] * pull, 0.0, 0.1 * data[2] * np.sin(data[0] * t)


def relay(t, omega, attitude, data, torque, states, rates):  # type: ignore[no-untyped-def]
    """A thruster that fires while an axis is up, and the fuel that it takes, behind a filter."""
    w, x, y, z = attitude
    fires = 2.0 * (x * z - w * y) > 0.3 * data[1]
    torque[0], torque[1], torque[2] = (0.3 * data[0] if fires else 0.0), -0.1 * omega[1], 0.0
    rates[0] = abs(torque[0])
    rates[1] = data[2] * (states[0] - states[1])


FUNCTIONS: dict[str, Callable[..., None]] = {
    one.__name__: numba.njit(one, error_model="numpy") for one in (wheel, spring, relay)
}


@dataclass(frozen=True)
class Judged:
    """A run: what it states of its error, the true one, and how well that is known."""

    number: int
    function: str
    way: str
    true: float
    unsure: float
    stated: float
    claims: bool

    @property
    def undetected(self) -> bool:
        """Whether the error is above the stated one, whatever the error of the truth."""
        return self.claims and self.true > self.stated + self.unsure


def judge(number: int, seed: int) -> Judged:
    rng = np.random.default_rng([seed, number])
    name = list(FUNCTIONS)[number % len(FUNCTIONS)]
    way = list(WAYS)[number // len(FUNCTIONS) % len(WAYS)]
    body = rigid.Body.box(*rng.uniform(0.5, 1.5, 3), mass=6.0)
    omega, data = rng.normal(size=3), np.exp(rng.uniform(np.log(0.05), np.log(2.0), 3))
    states = rng.normal(size=2) * (name != "relay")
    asked = dict(WAYS[way])
    fastest = 8.0 if way == "rk4" else None
    torque = rigid.Torque.call(FUNCTIONS[name], data, states=2, fastest=fastest)
    times = np.linspace(0.0, rng.uniform(5.0, 40.0), int(rng.integers(2, 6)))[1:]
    run = rigid.simulate(
        rigid.FreeBody(body, torque=torque), omega, states=states, t=times, progress=False,
        max_steps=MOST_STEPS, **asked,
    )  # fmt: skip
    claims = bool(run.status in (rigid.Status.OK, rigid.Status.COARSE))
    if not claims:
        return Judged(number, name, way, np.nan, np.nan, np.nan, claims)
    moments = np.array(body.moments)
    fine, coarse = (
        truth(name, moments, np.concatenate([omega, states]), data, times, tolerance)
        for tolerance in (3e-14, 1e-12)
    )
    mine = np.concatenate([run.omega, run.attitude, run.states], axis=1)
    return Judged(
        number=number,
        function=name,
        way=way,
        true=apart(mine, fine),
        unsure=apart(coarse, fine) + ROUNDING,
        stated=max(float(run.error), asked.get("accuracy", 0.0)),
        claims=claims,
    )


def apart(one: Floats, other: Floats) -> float:
    """The largest relative distance of rates, attitudes and states, (m, 9)."""
    rates = np.linalg.norm(one[:, :3] - other[:, :3], axis=1).max()
    rates /= np.linalg.norm(other[:, :3], axis=1).max()
    ends = [np.linalg.norm(one[:, 3:7] + s * other[:, 3:7], axis=1) for s in (1.0, -1.0)]
    size = np.abs(other[:, 7:]).max(axis=0)
    size = np.maximum(size, max(SMALL[0] * size.max(), SMALL[1]))
    states = (np.abs(one[:, 7:] - other[:, 7:]) / size).max()
    return float(max(rates, 2.0 * np.minimum(*ends).max(), states))


def equations(function: Callable[..., None]) -> Callable[..., Floats]:
    """The rates of change of rates, quaternion and states."""

    def rate(t, y, moments, data):  # type: ignore[no-untyped-def]
        omega, q = y[:3], y[3:7] / np.sqrt(np.sum(y[3:7] ** 2))
        torque, rates, changes = np.zeros(3), np.zeros(2), np.empty(9)
        function(t, omega, q if q[0] >= 0.0 else -q, data, torque, y[7:], rates)
        (a, b, c), (w, x, v, z) = omega, q
        for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            changes[k] = (torque[k] + (moments[i] - moments[j]) * omega[i] * omega[j]) / moments[k]
        changes[3], changes[4] = 0.5 * (-x * a - v * b - z * c), 0.5 * (w * a + v * c - z * b)
        changes[5], changes[6] = 0.5 * (w * b + z * a - x * c), 0.5 * (w * c + x * b - v * a)
        changes[7:] = rates
        return changes

    made: Callable[..., Floats] = numba.njit(rate, error_model="numpy")
    return made


EQUATIONS = {name: equations(function) for name, function in FUNCTIONS.items()}


def truth(
    name: str, moments: Floats, start: Floats, data: Floats, times: Floats, tolerance: float
) -> Floats:
    """Rates, quaternions and states at these times; the attitude at the start is the identity."""
    found = solve_ivp(
        EQUATIONS[name], (0.0, times[-1]), np.concatenate([start[:3], [1.0, 0, 0, 0], start[3:]]),
        "DOP853", times, args=(moments, data), rtol=tolerance, atol=1e-3 * tolerance, max_step=0.2,
    )  # fmt: skip
    if not found.success:  # its steps became shorter than rounding
        return truth(name, moments, start, data, times, 10.0 * tolerance)
    states: Floats = found.y.T
    states[:, 3:7] /= np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    return states


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    chosen = parser.parse_args()
    judged = []
    for number in range(chosen.first, chosen.first + chosen.runs):
        judged.append(judge(number, chosen.seed))
        if judged[-1].undetected:
            print("UNDETECTED", judged[-1], flush=True)
    counts = Counter((one.function, one.way) for one in judged)
    for (name, way), count in sorted(counts.items()):
        mine = [one for one in judged if (one.function, one.way) == (name, way)]
        claims, wrong = sum(one.claims for one in mine), sum(one.undetected for one in mine)
        print(f"{name:8} {way:10} {count:5} runs, {claims:5} claimed, {wrong:3} undetected")
    adaptive = [one for one in judged if one.way != "rk4"]
    wrong = sum(one.undetected for one in adaptive)
    print(f"{wrong} of {len(adaptive)} by adaptive steps undetected")
    return int(wrong > MOST_UNDETECTED * len(adaptive))


if __name__ == "__main__":
    sys.exit(main())
