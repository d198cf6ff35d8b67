"""The tables of a report as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap

import numpy as np

from ..model.scene import Scene
from ..solve.methods import EXACT, methods
from ..solve.plan import carried, left_out, not_left_out
from .data import REPEATS, ReportData
from .long_data import LongRunData

__all__ = ["aligned", "heading", "report_text", "time_text"]

NAMES = 60
"""Characters of a line of other names."""


def report_text(report: ReportData) -> str:
    """Lines on the measurement, the time of each method for each error, and the Pareto front."""
    return "\n".join([*_head(report), "", *_costs(report), "", *_front(report)])


def _head(report: ReportData) -> list[str]:
    spec, reference = report.spec, report.reference
    how = "closed form" if reference.method == EXACT else f"{reference.steps:,} steps"
    time = f"processor time, ns per body and {spec.unit} of motion; {_repeats(report.rounds)}"
    lines = {
        "bodies": f"{spec.bodies} close to it, seed {spec.seed}; t = {spec.t_end:g} {spec.unit}",
        "reference": (
            f"{reference.method}, {how}; may be off by {reference.uncertainty:.1e}, "
            f"worst {reference.worst:.1e}"
        ),
        "error": "median of the bodies: of the rates, relative, or of the attitude, rad",
        "time": time,
    }
    return heading(report, "report", "error against run time", lines)


def heading(
    report: ReportData | LongRunData, what: str, untitled: str, lines: Mapping[str, str]
) -> list[str]:
    """The measured scene, the given lines on the measurement, and the refused methods."""
    spec, machine = report.spec, report.machine
    attitude = f"({_listed(spec.attitude)})"
    told = [
        (what, spec.title or untitled),
        ("scene", spec.scene.words()),
        *_carried(spec.scene),
        ("start", f"omega ({_listed(spec.omega)}) rad/{spec.unit}, attitude {attitude}"),
        *lines.items(),
        ("machine", ", ".join(machine[name] for name in ("cpu", "isa") if machine)),
    ]
    if not report.complete:
        told.append(("stopped", f"before its end: the {what.split()[-1]} is partial"))
    told += [("not for", f"{name}: {_brief(name, why)}") for name, why in report.refused.items()]
    return [f"{name:<12}{text}" for name, text in told]


def _carried(scene: Scene) -> list[tuple[str, str]]:
    """What every method carries, and what the scene does not need."""
    question, method = "attitude", ""  # any but the closed form
    done = carried(scene, question, method)
    left = left_out(scene, question, method, None, np.zeros(0, np.uint8))
    why = "; ".join(not_left_out(done, scene.forces))
    return [
        ("carried", ", ".join(done) + (f" ({why})" if why else "")),
        ("left out", "; ".join(left) or "nothing"),
    ]


def _repeats(rounds: int) -> str:
    too_few = ", too few to tell the cheapest" if rounds < REPEATS else ""
    return f"median of {rounds}{too_few}"


def _costs(report: ReportData) -> list[str]:
    """For each method its order, the time for each error, and its other names.

    The cheapest method, and the cheapest one without the closed form, have stars, and so do methods
    whose costs are not distinct.
    """
    wanted = report.spec.errors
    orders = {method.name: method.order for method in methods()}
    # The numbers below are times: `ns/s at 1e-06` is the time that an error of 1e-6 needs.
    table = [
        ["* cheapest", "order", "measured", *(f"{_rate(report)} at " for _ in wanted), ""],
        ["", "", "order", *(f"{error:.0e} " for error in wanted), ""],
    ]
    winners = [{*report.cheapest(error), *report.cheapest(error, schemes=True)} for error in wanted]
    for method in report.methods:
        order = report.order(method)
        cells = [method, str(orders.get(method, "-")), "-" if order is None else f"{order:.1f}"]
        for error, best in zip(wanted, winners, strict=True):
            cost = report.cost(method, error)
            star = "*" if method in best else " "
            cells.append("- " if cost is None else f"{time_text(cost)}{star}")
        names = wrap(", ".join(report.same.get(method, ())), NAMES) or [""]
        table.append([*cells, f"= {names[0]}" if names[0] else ""])
        table += [[*("" for _ in cells), f"  {more}"] for more in names[1:]]
    return aligned(table)


def _front(report: ReportData) -> list[str]:
    time = _rate(report)
    head = ["front", "steps", "rad/step", "time", "±", "total", "error", "worst", "energy"]
    table = [
        [*head, "momentum", ""],
        ["", "", "", time, time, "ns", "rad", "rad", "relative", "relative", ""],
    ]
    closed = [row for row in report.front if row.method == EXACT]
    for row in [*closed, *report.scheme_front]:
        table.append(
            [
                row.method,
                f"{row.steps:,}",
                "-" if row.angle is None else f"{row.angle:.2g}",
                time_text(row.nanoseconds),
                "-" if row.spread is None else time_text(row.spread, 1),
                time_text(row.total),
                f"{row.error:.1e}",
                f"{row.worst:.1e}",
                f"{row.energy_drift:.0e}",
                f"{row.momentum_drift:.0e}",
                row.mark,
            ]
        )
    return aligned(table)


def _rate(report: ReportData) -> str:
    """The unit of time of a computation by time of the motion."""
    return f"ns/{report.spec.unit}"


def _listed(values: Sequence[float]) -> str:
    """The numbers of a vector."""
    return ", ".join(f"{value:g}" for value in values)


def time_text(nanoseconds: float, digits: int = 3) -> str:
    """Three digits, or all before the point."""
    small = nanoseconds < 10.0**digits - 0.5
    return f"{nanoseconds:.{digits}g}" if small else f"{nanoseconds:,.0f}"


def _brief(method: str, why: str) -> str:
    """The beginning of the reason of a refused method, without the name of the method."""
    text = why.removeprefix(f"method = {method!r}: ").partition(";")[0]
    return text if len(text) <= 100 else f"{text[:97]}..."


def aligned(table: Sequence[Sequence[str]]) -> list[str]:
    """Columns side by side: the first to the left, numbers to the right, marks unchanged."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = []
    for cells in table:
        first = f"{cells[0]:<{max(widths[0], 10)}}"
        rest = [f"{cell:>{width}}" for cell, width in zip(cells[1:], widths[1:], strict=True)]
        if not table[0][-1]:
            rest[-1] = cells[-1]
        lines.append("  ".join([first, *rest]).rstrip())
    return lines
