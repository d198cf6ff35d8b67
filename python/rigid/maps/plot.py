"""Pictures of stability maps. Nothing global is set, and no display is needed."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, finite_float, nearest
from .._checks.arrays import Floats
from ..drawing import colours
from ..drawing.along import write_along
from ..drawing.colours import on_ground
from ..drawing.figure import SMALL, axes_to_draw_on, shown_figure
from ..model.criteria import Regular
from ..solve.methods import AUTO
from .axes import Axis
from .data import MapData
from .measured import NUMBERS, Measures
from .spec import MapSpec
from .theory import Curve, Theory, predict
from .words import axis_label, class_words, default_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes


SHARE, COST = "share", "cost"
"""The quantity drawn by default, and the processor time."""

GROWTH = {
    "exponent": ("mean exponent", "1/s"),
    "mean_megno": ("mean of the mean MEGNO", "1"),
    "largest_exponent": ("largest exponent", "1/s"),
}
"""Quantities of maps of :func:`rigid.regular`, with their names and units."""

FINER = 4
"""Most steps in each cell of the grid on which lines of theory are drawn."""

FINEST = 2**19
"""Most cells of that grid, unless the map has more pixels: the prediction takes 200 MB for them."""

LONGEST = 76
"""Most letters of a line of the title: as many as fit above a picture and its bar of colours."""

LETTERS = 30
"""Most letters of an entry of a legend with two columns."""

UNDECIDED, MANY = 0.05, " > 5 %"
"""Cells with more than this share of undecided (or of failed) bodies are hatched."""

# Only the strokes of failed and undecided cover the colour of the share; shapes tell them apart.
_HATCHED = (
    ("impossible body", *colours.IMPOSSIBLE, "xx"),
    ("not computed", *colours.ABSENT, "\\\\\\"),
    ("failed" + MANY, "none", colours.FAILED, "oo"),
    ("undecided" + MANY, "none", colours.UNDECIDED, "////"),
)
_Dashes: TypeAlias = Literal["solid", "dashed", "dashdot", "dotted"]
DASHES: tuple[_Dashes, ...] = ("solid", "dashed", "dashdot", "dotted")
"""Of the lines of theory, in their order; further lines are not drawn."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """The drawn part of a map: the whole map, or a slice along one or two of its axes."""

    data: MapData
    index: tuple[int | slice, ...]
    at: Mapping[int, int]
    axes: tuple[Axis, ...]
    theory: Theory | None

    @classmethod
    def of(cls, data: MapData, theory: Theory | None, at: Mapping[int, int]) -> View:
        """The slice at these places of these axes, by their numbers."""
        axes = data.spec.axes
        index = tuple(at.get(k, slice(None)) for k in reversed(range(len(axes))))
        if theory is not None:
            curves = tuple(replace(one, field=one.field[index]) for one in theory.curves)
            theory = Theory(theory.label, theory.share[index], curves)
        free = tuple(axis for k, axis in enumerate(axes) if k not in at)
        return cls(data=data, index=index, at=at, axes=free, theory=theory)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The drawn part of an array of the map."""
        part: NDArray[Any] = getattr(self.data, name)[self.index]
        return part


