"""Figures of rotations: Euler's turns, frames, small turns, and the points of a rotating body."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import finite_float, positive_int, shaped
from .._checks.arguments import vector as vector_of
from ..drawing import axes3d as draw
from ..drawing import colours
from ..drawing.shapes import box_faces
from ..model.start import body_axis
from ..particles.motions import velocity_field
from ..rotations.euler import euler_to_matrix, rotation_z
from ..rotations.so3 import rotate
from .free import turning
from .picture import Picture

_NAMES = (("x'", "y'", "z'"), ("x''", "y''", "z''"), ("X", "Y", "Z"), ("x", "y", "z"))
_TURNS = (r"$\phi$", r"$\theta$", r"$\psi$")
_ABOUT = ("about $z'$", "about the line of nodes", "about $z$")
"""Axes before the first turn and after each turn; Euler's angles; axes of the turns."""


def _draw_euler_steps(data: Picture, *panels: Any) -> None:
    *spaces, plane = panels
    for step, ax in enumerate(spaces):
        kept = 0 if step == 1 else 2
        old, new = ([f"${name}$" for name in _NAMES[k]] for k in (step, step + 1))
        new[kept] = f"{old[kept][:-1]} = {new[kept][1:]}"
        old[kept] = ""
        origin = np.zeros(3)
        draw.triad(ax, data.axes[step], origin, old, gid="axes", **draw.DASHED)
        draw.triad(ax, data.axes[step + 1], origin, new, linewidth=2.4, gid="axes")
        # Beyond the tip of axis 1 is its name.
        node = data.turned_about[1] * np.array([[-0.4], [1.0], [np.nan], [1.35], [1.6]])
        purple = colours.NODE.colour
        draw.curve(ax, node, purple, linewidth=1.2, linestyle="dashdot", zorder=3, gid="node")
        turned = [axis for axis in range(3) if axis != kept]
        for axis, radius in zip(turned, (0.55, 0.7), strict=True):
            draw.arc(
                ax,
                data.turned_about[step],
                radius * data.axes[step, axis],
                float(data.angles[step]),
                colours.ANGLE.colour,
                _TURNS[step],
            )
        draw.label(ax, 1.72 * data.turned_about[1], "$N$", purple)
        ax.set_title(f"{step + 1}.  {_TURNS[step]} {_ABOUT[step]}", fontsize="medium")
        draw.fit(ax, data.axes, node[[0, -1]], elev=24.0, azim=_azimuth(data.angles[0]), filled=0.8)
    # The plane of the first turn, with the coordinates of the point along both pairs of axes.
    longest = max(1.0, 1.15 * float(np.linalg.norm(data.point)))
    for step, seen, style in ((0, data.point, draw.DASHED), (1, data.seen, {"linewidth": 2.4})):
        for axis, ink in enumerate(colours.AXES[:2]):
            along = data.axes[step, axis, :2]
            draw.arrow(plane, longest * along, ink.colour, f"${_NAMES[step][axis]}$", **style)
            foot = np.array([data.point, seen[axis] * along])
            draw.curve(plane, foot, ink.colour, linewidth=0.9, linestyle="dotted")
    draw.arc_in_plane(plane, 0.35 * longest, 0.0, data.angles[0], _TURNS[0], beyond=0.44 / 0.35)
    draw.arrow(plane, data.point, colours.HUES["black"], "$P$", linewidth=1.6, gid="point")
    corners = np.vstack([np.zeros((1, 2)), longest * data.axes[:2, :2, :2].reshape(-1, 2)])
    draw.fit_in_plane(plane, corners, 0.14 * longest)
    plane.set_anchor("N")  # its title as high as the titles of the other panels
    plane.set_title("the first turn seen from $z'$", fontsize="medium")


