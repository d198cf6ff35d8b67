"""The numbers of a report: rows, Pareto fronts, costs, growth of errors, and their JSON text."""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, TypeVar

from .._checks.arguments import brief, finite_float, one_line
from .._files import published
from ..solve.methods import EXACT
from .reference import Reference, Unbounded
from .spec import ReportSpec

FORMAT, FORMAT_VERSION = "rigid report", 1

REFERENCE = "reference"
AT_UNCERTAINTY = "at reference uncertainty"
USELESS = "error >= 1"
FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One method with one step over one horizon. Times are processor times of one body, in ns.

    Attributes
    ----------
    method : str
        Name of the method.
    revolutions : float
        Horizon, in revolutions at the rate of the start.
    steps : int
        Steps until the horizon; 0 by closed form.
    step, angle : float or None
        Step in units of time, and the angle turned in it (rad): a bound of it, or, in a report over
        revolutions, the angle at the rate of the start.
    nanoseconds, spread : float; float or None
        Time per unit of time of the motion: median, and distance of the quartiles; None of a
        single timing. In a partial report that may be a call with all that is around it.
    total : float
        Time until the horizon.
    error, worst : float
        Error of the state at the horizon: the largest component of the error of the rates, relative
        to ``|omega|``, or the angle to the true attitude (rad), whichever is larger. Median of the
        ensemble, and its worst body. Infinite for a body that did not arrive.
    rates_error, attitude_error : float
        Medians of the two.
    phase : float
        Angle between the last attitude and the true one (rad), of the worst body; at least the
        uncertainty of the reference, infinite if none is known.
    energy_drift, momentum_drift : float
        As in :class:`rigid.Run`, worst of the ensemble, infinite if not known: of the last state,
        or, in a report over revolutions, of states on the way. There the momentum of a body without
        torque, damping and other forces is that in space; of a top, its component along the
        vertical, and that along the axis of a symmetric top.
    order : float or None
        Measured order: slope from the row before, if both errors are well above rounding and below
        0.1.
    mark : str
        Empty; ``"reference"``; ``"at reference uncertainty"``: the errors are bounds, equal to the
        uncertainty of the reference; ``"error >= 1"``: the state is unknown, for example in chaos
        after a long time; ``"failed"``.
    """

    method: str
    revolutions: float
    steps: int
    step: float | None
    angle: float | None
    nanoseconds: float
    spread: float | None
    total: float
    error: Unbounded
    worst: Unbounded
    rates_error: Unbounded
    attitude_error: Unbounded
    phase: Unbounded
    energy_drift: Unbounded
    momentum_drift: Unbounded
    order: float | None
    mark: str


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
class ReportData:
    """The numbers of a report; :class:`rigid.Report` describes the attributes."""

    spec: ReportSpec
    machine: Mapping[str, str]
    references: tuple[Reference, ...]
    rows: tuple[Row, ...]
    same: Mapping[str, tuple[str, ...]]
    refused: Mapping[str, str]
    ended: Mapping[str, str]
    complete: bool
    rounds: int
    elapsed: float

    @property
    def methods(self) -> tuple[str, ...]:
        """The measured methods, each under one of its names."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    @property
    def horizon(self) -> float:
        """The most revolutions over which three of four steps of methods were run."""
        lengths = sorted(row.revolutions for row in _longest(self.rows))
        return lengths[len(lengths) // 4] if lengths else self.spec.horizons[0]

    @property
    def reference(self) -> Reference:
        """The reference over the :attr:`horizon`."""
        return dict(zip(self.spec.horizons, self.references, strict=True))[self.horizon]

    def of(self, method: str, revolutions: float | None = None) -> tuple[Row, ...]:
        """The rows of a method, by any of its names, from long steps to short ones.

        Over so many revolutions, by default over the :attr:`horizon`.
        """
        known = next((name for name, others in self.same.items() if method in others), method)
        return tuple(row for row in self._over(revolutions) if row.method == known)

    def _over(self, revolutions: float | None) -> list[Row]:
        over = self.horizon if revolutions is None else revolutions
        return [row for row in self.rows if row.revolutions == over]

    def growth(self, row: Row) -> tuple[Row, ...]:
        """The rows of the same method and step over all horizons, from short to long."""
        key = (row.method, row.angle)
        return tuple(other for other in self.rows if (other.method, other.angle) == key)

    def front(
        self, error: str = "error", *, schemes: bool = False, revolutions: float | None = None
    ) -> tuple[Row, ...]:
        """The Pareto front from fast to exact: no other row is both faster and more accurate.

        Rows with an error of 1 or more do not compete.

        Parameters
        ----------
        error : str
            ``"error"``, ``"phase"``, ``"energy_drift"`` or ``"momentum_drift"``.
        schemes : bool
            The closed form, which is often the fastest, does not compete.
        revolutions : float, optional
            The horizon, by default :attr:`horizon`.
        """
        best, front = 1.0, []
        rows = [row for row in self._over(revolutions) if not (schemes and row.method == EXACT)]
        for row in sorted(rows, key=lambda row: (row.nanoseconds, getattr(row, error))):
            if getattr(row, error) < best:
                best = getattr(row, error)
                front.append(row)
        return tuple(front)

    @property
    def common_time(self) -> float:
        """The least time per unit of time (ns) for which every method has a row."""
        return common_time(self.rows)

    def at_common_time(self) -> tuple[Row, ...]:
        """For each method the row with the shortest step that takes at most the common time.

        Of the rows that were run over the most revolutions.
        """
        return at_common_time(self.rows)

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

    def to_dict(self) -> dict[str, Any]:
        """The result as a JSON-able dictionary; infinite or unknown numbers become None."""
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            **{field.name: getattr(self, field.name) for field in dataclasses.fields(self)},
            "spec": self.spec.to_dict(),
            "references": [_bounded(reference) for reference in self.references],
            "rows": [_bounded(row) for row in self.rows],
            "same": {name: list(others) for name, others in self.same.items()},
        }

    def to_json(self) -> str:
        """The result as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False, indent=1, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """The result that :meth:`to_json` wrote.

        Raises
        ------
        ValueError
            If the text is no such result, or one of another format.
        """
        try:
            data = json.loads(text, parse_constant=_refuse)
            if data["format"] != FORMAT or data["format_version"] != FORMAT_VERSION:
                raise ValueError(f"format is not {FORMAT!r}, version {FORMAT_VERSION}")
            values = {field.name: data[field.name] for field in dataclasses.fields(cls)}
            values["spec"] = ReportSpec.from_dict(values["spec"])
            values["references"] = tuple(_read(Reference, one) for one in values["references"])
            if len(values["references"]) != len(values["spec"].horizons):
                raise ValueError("references: must be as many as horizons")
            values["rows"] = tuple(_read(Row, row) for row in values["rows"])
            values["same"] = _names(values["same"])
            for name in ("rounds", "elapsed"):
                finite_float(name, values[name], nonnegative=True)
            return cls(**values)
        except Exception as error:  # the text may hold anything
            raise ValueError(
                f"text: is not a report: {type(error).__name__}: {one_line(error)}"
            ) from None

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the JSON text to a file and return its path.

        The file appears whole or not at all; see :meth:`rigid.StabilityMap.save`.

        Raises
        ------
        ValueError
            If the name does not end in ``.json``.
        OSError
            If the file cannot be written, or the path names something other than a file.
        """
        text = self.to_json() + "\n"
        with published(path, [".json"]) as file:
            file.write(text.encode())
        return Path(path)