def plot_map(
    data: MapData,
    *,
    ax: Axes | None,
    cells: bool,
    what: str,
    at: Mapping[str, float] | None,
) -> Axes | NDArray[np.object_]:
    """Draw a stability map: colour for the share of stable bodies, hatches where it misleads.

    Cells are centred on the values of the axes, in the scale that is drawn: logarithmic where the
    values are geometric. Lines are the predictions of theory. A map with one axis is drawn as the
    share with its 95 % interval. A map with one body in each pixel has two classes and no shares,
    unless it is refined: swatches name them. A map with three or four axes is drawn as small
    pictures of its first two, side by side for the values of the third and one below the other for
    the values of the fourth.

    Parameters
    ----------
    data : MapData
        The map to draw.
    ax : matplotlib Axes, optional
        Axes to draw on; by default the axes of a new figure.
    cells : bool
        Draw the borders of the cells of a refined map.
    what : str, optional
        ``"share"``; ``"cost"``: the processor time of each pixel (s); or a number of a measure:
        ``"mean of flips"``; ``std``, ``least``, ``largest``, ``count``, ``error`` or ``median`` in
        place of ``mean``, or ``"quantile 0.9 of flips"``; or of a map of :func:`rigid.regular`
        ``"exponent"``, ``"mean_megno"`` or ``"largest_exponent"``. Lines of theory belong to the
        share.
    at : dict of str to float, optional
        Values of axes, by their names: the slice of the map there is drawn.

    Returns
    -------
    matplotlib Axes, or an ndarray of them
        The array, of shape (values of the fourth axis, values of the third), for small pictures.

    Raises
    ------
    ImportError
        Without matplotlib.
    ValueError
        If the map has no such axis or value, more axes are left than can be drawn, or ``what`` is
        nothing that the map has.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.HeavyTop, axes={"spin": np.linspace(3.0, 5.0, 9)}, samples=10, t_end=50.0,
    ...     stable=rigid.tilt_below(0.5), rng=2026,
    ... )
    >>> result.plot().figure.savefig("map.png")  # doctest: +SKIP
    """
    field, label = _field(data, what)
    fixed = _places(data, at or {})
    free = [k for k in range(len(data.spec.axes)) if k not in fixed]
    theory = predict(data.spec)
    if len(free) <= 2:
        ax = axes_to_draw_on(ax, SMALL)
        view = View.of(data, theory, fixed)
        shown = None if field is None else field[view.index]
        _draw(view, ax, _title(data, fixed), shown, label)
        if cells and len(view.axes) == len(data.spec.axes) == 2:
            _draw_cells(data, ax)
        return ax
    single = ax is not None or what != SHARE
    if single or len(free) > 4:
        names = ", ".join(data.spec.axes[k].name for k in free[2:])
        raise ValueError(
            f"at: must give values of {names}: "
            + ("one picture shows two axes" if single else "small pictures show four axes")
        )
    return _small_pictures(data, theory, fixed, free)


def _places(data: MapData, at: Mapping[str, float]) -> dict[int, int]:
    """Number and place of each axis that is fixed."""
    axes = data.spec.axes
    names = [axis.name for axis in axes]
    fixed = {}
    for name, value in at.items():
        if name not in names:
            raise ValueError(f"at: {name!r} is no axis of the map{nearest(name, names)}")
        values = np.array(axes[names.index(name)].values)
        wanted = finite_float(f"at[{name!r}]", value)
        place = int(np.argmin(np.abs(values - wanted)))
        if abs(values[place] - wanted) > 1e-9 * np.abs(values).max():
            raise ValueError(
                f"at[{name!r}] = {wanted:g}: is no value of the axis; the nearest is "
                f"{values[place]:g}"
            )
        fixed[names.index(name)] = place
    if len(fixed) == len(axes):
        raise ValueError("at: must leave an axis to draw")
    return fixed


def _small_pictures(
    data: MapData, theory: Theory | None, fixed: Mapping[int, int], free: Sequence[int]
) -> NDArray[np.object_]:
    """A picture of the first two free axes for each value of the others."""
    across, *down = free[2:]
    columns = len(data.spec.axes[across].values)
    rows = len(data.spec.axes[down[0]].values) if down else 1
    figure: Any = shown_figure()
    figure.set_size_inches(max(8.0, 2.6 * columns), max(3.2, 2.4 * rows) + 0.8)
    panels: NDArray[np.object_] = figure.subplots(
        rows, columns, squeeze=False, sharex=True, sharey=True
    )
    mesh: Any = None
    handles: dict[Any, Any] = {}
    for row, column in np.ndindex(rows, columns):
        here = {across: column, **({down[0]: row} if down else {})}
        view = View.of(data, theory, {**fixed, **here})
        panel: Any = panels[row, column]
        mesh, found = _plane(view, panel, named=False)
        handles |= {handle.get_label(): handle for handle in found}
        panel.set_title(_values(data, here), fontsize="small")
    figure.supxlabel(axis_label(data.spec, data.spec.axes[free[0]]))
    figure.supylabel(axis_label(data.spec, data.spec.axes[free[1]]))
    figure.suptitle(_title(data, fixed), x=0.01, ha="left", fontsize="medium")
    swatches = _classes(data)
    if not swatches:
        figure.colorbar(mesh, ax=panels, pad=0.02).set_label(_share_label(data))
    if shown := swatches + list(handles.values()):
        figure.legend(
            handles=shown,
            loc="outside lower left",
            handlelength=3.0,
            ncols=2,
            frameon=False,
            fontsize="small",
        )
    return panels


