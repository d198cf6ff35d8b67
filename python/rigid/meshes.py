"""Closed triangle meshes: mass properties of the homogeneous solid inside, exactly.

By the divergence theorem the integrals over the volume are sums over signed tetrahedra, one for
each triangle with a common inner point (B. Mirtich, *Journal of Graphics Tools* 1 (2) (1996) 31).
The second moments of a tetrahedron have a closed form (F. Tonon, *Journal of Mathematics and
Statistics* 1 (2005) 8). The functions measure lengths from the middle of the mesh in units of its
size. So a mesh far from the origin, a tiny mesh and a huge mesh lose no digits.
"""

from __future__ import annotations

import codecs
import io
import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import finite_float, first_place, one_line, one_of, shaped
from ._checks.arrays import Floats
from ._checks.extras import install_extra
from ._checks.overflow import refuses_overflow
from ._checks.quantities import LARGE_SIDE, LEAST_DENSITY, plain
from ._checks.warned import warn_caller
from .rotations import quaternion_to_matrix
from .solids.mass_properties import MassProperties, tensor_of_squares

__all__ = ["file_properties", "mesh_properties", "read_mesh"]

Indices = NDArray[np.int64]

_SLIVER = 1e-14
"""A triangle counts as a line if the sine of the angle between two sides is at most this."""

_ROUNDING = 1e-15
"""Rounding error of a sum of volumes, relative to its terms."""

_SAME_CORNER = 4.0 * float(np.finfo(np.float32).eps)
"""Corners are one if they differ by less than this share of the largest coordinate. Files of meshes
hold single precision, and each triangle has a copy of its corners."""

_TOUCHING = 1e-4
"""Overlaps count from this share of the size of the mesh on: parts pressed together touch."""

_LINES = 64
"""Lines through the common box of two surfaces: an overlap over 1/10 of it escapes one in 900."""

_MOST_LINES, _MOST_CROSSINGS = 4096, 400_000_000
"""Lines, and lines times triangles, of one mesh: one second."""

_READ_FORMATS = ("obj", "off", "ply", "stl")

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
"""Units of length by their names (m)."""


@refuses_overflow
def mesh_properties(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    density: ArrayLike | None = None,
    mass: ArrayLike | None = None,
    unit: float | str | None = None,
) -> MassProperties:
    """Mass, centre and tensor of inertia of the homogeneous solid inside a closed mesh.

    Parameters
    ----------
    vertices : array_like, shape (..., v, 3)
        Corners; leading axes count bodies with the same faces.
    faces : array_like of int, shape (f, 3)
        Indices of the corners of each triangle, from 0, counterclockwise seen from outside. Several
        closed surfaces are allowed: separate bodies, or cavities (counterclockwise seen from inside
        the cavity). Whether they overlap is looked for on up to 64 lines through the box that two
        surfaces share; a surface that cuts itself is not found.
    density : array_like, shape (...), optional
        Density (kg/m³); 1 if neither density nor mass is given.
    mass : array_like, shape (...), optional
        Mass (kg). Pass either the mass or the density.
    unit : float or {"m", "cm", "mm", "in"}, optional
        The unit of the corners, or its length in m; m if it is not given.

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        If the mesh is open, not consistently oriented or inside out, if its surfaces overlap, or if
        it has a triangle without area or an edge of more than two triangles; the message names the
        triangle or edge. If a result would leave the range of doubles.

    Warns
    -----
    UserWarning
        If a mesh without ``unit`` is longer than 5 m, and a density is given, or a mass too small
        for any solid: the corners are probably in mm.

    Examples
    --------
    >>> from rigid import meshes
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> solid = meshes.mesh_properties(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> float(6 * solid.mass), solid.centre
    (1.0, array([0.25, 0.25, 0.25]))
    """
    points = _metres(unit) * shaped("vertices", vertices, 3)
    if points.ndim < 2:
        raise ValueError(f"vertices: expected shape (..., v, 3), got {points.shape}")
    triangles = _triangles(faces, points.shape[-2])
    _check_closed(triangles)

    used = points[..., np.unique(triangles), :]
    low, high = used.min(axis=-2), used.max(axis=-2)
    middle = low + 0.5 * (high - low)
    # A power of two, so that the division is exact.
    size = np.ldexp(1.0, np.frexp((high - low).max(axis=-1))[1])
    local = (points - middle[..., None, :]) / size[..., None, None]
    _check_areas(local, triangles)
    volume, first, _, rounding = _moments(local, triangles)
    inside = volume > rounding
    if np.any(~inside):
        index, place = first_place(~inside)
        raise ValueError(
            f"vertices{place}: the volume inside is {volume[index] * size[index] ** 3:.3g}; the "
            "mesh is inside out (list the corners of each face in the other order) or encloses "
            "nothing"
        )
    _check_surfaces(local, triangles)
    inner = first / volume[..., None]
    local = local - inner[..., None, :]
    volume, first, second, _ = _moments(local, triangles)
    rest = first / volume[..., None]  # rounding of the first centre
    total = _mass(density, mass, volume * size**3)
    spread = (second / volume[..., None, None]) - rest[..., :, None] * rest[..., None, :]
    square = (size * size)[..., None, None] * spread
    if unit is None and (density is not None or mass is not None):
        _warn_of_unit((high - low).max(axis=-1), total, volume * size**3, density is None)
    return MassProperties(
        mass=total,
        centre=middle + size[..., None] * (inner + rest),
        tensor=total[..., None, None] * tensor_of_squares(square),
    )


