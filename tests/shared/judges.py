"""Functions that worker processes import: they judge bodies, and make scenes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import rigid


def keeps_its_sign(states: rigid.States) -> NDArray[np.bool_]:
    """As ``no_flip(2)``, as far as the looks tell."""
    kept: NDArray[np.bool_] = np.all(states.omega[..., 1] > 0.0, axis=1)
    return kept


def bodies(length: NDArray[np.float64]) -> rigid.FreeBody:
    """Rods of these lengths with a fin."""
    return rigid.FreeBody(rigid.Body(np.stack([length, 1.3 * length, 2.0 + 0.1 * length], axis=-1)))
