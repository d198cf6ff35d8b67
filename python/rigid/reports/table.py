"""The tables of a report as text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from .._checks.shown import LABEL, aligned, labelled, wrapped
from ..model.scene import Scene
from ..solve.methods import EXACT, methods
from ..solve.plan import carried, left_out, not_left_out
from .data import AT_UNCERTAINTY, REFERENCE, REPEATS, ReportData, Row

SIDE_BY_SIDE = 4
"""Most columns of times in a table."""

ERRORS = {"energy": "energy_drift", "momentum": "momentum_drift", "phase": "phase"}
"""The errors that are shown over revolutions, and their names in rows."""


def report_text(report: ReportData) -> str:
    """Lines on the measurement, the time of each method for each error, and the Pareto front.

    Over revolutions the errors of each method in equal time, and the Pareto fronts.
    """
    parts = [_head(report), *_costs(report), _same(report), _front(report)]
    if report.spec.revolutions:
        parts = [_long_head(report), *_growth(report)]
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def _head(report: ReportData) -> list[str]:
    spec, reference = report.spec, report.reference
    how = "closed form" if reference.method == EXACT else f"{reference.steps:,} steps"
    too_few = ", too few to tell the cheapest" if report.rounds < REPEATS else ""
    lines = {
        "bodies": f"{spec.bodies} close to it, seed {spec.seed}; t = {spec.t_end:g} {spec.unit}",
        "reference": (
            f"{reference.method}, {how}; may be off by {reference.uncertainty:.1e}, "
            f"worst {reference.worst:.1e}"
        ),
        "error": (
            "median of the bodies: of the rates, relative, or of the attitude, rad; "
            "< below the uncertainty of the reference"
        ),
        "time": (
            f"processor time, ns per body and {spec.unit} of motion; "
            f"median of {report.rounds}{too_few}"
        ),
    }
    return _heading(report, "report", "error against run time", lines)


def _heading(report: ReportData, what: str, untitled: str, lines: Mapping[str, str]) -> list[str]:
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
    refused: dict[str, list[str]] = {}
    for name, reason in report.refused.items():
        refused.setdefault(_brief(name, reason), []).append(name)
    told += [("not for", f"{', '.join(names)}: {reason}") for reason, names in refused.items()]
    return wrapped(labelled(told)).splitlines()


def _carried(scene: Scene) -> list[tuple[str, str]]:
    """What every method carries, and what the scene does not need."""
    question, method = "attitude", ""  # any but the closed form
    done = carried(scene, question, method, scene.forces)
    left = left_out(scene, question, method, None, np.zeros(0, np.uint8), scene.forces)
    why = "; ".join(not_left_out(done, scene.forces))
    return [
        ("carried", ", ".join(done) + (f" ({why})" if why else "")),
        ("left out", "; ".join(left) or "nothing"),
    ]


def _costs(report: ReportData) -> list[list[str]]:
    """For each method its order and the time for each error, a few errors in each table.

    The cheapest method, and the cheapest one without the closed form, have stars, and so do methods
    whose costs are not distinct.
    """
    wanted = report.spec.errors
    groups = range(0, len(wanted), SIDE_BY_SIDE)
    return [_times(report, wanted[first : first + SIDE_BY_SIDE]) for first in groups]


def _times(report: ReportData, wanted: Sequence[float]) -> list[str]:
    orders = {method.name: method.order for method in methods()}
    # The numbers below are times: `ns/s at 1e-06` is the time that an error of 1e-6 needs.
    table = [
        ["* cheapest", "order", "measured", *(f"ns/{report.spec.unit} at " for _ in wanted)],
        ["", "", "order", *(f"{error:.0e} " for error in wanted)],
    ]
    winners = [{*report.cheapest(error), *report.cheapest(error, schemes=True)} for error in wanted]
    for method in report.methods:
        order = report.order(method)
        cells = [method, str(orders.get(method, "-")), "-" if order is None else f"{order:.1f}"]
        for error, best in zip(wanted, winners, strict=True):
            cost = report.cost(method, error)
            star = "*" if method in best else " "
            cells.append("- " if cost is None else f"{time_text(cost)}{star}")
        table.append(cells)
    return _aligned(table)


def _same(report: ReportData) -> list[str]:
    """The other names of the methods in the tables."""
    if not report.same:
        return []
    lines = labelled((method, f"= {', '.join(names)}") for method, names in report.same.items())
    head = "Methods with bit-identical results share a row:"
    return [head, *wrapped(lines, indent=LABEL + 2).splitlines()]


def _front(report: ReportData) -> list[str]:
    time = f"ns/{report.spec.unit}"
    head = ["front", "steps", "rad/step", "time", "±", "error", "worst", "energy", "momentum"]
    table = [head, ["", "", "", time, "", "rad", "rad", "rel.", "rel."]]
    closed = [row for row in report.front() if row.method == EXACT]
    for row in [*closed, *report.front(schemes=True)]:
        table.append(
            [
                row.method,
                f"{row.steps:,}",
                "-" if row.angle is None else f"{row.angle:.2g}",
                time_text(row.nanoseconds),
                "-" if row.spread is None else time_text(row.spread, 1),
                f"{'<' if row.mark in (REFERENCE, AT_UNCERTAINTY) else ''}{row.error:.1e}",
                f"{row.worst:.1e}",
                _drift_text(row.energy_drift),
                _drift_text(row.momentum_drift),
            ]
        )
    return _aligned(table)


def _drift_text(drift: float) -> str:
    return f"{drift:.0e}" if math.isfinite(drift) else "-"


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


def _aligned(table: Sequence[Sequence[str]]) -> list[str]:
    """Columns side by side: names to the left, numbers to the right."""
    first, *rest = table
    wide = [first[0].ljust(10), *first[1:]]
    return aligned([wide, *rest], right=range(1, len(first)))


def known_errors(report: ReportData) -> list[str]:
    """The known errors; the error of the phase is unknown where the motion is chaotic."""
    known = any(row.phase < 1.0 for row in report.rows)
    return [name for name in ERRORS if known or name != "phase"]


def in_short(count: float) -> str:
    """A number of revolutions as text, such as 1e6."""
    power = round(math.log10(count))
    return f"1e{power}" if count == 10.0**power and power > 2 else f"{count:g}"


def _long_head(report: ReportData) -> list[str]:
    spec = report.spec
    lines = {
        "bodies": f"{spec.bodies} close to it, seed {spec.seed}: the largest error of all",
        "revolution": (
            f"2 pi / |omega| = {spec.time_of(1.0):.4g} {spec.unit}; rad of a step at this rate"
        ),
        "energy": "largest error, minus the work, relative",
        "momentum": f"largest error {_momentum(spec.scene)}, relative",
        "phase": "angle to the true attitude at the end, rad; < below the uncertainty of the truth",
        "reference": _references(report),
        "time": "processor time, ns per body and revolution (ns/rev)",
    }
    return _heading(report, "long run", "errors over many revolutions", lines)


def _momentum(scene: Scene) -> str:
    if scene.forces:
        return "of its balance"
    if not scene.weight.any():
        return "of L in space"
    return "of L along the vertical, and along the axis of a symmetric top"


def _references(report: ReportData) -> str:
    """The uncertainty of the truth over each number of revolutions, and where it is lost."""
    method = report.references[0].method
    if not method:
        return "no time to find it"
    counts = [in_short(count) for count in report.spec.revolutions]
    words = [
        f"{one.worst:.0e} over {count}"
        for one, count in zip(report.references, counts, strict=True)
        if one.worst < 1.0
    ]
    how = "closed form" if method == EXACT else "compared with twice the step"
    text = f"{method}, {how}; "
    text += f"may be off by {', '.join(words)}" if words else "no phase is known"
    if len(words) == len(counts):
        return text
    if report.references[len(words)].method:
        return f"{text}; lost over {counts[len(words)]}, as in chaos"
    return f"{text}; no time to find it over {counts[len(words)]}"


def _growth(report: ReportData) -> list[list[str]]:
    """The growth of the errors of each method in equal time, and the Pareto fronts."""
    if not report.rows:
        return []
    errors = known_errors(report)
    counts = [in_short(count) for count in report.spec.revolutions]
    most = time_text(report.spec.time_of(report.common_time))
    tables = [[f"Each method with the shortest step of at most {most} ns, after revolutions:"]]
    for name in errors:
        table = [[name, "rad/step", "ns/rev", *counts]]
        for row in report.at_common_time():
            grown = [_error_text(report, one, name) for one in report.growth(row)]
            missing = ["-"] * (len(counts) - len(grown))
            table.append([*_beginning(report, row), *grown, *missing])
        tables.append(_aligned(table))
    over = in_short(report.horizon)
    for name in errors:
        front = report.front(ERRORS[name]) if name != "momentum" else ()
        table = [["front", "rad/step", "ns/rev", *errors]]
        for row in front:
            cells = [_error_text(report, row, error) for error in errors]
            table.append([*_beginning(report, row), *cells])
        if front:
            tables.append([f"The least {name} over {over} revolutions:", *_aligned(table)])
    return tables


def _beginning(report: ReportData, row: Row) -> list[str]:
    return [row.method, f"{row.angle:g}", time_text(report.spec.time_of(row.nanoseconds))]


def _error_text(report: ReportData, row: Row, name: str) -> str:
    """An error as text: ``lost`` where it is 1 or more, ``-`` where it is not known."""
    error = getattr(row, ERRORS[name])
    reference = report.references[report.spec.horizons.index(row.revolutions)]
    if name == "phase" and not reference.method:
        return "-"
    # A step whose drift is infinite over the first revolutions has rows only if it is not known.
    if name != "phase" and math.isinf(getattr(report.growth(row)[0], ERRORS[name])):
        return "-"
    if not error < 1.0:
        return "lost"
    return f"{'<' if name == 'phase' and error <= reference.worst else ''}{error:.0e}"