def read_mesh(
    path: str | os.PathLike[str], *, unit: float | str = 1.0, kind: str | None = None
) -> tuple[Floats, Indices]:
    """Corners and triangles of a file in STL, OBJ, PLY or OFF, for :func:`mesh_properties`.

    Corners that the file repeats are merged, as STL repeats them for each triangle. Polygons become
    triangles, and several objects one mesh. The file is read by trimesh, extra ``mesh``.

    Parameters
    ----------
    path : path-like
    unit : float or {"m", "cm", "mm", "in"}
        The unit of the file, or its length in m. Files do not contain their unit.
    kind : {"stl", "obj", "ply", "off"}, optional
        Format of the file, if the suffix does not name it.

    Returns
    -------
    vertices : ndarray, shape (v, 3)
        Corners (m).
    faces : ndarray of int, shape (f, 3)

    Raises
    ------
    ValueError
        Naming the path: for another format, a file that is cut, or a file without triangles.
    OSError
        If the file cannot be read.
    ImportError
        Without trimesh.

    Examples
    --------
    >>> import os, tempfile, trimesh
    >>> from rigid import meshes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "box.stl")
    ...     _ = trimesh.creation.box((250.0, 80.0, 10.0)).export(path)
    ...     vertices, faces = meshes.read_mesh(path, unit="mm")
    >>> vertices.shape, faces.shape
    ((8, 3), (12, 3))
    """
    file = Path(path)
    metres = _metres(unit)
    if kind is None and file.suffix.lower()[1:] not in _READ_FORMATS:
        known = ", ".join(f".{name}" for name in _READ_FORMATS)
        raise ValueError(f"path = {str(path)!r}: the suffix must be one of {known}; or give kind")
    kind = one_of("kind", kind or file.suffix.lower()[1:], _READ_FORMATS)
    try:
        import trimesh
    except ImportError:
        raise ImportError(install_extra("meshes of files need trimesh", "mesh")) from None
    try:
        data = _without_names(file.read_bytes(), kind)
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type=kind, process=False)
        corners = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
    except OSError:
        raise
    except Exception as error:  # a reader fails in many ways at a damaged file
        raise ValueError(
            f"path = {str(path)!r}: cannot be read as {kind} ({one_line(error)})"
        ) from None
    if not len(triangles):
        raise ValueError(f"path = {str(path)!r}: has no triangles that can be read as {kind}")
    if not np.isfinite(corners).all():
        raise ValueError(f"path = {str(path)!r}: a corner is not finite")
    vertices, faces = _merged(corners, triangles)
    return metres * vertices, faces


def file_properties(
    path: str | os.PathLike[str],
    *,
    density: float | None = None,
    mass: float | None = None,
    unit: float | str | None = None,
    kind: str | None = None,
) -> MassProperties:
    """Mass, centre and tensor of inertia of the homogeneous solid in a file of a closed mesh.

    Parameters
    ----------
    path, kind
        As in :func:`read_mesh`.
    density, mass, unit
        As in :func:`mesh_properties`.

    Returns
    -------
    MassProperties
        In the axes of the file, lengths in m.

    Raises
    ------
    ValueError, OSError, ImportError
        As :func:`read_mesh` and :func:`mesh_properties`, naming the path.

    Warns
    -----
    UserWarning
        As :func:`mesh_properties`.

    Examples
    --------
    >>> import os, tempfile, trimesh
    >>> from rigid import meshes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "box.stl")
    ...     _ = trimesh.creation.box((250.0, 80.0, 10.0)).export(path)
    ...     properties = meshes.file_properties(path, mass=0.3, unit="mm")
    >>> (properties.tensor.diagonal() * 1e6).round(6)
    array([ 162.5, 1565. , 1722.5])
    """
    vertices, faces = read_mesh(path, kind=kind)
    try:
        return mesh_properties(vertices, faces, density=density, mass=mass, unit=unit)
    except ValueError as error:
        reason = str(error).replace("; corners stored several times must be merged first", "")
        raise ValueError(f"path = {str(path)!r}: {reason}") from None