def _values(data: MapData, at: Mapping[int, int]) -> str:
    """The values of some axes in words."""
    axes = data.spec.axes
    return ", ".join(
        f"{axes[k].name} = {axes[k].values[place]:g}"
        + ("" if axes[k].unit == "1" else f" {axes[k].unit}")
        for k, place in at.items()
    )


def check_what(spec: MapSpec, what: str) -> None:
    """Raise ValueError if the picture of a map cannot show this quantity."""
    if what != SHARE and len(spec.axes) > 2:
        raise ValueError(f"what = {brief(what)}: a picture of more than two axes shows the share")
    if what in GROWTH:
        if not spec.stable.has_deviation:
            raise ValueError(f"what = {what!r}: needs a map with the criterion rigid.regular()")
    elif what not in (SHARE, COST):
        _measured(Measures(spec.measure, None, spec.shape), what)


def _field(data: MapData, what: object) -> tuple[Floats | None, str]:
    """The drawn quantity if it is not the share, and its label."""
    if what == SHARE:
        return None, ""
    if what == COST:
        known = np.where(data.samples > 0, data.nanoseconds, np.nan)
        return 1e-9 * known, "processor time of a pixel (s)"
    if isinstance(what, str) and what in GROWTH:
        check_what(data.spec, what)
        name, unit = GROWTH[what]
        field = np.asarray(getattr(data, what), dtype=np.float64)
    else:
        field, name, unit = _measured(data.measures, what)
    unit, factor = data.spec.clock.shown(unit)
    return factor * field, name if unit == "1" else f"{name} ({unit})"


def _measured(measures: Measures, what: object) -> tuple[Floats, str, str]:
    """A number of a measure, its name and its unit."""
    pattern = rf"({'|'.join(NUMBERS)}|median|quantile (\S+)) of (.+)"
    found = re.fullmatch(pattern, str(what))
    if found is None or not isinstance(what, str):
        one = next(iter(measures), "flips")
        raise ValueError(
            f"what = {brief(what)}: must be one of 'share', 'cost', 'exponent', 'mean_megno', "
            f"'largest_exponent', or such as 'mean of {one}' or 'quantile 0.9 of {one}'"
        )
    number, share, name = found.groups()
    try:
        measured = measures[name]
    except KeyError as error:
        raise ValueError(f"what = {brief(what)}: {error.args[0]}") from None
    if number == "median" or share is not None:
        try:
            field = measured.quantile(0.5 if share is None else float(share))
        except ValueError:
            raise ValueError(f"what = {brief(what)}: a quantile lies in [0, 1]") from None
    else:
        field = np.asarray(getattr(measured, number), dtype=np.float64)
    return field, what, "1" if number == "count" else measured.measure.unit


def _draw(view: View, ax: Axes, title: str, field: Floats | None, label: str) -> None:
    if field is not None:
        handles = _draw_field(view, ax, field, label)
    else:
        handles = _draw_plane(view, ax) if len(view.axes) == 2 else _draw_line(view, ax)
    _set_scale(ax, "x", view.axes[0])
    ax.set_xlabel(axis_label(view.data.spec, view.axes[0]))
    ax.set_title(title, loc="left", fontsize="medium")
    if handles:
        ax.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(0.0, -0.12),
            borderaxespad=0.0,
            handlelength=3.0,
            ncols=2 if max(len(str(handle.get_label())) for handle in handles) <= LETTERS else 1,
            frameon=False,
            fontsize="small",
        )


def _draw_plane(view: View, ax: Axes) -> list[Any]:
    mesh, handles = _plane(view, ax)
    ax.set_ylabel(axis_label(view.data.spec, view.axes[1]))
    if swatches := _classes(view.data):
        return swatches + handles
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.set_label(_share_label(view.data))
    return handles


def _classes(data: MapData) -> list[Any]:
    """A swatch for each of the two classes, where each pixel has one body and so no share."""
    from matplotlib.patches import Patch

    # Between the corners of cells of a refined map, shares are interpolated.
    if data.spec.samples > 1 or data.spec.refine is not None:
        return []
    words = class_words(data.spec)
    return [
        Patch(facecolor=face, edgecolor=colours.NEUTRAL, linewidth=0.8, label=words[name])
        for name, face in (("stable", colours.STABLE), ("unstable", colours.UNSTABLE))
    ]


def _plane(view: View, ax: Axes, *, named: bool = True) -> tuple[Any, list[Any]]:
    """The colours and the hatches of a plane, and the lines of theory, ``named`` along them."""
    from matplotlib import colormaps

    shares = colormaps[colours.SHARE_MAP].with_extremes(bad=colours.SURFACE)
    mesh, handles = _mesh(view, ax, view["filled"], cmap=shares, vmin=0, vmax=1)
    return mesh, handles + _draw_curves(view, ax, named=named)


