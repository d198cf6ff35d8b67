"""Tensors of inertia of mass points and of parts, about any point and in any axes.

Products of inertia have minus signs, ``I_12 = -sum m x y``. A tensor of inertia belongs to a point
and to axes: add tensors only if they have the same point and the same axes.

=============================  ===========================================================
of mass points                 inertia_tensor, point_masses
mass, centre and tensor        MassProperties, compose
about another point            steiner
in other axes                  rotate_tensor
in principal axes              principal_axes, classify_body
symmetries of mass points      symmetry_check
energy, angular momentum       rotational_energy, kinetic_energy, energy_from_momentum;
                               angular_momentum, omega_from_momentum
=============================  ===========================================================

The package uses :mod:`rigid.solids`, :mod:`rigid.rotations` and ``_checks``. :class:`rigid.Body`
uses it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, shaped
from .._checks.arrays import Floats
from .._checks.moments import possible_moments, symmetric_tensor
from ..solids.mass_properties import (
    MassProperties,
    compose,
    inertia_tensor,
    point_masses,
    rotate_tensor,
    steiner,
)
from .momentum import (
    angular_momentum,
    energy_from_momentum,
    kinetic_energy,
    omega_from_momentum,
    rotational_energy,
)
from .symmetry import Symmetry, symmetry_check

__all__ = [
    "BodyClass",
    "MassProperties",
    "PrincipalAxes",
    "Symmetry",
    "angular_momentum",
    "classify_body",
    "compose",
    "energy_from_momentum",
    "inertia_tensor",
    "kinetic_energy",
    "omega_from_momentum",
    "point_masses",
    "principal_axes",
    "rotate_tensor",
    "rotational_energy",
    "steiner",
    "symmetry_check",
]


_EQUAL = 16.0 * float(np.finfo(np.float64).eps)
"""Share of the largest moment by which two moments may differ by the rounding of a tensor."""

_TIE = 1e-9
"""Components of a unit vector that differ by less than this count as equal."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PrincipalAxes:
    """Principal moments and axes.

    Attributes
    ----------
    moments : ndarray, shape (..., 3)
        Principal moments (kg m²), ascending.
    axes : ndarray, shape (..., 3, 3)
        Column k is the axis of moment k, in the frame of the tensor; right-handed. As a matrix it
        takes components in principal axes to those in the frame of the tensor.
    """

    moments: Floats
    axes: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyClass:
    """Classes of bodies by their principal moments.

    Attributes
    ----------
    kind : ndarray of str, shape (...)
        ``"asymmetric"``, ``"oblate"`` (two equal moments, the third larger), ``"prolate"`` (the
        third smaller), ``"rod"`` (the third zero), ``"spherical"``, ``"point"`` (no moment at all)
        or ``"impossible"`` (a negative moment, or one above the sum of the other two).
    axis : ndarray of int8, shape (...)
        The symmetry axis 1, 2 or 3 of an oblate or prolate body or a rod; 0 if no axis, or every
        axis, is a symmetry axis.
    flat : ndarray of bool, shape (...)
        Whether one moment is the sum of the other two, so that the body is flat: all mass lies in
        the plane of the axes of the other two moments.
    """

    kind: NDArray[np.str_]
    axis: NDArray[np.int8]
    flat: NDArray[np.bool_]


