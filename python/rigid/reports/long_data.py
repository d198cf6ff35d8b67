"""The numbers of a long run: rows, fronts, the errors in a given time, and their JSON text."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from .._checks.arguments import finite_float
from .reference import Reference
from .row import pareto
from .spec import ReportSpec
from .stored import Stored, names_from

__all__ = ["ERRORS", "LongRow", "LongRunData", "at_common_time", "in_short"]

ERRORS = ("energy", "momentum", "phase")
"""The errors of a row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LongRow:
    """One method with one step: its errors over more and more revolutions.

    Each error is a tuple with an entry for each number of revolutions that was reached. It is the
    largest of all bodies; infinite if it is unknown.

    Attributes
    ----------
    method : str
        Name of the method.
    angle : float
        Angle turned in a step at the rate of the start (rad).
    nanoseconds : float
        Processor time per body and revolution (ns), in the longest run.
    energy : tuple of float
        Largest error of the energy, minus the work, as in :attr:`rigid.Run.energy_drift`.
    momentum : tuple of float
        Largest error of the angular momentum in space, of a free body; of a top, of its component
        along the vertical, and of that along the axis of a symmetric top; under torque, damping and
        other forces the residual of the balance, as in :attr:`rigid.Run.momentum_drift`. Relative.
    phase : tuple of float
        Angle between the last attitude and the true one (rad), at least the uncertainty of the
        reference. Infinite from 1 rad on, and where no reference is known.
    """

    method: str
    angle: float
    nanoseconds: float
    energy: tuple[float, ...]
    momentum: tuple[float, ...]
    phase: tuple[float, ...]

    def error(self, name: str, horizon: int) -> float:
        """The error of a name over the revolutions of an index; infinite if not reached.

        Parameters
        ----------
        name : str
            ``"energy"``, ``"momentum"`` or ``"phase"``.
        horizon : int
            Index of the number of revolutions.

        Returns
        -------
        float
        """
        errors: tuple[float, ...] = getattr(self, name)
        return errors[horizon] if horizon < len(errors) else math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class LongRunData(Stored):
    """The numbers of a long run; :class:`rigid.LongRun` describes the attributes."""

    FORMAT = "rigid long run"

    spec: ReportSpec
    revolutions: tuple[float, ...]
    rows: tuple[LongRow, ...]
    same: Mapping[str, tuple[str, ...]]
    references: tuple[Reference, ...]
    refused: Mapping[str, str]
    machine: Mapping[str, str]
    complete: bool
    elapsed: float

    @property
    def methods(self) -> tuple[str, ...]:
        """The measured methods, each under one of its names."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    def of(self, method: str) -> tuple[LongRow, ...]:
        """The rows of a method, by any of its names, from long steps to short ones."""
        known = next((name for name, others in self.same.items() if method in others), method)
        return tuple(row for row in self.rows if row.method == known)

    @property
    def horizon(self) -> int:
        """Index of the most revolutions that three of four rows have reached."""
        lengths = sorted(len(row.energy) for row in self.rows)
        return lengths[len(lengths) // 4] - 1 if lengths else 0

    @property
    def errors(self) -> tuple[str, ...]:
        """The known errors; the error of the phase is unknown where the motion is chaotic."""
        return ERRORS if any(math.isfinite(row.phase[0]) for row in self.rows) else ERRORS[:2]

    def front(self, error: str, horizon: int | None = None) -> tuple[LongRow, ...]:
        """The Pareto front of ``"energy"``, ``"momentum"`` or ``"phase"``, from fast to exact.

        Over the revolutions of that index, by default the index :attr:`horizon`.
        """
        at = self.horizon if horizon is None else horizon
        return pareto(self.rows, lambda row: row.error(error, at))

    @property
    def common_time(self) -> float:
        """The least time per revolution (ns) for which every method has a row."""
        return common_time(self.rows)

    def at_common_time(self) -> tuple[LongRow, ...]:
        """For each method the row with the shortest step that takes at most the common time.

        Of the rows that were run over the most revolutions.
        """
        return at_common_time(self.rows)

    def _facts(self) -> dict[str, Any]:
        return {
            "spec": self.spec.to_dict(),
            "revolutions": list(self.revolutions),
            "machine": dict(self.machine),
            "references": [dataclasses.asdict(reference) for reference in self.references],
            "rows": [_bounded(dataclasses.asdict(row)) for row in self.rows],
            "same": {name: list(others) for name, others in self.same.items()},
            "refused": dict(self.refused),
            "complete": self.complete,
            "elapsed": self.elapsed,
        }

    @classmethod
    def _from_facts(cls, data: dict[str, Any]) -> Self:
        values = {field.name: data[field.name] for field in dataclasses.fields(cls)}
        values["spec"] = ReportSpec.from_dict(values["spec"])
        values["revolutions"] = tuple(values["revolutions"])
        values["references"] = tuple(Reference(**one) for one in values["references"])
        values["rows"] = tuple(_row(row) for row in values["rows"])
        values["same"] = names_from(values["same"])
        return cls(**values)


def common_time(rows: Sequence[LongRow]) -> float:
    """The least time per revolution (ns) for which every method has a row."""
    least: dict[str, float] = {}
    for row in rows:
        least[row.method] = min(row.nanoseconds, least.get(row.method, math.inf))
    return max(least.values(), default=0.0)


def at_common_time(rows: Sequence[LongRow]) -> tuple[LongRow, ...]:
    """See :meth:`LongRunData.at_common_time`."""
    most = common_time(rows)
    best: dict[str, LongRow] = {}
    for row in sorted(rows, key=lambda row: (len(row.energy), row.nanoseconds)):
        if row.nanoseconds <= most:
            best[row.method] = row
    return tuple(best[method] for method in dict.fromkeys(row.method for row in rows))


def in_short(count: float) -> str:
    """A number of revolutions as text, such as 1e6."""
    power = round(math.log10(count))
    return f"1e{power}" if count == 10.0**power and power > 2 else f"{count:g}"


def _bounded(row: dict[str, Any]) -> dict[str, Any]:
    return row | {
        name: [error if math.isfinite(error) else None for error in row[name]] for name in ERRORS
    }


def _row(data: Mapping[str, Any]) -> LongRow:
    values = dict(data)
    for name in ("angle", "nanoseconds"):
        finite_float(name, values[name], positive=True)
    for name in ERRORS:
        values[name] = tuple(
            math.inf if error is None else finite_float(name, error, nonnegative=True)
            for error in values[name]
        )
    return LongRow(**values)