def _mesh(view: View, ax: Axes, values: Floats, **how: Any) -> tuple[Any, list[Any]]:
    """Numbers of the pixels of a plane as colours, with their hatches."""
    x, y = view.axes
    edges = cell_edges(x), cell_edges(y)
    _set_scale(ax, "x", x)
    _set_scale(ax, "y", y)
    mesh = ax.pcolormesh(*edges, np.ma.masked_invalid(values), rasterized=True, **how)
    return mesh, _hatch(view, ax, *edges)


def _draw_field(view: View, ax: Axes, field: Floats, label: str) -> list[Any]:
    """Numbers of the pixels; white where there are none."""
    x = view.axes[0]
    if len(view.axes) == 1:
        ax.plot(np.array(x.values), field, color=on_ground(ax, colours.HUES["blue"]), marker=".")
        ax.set_ylabel(label)
        return _hatch(view, ax, cell_edges(x), np.array(ax.get_ylim()))
    growth = any(label.startswith(name) for name, _ in GROWTH.values())
    cmap = colours.CHAOS_MAP if growth else colours.NUMBER_MAP
    mesh, handles = _mesh(view, ax, field, cmap=cmap)
    ax.set_ylabel(axis_label(view.data.spec, view.axes[1]))
    ax.figure.colorbar(mesh, ax=ax, pad=0.02).set_label(label)
    return handles


def _draw_cells(data: MapData, ax: Axes) -> None:
    """The borders of the cells of a refined map, through the pixels that are their corners."""
    from matplotlib.collections import LineCollection

    x, y = (np.array(axis.values) for axis in data.spec.axes)
    top, bottom, left, right = data.cells.T
    turns = ((left, top), (right, top), (right, bottom), (left, bottom), (left, top))
    outlines = np.stack([np.stack([x[column], y[row]], axis=1) for column, row in turns], axis=1)
    ax.add_collection(LineCollection(list(outlines), colors="white", linewidths=0.3, alpha=0.6))


