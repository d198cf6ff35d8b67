"""Error against run time: the result, its Pareto front and its table."""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .cloud import Reference
from .methods import EXACT
from .reportspec import ReportSpec
from .scenes import scene_words

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes

__all__ = ["AT_UNCERTAINTY", "FAILED", "REFERENCE", "USELESS", "Report", "Row"]

FORMAT = "rigid report"
FORMAT_VERSION = 1

REFERENCE = "reference"
AT_UNCERTAINTY = "at reference uncertainty"
USELESS = "error >= 1"
FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One method with one step. Times are processor times of one body, in ns.

    Attributes
    ----------
    method : str
        Its name.
    steps : int
        Steps until ``t_end``; 0 by closed form.
    step, angle : float or None
        Step in units of time, and a bound of the angle turned in it (rad).
    nanoseconds, spread : float; float or None
        Time per unit of time of the motion: median, and distance of the quartiles; None of a
        single timing. In a partial report that may be a call with all that is around it.
    total : float
        Time until ``t_end``.
    error, worst : float
        Error of the state at ``t_end``: that of the rates relative to ``|omega|``, or the angle to
        the true attitude (rad), whichever is larger. Median of the cloud, and its worst body.
        Infinite for a body that did not arrive.
    rates_error, attitude_error : float
        Medians of the two.
    energy_drift, momentum_drift : float
        As in :class:`rigid.Run`, worst of the cloud.
    order : float or None
        Slope to the row before it, where both are well above rounding and below 0.1.
    mark : str
        Empty; ``"reference"``; ``"at reference uncertainty"``: the errors are bounds, what the
        reference may be off; ``"error >= 1"``: nothing is known of the state, as in chaos after
        too long a time; ``"failed"``.
    """

    method: str
    steps: int
    step: float | None
    angle: float | None
    nanoseconds: float
    spread: float | None
    total: float
    error: float
    worst: float
    rates_error: float
    attitude_error: float
    energy_drift: float
    momentum_drift: float
    order: float | None
    mark: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Error against run time of all methods for one scene; made by :func:`rigid.report`.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    rows : tuple of Row
        Method by method, from long steps to short ones.
    reference : Reference
        What errors are measured against, and by how much it may be off.
    refused : dict of str to str
        Methods that are not applicable, and why.
    ended : dict of str to str
        Why there are no shorter steps of a method: the error is the smallest wanted, or that of
        rounding, or no larger than the uncertainty of the reference, or the time was over.
    machine : dict of str to str
        Processor, instruction set, versions.
    complete : bool
        Whether the run came to its end; Ctrl-C leaves a partial report.
    rounds : int
        Timings of each row.
    elapsed : float
        Seconds that the report took.
    """

    spec: ReportSpec
    rows: tuple[Row, ...]
    reference: Reference
    refused: Mapping[str, str]
    ended: Mapping[str, str]
    machine: Mapping[str, str]
    complete: bool
    rounds: int
    elapsed: float

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods that were measured."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    def of(self, method: str) -> tuple[Row, ...]:
        """The rows of a method, from long steps to short ones."""
        return tuple(row for row in self.rows if row.method == method)

    @property
    def front(self) -> tuple[Row, ...]:
        """The Pareto front, from fast to exact: no other row is both faster and better.

        Rows with an error of 1 or more do not compete.
        """
        return _front(self.rows)

    @property
    def scheme_front(self) -> tuple[Row, ...]:
        """The Pareto front of the schemes alone: a closed form often beats them all."""
        return _front(row for row in self.rows if row.method != EXACT)

    def cost(self, method: str, error: float) -> float | None:
        """Processor time per body and unit of time (ns) for a wanted error, None if not reached.

        Interpolated between the steps of the sweep, linearly in the logarithms.
        """
        before = None
        for row in self.of(method):
            if row.error <= error:
                if before is None or not math.isfinite(before.error):
                    return row.nanoseconds
                share = math.log(before.error / error) / math.log(before.error / row.error)
                logs = math.log(before.nanoseconds), math.log(row.nanoseconds)
                return math.exp(logs[0] + share * (logs[1] - logs[0]))
            before = row
        return None

    def cheapest(self, error: float, *, schemes: bool = False) -> str | None:
        """The method that reaches a wanted error in the shortest time, None if none does.

        With ``schemes`` the closed form does not compete.
        """
        costs = {method: self.cost(method, error) for method in self.methods}
        reached = {
            method: cost
            for method, cost in costs.items()
            if cost is not None and not (schemes and method == EXACT)
        }
        return min(reached, key=lambda method: reached[method]) if reached else None

    def order(self, method: str) -> float | None:
        """The measured order: that of the shortest steps well above rounding."""
        orders = [row.order for row in self.of(method) if row.order is not None]
        return orders[-1] if orders else None

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw error against time, a line for each method, and the Pareto front.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            By default on a new figure that pyplot does not know.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        from .reportplot import plot_report

        return plot_report(self, ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """The report as a JSON-able dictionary; what is infinite or unknown is None."""
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "spec": self.spec.to_dict(),
            "machine": dict(self.machine),
            "reference": dataclasses.asdict(self.reference),
            "rows": [_finite(dataclasses.asdict(row)) for row in self.rows],
            "refused": dict(self.refused),
            "ended": dict(self.ended),
            "complete": self.complete,
            "rounds": self.rounds,
            "elapsed": self.elapsed,
        }

    def to_json(self) -> str:
        """The report as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False, indent=1, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> Report:
        """The report that :meth:`to_json` wrote.

        Raises
        ------
        ValueError
            If the text is no report, or one of another format.
        """
        try:
            data = json.loads(text)
            if data["format"] != FORMAT or data["format_version"] != FORMAT_VERSION:
                raise ValueError(f"format is not {FORMAT!r}, version {FORMAT_VERSION}")
            values = {field.name: data[field.name] for field in dataclasses.fields(cls)}
            values["spec"] = ReportSpec.from_dict(values["spec"])
            values["reference"] = Reference(**values["reference"])
            values["rows"] = tuple(_row(row) for row in values["rows"])
            return cls(**values)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise ValueError(f"text: is not a report: {type(error).__name__}: {error}") from None

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the JSON text to a file and return its path."""
        from pathlib import Path

        target = Path(path)
        target.write_text(self.to_json() + "\n", encoding="utf-8")
        return target

    def __str__(self) -> str:
        return "\n".join([*self._head(), "", *self._costs(), "", *self._front_table()])

    def _head(self) -> list[str]:
        spec, reference = self.spec, self.reference
        how = "closed form" if reference.method == EXACT else f"{reference.steps:,} steps"
        unit, attitude = spec.unit, f"({_listed(spec.attitude)})"
        lines = [
            ("report", spec.title or "error against run time"),
            ("scene", scene_words(spec.scene)),
            ("start", f"omega ({_listed(spec.omega)}) rad/{unit}, attitude {attitude}"),
            ("bodies", f"{spec.bodies} close to it, seed {spec.seed}; t = {spec.t_end:g} {unit}"),
            (
                "reference",
                f"{reference.method}, {how}; may be off by {reference.uncertainty:.1e}, "
                f"worst {reference.worst:.1e}",
            ),
            ("error", "median of the bodies: of the rates, relative, or of the attitude, rad"),
            ("time", f"processor time, ns per body and {unit} of motion; median of {self.rounds}"),
            ("machine", ", ".join(self.machine[name] for name in ("cpu", "isa") if self.machine)),
        ]
        if not self.complete:
            lines.append(("stopped", "before its end: the report is partial"))
        lines += [("not for", f"{name}: {_brief(name, why)}") for name, why in self.refused.items()]
        return [f"{name:<12}{text}" for name, text in lines]

    def _costs(self) -> list[str]:
        """Per method the time for each wanted error; the cheapest, and cheapest scheme, starred."""
        wanted = self.spec.errors
        table = [["* cheapest", "order", *(f"{error:.0e} " for error in wanted)]]
        winners = [{self.cheapest(error), self.cheapest(error, schemes=True)} for error in wanted]
        for method in self.methods:
            order = self.order(method)
            cells = [method, "-" if order is None else f"{order:.1f}"]
            for error, best in zip(wanted, winners, strict=True):
                cost = self.cost(method, error)
                star = "*" if method in best else " "
                cells.append("- " if cost is None else f"{_time(cost)}{star}")
            table.append(cells)
        return _aligned(table)

    def _front_table(self) -> list[str]:
        head = ["front", "steps", "rad/step", "time", "±", "total", "error", "worst", "energy"]
        table = [[*head, "momentum", ""]]
        closed = [row for row in self.front if row.method == EXACT]
        for row in [*closed, *self.scheme_front]:
            table.append(
                [
                    row.method,
                    f"{row.steps:,}",
                    "-" if row.angle is None else f"{row.angle:.2g}",
                    _time(row.nanoseconds),
                    "-" if row.spread is None else _time(row.spread, 1),
                    _time(row.total),
                    f"{row.error:.1e}",
                    f"{row.worst:.1e}",
                    f"{row.energy_drift:.0e}",
                    f"{row.momentum_drift:.0e}",
                    row.mark,
                ]
            )
        return _aligned(table)


