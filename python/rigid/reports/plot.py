"""The picture of a report: error against time, a line with a name at its end for each method."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats
from ..drawing.colours import BAND, GRID, HUES, NEUTRAL, PALE, SURFACE, on_ground
from ..drawing.figure import SMALL, axes_to_draw_on, check_axes, shown_figure
from ..solve.methods import EXACT, methods
from .data import ReportData
from .reference import Reference
from .table import ERRORS, in_short, known_errors, time_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Points: TypeAlias = Sequence[tuple[float, float]]
"""The line of a method: times, or revolutions, and errors."""


COLOURS: Mapping[str, str] = {
    EXACT: HUES["black"],
    "Runge–Kutta": HUES["vermilion"],
    "Taylor series": HUES["blue"],
    "splitting": HUES["green"],
    "free motion and kicks": HUES["purple"],
    "Moser–Veselov": HUES["violet"],
    "exponential": HUES["orange"],
    "midpoint rule": NEUTRAL,
}
"""The colours of closed forms, and of each family of methods."""

OTHERS = HUES["sky"]
"""Colour of own schemes, and of methods of another version in a report from a file."""

TOP = 3.0
"""Upper limit of the axis of errors: a larger error of an attitude has no meaning."""

LEAST = 1e-17
"""An error of zero is drawn here in its growth."""

LABELS = {"energy": "energy, relative", "momentum": "momentum, relative", "phase": "phase, rad"}

NAME_SIZE = 8.0
"""Size of the names of methods (points)."""


def plot_report(report: ReportData, ax: Axes | None) -> Any:
    """Draw error against processor time, both axes logarithmic.

    Each method has a line, with its name at the end, in the colour of its family. The broad line
    is the Pareto front: no method that makes steps is faster and better. Nothing is known in the
    hatched region below the uncertainty of the reference. Slow methods may end beyond the right
    edge.

    Over revolutions a grid of axes, in the place of ``ax``, shows the errors of energy, momentum
    and phase: against time, and beside it their growth in about the same time.

    Parameters
    ----------
    report : ReportData
        The report to draw.
    ax : matplotlib Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    matplotlib Axes, or ndarray of these

    Raises
    ------
    ImportError
        Without matplotlib.
    """
    if report.spec.revolutions:
        return _plot_growth(report, ax)
    ax = axes_to_draw_on(ax, SMALL)
    spec = report.spec
    ax.set_xlabel(f"processor time per body and {spec.unit} of motion (ns)")
    ax.set_ylabel(f"error of the state at t = {spec.t_end:g} {spec.unit}")
    ax.set_title(_title(report), loc="left", fontsize="medium")
    _draw_trade_off(ax, _lines(report, "error"), reference=report.reference)
    return ax


def _plot_growth(report: ReportData, ax: Axes | None) -> NDArray[Any]:
    """Draw the errors over revolutions; the axes are replaced by a grid of axes."""
    if ax is None:
        figure = shown_figure()
    else:
        figure = check_axes(ax).get_figure(root=True)
        ax.remove()
    spec, reference = report.spec, report.reference
    errors = [
        name for name in known_errors(report) if any(_lines(report, ERRORS[name]).values())
    ] or known_errors(report)
    figure.set_size_inches(8.0, 3.4 * len(errors) + 0.4)
    grid: NDArray[Any] = figure.subplots(len(errors), 2, squeeze=False)
    figure.suptitle(_title(report), x=0.01, ha="left", fontsize="medium")
    most = time_text(spec.time_of(report.common_time))
    for (first, second), name in zip(grid, errors, strict=True):
        first.set_title(f"over {in_short(report.horizon)} revolutions", fontsize="small")
        first.set_xlabel("processor time per body and revolution (ns)", fontsize="small")
        second.set_title(f"in at most {most} ns per revolution", fontsize="small")
        second.set_xlabel("revolutions", fontsize="small")
        known = None
        if name == "phase" and reference.method:
            known = replace(reference, uncertainty=reference.worst)
        times = [spec.time_of(row.nanoseconds) for row in report.rows] or [1.0]
        lines = _lines(report, ERRORS[name], spec.time_of)
        _draw_trade_off(first, lines, reference=known, times=(min(times), max(times)))
        _draw_growth(second, report, ERRORS[name])
        for one in (first, second):
            one.set_ylabel(f"error of the {LABELS[name]}", fontsize="small")
            one.tick_params(labelsize="small")
    return grid.T


def _lines(
    report: ReportData, error: str, time_of: Callable[[float], float] = float
) -> dict[str, Points]:
    """Time, by default for a unit of time of the motion, and error of the rows of each method."""
    return {
        method: [
            (time_of(row.nanoseconds), getattr(row, error))
            for row in report.of(method)
            if getattr(row, error) > 0.0
        ]
        for method in report.methods
    }


def _draw_growth(ax: Axes, report: ReportData, error: str) -> None:
    """Draw an error against the revolutions, of each method in about the same time."""
    _log_axes(ax)
    lines: dict[str, Points] = {}
    for row in report.at_common_time():
        points = [
            (one.revolutions, max(getattr(one, error), LEAST))
            for one in report.growth(row)
            if getattr(one, error) < 1.0
        ]
        if points:
            lines[row.method] = points
    if not lines:
        return
    errors = [error for points in lines.values() for _, error in points]
    counts = report.spec.revolutions
    ax.set_xlim(counts[0] / 1.5, counts[-1] * 1.5)
    ax.set_ylim(min(errors) / 3.0, min(3.0 * max(errors), TOP))
    _draw_methods(ax, lines)


def _log_axes(ax: Axes) -> None:
    ax.set(xscale="log", yscale="log")
    ax.grid(visible=True, which="major", color=on_ground(ax, GRID), linewidth=0.8)
    ax.set_axisbelow(True)


def _draw_trade_off(
    ax: Axes,
    lines: Mapping[str, Points],
    *,
    reference: Reference | None,
    times: tuple[float, float] | None = None,
) -> None:
    """Draw error against time of each method, the best of families, and the Pareto front.

    The plot is hatched below the uncertainty of the reference. ``times`` are the least and the
    largest; by default slow families do not stretch the axis.
    """
    _log_axes(ax)
    known = {method: _drawable(points) for method, points in lines.items()}
    known = {method: points for method, points in known.items() if points}
    if not known:
        return
    front = _front(known, [method for method in known if method != EXACT])
    if times is None:
        ends = sorted(points[-1][0] for points in known.values())
        slowest = max([ends[len(ends) // 2], *(time for time, _, _ in front[-1:])])
        times = min(points[0][0] for points in known.values()), slowest
    unknown = math.inf if reference is None else min(reference.uncertainty, 1.0)
    low = 0.1 * min(unknown, *(error for points in known.values() for _, error in points))
    ax.set_xlim(0.4 * times[0], 2.0 * times[1])
    ax.set_ylim(low, TOP)
    if reference is not None:
        _hatch(ax, low, unknown, reference.method)
    if front:
        ax.plot(
            *np.transpose([point[:2] for point in front]),
            color=on_ground(ax, BAND),
            linewidth=8.0,
            solid_capstyle="round",
            solid_joinstyle="round",
            zorder=2.0,
            label="Pareto front",
        )
    _draw_methods(ax, known)


def _draw_methods(ax: Axes, lines: Mapping[str, Points]) -> None:
    """Draw a line for each method, and its name to the right of the axes, at the end of the line.

    Names move up or down where they would cover each other; a thin line leads to each.
    """
    ends: list[tuple[float, float, str]] = []
    for method, points in lines.items():
        colour = on_ground(ax, colour_of(method))
        ax.plot(
            *np.transpose(points),
            color=colour,
            linewidth=1.3,
            marker="*" if method == EXACT else "o",
            markersize=10.0 if method == EXACT else 2.5,
            zorder=3.0,
            label=method,
        )
        if (end := _last_inside(_in_axes(ax, points))) is not None:
            ends.append((end[1], end[0], method))
    ends.sort(key=lambda end: (end[0], -end[1]))
    figure = ax.get_figure(root=True)
    assert figure is not None
    height = figure.get_size_inches()[1] * ax.get_position().height
    apart = 1.15 * NAME_SIZE / 72.0 / height
    for (y, x, method), place in zip(ends, spread([end[0] for end in ends], apart), strict=True):
        colour = on_ground(ax, colour_of(method))
        ax.plot(
            *([x, 1.015], [y, place]),
            transform=ax.transAxes,
            color=colour,
            linewidth=0.5,
            alpha=0.6,
            clip_on=False,
            zorder=1.0,
        )
        ax.text(
            *(1.02, place, method),
            transform=ax.transAxes,
            color=colour,
            fontsize=NAME_SIZE,
            va="center",
        )


def _last_inside(places: Floats) -> Floats | None:
    """The end of a line in shares of the axes: where it leaves them, if it does."""
    end: Floats = places[-1]
    if ((end >= 0.0) & (end <= 1.0)).all():
        return end
    # On each piece, the largest share of it at which the line is still within the axes.
    for first, last in zip(places[-2::-1], places[:0:-1], strict=True):
        shares = np.linspace(1.0, 0.0, 101)[:, np.newaxis]
        line = first + shares * (last - first)
        within = ((line >= 0.0) & (line <= 1.0)).all(axis=1)
        if within.any():
            return np.asarray(line[np.argmax(within)])
    return None


def spread(heights: Sequence[float], apart: float) -> Floats:
    """The increasing heights, moved as little as possible to be so far apart and in [0, 1].

    With ``apart`` times the index subtracted they must not decrease: the nearest such numbers are
    means of neighbours (pool adjacent violators).
    """
    blocks: list[tuple[float, int]] = []
    for k, height in enumerate(heights):
        total, count = height - apart * k, 1
        while blocks and blocks[-1][0] / blocks[-1][1] > total / count:
            more, others = blocks.pop()
            total, count = total + more, count + others
        blocks.append((total, count))
    means = [total / count for total, count in blocks for _ in range(count)]
    room = max(1.0 - apart * (len(means) - 1), 0.0)
    placed: Floats = np.clip(means, 0.0, room) + apart * np.arange(len(means))
    return placed


def colour_of(name: str) -> str:
    """The colour of a method in all pictures."""
    families = {EXACT: EXACT, **{method.name: method.family for method in methods()}}
    return COLOURS.get(families.get(name, ""), OTHERS)


def _drawable(points: Points) -> Points:
    """Finite points from the last one with an error of 1 or more on."""
    finite = [(time, error) for time, error in points if math.isfinite(error)]
    useless = [k for k, (_, error) in enumerate(finite) if error >= 1.0]
    return finite[useless[-1] :] if useless else finite


def _front(
    lines: Mapping[str, Points], methods: Iterable[str]
) -> Sequence[tuple[float, float, str]]:
    """Time, error and method of the points than which none is faster and better, from 1 down."""
    least, front = 1.0, []
    for time, error, method in sorted((*point, name) for name in methods for point in lines[name]):
        if error < least:
            least = error
            front.append((time, error, method))
    return front


def _hatch(ax: Axes, low: float, unknown: float, reference: str) -> None:
    face = on_ground(ax, SURFACE)
    ax.axhspan(
        low, unknown, facecolor=face, edgecolor=on_ground(ax, PALE), hatch="////", zorder=0.1
    )
    ax.annotate(
        f"below the uncertainty of the reference ({reference})",
        (0.01, low),
        xycoords=("axes fraction", "data"),
        xytext=(0.0, 4.0),
        textcoords="offset points",
        fontsize="x-small",
        color=on_ground(ax, NEUTRAL),
        bbox={"facecolor": face, "edgecolor": "none", "pad": 1.0},
    )


def _in_axes(ax: Axes, points: Points) -> Floats:
    """Points in shares of the axes."""
    low, high = np.log([ax.get_xlim(), ax.get_ylim()]).T
    places: Floats = (np.log(points) - low) / (high - low)
    return places


def _title(report: ReportData) -> str:
    spec = report.spec
    which, title = "median", spec.title or "Error against run time"
    bands = "broad: Pareto front"
    if spec.revolutions:
        which, title = "largest", f"{spec.title or spec.scene.words()}: the long run"
        bands = "broad: Pareto fronts"
    cpu, isa = report.machine.get("cpu", "?"), report.machine.get("isa")
    detail = f"{which} of {spec.bodies} bodies, one core of {cpu}{f' ({isa})' if isa else ''}"
    if not report.complete:
        detail += "; partial"
    return f"{title}\n{detail}\n{bands}"
