"""Blocks of units on the threads of this process, or on the workers of an executor."""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _core
from .._checks.arguments import brief, one_line
from ..maps.data import CLASSES
from ..maps.spec import MapSpec
from ..model.scene import Scene
from .head import Head, StoreError
from .rows import Block, Ints, compute
from .running import Memory

SHORTEST, LONGEST = 0.3, 60.0
"""Bounds of the time of a block, s."""

APPENDS = 50.0
"""A block lasts at least so many times as long as the last append."""

TRIES = 3
"""A unit is given up after so many failed tasks, the last one with this unit alone."""

HOPELESS = 12
"""More failures than this without any success are raised."""

GROWTH = 8
"""A block has at most so many times the units of the one before."""


@dataclass(frozen=True, slots=True)
class Task:
    """The data that a worker needs besides the units.

    Attributes
    ----------
    text : str
        The specification as JSON.
    threads : int
        Threads of the core in each worker.
    build : tuple of str and (str or None)
        Version and commit of the driver, which a worker must have; None accepts any.
    functions : dict of str to callable, or bytes
        The functions of the specification; as pickled, unless the executor pickles them itself.
    segment : int
        Most samples of a unit.
    whole : MapSpec or None
        The specification itself, for threads of this process.
    """

    text: str
    threads: int
    build: tuple[str, str | None] | None
    functions: Mapping[str, Callable[..., Any] | Scene] | bytes
    segment: int
    whole: MapSpec | None = None

    @classmethod
    def of(
        cls, head: Head, threads: int, build: tuple[str, str | None] | None, executor: Any
    ) -> Task:
        """The task of a running map for an executor.

        Raises
        ------
        ValueError
            If workers of the executor cannot import a function.
        """
        spec = head.spec
        if isinstance(executor, ThreadPoolExecutor):
            return cls(spec.to_json(), threads, build, {}, head.segment, spec)
        functions: Mapping[str, Callable[..., Any] | Scene] | bytes = spec.functions
        if isinstance(spec.functions.get("scene"), Scene):
            raise ValueError(
                "scene: its torque is a function, which other processes cannot call; let a "
                "function of an axis make the scene, or compute by threads of this process"
            )
        if functions and not hasattr(executor, "get_executor"):  # Dask passes any function on
            for name, function in spec.functions.items():
                try:
                    pickle.dumps(function)
                except Exception as error:  # whatever refuses
                    title = getattr(function, "__qualname__", "") or brief(function)
                    raise ValueError(
                        f"{name} = {title}: workers import the function by its "
                        f"name; define the function in a module ({one_line(error)})"
                    ) from None
            functions = pickle.dumps(dict(spec.functions))
        return cls(spec.to_json(), threads, build, functions, head.segment)

    @property
    def spec(self) -> MapSpec:
        """The specification with its functions, in a worker."""
        if self.whole is not None:
            return self.whole
        asked = self.text, self.functions
        for known, spec in _latest[:]:
            if known == asked:
                return spec
        spec = self._read()
        _latest[:] = [(asked, spec)]  # with its grid, which is made once; threads see one or other
        return spec

    def _read(self) -> MapSpec:
        functions, carried = self.functions, not isinstance(self.functions, bytes)
        if isinstance(functions, bytes):
            try:
                functions = pickle.loads(functions)
            except Exception as error:  # it runs the import of a module
                raise StoreError(
                    f"a worker cannot import a function of the map: {one_line(error)}"
                ) from None
        try:
            return MapSpec.from_json(self.text).with_functions(**functions, carried=carried)
        except ValueError as error:
            raise StoreError(f"a worker: {error}") from None


_latest: list[tuple[object, MapSpec]] = []
"""The latest text and functions in this process, with their specification."""


def own_build() -> tuple[str, str | None]:
    """Version and commit of this process."""
    build = _core.build_info()
    return build["version"], build.get("commit")


def work(task: Task, units: Ints) -> Block:
    """A block, in a worker."""
    if task.build is not None and task.build != own_build():
        raise StoreError(
            f"a worker has rigid {own_build()}, the driver {task.build}: install one version, or "
            "pass allow_mixed=True"
        )
    block = compute(Head(task.spec, task.segment), units, task.threads)
    assert block is not None
    return block


