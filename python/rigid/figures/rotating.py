"""A rotating body: its outline, points, their circles and their velocities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import positive_int, shaped, vector
from ..drawing import colours
from ..drawing.axes3d import AZIM, ELEV, arrow, curve, dots, fit
from ..drawing.shapes import box_faces
from ..drawing.sides import eye, surface
from ..particles import velocity_field
from ..rotations.so3 import rotate
from .picture import Picture
from .symmetric import turning

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RotatingBody(Picture):
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

    def _draw(self, ax: Any) -> None:
        size = float(np.linalg.norm(self.positions, axis=-1).max()) or 1.0
        speeds = np.linalg.norm(self.velocities, axis=-1)
        farthest = int(speeds.argmax())
        direction = self.omega / np.linalg.norm(self.omega)
        heights = self.positions @ direction
        reach = np.array(
            [min(heights.min(), 0.0) - 0.25 * size, max(heights.max(), 0.0) + 0.6 * size]
        )
        shown = [self.circles]
        if self.faces is not None:
            style: dict[str, Any] = {"alpha": 0.6, "linewidths": 1.2, "gid": "faces"}
            towards = eye(ELEV, AZIM)
            surface(ax, self.faces, colours.BODY_FACE, towards, edgecolors=colours.NEUTRAL, **style)
            shown.append(self.faces)
        omega, axis = colours.OMEGA, reach[:, np.newaxis] * direction
        curve(ax, axis, omega.colour, linewidth=1.0, linestyle="dashdot", zorder=1)
        for ring in self.circles:
            curve(ax, ring, colours.FAINT, linewidth=0.9, zorder=1, gid="circles")
        style = {"start": axis[1], "linewidth": 2.6, "gid": "omega"}
        arrow(ax, 0.55 * size * direction, omega.colour, omega.label, **style)
        dots(ax, self.positions, colours.NEUTRAL, markersize=6.0, zorder=6, gid="positions")
        scale = 0.55 * size / speeds[farthest] if speeds[farthest] > 0.0 else 0.0
        law = r"$\mathbf{v} = \boldsymbol{\omega}\times\mathbf{r}$"
        for k, (place, velocity) in enumerate(zip(self.positions, self.velocities, strict=True)):
            name = law if k == farthest else ""
            style = {"start": place, "linewidth": 2.0, "gid": "velocities"}
            arrow(ax, scale * velocity, colours.VELOCITY.colour, name, **style)
        ink, style = colours.POSITION, {"linewidth": 1.6, "zorder": 5, "gid": "position"}
        arrow(ax, self.positions[farthest], ink.colour, ink.label, **style)
        dots(ax, np.zeros(3), colours.HUES["black"], markersize=4.0, zorder=6)
        ends = self.positions + scale * self.velocities
        top = np.outer([reach[0], reach[1] + 0.55 * size], direction)
        fit(ax, *shown, ends, top, elev=ELEV, azim=AZIM)


def rotating_body(
    positions: ArrayLike,
    omega: ArrayLike,
    *,
    sides: ArrayLike | None = None,
    samples: int = 97,
) -> RotatingBody:
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
    RotatingBody

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
