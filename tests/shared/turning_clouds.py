"""Ten clouds of mass points that turn, and their tensors of inertia."""

import numpy as np

from rigid import inertia

RNG = np.random.default_rng(21)

#: Ten clouds of seven mass points, turning.
MASSES = RNG.uniform(0.5, 2.0, (10, 7))
POINTS = RNG.normal(size=(10, 7, 3))

TENSORS = inertia.inertia_tensor(MASSES, POINTS)
