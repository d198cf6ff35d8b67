"""Systems of particles: total momenta, the centre of mass, and constraints of distance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, positive_int, shaped, together
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from .._checks.quantities import plain

Counts = NDArray[np.intp]

RANK = 1e-9
"""Singular values below this fraction of the largest count as zero, as for points on a line."""


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


@refuses_overflow
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


@refuses_overflow
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


@refuses_overflow
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


@refuses_overflow
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
