"""Systems of particles: total momenta, constraints, rigid displacements, and the path of a body.

Vectors have components along axes of space; moments refer to the origin of space unless you pass
another point.

The module uses :mod:`rigid.rotations` and, for the path of a body, :func:`rigid.simulate`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import finite_float, positive_int, shaped, sorted_times, together, vectors
from ._checks.arrays import Floats
from ._checks.overflow import refuses_overflow
from ._checks.quantities import plain
from .model.body import Body, require_one
from .model.scene import FreeBody
from .rotations.so3 import rotation_matrices
from .solve.run import Run
from .solve.simulate import simulate

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "BodyPath",
    "Displacement",
    "Freedom",
    "OmegaFit",
    "Screw",
    "Split",
    "Totals",
    "degrees_of_freedom",
    "fit_omega",
    "particle_totals",
    "propagate_body",
    "rigid_motion",
    "rigidity_residual",
    "screw",
    "split_com",
    "velocity_field",
]

Counts = NDArray[np.intp]

RANK = 1e-9
"""Singular values below this fraction of the largest count as zero, as for points on a line."""

SMALL = 1e-9
"""Relative size that counts as zero: extent of the points, misfit, orthogonality error."""

NARROW = 1e-6
"""Least width of a system of points, relative to its length, that determines a turn about it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Totals:
    """Totals of a system of particles; the leading axes are the axes of the arguments.

    Attributes
    ----------
    mass : ndarray, shape (...)
        Total mass (kg).
    com : ndarray, shape (..., 3)
        Centre of mass (m), from the origin.
    momentum : ndarray, shape (..., 3)
        Sum of ``m v`` (kg m/s).
    angular_momentum : ndarray, shape (..., 3)
        Sum of ``m (r - about) × v`` (kg m²/s).
    kinetic_energy : ndarray, shape (...)
        Sum of ``m v²/2`` (J).
    force : ndarray, shape (..., 3)
        Sum of the forces (N); zero if none are given.
    torque : ndarray, shape (..., 3)
        Sum of ``(r_i - about) × F_i`` (N m).
    """

    mass: Floats
    com: Floats
    momentum: Floats
    angular_momentum: Floats
    kinetic_energy: Floats
    force: Floats
    torque: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Split:
    """König's theorem: the parts of the centre of mass, and the parts about the centre of mass.

    Attributes
    ----------
    com, velocity : ndarray, shape (..., 3)
        Centre of mass (m) and its velocity (m/s).
    angular_momentum_com, angular_momentum_relative : ndarray, shape (..., 3)
        ``M (R - about) × V`` and the sum of ``m r' × v'`` (kg m²/s), with r' and v' relative to the
        centre of mass. The second part does not depend on the reference point.
    kinetic_energy_com, kinetic_energy_relative : ndarray, shape (...)
        ``M V²/2`` and the sum of ``m v'²/2`` (J).
    """

    com: Floats
    velocity: Floats
    angular_momentum_com: Floats
    angular_momentum_relative: Floats
    kinetic_energy_com: Floats
    kinetic_energy_relative: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Freedom:
    """Degrees of freedom of a system of points with fixed distances.

    Attributes
    ----------
    rigid : ndarray of int, shape (...)
        Degrees of freedom of the rigid body: 6; 5 if the points lie on a line, 3 for a single
        point. Fixed points reduce the number.
    conditions : int
        Number of pairs with a fixed distance.
    independent : ndarray of int, shape (...)
        Rank of the constraints to first order, for the points that are not fixed in space.
    redundant : ndarray of int, shape (...)
        Number of the other constraints.
    first_order : ndarray of int, shape (...)
        Degrees of freedom that the constraints leave to first order. More than ``rigid`` if the
        pairs do not make a rigid body, or if all points lie in a plane or on a line: distances then
        restrict displacements out of the plane or line to second order only.
    """

    rigid: Counts
    conditions: int
    independent: Counts
    redundant: Counts
    first_order: Counts


