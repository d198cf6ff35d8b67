"""Statics: equilibrium of forces, the balancing force and couple, and the central axis.

Examples are the six simple machines without friction. A lever rests on its fulcrum between a load
and an effort at two arms:

>>> from math import cos, pi, sin, tan
>>> from rigid import statics
>>> def balanced(forces, points):
...     return bool(statics.equilibrium(forces, points).balanced)
>>> load, arm, effort_arm = 30.0, 0.2, 0.6
>>> effort = load * arm / effort_arm
>>> balanced([[0, 0, -load], [0, 0, -effort], [0, 0, load + effort]],
...          [[-arm, 0, 0], [effort_arm, 0, 0], [0, 0, 0]])
True

A wheel and its axle are a rotating lever; in a movable pulley two strands share the load:

>>> wheel, axle = 0.5, 0.1
>>> effort = load * axle / wheel
>>> balanced([[0, -load, 0], [0, -effort, 0], [0, load + effort, 0]],
...          [[-axle, 0, 0], [wheel, 0, 0], [0, 0, 0]])
True
>>> balanced([[0, 0, load / 2], [0, 0, load / 2], [0, 0, -load]],
...          [[-axle, 0, 0], [axle, 0, 0], [0, 0, -1]])
True

On an inclined plane, and at the two faces of a wedge, the surface pushes along its normal:

>>> slope = 0.3
>>> effort, push = load * sin(slope), load * cos(slope)
>>> balanced([[0, 0, -load], [effort * cos(slope), 0, effort * sin(slope)],
...           [-push * sin(slope), 0, push * cos(slope)]], [[2, 0, 0]] * 3)
True
>>> effort = 2 * push * sin(slope)
>>> balanced([[0, 0, -effort], [push * cos(slope), 0, push * sin(slope)],
...           [-push * cos(slope), 0, push * sin(slope)]], [[0, 0, 1], [-0.1, 0, 0], [0.1, 0, 0]])
True

A screw that rises by ``rise`` in a turn is an inclined plane around a cylinder, turned by a couple
of two efforts; here it rests on opposite points of a double thread:

>>> rise, radius, arm = 0.004, 0.01, 0.25
>>> slope = rise / (2 * pi * radius)  # tangent of the angle
>>> effort, push = load * rise / (2 * pi * 2 * arm), load / 2
>>> balanced([[0, 0, -load], [0, effort, 0], [0, -effort, 0], [0, -push * slope, push],
...           [0, push * slope, push]],
...          [[0, 0, 0], [arm, 0, 0], [-arm, 0, 0], [radius, 0, 0], [-radius, 0, 0]])
True
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import finite_float, shaped, together
from ._checks.arrays import Floats, of_size_one
from ._checks.overflow import refuses_overflow

__all__ = ["Equilibrant", "Equilibrium", "Wrench", "equilibrant", "equilibrium", "wrench"]

Flags = NDArray[np.bool_]

BALANCE = 1e-9
"""A sum below this fraction of the sum of the sizes counts as zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equilibrium:
    """Sums of forces and torques, and whether both are zero.

    Attributes
    ----------
    force : ndarray, shape (..., 3)
        Their sum (N).
    torque : ndarray, shape (..., 3)
        Sum of ``(r_i - about) × F_i`` (N m). It depends on ``about`` unless the force vanishes.
    balanced : ndarray of bool, shape (...)
        Whether force and torque are zero, for one and hence for every reference point: a body at
        rest remains at rest.
    """

    force: Floats
    torque: Floats
    balanced: Flags


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equilibrant:
    """The force and the couple that balance a system of forces.

    Attributes
    ----------
    force : ndarray, shape (..., 3)
        A force (N) that acts at the reference point.
    couple : ndarray, shape (..., 3)
        A couple (N m), the same wherever it acts.
    needs_force, needs_couple : ndarray of bool, shape (...)
        Whether the force and the couple are needed. If only the couple is needed, no single force
        balances the system.
    """

    force: Floats
    couple: Floats
    needs_force: Flags
    needs_couple: Flags


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wrench:
    """A system of forces as one force along its central axis, and a couple about that axis.

    Attributes
    ----------
    force : ndarray, shape (..., 3)
        Sum of the forces (N), along the axis.
    torque : ndarray, shape (..., 3)
        Sum of the torques about the reference point (N m).
    has_axis : ndarray of bool, shape (...)
        False if the sum of the forces is zero, as for a pure couple.
    point : ndarray, shape (..., 3)
        The point of the axis that is nearest to the reference point (m); the reference point if
        there is no axis.
    couple : ndarray, shape (..., 3)
        The torque along the axis (N m), the smallest torque about any point; the whole torque if
        there is no axis.
    pitch : ndarray, shape (...)
        Couple divided by force (m), positive for a right-handed wrench; inf for a pure couple, 0
        without force and couple.
    """

    force: Floats
    torque: Floats
    has_axis: Flags
    point: Floats
    couple: Floats
    pitch: Floats


