"""What a running map has and lacks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..maps.data import CLASSES
from .compute import moment_status
from .resume import missing
from .running import Folder

__all__ = ["Status", "status_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Status:
    """What a running map has and lacks; ``str()`` is a table for people.

    Attributes
    ----------
    key : str
        The key of the map, hexadecimal.
    units, done, missing : int
        Units of work with a possible body; those whose rows are stored; those to be computed next.
    bodies, failed : int
        Bodies done, and the failed among them.
    twice : int
        Rows that two processes have computed, with equal bytes.
    damage : list of str
        What could not be read in the logs, and where; its units count as missing.
    writers : list of dict
        The receipt of each log: build, machine, process; with ``log``, ``units``, ``blocks`` and
        ``reason``, why it ended. Without a reason the process runs or was killed.
    seconds, remaining : float
        Processor time of the stored rows, and about that of the missing; NaN if it is not known.
    """

    key: str
    units: int
    done: int
    missing: int
    bodies: int
    failed: int
    twice: int
    damage: list[str]
    writers: list[dict[str, Any]]
    seconds: float
    remaining: float

    @property
    def complete(self) -> bool:
        """Whether nothing is missing."""
        return self.missing == 0

    def __str__(self) -> str:
        lines = [
            ("map", self.key),
            ("units", f"{self.done:,} of {self.units:,} are stored, {self.missing:,} are missing"),
            ("bodies", f"{self.bodies:,} done, {self.failed:,} failed"),
            ("cost", f"{self.seconds:.3g} s of processor time, about {self.remaining:.3g} s left"),
        ]
        if self.twice:
            lines.append(("twice", f"{self.twice:,} rows were computed twice, with equal bytes"))
        for writer in self.writers:
            who = f"{writer['log']}: {writer['units']:,} units"
            build = f"rigid {writer.get('version')} {writer.get('commit') or ''}".strip()
            how = writer.get("reason") or "running or killed"
            lines.append(("writer", f"{who}, {build}, {writer.get('host')}; {how}"))
        lines += [("damage", text) for text in self.damage]
        return "\n".join(f"{name:<12}{text}" for name, text in lines)


def status_of(folder: Folder) -> Status:
    """What a running map has and lacks."""
    spec, table = folder.head.spec, folder.table
    status = moment_status(spec)
    left = len(missing(folder, status))
    rows = table.rows[table.known]
    costs = table.nanoseconds[table.known].astype(np.float64)
    seconds = 1e-9 * float(np.nansum(costs))
    mean = seconds / max(1, int((~np.isnan(costs)).sum())) if len(rows) else np.nan
    return Status(
        key=folder.head.key.hex(),
        units=int((status == 0).sum()) * folder.head.segments,
        done=len(rows),
        missing=left,
        bodies=sum(int(rows[name].sum()) for name in CLASSES),
        failed=int(rows["failed"].sum()),
        twice=table.twice,
        damage=[f"{log.name}: {text}" for log in folder.logs for text in log.found.damage],
        writers=folder.writers(),
        seconds=seconds,
        remaining=mean * left if left else 0.0,
    )
