"""Orientation of the axes of a body: from the axes of space, and from the line of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import vector
from ..drawing import colours
from ..drawing.axes3d import UP, arc, arrow, circle, curve, dots, fit, label, triad
from ..rotations.euler import euler_to_matrix
from .eulersteps import TURNS, azimuth, euler_steps
from .picture import Picture

Floats = NDArray[np.float64]

_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frames(Picture):
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

    def _draw(self, ax: Any) -> None:
        names = ("$X'$", "$Y'$", "$Z'$")
        triad(ax, self.space, np.zeros(3), names, linewidth=1.2, gid="space")
        apart = bool(self.origin.any())
        names = ("$x'$", "$y'$", "$z'$") if apart else ("", "", "")
        dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
        triad(ax, self.space, self.origin, names, gid="parallel", **dashed)
        triad(ax, self.body, self.origin, ("$x$", "$y$", "$z$"), linewidth=2.6, gid="body")
        label(ax, np.array([-0.09, -0.09, -0.09]), "$O'$" if apart else "$O$", colours.NEUTRAL)
        # Write the names outside the triangle of R, r' and r.
        aside = _apart(self.origin, self.position) if apart and self.position is not None else -UP
        if apart:
            arrow(ax, self.origin, colours.SPACE.colour, linewidth=1.6, gid="origin")
            label(ax, 0.5 * self.origin + 0.12 * aside, r"$\mathbf{R}$", colours.SPACE.colour)
            label(ax, self.origin - 0.13 * UP, "$O$", colours.NEUTRAL)
        shown = [np.zeros((1, 3)), self.space, self.origin + self.space, self.origin + self.body]
        if self.relative is not None and self.position is not None:
            colour = colours.BODY.colour
            black = colours.POSITION.colour
            start = self.origin
            arrow(ax, self.relative, colour, start=start, linewidth=1.6, gid="relative")
            arrow(ax, self.position, black, linewidth=1.6, gid="position")
            dots(ax, self.position, black, markersize=5, zorder=6)
            label(ax, self.position + 0.12 * UP, "$P$")
            label(ax, self.origin + 0.6 * self.relative + 0.1 * aside, r"$\mathbf{r}'$", colour)
            label(ax, 0.45 * self.position - 0.12 * aside, colours.POSITION.label)
            shown.append(self.position)
        fit(ax, *shown, elev=20.0, azim=-65.0)


def frames(
    angles: ArrayLike, *, origin: ArrayLike = (1.6, 1.2, 0.5), point: ArrayLike | None = None
) -> Frames:
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
    Frames

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
    return Frames(
        space=np.eye(3),
        body=body,
        origin=place,
        relative=relative,
        position=None if relative is None else place + relative,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NodeFrame(Picture):
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

    def _draw(self, ax: Any) -> None:
        origin = np.zeros(3)
        for normal in (self.space[2], self.body[2]):
            curve(ax, circle(origin, normal, 1.0), colours.FAINT, linewidth=1.0, zorder=1)
        names = ("$x'$", "$y'$", r"$z',\ \dot{\phi}$")
        dashed: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}
        triad(ax, self.space, origin, names, gid="space", **dashed)
        names = ("$x$", "$y$", r"$z = \zeta,\ \dot{\psi}$")
        triad(ax, self.body, origin, names, linewidth=2.4, gid="body")
        for along, name in zip(
            self.node[:2], (r"$N,\ \xi,\ \dot{\theta}$", r"$M,\ \eta$"), strict=True
        ):
            arrow(ax, along, colours.NODE.colour, name, linewidth=2.0, gid="node")
        for about, start, angle, name in zip(
            (UP, self.node[0], self.node[2]),
            (_X, self.space[2], self.node[0]),
            self.angles,
            TURNS,
            strict=True,
        ):
            arc(ax, about, 0.5 * start, float(angle), colours.ANGLE.colour, name, gid="angles")
        label(ax, np.array([-0.06, -0.06, -0.09]), "$O$", colours.NEUTRAL)
        circles = circle(origin, UP, 1.0), circle(origin, self.body[2], 1.0)
        fit(ax, *circles, self.space, self.body, elev=24.0, azim=azimuth(self.angles[0]))


def node_frame(angles: ArrayLike) -> NodeFrame:
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
    NodeFrame

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
    return NodeFrame(
        angles=steps.angles, space=steps.axes[0], node=steps.axes[2], body=steps.axes[3]
    )


def _apart(first: Floats, second: Floats) -> Floats:
    """Unit vector perpendicular to the bisector, on the side of ``first``; or downwards."""
    gap = first / np.linalg.norm(first) - second / (np.linalg.norm(second) or 1.0)
    size = float(np.linalg.norm(gap))
    return np.asarray(gap / size) if size > 1e-9 else -UP
