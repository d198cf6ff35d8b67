"""The picture of a report: error against time, with the methods named beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..drawing.figure import shown_figure
from ..solve.methods import EXACT
from .data import ReportData
from .row import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["STYLES", "plot_report"]

# Okabe and Ito's colours without yellow, which is lost on white. A family has a colour and a
# marker, its members differ in dashes: readers who see few colours have the other two.
_FAMILIES = (
    ("black", "*", (EXACT,)),
    ("#d55e00", "o", ("rk4", "dop853")),
    ("#0072b2", "s", ("taylor12", "taylor16", "taylor20", "taylor26")),
    ("#009e73", "^", ("splitting", "splitting4", "splitting8")),
    ("#cc79a7", "D", ("chin4a",)),
    ("#56b4e9", "X", ("pmlf4", "pmlf6")),
    ("#e69f00", "v", ("dmv2", "dmv10")),
    ("#555555", "P", ("etd4", "midpoint")),
)
_DASHES = ("-", "--", ":", "-.", (0, (6, 1)), (0, (3, 1, 1, 1, 1, 1)))

Style: TypeAlias = tuple[str, Any, str]
"""Colour, dashes and marker of a line."""

STYLES: Mapping[str, Style] = {
    method: (colour, dashes, marker)
    for colour, marker, members in _FAMILIES
    for method, dashes in zip(members, _DASHES, strict=False)
}
"""The style of each method in all pictures of reports."""

_UNKNOWN: Style = ("#999999", "-", ".")
"""The style of a method of another version, in a report that was read from a file."""

WIDTH = 24
"""Characters of a line of names, of which a method may have several."""

TOP = 3.0
"""Upper limit of the axis of errors: a larger error of an attitude has no meaning."""


def plot_report(report: ReportData, *, ax: Axes | None = None) -> Axes:
    """Draw error against processor time, a line for each method, both axes logarithmic.

    The grey band follows the Pareto front of the schemes; nothing is known in the hatched region
    below the uncertainty of the reference. Small points are rows whose error is only a bound,
    because the true error is below this uncertainty.

    Parameters
    ----------
    report : ReportData
        The report to draw.
    ax : matplotlib Axes, optional
        Axes to draw on; by default those of a new figure.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ImportError
        Without matplotlib.
    """
    if ax is None:
        ax = shown_figure().add_subplot()
    spec = report.spec
    ax.set(xscale="log", yscale="log")
    ax.set_xlabel(f"processor time per body and {spec.unit} of motion (ns)")
    ax.set_ylabel(f"error of the state at t = {spec.t_end:g} {spec.unit}")
    ax.set_title(_title(report), loc="left", fontsize="medium")
    ax.grid(visible=True, which="major", color="0.92", linewidth=0.8)
    ax.set_axisbelow(True)
    lines = {method: _drawable(report.of(method)) for method in report.methods}
    lines = {method: rows for method, rows in lines.items() if rows}
    if not lines:
        return ax
    _limits(ax, report, [row for rows in lines.values() for row in rows])
    _draw_front(ax, report)
    for method, rows in lines.items():
        _draw_method(ax, rows, *STYLES.get(method, _UNKNOWN))
    _name(ax, list(lines), report.same)
    return ax


def _drawable(rows: tuple[Row, ...]) -> list[Row]:
    """Finite rows from the last one with an error of 1 or more on; the line begins there."""
    finite = [row for row in rows if math.isfinite(row.error) and row.error > 0.0]
    useless = [k for k, row in enumerate(finite) if row.error >= 1.0]
    return finite[useless[-1] :] if useless else finite


def _limits(ax: Axes, report: ReportData, rows: list[Row]) -> None:
    times = np.array([row.nanoseconds for row in rows])
    errors = np.array([row.error for row in rows])
    unknown = min(report.reference.uncertainty, 1.0)
    low = 0.1 * min(errors.min(), unknown)
    ax.set_xlim(0.5 * times.min(), 4.0 * times.max())
    ax.set_ylim(low, TOP)
    ax.axhspan(low, unknown, facecolor="0.96", edgecolor="0.85", hatch="////", zorder=0.1)
    ax.annotate(
        f"below the uncertainty of the reference ({report.reference.method})",
        (0.01, low),
        xycoords=("axes fraction", "data"),
        xytext=(0.0, 4.0),
        textcoords="offset points",
        fontsize="x-small",
        color="0.35",
        bbox={"facecolor": "0.96", "edgecolor": "none", "pad": 1.0},
    )


def _draw_front(ax: Axes, report: ReportData) -> None:
    front = [row for row in report.scheme_front if row.error > 0.0]
    if not front:
        return
    ax.plot(
        [row.nanoseconds for row in front],
        [row.error for row in front],
        color="0.8",
        linewidth=7.0,
        solid_capstyle="round",
        solid_joinstyle="round",
        zorder=1.0,
        label="Pareto front",
    )


def _draw_method(ax: Axes, rows: list[Row], colour: str, dashes: Any, marker: str) -> None:
    times, errors = [row.nanoseconds for row in rows], [row.error for row in rows]
    ax.plot(times, errors, color=colour, linestyle=dashes, linewidth=1.3, zorder=2.0)
    known = [not row.mark or row.method == EXACT for row in rows]
    for wanted, size in ((True, 22.0), (False, 7.0)):
        chosen = [k for k, is_known in enumerate(known) if is_known == wanted]
        ax.scatter(
            [times[k] for k in chosen],
            [errors[k] for k in chosen],
            s=110.0 if marker == "*" else size,
            marker=marker,
            facecolor=colour,
            edgecolor="white",
            linewidth=0.5,
            zorder=3.0,
        )


def _title(report: ReportData) -> str:
    spec = report.spec
    detail = f"median of {spec.bodies} bodies, one core of {report.machine.get('cpu', '?')}"
    isa = report.machine.get("isa")
    if isa:
        detail += f" ({isa})"
    if not report.complete:
        detail += "; partial"
    return f"{spec.title or 'Error against run time'}\n{detail}"


def _name(ax: Axes, methods: list[str], same: Mapping[str, tuple[str, ...]]) -> None:
    """Name the methods beside the plot, family by family: at the ends their names would collide.

    A method that has several names is named by all of them.
    """
    from matplotlib.lines import Line2D

    known = list(STYLES)
    ordered = sorted(methods, key=lambda name: known.index(name) if name in STYLES else len(known))
    lines = [Line2D([], [], color="0.8", linewidth=7.0, label="Pareto front")]
    for method in ordered:
        colour, dashes, marker = STYLES.get(method, _UNKNOWN)
        others = ", ".join(same.get(method, ()))
        lines.append(
            Line2D(
                [],
                [],
                color=colour,
                linestyle="none" if method == EXACT else dashes,
                linewidth=1.3,
                marker=marker,
                markersize=10.0 if method == EXACT else 5.0,
                markeredgecolor="white",
                markeredgewidth=0.5,
                label=fill(f"{method} = {others}" if others else method, WIDTH),
            )
        )
    ax.legend(
        handles=lines,
        loc="upper left",
        bbox_to_anchor=(1.01, 1.01),
        frameon=False,
        fontsize="small",
        handlelength=3.4,
        labelspacing=0.35,
    )
