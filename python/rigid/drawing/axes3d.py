"""Helpers of all figures: axes with equal scales, arrows, arcs and labels."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians
from typing import Any

import numpy as np

from .._checks.arrays import Floats
from ..rotations.euler import rotation_y, rotation_z
from ..rotations.so3 import rotate
from . import colours
from .colours import HUES, on_ground

UP = np.array([0.0, 0.0, 1.0])

ELEV, AZIM = 22.0, -60.0
"""The usual view (degrees)."""

KEY: dict[str, Any] = {"frameon": False, "handlelength": 3.0}
"""Style of a legend that belongs to a whole figure."""

BELOW: dict[str, Any] = {**KEY, "loc": "upper center", "bbox_to_anchor": (0.5, -0.12)}
"""Style and place of a legend below its axes."""

DASHED: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
"""Style of thin lines beside those that matter."""

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
    limits = np.stack([middle - 0.5 * side, middle + 0.5 * side], axis=1)
    ax.set(xlim=limits[0], ylim=limits[1], zlim=limits[2])
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


def fit_in_plane(ax: Any, points: Floats, margin: float) -> None:
    """Set limits with this margin around the points (m, 2), equal scales, and no frame."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    ax.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set_axis_off()


def arrow(
    ax: Any,
    vector: Floats,
    colour: str,
    text: str = "",
    *,
    start: Floats | None = None,
    **style: Any,
) -> None:
    """An arrow in space or in the plane with its name beyond the tip; no arrow along zero."""
    from .arrows import Arrow

    style = {"color": on_ground(ax, colour), "linewidth": 2.0, "zorder": 5} | style
    one = Arrow(np.zeros(len(vector)) if start is None else start, vector, **style)
    one.set_in_layout(len(vector) == 2)
    one.set_visible(bool(vector.any()))
    ax.add_artist(one)
    if text and vector.any():
        one.write(ax, text, **_text(ax, colour))


def triad(ax: Any, axes: Floats, origin: Floats, names: Sequence[str], **style: Any) -> None:
    """Three axes with their names, from an origin, in the colours of x, y, z."""
    for along, ink, name in zip(axes, colours.AXES, names, strict=True):
        arrow(ax, along, ink.colour, name, start=origin, **style)


def label(ax: Any, place: Any, text: str, colour: str = HUES["black"], **style: Any) -> None:
    """Text that is centred at a point in space or in the plane, and legible over lines."""
    ax.text(*place, text, **(_text(ax, colour) | style))


def curve(ax: Any, points: Floats | tuple[Any, ...], colour: str, **style: Any) -> Any:
    """A line through points (m, 3) or (m, 2), or through a tuple of their coordinates."""
    along = points if isinstance(points, tuple) else points.T
    (line,) = ax.plot(*along, **({"color": on_ground(ax, colour), "linewidth": 1.3} | style))
    return line


def dots(ax: Any, points: Floats | tuple[Any, ...], colour: str, **style: Any) -> Any:
    """Dots at points (m, 3) or (m, 2), at one point, or at a tuple of coordinates."""
    return curve(ax, points, colour, marker="o", linestyle="", **style)


def cone(ax: Any, rim: Floats, colour: Any, alpha: float, **style: Any) -> None:
    """The transparent surface from the origin to a closed rim (m, 3), below all curves."""
    sheet = np.array([0.0, 1.0])[:, np.newaxis, np.newaxis] * rim
    style |= {"linewidth": 0.0, "rcount": 2, "ccount": len(rim), "zorder": 1}
    xyz = np.moveaxis(sheet, -1, 0)
    ax.plot_surface(*xyz, color=colour, alpha=alpha, shade=False, **style)


def eye(elev: float, azim: float) -> Floats:
    """Unit vector towards a viewer at this elevation and azimuth (degrees)."""
    e, a = np.radians([elev, azim])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def sides(points: Floats, outward: Floats, towards: Floats) -> tuple[Floats, Floats]:
    """Visible and hidden points (m, 3) of a curve on a surface; the other points are NaN."""
    seen = (outward @ towards >= 0.0)[:, np.newaxis]
    return np.where(seen, points, np.nan), np.where(seen, np.nan, points)


def surface(ax: Any, faces: Floats, colour: str, towards: Floats, **style: Any) -> None:
    """Draw polygons (k, 4, 3), shaded by their angle to the viewer, below all curves."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    size = np.linalg.norm(normal, axis=1)
    light = 0.8 + 0.2 * np.abs(normal @ towards) / np.where(size > 0.0, size, 1.0)
    shades = light[:, np.newaxis] * np.array(to_rgb(on_ground(ax, colour)))
    given: dict[str, Any] = {"edgecolors": shades, "linewidths": 0.4, "zorder": 1}
    ax.add_collection3d(Poly3DCollection(faces, facecolors=shades, **(given | style)))


def circle(centre: Floats, normal: Floats, radius: float, start: Floats | None = None) -> Floats:
    """Points (97, 3) of a circle in space, closed."""
    unit = normal / np.linalg.norm(normal)
    if start is None:
        start = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit))])
    start = start / np.linalg.norm(start)
    angles = np.linspace(0.0, 2.0 * pi, 97)
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
) -> None:
    """The arc of ``start``, a vector from the centre, turning about ``axis``, with an arrow tip.

    The name is written at half the angle and at ``beyond`` times the radius.
    """
    middle = np.zeros(3) if centre is None else centre
    points = middle + rotate(start, axis, np.linspace(0.0, angle, 49))
    curve(ax, points, colour, **style)
    if abs(angle) * np.linalg.norm(start) > 1e-9:
        tip = points[-1] - points[-5]
        arrow(ax, tip, colour, start=points[-5], linewidth=0.0, mutation_scale=9.0)
    if text:
        label(ax, middle + beyond * (points[24] - middle), text, colour)


def arc_in_plane(
    ax: Any, radius: float, start: float, end: float, text: str, *, beyond: float = 1.2
) -> None:
    """An angle about the origin of a plane; its name is at ``beyond`` times the radius."""
    angles = np.linspace(start, end, 49)
    points = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    curve(ax, points, colours.ANGLE.colour)
    label(ax, beyond * points[24], text)


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
