"""The second run of bodies, with which the first is compared to estimate its error.

It begins at a start that is rounded otherwise, and takes shorter steps.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .batch import Batch
from .methods import is_stiff, order_of, series_methods
from .request import Request

__all__ = ["HALVINGS", "is_damped_stiffly", "second_run"]

Floats = NDArray[np.float64]

HALVINGS = 2.0
"""The second run halves the truncation error so many times."""

FEW = 32
"""Fewer steps under strong damping: the error may grow at first as they become shorter."""

TIGHTER = 1000.0
"""The second run of a run by tolerance divides the tolerance by this.

Series of different order may err alike at tolerances that are alike."""

FINEST = 1e-15
"""With work the second run divides its tolerance so often again, but not below this.

The tolerance is that of the rates: under damping their squares, the power, converge more slowly."""


def second_run(
    request: Request,
    steps: Floats | None,
    refinement: float,
    taken: Floats,
    halvings: float = HALVINGS,
) -> dict[str, Any]:
    """The states of the same bodies at the same times, with shorter steps than those taken.

    Nearly all of their distance from the states of the first run is the error of the first run.
    """
    second = replace(
        request, batch=_rounded_start(request.batch), max_steps=min(4 * request.max_steps, 2**63)
    )
    if request.tolerance is not None:
        # Of equal order the first steps of both runs would be one polynomial. No smaller tolerance
        # could show how far it is off at a time within the shorter step.
        last, other = series_methods()[-1:-3:-1]
        tolerance = max(request.tolerance / TIGHTER, np.finfo(np.float64).tiny)
        if request.batch.forcing is not None:
            tolerance = min(tolerance, max(tolerance / TIGHTER, FINEST))
        method = other if request.method == last else last
        return replace(second, method=method, tolerance=tolerance).states(None)
    ratio = max(2.0 ** (halvings / order_of(request.method)), 1.2)
    if is_damped_stiffly(request):
        # Under strong damping the order of these methods falls, to one at worst.
        ratio = max(ratio, 4.0 if taken.min() < FEW else 2.0)
    return second.states(steps, refinement * ratio)


def _rounded_start(batch: Batch) -> Batch:
    """The bodies with their starts rounded otherwise.

    Two runs from one start would share what a saddle makes of its rounding. Zeros stay and equal
    sizes stay equal, so that a start that is in equilibrium to the bit stays one.
    """
    omega, attitude = _rounded_otherwise(batch.omega), _rounded_otherwise(batch.attitude)
    return replace(batch, omega=omega, attitude=attitude)


def _rounded_otherwise(rows: Floats) -> Floats:
    """Rows a unit in the last place off: the smallest size of each larger, the next smaller, ..."""
    size = np.abs(rows)
    order = size.argsort(axis=1, kind="stable")
    further = np.diff(np.take_along_axis(size, order, axis=1), axis=1) > 0.0
    rank = np.zeros(rows.shape)
    np.put_along_axis(rank, order[:, 1:], np.cumsum(further, axis=1), axis=1)
    rounded: Floats = rows * (1.0 + np.finfo(np.float64).eps * (1.0 - 2.0 * (rank % 2.0)))
    return rounded


def is_damped_stiffly(request: Request) -> bool:
    """Whether a method for strong damping integrates forced bodies."""
    return request.batch.forcing is not None and is_stiff(request.method)
