"""The picture of a report: error against time, the best of each family named at its line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..drawing.colours import BAND, GRID, HUES, NEUTRAL, PALE, SURFACE, ground, on_ground
from ..drawing.figure import axes_to_draw_on, check_axes, shown_figure
from ..solve.methods import EXACT
from .data import ReportData, Row
from .reference import Reference
from .table import ERRORS, in_short, known_errors, time_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Floats = NDArray[np.float64]

Points: TypeAlias = Sequence[tuple[float, float]]
"""The line of a method: times, or revolutions, and errors."""

Name: TypeAlias = tuple[Floats, Floats]
"""The middle of a name and half its size, in shares of the axes."""


class Family(NamedTuple):
    """Methods of one kind, with one colour in all pictures."""

    name: str
    colour: str
    members: tuple[str, ...]


FAMILIES = (
    Family("closed form", HUES["black"], (EXACT,)),
    Family("Runge–Kutta", HUES["vermilion"], ("rk4", "dop853")),
    Family("Taylor series", HUES["blue"], ("taylor12", "taylor16", "taylor20", "taylor26")),
    Family("splitting", HUES["green"], ("splitting", "splitting4", "splitting8")),
    Family("free motion and kicks", HUES["purple"], ("chin4a", "pmlf4", "pmlf6")),
    Family("Moser–Veselov", HUES["violet"], ("dmv2", "dmv10")),
    Family("exponential", HUES["orange"], ("etd4",)),
    Family("midpoint rule", NEUTRAL, ("midpoint",)),
)
"""The families of the methods."""

OTHERS = HUES["sky"]
"""Colour of own schemes, and of methods of another version in a report from a file."""

TOP = 3.0
"""Upper limit of the axis of errors: a larger error of an attitude has no meaning."""

LEAST = 1e-17
"""An error of zero is drawn here in its growth."""

LABELS = {"energy": "energy, relative", "momentum": "momentum, relative", "phase": "phase, rad"}

NAME_SIZE = 8.5
"""Size of the names of families (points)."""

ROOM = 3.0
"""A name is as well off with so much room, in half widths, as with more."""


def plot_report(report: ReportData, *, ax: Axes | None = None) -> Any:
    """Draw error against processor time, both axes logarithmic.

    Each method has a pale line. The best of a family of methods has a line in a colour, with the
    name of the family; the Pareto front of all methods is the broad line, with the names of the
    methods that begin there to be the best. Nothing is known in the hatched region below the
    uncertainty of the reference. Slow families may end beyond the right edge.

    Over revolutions a grid of axes, in the place of ``ax``, shows the errors of energy, momentum
    and phase: above against time, below their growth in about the same time.

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
    ax = axes_to_draw_on(ax)
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
    errors, spec, reference = known_errors(report), report.spec, report.reference
    figure.set_size_inches(4.0 * len(errors), 8.0)
    grid: NDArray[Any] = figure.subplots(2, len(errors), squeeze=False)
    figure.suptitle(_title(report), x=0.01, ha="left", fontsize="medium")
    most = time_text(spec.time_of(report.common_time))
    for (upper, lower), name in zip(grid.T, errors, strict=True):
        over = f"over {in_short(report.horizon)} revolutions"
        upper.set_title(f"error of the {LABELS[name]}, {over}", fontsize="small")
        upper.set_xlabel("processor time per body and revolution (ns)", fontsize="small")
        lower.set_xlabel(f"revolutions, in at most {most} ns each", fontsize="small")
        known = None
        if name == "phase" and reference.method:
            known = replace(reference, uncertainty=reference.worst)
        times = [spec.time_of(row.nanoseconds) for row in report.rows] or [1.0]
        lines = _lines(report, ERRORS[name], spec.time_of)
        _draw_trade_off(upper, lines, reference=known, times=(min(times), max(times)))
        _draw_growth(lower, report, ERRORS[name])
        for one in (upper, lower):
            one.tick_params(labelsize="small")
    return grid


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
    lines: dict[Row, Points] = {}
    best: dict[Family, Row] = {}
    for row in report.at_common_time():
        lines[row] = [
            (one.revolutions, max(getattr(one, error), LEAST))
            for one in report.growth(row)
            if getattr(one, error) < 1.0
        ]
    lines = {row: points for row, points in lines.items() if points}

    def rank(row: Row) -> tuple[float, int]:
        at_horizon = [y for x, y in lines[row] if x == report.horizon]
        return min(at_horizon, default=math.inf), -len(lines[row])

    for row in sorted(lines, key=rank):
        best.setdefault(family_of(row.method), row)
    if not best:
        return
    for points in lines.values():
        ax.plot(*np.transpose(points), color=on_ground(ax, PALE), linewidth=0.9, zorder=1.0)
    errors = [error for points in lines.values() for _, error in points]
    counts = report.spec.revolutions
    ax.set_xlim(counts[0] / 1.5, counts[-1] * 1.5)
    ax.set_ylim(min(errors) / 3.0, min(3.0 * max(errors), TOP))
    ordered = [family for family in _families(report.methods) if family in best]
    _draw_families(ax, {family: lines[best[family]] for family in ordered})