def _metres(unit: float | str | None) -> float:
    """The length of a unit."""
    if isinstance(unit, str):
        return _UNITS[one_of("unit", unit, _UNITS)]
    return 1.0 if unit is None else finite_float("unit", unit, positive=True)


def _warn_of_unit(length: Floats, mass: Floats, volume: Floats, is_given: bool) -> None:
    """Warn of large meshes, unless the given mass is a possible one; 1 stands for any mass."""
    light = (mass < LEAST_DENSITY * volume) & (mass != 1.0)
    large = (length > LARGE_SIDE) & (light | (not is_given))
    if np.any(large):
        index, place = first_place(large)
        warn_caller(
            f"vertices{place}: the mesh is {length[index]:.4g} m long, and its unit is not given; "
            "give unit='mm', or unit='m' if it is so long"
        )


def _without_names(data: bytes, kind: str) -> bytes:
    """A file whose text has ASCII only: names and comments may be in any encoding.

    Raises
    ------
    ValueError
        For an STL file that is cut.
    """
    if kind == "stl":
        count = int.from_bytes(data[80:84], "little")
        whole = 84 + 50 * count
        if len(data) == whole and count:
            return data
        if data.removeprefix(b"\xef\xbb\xbf").lstrip()[:5].lower() != b"solid":
            if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
                raise ValueError("the file is text of 16 bits (UTF-16); save it as UTF-8")
            if data[:84].isascii() and b"\0" not in data[:84] and b"\n" in data[:84]:
                raise ValueError(
                    "a text that does not begin with 'solid' is no STL file; "
                    "rigid.Body.from_obj reads OBJ"
                )
            raise ValueError(
                f"the file is cut: it has {len(data)} bytes, and its {count} triangles take {whole}"
                if len(data) < max(whole, 84)
                else f"{len(data) - whole} bytes follow its {count} triangles"
            )
        if b"endsolid" not in data.lower():
            raise ValueError("the file is cut: it has no 'endsolid'")
    text, end, rest = data.partition(b"end_header") if kind == "ply" else (data, b"", b"")
    # From a byte beyond ASCII on, the rest of a line is a name; its bytes may look like "\\".
    return re.sub(rb"[\x80-\xff][^\r\n]*", b"", text.removeprefix(b"\xef\xbb\xbf")) + end + rest