def _front(rows: Iterable[Row]) -> tuple[Row, ...]:
    best, front = 1.0, []
    for row in sorted(rows, key=lambda row: (row.nanoseconds, row.error)):
        if row.error < best:
            best = row.error
            front.append(row)
    return tuple(front)


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _time(nanoseconds: float, digits: int = 3) -> str:
    """Three digits, or all before the point."""
    small = nanoseconds < 10.0**digits - 0.5
    return f"{nanoseconds:.{digits}g}" if small else f"{nanoseconds:,.0f}"


def _brief(method: str, why: str) -> str:
    """The beginning of a refusal, without the name of the method."""
    text = why.removeprefix(f"method = {method!r}: ").partition(";")[0]
    return text if len(text) <= 100 else f"{text[:97]}..."


def _aligned(table: Sequence[Sequence[str]]) -> list[str]:
    """Columns side by side: the first to the left, numbers to the right, the marks as they come."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = []
    for cells in table:
        first = f"{cells[0]:<{max(widths[0], 10)}}"
        rest = [f"{cell:>{width}}" for cell, width in zip(cells[1:], widths[1:], strict=True)]
        if not table[0][-1]:
            rest[-1] = cells[-1]
        lines.append("  ".join([first, *rest]).rstrip())
    return lines


_UNBOUNDED = (
    "error",
    "worst",
    "rates_error",
    "attitude_error",
    "energy_drift",
    "momentum_drift",
)


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    lost = {name: None for name in _UNBOUNDED if not math.isfinite(row[name])}
    return row | lost


def _row(data: Mapping[str, Any]) -> Row:
    values = dict(data)
    for name in _UNBOUNDED:
        if values[name] is None:
            values[name] = math.inf
    return Row(**values)
