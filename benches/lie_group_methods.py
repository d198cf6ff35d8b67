"""Why there is no Lie-group method: error against work of CF4 and RKMK4, beside RK4 and DOP853.

The commutator-free method of order 4 (Celledoni, Marthinsen, Owren 2003) and the Munthe-Kaas method
of order 4 act on attitude and vertical by rotations. Work is counted, not timed: multiplications
and fused multiply-adds of a step on rates and vertical, a rotation being a Rodrigues formula with
two polynomials (32), the equations of motion of a top 24 for RK4 and 12 without the kinematics.

    python benches/lie_group_methods.py
"""

from __future__ import annotations

import numpy as np
from timing import Floats, moved, parser, positive, sized

import rigid

COM = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
SCENES = {
    "asymmetric top": ((1.0, 1.6, 0.7), 1.2 * COM, (0.4, 0.7, 2.0), 5.0),
    "Lagrange top": ((1.0, 1.0, 0.4), np.array([0.0, 0.0, 1.0]), (0.0, 0.0, 6.0), 5.0),
    "free body": ((1.0, 2.0, 3.0), np.zeros(3), (0.3, 1.0, 0.2), 20.0),
}
"""Moments, weight, rates and the time of a run."""
GAMMA = np.array([0.0, np.sin(1.0), np.cos(1.0)])
ATTITUDE = [np.cos(0.5), np.sin(0.5), 0.0, 0.0]
STEPS = sized((0.2, 0.1, 0.05, 0.025), (0.2, 0.1))
WORK = {"rk4": 96.0, "cf4": 260.0, "rkmk4": 4 * 12 + 5 * 32 + 40 + 3 * 24.0, "dop853": 636.0}


State = tuple[Floats, Floats]


class Body:
    """Moments and weight of what moves."""

    def __init__(self, moments: tuple[float, ...], weight: Floats) -> None:
        self.moments, self.weight = np.array(moments), weight

    def acceleration(self, omega: Floats, gamma: Floats) -> Floats:
        torque = np.cross(gamma, self.weight) + np.cross(self.moments * omega, omega)
        rate: Floats = torque / self.moments
        return rate


def turned(gamma: Floats, u: Floats) -> Floats:
    """The vertical seen from the body after it turned by the rotation vector ``u``."""
    angle = float(np.linalg.norm(u))
    if angle == 0.0:
        return gamma
    axis = u / angle
    across = np.cross(gamma, axis)
    seen: Floats = gamma + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(across, axis)
    return seen


def cf4(body: Body, omega: Floats, gamma: Floats, h: float) -> State:
    acceleration = body.acceleration
    k1 = acceleration(omega, gamma)
    w2 = omega + 0.5 * h * k1
    g2 = turned(gamma, 0.5 * h * omega)
    k2 = acceleration(w2, g2)
    w3 = omega + 0.5 * h * k2
    k3 = acceleration(w3, turned(gamma, 0.5 * h * w2))
    w4 = omega + h * k3
    k4 = acceleration(w4, turned(g2, h * (w3 - 0.5 * omega)))
    first = h * (omega / 4 + (w2 + w3) / 6 - w4 / 12)
    second = h * (w4 / 4 + (w2 + w3) / 6 - omega / 12)
    return omega + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6, turned(turned(gamma, first), second)


def dexpinv(u: Floats, v: Floats) -> Floats:
    """Body rates to the rate of the rotation vector, to the terms that order 4 needs."""
    once = np.cross(u, v)
    rate: Floats = v + 0.5 * once + np.cross(u, once) / 12.0
    return rate


def rkmk4(body: Body, omega: Floats, gamma: Floats, h: float) -> State:
    acceleration = body.acceleration
    zero = np.zeros(3)
    a1, b1 = acceleration(omega, gamma), dexpinv(zero, omega)
    w, u = omega + 0.5 * h * a1, 0.5 * h * b1
    a2, b2 = acceleration(w, turned(gamma, u)), dexpinv(u, w)
    w, u = omega + 0.5 * h * a2, 0.5 * h * b2
    a3, b3 = acceleration(w, turned(gamma, u)), dexpinv(u, w)
    w, u = omega + h * a3, h * b3
    a4, b4 = acceleration(w, turned(gamma, u)), dexpinv(u, w)
    u = h * (b1 + 2 * b2 + 2 * b3 + b4) / 6
    return omega + h * (a1 + 2 * a2 + 2 * a3 + a4) / 6, turned(gamma, u)


def scene_of(moments: tuple[float, ...], weight: Floats) -> rigid.FreeBody | rigid.HeavyTop:
    mgl = float(np.linalg.norm(weight))
    body = rigid.Body(moments)
    return rigid.HeavyTop(body, mgl=mgl, com=weight / mgl) if mgl else rigid.FreeBody(body)


def errors(name: str, key: str) -> list[float]:
    """Distance of rates and vertical from the truth at the end, for each step."""
    moments, weight, rates, t_end = SCENES[key]
    start = (scene_of(moments, weight), rates, ATTITUDE)
    options = {"t": [t_end], "record": "axis", "check": False}
    truth = rigid.simulate(*start, method="taylor20", step=0.02, **options)
    found = []
    for h in STEPS:
        if name in ("rk4", "dop853"):
            run = rigid.simulate(*start, method=name, step=h, **options)
            omega, gamma = run.omega[0], run.gamma[0]
        else:
            step, body = (cf4 if name == "cf4" else rkmk4), Body(moments, weight)
            omega, gamma = np.array(rates), GAMMA
            for _ in range(round(t_end / h)):
                omega, gamma = step(body, omega, gamma, h)
        moved(omega, rates)
        off = np.concatenate([omega - truth.omega[0], gamma - truth.gamma[0]])
        found.append(positive(f"error of {name}", float(np.linalg.norm(off))))
    return found


def main() -> None:
    parser(__doc__).parse_args()
    for key in SCENES:
        print(f"{key:<16}{'work':>8}" + "".join(f"{f'h = {h:g}':>10}" for h in STEPS), end="")
        print("   operations per unit of time for 1e-3, 1e-6, 1e-9")
        for name, work in WORK.items():
            found = errors(name, key)
            order = 8.0 if name == "dop853" else 4.0
            # From the shortest step above rounding.
            k = max((k for k, error in enumerate(found) if error > 1e-11), default=0)
            needed = [
                work / (STEPS[k] * (e / found[k]) ** (1.0 / order)) for e in (1e-3, 1e-6, 1e-9)
            ]
            print(f"{name:<16}{work:8.0f}" + "".join(f"{error:10.1e}" for error in found), end="")
            print("   " + "".join(f"{operations:10,.0f}" for operations in needed))


if __name__ == "__main__":
    main()