def _log_axes(ax: Axes) -> None:
    ax.set(xscale="log", yscale="log")
    ax.grid(visible=True, which="major", color=on_ground(ax, GRID), linewidth=0.8)
    ax.set_axisbelow(True)


def _draw_trade_off(
    ax: Axes,
    lines: Mapping[str, Points],
    *,
    reference: Reference | None = None,
    times: tuple[float, float] | None = None,
) -> None:
    """Draw error against time of each method, the best of families, and the Pareto front.

    The plot is hatched below the uncertainty of the reference. ``times`` are the least and the
    largest; by default slow families do not stretch the axis.
    """
    _log_axes(ax)
    known = {method: _drawable(points) for method, points in lines.items()}
    best = {
        family: front
        for family in _families(known)
        if (front := _front(known, [name for name in known if family_of(name) == family]))
    }
    if not best:
        return
    front = _front(known, [method for method in known if method != EXACT])
    if times is None:
        ends = sorted(line[-1][0] for line in best.values())
        slowest = max([ends[len(ends) // 2], *(time for time, _, _ in front[-1:])])
        times = min(line[0][0] for line in best.values()), slowest
    unknown = math.inf if reference is None else min(reference.uncertainty, 1.0)
    low = 0.1 * min(unknown, *(line[-1][1] for line in best.values()))
    ax.set_xlim(0.4 * times[0], 2.0 * times[1])
    ax.set_ylim(low, TOP)
    if reference is not None:
        _hatch(ax, low, unknown, reference.method)
    for points in filter(None, known.values()):
        ax.plot(*np.transpose(points), color=on_ground(ax, PALE), linewidth=0.9, zorder=1.0)
    names = _draw_front(ax, front) if front else []
    _draw_families(
        ax, {family: [point[:2] for point in line] for family, line in best.items()}, names
    )


def _draw_front(ax: Axes, front: Sequence[tuple[float, float, str]]) -> list[Name]:
    """Draw the Pareto front, with the name of a method where it begins to be the best."""
    points = [point[:2] for point in front]
    ax.plot(
        *np.transpose(points),
        color=on_ground(ax, BAND),
        linewidth=8.0,
        solid_capstyle="round",
        solid_joinstyle="round",
        zorder=2.0,
        label="Pareto front",
    )
    names: list[Name] = []
    before = None
    for (_, _, method), place in zip(front, _in_axes(ax, points), strict=True):
        half = _half(ax, method, 0.8 * NAME_SIZE)
        corner = place - half - [0.006, 0.008]  # nothing of the front is to the left and below
        if method != before and not _clashes(corner, half, names) and (corner > half).all():
            _write(ax, method, corner, on_ground(ax, family_of(method).colour), 0.8 * NAME_SIZE)
            names.append((corner, half))
        before = method
    return names


def _draw_families(ax: Axes, lines: Mapping[Family, Points], names: Sequence[Name] = ()) -> None:
    """Draw a line for each family, with its name on it, where no other name is.

    The name is written where it covers no other line, if there is such a place.
    """
    for family, points in lines.items():
        ax.plot(
            *np.transpose(points),
            color=on_ground(ax, family.colour),
            linewidth=1.8,
            marker="*" if EXACT in family.members else "o",
            markersize=10.0 if EXACT in family.members else 3.5,
            zorder=3.0,
            label=family.name,
        )
    paths = {family: _path(_in_axes(ax, line)) for family, line in lines.items()}
    names = list(names)
    for family, path in paths.items():
        half = _half(ax, family.name, NAME_SIZE)
        others = [other for other in paths.values() if other is not path]
        place = _place(path, half, np.concatenate([*others, path[:0]]), names)
        if place is not None:
            _write(ax, family.name, place, on_ground(ax, family.colour), NAME_SIZE)
            names.append((place, half))


def family_of(method: str) -> Family:
    """The family of a method; an own scheme is a family by itself."""
    own = Family(method, OTHERS, (method,))
    return next((family for family in FAMILIES if method in family.members), own)


def _families(methods: Iterable[str]) -> list[Family]:
    """All families, in the order of the pictures."""
    return list(dict.fromkeys([*FAMILIES, *map(family_of, methods)]))


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


def _place(path: Floats, half: Floats, others: Floats, names: Sequence[Name]) -> Floats | None:
    """Where on a path a name covers the least of other lines, far from them if there is room."""
    best, least = None, math.inf
    inside = ((path >= 0.0) & (path <= 1.0)).all(axis=1)
    for place in np.clip(path[inside], half, 1.0 - half):
        if _clashes(place, half, names):
            continue
        distance = (np.abs(others - place) / half).max(axis=1)
        cost = float((distance < 1.0).sum()) - float(distance.min(initial=ROOM))
        if cost < least:
            best, least = place, cost
    return best


def _clashes(place: Floats, half: Floats, names: Iterable[Name]) -> bool:
    return any(bool((np.abs(place - at) < half + of).all()) for at, of in names)


def _half(ax: Axes, text: str, size: float) -> Floats:
    """About half the width and height of a text, in shares of the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    inches = np.array([0.29 * len(text), 0.7]) * size / 72.0
    half: Floats = inches / figure.get_size_inches() / ax.get_position().size
    return half


def _write(ax: Axes, text: str, place: Floats, colour: str, size: float) -> None:
    x, y = place.tolist()
    ax.text(
        x,
        y,
        text,
        transform=ax.transAxes,
        color=colour,
        fontsize=size,
        ha="center",
        va="center",
        zorder=4.0,
        bbox={"facecolor": ground(ax), "edgecolor": "none", "pad": 0.6, "alpha": 0.85},
    )


def _in_axes(ax: Axes, points: Points) -> Floats:
    """Points in shares of the axes."""
    low, high = np.log([ax.get_xlim(), ax.get_ylim()]).T
    places: Floats = (np.log(points) - low) / (high - low)
    return places


def _path(corners: Floats) -> Floats:
    """Places along a line, but not at its ends; around the only point of a short one."""
    if len(corners) == 1:
        around: Floats = corners + np.array([[0.0, 0.04], [0.0, -0.04], [0.15, 0.0], [-0.15, 0.0]])
        return around
    share = np.linspace(0.15, len(corners) - 1.15, 40 * len(corners))
    k = np.arange(len(corners))
    return np.stack([np.interp(share, k, column) for column in corners.T], axis=1)


def _title(report: ReportData) -> str:
    spec = report.spec
    which, title = "median", spec.title or "Error against run time"
    bands = "grey band: Pareto front"
    if spec.revolutions:
        which, title = "largest", f"{spec.title or spec.scene.words()}: the long run"
        bands = "grey bands: Pareto fronts"
    cpu, isa = report.machine.get("cpu", "?"), report.machine.get("isa")
    detail = f"{which} of {spec.bodies} bodies, one core of {cpu}{f' ({isa})' if isa else ''}"
    if not report.complete:
        detail += "; partial"
    return f"{title}\n{detail}; {bands}"