def euler_steps(angles: ArrayLike, *, point: ArrayLike = (0.35, 0.85)) -> Picture:
    """The three turns of Euler's angles one by one, and the first turn in its plane.

    The turns are by phi about the vertical, by theta about the line of nodes ``x'' = X``, and by
    psi about ``Z = z``; dashed lines are the axes before a turn. In the plane of the first turn
    ``x'' = x' cos phi + y' sin phi`` and ``y'' = y' cos phi - x' sin phi`` (Ercan 2016, figs. 2-5,
    eq. (1) with y'' in the second line, erratum D-03; lecture notes, fig. 5.2).

    Parameters
    ----------
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).
    point : array_like, shape (2,)
        A point of the plane ``x' y'``.

    Returns
    -------
    Picture
        The three turns of Euler's angles.

        angles : ndarray, shape (3,)
            ``phi, theta, psi`` (rad).
        axes : ndarray, shape (4, 3, 3)
            Unit vectors along the axes, as rows, before the first turn and after each turn, with
            components in space.
        turned_about : ndarray, shape (3, 3)
            Unit vectors along the axes of the turns: the vertical, the line of nodes, body axis z.
        point, seen : ndarray, shape (2,)
            Coordinates of a point in the plane of the first turn, along the axes before and after
            it.

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.euler_steps([np.pi / 2, 0.3, 0.0], point=[0.0, 2.0])
    >>> data.seen.round(12).tolist(), data.turned_about[1].round(12).tolist()
    ([2.0, 0.0], [0.0, 1.0, 0.0])
    """
    phi, theta, psi = vector_of("angles", angles, 3).tolist()
    steps = euler_to_matrix(
        [[0.0, 0.0, 0.0], [phi, 0.0, 0.0], [phi, theta, 0.0], [phi, theta, psi]]
    )
    axes = np.swapaxes(steps, -1, -2)
    seen_from = vector_of("point", point, 2)
    return Picture(
        _draw_euler_steps,
        panels=["space", "space", "space", "plane"],
        columns=2,
        angles=np.array([phi, theta, psi]),
        axes=axes,
        turned_about=np.stack([axes[0, 2], axes[1, 0], axes[2, 2]]),
        point=seen_from,
        seen=(rotation_z(phi, passive=True) @ np.append(seen_from, 0.0))[:2],
    )


def _azimuth(phi: float) -> float:
    """Azimuth of the view (degrees): between the first axis of space and the line of nodes."""
    return float(np.degrees(0.5 * phi)) - 16.0  # aside, so that it does not hide body axis z


def _draw_frames(data: Picture, ax: Any) -> None:
    names = ("$X'$", "$Y'$", "$Z'$")
    draw.triad(ax, data.space, np.zeros(3), names, linewidth=1.2, gid="space")
    apart = bool(data.origin.any())
    names = ("$x'$", "$y'$", "$z'$") if apart else ("", "", "")
    draw.triad(ax, data.space, data.origin, names, gid="parallel", **draw.DASHED)
    draw.triad(ax, data.body, data.origin, ("$x$", "$y$", "$z$"), linewidth=2.6, gid="body")
    draw.label(ax, (-0.09, -0.09, -0.09), "$O'$" if apart else "$O$", colours.NEUTRAL)
    # Write the names outside the triangle of R, r' and r.
    aside = -draw.UP
    if apart and data.position is not None:  # away from the bisector of R and r, if there is one
        size = np.linalg.norm(data.position) or 1.0
        gap = data.origin / np.linalg.norm(data.origin) - data.position / size
        aside = gap / np.linalg.norm(gap) if np.linalg.norm(gap) > 1e-9 else aside
    if apart:
        draw.arrow(ax, data.origin, colours.SPACE.colour, linewidth=1.6, gid="origin")
        draw.label(ax, 0.5 * data.origin + 0.12 * aside, r"$\mathbf{R}$", colours.SPACE.colour)
        draw.label(ax, data.origin - 0.13 * draw.UP, "$O$", colours.NEUTRAL)
    shown = [np.zeros((1, 3)), data.space, data.origin + data.space, data.origin + data.body]
    if data.position is not None:
        colour, black = colours.BODY.colour, colours.POSITION.colour
        draw.arrow(ax, data.relative, colour, start=data.origin, linewidth=1.6, gid="relative")
        draw.arrow(ax, data.position, black, linewidth=1.6, gid="position")
        draw.dots(ax, data.position, black, markersize=5, zorder=6)
        draw.label(ax, data.position + 0.12 * draw.UP, "$P$")
        draw.label(ax, data.origin + 0.6 * data.relative + 0.1 * aside, r"$\mathbf{r}'$", colour)
        draw.label(ax, 0.45 * data.position - 0.12 * aside, colours.POSITION.label)
        shown.append(data.position)
    draw.fit(ax, *shown, elev=20.0, azim=-65.0)


def frames(
    angles: ArrayLike, *, origin: ArrayLike = (1.6, 1.2, 0.5), point: ArrayLike | None = None
) -> Picture:
    """The axes of space, parallel axes at the origin of a body, and the axes of the body.

    Three coordinates determine the origin, three angles the orientation; a point of the body is at
    ``r = R + r'`` (Ercan 2016, figs. 1, 6, 7).

    Parameters
    ----------
    angles : array_like, shape (3,)
        Euler angles ``phi, theta, psi`` (rad) of the body.
    origin : array_like, shape (3,)
        Origin of the body in space (m); the axes have length one.
    point : array_like, shape (3,), optional
        A point of the body, in body components (m).

    Returns
    -------
    Picture
        Axes of space, parallel axes at the origin of the body, and axes of the body.

        space, body : ndarray, shape (3, 3)
            Unit vectors along the axes, as rows, with components in space.
        origin : ndarray, shape (3,)
            ``R``, the origin of the axes of the body (m).
        relative, position : ndarray, shape (3,), or None
            Vectors to a point from the origin of the body, ``r'``, and from the origin of space,
            ``r = R + r'``, with components in space (m).

    Raises
    ------
    ValueError
        If an argument is not finite or does not have three numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.frames([np.pi / 2, 0, 0], origin=[3, 0, 0], point=[1, 0, 0])
    >>> data.position.round(12).tolist()
    [3.0, 1.0, 0.0]
    """
    body = euler_to_matrix(vector_of("angles", angles, 3)).T
    place = vector_of("origin", origin, 3)
    relative = None if point is None else vector_of("point", point, 3) @ body
    return Picture(
        _draw_frames,
        space=np.eye(3),
        body=body,
        origin=place,
        relative=relative,
        position=None if relative is None else place + relative,
    )


