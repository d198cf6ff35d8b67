"""Helpers of all figures: axes with equal scales, arrows, arcs and labels."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..rotations.euler import rotation_y, rotation_z
from ..rotations.so3 import rotate
from . import colours
from .colours import HUES, on_ground

if TYPE_CHECKING:
    from .arrows import PlaneArrow, SpaceArrow


Floats = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])

ELEV, AZIM = 22.0, -60.0
"""The usual view (degrees)."""

KEY: dict[str, Any] = {"frameon": False, "handlelength": 3.0}
"""Style of a legend that belongs to a whole figure."""

BELOW: dict[str, Any] = {**KEY, "loc": "upper center", "bbox_to_anchor": (0.5, -0.12)}
"""Style and place of a legend below its axes."""

FILLED = 0.88
"""Fraction of the axes that the drawing fills; labels need the rest."""


def fit(
    ax: Any,
    *points: Floats,
    elev: float = ELEV,
    azim: float = AZIM,
    filled: float = FILLED,
) -> None:
    """Set view and limits so that the points (..., 3) fill the axes, with equal scales.

    Call it when everything is drawn. Axes in space are square, so points that fill wide or high
    axes leave that square: nothing is cut off at its edge.
    """
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    cloud = np.concatenate([np.reshape(some, (-1, 3)) for some in points])
    # Rows: to the right on the page, upwards, and towards the viewer.
    page = (rotation_z(radians(azim)) @ rotation_y(-radians(elev))).T[[1, 2, 0]]
    seen = cloud @ page.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0)) @ page
    side = max(float(np.ptp(cloud, axis=0).max()), 1e-300)
    ax.set(
        **{
            f"{name}lim": (c - 0.5 * side, c + 0.5 * side)
            for name, c in zip("xyz", middle, strict=True)
        }
    )
    ax.view_init(elev=elev, azim=azim)
    ax.set_box_aspect((1.0, 1.0, 1.0))
    x, y, _ = proj_transform(*cloud.T, ax.get_proj())
    place = ax.get_position(original=True).transformed(ax.figure.transSubfigure)
    wide, high = np.array(place.size) / min(place.size)
    room = wide * ax.viewLim.width / np.abs(x).max(), high * ax.viewLim.height / np.abs(y).max()
    ax.set_box_aspect((1.0, 1.0, 1.0), zoom=0.5 * filled * min(room))
    for artist in (*ax.lines, *ax.collections, *ax.patches, *ax.artists):
        artist.set_clip_on(False)
        artist.set_in_layout(False)


def arrow(
    ax: Any,
    vector: Floats,
    colour: str,
    text: str = "",
    *,
    start: Floats | None = None,
    **style: Any,
) -> SpaceArrow:
    """An arrow in space with its name beyond the tip; invisible if the vector is zero."""
    from .arrows import SpaceArrow

    one = SpaceArrow(np.zeros(3) if start is None else start, vector, **_arrow(ax, colour, style))
    one.set_in_layout(False)
    ax.add_artist(one)
    _finish(one, ax, text, colour)
    return one


def arrow_in_plane(
    ax: Any,
    vector: Floats,
    colour: str,
    text: str = "",
    *,
    start: Floats | None = None,
    **style: Any,
) -> PlaneArrow:
    """An arrow in the plane with its name beyond the tip; invisible if the vector is zero."""
    from .arrows import PlaneArrow

    one = PlaneArrow(np.zeros(2) if start is None else start, vector, **_arrow(ax, colour, style))
    ax.add_patch(one)
    _finish(one, ax, text, colour)
    return one


def _arrow(ax: Any, colour: str, style: dict[str, Any]) -> dict[str, Any]:
    return {"color": on_ground(ax, colour), "linewidth": 2.0, "zorder": 5} | style


def _finish(one: PlaneArrow, ax: Any, text: str, colour: str) -> None:
    """Show and name an arrow, unless its vector is zero and has no direction."""
    one.set_visible(bool(one.vector.any()))
    if text and one.vector.any():
        one.write(ax, text, **_text(ax, colour))


def triad(
    ax: Any, axes: Floats, origin: Floats, names: Sequence[str], **style: Any
) -> tuple[Any, ...]:
    """Three axes with their names, from an origin, in the colours of x, y, z."""
    return tuple(
        arrow(ax, along, ink.colour, name, start=origin, **style)
        for along, ink, name in zip(axes, colours.AXES, names, strict=True)
    )


def label(ax: Any, place: Floats, text: str, colour: str = HUES["black"], **style: Any) -> Any:
    """Text that is centred at a point in space or in the plane, and legible over lines."""
    return ax.text(*place, text, **(_text(ax, colour) | style))


def curve(ax: Any, points: Floats, colour: str, **style: Any) -> Any:
    """A line through points (m, 3) or (m, 2)."""
    (line,) = ax.plot(*points.T, **({"color": on_ground(ax, colour), "linewidth": 1.3} | style))
    return line


def dots(ax: Any, points: Floats, colour: str, **style: Any) -> Any:
    """Dots at points (m, 3) or (m, 2), or at one point."""
    (line,) = ax.plot(*np.atleast_2d(points).T, "o", color=on_ground(ax, colour), **style)
    return line


def cone(ax: Any, rim: Floats, colour: Any, alpha: float, **style: Any) -> Any:
    """The transparent surface from the origin to a closed rim (m, 3), below all curves."""
    sheet = np.array([0.0, 1.0])[:, np.newaxis, np.newaxis] * rim
    given: dict[str, Any] = {"linewidth": 0.0, "rcount": 2, "ccount": len(rim), "zorder": 1}
    xyz = np.moveaxis(sheet, -1, 0)
    return ax.plot_surface(*xyz, color=colour, alpha=alpha, shade=False, **(given | style))


def circle(
    centre: Floats, normal: Floats, radius: float, start: Floats | None = None, *, samples: int = 97
) -> Floats:
    """Points (samples, 3) of a circle in space, closed."""
    unit = normal / np.linalg.norm(normal)
    if start is None:
        start = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit))])
    start = start / np.linalg.norm(start)
    angles = np.linspace(0.0, 2.0 * pi, samples)
    return np.asarray(centre + radius * rotate(start, unit, angles))


def arc(
    ax: Any,
    axis: Floats,
    start: Floats,
    angle: float,
    colour: str,
    text: str = "",
    *,
    centre: Floats | None = None,
    beyond: float = 1.22,
    **style: Any,
) -> Any:
    """The arc of ``start``, a vector from the centre, turning about ``axis``, with an arrow tip.

    The name is written at half the angle and at ``beyond`` times the radius.
    """
    middle = np.zeros(3) if centre is None else centre
    points = middle + rotate(start, axis, np.linspace(0.0, angle, 49))
    line = curve(ax, points, colour, **style)
    if abs(angle) * np.linalg.norm(start) > 1e-9:
        tip = points[-1] - points[-5]
        arrow(ax, tip, colour, start=points[-5], linewidth=0.0, mutation_scale=9.0)
    if text:
        label(ax, middle + beyond * (points[24] - middle), text, colour)
    return line


def arc_between(
    ax: Any, first: Floats, second: Floats, radius: float, colour: str, text: str = "", **style: Any
) -> Any:
    """The shorter arc from one direction to another."""
    a, b = first / np.linalg.norm(first), second / np.linalg.norm(second)
    normal = np.cross(a, b)
    sine = np.linalg.norm(normal)
    angle = float(np.arctan2(sine, a @ b))
    axis = normal / sine if sine > 0.0 else np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
    return arc(ax, axis, radius * a, angle, colour, text, **style)


def _text(ax: Any, colour: str) -> dict[str, Any]:
    from matplotlib.patheffects import Normal, Stroke

    return {
        "color": on_ground(ax, colour),
        "ha": "center",
        "va": "center",
        "fontsize": "large",
        "zorder": 10,
        "path_effects": [Stroke(linewidth=2.5, foreground=colours.ground(ax)), Normal()],
    }
