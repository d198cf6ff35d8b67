"""The missing units of a running map, and their computation."""

from __future__ import annotations

import operator
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._checks.progress import ProgressOption, reporting, terminated
from ..maps.data import MapData
from ..maps.refine import lattice_level, refined, stages
from .drive import Intake, Task, drive, executor_of, own_build, run_here
from .head import StoreError
from .rows import compute, unequal
from .running import Memory

Data = TypeVar("Data", bound=MapData)

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""The golden ratio: the upper bits of its multiples follow no pattern of a grid."""


MOST_PARTS = 2**31
"""Most parts of a map. The numbers of units, below 2**63, are dealt to them."""

MOST_AGAIN = 16
SECONDS_AGAIN = 0.5
"""Most rows that are computed again, and most processor time (s) of these rows."""

_RULE = f"must be k/n with 1 <= k <= n <= {MOST_PARTS}"


@dataclass(frozen=True, slots=True)
class Part:
    """A share of the units, for jobs that run side by side.

    Attributes
    ----------
    number, count : int
        Part ``number`` of ``count``, from 1.
    """

    number: int = 1
    count: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.count <= MOST_PARTS:
            raise ValueError(f"part = {self}: {_RULE}")

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    @classmethod
    def of(cls, part: str | tuple[int, int] | None) -> Part:
        """A part from ``"k/n"`` or ``(k, n)``; all units for None."""
        if part is None:
            return cls()
        try:
            number, count = map(int, part.split("/")) if isinstance(part, str) else part
            return cls(operator.index(number), operator.index(count))
        except TypeError:
            raise TypeError(f"part = {brief(part)}: must be 'k/n' or (k, n), whole") from None
        except ValueError:
            raise ValueError(f"part = {brief(part)}: {_RULE}") from None

    def has(self, units: NDArray[np.int64], running: Memory) -> NDArray[np.bool_]:
        """Which units belong to this part.

        Those with a possible body are dealt one after the other, a turn to all parts. Each turn
        begins with another part, lest columns of the grid become parts.
        """
        if self.count == 1:
            return np.ones(len(units), np.bool_)
        possible = np.repeat(running.status == 0, running.head.segments)
        turn, seat = np.divmod(np.cumsum(possible)[units] - 1, self.count)
        shift = (turn.astype(np.uint64) * GOLDEN) >> np.uint64(40)
        mine: NDArray[np.bool_] = (seat + shift.astype(np.int64)) % self.count == self.number - 1
        return mine


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a sitting ended: complete, interrupted, terminated, waiting or with poisoned units.

    Attributes
    ----------
    reason : str
        ``complete``, ``interrupted`` by Ctrl-C, ``terminated`` by SIGTERM, ``waiting`` for other
        parts, or ``poisoned`` units.
    poison : dict of int to str
        Units whose tasks failed three times, with the last error of each.
    """

    reason: str
    poison: dict[int, str]


def missing(running: Memory) -> NDArray[np.int64]:
    """The units that are to be computed now, in order.

    First comes a coarse lattice of pixels, so that an interrupted map is a coarse whole one. Within
    a lattice those come first that are likely to take longest, so that no worker is left alone with
    them at the end. The next stage of a refined map follows from the rows of those before.
    """
    spec, status = running.head.spec, running.status
    if refined(spec):
        data = result_of(running, MapData)
        ends = [data.lower, data.upper]
        pixels = stages(spec, data.status, data.finished, data.samples, ends).wanted
    else:
        # Of most maps: nothing is sorted that is done.
        known = running.table.known.reshape(-1, running.head.segments).all(axis=1)
        pixels = np.flatnonzero((status == 0) & ~known)
        level = lattice_level(spec.shape, pixels)
        if running.table.known.any():
            pixels = pixels[np.lexsort((-_likely_cost(running, pixels, level), -level))]
        else:
            pixels = pixels[np.argsort(-level.astype(np.int8), kind="stable")]
    segments = running.head.segments
    units = (pixels[:, np.newaxis] * segments + np.arange(segments)).ravel()
    left: NDArray[np.int64] = units[~running.table.known[units]]
    return left


