"""Pictures of stability maps. Nothing global is set, and no display is needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_of
from ..drawing.figure import shown_figure
from ..model.criteria import Regular
from .data import MapData
from .parameters import Axis
from .theory import Curve, Theory, predict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_map"]

UNDECIDED = 0.05
"""Cells with more than this share of undecided (or of failed) bodies are hatched."""

# Only the strokes of failed and undecided cover the colour of the share. Red and vermilion contrast
# with both ends of the colour scale, and the shapes tell them apart.
_HATCHED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("impossible body", {"facecolor": "0.88", "edgecolor": "0.62", "hatch": "xx"}),
    ("not computed", {"facecolor": "white", "edgecolor": "0.75", "hatch": "\\\\\\"}),
    ("failed > 5 %", {"facecolor": "none", "edgecolor": "#cc3311", "hatch": "oo"}),
    ("undecided > 5 %", {"facecolor": "none", "edgecolor": "#d55e00", "hatch": "////"}),
)
_DASHES: tuple[Literal["solid", "dashed"], ...] = ("solid", "dashed")


def plot_map(
    data: MapData, *, ax: Axes | None = None, cells: bool = False, what: str = "share"
) -> Axes:
    """Draw a stability map: colour for the share of stable bodies, hatches where it is misleading.

    Cells are centred on the values of the axes, in the scale that is drawn: logarithmic where the
    values are geometric. Lines are the predictions of theory. A map with one axis is drawn as the
    share with its 95 % interval.

    Parameters
    ----------
    data : MapData
        The map to draw.
    ax : matplotlib Axes, optional
        Axes to draw on; by default those of a new figure.
    cells : bool
        Draw the borders of the cells of a refined map.
    what : {"share", "cost"}
        The share of stable bodies, or the processor time of each pixel (s).

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.HeavyTop, axes={"spin": np.linspace(3.0, 5.0, 9)}, samples=10, t_end=50.0,
    ...     stable=rigid.tilt_below(0.5), rng=2026,
    ... )
    >>> result.plot().figure.savefig("map.png")  # doctest: +SKIP
    """
    one_of("what", what, ("share", "cost"))
    if ax is None:
        ax = shown_figure().add_subplot()
    if what == "cost":
        handles = _draw_cost(data, ax)
    else:
        draw = _draw_plane if len(data.spec.axes) == 2 else _draw_line
        handles = draw(data, ax, predict(data.spec))
    if cells and len(data.spec.axes) == 2:
        _draw_cells(data, ax)
    _set_scale(ax, "x", data.spec.axes[0])
    ax.set_xlabel(data.spec.axes[0].label)
    ax.set_title(_title(data), loc="left", fontsize="medium")
    if handles:
        ax.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(0.0, -0.12),
            borderaxespad=0.0,
            ncols=2,
            frameon=False,
            fontsize="small",
        )
    return ax


def _draw_plane(data: MapData, ax: Axes, theory: Theory | None) -> list[Any]:
    x, y = data.spec.axes
    edges = _edges(x), _edges(y)
    _set_scale(ax, "y", y)
    ax.set_ylabel(y.label)
    mesh = ax.pcolormesh(
        *edges, np.ma.masked_invalid(data.filled), cmap="cividis", vmin=0, vmax=1, rasterized=True
    )
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.set_label(_share_label(data))
    handles = _hatch(data, ax, *edges)
    for curve, dashes in zip(theory.curves if theory else (), _DASHES, strict=False):
        handles += _draw_curve(data, ax, curve, dashes)
    return handles


def _draw_cost(data: MapData, ax: Axes) -> list[Any]:
    """Processor time of each pixel; white where it is not known."""
    seconds = 1e-9 * np.where(data.samples > 0, data.nanoseconds, np.nan)
    label = "processor time of a pixel (s)"
    if len(data.spec.axes) == 1:
        ax.plot(data.spec.axes[0].values, seconds, color="#0072b2", marker=".")
        ax.set_ylabel(label)
        return []
    x, y = data.spec.axes
    _set_scale(ax, "y", y)
    ax.set_ylabel(y.label)
    mesh = ax.pcolormesh(
        _edges(x), _edges(y), np.ma.masked_invalid(seconds), cmap="cividis", rasterized=True
    )
    ax.figure.colorbar(mesh, ax=ax, pad=0.02).set_label(label)
    return []


def _draw_cells(data: MapData, ax: Axes) -> None:
    """The borders of the cells of a refined map, through the pixels that are their corners."""
    from matplotlib.collections import LineCollection

    x, y = (np.array(axis.values) for axis in data.spec.axes)
    top, bottom, left, right = data.cells.T
    turns = ((left, top), (right, top), (right, bottom), (left, bottom), (left, top))
    outlines = np.stack([np.stack([x[column], y[row]], axis=1) for column, row in turns], axis=1)
    ax.add_collection(LineCollection(list(outlines), colors="white", linewidths=0.3, alpha=0.6))


def _draw_curve(
    data: MapData, ax: Axes, curve: Curve, dashes: Literal["solid", "dashed"]
) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import Normal, Stroke

    x, y = data.spec.axes
    if min(curve.field.shape) < 2:
        return []  # no plane to draw a line in
    lines = ax.contour(
        x.values, y.values, curve.field, levels=[0.0], colors="white", linestyles=dashes
    )
    if not any(len(path) for path in lines.get_paths()):
        return []  # between pixels, or where theory does not reach
    handle = Line2D([], [], color="white", linestyle=dashes, label=f"theory: {curve.label}")
    for artist in (lines, handle):
        artist.set(linewidth=1.6)
        artist.set_path_effects([Stroke(linewidth=3.4, foreground="black"), Normal()])
    return [handle]


def _draw_line(data: MapData, ax: Axes, theory: Theory | None) -> list[Any]:
    (axis,) = data.spec.axes
    values = np.array(axis.values)
    edges = _edges(axis)
    band = ax.fill_between(
        values, data.lower, data.upper, color="#0072b2", alpha=0.25, linewidth=0.0
    )
    band.set_label("95 % interval")
    (line,) = ax.plot(values, data.share, color="#0072b2", marker=".", label="share")
    handles: list[Any] = [line, band]
    if theory:
        handles += ax.plot(values, theory.share, "--", color="black", lw=1.2, label="theory")
    handles += _hatch(data, ax, edges, np.array([-0.02, 1.02]))
    ax.set_ylim(-0.02, 1.02)
    ax.set_ylabel(_share_label(data))
    return handles


def _hatch(data: MapData, ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64]) -> list[Any]:
    """Hatch cells that are impossible, not computed, or hold many failed or undecided bodies."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    impossible = data.status != 0
    marked = (
        impossible,
        ~impossible & (data.samples == 0) & np.isnan(data.filled),
        data.failed > UNDECIDED * data.samples,
        data.undecided > UNDECIDED * data.samples,
    )
    handles = []
    for (label, style), cells in zip(_HATCHED, marked, strict=True):
        if cells.any():
            # One path for all: hatching thousands of cells one by one takes seconds.
            path = Path.make_compound_path_from_polys(_rectangles(np.atleast_2d(cells), x, y))
            handles.append(ax.add_patch(PathPatch(path, linewidth=0.0, label=label, **style)))
    return handles