def particle_totals(
    masses: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike,
    forces: ArrayLike | None = None,
    *,
    about: ArrayLike = (0.0, 0.0, 0.0),
) -> Totals:
    """Mass, centre of mass, momentum, angular momentum, energy, force and torque of particles.

    ``L = Σ m_i (r_i - c) × v_i`` and ``N = Σ (r_i - c) × F_i``, each particle with its own force
    (Goldstein, *Classical Mechanics*, § 1.2; Ercan 2016, § 1, where the force lacks its index,
    erratum D-01). About another fixed point ``L_c = L_0 - c × P`` and ``N_c = N_0 - c × F``.

    Parameters
    ----------
    masses : array_like, shape (..., N)
        Masses (kg), >= 0, not all zero.
    positions, velocities : array_like, shape (..., N, 3)
        Positions (m) and velocities (m/s).
    forces : array_like, shape (..., N, 3), optional
        Total force on each particle (N), external and internal. Default: none.
    about : array_like, shape (3,) or (..., 3)
        Reference point (m), at rest.

    Returns
    -------
    Totals

    Raises
    ------
    ValueError
        If there are no particles, a mass is negative, all masses are zero, or an argument is not
        finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import particles
    >>> pair = particles.particle_totals([1.0, 3.0], [[0, 0, 0], [4, 0, 0]], [[0, 2, 0], [0, 0, 0]])
    >>> pair.com.tolist(), pair.momentum.tolist(), float(pair.kinetic_energy)
    ([3.0, 0.0, 0.0], [0.0, 2.0, 0.0], 2.0)
    """
    m, r, v = _cloud(masses, positions, velocities)
    f = np.zeros_like(r) if forces is None else shaped("forces", forces, None, 3)
    if f.shape[-2] != r.shape[-2]:
        raise ValueError(f"forces {f.shape}, positions {r.shape}: must have as many particles each")
    point = shaped("about", about, 3)[..., np.newaxis, :]
    m, r, v, f, point = together(masses=m, positions=r, velocities=v, forces=f, about=point)
    arm = r - point
    mass = m[..., 0].sum(axis=-1)
    return Totals(
        mass=mass,
        com=(m * r).sum(axis=-2) / mass[..., np.newaxis],
        momentum=(m * v).sum(axis=-2),
        angular_momentum=(m * np.cross(arm, v)).sum(axis=-2),
        kinetic_energy=0.5 * (m * v * v).sum(axis=(-2, -1)),
        force=f.sum(axis=-2),
        torque=np.cross(arm, f).sum(axis=-2),
    )


def split_com(
    masses: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike,
    *,
    about: ArrayLike = (0.0, 0.0, 0.0),
) -> Split:
    """König's theorem: angular momentum and kinetic energy of the centre of mass, and about it.

    König's theorem, ``L = M (R - c) × V + Σ m r' × v'`` and ``T = M V²/2 + Σ m v'²/2`` (Goldstein,
    *Classical Mechanics*, § 1.2; Ercan 2016, § 5). The function computes both parts as sums, so no
    digits cancel.

    Parameters
    ----------
    masses, positions, velocities, about : array_like
        As in :func:`particle_totals`.

    Returns
    -------
    Split

    Raises
    ------
    ValueError
        As in :func:`particle_totals`.

    Examples
    --------
    >>> from rigid import particles
    >>> dumbbell = particles.split_com([1, 1], [[5, 1, 0], [5, -1, 0]], [[2, 0, 0], [4, 0, 0]])
    >>> float(dumbbell.kinetic_energy_com), float(dumbbell.kinetic_energy_relative)
    (9.0, 1.0)
    """
    m, r, v = _cloud(masses, positions, velocities)
    point = shaped("about", about, 3)[..., np.newaxis, :]
    m, r, v, point = together(masses=m, positions=r, velocities=v, about=point)
    mass = m[..., 0].sum(axis=-1)
    com = (m * r).sum(axis=-2) / mass[..., np.newaxis]
    velocity = (m * v).sum(axis=-2) / mass[..., np.newaxis]
    own_r, own_v = r - com[..., np.newaxis, :], v - velocity[..., np.newaxis, :]
    orbital = mass[..., np.newaxis] * np.cross(com - point[..., 0, :], velocity)
    return Split(
        com=com,
        velocity=velocity,
        angular_momentum_com=orbital,
        angular_momentum_relative=(m * np.cross(own_r, own_v)).sum(axis=-2),
        kinetic_energy_com=0.5 * mass * (velocity * velocity).sum(axis=-1),
        kinetic_energy_relative=0.5 * (m * own_v * own_v).sum(axis=(-2, -1)),
    )