class Intake:
    """Keeps blocks, reports progress, and chooses the number of units of the next block.

    Costs differ between units by orders of magnitude, because a flip ends a body early. So a block
    also stays short in case it consists of the costliest units only.

    Parameters
    ----------
    running : Memory
        Gets the rows.
    report : callable
        Called with the numbers of bodies and of failed ones after each block.
    threads : int
        Threads that compute a block.
    """

    def __init__(self, running: Memory, report: Callable[[int, int], object], threads: int) -> None:
        self._running, self._report, self._threads = running, report, threads
        self.units = max(1, 16 * threads // min(running.head.segment, running.head.spec.samples))
        self._costliest, self._done, self._failures = 0.0, 0, 0

    def take(self, block: Block, seconds: float | None = None) -> None:
        """Keep a block, which took so many seconds; by default its processor time."""
        begin = time.perf_counter()
        self._running.append(block)
        append = time.perf_counter() - begin
        costs = 1e-9 * block.nanoseconds.astype(np.float64) / self._threads
        self._costliest = max(self._costliest, float(costs.max()))
        wanted = min(max(SHORTEST, APPENDS * append), LONGEST)
        taken = float(costs.sum()) if seconds is None else seconds
        fitting = wanted * len(costs) / max(taken, 1e-6)
        bounded = 4.0 * wanted / max(self._costliest, 1e-9)
        self.units = max(1, int(min(fitting, bounded, GROWTH * self.units)))
        bodies = sum(int(block.rows[name].sum()) for name in CLASSES)
        self._running.computed += bodies
        self._done += bodies
        self._failures += int(block.rows["failed"].sum())
        self._report(self._done, self._failures)


def run_here(
    head: Head, todo: Ints, intake: Intake, threads: int, stop: Callable[[], bool]
) -> None:
    """Compute units one block after the other, on threads of this process."""
    at = 0
    while at < len(todo) and not stop():
        units = todo[at : at + intake.units]
        begin = time.perf_counter()
        block = compute(head, units, threads, stop)
        if block is None:
            return
        intake.take(block, time.perf_counter() - begin)
        at += len(units)


def executor_of(executor: Any) -> tuple[Any, int]:
    """An object with the method ``submit``, and its number of workers.

    A Dask client is asked for its own executor.

    Raises
    ------
    TypeError
    """
    if hasattr(executor, "get_executor"):
        return executor.get_executor(pure=False), max(1, len(executor.nthreads()))
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor = {executor!r}: must have the method submit, as executors of "
            "concurrent.futures"
        )
    return executor, int(getattr(executor, "_max_workers", 8))


def drive(
    task: Task,
    todo: Ints,
    intake: Intake,
    executor: Executor,
    workers: int,
    stop: Callable[[], bool],
) -> dict[int, str]:
    """Compute units on the workers of an executor; only this process writes.

    Returns the units that were given up, with the reasons.

    A block whose worker dies is halved and tried again. A pool that breaks ends the run; what was
    returned is kept.
    """
    at = 0
    waiting: dict[Future[Block], tuple[Ints, int]] = {}
    again: list[tuple[Ints, int]] = []
    poison: dict[int, str] = {}
    failures, succeeded = 0, False

    try:
        while (again or waiting or at < len(todo)) and not stop():
            while len(waiting) < 2 * workers and (again or at < len(todo)):
                if again:
                    units, tried = again.pop()
                else:
                    units, tried = todo[at : at + intake.units], 0
                    at += len(units)
                waiting[executor.submit(work, task, units)] = units, tried
            for future in wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED).done:
                units, tried = waiting.pop(future)
                try:
                    block = future.result()
                except (BrokenExecutor, StoreError):
                    raise
                except Exception as error:
                    failures += 1
                    if failures > HOPELESS and not succeeded:
                        raise  # it is not the units
                    if tried + 1 >= TRIES and len(units) == 1:
                        poison[int(units[0])] = f"{type(error).__name__}: {error}"
                    else:
                        middle = (len(units) + 1) // 2
                        halves = units[:middle], units[middle:]
                        again += [(half, tried + 1) for half in halves if len(half)]
                    continue
                succeeded = True
                intake.take(block)
    finally:
        for future in waiting:
            future.cancel()
    return poison
