"""Closed triangle meshes: mass properties of the homogeneous solid inside, exactly.

By the divergence theorem the integrals over the volume are sums over signed tetrahedra, one for
each triangle with a common inner point (B. Mirtich, *Journal of Graphics Tools* 1 (2) (1996) 31).
The second moments of a tetrahedron have a closed form (F. Tonon, *Journal of Mathematics and
Statistics* 1 (2005) 8). The functions measure lengths from the middle of the mesh in units of its
size, so that a mesh far from the origin, a tiny mesh and a huge mesh lose no digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import first_place, shaped
from .inertia.mass_properties import MassProperties, tensor_of_squares

__all__ = ["mesh_properties"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_SLIVER = 1e-14
"""A triangle counts as a line if the sine of the angle between two sides is at most this."""

_ROUNDING = 1e-15
"""Rounding error of a sum of volumes, relative to its terms."""


def mesh_properties(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    density: ArrayLike | None = None,
    mass: ArrayLike | None = None,
) -> MassProperties:
    """Mass, centre and tensor of inertia of the homogeneous solid inside a closed mesh.

    Parameters
    ----------
    vertices : array_like, shape (..., v, 3)
        Corners (m); leading axes count bodies with the same faces.
    faces : array_like of int, shape (f, 3)
        Indices of the corners of each triangle, from 0, counterclockwise seen from outside. Several
        closed surfaces are allowed: separate bodies, or cavities (counterclockwise seen from inside
        the cavity). The function does not check whether surfaces intersect.
    density : array_like, shape (...), optional
        Density (kg/m³); 1 if neither density nor mass is given.
    mass : array_like, shape (...), optional
        Mass (kg). Pass either the mass or the density.

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        If the mesh is open, not consistently oriented or inside out, or if it has a triangle
        without area or an edge of more than two triangles. The message names the triangle or edge.

    Examples
    --------
    >>> from rigid import meshes
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> solid = meshes.mesh_properties(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> float(6 * solid.mass), solid.centre
    (1.0, array([0.25, 0.25, 0.25]))
    """
    points = shaped("vertices", vertices, 3)
    if points.ndim < 2:
        raise ValueError(f"vertices: expected shape (..., v, 3), got {points.shape}")
    triangles = _triangles(faces, points.shape[-2])
    _check_closed(triangles)

    used = points[..., np.unique(triangles), :]
    low, high = used.min(axis=-2), used.max(axis=-2)
    middle = low + 0.5 * (high - low)
    # A power of two, so that the division is exact.
    unit = np.ldexp(1.0, np.frexp((high - low).max(axis=-1))[1])
    local = (points - middle[..., None, :]) / unit[..., None, None]
    _check_areas(local, triangles)
    volume, first, _, rounding = _moments(local, triangles)
    inside = volume > rounding
    if np.any(~inside):
        index, place = first_place(~inside)
        raise ValueError(
            f"vertices{place}: the volume inside is {volume[index] * unit[index] ** 3:.3g}; the "
            "mesh is inside out (list the corners of each face in the other order) or encloses "
            "nothing"
        )
    _check_surfaces(local, triangles)
    inner = first / volume[..., None]
    local = local - inner[..., None, :]
    volume, first, second, _ = _moments(local, triangles)
    rest = first / volume[..., None]  # rounding of the first centre
    total = _mass(density, mass, volume * unit**3)
    spread = (second / volume[..., None, None]) - rest[..., :, None] * rest[..., None, :]
    square = (unit * unit)[..., None, None] * spread
    return MassProperties(
        mass=total,
        centre=middle + unit[..., None] * (inner + rest),
        tensor=total[..., None, None] * tensor_of_squares(square),
    )


def _triangles(faces: ArrayLike, count: int) -> Indices:
    array = np.asarray(faces)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu" or not len(array):
        raise ValueError(
            f"faces: expected whole numbers of shape (f, 3), got {array.dtype} of shape "
            f"{array.shape}"
        )
    if array.min() < 0 or array.max() >= count:
        index, _ = first_place((array < 0) | (array >= count))
        raise ValueError(
            f"faces{list(index)} = {array[index]}: there is no such corner among {count} vertices"
        )
    twice = (array == np.roll(array, 1, axis=1)).any(axis=1)
    if np.any(twice):
        k = int(np.argmax(twice))
        raise ValueError(f"faces[{k}] = {array[k].tolist()}: a triangle with a corner twice")
    return array.astype(np.int64)


def _check_closed(triangles: Indices) -> None:
    """Raise ValueError unless two triangles share each edge, with opposite directions."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    base = int(triangles.max()) + 1
    there, back = start * base + end, end * base + start
    edges, inverse, counts = np.unique(there, return_inverse=True, return_counts=True)

    def said(bad: NDArray[np.bool_]) -> str:
        k = int(np.argmax(bad))
        return f"faces[{k // 3}] = {triangles[k // 3].tolist()}, edge {start[k]}-{end[k]}"

    both = counts[inverse] + _count(edges, counts, back)
    if np.any(both > 2):
        bad = both > 2
        raise ValueError(f"{said(bad)}: an edge of more than two triangles")
    if np.any(counts > 1):
        bad = counts[inverse] > 1
        raise ValueError(
            f"{said(bad)}: the neighbour runs through the edge in the same direction; the faces "
            "are not consistently oriented"
        )
    if np.any(both < 2):
        bad = both < 2
        raise ValueError(
            f"{said(bad)}: no triangle on its other side; the mesh is open ({int(bad.sum())} such "
            "edges; corners stored several times must be merged first)"
        )


def _count(known: Indices, counts: Indices, wanted: Indices) -> Indices:
    """The count of each requested value."""
    place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[place] == wanted, counts[place], 0)


