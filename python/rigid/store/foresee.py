"""What a call would compute, and how long it would take: by computing some of it."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..maps.job import to_core
from ..maps.plan import map_plan
from ..maps.refine import refined
from ..maps.request import shortened
from ..maps.sequential import LOOK
from ..maps.spec import MapSpec
from ..solve.plan import Plan
from ..solve.timing import FEW, LEAST_SHARE, seconds_of_one
from .head import divided
from .log import COST
from .resume import Part, missing
from .rows import BIN_ROW, ROW
from .running import Folder, Memory

QUICK = 40_000
"""Most steps of the bodies of a look that are run to the horizon at once: eight such looks take
some hundredths of a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Foreseen:
    """What a call would compute.

    Attributes
    ----------
    plan : Plan
    pixels, bodies : int
        Of this call: without what is stored, and without other parts.
    at_most : bool
        Whether these are the largest possible numbers.
    seconds : float
        Wall time on free threads.
    stored : int
        Bytes of the rows that a folder gets.
    """

    plan: Plan
    pixels: int
    bodies: int
    at_most: bool
    seconds: float
    stored: int


def foresee(
    spec: MapSpec,
    *,
    store: str | os.PathLike[str] | None,
    seeded: bool,
    threads: int,
    part: str | None,
) -> Foreseen:
    """Foresee a call, by the computation of some bodies of random pixels, with their cross-check.

    Raises
    ------
    StoreError
        As the call.
    """
    share = Part.of(part)
    if store is not None and not seeded:
        spec = Folder.seeded(spec, store)
    begin = time.process_time()  # other programs may be busy
    if store is None:
        running = Memory(spec)
    elif Folder.is_at(store):
        running = Folder.at(store, spec)
    else:
        Folder.require_empty(store)
        running = Memory(spec, divided(spec))
    spec, head = running.head.spec, running.head
    spec.require_functions()
    todo = missing(running)
    mine = todo[share.has(todo, running)]
    pixels = np.unique(mine // head.segments)
    bodies = int(head.samples_of(mine).sum())
    if refined(spec):  # later stages follow from the rows of earlier ones
        possible = np.flatnonzero(running.status == 0)
        pixels, bodies = possible, len(possible) * spec.samples // share.count
    bodies = min(bodies, spec.budget or bodies)
    made = map_plan(spec)
    prepared = time.process_time() - begin
    seconds = 0.0
    if bodies:
        seconds = bodies / threads * _seconds_of_one(spec, made.steps, pixels, threads)
    bins = len(spec.measure) * BIN_ROW.itemsize  # one of each measure; most pixels have few
    return Foreseen(
        plan=made,
        pixels=len(pixels),
        bodies=bodies,
        at_most=spec.looks is not None or refined(spec),
        seconds=prepared + seconds,
        stored=len(mine) * (ROW.itemsize + COST.itemsize + bins),
    )


def _seconds_of_one(
    spec: MapSpec, steps: int | None, pixels: NDArray[np.int64], threads: int
) -> float:
    """Processor time of a body of these pixels (s), which takes so many steps, on so many threads.

    Looks of random pixels are computed. The looks are random too: by default some bodies of each
    look are cross-checked, but of a share to check it is the first bodies of a pixel.
    """
    samples = min(LOOK, spec.samples)
    looks = spec.samples // samples if spec.looks is None else 1
    until = cache(lambda share: shortened(spec, share))

    def run(count: int, share: float) -> None:
        rng = np.random.default_rng(0)
        some = np.resize(rng.permutation(pixels), count)
        job = to_core(until(share), some, samples, LOOK * rng.integers(looks, size=count))
        job.run(0, count * samples, threads)

    share = 1.0 if steps is not None and steps * samples <= QUICK else LEAST_SHARE
    most, few = looks * len(pixels), max(1, FEW // samples)
    seconds, _ = seconds_of_one(run, most, few, share)
    return seconds / samples
