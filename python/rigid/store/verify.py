"""Stored numbers, computed again."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .._checks.arguments import finite_float
from ..maps.identity import segment_of
from ..maps.result import load_map
from .compute import compute
from .rows import FIELDS, Rows, rows_of
from .running import Folder

__all__ = ["Verification", "verify"]

TOGETHER = 1024
"""Units that are computed at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What a verification has found; ``str()`` tells it.

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
        """Whether all numbers came out as they are stored, and all could be read."""
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
    path: str | os.PathLike[str], *, share: float = 0.01, seed: int = 0, threads: int = 1
) -> Verification:
    """Compute a random share of the units of a running map, or of a saved map, again."""
    share = finite_float("share", share, positive=True)
    if share > 1.0:
        raise ValueError(f"share = {share}: must be at most 1")
    rows, text, segments, damage = _rows(path)
    count = min(len(rows), int(np.ceil(share * len(rows) * (1.0 - 1e-12))))
    chosen = np.sort(np.random.default_rng(seed).choice(len(rows), count, replace=False))
    wrong: list[str] = []
    for begin in range(0, count, TOGETHER):
        stored = rows[chosen[begin : begin + TOGETHER]]
        again = compute(text, stored["unit"].copy(), threads)
        assert again is not None
        wrong += [
            f"pixel {int(old['unit']) // segments}: {_fields(old, new)}"
            for old, new in zip(stored, again[0], strict=True)
            if old.tobytes() != new.tobytes()
        ]
    return Verification(units=len(rows), checked=count, wrong=wrong, damage=damage)


def _rows(path: str | os.PathLike[str]) -> tuple[Rows, str, int, list[str]]:
    """The rows of complete units, the specification, the units of a pixel, and what is damaged."""
    if Path(path).is_dir():
        folder = Folder(path)
        damage = [f"{log.name}: {text}" for log in folder.logs for text in log.found.damage]
        rows: Rows = folder.table.rows[folder.table.known]
        return rows, folder.head.spec.to_json(), folder.head.segments, damage
    result = load_map(path)
    if result.spec.samples > segment_of(result.spec):
        raise ValueError(f"{path}: samples of several segments are merged there; verify its store")
    pixels = np.flatnonzero((result.finished & (result.status == 0)).ravel())
    columns = {name: result.columns[name].ravel()[pixels] for name in FIELDS}
    return rows_of(pixels, columns), result.spec.to_json(), 1, []


def _fields(old: Rows, new: Rows) -> str:
    return ", ".join(
        f"{name} is {old[name]}, computed {new[name]}"
        for name in FIELDS
        if old[name].tobytes() != new[name].tobytes()
    )