def _check_areas(local: Floats, triangles: Indices) -> None:
    a, b, c = (local[..., triangles[:, k], :] for k in range(3))
    sides = np.linalg.norm(b - a, axis=-1) * np.linalg.norm(c - a, axis=-1)
    flat = np.linalg.norm(np.cross(b - a, c - a), axis=-1) <= _SLIVER * sides
    if np.any(flat):
        index, _ = first_place(flat)
        k = index[-1]
        raise ValueError(
            f"faces[{k}] = {triangles[k].tolist()}: a triangle without area, its corners are on a "
            "line or in one place"
        )


def _check_surfaces(local: Floats, triangles: Indices) -> None:
    """Raise ValueError unless each surface with a negative volume lies inside another surface."""
    label = np.arange(int(triangles.max()) + 1)
    while True:
        smallest = label[triangles].min(axis=1)
        if np.array_equal(label[triangles], np.repeat(smallest[:, None], 3, axis=1)):
            break
        np.minimum.at(label, triangles, smallest[:, None])
        label = label[label]
    _, first, surface = np.unique(smallest, return_index=True, return_inverse=True)
    corners = np.moveaxis(local[..., triangles, :], -3, 0)  # (f, ..., 3, 3)
    shape = (len(first), *corners.shape[1:-2])
    volume = np.zeros(shape)
    np.add.at(volume, surface, np.linalg.det(corners))
    low, high = np.full((*shape, 3), np.inf), np.full((*shape, 3), -np.inf)
    np.minimum.at(low, surface, corners.min(axis=-2))
    np.maximum.at(high, surface, corners.max(axis=-2))
    within = np.all((low[:, None] >= low) & (high[:, None] <= high), axis=-1)
    lost = (volume < 0.0) & ~np.any(within & (volume > 0.0), axis=1)
    if np.any(lost):
        k = int(first[first_place(lost)[0][0]])
        raise ValueError(
            f"faces[{k}] = {triangles[k].tolist()}: the surface of this triangle is inside out and "
            "is no cavity of another surface"
        )


def _moments(r: Floats, triangles: Indices) -> tuple[Floats, Floats, Floats, Floats]:
    """Volume, integrals of ``r`` and of ``r ⊗ r`` over the volume, and rounding of the volume.

    The integrals over the tetrahedron of the origin and ``a, b, c`` are ``d/6``, ``d/24 s`` and
    ``d/120 (a ⊗ a + b ⊗ b + c ⊗ c + s ⊗ s)`` with ``d = a·b×c``, ``s = a + b + c``.
    """
    a, b, c = (r[..., triangles[:, k], :] for k in range(3))
    d = np.vecdot(a, np.cross(b, c))
    s = a + b + c
    corners = np.concatenate([a, b, c, s], axis=-2)
    weights = np.concatenate([d, d, d, d], axis=-1)
    second: Floats = np.swapaxes(corners, -1, -2) @ (weights[..., None] * corners) / 120.0
    first: Floats = (d[..., None] * s).sum(axis=-2) / 24.0
    volume: Floats = np.asarray(d.sum(axis=-1) / 6.0)
    return volume, first, second, _ROUNDING * np.abs(d).sum(axis=-1)


def _mass(density: ArrayLike | None, mass: ArrayLike | None, volume: Floats) -> Floats:
    if density is not None and mass is not None:
        raise ValueError("density and mass: give one of them, the other follows")
    if mass is not None:
        return np.broadcast_to(shaped("mass", mass, positive=True), volume.shape)
    total: Floats = shaped("density", 1.0 if density is None else density, positive=True) * volume
    return total
