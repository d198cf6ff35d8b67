"""What a running map has and lacks, and what a call would compute, and how long it would take."""

from __future__ import annotations

import os
import time
from calendar import timegm
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.shown import labelled
from .._timing import FEW, LEAST_SHARE, seconds_of_one
from ..maps.data import CLASSES, MapData
from ..maps.job import to_core
from ..maps.plan import map_plan, shortened
from ..maps.refine import refined
from ..maps.sequential import LOOK
from ..maps.spec import MapSpec
from ..solve.plan import Plan
from .head import divided
from .log import COST, UTC, Found
from .resume import Part, missing, result_of
from .rows import BIN_ROW, ROW
from .running import Folder, Memory

QUICK = 40_000
"""Most steps of the bodies of a look that are run to the horizon at once: eight such looks take
some hundredths of a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Status:
    """The stored and the missing parts of a running map; ``str()`` is a table.

    Attributes
    ----------
    key : str
        The key of the map, hexadecimal.
    units, done, missing : int
        Units of work with a possible body; those whose rows are stored; those to be computed next.
    cut : int
        Pixels that the budget of the map omits.
    bodies, failed : int
        Bodies done, and the failed among them.
    twice : int
        Rows that two processes have computed, with equal bytes.
    damage : list of str
        What could not be read in the logs, and where; its units count as missing.
    writers : list of dict
        The receipt of each log: build, machine, process, part; with ``log``, ``units``, ``seconds``
        of processor time, ``blocks`` and ``reason``, why it ended. Without a reason the process
        runs or was killed; then ``silent`` (s) is the time since it last wrote, ``missing`` how
        many units its part lacks, and ``remaining`` (s) how long it takes at its pace, NaN if it
        has none yet.
    seconds, remaining : float
        Processor time of the stored rows, and an estimate for the missing rows; NaN if unknown.
    """

    key: str
    units: int
    done: int
    missing: int
    cut: int
    bodies: int
    failed: int
    twice: int
    damage: list[str]
    writers: list[dict[str, Any]]
    seconds: float
    remaining: float

    @property
    def complete(self) -> bool:
        """Whether no unit is missing, within the budget of the map."""
        return self.missing == 0

    def __str__(self) -> str:
        left = f"about {self.remaining:.3g} s left"
        if np.isnan(self.remaining):
            left = "how much is left is not known yet"
        lines = [
            ("map", self.key),
            ("units", f"{self.done:,} of {self.units:,} are stored, {self.missing:,} are missing"),
            ("bodies", f"{self.bodies:,} done, {self.failed:,} failed"),
            ("cost", f"{self.seconds:.3g} s of processor time, {left}"),
        ]
        if self.cut and self.complete:
            lines.append(("budget", f"spent: {self.cut:,} pixels are omitted"))
        if self.twice:
            lines.append(("twice", f"{self.twice:,} rows were computed twice, with equal bytes"))
        for writer in self.writers:
            part = writer.get("part", "1/1")
            who = f"{writer['log']}: {'' if part == '1/1' else f'part {part}, '}"
            what = f"{writer['units']:,} units in {writer['seconds']:.3g} s of processor time"
            build = f"rigid {writer.get('version')} {writer.get('commit') or ''}".strip()
            lines.append(("writer", f"{who}{what}, {build}, {writer.get('host')}; {_how(writer)}"))
        lines += [("damage", text) for text in self.damage]
        return labelled(lines)


_ENDS = {"waiting": "has done its part", "complete": "has done its part, the last one"}
"""Why a writer ended, where the word in the log is for programs."""


def _how(writer: dict[str, Any]) -> str:
    """The reason why a writer ended, or its progress."""
    if writer.get("reason"):
        return _ENDS.get(writer["reason"], str(writer["reason"]))
    left = f"its part lacks {writer['missing']:,} units"
    if writer["missing"] and writer["remaining"] < np.inf:
        left += f", about {writer['remaining']:.0f} s at its pace"
    return f"running or killed, wrote {writer['silent']:.0f} s ago, {left}"


def _pace(folder: Folder, log: Found, left: NDArray[np.int64]) -> dict[str, Any]:
    """How long a writer has been silent, and how many units its part lacks."""
    receipt = log.writer or {}
    try:
        lacks = int(Part.of(receipt.get("part")).has(left, folder).sum())
        begun = float(timegm(time.strptime(receipt["begin"], UTC)))
    except (KeyError, TypeError, ValueError):  # a damaged log may have no receipt
        lacks, begun = len(left), log.written
    pace = log.units / (log.written - begun) if log.written > begun else 0.0
    return {
        "silent": max(0.0, time.time() - log.written),
        "missing": lacks,
        "remaining": lacks / pace if pace > 0.0 else np.nan,
    }


def status_of(folder: Folder) -> Status:
    """The stored and the missing parts of a running map."""
    table, todo = folder.table, missing(folder)
    left = len(todo)
    rows = table.rows[table.known]
    costs = table.nanoseconds[table.known].astype(np.float64)
    seconds = 1e-9 * float(np.nansum(costs))
    counted = int((~np.isnan(costs)).sum())
    mean = seconds / counted if counted else np.nan
    return Status(
        key=folder.head.key.hex(),
        units=int((folder.status == 0).sum()) * folder.head.segments,
        done=len(rows),
        missing=left,
        cut=result_of(folder, MapData).cut,
        bodies=sum(int(rows[name].sum()) for name in CLASSES),
        failed=int(rows["failed"].sum()),
        twice=table.twice,
        damage=folder.damage,
        writers=[
            writer if log.end else {**writer, **_pace(folder, log, todo)}
            for writer, log in zip(folder.writers(), folder.logs, strict=True)
        ],
        seconds=seconds,
        remaining=mean * left if left else 0.0,
    )


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
        first = LOOK * rng.integers(looks, size=count)
        for part, mine, own in until(share).by_part(some):
            job = to_core(part.spec, own, samples, first[mine], part.fixed)
            job.run(0, len(own) * samples, threads)

    share = 1.0 if steps is not None and steps * samples <= QUICK else LEAST_SHARE
    most, few = looks * len(pixels), max(1, FEW // samples)
    seconds, _ = seconds_of_one(run, most, few, share)
    return seconds / samples