@refuses_overflow
def equilibrium(
    forces: ArrayLike,
    points: ArrayLike,
    *,
    about: ArrayLike = (0.0, 0.0, 0.0),
    rtol: float = BALANCE,
) -> Equilibrium:
    """Sum of forces and sum of torques, and whether both are zero.

    In equilibrium ``Σ F_i = 0`` and ``Σ r_i × F_i = 0``, each force with its own arm (lecture
    notes, § 5.2, where the index is missing, erratum G-04). About another point
    ``N_c = N_0 - c × F``: the torque depends on the reference point unless the sum of the forces is
    zero (erratum G-05). Balanced forces keep momentum and angular momentum constant; a body at
    rest has neither (erratum D-44).

    Parameters
    ----------
    forces, points : array_like, shape (..., N, 3)
        Forces (N) and the points where they act (m).
    about : array_like, shape (3,) or (..., 3)
        Reference point (m).
    rtol : float
        A sum below this fraction of the sum of the sizes counts as zero.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import statics
    >>> seesaw = statics.equilibrium(
    ...     [[0, 0, -300], [0, 0, -200], [0, 0, 500]], [[-1, 0, 0], [1, 0, 0], [0, 0, 0]]
    ... )
    >>> seesaw.torque.tolist(), bool(seesaw.balanced)
    ([0.0, -100.0, 0.0], False)
    """
    sums = _sums(forces, points, about, rtol)
    return Equilibrium(
        force=sums.force, torque=sums.torque, balanced=~(sums.some_force | sums.some_torque)
    )


@refuses_overflow
def equilibrant(
    forces: ArrayLike,
    points: ArrayLike,
    *,
    about: ArrayLike = (0.0, 0.0, 0.0),
    rtol: float = BALANCE,
) -> Equilibrant:
    """The force at the reference point, and the couple, that balance a system of forces.

    One force at the reference point balances a force without torque. Only a couple balances a
    torque without force (lecture notes, § 5.2).

    Parameters
    ----------
    forces, points, about, rtol : array_like
        As in :func:`equilibrium`.

    Returns
    -------
    Equilibrant

    Raises
    ------
    ValueError
        As in :func:`equilibrium`.

    Examples
    --------
    >>> from rigid import statics
    >>> pair = statics.equilibrant([[0, 0, 5], [0, 0, -5]], [[1, 0, 0], [-1, 0, 0]])
    >>> bool(pair.needs_force), bool(pair.needs_couple), float(pair.couple[1])
    (False, True, 10.0)
    """
    sums = _sums(forces, points, about, rtol)
    return Equilibrant(
        force=-sums.force,
        couple=-sums.torque,
        needs_force=sums.some_force,
        needs_couple=sums.some_torque,
    )


@refuses_overflow
def wrench(
    forces: ArrayLike,
    points: ArrayLike,
    *,
    about: ArrayLike = (0.0, 0.0, 0.0),
    rtol: float = BALANCE,
) -> Wrench:
    """The central axis of a system of forces, and the couple about this axis.

    Poinsot's theorem: the axis has the direction of ``F = Σ F_i`` and passes through
    ``about + F × N / F²``; the torque about the axis is ``(N·F) F / F²``.

    Parameters
    ----------
    forces, points, about, rtol : array_like
        As in :func:`equilibrium`.

    Returns
    -------
    Wrench

    Raises
    ------
    ValueError
        As in :func:`equilibrium`.

    Examples
    --------
    >>> from rigid import statics
    >>> drill = statics.wrench(  # a push along z at x = 1, and a couple about z
    ...     [[0, 0, -20], [0, 3, 0], [0, -3, 0]], [[1, 0, 0], [2, 0, 0], [0, 0, 0]]
    ... )
    >>> drill.point.tolist(), drill.couple.tolist(), float(drill.pitch)
    ([1.0, 0.0, 0.0], [-0.0, -0.0, 6.0], -0.3)
    """
    sums = _sums(forces, points, about, rtol)
    force, torque = sums.force, sums.torque
    axis = sums.some_force[..., np.newaxis]
    direction = np.divide(force, sums.size, out=np.zeros_like(force), where=axis)
    along = (torque * direction).sum(axis=-1, keepdims=True)
    arm = np.divide(np.cross(direction, torque), sums.size, out=np.zeros_like(force), where=axis)
    pitch = np.where(sums.some_torque, np.inf, 0.0)[..., np.newaxis]
    np.divide(along, sums.size, out=pitch, where=axis)
    return Wrench(
        force=force,
        torque=torque,
        has_axis=sums.some_force,
        point=sums.about + arm,
        couple=np.where(axis, along * direction, torque),
        pitch=pitch[..., 0],
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Sums:
    force: Floats
    torque: Floats
    some_force: Flags
    some_torque: Flags
    size: Floats  #: of the force, shape (..., 1)
    about: Floats


def _sums(forces: ArrayLike, points: ArrayLike, about: ArrayLike, rtol: float) -> _Sums:
    f, r = shaped("forces", forces, None, 3), shaped("points", points, None, 3)
    if f.shape[-2] != r.shape[-2]:
        raise ValueError(f"forces {f.shape}, points {r.shape}: each force needs its point")
    share = finite_float("rtol", rtol, nonnegative=True)
    point = shaped("about", about, 3)[..., np.newaxis, :]
    f, r, origin = together(forces=f, points=r, about=point)
    arm = r - origin
    force, torque = f.sum(axis=-2), np.cross(arm, f).sum(axis=-2)
    # In units of the largest force and of the longest arm no square leaves the range of doubles.
    (unit_f, power), (unit_arm, _) = (of_size_one(own, (-2, -1)) for own in (f, arm))
    sizes, arms = np.linalg.norm(unit_f, axis=-1), np.linalg.norm(unit_arm, axis=-1)
    unit_torque = np.cross(unit_arm, unit_f).sum(axis=-2)
    size = np.linalg.norm(unit_f.sum(axis=-2), axis=-1)
    return _Sums(
        force=force,
        torque=torque,
        some_force=size > share * sizes.sum(axis=-1),
        some_torque=np.linalg.norm(unit_torque, axis=-1) > share * (arms * sizes).sum(axis=-1),
        size=np.ldexp(size[..., np.newaxis], power[..., 0]),
        about=np.broadcast_to(point[..., 0, :], force.shape),
    )
