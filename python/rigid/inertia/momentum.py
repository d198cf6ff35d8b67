"""Energy and angular momentum from the angular velocity, and the angular velocity from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import first_place, shaped
from .._checks.arrays import Floats
from .._checks.moments import possible_tensor
from .._checks.overflow import refuses_overflow
from ..rotations.quaternions import quaternion_to_matrix, quaternions
from ..solids.mass_properties import MassProperties

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


_NOTHING = 1e-14
"""Fraction of the largest moment, or momentum, that counts as zero: rounding of a rod's tensor."""


@runtime_checkable
class HasMoments(Protocol):
    """A body or many: any object that has principal moments of inertia."""

    @property
    def moments(self) -> tuple[float, float, float] | Floats:
        """Principal moments of inertia (kg m²)."""


@refuses_overflow
def rotational_energy(omega: ArrayLike, inertia: HasMoments | MassProperties | ArrayLike) -> Floats:
    """Kinetic energy of rotation: ``½ omega·I omega``.

    Goldstein, § 5.3; Ercan 2016, eqs. (24), (34); lecture notes, eqs. (5.10), (5.12), where the
    factor ½ is missing from the second (erratum G-12). In the third line of Ercan's derivation
    ``(omega × r)²`` is a misprint for ``(omega·r)²`` (D-12).

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s) in the axes of the tensor.
    inertia : Body, MassProperties, or array_like of shape (3,) or (..., 3, 3)
        Principal moments of one body, or tensors of inertia (kg m²). For moments of many bodies
        pass diagonal tensors, ``moments[..., None] * np.eye(3)``, or a :class:`rigid.Body`.

    Returns
    -------
    ndarray, shape (...)
        Energy (J).

    Raises
    ------
    ValueError
        If no body has such a tensor, or a value is not finite.

    Examples
    --------
    >>> from rigid import inertia
    >>> float(inertia.rotational_energy([1.0, 0.0, 2.0], [1.0, 2.0, 2.5]))
    5.5
    """
    w, tensor = shaped("omega", omega, 3), _tensor(inertia)
    energy: Floats = 0.5 * np.vecdot(w, np.matvec(tensor, w))
    return energy


@refuses_overflow
def kinetic_energy(
    omega: ArrayLike,
    inertia: HasMoments | MassProperties | ArrayLike,
    mass: ArrayLike,
    velocity: ArrayLike,
) -> Floats:
    """Kinetic energy of a free body: ``½ M V² + ½ omega·I omega`` (König's theorem).

    Parameters
    ----------
    omega, inertia
        As for :func:`rotational_energy`, about the centre of mass.
    mass : array_like, shape (...)
        Mass (kg), not negative.
    velocity : array_like, shape (..., 3)
        Velocity of the centre of mass (m/s), in any axes.

    Returns
    -------
    ndarray, shape (...)
        Energy (J).

    Raises
    ------
    ValueError
        As for :func:`rotational_energy`, or if a mass is negative.

    Examples
    --------
    >>> from rigid import inertia
    >>> float(inertia.kinetic_energy([1.0, 0.0, 2.0], [1.0, 2.0, 2.5], 3.0, [0.0, 2.0, 0.0]))
    11.5
    """
    m, v = shaped("mass", mass, nonnegative=True), shaped("velocity", velocity, 3)
    energy: Floats = 0.5 * m * np.vecdot(v, v) + rotational_energy(omega, inertia)
    return energy


@refuses_overflow
def energy_from_momentum(
    momentum: ArrayLike, inertia: HasMoments | MassProperties | ArrayLike
) -> Floats:
    """Kinetic energy of rotation from the angular momentum; ``½ sum L²/I`` in principal axes.

    Ercan 2016, eq. (36).

    Parameters
    ----------
    momentum : array_like, shape (..., 3)
        Angular momentum (kg m²/s) in the axes of the tensor.
    inertia
        As for :func:`rotational_energy`.

    Returns
    -------
    ndarray, shape (...)
        Energy (J).

    Raises
    ------
    ValueError
        As :func:`omega_from_momentum`.

    Examples
    --------
    >>> from rigid import inertia
    >>> float(inertia.energy_from_momentum([1.0, 0.0, 5.0], [1.0, 2.0, 2.5]))
    5.5
    """
    L = shaped("momentum", momentum, 3)
    energy: Floats = 0.5 * np.vecdot(L, omega_from_momentum(L, inertia))
    return energy


