"""Homogeneous solids, shells and wires in closed form, and bodies of any density by quadrature.

The symmetry axis of each solid is axis 3. The centre of mass is at the origin, except for the cone,
whose tip is at the origin, as for a top. Sizes broadcast: one call may describe many bodies. A size
may be zero: a cylinder without height is a disk, a cylinder without radius is a rod.

The formulas come from Goldstein, ch. 5, exercises, and Landau and Lifshitz, *Mechanics*, § 32.

The package uses ``_checks``. :mod:`rigid.inertia`, :mod:`rigid.meshes` and :class:`rigid.Body` use
it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import first_place, shaped
from .._checks.arrays import Floats
from .._checks.moments import box_moments
from .._checks.overflow import refuses_overflow
from .density import (
    DensityIntegral,
    Region,
    box_region,
    cylinder_region,
    density_integral,
    ellipsoid_region,
    sampled_density,
)
from .mass_properties import MassProperties

__all__ = [
    "DensityIntegral",
    "MassProperties",
    "Region",
    "box",
    "box_region",
    "cone",
    "cylinder",
    "cylinder_region",
    "density_integral",
    "disk",
    "ellipsoid",
    "ellipsoid_region",
    "ring",
    "rod",
    "sampled_density",
    "sphere",
]


@refuses_overflow
def box(a: ArrayLike, b: ArrayLike, c: ArrayLike, *, mass: ArrayLike = 1.0) -> MassProperties:
    """A homogeneous box with sides ``a, b, c`` (m): ``M/12 (b² + c², a² + c², a² + b²)``.

    Parameters
    ----------
    a, b, c : array_like, shape (...)
        Sides (m) along axes 1, 2, 3; zero for a plate or a rod.
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        If a size is negative, a mass is not positive, or a value is not finite.

    Examples
    --------
    >>> from rigid import solids
    >>> (solids.box(0.25, 0.08, 0.01, mass=12.0).tensor.diagonal() * 1e4).round(9)
    array([ 65., 626., 689.])
    """
    a, b, c = _size("a", a), _size("b", b), _size("c", c)
    return _centred(mass, box_moments(a, b, c, 1.0))


@refuses_overflow
def ellipsoid(a: ArrayLike, b: ArrayLike, c: ArrayLike, *, mass: ArrayLike = 1.0) -> MassProperties:
    """A homogeneous ellipsoid with semi-axes ``a, b, c`` (m): ``M/5 (b² + c², a² + c², a² + b²)``.

    Parameters and errors are as for :func:`box`.

    Parameters
    ----------
    a, b, c : array_like, shape (...)
        Semi-axes (m) along axes 1, 2, 3; zero for a plate or a rod.
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.ellipsoid(3.0, 2.0, 1.0, mass=5.0).tensor.diagonal()
    array([ 5., 10., 13.])
    """
    a, b, c = _size("a", a), _size("b", b), _size("c", c)
    return _centred(mass, box_moments(a, b, c, 12.0) / 5.0)


@refuses_overflow
def sphere(radius: ArrayLike, *, inner: ArrayLike = 0.0, mass: ArrayLike = 1.0) -> MassProperties:
    """A ball, ``2/5 M R²``, hollow up to the radius ``inner``; with ``inner = radius`` a shell.

    The moment is ``2/5 M (R⁵ - r⁵)/(R³ - r³)`` with the inner radius ``r``; the function divides
    out ``R - r``, so that thin shells do not lose digits. A shell has ``2/3 M R²``. The lecture
    notes, § 5.4, example 2, have the solid ball.

    Parameters
    ----------
    radius, inner : array_like, shape (...)
        Outer and inner radius (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`, or if the inner radius exceeds the outer.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.sphere(1.0, mass=5.0).tensor.diagonal()
    array([2., 2., 2.])
    >>> solids.sphere(1.0, inner=1.0, mass=3.0).tensor.diagonal()
    array([2., 2., 2.])
    """
    outer, ratio = _hollow(radius, inner)
    fourth = 1.0 + ratio * (1.0 + ratio * (1.0 + ratio * (1.0 + ratio)))
    moment = 0.4 * outer * outer * fourth / (1.0 + ratio * (1.0 + ratio))
    return _centred(mass, np.stack([moment] * 3, axis=-1))


def ring(radius: ArrayLike, *, mass: ArrayLike = 1.0) -> MassProperties:
    """A ring of wire: moments ``M R² (½, ½, 1)``.

    Lecture notes, § 5.4, where the third moment has a wrong index (erratum G-10).

    Parameters
    ----------
    radius : array_like, shape (...)
        Radius (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.ring(2.0, mass=3.0).tensor.diagonal()
    array([ 6.,  6., 12.])
    """
    return cylinder(radius, 0.0, inner=radius, mass=mass)


def disk(radius: ArrayLike, *, inner: ArrayLike = 0.0, mass: ArrayLike = 1.0) -> MassProperties:
    """A flat disk with a hole up to the radius ``inner``: moments ``M (R² + r²) (¼, ¼, ½)``.

    Parameters and errors are as for :func:`sphere`.

    Parameters
    ----------
    radius, inner : array_like, shape (...)
        Outer and inner radius (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`sphere`.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.disk(2.0, mass=1.0).tensor.diagonal()
    array([1., 1., 2.])
    """
    return cylinder(radius, 0.0, inner=inner, mass=mass)


def rod(length: ArrayLike, *, mass: ArrayLike = 1.0) -> MassProperties:
    """A thin rod along axis 3: moments ``M l²/12`` about axes 1 and 2, zero about axis 3.

    Lecture notes, § 5.4, example 1, where the integral must begin at ``-l/2`` (erratum G-13).
    :meth:`rigid.Body.rod` is the body, which cannot spin about its axis.

    Parameters
    ----------
    length : array_like, shape (...)
        Length (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.rod(2.0, mass=3.0).tensor.diagonal()
    array([1., 1., 0.])
    """
    return box(0.0, 0.0, _size("length", length), mass=mass)


@refuses_overflow
def cylinder(
    radius: ArrayLike, height: ArrayLike, *, inner: ArrayLike = 0.0, mass: ArrayLike = 1.0
) -> MassProperties:
    """A cylinder, hollow up to the radius ``inner``; with ``inner = radius`` a thin pipe.

    The moments are ``½ M (R² + r²)`` about axis 3 and ``M (3 (R² + r²) + h²)/12`` about axes 1, 2.

    Parameters
    ----------
    radius, height : array_like, shape (...)
        Outer radius and height (m).
    inner : array_like, shape (...)
        Inner radius (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`, or if the inner radius exceeds the outer.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.cylinder(1.0, 3.0, mass=2.0).tensor.diagonal()
    array([2., 2., 1.])
    """
    outer, ratio = _hollow(radius, inner)
    square = 0.25 * outer * outer * (1.0 + ratio * ratio)
    across = square + _size("height", height) ** 2 / 12.0
    return _centred(mass, np.stack(np.broadcast_arrays(across, across, 2.0 * square), axis=-1))


@refuses_overflow
def cone(radius: ArrayLike, height: ArrayLike, *, mass: ArrayLike = 1.0) -> MassProperties:
    """A solid cone along axis 3 with its tip at the origin.

    The centre of mass is at the height ``3/4 h``. The moments about the centre of mass are
    ``3/80 M (4 R² + h²)`` about axes 1, 2 and ``3/10 M R²`` about axis 3. For a top that stands on
    the tip, ``cone(...).about([0, 0, 0])`` is the tensor about the tip.

    Parameters
    ----------
    radius, height : array_like, shape (...)
        Radius of the base and height (m).
    mass : array_like, shape (...)
        Mass (kg).

    Returns
    -------
    MassProperties

    Raises
    ------
    ValueError
        As :func:`box`.

    Examples
    --------
    >>> from rigid import solids
    >>> top = solids.cone(1.0, 2.0, mass=20.0)
    >>> top.centre, top.tensor.diagonal(), top.about([0, 0, 0]).diagonal()
    (array([0. , 0. , 1.5]), array([6., 6., 6.]), array([51., 51.,  6.]))
    """
    r, h = np.broadcast_arrays(_size("radius", radius), _size("height", height))
    across = 3.0 * (4.0 * r * r + h * h) / 80.0
    moments = np.stack([across, across, 0.3 * r * r], axis=-1)
    return _centred(mass, moments, centre=np.array([0.0, 0.0, 0.75]) * h[..., None])


def _centred(
    mass: ArrayLike, moments: Floats, centre: ArrayLike = (0.0, 0.0, 0.0)
) -> MassProperties:
    """Mass properties from the moments for unit mass."""
    m = shaped("mass", mass)
    tensor = (m[..., None] * moments)[..., None] * np.eye(3)
    return MassProperties(mass=m, centre=centre, tensor=tensor)


def _size(name: str, value: ArrayLike) -> Floats:
    return shaped(name, value, nonnegative=True, unit="m")


def _hollow(radius: ArrayLike, inner: ArrayLike) -> tuple[Floats, Floats]:
    """The outer radius, and the ratio of the inner to the outer radius."""
    outer, hole = np.broadcast_arrays(_size("radius", radius), _size("inner", inner))
    if np.any(hole > outer):
        index, place = first_place(hole > outer)
        raise ValueError(
            f"inner{place} = {hole[index]}: must not exceed the radius, {outer[index]}"
        )
    return outer, hole / np.where(outer == 0.0, 1.0, outer)
