"""The distance of a free body from its separatrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def circulation_terms(moments: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """The terms of ``2 T I2 - L²`` from the rates about axes 1 and 3; axes in ascending moments.

    The first minus the second term is ``2 T I2 - L²``. The difference of energy and momentum would
    lose all digits near the separatrix.
    """
    i1, i2, i3 = np.moveaxis(moments, -1, 0)
    return i1 * (i2 - i1) * omega[..., 0] ** 2, i3 * (i3 - i2) * omega[..., 2] ** 2
