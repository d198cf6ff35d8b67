"""The picture of a long run: errors against time, and their growth with the revolutions."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..drawing.colours import GRID, PALE, on_ground
from ..drawing.figure import shown_figure
from .long_data import LongRow, LongRunData, in_short
from .plot import (
    FAMILIES,
    OTHERS,
    TOP,
    Family,
    Points,
    draw_families,
    draw_trade_off,
    family_of,
    machine_words,
)
from .table import time_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_long_run"]

LABELS = {"energy": "energy, relative", "momentum": "momentum, relative", "phase": "phase, rad"}

LEAST = 1e-17
"""An error of zero is drawn here."""


def plot_long_run(report: LongRunData, figure: Figure | None = None) -> NDArray[Any]:
    """Draw the errors of a long run on a figure; :meth:`rigid.LongRun.plot` describes it."""
    figure = shown_figure() if figure is None else figure
    figure.set_size_inches(4.0 * len(report.errors), 8.0)
    grid: NDArray[Any] = figure.subplots(2, len(report.errors), squeeze=False)
    figure.suptitle(_title(report), x=0.01, ha="left", fontsize="medium")
    at = report.horizon
    reference = report.references[at] if at < len(report.references) else None
    times = [row.nanoseconds for row in report.rows] or [1.0]
    for (upper, lower), name in zip(grid.T, report.errors, strict=True):
        over = f"over {in_short(report.revolutions[at])} revolutions"
        upper.set_title(f"error of the {LABELS[name]}, {over}", fontsize="small")
        upper.set_xlabel("processor time per body and revolution (ns)", fontsize="small")
        lower.set_xlabel(
            f"revolutions, in at most {time_text(report.common_time)} ns each", fontsize="small"
        )
        lines = {
            method: [
                (row.nanoseconds, error)
                for row in report.of(method)
                if (error := row.error(name, at)) > 0.0
            ]
            for method in report.methods
        }
        known = None
        if name == "phase" and reference is not None:
            known = dataclasses.replace(reference, uncertainty=reference.worst)
        draw_trade_off(upper, lines, reference=known, times=(min(times), max(times)))
        _draw_growth(lower, report, name)
        for ax in (upper, lower):
            ax.tick_params(labelsize="small")
    return grid


def _draw_growth(ax: Axes, report: LongRunData, name: str) -> None:
    """Draw an error against the revolutions, of each method in about the same time."""
    ax.set(xscale="log", yscale="log")
    ax.grid(visible=True, which="major", color=on_ground(ax, GRID), linewidth=0.8)
    ax.set_axisbelow(True)
    lines = {row: _growth(report, row, name) for row in report.at_common_time()}
    lines = {row: points for row, points in lines.items() if points}
    best: dict[Family, LongRow] = {}
    at = report.horizon
    for row in sorted(lines, key=lambda row: (row.error(name, at), -len(lines[row]))):
        best.setdefault(family_of(row.method), row)
    if not best:
        return
    for points in lines.values():
        ax.plot(*np.transpose(points), color=on_ground(ax, PALE), linewidth=0.9, zorder=1.0)
    errors = [error for points in lines.values() for _, error in points]
    ax.set_xlim(report.revolutions[0] / 1.5, report.revolutions[-1] * 1.5)
    ax.set_ylim(min(errors) / 3.0, min(3.0 * max(errors), TOP))
    ordered = [family for family in (*FAMILIES, OTHERS) if family in best]
    draw_families(ax, {family: lines[best[family]] for family in ordered})


def _growth(report: LongRunData, row: LongRow, name: str) -> Points:
    errors = [row.error(name, k) for k in range(len(report.revolutions))]
    return [
        (count, max(error, LEAST))
        for count, error in zip(report.revolutions, errors, strict=True)
        if np.isfinite(error)
    ]


def _title(report: LongRunData) -> str:
    spec = report.spec
    detail = f"largest of {spec.bodies} bodies, {machine_words(report.machine)}"
    if not report.complete:
        detail += "; partial"
    title = f"{spec.title or spec.scene.words()}: the long run"
    return f"{title}\n{detail}; grey bands: Pareto fronts"
