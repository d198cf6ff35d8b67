"""The phase error that the drift of a run causes in a free body next to its separatrix."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .error_estimate import ErrorEstimate
from .request import Request

__all__ = ["circulation_terms", "with_separatrix"]

Floats = NDArray[np.float64]


def circulation_terms(moments: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """The terms of ``2 T I2 - L²`` from the rates about axes 1 and 3; axes in ascending moments.

    The first minus the second term is ``2 T I2 - L²``. The difference of energy and momentum would
    lose all digits near the separatrix.
    """
    i1, i2, i3 = np.moveaxis(moments, -1, 0)
    return i1 * (i2 - i1) * omega[..., 0] ** 2, i3 * (i3 - i2) * omega[..., 2] ** 2


def with_separatrix(
    request: Request, states: Mapping[str, Any], estimate: ErrorEstimate
) -> ErrorEstimate:
    """The estimate with the phase error from drift beside the separatrix."""
    near = _core.phase_errors(request.bodies, request.times, states)
    if near is None:
        return estimate
    delay, lost = near
    # Of a body that was not run again no error is known, but that its phase is lost.
    known = ~np.isnan(estimate.error) | np.isfinite(lost)
    error = np.where(known & (delay > 0.0), np.fmax(estimate.error, delay), estimate.error)
    earlier = known & ~(np.abs(estimate.lost_from) < np.abs(lost))
    return ErrorEstimate(error, np.where(earlier, lost, estimate.lost_from))