def _draw_node_frame(data: Picture, ax: Any) -> None:
    origin = np.zeros(3)
    for normal in (data.space[2], data.body[2]):
        draw.curve(ax, draw.circle(origin, normal, 1.0), colours.FAINT, linewidth=1.0, zorder=1)
    names = ("$x'$", "$y'$", r"$z',\ \dot{\phi}$")
    draw.triad(ax, data.space, origin, names, gid="space", **draw.DASHED)
    names = ("$x$", "$y$", r"$z = \zeta,\ \dot{\psi}$")
    draw.triad(ax, data.body, origin, names, linewidth=2.4, gid="body")
    for along, name in zip(
        data.node[:2], (r"$N,\ \xi,\ \dot{\theta}$", r"$M,\ \eta$"), strict=True
    ):
        draw.arrow(ax, along, colours.NODE.colour, name, linewidth=2.0, gid="node")
    for about, start, angle, name in zip(
        (draw.UP, data.node[0], data.node[2]),
        (data.space[0], data.space[2], data.node[0]),
        data.angles,
        _TURNS,
        strict=True,
    ):
        draw.arc(ax, about, 0.5 * start, float(angle), colours.ANGLE.colour, name, gid="angles")
    draw.label(ax, (-0.06, -0.06, -0.09), "$O$", colours.NEUTRAL)
    circles = draw.circle(origin, draw.UP, 1.0), draw.circle(origin, data.body[2], 1.0)
    draw.fit(ax, *circles, data.space, data.body, elev=24.0, azim=_azimuth(data.angles[0]))


def node_frame(angles: ArrayLike) -> Picture:
    """The frame of the line of nodes between space and body.

    In this frame ``omega = (theta', phi' sin theta, phi' cos theta + psi')``: the rate of theta is
    along ON, the rate of phi along the vertical ``z'``, and the rate of psi along ``z`` (Ercan
    2016, fig. 13, eq. (49); the text exchanges the last two, erratum D-24).

    Parameters
    ----------
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).

    Returns
    -------
    Picture
        The axes of space, the axes of the body, and the axes of the line of nodes.

        angles : ndarray, shape (3,)
            ``phi, theta, psi`` (rad).
        space, node, body : ndarray, shape (3, 3)
            Unit vectors along the axes, as rows, with components in space. The axes of ``node`` are
            xi along the line of nodes ON, eta along OM in the equator of the body, perpendicular to
            ON, and zeta, which is body axis z.

    Raises
    ------
    ValueError
        If the angles are not three finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> figures.node_frame([0.0, np.pi / 2, 0.3]).node.round(12).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    """
    steps = euler_steps(angles)
    return Picture(
        _draw_node_frame,
        angles=steps.angles,
        space=steps.axes[0],
        node=steps.axes[2],
        body=steps.axes[3],
    )


