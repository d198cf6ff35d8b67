"""Surfaces of simple solids as polygons, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arrays import Floats

STEM = 1.45
"""Height of the end of a top's stem, in distances of the centre of mass from the fixed point."""

# Radii and heights of a top from the fixed point to the end of the stem.
_PROFILE = (
    (0.02, 0.0),
    (0.06, 0.3),
    (1.0, 0.85),
    (1.0, 1.1),
    (0.08, 1.25),
    (0.06, STEM),
    (0.0, STEM),
)


def across(direction: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """A right-handed triad of unit vectors with the direction as the third vector."""
    along = np.asarray(direction, dtype=np.float64)
    along = along / np.linalg.norm(along)
    first = np.eye(3)[np.abs(along).argmin()]
    first = first - along * (first @ along)
    first /= np.linalg.norm(first)
    return first, np.cross(along, first), along


def box_faces(half: ArrayLike) -> Floats:
    """The faces of a box with these half sides, two for each axis, shape (6, 4, 3)."""
    ends = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    faces = np.empty((6, 4, 3))
    for axis in range(3):
        for side in range(2):
            face = faces[2 * axis + side]
            face[:, axis] = 2.0 * side - 1.0
            face[:, [(axis + 1) % 3, (axis + 2) % 3]] = ends
    faces *= np.asarray(half)
    return faces


def ellipsoid_faces(semi_axes: ArrayLike, *, rings: int, sectors: int) -> Floats:
    """An ellipsoid in its principal axes, shape (rings sectors, 4, 3)."""
    tilt = np.linspace(0.0, np.pi, rings + 1)[:, np.newaxis]
    turn = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    sine = np.sin(tilt)
    x, y, z = np.broadcast_arrays(sine * np.cos(turn), sine * np.sin(turn), np.cos(tilt))
    return quads(np.stack([x, y, z], axis=-1) * np.asarray(semi_axes))


def cone_faces(axis: ArrayLike, half_angle: float) -> Floats:
    """A cone of slant 1 with its apex at the origin, without base: 5 rings of 40 faces."""
    first, second, along = across(axis)
    turn = np.linspace(0.0, 2.0 * np.pi, 41)[:, np.newaxis]
    rim = np.cos(half_angle) * along + np.sin(half_angle) * (
        np.cos(turn) * first + np.sin(turn) * second
    )
    return quads(np.linspace(0.0, 1.0, 6)[:, np.newaxis, np.newaxis] * rim)


def plane_face(centre: ArrayLike, normal: ArrayLike, half_width: float) -> Floats:
    """A square, shape (1, 4, 3)."""
    first, second, _ = across(normal)
    corners = [first + second, second - first, -first - second, first - second]
    return np.asarray(centre) + half_width * np.array(corners)[np.newaxis]


def top_faces(direction: ArrayLike, spread: ArrayLike) -> Floats:
    """A spinning top with its fixed point at the origin and its centre of mass at distance one.

    Parameters
    ----------
    direction : array_like, shape (3,)
        Direction to the centre of mass, in the body.
    spread : array_like, shape (3,)
        ``∫ x_i² dm`` along the body axes, which sets the shape perpendicular to the direction.

    Returns
    -------
    ndarray, shape (288, 4, 3)
        48 faces of each circle.
    """
    first, second, along = across(direction)
    plane = np.stack([first, second])
    widths, turned = np.linalg.eigh(plane @ np.diag(np.asarray(spread)) @ plane.T)
    widths = np.sqrt(np.maximum(widths, 0.0))
    widths = np.maximum(0.5 * widths / (widths.max() or 1.0), 0.05)  # a rod has none
    axes = turned.T @ plane
    turn = np.linspace(0.0, 2.0 * np.pi, 49)[:, np.newaxis]
    rim = widths[0] * np.cos(turn) * axes[0] + widths[1] * np.sin(turn) * axes[1]
    return quads(np.stack([radius * rim + height * along for radius, height in _PROFILE]))


def quads(grid: Floats) -> Floats:
    """The faces between the points of a grid, shape (rows columns, 4, 3), row by row."""
    corners = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.stack(corners, axis=-2).reshape(-1, 4, 3)