@refuses_overflow
def angular_momentum(
    omega: ArrayLike,
    inertia: HasMoments | MassProperties | ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
) -> Floats:
    """Angular momentum ``I omega`` in the body, or ``R I omega`` in space.

    The angular momentum is parallel to ``omega`` on principal axes only. Goldstein, § 5.1; Ercan
    2016, eq. (26); lecture notes, eqs. (5.6), (5.8).

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s), in the body.
    inertia
        As for :func:`rotational_energy`.
    attitude : array_like, shape (..., 4) or (..., 3, 3), or SciPy Rotation, optional
        If given, the result has components in space.

    Returns
    -------
    ndarray, shape (..., 3)
        Angular momentum (kg m²/s).

    Raises
    ------
    ValueError
        If no body has such a tensor, or a value is not finite.

    Examples
    --------
    >>> from rigid import inertia
    >>> inertia.angular_momentum([1.0, 0.0, 2.0], [1.0, 2.0, 2.5])
    array([1., 0., 5.])
    """
    L: Floats = np.matvec(_tensor(inertia), shaped("omega", omega, 3))
    if attitude is not None:
        L = np.matvec(quaternion_to_matrix(quaternions("attitude", attitude)), L)
    return L


@refuses_overflow
def omega_from_momentum(
    momentum: ArrayLike,
    inertia: HasMoments | MassProperties | ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
) -> Floats:
    """Angular velocity in the body from the angular momentum: ``I⁻¹ L``, or ``I⁻¹ R.T L``.

    The moment of a rod about its own axis is zero. The momentum about this axis must then be zero,
    and the function sets the rate about this axis, which is arbitrary, to zero.

    Parameters
    ----------
    momentum : array_like, shape (..., 3)
        Angular momentum (kg m²/s): in space if ``attitude`` is given, else in the body.
    inertia
        As for :func:`rotational_energy`.
    attitude : array_like, shape (..., 4) or (..., 3, 3), or SciPy Rotation, optional
        Attitude of the body.

    Returns
    -------
    ndarray, shape (..., 3)
        Angular velocity (rad/s), in the body.

    Raises
    ------
    ValueError
        If no body has such a tensor, or there is momentum about an axis without a moment.

    Examples
    --------
    >>> from rigid import inertia
    >>> inertia.omega_from_momentum([1.0, 0.0, 5.0], [1.0, 2.0, 2.5])
    array([1., 0., 2.])
    """
    L = shaped("momentum", momentum, 3)
    if attitude is not None:
        L = np.vecmat(L, quaternion_to_matrix(quaternions("attitude", attitude)))
    moments, axes = np.linalg.eigh(_tensor(inertia))
    along = np.vecmat(L, axes)
    moments = np.broadcast_to(moments, along.shape)
    none = moments <= _NOTHING * moments[..., -1:]
    lost = none & (np.abs(along) > _NOTHING * np.linalg.norm(along, axis=-1, keepdims=True))
    if np.any(lost):
        _, place = first_place(lost.any(axis=-1))
        raise ValueError(
            f"momentum{place}: its component along an axis without a moment of inertia is "
            f"{along[lost][0]:.3g}; it must be zero"
        )
    rates = np.where(none, 0.0, along / np.where(none, 1.0, moments))
    omega: Floats = np.matvec(axes, rates)
    return omega


def _tensor(inertia: HasMoments | MassProperties | ArrayLike) -> Floats:
    """Tensors of inertia of a body, of mass properties, of moments, or an array of tensors."""
    if isinstance(inertia, HasMoments):
        return np.asarray(inertia.moments)[..., np.newaxis] * np.eye(3)
    if isinstance(inertia, MassProperties):
        return inertia.tensor
    if np.shape(inertia) == (3,):
        return possible_tensor("inertia", np.diag(shaped("inertia", inertia, 3)))
    if np.shape(inertia)[-2:] != (3, 3):
        raise ValueError(
            f"inertia: expected shape (3,) or (..., 3, 3), got {np.shape(inertia)}; moments of "
            "many bodies go in as diagonal tensors, moments[..., None] * np.eye(3)"
        )
    return possible_tensor("inertia", inertia)
