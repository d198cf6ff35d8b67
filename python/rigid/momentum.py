"""Energy and angular momentum of a turning body, and back from them to its rates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import first_place, shaped
from .bodies import Body
from .massproperties import MassProperties, possible_tensor
from .quaternions import quaternion_to_matrix, quaternions

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "angular_momentum",
    "energy_from_momentum",
    "kinetic_energy",
    "omega_from_momentum",
    "rotational_energy",
]

Floats = NDArray[np.float64]

_NOTHING = 1e-14
"""Share of the largest moment, or momentum, that counts as zero: rounding of a rod's tensor."""


def rotational_energy(omega: ArrayLike, inertia: Body | MassProperties | ArrayLike) -> Floats:
    """Kinetic energy of rotation: ``½ omega·I omega``.

    Goldstein, § 5.3; Ercan 2016, eqs. (24), (34); lecture notes, eqs. (5.10), (5.12), where the
    factor ½ is missing from the second (erratum G-12). In the third line of Ercan's derivation
    ``(omega × r)²`` is a misprint for ``(omega·r)²`` (D-12).

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s) in the axes of the tensor.
    inertia : Body, MassProperties, or array_like of shape (3,) or (..., 3, 3)
        Principal moments of one body, or tensors of inertia (kg m²). Moments of many bodies go in
        as diagonal tensors, ``moments[..., None] * np.eye(3)``.

    Returns
    -------
    ndarray, shape (...)
        Energy (J).

    Raises
    ------
    ValueError
        If no body has such a tensor, or anything is not finite.

    Examples
    --------
    >>> from rigid import inertia
    >>> float(inertia.rotational_energy([1.0, 0.0, 2.0], [1.0, 2.0, 2.5]))
    5.5
    """
    w, tensor = shaped("omega", omega, 3), _tensor(inertia)
    energy: Floats = 0.5 * np.vecdot(w, np.matvec(tensor, w))
    return energy


def kinetic_energy(
    omega: ArrayLike,
    inertia: Body | MassProperties | ArrayLike,
    mass: ArrayLike,
    velocity: ArrayLike,
) -> Floats:
    """Kinetic energy of a free body: ``½ M V² + ½ omega·I omega`` (König).

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

    Examples
    --------
    >>> from rigid import inertia
    >>> float(inertia.kinetic_energy([1.0, 0.0, 2.0], [1.0, 2.0, 2.5], 3.0, [0.0, 2.0, 0.0]))
    11.5
    """
    m, v = shaped("mass", mass, nonnegative=True), shaped("velocity", velocity, 3)
    energy: Floats = 0.5 * m * np.vecdot(v, v) + rotational_energy(omega, inertia)
    return energy


def energy_from_momentum(momentum: ArrayLike, inertia: Body | MassProperties | ArrayLike) -> Floats:
    """Kinetic energy of rotation from the angular momentum: in principal axes ``½ sum L²/I``.

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


def angular_momentum(
    omega: ArrayLike,
    inertia: Body | MassProperties | ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
) -> Floats:
    """Angular momentum ``I omega`` in the body, or ``R I omega`` in space.

    Parallel to ``omega`` on principal axes only. Goldstein, § 5.1; Ercan 2016, eq. (26);
    lecture notes, eqs. (5.6), (5.8).

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s), in the body.
    inertia
        As for :func:`rotational_energy`.
    attitude : array_like, shape (..., 4) or (..., 3, 3), or SciPy Rotation, optional
        If given, the components of the result are those in space.

    Returns
    -------
    ndarray, shape (..., 3)
        Angular momentum (kg m²/s).

    Raises
    ------
    ValueError
        If no body has such a tensor, or anything is not finite.

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


def omega_from_momentum(
    momentum: ArrayLike,
    inertia: Body | MassProperties | ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
) -> Floats:
    """Angular velocity in the body of a given angular momentum: ``I⁻¹ L``, or ``I⁻¹ R.T L``.

    A rod has no moment about its own axis: then there must be no momentum about it, and the
    rate about it, which is free, is taken as zero.

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


def _tensor(inertia: Body | MassProperties | ArrayLike) -> Floats:
    """The tensors meant by a body, its mass properties, three moments, or an array of tensors."""
    if isinstance(inertia, Body):
        return np.diag(inertia.moments)
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
