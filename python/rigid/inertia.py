"""Tensors of inertia: of mass points, of parts, about other points, in other and in principal axes.

A tensor of inertia has its products with minus signs, ``I_12 = -sum m x y``, and belongs to a point
and to axes: tensors add only if both are common.

=============================  ===========================================================
of mass points                 inertia_tensor, point_masses
mass, centre and tensor        MassProperties, compose
about another point            steiner
in other axes                  rotate_tensor
in principal axes              principal_axes, classify_body
symmetries of a cloud          symmetry_check
energy, angular momentum       rotational_energy, kinetic_energy, energy_from_momentum;
                               angular_momentum, omega_from_momentum
=============================  ===========================================================
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import finite_float, shaped
from .massproperties import (
    MassProperties,
    check_possible,
    compose,
    inertia_tensor,
    point_masses,
    rotate_tensor,
    steiner,
    symmetric_tensor,
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

Floats = NDArray[np.float64]

_EQUAL = 16.0 * float(np.finfo(np.float64).eps)
"""Share of the largest moment by which two moments may differ by the rounding of a tensor."""

_TIE = 1e-9
"""Components of a unit vector that differ by less are of one size."""


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
    """What kind of body has these moments.

    Attributes
    ----------
    kind : ndarray of str, shape (...)
        ``"asymmetric"``, ``"oblate"`` (two equal moments, the third larger), ``"prolate"`` (the
        third smaller), ``"rod"`` (the third zero), ``"spherical"``, ``"point"`` (no moment at all)
        or ``"impossible"`` (a negative moment, or one above the sum of the other two).
    axis : ndarray of int8, shape (...)
        The symmetry axis 1, 2 or 3 of an oblate or prolate body or a rod; 0 where there is none, or
        every axis is one.
    flat : ndarray of bool, shape (...)
        Whether one moment is the sum of the other two: all mass is in the plane of their axes.
    """

    kind: NDArray[np.str_]
    axis: NDArray[np.int8]
    flat: NDArray[np.bool_]


def principal_axes(tensor: ArrayLike) -> PrincipalAxes:
    """Principal moments, ascending, and right-handed principal axes.

    Every body has them, about every point (Goldstein, § 5.4; Ercan 2016, eq. (37): in the example
    ``I`` stands for the eigenvalue ``I_1``, erratum D-18). The lecture notes call the tensor
    positive definite; their own thin rod has a moment zero (G-11).

    The axes are the same for the same tensor, and change little with its rounding: each but the
    last has its largest component positive. Where moments are equal (to 16 roundings of the
    largest) their axes are free, and laid down: in a plane, the first of the two is the projection
    of that axis of the frame which is nearest to the plane; of a spherical body, the frame itself.

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensors of inertia (kg m²), rods and points included.

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
    check_possible("tensor", moments)
    moments = np.maximum(moments, 0.0)
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
    """The kind of body that has these principal moments.

    Parameters
    ----------
    moments : array_like, shape (..., 3)
        Principal moments (kg m²), in any order.
    tolerance : float
        Share of the largest moment by which equal ones may differ.

    Returns
    -------
    BodyClass

    Raises
    ------
    ValueError
        If a moment is not finite or the tolerance is negative. An impossible body is no error.

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
    """Unit vectors across unit vectors: the frame axis nearest to the plane, projected on it."""
    size = np.abs(normal)
    nearest = np.argmax(size <= size.min(axis=-1, keepdims=True) + _TIE, axis=-1)
    along = np.take_along_axis(normal, nearest[..., None], axis=-1)
    projected = np.eye(3)[nearest] - along * normal
    unit: Floats = projected / np.linalg.norm(projected, axis=-1, keepdims=True)
    return unit


def _signed(axis: Floats) -> Floats:
    """Axes turned so that the largest component, the first of equal ones, is positive."""
    size = np.abs(axis)
    largest = np.argmax(size >= size.max(axis=-1, keepdims=True) - _TIE, axis=-1)
    leading = np.take_along_axis(axis, largest[..., None], axis=-1)
    return np.where(leading < 0.0, -axis, axis)