def _likely_cost(
    running: Memory, pixels: NDArray[np.int64], level: NDArray[np.int64]
) -> NDArray[np.float32]:
    """The processor time of the pixel of the next coarser lattice beside each, 0 if unknown."""
    shape, segments = running.head.spec.shape, running.head.segments
    stride = 2 * level
    beside = [index // stride * stride for index in np.unravel_index(pixels, shape)]
    cost = running.table.nanoseconds[np.ravel_multi_index(beside, shape) * segments]
    return np.nan_to_num(cost)


def carry_on(
    running: Memory,
    *,
    threads: int,
    stop: Callable[[], bool],
    executor: Any = None,
    threads_per_task: int = 1,
    part: Part | None = None,
    allow_mixed: bool = False,
    progress: ProgressOption = None,
) -> Outcome:
    """Compute the missing units, or a part of these, until the map is complete or ``stop()``.

    Raises
    ------
    StoreError
        If this machine computes other numbers than those that are stored.
    OSError
        If a row cannot be written; the rows before are kept.
    RuntimeError
        If the pool of workers broke.
    """
    spec, part = running.head.spec, part or Part()
    spec.require_functions()
    running.computed = 0
    checked = reread = False
    poison: dict[int, str] = {}
    pool = None if executor is None else executor_of(executor)
    each = threads if pool is None else threads_per_task
    reason = "error"
    try:
        while True:
            todo = missing(running)
            mine = todo[part.has(todo, running)]
            if poison:
                mine = mine[~np.isin(mine, list(poison))]
            if stop():
                break
            if not len(mine):
                if reread or not len(todo):
                    break
                running.read()  # other parts may have gone on
                reread = True
                continue
            running.begin(
                threads=each,
                executor="threads" if pool is None else type(executor).__name__,
                part=str(part),
            )
            total = int(running.head.samples_of(mine).sum())
            who = "" if part.count == 1 else f"part {part}: "
            with reporting(progress, total, who=who) as report:
                intake = Intake(running, report, each)
                if not checked:
                    _compute_again(running, threads, stop)
                    checked = True
                if pool is None:
                    run_here(running.head, mine, intake, threads, stop)
                else:
                    build = None if allow_mixed else own_build()
                    task = Task.of(running.head, threads_per_task, build, executor)
                    poison |= drive(task, mine, intake, *pool, stop)
        if stop() and len(todo):
            reason = "terminated" if terminated() else "interrupted"
        elif poison:
            reason = "poisoned"
        else:
            reason = "waiting" if len(todo) else "complete"
    except KeyboardInterrupt:
        reason = "interrupted"
        raise
    except BrokenExecutor as error:
        raise RuntimeError(
            f"the pool of workers broke ({error}); the rows that it returned are kept"
        ) from None
    finally:
        running.end(reason)
    return Outcome(reason, poison)


def _compute_again(running: Memory, threads: int, stop: Callable[[], bool]) -> None:
    """Compute some known rows again, before rows are added: another version may give others.

    Raises
    ------
    StoreError
        Naming the first unit and the fields that come out otherwise here, and a function of the
        user that is the cause.
    """
    table, spec = running.table, running.head.spec
    known = np.flatnonzero(table.known)
    known = known[:: -(-len(known) // MOST_AGAIN) or 1]
    is_soon = 1e-9 * np.cumsum(np.nan_to_num(table.nanoseconds[known])) <= SECONDS_AGAIN
    is_soon[:1] = True
    stored = table.block(known[is_soon])
    if not len(stored.rows):
        return
    units = stored.rows["unit"].copy()
    again = compute(running.head, units, threads, stop)
    found = "" if again is None else unequal(stored, again, spec.measure)
    if found:
        who = "this build of rigid, or this machine, does not compute the numbers that are stored"
        raise StoreError(f"{spec.doubt or who}: stored and computed: {found}")


def result_of(
    running: Memory, kind: type[Data], *, elapsed: float = np.nan, threads: int = 0
) -> Data:
    """The map of the rows that are stored, as an object of a class."""
    columns, bins = running.table.merged()
    return kind.from_arrays(
        running.head.spec,
        {**columns, "status": running.status},
        bins,
        elapsed=elapsed,
        threads=threads,
        computed=running.computed,
        writers=tuple(running.writers()),
    )


def pixels_done(running: Memory, how: str = "stored") -> str:
    """How many pixels have all their bodies, in words, and pieces of divided ones."""
    result = result_of(running, MapData)
    possible, segments = result.status == 0, running.head.segments
    done, pixels = int((result.finished & possible).sum()), int(possible.sum())
    text = f"{done:,} of {pixels:,} pixels"
    if segments > 1:
        text += f" ({int(running.table.known.sum()):,} of {pixels * segments:,} pieces)"
    return f"{text} are {how}"