def _longest(rows: Iterable[Row]) -> Iterable[Row]:
    """Of each method and step the row over the most revolutions."""
    return {(row.method, row.angle): row for row in rows}.values()


def common_time(rows: Sequence[Row]) -> float:
    """The least time per unit of time (ns) for which every method has a row."""
    least: dict[str, float] = {}
    for row in _longest(rows):
        least[row.method] = min(row.nanoseconds, least.get(row.method, math.inf))
    return max(least.values(), default=0.0)


def at_common_time(rows: Sequence[Row]) -> tuple[Row, ...]:
    """See :meth:`ReportData.at_common_time`."""
    most = common_time(rows)
    best: dict[str, Row] = {}
    for row in sorted(_longest(rows), key=lambda row: (row.revolutions, row.nanoseconds)):
        if row.nanoseconds <= most:
            best[row.method] = row
    return tuple(best[method] for method in dict.fromkeys(row.method for row in rows))


def _relative_spread(row: Row) -> float:
    """The distance of the quartiles of repeats, as a share; infinite if there are none."""
    return math.inf if row.spread is None else row.spread / row.nanoseconds


def _names(data: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """The other names of each method."""
    for names in data.values():
        for name in names:
            if not isinstance(name, str):
                raise TypeError(f"same: {brief(name)}: must be a name")
    return {method: tuple(names) for method, names in data.items()}


def _bounded(one: Row | Reference) -> dict[str, Any]:
    """The fields of a row or a reference; what is infinite becomes None."""
    values = dataclasses.asdict(one)
    lost = [k for k, v in values.items() if isinstance(v, float) and not math.isfinite(v)]
    return values | dict.fromkeys(lost)


Fields = TypeVar("Fields", Row, Reference)


def _read(kind: type[Fields], data: Mapping[str, Any]) -> Fields:
    values = dict(data)
    types = {field.name: str(field.type) for field in dataclasses.fields(kind)}
    for name, value in values.items():
        if types.get(name) == "str":
            if not isinstance(value, str):
                raise TypeError(f"{name} = {brief(value)}: must be a string")
        elif value is not None:
            finite_float(name, value, nonnegative=name != "order", positive=name == "nanoseconds")
        elif types.get(name) == "Unbounded":
            values[name] = math.inf
        elif "None" not in types.get(name, ""):
            raise TypeError(f"{name} = None: must be a number")
    return kind(**values)


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant}: is not JSON")