def _draw_active_passive(data: Picture, passive: Any, active: Any) -> None:
    length = 1.2 * float(np.linalg.norm(data.vector))
    black = colours.HUES["black"]
    for along, old, ink in zip(data.axes, np.eye(2), colours.AXES[:2], strict=True):
        name = ink.label.strip("$")
        draw.arrow(passive, length * old, ink.colour, ink.label, **draw.DASHED)
        draw.arrow(passive, length * along, ink.colour, f"${name}'$", gid="axes")
        draw.arrow(active, length * old, ink.colour, ink.label)
    for component, along, ink in zip(data.seen, data.axes, colours.AXES[:2], strict=True):
        foot = np.array([data.vector, component * along])
        draw.curve(passive, foot, ink.colour, linewidth=0.9, linestyle="dotted")
    draw.arrow(passive, data.vector, black, colours.POSITION.label)
    draw.arc_in_plane(passive, 0.42 * length, 0.0, data.angle, r"$\varepsilon$")

    draw.arrow(active, data.vector, black, colours.POSITION.label, gid="vector", **draw.DASHED)
    draw.arrow(active, data.turned, black, r"$\mathbf{r}'$", gid="turned")
    purple, tip = colours.HUES["purple"], data.vector
    draw.arrow(active, data.first_order, purple, start=tip, linewidth=1.4, gid="first_order")
    beside = data.vector + 0.5 * data.first_order + 0.04 * data.vector
    draw.label(active, beside, r"$\varepsilon\,\mathbf{n}\times\mathbf{r}$", purple, ha="left")
    start = float(np.arctan2(data.vector[1], data.vector[0]))
    draw.arc_in_plane(active, 0.42 * length, start, start + data.angle, r"$\varepsilon$")

    shown = np.vstack(
        [[[0.0, 0.0]], length * np.eye(2), length * data.axes, [data.vector, data.turned]]
    )
    for ax, title in ((passive, "passive: the axes turn"), (active, "active: the vector turns")):
        draw.fit_in_plane(ax, shown, 0.18 * length)
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
    draw.triad(ax, np.eye(3), np.zeros(3), names, linewidth=2.0, gid="axes")
    third = 3 - one - other
    toward = np.sign(data.first_order[third]) * np.eye(3)[third]
    if toward.any():
        part = np.array([np.zeros(3), 0.6 * toward])
        draw.curve(ax, part, colours.AXES[third].colour, linewidth=1.0, linestyle="dashed")
    colour = colours.AXES[one].colour
    draw.arrow(ax, data.turned, colour, linestyle="dashed", gid="turned")
    below = 0.95 * data.turned + 0.1 * toward
    draw.label(ax, below, rf"$\mathbf{{e}}_{one + 1}'$", colour)
    black, tip = colours.HUES["black"], data.unit
    draw.arrow(ax, data.change, black, start=tip, linewidth=1.8, gid="change")
    draw.label(ax, 0.87 * data.unit + 0.6 * data.change, rf"$\Delta\mathbf{{e}}_{one + 1}$", black)
    purple = colours.OMEGA.colour
    draw.arrow(ax, data.first_order, purple, start=tip, linewidth=1.8, gid="first_order")
    product = rf"$\delta\,\mathbf{{e}}_{other + 1}\times\mathbf{{e}}_{one + 1}$"
    draw.label(ax, 1.04 * data.unit + 0.5 * data.first_order, product, purple, ha="left")
    draw.arc(ax, data.about, 0.45 * data.unit, data.angle, black, r"$\delta$")
    # The sense of the turn: most of a circle about the axis.
    sense = np.copysign(5.0, data.angle)
    draw.arc(ax, data.about, 0.12 * np.eye(3)[third], sense, purple, centre=0.6 * data.about)
    shown = np.vstack([np.eye(3), data.turned, data.unit + data.first_order, np.zeros(3)])
    draw.fit(ax, shown, elev=18.0, azim=-58.0, filled=0.85)


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
        towards = draw.eye(draw.ELEV, draw.AZIM)
        draw.surface(
            ax, data.faces, colours.BODY_FACE, towards, edgecolors=colours.NEUTRAL, **style
        )
        shown.append(data.faces)
    omega, axis = colours.OMEGA, reach[:, np.newaxis] * direction
    draw.curve(ax, axis, omega.colour, linewidth=1.0, linestyle="dashdot", zorder=1)
    for ring in data.circles:
        draw.curve(ax, ring, colours.FAINT, linewidth=0.9, zorder=1, gid="circles")
    style = {"start": axis[1], "linewidth": 2.6, "gid": "omega"}
    draw.arrow(ax, 0.55 * size * direction, omega.colour, omega.label, **style)
    draw.dots(ax, data.positions, colours.NEUTRAL, markersize=6.0, zorder=6, gid="positions")
    scale = 0.55 * size / speeds[farthest] if speeds[farthest] > 0.0 else 0.0
    law = r"$\mathbf{v} = \boldsymbol{\omega}\times\mathbf{r}$"
    for k, (place, velocity) in enumerate(zip(data.positions, data.velocities, strict=True)):
        name = law if k == farthest else ""
        style = {"start": place, "linewidth": 2.0, "gid": "velocities"}
        draw.arrow(ax, scale * velocity, colours.VELOCITY.colour, name, **style)
    ink, style = colours.POSITION, {"linewidth": 1.6, "zorder": 5, "gid": "position"}
    draw.arrow(ax, data.positions[farthest], ink.colour, ink.label, **style)
    draw.dots(ax, np.zeros(3), colours.HUES["black"], markersize=4.0, zorder=6)
    ends = data.positions + scale * data.velocities
    top = np.outer([reach[0], reach[1] + 0.55 * size], direction)
    draw.fit(ax, *shown, ends, top, elev=draw.ELEV, azim=draw.AZIM)


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
