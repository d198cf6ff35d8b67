"""A rotating body: its outline, points, their circles and their velocities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import positive_int, shaped, vector
from ..drawing import colours
from ..drawing.axes3d import arrow, curve, fit, in_space
from ..drawing.colours import on_ground
from ..drawing.shapes import box_faces
from ..drawing.sides import eye, surface
from ..particles import velocity_field
from ..rotations.so3 import rotate
from .symmetric import turning

__all__ = ["RotatingBody", "RotatingBodyArtists", "rotating_body", "rotating_body_data"]

Floats = NDArray[np.float64]

ELEV, AZIM = 22.0, -60.0
FACE = colours.BODY_FACE
"""A light tint of the colour of the body."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RotatingBody:
    """Points of a body that turns about an axis through the origin.

    Attributes
    ----------
    omega : ndarray, shape (3,)
        Angular velocity (rad/s).
    positions, velocities : ndarray, shape (N, 3)
        Positions and velocities of the points (m, m/s): ``v = omega × r``.
    circles : ndarray, shape (N, m, 3)
        The circle on which each point moves (m).
    faces : ndarray, shape (6, 4, 3), or None
        Corners of the faces of the block that represents the body (m).
    """

    omega: Floats
    positions: Floats
    velocities: Floats
    circles: Floats
    faces: Floats | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RotatingBodyArtists:
    """Artists of the figure :func:`rotating_body`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : RotatingBody
        Data of the figure.
    omega, position : SpaceArrow
        Arrows of the angular velocity and of the position of one point, with the attributes
        ``start`` and ``vector``.
    velocities : tuple of N SpaceArrow
        The velocities.
    points : Line3D
        The points.
    block : Poly3DCollection or None
        The block that represents the body.
    """

    ax: Any
    data: RotatingBody
    omega: Any
    position: Any
    velocities: tuple[Any, ...]
    points: Any
    block: Any | None


def rotating_body_data(
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    samples: int = 97,
) -> RotatingBody:
    """Velocities and paths of the figure :func:`rotating_body`.

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
    RotatingBody

    Raises
    ------
    ValueError
        If there are no points, the body does not turn, a side is not positive, or an argument is
        not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> figures.rotating_body_data([[2, 0, 5]], [0, 0, 3]).velocities.tolist()
    [[0.0, 6.0, 0.0]]
    """
    r = shaped("positions", positions, None, 3)
    if r.ndim != 2 or len(r) == 0:
        raise ValueError(f"positions: expected shape (N, 3) of one or more, got {r.shape}")
    w = turning(omega)
    block = None if sides is None else 0.5 * vector("sides", sides, 3)
    if block is not None and not (block > 0.0).all():
        raise ValueError(f"sides = {(2.0 * block).tolist()}: must be positive")
    turns = np.linspace(0.0, 2.0 * np.pi, positive_int("samples", samples, minimum=2))
    return RotatingBody(
        omega=w,
        positions=r,
        velocities=velocity_field(w, r),
        circles=rotate(r[:, np.newaxis, :], w, turns),
        faces=None if block is None else box_faces(block),
    )


def rotating_body(
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    ax: Any | None = None,
) -> RotatingBodyArtists:
    """Draw the points of a rotating body with their velocities ``v = omega × r``.

    Every point moves on a circle about the axis; the point that is farthest from the axis has
    labels (Ercan 2016, fig. 9).

    Parameters
    ----------
    positions, omega, sides
        As in :func:`rotating_body_data`.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    RotatingBodyArtists

    Raises
    ------
    ValueError
        As in :func:`rotating_body_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> from rigid import figures
    >>> corners = [[0.5, -1.0, 0.2], [-0.5, -1.0, -0.2]]
    >>> drawn = figures.rotating_body(corners, [0.0, 0.0, 2.0], sides=(1.0, 2.0, 0.4))
    >>> drawn.ax.figure.savefig("rotating.png")  # doctest: +SKIP
    """
    data = rotating_body_data(positions, omega, sides=sides)
    ax = in_space(ax)
    size = float(np.linalg.norm(data.positions, axis=-1).max()) or 1.0
    speeds = np.linalg.norm(data.velocities, axis=-1)
    farthest = int(speeds.argmax())
    direction = data.omega / np.linalg.norm(data.omega)
    heights = data.positions @ direction
    reach = np.array([min(heights.min(), 0.0) - 0.25 * size, max(heights.max(), 0.0) + 0.6 * size])
    block = None
    shown = [data.circles]
    if data.faces is not None:
        style: dict[str, Any] = {"alpha": 0.6, "edgecolors": colours.NEUTRAL, "linewidths": 1.2}
        block = surface(ax, data.faces, FACE, eye(ELEV, AZIM), **style)
        shown.append(data.faces)
    curve(
        ax,
        reach[:, np.newaxis] * direction,
        colours.OMEGA.colour,
        linewidth=1.0,
        linestyle="dashdot",
        zorder=1,
    )
    for ring in data.circles:
        curve(ax, ring, colours.FAINT, linewidth=0.9, zorder=1)
    spin = arrow(
        ax,
        0.55 * size * direction,
        colours.OMEGA.colour,
        colours.OMEGA.label,
        start=reach[1] * direction,
        linewidth=2.6,
    )
    (points,) = ax.plot(
        *data.positions.T, "o", color=on_ground(ax, colours.NEUTRAL), markersize=6.0, zorder=6
    )
    scale = 0.55 * size / speeds[farthest] if speeds[farthest] > 0.0 else 0.0
    velocities = tuple(
        arrow(
            ax,
            scale * velocity,
            colours.VELOCITY.colour,
            r"$\mathbf{v} = \boldsymbol{\omega}\times\mathbf{r}$" if number == farthest else "",
            start=place,
            linewidth=2.0,
        )
        for number, (place, velocity) in enumerate(
            zip(data.positions, data.velocities, strict=True)
        )
    )
    position = arrow(
        ax,
        data.positions[farthest],
        colours.POSITION.colour,
        colours.POSITION.label,
        linewidth=1.6,
        zorder=5,
    )
    ax.plot(
        [0.0],
        [0.0],
        [0.0],
        "o",
        color=on_ground(ax, colours.HUES["black"]),
        markersize=4.0,
        zorder=6,
    )
    ends = data.positions + scale * data.velocities
    top = np.outer([reach[0], reach[1] + 0.55 * size], direction)
    fit(ax, *shown, ends, top, elev=ELEV, azim=AZIM)
    return RotatingBodyArtists(
        ax=ax,
        data=data,
        omega=spin,
        position=position,
        velocities=velocities,
        points=points,
        block=block,
    )
