"""Free bodies and their paths; moments and tops at random."""

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
