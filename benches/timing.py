"""Times of calls in turns, and what no measurement can be: what all benches share.

A bench that computes nothing prints times like any other. So each bench hands its results and its
numbers to the checks of this module: an impossible one ends the bench with words and exit status 1.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid import build_info
from rigid.maps.data import CLASSES

T = TypeVar("T")
Floats = NDArray[np.float64]
Moved = tuple[ArrayLike, ...]
"""What :func:`moved` takes: ends, starts, and steps if there are any."""

QUICK = "--quick" in sys.argv[1:]
"""Whether sizes are tiny: the run shows that the bench works, and measures nothing."""


def sized(full: T, quick: T) -> T:
    """A size of a measurement, or that of a quick run."""
    return quick if QUICK else full


TICKS = sized(100, 1)
"""A turn lasts so many ticks of the clock at least: a measured time is right to a hundredth."""

READINGS = (1000, 10**6)
"""Readings in which a clock goes on: a fine one, and one that goes on fifty times a second."""


class _Quick(argparse.Action):
    """Says at once that nothing is measured."""

    def __call__(self, *_: object) -> None:
        print("quick run: not a measurement", flush=True)


def parser(doc: str) -> argparse.ArgumentParser:
    """The command line of a bench: ``--quick``, and what the bench adds."""
    made = argparse.ArgumentParser(description=doc.splitlines()[0], allow_abbrev=False)
    made.add_argument(
        "--quick", action=_Quick, nargs=0, help="tiny sizes, for seconds: not a measurement"
    )
    return made


AVX2_ALONE = {"NUMBA_CPU_NAME": "znver3", "NUMBA_CPU_FEATURES": "+avx2,+fma"}
"""The registers of numba on a processor with wider ones, where rigid is told to use AVX2."""


def installed(name: str) -> Any:
    """A package to compare with; None, which is said, if it is not installed.

    numba compiles for the instruction set of rigid. heyoka uses registers of AVX2 by default.
    """
    if name == "numba" and build_info()["isa"] == "avx2":
        os.environ.update(AVX2_ALONE)
    try:
        package = importlib.import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name != name:
            raise
        print(f"{name} is not installed: what needs it is omitted")
        return None
    if name == "numba" and QUICK:
        # Its compiler takes longer than all the rest of a quick run.
        package.config.DISABLE_JIT = True
    return package


def required(holds: object, words: str) -> None:
    """End the bench with these words unless they hold."""
    if not holds:
        raise SystemExit(words)


def positive(name: str, number: float) -> float:
    """A number that is printed: neither zero, negative, infinite nor NaN."""
    required(0.0 < number < np.inf, f"{name} = {number:g}: must be positive and finite")
    return float(number)


def share(name: str, number: float) -> float:
    """A part of a whole, such as the core of a call."""
    required(positive(name, number) <= 1.0, f"{name} = {number:g}: must be at most 1")
    return float(number)


def moved(end: ArrayLike, start: ArrayLike, steps: ArrayLike = 1) -> None:
    """States, a row each body, are finite and not those of the start; each body took a step."""
    ends = np.atleast_2d(end)
    wrong = ~np.isfinite(ends).all(axis=1) | (ends == start).all(axis=1) | (np.asarray(steps) < 1)
    required(len(ends), "states = []: must be of one body or more")
    body = int(np.argmax(wrong))
    required(
        not wrong[body],
        f"state of body {body} = {ends[body]} after {np.broadcast_to(steps, len(ends))[body]} "
        "steps: must be finite, not that of the start, and after a step or more",
    )


def counted(columns: Mapping[str, ArrayLike], bodies: int) -> None:
    """The classes of a map have so many bodies together, and some are decided."""
    of = {name: int(np.sum(columns[name])) for name in CLASSES}
    required(sum(of.values()) == bodies, f"bodies of the map = {of}: must be {bodies} together")
    required(of["stable"] + of["unstable"], f"bodies of the map = {of}: some must be decided")


def tick(clock: Callable[[], float]) -> float:
    """The least time between two readings of a clock that differ (s)."""
    for readings in READINGS:
        apart = np.diff([clock() for _ in range(readings)])
        if (apart > 0.0).any():
            return float(apart[apart > 0.0].min())
    raise SystemExit(f"clock = {clock():g} s: stands still")


def in_turns(
    sides: Mapping[str, Callable[[], T]],
    check: Callable[[T], object],
    *,
    repeats: int,
    calls: int = 1,
    clock: Callable[[], float] = time.process_time,
) -> dict[str, Floats]:
    """Seconds of a call of each side in each turn, after a first turn that does not count.

    The sides take turns, so that other programs disturb all alike. A side makes so many calls in a
    turn; ``check`` refuses the result of the last of them.
    """
    least = TICKS * tick(clock)
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    for side in sides.values():
        side()
    for _ in range(repeats):
        for name, side in sides.items():
            begin = clock()
            for _ in range(calls):
                result = side()
            turn = clock() - begin
            required(
                turn >= least,
                f"time of a turn of {name} = {turn:.1e} s: must be {TICKS} ticks of the clock, "
                f"{least:.1e} s, or more",
            )
            check(result)
            del result  # its memory is free for the next turn
            seconds[name].append(turn / calls)
    return {name: np.array(turns) for name, turns in seconds.items()}


def over(name: str, above: ArrayLike, below: ArrayLike) -> float:
    """The median ratio of two sides, turn by turn."""
    return positive(name, float(np.median(np.divide(above, below))))
