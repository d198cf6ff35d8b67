"""The key of the random numbers."""

from __future__ import annotations

import numpy as np

from .._checks.arguments import brief, whole


def seed_from(rng: int | np.random.Generator | np.random.SeedSequence | None) -> int:
    """The 128-bit key of the random numbers that ``rng`` specifies."""
    if rng is None:
        rng = np.random.SeedSequence()
    if isinstance(rng, np.random.SeedSequence):
        low, high = rng.generate_state(2, np.uint64).tolist()
    elif isinstance(rng, np.random.Generator):
        low, high = rng.integers(2**64, size=2, dtype=np.uint64).tolist()
    elif isinstance(rng, (int, np.integer)):
        return checked_seed("rng", rng)
    else:
        raise TypeError(
            f"rng = {brief(rng)}: must be a whole number, a numpy Generator or SeedSequence, "
            "or None"
        )
    return int(low) | int(high) << 64


def checked_seed(name: str, seed: object) -> int:
    """``seed`` as a key of the random numbers, a whole number of at most 128 bits."""
    number = whole(name, seed)
    if not 0 <= number < 2**128:
        raise ValueError(f"{name} = {brief(seed)}: must lie in 0 .. 2**128 - 1")
    return number
