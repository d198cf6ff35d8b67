"""Symmetries of a system of mass points, and the principal axes that follow from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, shaped
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from ..rotations.quaternions import log_so3
from ..solids.mass_properties import point_masses

_AT_ONCE = 1_000_000
"""Number of points whose images are searched at once; bounds the memory."""

_ONE_LINE = 1e-8
"""Directions are parallel if the cosine of their angle differs from 1 by less than this."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symmetry:
    """Mirror planes and symmetry axes of mass points, all through the centre of mass.

    Attributes
    ----------
    centre : ndarray, shape (3,)
        Centre of mass (m).
    planes : ndarray, shape (p, 3)
        Unit normals of the mirror planes; each is a principal axis. For points on a line only the
        plane perpendicular to the line is listed, although every plane through the line is another.
    axes : ndarray, shape (a, 3)
        Unit vectors along the symmetry axes, the highest order first. Each is a principal axis; an
        axis of order 3 or more makes the other two moments equal.
    orders : ndarray of int, shape (a,)
        A turn by ``2 pi / order`` maps the points onto themselves; 0 if every turn does, as about
                the line of points on a line.
    inversion : bool
        Whether the point reflection in the centre of mass maps the points onto themselves.
    size : int
        Number of rotations and rotary reflections, with the identity, that map the points onto
                themselves; 0 if there are infinitely many.
    """

    centre: Floats
    planes: Floats
    axes: Floats
    orders: NDArray[np.intp]
    inversion: bool
    size: int


@refuses_overflow
def symmetry_check(
    points: ArrayLike, masses: ArrayLike | None = None, *, tolerance: float = 1e-8
) -> Symmetry:
    """Mirror planes and symmetry axes of a system of mass points.

    A symmetry maps a pair of points to a pair with the same masses and distances; the function
    tries all such pairs. Many points at one distance from the centre take long: a ring of a
    thousand points takes some seconds.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Positions of the mass points (m), all different.
    masses : array_like, shape (n,), optional
        Masses (kg), not negative; equal by default.
    tolerance : float
        Largest distance of an image from its point, as a fraction of the radius of the points.

    Returns
    -------
    Symmetry

    Raises
    ------
    ValueError
        If all mass is in one point, which has every symmetry.
    ImportError
        Without SciPy.

    Examples
    --------
    >>> from rigid import inertia
    >>> triangle = [[1.0, 0.0, 0.0], [-0.5, 0.75**0.5, 0.0], [-0.5, -(0.75**0.5), 0.0]]
    >>> found = inertia.symmetry_check(triangle)
    >>> found.orders.tolist(), len(found.planes), found.size
    ([3, 2, 2, 2], 4, 12)
    """
    r = shaped("points", points, 3)
    m = np.ones(r.shape[:-1]) if masses is None else shaped("masses", masses)
    if r.ndim != 2 or m.shape != r.shape[:1]:
        raise ValueError(
            f"points: expected shape (n, 3) with masses (n,), got {r.shape} and {m.shape}"
        )
    tolerance = finite_float("tolerance", tolerance, positive=True)
    centre = point_masses(m, r).centre
    r, m = r[m > 0.0] - centre, m[m > 0.0]
    radius = np.linalg.norm(r, axis=-1)
    scale = float(radius.max())
    if scale <= tolerance * float(np.abs(centre).max(initial=0.0)):
        raise ValueError("points: all mass is in one point, which has every symmetry")
    r, radius = r / scale, radius / scale
    kinds = _kinds(radius, m, tolerance)
    # Pairs of the rarest kinds are the fewest to try.
    rarity = np.bincount(kinds)[kinds] + np.where(radius <= tolerance, np.inf, 0.0)
    first = int(np.argmin(rarity))
    sine = np.linalg.norm(np.cross(r[first], r), axis=-1) / radius[first]
    if sine.max() <= tolerance:
        return _on_a_line(centre, r[first] / radius[first], r, kinds, tolerance)
    second = int(np.argmin(np.where(sine >= 0.5 * sine.max(), rarity, np.inf)))
    group = _orthogonal(r, kinds, first, second, tolerance)
    group = group[_kept(group, r, kinds, tolerance)]

    proper = np.linalg.det(group) > 0.0
    vectors = log_so3(group[proper])
    angles = np.linalg.norm(vectors, axis=-1)
    turns = angles > 0.5 * np.pi / len(group)  # all but the identity
    axes, orders = _lines(vectors[turns] / angles[turns, None])
    mirrors = group[~proper & (np.abs(np.trace(group, axis1=1, axis2=2) - 1.0) < 1e-6)]
    return Symmetry(
        centre=centre,
        planes=_normals(mirrors),
        axes=axes,
        orders=orders,
        inversion=bool(np.any(np.trace(group, axis1=1, axis2=2) < -3.0 + 1e-6)),
        size=len(group),
    )


