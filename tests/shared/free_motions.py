"""Free bodies and their paths; moments and tops at random."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import rigid
from physics import Floats, present, rotation_matrix

OBLATE, PROLATE = (1.0, 1.0, 1.6), (1.0, 1.0, 0.55)
SPUN = np.array([0.9, 0.0, 2.3])


def moments_at_random(count: int, random: np.random.Generator) -> Floats:
    """Moments of random clouds of points, in random order: never impossible."""
    squares = random.uniform(0.1, 2.0, (count, 3))
    moments: Floats = squares.sum(axis=1, keepdims=True) - squares
    return moments


def path(body: ArrayLike, omega: ArrayLike, t: ArrayLike, start: ArrayLike | None = None) -> Any:
    """A free motion by closed form: rates and matrices body to space."""
    run = rigid.simulate(rigid.FreeBody(rigid.Body(body)), omega, start, t=t, method="exact")
    return run.omega, rotation_matrix(present(run.attitude))


def of_jacobi(moments: Floats, omega: Floats) -> tuple[float, float, float]:
    """Parameter and rate of the Jacobi functions of a free body, and ``2 E I3 - L²``.

    Moments ascend (Landau and Lifshitz, Mechanics, § 37).
    """
    i1, i2, i3 = moments
    w1, w2, w3 = omega
    above = i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2  # L² - 2 E I1
    below = i1 * (i3 - i1) * w1**2 + i2 * (i3 - i2) * w2**2
    first, second = (i3 - i2) * above, (i2 - i1) * below
    square = max(first, second)  # the larger one belongs to the axis about which the body turns
    return min(first, second) / square, math.sqrt(square / (i1 * i2 * i3)), below


def tops_at_random(
    count: int, random: np.random.Generator, **acting: Any
) -> tuple[rigid.HeavyTop, Floats, Floats]:
    """Heavy tops of any shape, with rates and attitudes."""
    com = random.normal(size=(count, 3))
    scene = rigid.HeavyTop(
        rigid.Body(moments_at_random(count, random)),
        mgl=random.uniform(0.1, 2.0, count),
        com=com / np.linalg.norm(com, axis=1, keepdims=True),
        **acting,
    )
    return scene, random.normal(size=(count, 3)), random.normal(size=(count, 4))


def _slow_down(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -0.5 * omega[k]


def slowing_ball(force: str, fastest: float | None = None) -> rigid.FreeBody:
    """A ball that slows as exp(-D t / I), or under drag as 1 / (1 + C w t / I)."""
    forces: dict[str, dict[str, Any]] = {
        "damping": {"damping": 0.5},
        "drag": {"drag": 0.5},
        "callback": {"torque": rigid.Torque.call(_slow_down, fastest=fastest)},
    }
    return rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)), **forces[force])
