"""Does a run see a short pulse of the torque of a function? Random pulses against SciPy.

    python tests/long/pulses.py [--pulses 300] [--seed 1] [--from 0]

Each pulse is a constant torque in the body for a share of the run, of a body at rest, at 1e-9 rad/s
or turning. The truth is SciPy's DOP853, which is told where the pulse begins and ends. Fails if the
true error of a run that claims its error is above the larger of the error asked for and stated.
"""

import argparse
import ctypes
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import rigid

Floats = NDArray[np.float64]

T_END = 100.0
STARTS = {"rest": 0.0, "1e-9 rad/s": 1e-9, "turning": 0.5}
WAYS: dict[str, dict[str, Any]] = {
    "default": {},
    "accuracy": {"accuracy": 1e-7},
    "tolerance": {"tolerance": 1e-9},
    "loose": {"tolerance": 1e-5},
    "bound": {"fastest": 8.0},
}
SHARES = 0.005, 0.2
ROUNDING = 1e-11
"""Error of the truth."""

_DOUBLES = ctypes.POINTER(ctypes.c_double)


@ctypes.CFUNCTYPE(None, ctypes.c_double, _DOUBLES, _DOUBLES, _DOUBLES, _DOUBLES)  # type: ignore[untyped-decorator]
def pulse(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    acts = data[0] <= t < data[1]
    for k in range(3):
        torque[k] = data[2 + k] if acts else 0.0


@dataclass(frozen=True)
class Judged:
    """A pulse and what a run says of it."""

    number: int
    start: str
    way: str
    share: float
    true: float
    stated: float
    asked: float
    claims: bool

    @property
    def undetected(self) -> bool:
        allowed = max(self.stated, self.asked) + ROUNDING
        return self.claims and not self.true <= allowed


def judge(number: int, seed: int) -> Judged:
    rng = np.random.default_rng([seed, number])
    body = rigid.Body.box(*rng.uniform(0.5, 1.5, 3), mass=6.0)
    start = list(STARTS)[number % len(STARTS)]
    way = list(WAYS)[number // len(STARTS) % len(WAYS)]
    omega = STARTS[start] * _direction(rng)
    share = float(np.exp(rng.uniform(*np.log(SHARES))))
    begin = rng.uniform(0.0, 1.0 - share) * T_END
    gained = np.exp(rng.uniform(np.log(0.01), np.log(2.0)))
    torque = gained / (share * T_END) * np.array(body.moments) * _direction(rng)
    data = np.array([begin, begin + share * T_END, *torque])
    times = np.array([T_END]) if number % 2 else np.linspace(0.0, T_END, 4)
    asked = dict(WAYS[way])
    fastest = asked.pop("fastest", None)
    scene = rigid.FreeBody(body, torque=rigid.Torque.call(pulse, data, fastest=fastest))
    run = rigid.simulate(scene, omega, t=times, **asked)
    rates, attitudes = truth(np.array(body.moments), omega, data, times)
    size = np.linalg.norm(rates, axis=-1).max()
    apart = np.linalg.norm(run.omega - rates, axis=-1).max() / (size or 1.0)
    ends = [np.linalg.norm(run.attitude + s * attitudes, axis=-1) for s in (1.0, -1.0)]
    return Judged(
        number=number,
        start=start,
        way=way,
        share=share,
        true=max(apart, 2.0 * np.minimum(*ends).max()),
        stated=float(run.error),
        asked=asked.get("accuracy", 0.0),
        claims=bool(run.status in (rigid.Status.OK, rigid.Status.COARSE)),
    )


def _direction(rng: np.random.Generator) -> Floats:
    vector = rng.normal(size=3)
    direction: Floats = vector / np.linalg.norm(vector)
    return direction


def truth(moments: Floats, omega: Floats, data: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Rates and quaternions at these times; the attitude at the start is the identity."""

    def rate(t: float, y: Floats, torque: Floats) -> Floats:
        (a, b, c), (w, x, y_, z) = y[:3], y[3:]
        turning = 0.5 * np.array(
            [
                -x * a - y_ * b - z * c,
                w * a + y_ * c - z * b,
                w * b + z * a - x * c,
                w * c + x * b - y_ * a,
            ]
        )
        return np.concatenate([(np.cross(moments * y[:3], y[:3]) + torque) / moments, turning])

    y = np.concatenate([omega, [1.0, 0.0, 0.0, 0.0]])
    rows = {0.0: y}
    stops = [0.0, data[0], data[1], T_END]
    for first, last, acts in zip(stops[:-1], stops[1:], (0.0, 1.0, 0.0), strict=True):
        inside = times[(times > first) & (times < last)]
        at, torque = np.concatenate([inside, [last]]), acts * data[2:]
        found = solve_ivp(
            rate, (first, last), y, "DOP853", at, rtol=1e-13, atol=1e-15, args=(torque,)
        )
        rows.update(zip(at.tolist(), found.y.T, strict=True))
        y = found.y[:, -1]
    states = np.array([rows[t] for t in times.tolist()])
    attitudes = states[:, 3:]
    return states[:, :3], attitudes / np.linalg.norm(attitudes, axis=-1, keepdims=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pulses", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    chosen = parser.parse_args()
    numbers = range(chosen.first, chosen.first + chosen.pulses)
    judged = [judge(number, chosen.seed) for number in numbers]
    for way in WAYS:
        mine = [one for one in judged if one.way == way]
        claims = sum(one.claims for one in mine)
        worst = max((one.true / (one.stated + ROUNDING) for one in mine if one.claims), default=0.0)
        print(f"{way}: {claims} of {len(mine)} claimed, worst true over stated error {worst:.2g}")
    undetected = [one for one in judged if one.undetected]
    print(f"{sum(one.share > 0.02 for one in judged)} pulses longer than 2 % of the run")
    for one in undetected:
        print("UNDETECTED", one)
    return int(bool(undetected))


if __name__ == "__main__":
    sys.exit(main())
