"""Frames and Euler angles: where the axes of space and of a body are, and how one gets there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._check import vector
from ..euler import euler_to_matrix, rotation_z
from . import colours
from ._draw import (
    arc,
    arrow,
    arrow_in_plane,
    circle,
    curve,
    fit,
    in_space,
    label,
    label_in_plane,
    panels,
)

__all__ = [
    "EulerSteps",
    "EulerStepsArtists",
    "Frames",
    "FramesArtists",
    "NodeFrame",
    "NodeFrameArtists",
    "euler_steps",
    "euler_steps_data",
    "frames",
    "frames_data",
    "node_frame",
    "node_frame_data",
]

Floats = NDArray[np.float64]

_X = np.array([1.0, 0.0, 0.0])
_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frames:
    """Axes of space, axes parallel to them in the body, and those of the body.

    Attributes
    ----------
    space, body : ndarray, shape (3, 3)
        Unit vectors along the axes, one in a row, in space components.
    origin : ndarray, shape (3,)
        ``R``, where the axes of the body meet (m).
    relative, position : ndarray, shape (3,), or None
        A point seen from there, ``r'``, and from the origin of space, ``r = R + r'``; both in space
        components (m).
    """

    space: Floats
    body: Floats
    origin: Floats
    relative: Floats | None
    position: Floats | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FramesArtists:
    """What :func:`frames` has drawn.

    Attributes
    ----------
    ax : Axes3D
        Where.
    data : Frames
        What.
    space, parallel, body : tuple of 3 SpaceArrow
        The axes; an arrow has its ``start`` and its ``vector``.
    origin, relative, position : SpaceArrow or None
        The arrows ``R``, ``r'`` and ``r``.
    """

    ax: Any
    data: Frames
    space: tuple[Any, ...]
    parallel: tuple[Any, ...]
    body: tuple[Any, ...]
    origin: Any | None
    relative: Any | None
    position: Any | None


def frames_data(
    angles: ArrayLike, *, origin: ArrayLike = (1.6, 1.2, 0.5), point: ArrayLike | None = None
) -> Frames:
    """Axes and vectors under :func:`frames`.

    Parameters
    ----------
    angles : array_like, shape (3,)
        Euler angles ``phi, theta, psi`` (rad) of the body.
    origin : array_like, shape (3,)
        Its origin in space (m); axes are drawn of length one.
    point : array_like, shape (3,), optional
        A point of the body, in body components (m).

    Returns
    -------
    Frames

    Raises
    ------
    ValueError
        If an argument is not finite or not of three numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.frames_data([np.pi / 2, 0, 0], origin=[3, 0, 0], point=[1, 0, 0])
    >>> data.position.round(12).tolist()
    [3.0, 1.0, 0.0]
    """
    body = euler_to_matrix(vector("angles", angles, 3)).T
    place = vector("origin", origin, 3)
    relative = None if point is None else vector("point", point, 3) @ body
    return Frames(
        space=np.eye(3),
        body=body,
        origin=place,
        relative=relative,
        position=None if relative is None else place + relative,
    )


def frames(
    angles: ArrayLike,
    *,
    origin: ArrayLike = (1.6, 1.2, 0.5),
    point: ArrayLike | None = None,
    ax: Any | None = None,
) -> FramesArtists:
    """Draw the axes of space, parallel ones at the origin of a body, and those of the body.

    Three coordinates place the origin, three angles turn the axes; a point of the body is seen at
    ``r = R + r'`` (Ercan 2016, figs. 1, 6, 7).

    Parameters
    ----------
    angles, origin, point
        As in :func:`frames_data`.
    ax : Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    FramesArtists

    Raises
    ------
    ValueError
        As in :func:`frames_data`, and if the axes are not three-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.frames([0.6, 0.7, 0.4], point=[0.5, 0.9, 0.3])
    >>> drawn.ax.figure.savefig("frames.png")  # doctest: +SKIP
    """
    data = frames_data(angles, origin=origin, point=point)
    ax = in_space(ax)
    space = _triad(ax, data.space, np.zeros(3), ("$X'$", "$Y'$", "$Z'$"), linewidth=1.2)
    apart = bool(data.origin.any())
    parallel = _triad(
        ax,
        data.space,
        data.origin,
        ("$x'$", "$y'$", "$z'$") if apart else ("", "", ""),
        linewidth=1.0,
        linestyle="dashed",
    )
    body = _triad(ax, data.body, data.origin, ("$x$", "$y$", "$z$"), linewidth=2.6)
    label(ax, np.array([-0.09, -0.09, -0.09]), "$O'$" if apart else "$O$", colours.NEUTRAL)
    # Names stand on the outer sides of the triangle of R, r' and r.
    aside = _apart(data.origin, data.position) if apart and data.position is not None else -_Z
    shift = None
    if apart:
        shift = arrow(ax, data.origin, colours.SPACE.colour, linewidth=1.6)
        label(ax, 0.5 * data.origin + 0.12 * aside, r"$\mathbf{R}$", colours.SPACE.colour)
        label(ax, data.origin - 0.13 * _Z, "$O$", colours.NEUTRAL)
    relative = position = None
    shown = [np.zeros((1, 3)), data.space, data.origin + data.space, data.origin + data.body]
    if data.relative is not None and data.position is not None:
        colour = colours.BODY.colour
        relative = arrow(ax, data.relative, colour, start=data.origin, linewidth=1.6)
        position = arrow(ax, data.position, colours.POSITION.colour, linewidth=1.6)
        ax.plot(*data.position, "o", color="black", markersize=5, zorder=6)
        label(ax, data.position + 0.12 * _Z, "$P$")
        label(ax, data.origin + 0.6 * data.relative + 0.1 * aside, r"$\mathbf{r}'$", colour)
        label(ax, 0.45 * data.position - 0.12 * aside, colours.POSITION.label)
        shown.append(data.position)
    fit(ax, *shown, elev=20.0, azim=-65.0)
    return FramesArtists(
        ax=ax,
        data=data,
        space=space,
        parallel=parallel,
        body=body,
        origin=shift,
        relative=relative,
        position=position,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EulerSteps:
    """The three turns of Euler's angles.

    Attributes
    ----------
    angles : ndarray, shape (3,)
        ``phi, theta, psi`` (rad).
    axes : ndarray, shape (4, 3, 3)
        Unit vectors along the axes before the first turn and after each, one in a row, in space
        components.
    turned_about : ndarray, shape (3, 3)
        Unit vectors that the turns are about: the vertical, the line of nodes, body axis z.
    point, seen : ndarray, shape (2,)
        Coordinates of a point across the first axis, from the axes before and after the first turn.
    """

    angles: Floats
    axes: Floats
    turned_about: Floats
    point: Floats
    seen: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EulerStepsArtists:
    """What :func:`euler_steps` has drawn.

    Attributes
    ----------
    axes : tuple of 3 Axes3D and Axes
        The panels.
    data : EulerSteps
        What.
    before, after : tuple of 3 tuples of 3 SpaceArrow
        The axes in each panel.
    nodes : tuple of 3 Line3D
        The line of nodes in each panel.
    point : PlaneArrow
        The vector that is seen from both axes in the plane.
    """

    axes: tuple[Any, ...]
    data: EulerSteps
    before: tuple[tuple[Any, ...], ...]
    after: tuple[tuple[Any, ...], ...]
    nodes: tuple[Any, ...]
    point: Any


def euler_steps_data(angles: ArrayLike, *, point: ArrayLike = (0.35, 0.85)) -> EulerSteps:
    """Axes under :func:`euler_steps`.

    Parameters
    ----------
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).
    point : array_like, shape (2,)
        A point of the plane ``x' y'``.

    Returns
    -------
    EulerSteps

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong shape.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.euler_steps_data([np.pi / 2, 0.3, 0.0], point=[0.0, 2.0])
    >>> data.seen.round(12).tolist(), data.turned_about[1].round(12).tolist()
    ([2.0, 0.0], [0.0, 1.0, 0.0])
    """
    phi, theta, psi = vector("angles", angles, 3).tolist()
    steps = euler_to_matrix(
        [[0.0, 0.0, 0.0], [phi, 0.0, 0.0], [phi, theta, 0.0], [phi, theta, psi]]
    )
    axes = np.swapaxes(steps, -1, -2)
    seen_from = vector("point", point, 2)
    return EulerSteps(
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


def euler_steps(
    angles: ArrayLike, *, point: ArrayLike = (0.35, 0.85), axes: Sequence[Any] | None = None
) -> EulerStepsArtists:
    """Draw the three turns of Euler's angles one by one, and the first in its plane.

    By phi about the vertical, by theta about the line of nodes ``x'' = X``, by psi about ``Z = z``;
    axes before a turn are dashed. In the plane of the first, ``x'' = x' cos phi + y' sin phi`` and
    ``y'' = y' cos phi - x' sin phi`` (Ercan 2016, figs. 2-5, eq. (1) with the second line y'',
    erratum D-03; lecture notes, fig. 5.2).

    Parameters
    ----------
    angles, point
        As in :func:`euler_steps_data`.
    axes : sequence of 3 Axes3D and Axes, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    EulerStepsArtists

    Raises
    ------
    ValueError
        As in :func:`euler_steps_data`, and if the axes are not those four.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.euler_steps([0.7, 0.6, 0.8])
    >>> drawn.axes[0].figure.savefig("euler.png")  # doctest: +SKIP
    """
    data = euler_steps_data(angles, point=point)
    *spaces, plane = panels(axes, ["space", "space", "space", "plane"], columns=2)
    before, after, nodes = [], [], []
    for step, ax in enumerate(spaces):
        kept = 0 if step == 1 else 2
        old, new = ([f"${name}$" for name in _NAMES[k]] for k in (step, step + 1))
        new[kept] = f"{old[kept][:-1]} = {new[kept][1:]}"
        old[kept] = ""
        origin = np.zeros(3)
        before.append(_triad(ax, data.axes[step], origin, old, linewidth=1.0, linestyle="dashed"))
        after.append(_triad(ax, data.axes[step + 1], origin, new, linewidth=2.4))
        node = data.turned_about[1] * np.array([[-1.0], [1.25]])
        nodes.append(
            curve(ax, node, colours.NODE.colour, linewidth=1.2, linestyle="dashdot", zorder=3)
        )
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
        label(ax, -1.12 * data.turned_about[1], "$N$", colours.NODE.colour)
        ax.set_title(f"{step + 1}.  {_TURNS[step]} {_ABOUT[step]}", fontsize="medium")
        fit(ax, data.axes, node, elev=24.0, azim=_between(data.angles[0]), filled=0.8)
    arrow_of_point = _draw_turned_plane(plane, data)
    return EulerStepsArtists(
        axes=(*spaces, plane),
        data=data,
        before=tuple(before),
        after=tuple(after),
        nodes=tuple(nodes),
        point=arrow_of_point,
    )


def _draw_turned_plane(ax: Any, data: EulerSteps) -> Any:
    """The plane of the first turn, with the coordinates of a point along both pairs of axes."""
    longest = max(1.0, 1.15 * float(np.linalg.norm(data.point)))
    for step, names, style in (
        (0, _NAMES[0], {"linewidth": 1.0, "linestyle": "dashed"}),
        (1, _NAMES[1], {"linewidth": 2.4}),
    ):
        for axis, ink in enumerate(colours.AXES[:2]):
            along = longest * data.axes[step, axis, :2]
            arrow_in_plane(ax, along, ink.colour, f"${names[axis]}$", **style)
            foot = (data.point, data.seen)[step][axis] * data.axes[step, axis, :2]
            curve(ax, np.array([data.point, foot]), ink.colour, linewidth=0.9, linestyle="dotted")
    turned = np.linspace(0.0, data.angles[0], 49)[:, np.newaxis]
    curve(
        ax,
        0.35 * longest * np.hstack([np.cos(turned), np.sin(turned)]),
        colours.ANGLE.colour,
    )
    half = 0.5 * data.angles[0]
    label_in_plane(ax, 0.44 * longest * np.array([np.cos(half), np.sin(half)]), _TURNS[0])
    drawn = arrow_in_plane(ax, data.point, colours.HUES["black"], "$P$", linewidth=1.6)
    corners = np.vstack([np.zeros((1, 2)), longest * data.axes[:2, :2, :2].reshape(-1, 2)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.14 * longest
    ax.set_aspect("equal")
    ax.set(
        xlim=(low[0] - margin, high[0] + margin),
        ylim=(low[1] - margin, high[1] + margin),
        title="the first turn seen from $z'$",
    )
    ax.title.set_fontsize("medium")
    ax.set_axis_off()
    return drawn


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NodeFrame:
    """The axes of space, of the body, and those between that follow the line of nodes.

    Attributes
    ----------
    angles : ndarray, shape (3,)
        ``phi, theta, psi`` (rad).
    space, node, body : ndarray, shape (3, 3)
        Unit vectors along the axes, one in a row, in space components. Those of ``node`` are xi
        along the line of nodes ON, eta along OM across it in the equator of the body, and zeta,
        which is body axis z.
    """

    angles: Floats
    space: Floats
    node: Floats
    body: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NodeFrameArtists:
    """What :func:`node_frame` has drawn.

    Attributes
    ----------
    ax : Axes3D
        Where.
    data : NodeFrame
        What.
    space, body : tuple of 3 SpaceArrow
        The axes.
    node : tuple of 2 SpaceArrow
        ON and OM; the third axis is that of the body.
    arcs : tuple of 3 Line3D
        The angles phi, theta, psi.
    """

    ax: Any
    data: NodeFrame
    space: tuple[Any, ...]
    body: tuple[Any, ...]
    node: tuple[Any, ...]
    arcs: tuple[Any, ...]


def node_frame_data(angles: ArrayLike) -> NodeFrame:
    """Axes under :func:`node_frame`.

    Parameters
    ----------
    angles : array_like, shape (3,)
        ``phi, theta, psi`` (rad).

    Returns
    -------
    NodeFrame

    Raises
    ------
    ValueError
        If the angles are not three finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> figures.node_frame_data([0.0, np.pi / 2, 0.3]).node.round(12).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    """
    steps = euler_steps_data(angles)
    return NodeFrame(
        angles=steps.angles, space=steps.axes[0], node=steps.axes[2], body=steps.axes[3]
    )


def node_frame(angles: ArrayLike, *, ax: Any | None = None) -> NodeFrameArtists:
    """Draw the frame of the line of nodes between space and body.

    In it ``omega = (theta', phi' sin theta, phi' cos theta + psi')``: theta changes along ON, phi
    along the vertical ``z'`` and psi along ``z`` (Ercan 2016, fig. 13, eq. (49); the text has the
    last two exchanged, erratum D-24).

    Parameters
    ----------
    angles
        As in :func:`node_frame_data`.
    ax : Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    NodeFrameArtists

    Raises
    ------
    ValueError
        As in :func:`node_frame_data`, and if the axes are not three-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.node_frame([0.9, 0.7, 0.8])
    >>> drawn.ax.figure.savefig("node-frame.png")  # doctest: +SKIP
    """
    data = node_frame_data(angles)
    ax = in_space(ax)
    origin = np.zeros(3)
    for normal in (data.space[2], data.body[2]):
        curve(ax, circle(origin, normal, 1.0), colours.FAINT, linewidth=1.0, zorder=1)
    space = _triad(
        ax,
        data.space,
        origin,
        ("$x'$", "$y'$", r"$z',\ \dot{\phi}$"),
        linewidth=1.0,
        linestyle="dashed",
    )
    body = _triad(ax, data.body, origin, ("$x$", "$y$", r"$z = \zeta,\ \dot{\psi}$"), linewidth=2.4)
    node = tuple(
        arrow(ax, along, colours.NODE.colour, name, linewidth=2.0)
        for along, name in zip(
            data.node[:2], (r"$N,\ \xi,\ \dot{\theta}$", r"$M,\ \eta$"), strict=True
        )
    )
    black = colours.ANGLE.colour
    arcs = tuple(
        arc(ax, about, 0.5 * start, float(angle), black, name)
        for about, start, angle, name in zip(
            (_Z, data.node[0], data.node[2]),
            (_X, data.space[2], data.node[0]),
            data.angles,
            _TURNS,
            strict=True,
        )
    )
    label(ax, np.array([-0.06, -0.06, -0.09]), "$O$", colours.NEUTRAL)
    circles = circle(origin, _Z, 1.0), circle(origin, data.body[2], 1.0)
    fit(ax, *circles, data.space, data.body, elev=24.0, azim=_between(data.angles[0]))
    return NodeFrameArtists(ax=ax, data=data, space=space, body=body, node=node, arcs=arcs)


def _apart(first: Floats, second: Floats) -> Floats:
    """Unit vector across both halves of an angle, on the side of the first; or downwards."""
    gap = first / np.linalg.norm(first) - second / (np.linalg.norm(second) or 1.0)
    size = float(np.linalg.norm(gap))
    return np.asarray(gap / size) if size > 1e-9 else -_Z


def _between(phi: float) -> float:
    """Degrees of azimuth to look from: between the first axis of space and the line of nodes."""
    return float(np.degrees(0.5 * phi)) - 16.0  # aside, so that it does not hide body axis z


def _triad(
    ax: Any, axes: Floats, origin: Floats, names: Sequence[str], **style: Any
) -> tuple[Any, ...]:
    return tuple(
        arrow(ax, along, ink.colour, name, start=origin, **style)
        for along, ink, name in zip(axes, colours.AXES, names, strict=True)
    )
