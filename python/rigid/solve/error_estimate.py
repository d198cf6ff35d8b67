"""The estimated errors of bodies: of steps by the core, of closed forms by their rounding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import Range
from .bodies import Bodies

Floats = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class ErrorEstimate:
    """Estimated errors of some bodies.

    Attributes
    ----------
    error : ndarray, shape (n,)
        The largest error at the compared times; NaN if it is not known.
    lost_from : ndarray, shape (n,)
        The time (s) nearest to 0 from which on the error is 1 or more; infinite if there is none.
    """

    error: Floats
    lost_from: Floats

    def write(self, bodies: NDArray[np.intp], other: ErrorEstimate) -> None:
        """Replace the estimate of some bodies."""
        self.error[bodies], self.lost_from[bodies] = other.error, other.lost_from


def unknown_error(count: int) -> ErrorEstimate:
    """The estimate of bodies whose error is unknown."""
    return ErrorEstimate(np.full(count, np.nan), np.full(count, np.nan))


def closed_form_error(bodies: Bodies, times: Floats, omega: NDArray[Any]) -> ErrorEstimate:
    """The error of a closed form: 1e-15 for each radian turned, or its growth at a saddle.

    The rates ``omega`` have the shape (n, m, 3).
    """
    return ErrorEstimate(*_core.errors_of_closed_forms(bodies, times, omega))


def known_rates(bodies: Bodies, reached: Range, met: Floats) -> Floats:
    """Bounds of the rates, under a function at least the rates met: it may have no bound."""
    rates = bodies.fastest_rates(reached)
    is_called = bodies.forces is not None and bodies.forces.calls
    return np.fmax(rates, met) if is_called else rates