def fine_curves(view: View) -> tuple[tuple[Axis, ...], tuple[Curve, ...]]:
    """The lines of theory, and the axes of their points: finer than the pixels, up to the edges."""
    spec = view.data.spec
    if view.theory is None or not view.theory.curves:
        return view.axes, ()
    if spec.own is not None or min(len(axis.values) for axis in view.axes) < 2:
        return view.axes, view.theory.curves  # a function of the user is called for pixels only
    steps = min(FINER, max(math.isqrt(FINEST // view["share"].size), 1))
    axes = tuple(
        replace(axis, values=(axis.values[view.at[k]],) if k in view.at else _finer(axis, steps))
        for k, axis in enumerate(spec.axes)
    )
    try:
        theory = predict(spec.replace(axes=axes, method=AUTO, refine=None, budget=None))
    except ValueError:  # an edge is no value, such as the moment of a rod that would spin
        return view.axes, view.theory.curves
    drawn = tuple(axis for k, axis in enumerate(axes) if k not in view.at)
    shape = tuple(len(axis.values) for axis in reversed(drawn))
    curves = () if theory is None else theory.curves
    return drawn, tuple(replace(one, field=one.field.reshape(shape)) for one in curves)


def _finer(axis: Axis, steps: int) -> tuple[float, ...]:
    """Values from edge to edge, so many steps in each cell; those that the axis allows."""
    edges = cell_edges(axis)
    places = np.arange(steps * len(axis.values) + 1) / steps
    marks = np.log(edges) if axis.geometric else edges
    fine = np.interp(places, np.arange(len(edges)), marks)
    values = np.exp(fine) if axis.geometric else fine
    return tuple(values[~axis.parameter.rejects(values)].tolist())


def _draw_curves(view: View, ax: Axes, *, named: bool) -> list[Any]:
    """The lines of theory, each with its name along it; in the legend if there is no place."""
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import Normal, Stroke

    axes, curves = fine_curves(view)
    drawn: dict[str, tuple[Any, list[Floats]]] = {}
    for curve in curves:
        if min(curve.field.shape) < 2:
            continue  # no plane to draw a line in
        x, y = (axis.values for axis in axes)
        lines = ax.contour(x, y, curve.field, levels=[0.0], colors="white", linewidths=1.6)
        (path,) = lines.get_paths()
        corners = np.asarray(path.vertices)
        if not len(corners):
            continue  # between pixels, or where theory does not reach
        begins = np.flatnonzero(path.codes == path.MOVETO)[1:]
        drawn[curve.label] = lines, np.split(corners, begins)
    # A black line below the dashes too: dashes alone read as equality signs in a legend.
    below = Stroke(
        linewidth=3.4, foreground="black", dashes={"dash_offset": 0.0, "dash_list": None}
    )
    handles: list[Any] = []
    names: list[Floats] = []
    for label, (lines, paths) in drawn.items():
        lines.set_path_effects([below, Normal()])
        others = [path for other, (_, its) in drawn.items() if other != label for path in its]
        name = write_along(ax, label, paths, others + names) if named else None
        if name is not None:
            names.append(name)
            continue
        dashes = DASHES[len(handles) % len(DASHES)]
        lines.set_linestyle(dashes)
        handle = Line2D(
            [], [], color="white", linestyle=dashes, linewidth=1.6, label=f"theory: {label}"
        )
        handle.set_path_effects([below, Normal()])
        handles.append(handle)
    return handles


def _draw_line(view: View, ax: Axes) -> list[Any]:
    (axis,) = view.axes
    values = np.array(axis.values)
    edges = cell_edges(axis)
    blue, black = (on_ground(ax, colours.HUES[name]) for name in ("blue", "black"))
    band = ax.fill_between(
        values, view["lower"], view["upper"], color=blue, alpha=0.25, linewidth=0.0
    )
    band.set_label("95 % interval")
    (line,) = ax.plot(values, view["share"], color=blue, marker=".", label="share")
    handles: list[Any] = [line, band]
    if view.theory:
        handles += ax.plot(values, view.theory.share, "--", color=black, lw=1.2, label="theory")
    handles += _hatch(view, ax, edges, np.array([-0.02, 1.02]))
    ax.set_ylim(-0.02, 1.02)
    ax.set_ylabel(_share_label(view.data))
    return handles


def _hatch(view: View, ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64]) -> list[Any]:
    """Hatch cells that are impossible, not computed, or hold many failed or undecided bodies."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    impossible = view["status"] != 0
    marked = (
        impossible,
        ~impossible & (view["samples"] == 0),
        view["failed"] > UNDECIDED * view["samples"],
        view["undecided"] > UNDECIDED * view["samples"],
    )
    handles = []
    for (label, face, strokes, hatch), cells in zip(_HATCHED, marked, strict=True):
        if cells.any():
            if view.data.spec.samples == 1:
                label = label.removesuffix(MANY)
            # One path for all: hatching thousands of cells one by one takes seconds.
            path = Path.make_compound_path_from_polys(_rectangles(np.atleast_2d(cells), x, y))
            style = {
                "facecolor": on_ground(ax, face),
                "edgecolor": on_ground(ax, strokes),
                "hatch": hatch,
            }
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


def cell_edges(axis: Axis) -> NDArray[np.float64]:
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
    edges = cell_edges(axis)
    scale = "log" if axis.geometric else "linear"
    ax.set(**{f"{which}scale": scale, f"{which}lim": (edges.min(), edges.max())})


def _share_label(data: MapData) -> str:
    spec = data.spec
    if isinstance(spec.stable, Regular):
        return "share regular"
    if "t_end" in spec.varied:
        return "share stable until $t_{end}$"
    return f"share stable until {spec.horizon}"


def _title(data: MapData, at: Mapping[int, int]) -> str:
    spec = data.spec
    title = textwrap.fill(spec.title or default_title(spec), LONGEST)
    bodies = "1 body" if spec.samples == 1 else f"{spec.samples} bodies"
    if spec.half_width is not None:
        bodies = f"64 to {bodies}"
    asks = "" if isinstance(spec.stable, Regular) else "stable: "
    lines = [f"{asks}{spec.criterion}", f"{bodies} per pixel"]
    if not data.complete:
        lines[1] += f"; stopped after {data.samples.sum():,} bodies"
    if at:
        lines.append(_values(data, at))
    if len("; ".join(lines)) <= LONGEST:
        lines = ["; ".join(lines)]
    unbroken = [re.sub(r"\bt = (\S+) ", "t\0=\0\\1\0", line) for line in lines]
    filled = [textwrap.fill(line, LONGEST) for line in unbroken]
    return "\n".join([title, *filled]).replace("\0", " ")