def degrees_of_freedom(
    positions: ArrayLike,
    *,
    fixed: Iterable[int] = (),
    pairs: ArrayLike | None = None,
    rtol: float = RANK,
) -> Freedom:
    """Degrees of freedom of a rigid system of points, and the number of redundant distances.

    A body of three or more points that are not on a line has six degrees of freedom. Points on a
    line have five, a single point has three. From ``N = 5`` on the number ``N (N - 1)/2`` of
    distances exceeds ``3 N - 6``, so that some distances follow from the others. The distances
    determine the points up to a mirror image only (lecture notes, § 5.1, erratum G-03).

    Parameters
    ----------
    positions : array_like, shape (..., N, 3)
        Points (m).
    fixed : iterable of int
        Indices of points that are fixed in space.
    pairs : array_like of int, shape (P, 2), optional
        Pairs with a fixed distance. Default: all.
    rtol : float
        Singular values below this fraction of the largest count as zero.

    Returns
    -------
    Freedom

    Raises
    ------
    ValueError
        If there are no points, an index is out of range, or the two points of a pair coincide.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import particles
    >>> cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> free = particles.degrees_of_freedom(cube)
    >>> int(free.rigid), free.conditions, int(free.independent), int(free.redundant)
    (6, 28, 18, 10)
    >>> [int(particles.degrees_of_freedom(cube, fixed=range(n)).rigid) for n in (1, 2, 3)]
    [3, 1, 0]
    """
    r = shaped("positions", positions, None, 3)
    count = r.shape[-2]
    if count == 0:
        raise ValueError(f"positions: expected at least one point, got shape {r.shape}")
    share = finite_float("rtol", rtol, positive=True)
    held = sorted({positive_int("fixed", one, minimum=0) for one in fixed})
    if held and held[-1] >= count:
        raise ValueError(f"fixed = {held[-1]}: there are {count} points, counted from 0")
    first, second = pairs_of(pairs, count)

    # Directions and arms in units of the size of the system, so that the ranks have no unit.
    apart = r[..., first, :] - r[..., second, :]
    lengths = np.linalg.norm(apart, axis=-1, keepdims=True)
    refuse_coincidence(lengths[..., 0], first, second)
    number = np.arange(len(first))
    gradients = np.zeros((*r.shape[:-2], len(first), count, 3))
    gradients[..., number, first, :] = apart / lengths
    gradients[..., number, second, :] = -apart / lengths
    movable = np.setdiff1d(np.arange(count), held)
    gradients = gradients[..., movable, :].reshape(*r.shape[:-2], len(first), 3 * len(movable))
    independent = _rank(gradients, share)

    arms = r - r.mean(axis=-2, keepdims=True)
    size = np.linalg.norm(arms, axis=-1).max(axis=-1)[..., np.newaxis, np.newaxis]
    arms = np.divide(arms, size, out=np.zeros_like(arms), where=size > 0.0)
    # Velocities of the points in three translations and three turns, of comparable size.
    turns = np.cross(np.eye(3), arms[..., np.newaxis, :])
    shifts = np.broadcast_to(np.eye(3), turns.shape)
    motions = np.concatenate([shifts, turns], axis=-2).swapaxes(-1, -2)
    motions = motions.reshape(*r.shape[:-2], count, 3, 6)

    def moving(which: Any) -> Counts:
        some = motions[..., which, :, :]
        return _rank(some.reshape(*r.shape[:-2], 3 * some.shape[-3], 6), share)

    return Freedom(
        rigid=moving(slice(None)) - moving(held),
        conditions=len(first),
        independent=independent,
        redundant=len(first) - independent,
        first_order=3 * len(movable) - independent,
    )


