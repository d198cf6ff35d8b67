"""Tolerances of adaptive steps for an accuracy, and the coarser runs that show their errors.

A run begins with a tolerance below its accuracy. A body that is not accurate is run once more, by
a tolerance that leaves nothing but rounding: chaos or a saddle magnifies its error.
"""

from __future__ import annotations

from dataclasses import replace

from .. import _core
from .methods import FUNCTION, TO_ROUNDING
from .problem import LEAST_TOLERANCE
from .request import Request

__all__ = [
    "COARSER_TOLERANCE",
    "SERIES",
    "SERIES_TOLERANCE",
    "coarser_run",
    "finest_tolerance",
    "first_tolerance",
    "is_ruled_by_rounding",
]

SERIES, SERIES_TOLERANCE = "taylor20", 1e-16
"""The series, with its tolerance, that leaves rounding alone.

On 200 random orbits, of eccentricities to 0.95, it errs no more than with a tolerance of 1e-20: the
ratio of the errors is 1.04 in the median, below 5.1 in 95 of 100, as it is with 1e-18."""

COARSER_TOLERANCE = 1e-11
"""The tolerance of the coarser run of a series that leaves rounding alone.

On the same orbits it errs 1700 times as much in the median, by truncation, and never less than 10
times as much. A series that errs by rounding too would hide its error in one of ten runs."""

RULED = 1e-15
"""Largest tolerance of a series whose error is rounding: on the same orbits the median of the ratio
to the error with 1e-20 is 1.18, with 1e-14 it is 2.8."""

APART = 900.0
"""Factor between the tolerances of a run and of its coarser run.

Where the motion magnifies errors, the errors of both runs have signs and sizes at random, the
coarser one APART times as large. The runs are then nearer to each other than half of the finer
error in about ``1 / (2.5 APART)`` of all cases. On 2000 eccentric orbits 0.5 % erred by more than
twice the stated error with a factor of 30."""

SHARE = 2e-4
"""First tolerance over the accuracy. The tolerance of the coarser run is a fifth of the accuracy:
the stated error is half of the accuracy unless the motion magnifies errors."""

SHARE_UNDER_FUNCTION = 0.01
"""The same under a function: some steps err, and three times the distance is stated."""

LARGEST = 1e-6
"""Largest first tolerance: the coarser run has nearly 1e-3, where orders just show."""


def first_tolerance(accuracy: float, method: str) -> float:
    """The tolerance of the first run for an accuracy."""
    if method == FUNCTION:
        # A body whose error is 1 is lost.
        return max(SHARE_UNDER_FUNCTION * min(accuracy, 1.0), LEAST_TOLERANCE)
    return min(max(SHARE * accuracy, SERIES_TOLERANCE), LARGEST)


def finest_tolerance(method: str) -> float:
    """The tolerance below which there is nothing but rounding."""
    return LEAST_TOLERANCE if method == FUNCTION else SERIES_TOLERANCE


def is_ruled_by_rounding(request: Request) -> bool:
    """Whether the tolerance of a series leaves less truncation than rounding."""
    tolerance = 1.0 if request.tolerance is None else request.tolerance
    return tolerance <= RULED and request.method != FUNCTION and not request.bodies.may_stop


def coarser_run(request: Request, tolerance: float) -> _core.States:
    """The states from the start rounded otherwise, by a series with a larger tolerance.

    Two series of high order may err alike: their errors do not fall evenly with the tolerance.
    """
    # A series of lower order may need more steps than the run whose limit this is.
    coarser = replace(
        request,
        bodies=request.bodies.rounded_otherwise(),
        method=TO_ROUNDING,
        tolerance=tolerance,
        max_steps=min(64 * request.max_steps, 2**63),
    )
    return coarser.states(None)
