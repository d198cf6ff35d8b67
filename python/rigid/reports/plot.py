"""The picture of a report: error against time, labelled at the ends of the lines."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..drawing.figure import shown_figure
from ..solve.methods import EXACT
from .data import ReportData
from .row import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

__all__ = ["STYLES", "plot_report"]

# Okabe and Ito's colours without yellow, which is lost on white. A family has a colour and a
# marker, its members differ in dashes: readers who see few colours have the other two.
_FAMILIES = (
    ("black", "*", (EXACT,)),
    ("#d55e00", "o", ("rk4", "dop853")),
    ("#0072b2", "s", ("taylor8", "taylor12", "taylor14", "taylor16", "taylor20", "taylor26")),
    ("#009e73", "^", ("splitting", "splitting4", "splitting6", "splitting8")),
    ("#cc79a7", "D", ("chin4a", "srkn6", "srkn11", "srkn14")),
    ("#56b4e9", "X", ("pmlf4", "pmlf6")),
    ("#e69f00", "v", ("dmv2", "dmv4", "dmv6", "dmv8", "dmv10")),
    ("#555555", "P", ("hermite9", "etd4", "midpoint")),
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
    ends = []
    for method, rows in lines.items():
        style = STYLES.get(method, _UNKNOWN)
        _draw_method(ax, rows, *style)
        ends.append((method, rows[-1], style[0]))
    _label(ax, ends, lines)
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


def _label(
    ax: Axes, ends: list[tuple[str, Row, str]], lines: dict[str, list[Row]]
) -> list[Annotation]:
    """Name each line near its last point, where no other name and as few lines as possible are."""
    ax.figure.draw_without_rendering()  # type: ignore[union-attr]  # settles the layout
    taken: list[Bbox] = [text.get_window_extent() for text in ax.texts]
    obstacles = np.concatenate([_along(ax, rows) for rows in lines.values()])
    frame = ax.get_window_extent()
    points = ax.figure.dpi / 72.0
    labels = []
    for method, row, colour in sorted(ends, key=lambda end: (end[1].error, end[1].nanoseconds)):
        label = ax.annotate(
            method,
            (row.nanoseconds, row.error),
            xytext=(0.0, 0.0),
            textcoords="offset points",
            color=colour,
            fontsize="small",
            fontweight="bold" if method == EXACT else "normal",
            ha="left",
            va="center",
            zorder=4.0,
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.6, "shrinkB": 3.0},
        )
        label.set_in_layout(False)
        anchor = ax.transData.transform((row.nanoseconds, row.error))
        box = label.get_window_extent()
        size = np.array([box.width, box.height])
        best, place, distance = math.inf, (8.0, 0.0), 8.0
        for radius, *offset in _offsets(size / points):
            moved = _box_at(anchor + points * np.array(offset), size)
            cost = _cost(moved, frame, taken, obstacles, anchor, points)
            if cost < best:
                best, place, distance = cost, (offset[0], offset[1]), radius
        label.set_position(place)
        if distance < 14.0 and label.arrow_patch is not None:
            label.arrow_patch.set_visible(False)
        taken.append(_box_at(anchor + points * np.array(place), size))
        labels.append(label)
    return labels


def _along(ax: Axes, rows: list[Row]) -> NDArray[np.float64]:
    """Points along a line, a few pixels apart."""
    corners = ax.transData.transform([(row.nanoseconds, row.error) for row in rows])
    share = np.linspace(0.0, 1.0, 25)[:, None]
    pieces = [a + share * (b - a) for a, b in pairwise(corners)]
    return np.concatenate([corners, *pieces])


def _offsets(size: NDArray[np.float64]) -> list[tuple[float, float, float]]:
    """Distances and places of the left middle of a label around its point, in points."""
    width = float(size[0])
    places = []
    for radius in (8.0, 13.0, 20.0, 28.0, 38.0, 50.0, 64.0, 80.0, 98.0, 120.0):
        for degrees in range(0, 360, 15):
            x = radius * math.cos(math.radians(degrees))
            y = radius * math.sin(math.radians(degrees))
            # Left of the point the label ends there; above and below it is centred.
            shift = 0.0 if x > 0.5 * radius else width if x < -0.5 * radius else 0.5 * width
            places.append((radius, x - shift, y))
    return places


def _box_at(left_middle: NDArray[np.float64], size: NDArray[np.float64]) -> Bbox:
    from matplotlib.transforms import Bbox

    x, y = left_middle
    return Bbox.from_bounds(x, y - 0.5 * size[1], size[0], size[1])


def _cost(
    box: Bbox,
    frame: Bbox,
    taken: list[Bbox],
    obstacles: NDArray[np.float64],
    anchor: NDArray[np.float64],
    points: float,
) -> float:
    """Penalty of a position: overlap with a name is worst, then the frame, lines and distance."""
    roomy = box.padded(1.5 * points)
    names = sum(roomy.overlaps(other) for other in taken)
    outside = not (
        frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 < box.y1 < frame.y1
    )
    inside = np.all((obstacles > (roomy.x0, roomy.y0)) & (obstacles < (roomy.x1, roomy.y1)), axis=1)
    middle = np.array([0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)])
    gap: Any = np.linalg.norm((middle - anchor) / (2.5 * points, points))
    return 1e4 * names + 1e3 * outside + 6.0 * min(int(inside.sum()), 30) + float(gap)