def _kinds(radius: Floats, masses: Floats, tolerance: float) -> NDArray[np.intp]:
    """A number for each point: points of equal mass and equal distance have the same number."""
    order = np.lexsort((radius, masses))
    mass, distance = np.diff(masses[order]), np.diff(radius[order])
    new = (np.abs(mass) > tolerance * masses.max()) | (distance > tolerance)
    kinds = np.empty(len(radius), dtype=np.intp)
    kinds[order] = np.concatenate([[0], np.cumsum(new)])
    return kinds


def _orthogonal(
    r: Floats, kinds: NDArray[np.intp], first: int, second: int, tolerance: float
) -> Floats:
    """Orthogonal matrices that take two points to points of their kinds."""
    a, b = r[first], r[second]
    heres, theres = r[kinds == kinds[first]], r[kinds == kinds[second]]
    # Each of the two images misses its point by a tolerance at most, and no radius exceeds one.
    i, j = np.nonzero(np.abs(heres @ theres.T - a @ b) <= 2.0 * tolerance)
    across = np.cross(heres[i], theres[j])
    images = np.stack(
        [np.stack([heres[i], theres[j], sign * across], axis=-1) for sign in (1.0, -1.0)]
    ).reshape(-1, 3, 3)
    frame = np.stack([a, b, np.cross(a, b)], axis=-1)
    left, _, right = np.linalg.svd(images @ np.linalg.inv(frame))
    orthogonal: Floats = left @ right
    return orthogonal


def _kept(group: Floats, r: Floats, kinds: NDArray[np.intp], tolerance: float) -> NDArray[np.bool_]:
    """Which of the matrices take every point to a point of the same kind."""
    from scipy.spatial import cKDTree

    # The kind is a fourth coordinate, so that an image only matches points of the same kind.
    apart = 10.0 * kinds[:, None]
    tree = cKDTree(np.concatenate([r, apart], axis=1))
    kept = np.empty(len(group), dtype=np.bool_)
    chunk = max(1, _AT_ONCE // len(r))
    for start in range(0, len(group), chunk):
        images = r @ group[start : start + chunk]  # by the inverse, which misses by as much
        label = np.broadcast_to(apart, (*images.shape[:-1], 1))
        distance, _ = tree.query(np.concatenate([images, label], axis=-1))
        kept[start : start + chunk] = distance.max(axis=-1) <= tolerance
    return kept


def _lines(directions: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Distinct lines among directions, and one plus the number on each; the largest first."""
    if not len(directions):
        return directions, np.empty(0, dtype=np.intp)
    same = np.abs(directions @ directions.T) > 1.0 - _ONE_LINE
    lines, orders = np.unique(np.argmax(same, axis=1), return_counts=True)
    sort = np.argsort(-orders, kind="stable")
    return _upright(directions[lines[sort]]), orders[sort] + 1


def _normals(mirrors: Floats) -> Floats:
    """Normals of reflections ``1 - 2 n ⊗ n``."""
    squares = 0.5 * (np.eye(3) - mirrors)
    largest = np.argmax(np.diagonal(squares, axis1=1, axis2=2), axis=1)
    normal = np.take_along_axis(squares, largest[:, None, None], axis=2)[..., 0]
    return _upright(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


def _upright(directions: Floats) -> Floats:
    """Directions with the sign that makes the last component that is not small positive."""
    last = 2 - np.argmax(np.abs(directions[:, ::-1]) > 1e-6, axis=1)
    leading = np.take_along_axis(directions, last[:, None], axis=1)
    return np.where(leading < 0.0, -directions, directions) + 0.0


def _on_a_line(
    centre: Floats, line: Floats, r: Floats, kinds: NDArray[np.intp], tolerance: float
) -> Symmetry:
    mirrored = bool(_kept(-np.eye(3)[None], r, kinds, tolerance)[0])
    axis = _upright(line[None])
    return Symmetry(
        centre=centre,
        planes=axis if mirrored else axis[:0],
        axes=axis,
        orders=np.zeros(1, dtype=np.intp),
        inversion=mirrored,
        size=0,
    )