def principal_axes(tensor: ArrayLike) -> PrincipalAxes:
    """Principal moments, ascending, and right-handed principal axes.

    Every body has principal axes about every point (Goldstein, § 5.4; Ercan 2016, eq. (37): in the
    example ``I`` stands for the eigenvalue ``I_1``, erratum D-18). The lecture notes call the
    tensor positive definite, but a moment of their thin rod is zero (G-11).

    The function fixes the signs: the largest component of the first and of the second axis is
    positive. If moments are equal (to 16 roundings of the largest), their axes are not unique. For
    two equal moments the first of their axes is the projection of one frame axis, the nearest to
    the plane of both axes. For three equal moments the principal axes are the axes of the frame.
    Thus a rounding error of the tensor changes the axes little.

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensors of inertia (kg m²); tensors of rods and points are allowed.

    Returns
    -------
    PrincipalAxes

    Raises
    ------
    ValueError
        If a tensor is not finite and symmetric, or no body has its moments.

    Examples
    --------
    >>> from rigid import inertia
    >>> found = inertia.principal_axes([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.5]])
    >>> found.moments.round(15)
    array([1. , 2.5, 3. ])
    >>> inertia.principal_axes([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]).axes
    array([[ 0.,  1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0., -1.]])
    """
    t = symmetric_tensor("tensor", tensor)
    moments, axes = np.linalg.eigh(t)
    moments = np.maximum(possible_moments("tensor", moments), 0.0)
    width = _EQUAL * moments[..., 2]
    lower, upper = (moments[..., k + 1] - moments[..., k] <= width for k in (0, 1))
    first, second, third = np.moveaxis(axes, -1, 0)
    first = np.where(lower[..., None], _in_plane(third), first)
    second = np.where(upper[..., None], _in_plane(first), second)
    second = np.where((lower & ~upper)[..., None], np.cross(third, first), second)
    spherical = (moments[..., 2] - moments[..., 0] <= width)[..., None]
    first = np.where(spherical, [1.0, 0.0, 0.0], first)
    second = np.where(spherical, [0.0, 1.0, 0.0], second)
    first, second = _signed(first), _signed(second)
    return PrincipalAxes(
        moments=moments, axes=np.stack([first, second, np.cross(first, second)], axis=-1) + 0.0
    )


def classify_body(moments: ArrayLike, *, tolerance: float = 1e-12) -> BodyClass:
    """The class of a body with these principal moments.

    Parameters
    ----------
    moments : array_like, shape (..., 3)
        Principal moments (kg m²), in any order.
    tolerance : float
        Moments are equal if they differ by at most this fraction of the largest moment.

    Returns
    -------
    BodyClass

    Raises
    ------
    ValueError
        If a moment is not finite or the tolerance is negative. Impossible moments do not raise.

    Examples
    --------
    >>> from rigid import inertia
    >>> disk = inertia.classify_body([1.0, 2.0, 1.0])
    >>> str(disk.kind), int(disk.axis), bool(disk.flat)
    ('oblate', 2, True)
    >>> str(inertia.classify_body([1.0, 1.0, 2.5]).kind)
    'impossible'
    """
    array = shaped("moments", moments, 3)
    tolerance = finite_float("tolerance", tolerance, nonnegative=True)
    order = np.argsort(array, axis=-1, kind="stable")
    small, middle, large = np.moveaxis(np.take_along_axis(array, order, axis=-1), -1, 0)
    width = tolerance * np.abs(array).max(axis=-1)
    excess = large - middle - small
    impossible = (small < -width) | (excess > width)
    lower, upper = middle - small <= width, large - middle <= width
    cases = {
        "impossible": impossible,
        "point": large == 0.0,
        "spherical": large - small <= width,
        "rod": upper & (small <= width),
        "prolate": upper,
        "oblate": lower,
    }
    kind = np.select(list(cases.values()), list(cases), "asymmetric")
    axis = np.select(
        [np.isin(kind, ["rod", "prolate"]), kind == "oblate"],
        [order[..., 0] + 1, order[..., 2] + 1],
        0,
    )
    return BodyClass(
        kind=kind, axis=axis.astype(np.int8), flat=(np.abs(excess) <= width) & ~impossible
    )


def _in_plane(normal: Floats) -> Floats:
    """Projection, of length one, of the nearest frame axis onto the plane normal to ``normal``."""
    size = np.abs(normal)
    nearest = np.argmax(size <= size.min(axis=-1, keepdims=True) + _TIE, axis=-1)
    along = np.take_along_axis(normal, nearest[..., None], axis=-1)
    projected = np.eye(3)[nearest] - along * normal
    unit: Floats = projected / np.linalg.norm(projected, axis=-1, keepdims=True)
    return unit


def _signed(axis: Floats) -> Floats:
    """Axes with the sign that makes the largest component (the first of equal ones) positive."""
    size = np.abs(axis)
    largest = np.argmax(size >= size.max(axis=-1, keepdims=True) - _TIE, axis=-1)
    leading = np.take_along_axis(axis, largest[..., None], axis=-1)
    return np.where(leading < 0.0, -axis, axis)