def _rectangles(
    cells: NDArray[np.bool_], x: NDArray[np.float64], y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Corners of the horizontal runs of marked cells, shape (n, 4, 2)."""
    steps = np.diff(cells.astype(np.int8), axis=1, prepend=0, append=0)
    row, left = np.nonzero(steps == 1)
    right = np.nonzero(steps == -1)[1]
    across = x[np.stack([left, right, right, left], axis=1)]
    upward = y[np.stack([row, row, row + 1, row + 1], axis=1)]
    return np.stack([across, upward], axis=-1)


def _edges(axis: Axis) -> NDArray[np.float64]:
    """Cell borders half-way between the values, in the scale that is drawn; shape (n + 1,)."""
    values = np.array(axis.values)
    if values.size == 1:
        half_width = 0.5 * abs(values[0]) or 0.5
        return np.array([values[0] - half_width, values[0] + half_width])
    centres = np.log(values) if axis.geometric else values
    half = 0.5 * np.diff(centres)
    ends = centres[0] - half[0], centres[-1] + half[-1]
    edges: NDArray[np.float64] = np.array([ends[0], *(centres[:-1] + half), ends[1]])
    return np.exp(edges) if axis.geometric else edges


def _set_scale(ax: Axes, which: str, axis: Axis) -> None:
    edges = _edges(axis)
    scale = "log" if axis.geometric else "linear"
    ax.set(**{f"{which}scale": scale, f"{which}lim": (edges.min(), edges.max())})


def _share_label(data: MapData) -> str:
    spec = data.spec
    if isinstance(spec.stable, Regular):
        return f"share {spec.criterion}"
    return f"share stable until t = {spec.t_end:g} s"


def _title(data: MapData) -> str:
    spec = data.spec
    bodies = "1 body" if spec.samples == 1 else f"{spec.samples} bodies"
    if spec.half_width is not None:
        bodies = f"64 to {bodies}"
    detail = f"stable: {spec.criterion}; {bodies} per pixel"
    if not data.complete:
        detail += f"; stopped after {data.samples.sum():,} bodies"
    what = "Regular motions" if isinstance(spec.stable, Regular) else "Stability"
    return f"{spec.title or f'{what} of a {spec.scene.title}'}\n{detail}"
