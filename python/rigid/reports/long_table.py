"""The table of a long run as text."""

from __future__ import annotations

import math

from ..solve.methods import EXACT
from .long_data import LongRow, LongRunData, in_short
from .table import aligned, heading, time_text

__all__ = ["long_text"]


def long_text(report: LongRunData) -> str:
    """Lines on the measurement, the errors of each method in equal time, and the Pareto fronts."""
    parts = [_head(report)]
    if report.rows:
        parts += [
            _at_common_time(report),
            *(_front(report, error) for error in report.errors if error != "momentum"),
        ]
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def _head(report: LongRunData) -> list[str]:
    spec = report.spec
    period = math.tau / math.hypot(*spec.omega)
    lines = {
        "bodies": f"{spec.bodies} close to it, seed {spec.seed}: the largest error of all",
        "revolution": f"2 pi / |omega| = {period:.4g} {spec.unit}; rad of a step at this rate",
        "energy": "largest error, minus the work, relative",
        "momentum": f"largest error {_momentum(report)}, relative",
        "phase": "angle to the true attitude at the end, rad; < below the uncertainty of the truth",
        "reference": _references(report),
        "time": "processor time, ns per body and revolution (ns/rev)",
    }
    return heading(report, "long run", "errors over many revolutions", lines)


def _momentum(report: LongRunData) -> str:
    scene = report.spec.scene
    if scene.forces:
        return "of its balance"
    if not scene.weight.any():
        return "of L in space"
    return "of L along the vertical, and along the axis of a symmetric top"


def _references(report: LongRunData) -> str:
    """The uncertainty of the truth over each number of revolutions, and where it is lost."""
    known = [one for one in report.references if one.worst < 1.0]
    words = [
        f"{one.worst:.0e} over {in_short(count)}"
        for one, count in zip(known, report.revolutions, strict=False)
    ]
    if not report.references:
        return "no time to find it"
    method = report.references[0].method
    how = "closed form" if method == EXACT else "compared with twice the step"
    text = f"{method}, {how}; "
    text += f"may be off by {', '.join(words)}" if known else "no phase is known"
    if len(known) < len(report.references):
        return f"{text}; lost over {in_short(report.revolutions[len(known)])}, as in chaos"
    if len(known) < len(report.revolutions):
        return f"{text}; no time to find it over {in_short(report.revolutions[len(known)])}"
    return text


def _at_common_time(report: LongRunData) -> list[str]:
    """For each method the shortest step within the common time, and the growth of its errors."""
    counts = [in_short(count) for count in report.revolutions]
    head = ["method", "rad/step", "ns/rev"]
    for error in report.errors:
        head += [f"{error} {counts[0]}", *counts[1:]]
    table = [[*head, ""]]
    for row in report.at_common_time():
        cells = [row.method, f"{row.angle:g}", time_text(row.nanoseconds)]
        for error in report.errors:
            cells += [_error(report, row, error, k) for k in range(len(counts))]
        table.append([*cells, ""])
    return [
        f"Each method with the shortest step of at most {time_text(report.common_time)} ns:",
        *aligned(table),
    ]


def _front(report: LongRunData, error: str) -> list[str]:
    """The Pareto front of an error over the most revolutions."""
    at = report.horizon
    table = [["front", "rad/step", "ns/rev", *report.errors, ""]]
    for row in report.front(error):
        cells = [_error(report, row, name, at) for name in report.errors]
        table.append([row.method, f"{row.angle:g}", time_text(row.nanoseconds), *cells, ""])
    if len(table) == 1:
        return []
    return [
        f"The least {error} over {in_short(report.revolutions[at])} revolutions:",
        *aligned(table),
    ]


def _error(report: LongRunData, row: LongRow, name: str, horizon: int) -> str:
    """An error as text: ``lost`` where the phase is lost, ``-`` where it is unknown or not run."""
    error = row.error(name, horizon)
    if math.isfinite(error):
        known = name == "phase" and error <= report.references[horizon].worst
        return f"{'<' if known else ''}{error:.0e}"
    run = horizon < len(row.energy)
    if run and (name != "phase" or horizon < len(report.references)):
        return "lost"
    return "-"
