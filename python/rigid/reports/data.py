"""The numbers of a report: rows, Pareto fronts, costs, and their JSON text."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from .._checks.arguments import brief, finite_float
from ..solve.methods import EXACT
from .reference import Reference
from .row import Row, pareto
from .spec import ReportSpec
from .stored import Stored, names_from

__all__ = ["REPEATS", "ReportData"]

REPEATS = 3
"""Fewest repeats that show by how much times differ."""

APART = 2.0
"""Two costs differ if they are further apart than so many interquartile distances of both.

Of two equal methods one then seems cheaper in 15 of 1000 reports of three repeats, in 5 of four or
five, and in none of nine."""

DEARER = 2.0
"""A cost above so many times the lowest is distinct from it, whatever the scatter: a busy machine
scatters times by a factor of ten."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportData(Stored):
    """The numbers of a report; :class:`rigid.Report` describes the attributes."""

    FORMAT = "rigid report"

    spec: ReportSpec
    rows: tuple[Row, ...]
    same: Mapping[str, tuple[str, ...]]
    reference: Reference
    refused: Mapping[str, str]
    ended: Mapping[str, str]
    machine: Mapping[str, str]
    complete: bool
    rounds: int
    elapsed: float

    @property
    def methods(self) -> tuple[str, ...]:
        """The measured methods, each under one of its names."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    def of(self, method: str) -> tuple[Row, ...]:
        """The rows of a method, by any of its names, from long steps to short ones."""
        known = next((name for name, others in self.same.items() if method in others), method)
        return tuple(row for row in self.rows if row.method == known)

    @property
    def front(self) -> tuple[Row, ...]:
        """The Pareto front from fast to exact: no other row is both faster and more accurate.

        Rows with an error of 1 or more do not compete.
        """
        return pareto(self.rows, _error)

    @property
    def scheme_front(self) -> tuple[Row, ...]:
        """The Pareto front without the closed form, which is often the fastest."""
        return pareto([row for row in self.rows if row.method != EXACT], _error)

    def cost(self, method: str, error: float) -> float | None:
        """Processor time per body and unit of time (ns) for a given error, None if not reached.

        Interpolated between the steps of the sweep, linearly in the logarithms.
        """
        known = self._cost(method, error)
        return None if known is None else known[0]

    def _cost(self, method: str, error: float) -> tuple[float, float] | None:
        """The cost for a given error, and the distance of the quartiles of its repeats (ns)."""
        before = None
        for row in self.of(method):
            if row.error <= error:
                if before is None or not math.isfinite(before.error):
                    return row.nanoseconds, _relative_spread(row) * row.nanoseconds
                share = math.log(before.error / error) / math.log(before.error / row.error)
                logs = math.log(before.nanoseconds), math.log(row.nanoseconds)
                cost = math.exp(logs[0] + share * (logs[1] - logs[0]))
                return cost, max(_relative_spread(before), _relative_spread(row)) * cost
            before = row
        return None

    def cheapest(self, error: float, *, schemes: bool = False) -> tuple[str, ...]:
        """The methods that reach a given error in the shortest time, within the scatter of times.

        Two costs are distinct if they differ by more than twice the distances of the quartiles of
        their repeats, of which there must be three at least, or if one is above twice the other.
        All methods are returned whose cost is not distinct from the lowest, the lowest first. None
        are returned if the error is not reached, or if the repeats are too few.

        Parameters
        ----------
        error : float
        schemes : bool
            The closed form does not compete.
        """
        costs = {method: self._cost(method, error) for method in self.methods}
        reached = {
            method: cost
            for method, cost in costs.items()
            if cost is not None and not (schemes and method == EXACT)
        }
        if not reached or (self.rounds < REPEATS and len(reached) > 1):
            return ()
        ordered = sorted(reached, key=lambda method: reached[method])
        low, spread = reached[ordered[0]]

        def is_apart(cost: float, of_cost: float) -> bool:
            return cost > DEARER * low or cost - low > APART * (spread + of_cost)

        return tuple(name for name in ordered if not is_apart(*reached[name]))

    def order(self, method: str) -> float | None:
        """The measured order, from the shortest steps whose error is well above rounding."""
        orders = [row.order for row in self.of(method) if row.order is not None]
        return orders[-1] if orders else None

    def _facts(self) -> dict[str, Any]:
        return {
            "spec": self.spec.to_dict(),
            "machine": dict(self.machine),
            "reference": dataclasses.asdict(self.reference),
            "rows": [_bounded(dataclasses.asdict(row)) for row in self.rows],
            "same": {name: list(others) for name, others in self.same.items()},
            "refused": dict(self.refused),
            "ended": dict(self.ended),
            "complete": self.complete,
            "rounds": self.rounds,
            "elapsed": self.elapsed,
        }

    @classmethod
    def _from_facts(cls, data: dict[str, Any]) -> Self:
        data.setdefault("same", {})  # a report of an older version
        values = {field.name: data[field.name] for field in dataclasses.fields(cls)}
        values["spec"] = ReportSpec.from_dict(values["spec"])
        values["reference"] = Reference(**values["reference"])
        values["rows"] = tuple(_row(row) for row in values["rows"])
        values["same"] = names_from(values["same"])
        for name in ("rounds", "elapsed"):
            finite_float(name, values[name], nonnegative=True)
        return cls(**values)


def _error(row: Row) -> float:
    return row.error


def _relative_spread(row: Row) -> float:
    """The distance of the quartiles of repeats, as a share; infinite if there are none."""
    return math.inf if row.spread is None else row.spread / row.nanoseconds


_UNBOUNDED = (
    "error",
    "worst",
    "rates_error",
    "attitude_error",
    "energy_drift",
    "momentum_drift",
)


def _bounded(row: dict[str, Any]) -> dict[str, Any]:
    lost = {name: None for name in _UNBOUNDED if not math.isfinite(row[name])}
    return row | lost


_OPTIONAL = ("step", "angle", "spread", "order")


def _row(data: Mapping[str, Any]) -> Row:
    values = dict(data)
    for name, value in values.items():
        if name in ("method", "mark"):
            if not isinstance(value, str):
                raise TypeError(f"{name} = {brief(value)}: must be a string")
        elif value is not None:
            finite_float(name, value, nonnegative=name != "order", positive=name == "nanoseconds")
        elif name in _UNBOUNDED:
            values[name] = math.inf
        elif name not in _OPTIONAL:
            raise TypeError(f"{name} = None: must be a number")
    return Row(**values)
