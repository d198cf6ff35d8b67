"""The processor time of one body of a call, measured by running some of the bodies."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")

BUDGET = 0.4
"""Processor time of all runs together (s): half a second with what comes before and after."""

FEW = 512
"""Bodies of a run whose horizon is not yet the whole one: of these the bodies that are checked
alone, at most 32, are a sixteenth."""

PACK = 8
"""Bodies that are moved side by side: fewer take as long."""

LEAST_STEPS = 1000
"""Least ``max_steps`` of a run: steps may be short at the start."""

LEAST_SHARE = 1e-6
"""First share of the horizon: a call of 1e9 steps, the most of a body, takes a thousand there."""

SHORT = 0.01 * BUDGET
"""Longest time (s) of the run before the bodies of a run become more."""

SLOW = 0.05 * BUDGET
"""A run of one body that takes longer (s) is too slow for a pack, or calls Python for each body."""

GROWTH = 8.0
"""Largest growth from run to run: a run that took its least number of steps shows no more."""

LEAST_GROWTH = 1.5
"""A run that is less longer than the one before tells little more."""

REPEATED = 0.25 * BUDGET
"""A whole call that is shorter (s) is repeated for this time, and the mean counts: where the time
of a process is limited, its clock may tick 250 times a second only."""

TICK = 1e-6
"""Shortest time (s) that is told from zero."""


def seconds_of_one(
    run: Callable[[int, float], Result], most: int, few: int = FEW, share: float = LEAST_SHARE
) -> tuple[float, Result | None]:
    """Processor time (s) of one body of a call, of all threads together.

    The bodies become more, then their horizon longer, then again the bodies more, as long as the
    next run is likely to take at most half of the time that is left, or 0.8 of it over the whole
    horizon: bodies that end last leave lanes empty, the less the more bodies there are. What does
    not grow with the horizon is counted once.

    Parameters
    ----------
    run : callable
        Runs so many of the bodies for this share of the horizon.
    most : int
        Bodies of the call, at least one.
    few : int
        Bodies of the runs in which the horizon grows.
    share : float
        First share of the horizon.

    Returns
    -------
    seconds : float
    result : object or None
        What the last run returned; None if it did not reach the whole horizon.
    """
    begin = time.process_time()

    def clocked(count: int, share: float) -> tuple[float, Result]:
        started = time.process_time()
        result = run(count, share)
        return time.process_time() - started, result

    def growth(taken: float, fixed: float, part: float) -> float:
        left = part * (BUDGET - (time.process_time() - begin))
        return min(GROWTH, (left - fixed) / max(taken - fixed, TICK))

    few = min(few, most)
    taken, result = clocked(1, share)  # what is made once takes its time here
    count = min(PACK, few) if taken < SLOW else 1
    taken, result = clocked(count, share)
    while count < few and taken < SHORT:
        count = min(PACK * count, few)
        taken, result = clocked(count, share)
    fixed = taken
    while share < 1.0 and (more := growth(taken, fixed, 0.5)) > LEAST_GROWTH:
        share = min(1.0, more * share)
        taken, result = clocked(count, share)
    if share < 1.0:
        return (fixed + max(taken - fixed, 0.0) / share) / count, None
    while count < most and (more := growth(taken, 0.0, 0.8)) > LEAST_GROWTH:
        count = min(most, math.ceil(more * count))
        taken, result = clocked(count, share)
    runs = 1
    while count == most and taken < REPEATED:
        taken += clocked(count, share)[0]
        runs += 1
    return taken / (runs * count), result
