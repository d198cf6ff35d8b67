"""Orientation of the axes of a body: from the axes of space, and from the line of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import arc, arrow, circle, curve, fit, in_space, label, triad
from ..drawing.colours import on_ground
from ..rotations.euler import euler_to_matrix
from .eulersteps import TURNS, azimuth, euler_steps_data

__all__ = [
    "Frames",
    "FramesArtists",
    "NodeFrame",
    "NodeFrameArtists",
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
    """Axes of space, parallel axes at the origin of the body, and axes of the body.

    Attributes
    ----------
    space, body : ndarray, shape (3, 3)
        Unit vectors along the axes, as rows, with components in space.
    origin : ndarray, shape (3,)
        ``R``, the origin of the axes of the body (m).
    relative, position : ndarray, shape (3,), or None
        Vectors to a point from the origin of the body, ``r'``, and from the origin of space,
        ``r = R + r'``, with components in space (m).
    """

    space: Floats
    body: Floats
    origin: Floats
    relative: Floats | None
    position: Floats | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FramesArtists:
    """Artists of the figure :func:`frames`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : Frames
        Data of the figure.
    space, parallel, body : tuple of 3 SpaceArrow
        The axes; an arrow has the attributes ``start`` and ``vector``.
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
    """Axes and vectors of the figure :func:`frames`.

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
    Frames

    Raises
    ------
    ValueError
        If an argument is not finite or does not have three numbers.

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
    """Draw the axes of space, parallel axes at the origin of a body, and the axes of the body.

    Three coordinates determine the origin, three angles the orientation; a point of the body is at
    ``r = R + r'`` (Ercan 2016, figs. 1, 6, 7).

    Parameters
    ----------
    angles, origin, point
        As in :func:`frames_data`.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    FramesArtists

    Raises
    ------
    ValueError
        As in :func:`frames_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.frames([0.6, 0.7, 0.4], point=[0.5, 0.9, 0.3])
    >>> drawn.ax.figure.savefig("frames.png")  # doctest: +SKIP
    """
    data = frames_data(angles, origin=origin, point=point)
    ax = in_space(ax)
    space = triad(ax, data.space, np.zeros(3), ("$X'$", "$Y'$", "$Z'$"), linewidth=1.2)
    apart = bool(data.origin.any())
    parallel = triad(
        ax,
        data.space,
        data.origin,
        ("$x'$", "$y'$", "$z'$") if apart else ("", "", ""),
        linewidth=1.0,
        linestyle="dashed",
    )
    body = triad(ax, data.body, data.origin, ("$x$", "$y$", "$z$"), linewidth=2.6)
    label(ax, np.array([-0.09, -0.09, -0.09]), "$O'$" if apart else "$O$", colours.NEUTRAL)
    # Write the names outside the triangle of R, r' and r.
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
        ax.plot(
            *data.position, "o", color=on_ground(ax, colours.HUES["black"]), markersize=5, zorder=6
        )
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
class NodeFrame:
    """The axes of space, the axes of the body, and the axes of the line of nodes.

    Attributes
    ----------
    angles : ndarray, shape (3,)
        ``phi, theta, psi`` (rad).
    space, node, body : ndarray, shape (3, 3)
        Unit vectors along the axes, as rows, with components in space. The axes of ``node`` are xi
        along the line of nodes ON, eta along OM in the equator of the body, perpendicular to ON,
        and zeta, which is body axis z.
    """

    angles: Floats
    space: Floats
    node: Floats
    body: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NodeFrameArtists:
    """Artists of the figure :func:`node_frame`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : NodeFrame
        Data of the figure.
    space, body : tuple of 3 SpaceArrow
        The axes.
    node : tuple of 2 SpaceArrow
        ON and OM; the third axis is body axis z.
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
    """Axes of the figure :func:`node_frame`.

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

    In this frame ``omega = (theta', phi' sin theta, phi' cos theta + psi')``: the rate of theta is
    along ON, the rate of phi along the vertical ``z'``, and the rate of psi along ``z`` (Ercan
    2016, fig. 13, eq. (49); the text exchanges the last two, erratum D-24).

    Parameters
    ----------
    angles
        As in :func:`node_frame_data`.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    NodeFrameArtists

    Raises
    ------
    ValueError
        As in :func:`node_frame_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

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
    space = triad(
        ax,
        data.space,
        origin,
        ("$x'$", "$y'$", r"$z',\ \dot{\phi}$"),
        linewidth=1.0,
        linestyle="dashed",
    )
    body = triad(ax, data.body, origin, ("$x$", "$y$", r"$z = \zeta,\ \dot{\psi}$"), linewidth=2.4)
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
            TURNS,
            strict=True,
        )
    )
    label(ax, np.array([-0.06, -0.06, -0.09]), "$O$", colours.NEUTRAL)
    circles = circle(origin, _Z, 1.0), circle(origin, data.body[2], 1.0)
    fit(ax, *circles, data.space, data.body, elev=24.0, azim=azimuth(data.angles[0]))
    return NodeFrameArtists(ax=ax, data=data, space=space, body=body, node=node, arcs=arcs)


def _apart(first: Floats, second: Floats) -> Floats:
    """Unit vector perpendicular to the bisector, on the side of ``first``; or downwards."""
    gap = first / np.linalg.norm(first) - second / (np.linalg.norm(second) or 1.0)
    size = float(np.linalg.norm(gap))
    return np.asarray(gap / size) if size > 1e-9 else -_Z
