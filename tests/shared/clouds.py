"""Random clouds of particles, and a thrown body."""

from typing import Any

import numpy as np

import rigid
from physics import Floats
from rigid import particles

RNG_SEED = 11


def cloud(count: int, seed: int = RNG_SEED) -> tuple[Floats, Floats, Floats, Floats]:
    """Masses, positions, velocities and forces of that many particles."""
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(0.5, 2.0, count),
        rng.normal(size=(count, 3)),
        rng.normal(size=(count, 3)),
        rng.normal(size=(count, 3)),
    )


BODY = rigid.Body((1.0, 2.0, 3.0), mass=1.7)
TIMES = np.linspace(0.0, 5.0, 41)
RATES = np.array([0.02, 1.0, 0.02])


def throw(force: Any, t: Any = TIMES, **options: Any) -> particles.BodyPath:
    start = {"position": [1.0, 2.0, 3.0], "velocity": [0.5, -1.0, 4.0], "omega": RATES, **options}
    return particles.propagate_body(BODY, force=force, t=t, **start)
