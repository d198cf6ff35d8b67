"""Orientation of the axes of a body: Euler's turns, the line of nodes, and frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import (
    UP,
    arc,
    arc_in_plane,
    arrow,
    circle,
    curve,
    dots,
    fit,
    fit_in_plane,
    label,
    triad,
)
from ..rotations.euler import euler_to_matrix, rotation_z
from .picture import Picture

Floats = NDArray[np.float64]


def _draw_euler_steps(data: Picture, *panels: Any) -> None:
    *spaces, plane = panels
    for step, ax in enumerate(spaces):
        kept = 0 if step == 1 else 2
        old, new = ([f"${name}$" for name in _NAMES[k]] for k in (step, step + 1))
        new[kept] = f"{old[kept][:-1]} = {new[kept][1:]}"
        old[kept] = ""
        origin = np.zeros(3)
        dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
        triad(ax, data.axes[step], origin, old, gid="axes", **dashed)
        triad(ax, data.axes[step + 1], origin, new, linewidth=2.4, gid="axes")
        # Beyond the tip of axis 1 is its name.
        node = data.turned_about[1] * np.array([[-0.4], [1.0], [np.nan], [1.35], [1.6]])
        dashdot: dict[str, Any] = {"linewidth": 1.2, "linestyle": "dashdot", "zorder": 3}
        curve(ax, node, colours.NODE.colour, gid="node", **dashdot)
        turned = [axis for axis in range(3) if axis != kept]
        for axis, radius in zip(turned, (0.55, 0.7), strict=True):
            arc(
                ax,
                data.turned_about[step],
                radius * data.axes[step, axis],
                float(data.angles[step]),
                colours.ANGLE.colour,
                _TURNS[step],
            )
        label(ax, 1.72 * data.turned_about[1], "$N$", colours.NODE.colour)
        ax.set_title(f"{step + 1}.  {_TURNS[step]} {_ABOUT[step]}", fontsize="medium")
        fit(ax, data.axes, node[[0, -1]], elev=24.0, azim=_azimuth(data.angles[0]), filled=0.8)
    _draw_turned_plane(plane, data)


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
    phi, theta, psi = vector("angles", angles, 3).tolist()
    steps = euler_to_matrix(
        [[0.0, 0.0, 0.0], [phi, 0.0, 0.0], [phi, theta, 0.0], [phi, theta, psi]]
    )
    axes = np.swapaxes(steps, -1, -2)
    seen_from = vector("point", point, 2)
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


_NAMES = (
    ("x'", "y'", "z'"),
    ("x''", "y''", "z''"),
    ("X", "Y", "Z"),
    ("x", "y", "z"),
)
_TURNS = (r"$\phi$", r"$\theta$", r"$\psi$")
_ABOUT = ("about $z'$", "about the line of nodes", "about $z$")


def _draw_turned_plane(ax: Any, data: Picture) -> None:
    """The plane of the first turn, with the coordinates of a point along both pairs of axes."""
    longest = max(1.0, 1.15 * float(np.linalg.norm(data.point)))
    for step, names, style in (
        (0, _NAMES[0], {"linewidth": 1.0, "linestyle": "dashed"}),
        (1, _NAMES[1], {"linewidth": 2.4}),
    ):
        for axis, ink in enumerate(colours.AXES[:2]):
            along = longest * data.axes[step, axis, :2]
            arrow(ax, along, ink.colour, f"${names[axis]}$", **style)
            foot = (data.point, data.seen)[step][axis] * data.axes[step, axis, :2]
            curve(ax, np.array([data.point, foot]), ink.colour, linewidth=0.9, linestyle="dotted")
    arc_in_plane(ax, 0.35 * longest, 0.0, data.angles[0], _TURNS[0], beyond=0.44 / 0.35)
    arrow(ax, data.point, colours.HUES["black"], "$P$", linewidth=1.6, gid="point")
    corners = np.vstack([np.zeros((1, 2)), longest * data.axes[:2, :2, :2].reshape(-1, 2)])
    fit_in_plane(ax, corners, 0.14 * longest)
    ax.set_anchor("N")  # its title as high as the titles of the other panels
    ax.set_title("the first turn seen from $z'$", fontsize="medium")


def _azimuth(phi: float) -> float:
    """Azimuth of the view (degrees): between the first axis of space and the line of nodes."""
    return float(np.degrees(0.5 * phi)) - 16.0  # aside, so that it does not hide body axis z


def _draw_frames(data: Picture, ax: Any) -> None:
    names = ("$X'$", "$Y'$", "$Z'$")
    triad(ax, data.space, np.zeros(3), names, linewidth=1.2, gid="space")
    apart = bool(data.origin.any())
    names = ("$x'$", "$y'$", "$z'$") if apart else ("", "", "")
    dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
    triad(ax, data.space, data.origin, names, gid="parallel", **dashed)
    triad(ax, data.body, data.origin, ("$x$", "$y$", "$z$"), linewidth=2.6, gid="body")
    label(ax, np.array([-0.09, -0.09, -0.09]), "$O'$" if apart else "$O$", colours.NEUTRAL)
    # Write the names outside the triangle of R, r' and r.
    aside = _apart(data.origin, data.position) if apart and data.position is not None else -UP
    if apart:
        arrow(ax, data.origin, colours.SPACE.colour, linewidth=1.6, gid="origin")
        label(ax, 0.5 * data.origin + 0.12 * aside, r"$\mathbf{R}$", colours.SPACE.colour)
        label(ax, data.origin - 0.13 * UP, "$O$", colours.NEUTRAL)
    shown = [np.zeros((1, 3)), data.space, data.origin + data.space, data.origin + data.body]
    if data.relative is not None and data.position is not None:
        colour = colours.BODY.colour
        black = colours.POSITION.colour
        start = data.origin
        arrow(ax, data.relative, colour, start=start, linewidth=1.6, gid="relative")
        arrow(ax, data.position, black, linewidth=1.6, gid="position")
        dots(ax, data.position, black, markersize=5, zorder=6)
        label(ax, data.position + 0.12 * UP, "$P$")
        label(ax, data.origin + 0.6 * data.relative + 0.1 * aside, r"$\mathbf{r}'$", colour)
        label(ax, 0.45 * data.position - 0.12 * aside, colours.POSITION.label)
        shown.append(data.position)
    fit(ax, *shown, elev=20.0, azim=-65.0)


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
    body = euler_to_matrix(vector("angles", angles, 3)).T
    place = vector("origin", origin, 3)
    relative = None if point is None else vector("point", point, 3) @ body
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
        curve(ax, circle(origin, normal, 1.0), colours.FAINT, linewidth=1.0, zorder=1)
    names = ("$x'$", "$y'$", r"$z',\ \dot{\phi}$")
    dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
    triad(ax, data.space, origin, names, gid="space", **dashed)
    names = ("$x$", "$y$", r"$z = \zeta,\ \dot{\psi}$")
    triad(ax, data.body, origin, names, linewidth=2.4, gid="body")
    for along, name in zip(
        data.node[:2], (r"$N,\ \xi,\ \dot{\theta}$", r"$M,\ \eta$"), strict=True
    ):
        arrow(ax, along, colours.NODE.colour, name, linewidth=2.0, gid="node")
    for about, start, angle, name in zip(
        (UP, data.node[0], data.node[2]),
        (data.space[0], data.space[2], data.node[0]),
        data.angles,
        _TURNS,
        strict=True,
    ):
        arc(ax, about, 0.5 * start, float(angle), colours.ANGLE.colour, name, gid="angles")
    label(ax, np.array([-0.06, -0.06, -0.09]), "$O$", colours.NEUTRAL)
    circles = circle(origin, UP, 1.0), circle(origin, data.body[2], 1.0)
    fit(ax, *circles, data.space, data.body, elev=24.0, azim=_azimuth(data.angles[0]))


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


def _apart(first: Floats, second: Floats) -> Floats:
    """Unit vector perpendicular to the bisector, on the side of ``first``; or downwards."""
    gap = first / np.linalg.norm(first) - second / (np.linalg.norm(second) or 1.0)
    size = float(np.linalg.norm(gap))
    return np.asarray(gap / size) if size > 1e-9 else -UP
