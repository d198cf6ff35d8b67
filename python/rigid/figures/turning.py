"""Small turns of vectors and axes, and the points of a rotating body."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, positive_int, shaped
from .._checks.arguments import vector as vector_of
from ..drawing import colours
from ..drawing.axes3d import (
    AZIM,
    ELEV,
    arc,
    arc_in_plane,
    arrow,
    curve,
    dots,
    eye,
    fit,
    fit_in_plane,
    label,
    surface,
    triad,
)
from ..drawing.shapes import box_faces
from ..model.start import body_axis
from ..particles import velocity_field
from ..rotations.euler import rotation_z
from ..rotations.so3 import rotate
from .picture import Picture
from .symmetric import turning

Floats = NDArray[np.float64]


def _draw_active_passive(data: Picture, passive: Any, active: Any) -> None:
    length = 1.2 * float(np.linalg.norm(data.vector))
    black = colours.HUES["black"]
    thin: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}

    for along, old, ink in zip(data.axes, np.eye(2), colours.AXES[:2], strict=True):
        name = ink.label.strip("$")
        arrow(passive, length * old, ink.colour, ink.label, **thin)
        arrow(passive, length * along, ink.colour, f"${name}'$", gid="axes")
        arrow(active, length * old, ink.colour, ink.label)
    for component, along, ink in zip(data.seen, data.axes, colours.AXES[:2], strict=True):
        foot = np.array([data.vector, component * along])
        curve(passive, foot, ink.colour, linewidth=0.9, linestyle="dotted")
    arrow(passive, data.vector, black, colours.POSITION.label)
    arc_in_plane(passive, 0.42 * length, 0.0, data.angle, r"$\varepsilon$")

    arrow(active, data.vector, black, colours.POSITION.label, gid="vector", **thin)
    arrow(active, data.turned, black, r"$\mathbf{r}'$", gid="turned")
    purple = colours.HUES["purple"]
    tip: dict[str, Any] = {"start": data.vector, "linewidth": 1.4, "gid": "first_order"}
    arrow(active, data.first_order, purple, **tip)
    beside = data.vector + 0.5 * data.first_order + 0.04 * data.vector
    label(active, beside, r"$\varepsilon\,\mathbf{n}\times\mathbf{r}$", purple, ha="left")
    start = float(np.arctan2(data.vector[1], data.vector[0]))
    arc_in_plane(active, 0.42 * length, start, start + data.angle, r"$\varepsilon$")

    shown = np.vstack(
        [[[0.0, 0.0]], length * np.eye(2), length * data.axes, [data.vector, data.turned]]
    )
    for ax, title in ((passive, "passive: the axes turn"), (active, "active: the vector turns")):
        fit_in_plane(ax, shown, 0.18 * length)
        ax.set_title(title, fontsize="medium")


def active_passive(angle: float = 0.35, *, vector: ArrayLike = (0.75, 0.6)) -> Picture:
    """A turn of the axes (passive) and a turn of the vector (active).

    In the passive turn the axes turn and the components of the vector change. In the active turn
    the vector turns and changes by ``angle n × r`` to first order. A passive turn gives the same
    components as the active turn by the opposite angle (lecture notes, fig. 5.1).

    Parameters
    ----------
    angle : float
        Angle of the turn (rad).
    vector : array_like, shape (2,)
        The vector, not zero.

    Returns
    -------
    Picture
        A turn in a plane, passive and active.

        angle : float
            Angle of the turn (rad).
        vector : ndarray, shape (2,)
            The vector before the turn.
        axes : ndarray, shape (2, 2)
            Passive: unit vectors along the turned axes, one in a row.
        seen : ndarray, shape (2,)
            Passive: components of the vector along the turned axes.
        turned : ndarray, shape (2,)
            Active: the turned vector.
        first_order : ndarray, shape (2,)
            Change of the vector by the active turn to first order, ``angle n × r``.

    Raises
    ------
    ValueError
        If the vector is zero or an argument is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.active_passive(np.pi / 2, vector=[1.0, 0.0])
    >>> data.turned.round(12).tolist(), (data.seen.round(12) + 0.0).tolist()
    ([0.0, 1.0], [0.0, -1.0])
    """
    turn = finite_float("angle", angle)
    before = vector_of("vector", vector, 2)
    if not before.any():
        raise ValueError(f"vector = {before.tolist()}: must not be zero")
    active = rotation_z(turn)[:2, :2]
    return Picture(
        _draw_active_passive,
        panels=["plane", "plane"],
        angle=turn,
        vector=before,
        axes=active.T,
        seen=rotation_z(turn, passive=True)[:2, :2] @ before,
        turned=active @ before,
        first_order=turn * np.array([-before[1], before[0]]),
    )


def _draw_unit_vector_change(data: Picture, ax: Any) -> None:
    one, other = int(data.unit.argmax()), int(data.about.argmax())
    names = [rf"$\mathbf{{e}}_{number}$" for number in (1, 2, 3)]
    triad(ax, np.eye(3), np.zeros(3), names, linewidth=2.0, gid="axes")
    third = 3 - one - other
    toward = np.sign(data.first_order[third]) * np.eye(3)[third]
    if toward.any():
        part = np.array([np.zeros(3), 0.6 * toward])
        curve(ax, part, colours.AXES[third].colour, linewidth=1.0, linestyle="dashed")
    colour = colours.AXES[one].colour
    arrow(ax, data.turned, colour, linestyle="dashed", gid="turned")
    below = 0.95 * data.turned + 0.1 * toward
    label(ax, below, rf"$\mathbf{{e}}_{one + 1}'$", colour)
    black = colours.HUES["black"]
    tip: dict[str, Any] = {"start": data.unit, "linewidth": 1.8}
    arrow(ax, data.change, black, gid="change", **tip)
    label(ax, 0.87 * data.unit + 0.6 * data.change, rf"$\Delta\mathbf{{e}}_{one + 1}$", black)
    purple = colours.OMEGA.colour
    arrow(ax, data.first_order, purple, gid="first_order", **tip)
    product = rf"$\delta\,\mathbf{{e}}_{other + 1}\times\mathbf{{e}}_{one + 1}$"
    label(ax, 1.04 * data.unit + 0.5 * data.first_order, product, purple, ha="left")
    arc(ax, data.about, 0.45 * data.unit, data.angle, black, r"$\delta$")
    # The sense of the turn: most of a circle about the axis.
    sense = np.copysign(5.0, data.angle)
    arc(ax, data.about, 0.12 * np.eye(3)[third], sense, purple, centre=0.6 * data.about)
    shown = np.vstack([np.eye(3), data.turned, data.unit + data.first_order, np.zeros(3)])
    fit(ax, shown, elev=18.0, azim=-58.0, filled=0.85)


def unit_vector_change(angle: float = 0.35, *, unit: int = 1, about: int = 2) -> Picture:
    """How a unit vector changes in a small turn about another: ``d e/dt = omega × e``.

    A turn about axis 2 moves the first unit vector towards the negative third axis (Ercan 2016,
    fig. 8, eqs. (13)-(15); the caption names the first axis instead, erratum D-05).

    Parameters
    ----------
    angle : float
        Angle of the turn (rad).
    unit, about : {1, 2, 3}
        Number of the unit vector that turns, and number of the axis of the turn; they must differ.

    Returns
    -------
    Picture
        A unit vector under a small turn about another.

        angle : float
            Angle of the turn (rad).
        unit, about : ndarray, shape (3,)
            The vector before the turn, and the axis of the turn.
        turned : ndarray, shape (3,)
            The vector after the turn.
        change : ndarray, shape (3,)
            Difference of the vector after and before the turn.
        first_order : ndarray, shape (3,)
            ``angle about × unit``.

    Raises
    ------
    ValueError
        If the angle is not finite, or ``unit`` and ``about`` are equal or not 1, 2 or 3.

    Examples
    --------
    >>> from rigid import figures
    >>> figures.unit_vector_change(1e-3).first_order.tolist()
    [0.0, 0.0, -0.001]
    """
    turn = finite_float("angle", angle)
    one, other = body_axis(unit) - 1, body_axis(about) - 1
    if one == other:
        raise ValueError(f"unit = {unit}, about = {about}: a vector does not turn about itself")
    before, axis = np.eye(3)[[one, other]]
    turned = rotate(before, axis, turn)
    return Picture(
        _draw_unit_vector_change,
        angle=turn,
        unit=before,
        about=axis,
        turned=turned,
        change=turned - before,
        first_order=turn * np.cross(axis, before),
    )


def _draw_rotating_body(data: Picture, ax: Any) -> None:
    size = float(np.linalg.norm(data.positions, axis=-1).max()) or 1.0
    speeds = np.linalg.norm(data.velocities, axis=-1)
    farthest = int(speeds.argmax())
    direction = data.omega / np.linalg.norm(data.omega)
    heights = data.positions @ direction
    reach = np.array([min(heights.min(), 0.0) - 0.25 * size, max(heights.max(), 0.0) + 0.6 * size])
    shown = [data.circles]
    if data.faces is not None:
        style: dict[str, Any] = {"alpha": 0.6, "linewidths": 1.2, "gid": "faces"}
        towards = eye(ELEV, AZIM)
        surface(ax, data.faces, colours.BODY_FACE, towards, edgecolors=colours.NEUTRAL, **style)
        shown.append(data.faces)
    omega, axis = colours.OMEGA, reach[:, np.newaxis] * direction
    curve(ax, axis, omega.colour, linewidth=1.0, linestyle="dashdot", zorder=1)
    for ring in data.circles:
        curve(ax, ring, colours.FAINT, linewidth=0.9, zorder=1, gid="circles")
    style = {"start": axis[1], "linewidth": 2.6, "gid": "omega"}
    arrow(ax, 0.55 * size * direction, omega.colour, omega.label, **style)
    dots(ax, data.positions, colours.NEUTRAL, markersize=6.0, zorder=6, gid="positions")
    scale = 0.55 * size / speeds[farthest] if speeds[farthest] > 0.0 else 0.0
    law = r"$\mathbf{v} = \boldsymbol{\omega}\times\mathbf{r}$"
    for k, (place, velocity) in enumerate(zip(data.positions, data.velocities, strict=True)):
        name = law if k == farthest else ""
        style = {"start": place, "linewidth": 2.0, "gid": "velocities"}
        arrow(ax, scale * velocity, colours.VELOCITY.colour, name, **style)
    ink, style = colours.POSITION, {"linewidth": 1.6, "zorder": 5, "gid": "position"}
    arrow(ax, data.positions[farthest], ink.colour, ink.label, **style)
    dots(ax, np.zeros(3), colours.HUES["black"], markersize=4.0, zorder=6)
    ends = data.positions + scale * data.velocities
    top = np.outer([reach[0], reach[1] + 0.55 * size], direction)
    fit(ax, *shown, ends, top, elev=ELEV, azim=AZIM)


def rotating_body(
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    samples: int = 97,
) -> Picture:
    """The points of a rotating body with their velocities ``v = omega × r``.

    Every point moves on a circle about the axis; the point that is farthest from the axis has
    labels (Ercan 2016, fig. 9).

    Parameters
    ----------
    positions : array_like, shape (N, 3)
        Points (m), at least one.
    omega : array_like, shape (3,)
        Angular velocity (rad/s), not zero.
    sides : array_like, shape (3,), optional
        Sides of the block that represents the body (m), positive; its centre is the origin.
    samples : int
        Number of points of a circle; the first and the last point coincide.

    Returns
    -------
    Picture
        Points of a body that turns about an axis through the origin.

        omega : ndarray, shape (3,)
            Angular velocity (rad/s).
        positions, velocities : ndarray, shape (N, 3)
            Positions and velocities of the points (m, m/s): ``v = omega × r``.
        circles : ndarray, shape (N, m, 3)
            The circle on which each point moves (m).
        faces : ndarray, shape (6, 4, 3), or None
            Corners of the faces of the block that represents the body (m).

    Raises
    ------
    ValueError
        If there are no points, the body does not turn, a side is not positive, or an argument is
        not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> figures.rotating_body([[2, 0, 5]], [0, 0, 3]).velocities.tolist()
    [[0.0, 6.0, 0.0]]
    """
    r = shaped("positions", positions, None, 3)
    if r.ndim != 2 or len(r) == 0:
        raise ValueError(f"positions: expected shape (N, 3) of one or more, got {r.shape}")
    w = turning(omega)
    block = None if sides is None else 0.5 * vector_of("sides", sides, 3)
    if block is not None and not (block > 0.0).all():
        raise ValueError(f"sides = {(2.0 * block).tolist()}: must be positive")
    turns = np.linspace(0.0, 2.0 * np.pi, positive_int("samples", samples, minimum=2))
    return Picture(
        _draw_rotating_body,
        omega=w,
        positions=r,
        velocities=velocity_field(w, r),
        circles=rotate(r[:, np.newaxis, :], w, turns),
        faces=None if block is None else box_faces(block),
    )
