"""Stored numbers, computed again."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .._checks.arguments import finite_float
from .._checks.progress import Progress, ProgressOption, reporting
from ..maps.job import of_pixels
from ..maps.spec import MapSpec
from .compute import compute
from .result import load_map
from .rows import FIELDS, Block, bins_of, differences, rows_of
from .running import Folder

TOGETHER = 1024
"""Number of units that are computed at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """The result of a verification; ``str()`` describes it.

    Attributes
    ----------
    units, checked : int
        Units that are stored, and those that were computed again.
    wrong : list of str
        The units that came out otherwise: pixel, fields, stored and computed numbers.
    damage : list of str
        What could not be read in the logs, and where.
    """

    units: int
    checked: int
    wrong: list[str] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether all numbers agree with the stored ones, and all rows could be read."""
        return not (self.wrong or self.damage)

    def __str__(self) -> str:
        lines = [
            f"{self.checked:,} of {self.units:,} units were computed again: "
            f"{len(self.wrong):,} differ",
            *self.wrong[:20],
            *([f"and {len(self.wrong) - 20:,} more"] if self.wrong[20:] else []),
            *(f"damage: {text}" for text in self.damage),
        ]
        return "\n".join(lines)


def verify(
    stored: str | os.PathLike[str] | Folder,
    *,
    share: float = 0.01,
    seed: int = 0,
    threads: int = 1,
    progress: ProgressOption = None,
) -> Verification:
    """Compute a random share of the units of a running map, or of a saved map, again."""
    share = finite_float("share", share, positive=True)
    if share > 1.0:
        raise ValueError(f"share = {share}: must be at most 1")
    block, spec, segment, damage = _rows(stored)
    segments = 1 if segment is None else -(-spec.samples // segment)
    units = len(block.rows)
    count = min(units, int(np.ceil(share * units * (1.0 - 1e-12))))
    chosen = np.zeros(units, np.bool_)
    chosen[np.random.default_rng(seed).choice(units, count, replace=False)] = True
    places = np.flatnonzero(chosen)
    wrong: list[str] = []
    begun = time.perf_counter()
    with reporting(progress, count, unit=" units") as report:
        for begin in range(0, count, TOGETHER):
            mine = np.zeros(units, np.bool_)
            mine[places[begin : begin + TOGETHER]] = True
            old = block.some(mine)
            again = compute(spec, old.rows["unit"].copy(), threads, segment=segment)
            assert again is not None
            wrong += [
                f"pixel {int(unit) // segments}: {text}"
                for unit, text in zip(
                    old.rows["unit"],
                    differences(old, again, spec.measure, "{} is {}, computed {}"),
                    strict=True,
                )
                if text
            ]
            done, elapsed = min(begin + TOGETHER, count), time.perf_counter() - begun
            report(Progress(done=done, total=count, elapsed=elapsed, failures=len(wrong)))
    return Verification(units=units, checked=count, wrong=wrong, damage=damage)


def _rows(
    stored: str | os.PathLike[str] | Folder,
) -> tuple[Block, MapSpec, int | None, list[str]]:
    """The rows of complete units, the specification, samples of a unit, and the damaged rows."""
    if isinstance(stored, Folder) or Path(stored).is_dir():
        folder = stored if isinstance(stored, Folder) else Folder(stored)
        folder.read()
        block = folder.table.block(np.flatnonzero(folder.table.known))
        return block, folder.head.spec, folder.head.segment, folder.damage
    result = load_map(stored)
    pixels = np.flatnonzero((result.finished & (result.status == 0)).ravel())
    columns = {name: result.columns[name].ravel()[pixels] for name in FIELDS}
    place = np.full(result.status.size, -1)
    place[pixels] = np.arange(len(pixels))
    finished = [
        measured.bins[place[measured.bins[:, 0]] >= 0] for measured in result.measures.values()
    ]
    bins = bins_of(pixels, [of_pixels(one, place) for one in finished])
    costs = np.full(len(pixels), np.nan, np.float32)
    return Block(rows_of(pixels, columns), costs, bins), result.spec, None, []