def _merged(corners: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Corners in one place made one; triangles that lose a corner by this are omitted."""
    near = _SAME_CORNER * float(np.abs(corners).max())
    label = np.zeros(len(corners), dtype=np.int64)
    count = 0
    # Groups are cut at gaps along one axis after the other until no axis has a gap.
    while True:
        for axis in range(3):
            order = np.lexsort((corners[:, axis], label))
            far = np.diff(corners[order, axis]) > near
            label[order] = np.cumsum(np.concatenate([[0], far | (np.diff(label[order]) > 0)]))
        if label.max() == count:
            break
        count = int(label.max())
    _, first = np.unique(label, return_index=True)
    faces = label[triangles]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return corners[first], faces[whole]


def _triangles(faces: ArrayLike, count: int) -> Indices:
    array = np.asarray(plain("faces", faces))
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

    place = np.minimum(np.searchsorted(edges, back), len(edges) - 1)
    both = counts[inverse] + np.where(edges[place] == back, counts[place], 0)
    if np.any(both > 2):
        raise ValueError(f"{said(both > 2)}: an edge of more than two triangles")
    if np.any(counts > 1):
        raise ValueError(
            f"{said(counts[inverse] > 1)}: the neighbour runs through the edge in the same "
            "direction; the faces are not consistently oriented"
        )
    if np.any(both < 2):
        bad = both < 2
        raise ValueError(
            f"{said(bad)}: no triangle on its other side; the mesh is open ({int(bad.sum())} such "
            "edges; corners stored several times must be merged first)"
        )


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
    corners = np.moveaxis(np.stack(_bluntest_first(local, triangles), -2), -3, 0)  # (f, ..., 3, 3)
    shape = (len(first), *corners.shape[1:-2])
    volume = np.zeros(shape)
    np.add.at(volume, surface, _volumes(*np.moveaxis(corners, -2, 0)))
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
    for place in np.ndindex(shape[1:]):
        body = (slice(None), *place)
        bad = _overlapping(corners[body], low[body], high[body])
        if bad is not None:
            raise ValueError(
                f"faces[{bad}] = {triangles[bad].tolist()}: the surface of this triangle overlaps "
                "another, and what both contain would count twice, or a cavity leaves its body; "
                "join the parts first (a boolean union)"
            )


def _overlapping(corners: Floats, low: Floats, high: Floats) -> int | None:
    """A triangle where the winding number of the surfaces becomes other than 0 or 1, or None.

    The winding number changes by one at each triangle that a line crosses. The lines have one
    direction, through random points of the box (``low`` to ``high``) that two surfaces share.
    """
    first, second = np.triu_indices(len(low), 1)
    begin, end = np.maximum(low[first], low[second]), np.minimum(high[first], high[second])
    shared = (end - begin > _TOUCHING).all(axis=-1)
    if not shared.any():
        return None
    begin, end = begin[shared], end[shared]
    most = min(_MOST_LINES, _MOST_CROSSINGS // len(corners)) // len(begin)
    draws = np.random.default_rng(0).random((min(max(most, 1), _LINES), *begin.shape))
    turn = quaternion_to_matrix([0.36, 0.48, 0.64, 0.48])  # along no axis
    points = (begin + draws * (end - begin)).reshape(-1, 3)[:_MOST_LINES] @ turn
    flat, height = (corners @ turn)[..., :2], (corners @ turn)[..., 2]
    (left, down), (right, up) = flat.min(axis=1).T.copy(), flat.max(axis=1).T.copy()
    for point in points[:, :2]:
        within = (left <= point[0]) & (point[0] <= right) & (down <= point[1]) & (point[1] <= up)
        near = np.flatnonzero(within)
        x, y = np.moveaxis(flat[near] - point, -1, 0)
        areas = np.roll(x, -1, 1) * np.roll(y, -2, 1) - np.roll(x, -2, 1) * np.roll(y, -1, 1)
        hit = (areas > 0.0).all(axis=1) | (areas < 0.0).all(axis=1)
        near, areas = near[hit], areas[hit]
        at = (areas * height[near]).sum(axis=1) / areas.sum(axis=1)
        order = np.argsort(at)
        winding = np.cumsum(np.where(areas[order, 0] < 0.0, 1, -1))
        if not len(winding) or winding[-1] != 0:  # a line through an edge
            continue
        wrong = ((winding[:-1] < 0) | (winding[:-1] > 1)) & (np.diff(at[order]) > _TOUCHING)
        if wrong.any():
            return int(near[order][np.argmax(wrong)])
    return None


def _moments(r: Floats, triangles: Indices) -> tuple[Floats, Floats, Floats, Floats]:
    """Volume, integrals of ``r`` and of ``r ⊗ r`` over the volume, and rounding of the volume.

    The integrals over the tetrahedron of the origin and ``a, b, c`` are ``d/6``, ``d/24 s`` and
    ``d/120 (a ⊗ a + b ⊗ b + c ⊗ c + s ⊗ s)`` with ``d = a·b×c``, ``s = a + b + c``.
    """
    a, b, c = _bluntest_first(r, triangles)
    d = _volumes(a, b, c)
    s = a + b + c
    corners, weights = np.concatenate([a, b, c, s], axis=-2), np.tile(d, 4)
    second = np.swapaxes(corners, -1, -2) @ (weights[..., None] * corners) / 120.0
    first = (d[..., None] * s).sum(axis=-2) / 24.0
    return np.asarray(d.sum(axis=-1) / 6.0), first, second, _ROUNDING * np.abs(d).sum(axis=-1)


def _bluntest_first(r: Floats, triangles: Indices) -> tuple[Floats, Floats, Floats]:
    """Corners (..., f, 3) of the triangles, each from the corner across its longest side on."""
    corners = r[..., triangles, :]
    sides = np.linalg.norm(np.roll(corners, -1, axis=-2) - np.roll(corners, 1, axis=-2), axis=-1)
    turn = (np.argmax(sides, axis=-1)[..., None] + np.arange(3)) % 3
    first, second, third = np.moveaxis(np.take_along_axis(corners, turn[..., None], -2), -2, 0)
    return first, second, third


def _volumes(a: Floats, b: Floats, c: Floats) -> Floats:
    """``a·b×c``: products of sides keep the digits that products of far corners lose."""
    return np.asarray(np.vecdot(a, np.cross(b - a, c - a)))


def _mass(density: ArrayLike | None, mass: ArrayLike | None, volume: Floats) -> Floats:
    if density is not None and mass is not None:
        raise ValueError("density and mass: give one of them, the other follows")
    if mass is not None:
        return np.broadcast_to(shaped("mass", mass, positive=True), volume.shape)
    return shaped("density", 1.0 if density is None else density, positive=True) * volume
