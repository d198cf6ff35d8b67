"""What a call would compute, and how long it would take: by computing some of it."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..maps.job import to_core
from ..maps.refine import refined
from ..maps.sequential import LOOK
from ..maps.spec import MapSpec
from .head import Head
from .log import COST
from .resume import Part, missing
from .rows import BIN_ROW, ROW, Table
from .running import Folder, Memory

__all__ = ["Foreseen", "foresee"]

LIMIT = 0.4
"""Longest time of the computation (s): half a second with what comes before."""

LANES = 8
"""Bodies that a thread moves side by side: a block of fewer takes as long."""


GROWTH = 16.0
"""A block has at most so many times the pixels of the one before."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Foreseen:
    """What a call would compute.

    Attributes
    ----------
    pixels, bodies : int
        Of this call: without what is stored, and without other parts.
    at_most : bool
        Whether these are the largest possible numbers.
    seconds : float
        Wall time on free threads.
    at_least : bool
        Whether so few bodies end within the check that ``seconds`` is a lower bound.
    stored : int
        Bytes of the rows that a folder gets.
    """

    pixels: int
    bodies: int
    at_most: bool
    seconds: float
    at_least: bool
    stored: int


def foresee(
    spec: MapSpec, *, threads: int, store: str | os.PathLike[str] | None, part: Part
) -> Foreseen:
    """Foresee a call, by the computation of some bodies of random pixels, with their cross-check.

    Raises
    ------
    StoreError
        As the call.
    """
    begin = time.process_time()  # other programs may be busy
    running: Folder | Memory = Memory(spec)
    if store is not None and Folder.is_at(store):
        running = Folder.at(store, spec)
    elif store is not None:
        Folder.require_empty(store)
        running.head = Head.of(spec)
        running.table = Table(running.head)
    spec, head = running.head.spec, running.head
    spec.require_functions()
    todo = missing(running)
    mine = todo[part.has(todo, running)]
    pixels = np.unique(mine // head.segments)
    bodies = int(head.samples_of(mine).sum())
    if refined(spec):  # later stages follow from the rows of earlier ones
        possible = np.flatnonzero(running.status == 0)
        pixels, bodies = possible, len(possible) * spec.samples // part.count
    bodies = min(bodies, spec.budget or bodies)
    prepared = time.process_time() - begin
    seconds, at_least = (0.0, False) if not bodies else _seconds(spec, pixels, threads, bodies)
    bins = len(spec.measure) * BIN_ROW.itemsize  # one of each measure; most pixels have few
    return Foreseen(
        pixels=len(pixels),
        bodies=bodies,
        at_most=spec.looks is not None or refined(spec),
        seconds=prepared + seconds,
        at_least=at_least,
        stored=len(mine) * (ROW.itemsize + COST.itemsize + bins),
    )


def _seconds(
    spec: MapSpec, pixels: NDArray[np.int64], threads: int, bodies: int
) -> tuple[float, bool]:
    """Time of so many bodies of these pixels, and whether it is a lower bound.

    The first bodies of a pixel stand for all of them: the default cross-check is one of each look.
    If they are too slow, fewer bodies are computed, of which a larger share is checked. The largest
    block counts alone: a small one waits for its slowest bodies, whose lanes nobody fills again.
    """
    order = np.random.default_rng(0).permutation(pixels)
    begin = time.perf_counter()
    for limit, most in ((0.5 * LIMIT, LOOK), (LIMIT, LANES)):
        samples = min(most, spec.samples)
        largest, taken, at, together = 0, 0.0, 0, -(-LANES * threads // samples)

        def late(limit: float = limit) -> bool:
            return time.perf_counter() - begin > limit

        while at < len(order) and not late():
            some = order[at : at + together]
            before, started = time.perf_counter(), time.process_time()
            job = to_core(spec, some, samples)
            made = time.process_time() - started
            columns = job.run(0, len(some) * samples, threads, late)
            if columns is None:
                break
            at += len(some)
            if len(some) >= largest:
                largest = len(some)
                taken = made + 1e-9 * float(columns["nanoseconds"].sum()) / threads
            # A block that does not end in time is lost.
            left = LIMIT + begin - time.perf_counter()
            fitting = 0.6 * left * len(some) / (time.perf_counter() - before)
            together = max(1, int(min(GROWTH * together, fitting)))
        if largest:
            return taken * bodies / (largest * samples), False
    return LIMIT * bodies / (LANES * threads), True
