"""The second run of bodies, with which the first is compared to estimate its error.

It begins at a start that is rounded otherwise, and takes shorter or longer steps.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import intervals, time_ranges
from .batch import Batch
from .cost_model import MARGIN, laws, phase_error
from .methods import is_stiff, order_of, series_methods
from .request import Request

__all__ = ["coarser_run", "finer_run", "has_coarser_run", "is_damped_stiffly"]

Floats = NDArray[np.float64]

FEW = 32
"""Fewer steps under strong damping: the error may grow at first as they become shorter."""

TIGHTER = 1000.0
"""The second run of a run by tolerance divides the tolerance by this.

Series of different order may err alike at tolerances that are alike."""

GAIN = 20.0
"""The second run with longer steps should err so many times as much as the first.

The errors of steps that are longer still obey the law less well: with a gain of 100 three times as
many of 10 000 random runs err by more than is stated."""

COARSE = 0.01
"""Largest error (rad) that longer steps should have."""

LONGEST = 2.5
"""Steps are made longer by this factor at most."""

LEAST = 4.0
"""Where the gain would be less, the steps of the second run are shorter.

Steps are few between some wanted times, or are as long as the law of their error holds."""


def has_coarser_run(
    request: Request, steps: Floats | None, accuracy: float | None
) -> NDArray[np.bool_]:
    """Whether a run with longer steps tells the error of a run for an accuracy; shape (n,)."""
    count = len(request.batch)
    if steps is None or accuracy is None or request.batch.forcing is not None:
        return np.zeros(count, dtype=bool)
    can: NDArray[np.bool_] = _gain(request, steps, _longer(request, steps, accuracy)) >= LEAST
    return can


def coarser_run(
    request: Request, steps: Floats, rounding: Floats, accuracy: float
) -> tuple[dict[str, Any], Floats]:
    """The states with longer steps, and which share of the distance to them is the error.

    If steps are longer by a factor ``r``, the error of a method of order ``p`` is larger by
    ``r**p``, however much the motion magnifies the errors of its steps. It magnifies rounding as
    much: so much of the distance belongs to rounding as the errors of the steps compare.

    Parameters
    ----------
    request : Request
    steps : ndarray, shape (n,)
        The longest step of each body in the first run (s).
    rounding : ndarray, shape (n,)
        What rounding leaves of a motion that magnifies nothing (rad).
    accuracy : float
        The error that is asked for.
    """
    longer = _longer(request, steps, accuracy)
    gain = _gain(request, steps, longer)
    second = replace(request, batch=_rounded_start(request.batch))
    states = second.states(longer)
    taken = states["steps"].astype(np.float64)
    of_steps = phase_error(request.batch, request.method, request.times, taken, None)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.fmin(1.0 / (gain - 1.0) + MARGIN * rounding / of_steps, 1.0)
    return states, share


def _longer(request: Request, steps: Floats, accuracy: float) -> Floats:
    """The steps of the second run: the errors of both runs follow one law."""
    gain = min(GAIN, COARSE / accuracy)
    ratio = np.clip(gain ** (1.0 / order_of(request.method)), 1.0, LONGEST)
    _, largest = laws(request.batch, request.method)
    rates = request.batch.fastest_rates(time_ranges(request.times), request.method)
    with np.errstate(divide="ignore"):
        longest = largest / rates
    longer: Floats = np.minimum(ratio * steps, longest)
    return longer


def _gain(request: Request, steps: Floats, longer: Floats) -> Floats:
    """How many times larger the error of longer steps is at least.

    Between two wanted times whole numbers of steps are taken.
    """
    between = intervals(request.times)
    shortest = np.where(between > 0.0, between, np.inf).min(axis=-1, initial=np.inf)
    ratio = longer / (steps * (1.0 + longer / shortest))
    gain: Floats = ratio ** order_of(request.method)
    return gain


def finer_run(
    request: Request, steps: Floats | None, refinement: float, taken: Floats
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
        method = other if request.method == last else last
        return replace(second, method=method, tolerance=tolerance).states(None)
    ratio = max(2.0 ** (2.0 / order_of(request.method)), 1.2)
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
