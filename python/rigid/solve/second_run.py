"""The second run of bodies, which is compared with the first to estimate its error.

It begins at a start that is rounded otherwise, and takes shorter steps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import time_ranges, time_span
from .bodies import Bodies
from .methods import FUNCTION, angle_per_step, is_compensated, is_stiff, order_of, series_methods
from .request import Request

__all__ = [
    "ELSEWHERE",
    "FINEST",
    "HALVINGS",
    "HALVINGS_AGAIN",
    "RUNGE_KUTTA",
    "has_its_order",
    "is_damped_stiffly",
    "is_refined_alike",
    "longest_steps",
    "second_run",
    "step_ratio",
]

Floats = NDArray[np.float64]

HALVINGS = 2.0
"""Number of halvings of the truncation error in the second run."""

HALVINGS_AGAIN = 4.0
"""Halvings in the second run where the motion multiplies errors, as for bodies integrated again.

Two runs of which one errs by a quarter of the other then err alike by chance in 5 of 100 cases, by
a sixteenth in 1 or 2."""

TIGHTER = 1000.0
"""The second run of a run by tolerance divides the tolerance by this.

Series of different order may err alike at tolerances that are alike."""

FINEST = 1e-20
"""Least tolerance of a second run."""

FEWEST = 16.0
"""Least number of steps of a second run: the errors of fewer do not fall evenly."""

FINER = 8.0
"""Factor by which the steps of the second run are shorter for a body that drag may stop.

Steps of a quarter leave one error in a hundred above the stated error, by up to 20 times."""

RUNGE_KUTTA = "dop853"
"""The method of a body that drag may stop where a series is the method of others, or of the first
run."""

COMPENSATED = "taylor16"
"""The second run of a series that does not carry its rounding errors on."""

ELSEWHERE = 0.5 * (1.0 + 5.0**0.5)
"""Factor by which the longest step under a function is shorter in the second run by a tolerance.

It is no ratio of small whole numbers: both runs look at the torque in different places."""

SUBDIVIDING = "midpoint"
"""The method that divides a step by 4, 16 or 64 where its equation has no solution."""


def second_run(
    request: Request,
    steps: Floats | None,
    refinement: float,
    taken: Floats,
    halvings: float = HALVINGS,
    rounding: int = 0,
) -> _core.States:
    """The states of the same bodies at the same times, with shorter steps than those taken.

    Nearly all of their distance from the states of the first run is the error of the first run. Its
    ``rounding`` is one of ``_core.ROUNDINGS``.
    """
    second = replace(
        request,
        bodies=request.bodies.rounded_otherwise(rounding),
        max_steps=min(64 * request.max_steps, 2**63),
    )
    if request.bodies.may_stop:
        return _past_stops(second, steps, refinement, taken)
    if request.tolerance is not None:
        # Of equal order the first steps of both runs would be one polynomial. No smaller tolerance
        # could show how far it is off at a time within the shorter step.
        last, other = series_methods()[-1:-3:-1]
        method = other if request.method == last else last
        tighter, refinement = TIGHTER, 1.0
        if request.method == FUNCTION:
            # The only one under the torque of a function.
            method, refinement = request.method, ELSEWHERE
        elif request.bodies.forces is not None:
            # The tolerance refers to the rates. Their square, the power, has twice their damping:
            # the last terms of its series are so many times as large.
            tighter *= 2.0 ** order_of(method)
        tolerance = max(request.tolerance / tighter, min(request.tolerance, FINEST))
        return replace(second, method=method, tolerance=tolerance).states(None, refinement)
    ratio = step_ratio(request.bodies, request.method, halvings)
    if request.method in series_methods() and not is_compensated(request.method):
        # Rounding that is alike in each step shows against none only.
        steps = longest_steps(second, request.method) if steps is None else steps
        second = replace(second, method=COMPENSATED)
    if steps is not None:
        steps = np.minimum(steps, refinement * ratio / FEWEST * time_span(second.times))
    return second.states(steps, refinement * ratio)


def step_ratio(bodies: Bodies, method: str, halvings: float = HALVINGS) -> float:
    """Factor by which the steps of the second run are shorter, in steps of the same method."""
    # Of forced bodies the order falls where damping is as fast as the steps.
    ratio: float = max(2.0 ** (halvings / order_of(method)), 1.2 if bodies.forces is None else 1.3)
    if is_damped_stiffly(bodies, method):
        # Under strong damping the order of these methods falls.
        ratio = max(ratio, 2.0)
    if method == SUBDIVIDING and ratio == 4.0:
        ratio = 6.0  # steps of a quarter are those that the first run may have divided
    return ratio


def has_its_order(bodies: Bodies, method: str) -> bool:
    """Whether the error falls with the order: not at a stop by drag, nor under strong damping."""
    return bodies.forces is None or not (bodies.may_stop or is_stiff(method))


def is_refined_alike(bodies: Bodies, method: str) -> bool:
    """Whether the second run is by the same method, and its error falls with the order."""
    other = method in series_methods() and not is_compensated(method)
    return has_its_order(bodies, method) and not other


def longest_steps(request: Request, method: str) -> Floats:
    """The longest steps that a method takes by default (s), shape (n,); infinite at rest."""
    rates = request.bodies.fastest_rates(time_ranges(request.times), method)
    with np.errstate(divide="ignore"):
        longest: Floats = angle_per_step(method) / rates
    return longest


def _past_stops(
    second: Request, steps: Floats | None, refinement: float, taken: Floats
) -> _core.States:
    """The states of bodies that drag may stop, by a Runge-Kutta method in far shorter steps.

    Where the body stops the speed has a corner. The error of the step that passes the corner falls
    with its cube, whatever the order, and depends on where in the step the corner is: of two runs
    with like steps either may err more. A series continues as if there were no corner.
    """
    if second.method not in series_methods():
        return second.states(steps, refinement * FINER)
    with np.errstate(invalid="ignore"):  # of a body that covers no time
        own = time_span(second.times) / taken / FINER
    longest = np.minimum(own, longest_steps(second, RUNGE_KUTTA))
    return replace(second, method=RUNGE_KUTTA, tolerance=None).states(longest)


def is_damped_stiffly(bodies: Bodies, method: str) -> bool:
    """Whether a method for strong damping integrates forced bodies."""
    return bodies.forces is not None and is_stiff(method)