def rigidity_residual(positions: ArrayLike) -> Floats:
    """Rigidity error of moving points: the largest relative change of a distance.

    Parameters
    ----------
    positions : array_like, shape (..., T, N, 3)
        Positions (m) of ``N`` points at ``T`` times; the first time is the reference.

    Returns
    -------
    ndarray, shape (..., T)
        Largest ``|d(t) - d(0)| / d(0)`` over the pairs at each time, 0 for a single point.

    Raises
    ------
    ValueError
        If there is no time, or two points coincide at the first time.

    Examples
    --------
    >>> from rigid import particles
    >>> particles.rigidity_residual([[[0, 0, 0], [2, 0, 0]], [[1, 0, 0], [1, 3, 0]]]).tolist()
    [0.0, 0.5]
    """
    r = shaped("positions", positions, None, None, 3)
    if r.shape[-3] == 0:
        raise ValueError(f"positions: expected at least one time, got shape {r.shape}")
    first, second = pairs_of(None, r.shape[-2])
    distances = np.linalg.norm(r[..., first, :] - r[..., second, :], axis=-1)
    start = distances[..., :1, :]
    refuse_coincidence(start, first, second)
    return np.asarray(np.abs(distances / start - 1.0).max(axis=-1, initial=0.0))


def _cloud(
    masses: ArrayLike, positions: ArrayLike, velocities: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Checked masses (..., N, 1), positions and velocities (..., N, 3) of at least one particle."""
    m = shaped("masses", masses, None, nonnegative=True)
    r = shaped("positions", positions, None, 3)
    v = shaped("velocities", velocities, None, 3)
    count = r.shape[-2]
    if m.shape[-1] != count or v.shape[-2] != count:
        raise ValueError(
            f"masses {m.shape}, positions {r.shape}, velocities {v.shape}: must have as many "
            "particles each"
        )
    if count == 0 or (m.sum(axis=-1) <= 0.0).any():
        raise ValueError(f"masses, shape {m.shape}: their sum must be positive")
    return m[..., np.newaxis], r, v


def pairs_of(pairs: ArrayLike | None, count: int) -> tuple[Counts, Counts]:
    """First and second points of the pairs."""
    if pairs is None:
        return np.triu_indices(count, 1)
    array = np.asarray(plain("pairs", pairs))
    if array.size == 0:
        return np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise ValueError(f"pairs: expected whole numbers of shape (P, 2), got {array.shape}")
    wrong = (array < 0).any(axis=1) | (array >= count).any(axis=1) | (array[:, 0] == array[:, 1])
    if wrong.any():
        raise ValueError(
            f"pairs = {array[wrong][0].tolist()}: must be two different points of {count}, "
            "counted from 0"
        )
    return array[:, 0].astype(np.intp), array[:, 1].astype(np.intp)


def refuse_coincidence(lengths: Floats, first: Counts, second: Counts) -> None:
    """Raise ValueError for pairs at zero distance; the last axis of ``lengths`` counts pairs."""
    touching = np.argwhere(lengths == 0.0)
    if len(touching):
        pair = int(touching[0, -1])
        raise ValueError(
            f"positions: points {first[pair]} and {second[pair]} coincide, their distance has no "
            "direction"
        )


def _rank(matrices: Floats, share: float) -> Counts:
    """Ranks of matrices; 0 for those without rows or columns."""
    if 0 in matrices.shape[-2:]:
        return np.zeros(matrices.shape[:-2], dtype=np.intp)
    return np.asarray(np.linalg.matrix_rank(matrices, rtol=share), dtype=np.intp)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Displacement:
    """A turn and a shift, ``b = rotation a + translation``.

    Attributes
    ----------
    rotation : ndarray, shape (..., 3, 3)
        Proper rotation, active.
    translation : ndarray, shape (..., 3)
        Shift (m) of the point of the body that was at the origin.
    residual : ndarray, shape (...)
        Weighted root mean square of ``|b - rotation a - translation|`` (m).
    determined : ndarray of bool, shape (...)
        Whether the points determine the rotation. False if the points lie within a millionth of
        their length from a line: the turn about this line is then arbitrary, and ``rotation`` is
        one of many that fit.
    """

    rotation: Floats
    translation: Floats
    residual: Floats
    determined: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Screw:
    """A displacement as a turn about an axis and a shift along it.

    Attributes
    ----------
    axis : ndarray, shape (..., 3)
        Unit vector of the axis, right-handed for the angle; the direction of the shift if the angle
        is zero; zero if angle and shift are zero.
    point : ndarray, shape (..., 3)
        The point of the axis that is nearest to the origin (m); the origin if the angle is zero,
        because then any line along ``axis`` is an axis.
    angle : ndarray, shape (...)
        Angle (rad) in [0, pi]. At pi the sign of the axis is arbitrary.
    advance : ndarray, shape (...)
        Shift along the axis (m).
    """

    axis: Floats
    point: Floats
    angle: Floats
    advance: Floats

    @property
    def pitch(self) -> Floats:
        """Shift along the axis per angle (m/rad); inf without a turn, 0 without turn and shift."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.where(self.advance == 0.0, 0.0, self.advance / self.angle)[()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OmegaFit:
    """The rigid motion that fits the velocities of points best.

    Attributes
    ----------
    omega : ndarray, shape (..., 3)
        Angular velocity (rad/s); it does not depend on the base. Components that the points do not
        determine are zero.
    velocity : ndarray, shape (..., 3)
        Velocity (m/s) of the point of the body at ``base``.
    base : ndarray, shape (..., 3)
        The base point (m).
    residual : ndarray, shape (...)
        Root mean square of the residual velocities (m/s).
    rank : ndarray of int, shape (...)
        Number of components of ``omega`` that the points determine: 3; 2 if the points lie on a
        line, because a rotation about this line does not move them; 0 if the points coincide.
    """

    omega: Floats
    velocity: Floats
    base: Floats
    residual: Floats
    rank: NDArray[np.intp]


def rigid_motion(
    before: ArrayLike, after: ArrayLike, weights: ArrayLike | None = None
) -> Displacement:
    """The rotation and the translation that take one set of points to another.

    Every displacement of a rigid body is a rotation and a translation (Euler, Chasles; Goldstein,
    *Classical Mechanics*, § 4.6; Ercan 2016, § 1). If the points are not exactly rigid, the result
    is the weighted least-squares fit (Kabsch, *Acta Cryst.* A32 (1976) 922).

    Parameters
    ----------
    before, after : array_like, shape (..., N, 3)
        Positions (m) of the points before and after the displacement, in the same order.
    weights : array_like, shape (..., N), optional
        Weights, >= 0, for instance masses. Default: equal.

    Returns
    -------
    Displacement

    Raises
    ------
    ValueError
        If the numbers of points differ, a weight is negative, all weights are zero, or ``after`` is
        a mirror image of ``before``: a reflection fits at least twice as well as any rotation.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import particles
    >>> corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> turned = particles.rigid_motion(corner, corner[:, [2, 0, 1]] + [5, 0, 0])
    >>> np.allclose(turned.rotation, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    True
    >>> np.allclose(turned.translation, [5, 0, 0])
    True
    """
    a = shaped("before", before, None, 3)
    b = shaped("after", after, None, 3)
    w = np.ones(a.shape[-2]) if weights is None else shaped("weights", weights, None)
    if not a.shape[-2] == b.shape[-2] == w.shape[-1] > 0:
        raise ValueError(
            f"before {a.shape}, after {b.shape}, weights {w.shape}: must have as many points each"
        )
    if (w < 0.0).any() or (w.sum(axis=-1) <= 0.0).any():
        raise ValueError("weights: must not be negative, and not all be zero")
    a, b, w = together(before=a, after=b, weights=w[..., np.newaxis])
    w = w / w.sum(axis=-2, keepdims=True)
    mean_a, mean_b = (w * a).sum(axis=-2), (w * b).sum(axis=-2)
    own_a, own_b = a - mean_a[..., np.newaxis, :], b - mean_b[..., np.newaxis, :]

    left, extent, right = np.linalg.svd(np.swapaxes(w * own_b, -1, -2) @ own_a)
    handed = np.where(np.linalg.det(left) * np.linalg.det(right) < 0.0, -1.0, 1.0)
    mirror = np.ones_like(extent)
    mirror[..., 2] = handed
    rotation = (left * mirror[..., np.newaxis, :]) @ right

    def residual(matrix: Floats) -> Floats:
        left_over = own_b - own_a @ np.swapaxes(matrix, -1, -2)
        return np.asarray(np.sqrt((w * left_over * left_over).sum(axis=(-2, -1))))

    proper, best = residual(rotation), residual(left @ right)
    size = np.sqrt((w * own_b * own_b).sum(axis=(-2, -1)))
    mirrored = proper > 2.0 * best + SMALL * size
    if mirrored.any():
        index = tuple(int(i) for i in np.argwhere(mirrored)[0])
        raise ValueError(
            f"after: a mirror image of before; no rotation comes nearer than {proper[index]:g}, a "
            f"reflection than {best[index]:g}"
        )
    return Displacement(
        rotation=rotation,
        translation=mean_b - (rotation @ mean_a[..., np.newaxis])[..., 0],
        residual=proper[()],
        # A turn about the longest direction moves points along the other two; extents are squares.
        determined=extent[..., 1] + handed * extent[..., 2] > NARROW**2 * extent[..., 0],
    )


def screw(rotation: ArrayLike, translation: ArrayLike) -> Screw:
    """The screw axis of a displacement, the angle about this axis and the shift along this axis.

    Chasles' (Mozzi's) theorem: with ``t`` the translation perpendicular to the axis ``n``, the axis
    passes through ``(t + cot(angle / 2) n × t) / 2`` (Goldstein, *Classical Mechanics*, § 4.6;
    Ercan 2016, § 1). The function needs SciPy.

    Parameters
    ----------
    rotation : array_like, shape (..., 3, 3)
        Rotation, active.
    translation : array_like, shape (..., 3)
        Shift (m) of the point of the body that was at the origin.

    Returns
    -------
    Screw

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4; within, the nearest rotation is taken.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import particles
    >>> quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    >>> turn = particles.screw(quarter, [1, 1, 3])
    >>> np.allclose(turn.axis, [0, 0, 1]), np.allclose(turn.point, [0, 1, 0]), float(turn.advance)
    (True, True, 3.0)
    """
    from scipy.spatial.transform import Rotation

    matrix = rotation_matrices("rotation", rotation)
    shift = shaped("translation", translation, 3)
    vector = Rotation.from_matrix(matrix.reshape(-1, 3, 3)).as_rotvec().reshape(matrix.shape[:-1])
    vector, shift = together(rotation=vector, translation=shift)
    angle, distance = (np.linalg.norm(of, axis=-1)[..., np.newaxis] for of in (vector, shift))
    axis = np.divide(shift, distance, out=np.zeros(shift.shape), where=distance > 0.0)
    np.divide(vector, angle, out=axis, where=angle > 0.0)
    advance = (axis * shift).sum(axis=-1, keepdims=True)
    across = shift - advance * axis
    with np.errstate(divide="ignore", invalid="ignore"):
        point = 0.5 * (across + np.cross(axis, across) / np.tan(0.5 * angle))
    return Screw(
        axis=axis,
        point=np.where(angle > 0.0, point, 0.0),
        angle=angle[..., 0],
        advance=advance[..., 0],
    )


def velocity_field(
    omega: ArrayLike,
    points: ArrayLike,
    *,
    velocity: ArrayLike = (0.0, 0.0, 0.0),
    base: ArrayLike = (0.0, 0.0, 0.0),
) -> Floats:
    """Velocities of the points of a rigid body: ``v = V + omega × (r - base)``.

    Landau and Lifshitz, *Mechanics*, § 31; Ercan 2016, eq. (21), where the arm must begin at the
    base (erratum D-11). Another base point with its own velocity gives the same velocity field.

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s), along the same axes as the other vectors.
    points : array_like, shape (..., 3)
        Positions (m); broadcast with the other arguments.
    velocity : array_like, shape (..., 3)
        Velocity (m/s) of the base. Default: zero, the body turns about the base.
    base : array_like, shape (..., 3)
        The base point (m). Default: the origin.

    Returns
    -------
    ndarray, shape (..., 3)
        Velocities (m/s).

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import particles
    >>> particles.velocity_field([0, 0, 2], [[1, 0, 0], [0, 3, 0]], velocity=[0, 0, 1]).tolist()
    [[0.0, 2.0, 1.0], [-6.0, 0.0, 1.0]]
    """
    w, r, v, r0 = vectors(omega=omega, points=points, velocity=velocity, base=base)
    return np.asarray(v + np.cross(w, r - r0))


@refuses_overflow
def fit_omega(
    points: ArrayLike, velocities: ArrayLike, *, base: ArrayLike | None = None
) -> OmegaFit:
    """The angular velocity of a rigid body from the velocities of its points.

    Least-squares solution of ``v = V + omega × (r - base)``. The angular velocity of a rigid body
    is the same for every base (Ercan 2016, theorem 1, eq. (21)); it is unique if two arms are not
    parallel (erratum D-11).

    Parameters
    ----------
    points, velocities : array_like, shape (..., N, 3)
        Positions (m) and velocities (m/s) of the points.
    base : array_like, shape (..., 3), optional
        The point (m) whose velocity is returned. Default: the mean of the points.

    Returns
    -------
    OmegaFit

    Raises
    ------
    ValueError
        If there are no points, the shapes do not match, or an argument is not finite.

    Examples
    --------
    >>> from rigid import particles
    >>> rim, speeds = [[1, 0, 0], [0, 1, 0], [-1, 0, 0]], [[5, 2, 0], [3, 0, 0], [5, -2, 0]]
    >>> wheel = particles.fit_omega(rim, speeds)
    >>> wheel.omega.round(9).tolist(), int(wheel.rank)
    ([0.0, 0.0, 2.0], 3)
    """
    r = shaped("points", points, None, 3)
    v = shaped("velocities", velocities, None, 3)
    if r.shape[-2] != v.shape[-2] or r.shape[-2] == 0:
        raise ValueError(f"points {r.shape}, velocities {v.shape}: must have as many points each")
    r, v = together(points=r, velocities=v)
    count = r.shape[-2]
    centre, drift = r.mean(axis=-2), v.mean(axis=-2)
    arms, own = r - centre[..., np.newaxis, :], v - drift[..., np.newaxis, :]
    # omega × r = -hat(r) omega, one 3×3 block a point.
    blocks = np.swapaxes(np.cross(np.eye(3), arms[..., np.newaxis, :]), -1, -2)
    left, extent, right = np.linalg.svd(
        blocks.reshape(*r.shape[:-2], 3 * count, 3), full_matrices=False
    )
    seen = extent > SMALL * extent[..., :1]
    inverse = np.divide(1.0, extent, out=np.zeros_like(extent), where=seen)
    flat = own.reshape(*r.shape[:-2], 3 * count, 1)
    modes = inverse[..., np.newaxis] * (np.swapaxes(left, -1, -2) @ flat)
    omega = (np.swapaxes(right, -1, -2) @ modes)[..., 0]
    left_over = own - np.cross(omega[..., np.newaxis, :], arms)
    at = centre if base is None else shaped("base", base, 3)
    at, centre, drift, turning = together(base=at, points=centre, velocities=drift, omega=omega)
    return OmegaFit(
        omega=omega,
        velocity=drift + np.cross(turning, at - centre),
        base=np.array(at),
        residual=np.sqrt((left_over * left_over).sum(axis=(-2, -1)) / count)[()],
        rank=seen.sum(axis=-1),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyPath:
    """Position, velocity and rotation of thrown bodies over time.

    Arrays of a single body lack the leading axis ``n``.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    position, velocity : ndarray, shape (n, m, 3)
        Centre of mass (m) and its velocity (m/s), in space.
    rotation : Run
        Angular velocities and attitudes with their errors, from :func:`rigid.simulate`.
    """

    t: Floats
    position: Floats
    velocity: Floats
    rotation: Run


def propagate_body(
    body: Body | FreeBody,
    position: ArrayLike,
    velocity: ArrayLike,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    force: ArrayLike = (0.0, 0.0, 0.0),
    t: ArrayLike,
) -> BodyPath:
    """Path of a thrown body: the centre of mass under a force through it, and the rotation.

    The centre of mass obeys ``F = dP/dt``, the rotation obeys ``N = dL/dt`` (Ercan 2016, § 2, eqs.
    (38)–(40)). Without torque the angular momentum is constant, but the angular velocity in general
    is not (erratum D-02). The path is exact for a constant force. For sampled forces the function
    integrates their cubic spline twice, which needs SciPy; the error falls with the fourth power of
    the spacing. :func:`rigid.simulate` gives the rotation.

    Parameters
    ----------
    body : Body or FreeBody
        The body, with moments about the centre of mass; it must have a mass if there is a force.
        The torques of a :class:`rigid.FreeBody` turn the body. An orbit is refused, because it
        moves the centre of mass in another way.
    position, velocity : array_like, shape (3,) or (n, 3)
        Centre of mass (m) and its velocity (m/s) at ``t = 0``.
    omega, attitude : array_like
        Angular velocity and attitude at ``t = 0``, as in :func:`rigid.simulate`.
    force : array_like, shape (3,), (m, 3) or (n, m, 3)
        Force (N) in space, through the centre of mass: constant, or sampled at the times. An axis
        of length one instead of ``m`` means a constant force.
    t : array_like, shape (m,)
        Times (s), ascending. For sampled forces the times must be strictly ascending and must
        contain or enclose ``t = 0``.

    Returns
    -------
    BodyPath

    Raises
    ------
    ValueError
        If there is a force but the body has no mass, the body is on an orbit, or an argument is not
        finite or has the wrong shape.

    Examples
    --------
    >>> import rigid
    >>> from rigid import particles
    >>> racket = rigid.Body((1.0, 2.0, 2.5), mass=0.3)
    >>> weight = [0.0, 0.0, -9.81 * racket.mass]
    >>> path = particles.propagate_body(
    ...     racket, [0, 0, 1], [2, 0, 5], [0, 10, 0.01], force=weight, t=[0.0, 1.0]
    ... )
    >>> path.position[-1].round(9).tolist()
    [2.0, 0.0, 1.095]
    """
    scene = body if isinstance(body, FreeBody) else FreeBody(body)
    require_one(body)
    if scene.orbit is not None:
        raise ValueError(
            f"body = {scene.words()}: position, velocity and force move its centre of mass; "
            "rigid.simulate gives the rotation on an orbit"
        )
    mass = scene.body.mass
    times = sorted_times("t", t)
    r0, v0 = shaped("position", position, 3), shaped("velocity", velocity, 3)
    f = shaped("force", force, 3)
    if mass is None and f.any():
        raise ValueError("body: its mass is None; give the body a mass, or no force")
    impulse, shift = _impulse_and_shift(f, times)
    run = simulate(scene, omega, attitude, t=times)
    mass = 1.0 if mass is None else mass
    r0, v0, impulse, shift, _ = together(
        position=r0[..., np.newaxis, :],
        velocity=v0[..., np.newaxis, :],
        force=impulse,
        shift=shift,
        omega=run.omega,
    )
    return BodyPath(
        t=times,
        position=r0 + v0 * times[:, np.newaxis] + shift / mass,
        velocity=v0 + impulse / mass,
        rotation=run,
    )


def _impulse_and_shift(force: Floats, times: Floats) -> tuple[Floats, Floats]:
    """First and second integral of the force from ``t = 0``, shape (..., m, 3)."""
    rows = force.shape[-2] if force.ndim > 1 else 1
    t = times[:, np.newaxis]
    if rows == 1:
        return force * t, force * (0.5 * t * t)
    if rows != len(times) or rows == 0:
        raise ValueError(
            f"force: expected shape (3,) or (..., {len(times)}, 3), a row for each of the times, "
            f"got {force.shape}"
        )
    if (np.diff(times) <= 0.0).any() or times[0] > 0.0 or times[-1] < 0.0:
        raise ValueError(
            f"t = {times[0]:g} ... {times[-1]:g}: times of sampled forces must be strictly "
            "ascending and reach or pass t = 0, where the path starts"
        )
    from scipy.interpolate import CubicSpline

    once = CubicSpline(times, force, axis=-2).antiderivative()
    twice = once.antiderivative()
    return once(times) - once([0.0]), twice(times) - twice([0.0]) - once([0.0]) * t
