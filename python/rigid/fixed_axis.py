"""A body that turns about an axis in bearings: the load of the bearings, and balance.

Body axes are any axes fixed in the body with their origin on the axis of rotation; they need not be
principal axes. The products of inertia carry their minus signs in the tensor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import finite_float, shaped, together, vector
from ._checks.arrays import Floats
from ._checks.moments import possible_tensor
from ._checks.overflow import refuses_overflow

__all__ = [
    "Analogy",
    "Balance",
    "BearingTorques",
    "Quantity",
    "analogy_table",
    "balance_test",
    "bearing_forces",
    "bearing_reactions",
    "bearing_torques",
    "two_plane_balance",
]


BALANCE = 1e-9
"""Relative size, to the moments or the gyration radius, below which an imbalance counts as none."""

_E3 = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BearingTorques:
    """Angular momentum of a body that turns about a fixed axis, and the torque of the motion.

    Attributes
    ----------
    angular_momentum, torque : ndarray, shape (..., 3)
        Angular momentum and torque about the origin, components in the body (kg m²/s, N m).
    angular_momentum_space, torque_space : ndarray, shape (..., 3)
        Angular momentum and torque, components in space.
    driving : ndarray, shape (...)
        Component of the torque along the axis, from the drive: ``I_zz omega'`` for the z axis.
    bearing : ndarray, shape (..., 3)
        Part of the torque perpendicular to the axis, from the bearings; components in the body.
    """

    angular_momentum: Floats
    torque: Floats
    angular_momentum_space: Floats
    torque_space: Floats
    driving: Floats
    bearing: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Balance:
    """Static and dynamic balance of a body about an axis.

    Attributes
    ----------
    offset : ndarray, shape (...)
        Distance of the centre of mass from the axis (m).
    product : ndarray, shape (...)
        Size of the products of inertia of the axis, ``sqrt(I_xz² + I_yz²)`` for the z axis (kg m²).
    static : ndarray of bool, shape (...)
        Whether the centre of mass lies on the axis, so that the rotation needs no net force.
    dynamic : ndarray of bool, shape (...)
        Whether the axis is a principal axis, so that a steady rotation needs no torque.
    """

    offset: Floats
    product: Floats
    static: NDArray[np.bool_]
    dynamic: NDArray[np.bool_]

    @property
    def balanced(self) -> NDArray[np.bool_]:
        """Whether the balance is static and dynamic: the bearings carry only the weight."""
        return self.static & self.dynamic


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity of mechanics: its name, symbol, SI unit, and exponents of kg, m and s.

    Attributes
    ----------
    name, symbol, unit : str
        Name, symbol and SI unit, as printed.
    dimension : tuple of 3 ints
        Exponents of kg, m and s; all zero for an angle.
    """

    name: str
    symbol: str
    unit: str
    dimension: tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Analogy:
    """A quantity of rotation about the z axis and the analogous quantity of motion along it.

    Attributes
    ----------
    rotation, translation : Quantity
        Both quantities.
    """

    rotation: Quantity
    translation: Quantity


@refuses_overflow
def bearing_torques(
    tensor: ArrayLike,
    omega: ArrayLike,
    omega_dot: ArrayLike = 0.0,
    *,
    axis: ArrayLike = _E3,
    angle: ArrayLike = 0.0,
) -> BearingTorques:
    """Torque of the drive and of the bearings on a body that turns about a fixed axis.

    ``L = I n omega`` and ``N = I n omega' + n × I n omega²``: about the z axis
    ``(I_xz omega' - I_yz omega², I_yz omega' + I_xz omega², I_zz omega')`` in the body (Goldstein,
    *Classical Mechanics*, § 5.5; Ercan 2016, eq. (29), with components in space). ``I_zz`` does not
    depend on time (erratum D-15), but the products of inertia in space do: eq. (29) with products
    in the body lacks the terms in ``omega²``. The bearings supply the torque perpendicular to the
    axis (erratum D-42).

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensor of inertia in the body (kg m²), about a point of the axis.
    omega, omega_dot : array_like, shape (...)
        Rate about the axis (rad/s) and its derivative (rad/s²).
    axis : array_like, shape (3,)
        Direction of the axis in the body, of any length. Default: the z axis.
    angle : array_like, shape (...)
        Angle (rad) of the body from the axes of space.

    Returns
    -------
    BearingTorques

    Raises
    ------
    ValueError
        If the tensor is not symmetric or no body has it, the axis is zero, or an argument is not
        finite.

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> tilted = [[2.0, 0.0, -0.5], [0.0, 2.0, 0.0], [-0.5, 0.0, 1.5]]
    >>> fixed_axis.bearing_torques(tilted, omega=10.0, omega_dot=2.0).torque.tolist()
    [-1.0, -50.0, 3.0]
    """
    inertia, n = possible_tensor("tensor", tensor), _direction(axis)
    w, dw, turned = (
        shaped(name, value)[..., np.newaxis]
        for name, value in (("omega", omega), ("omega_dot", omega_dot), ("angle", angle))
    )
    about, w, dw, turned = together(tensor=inertia @ n, omega=w, omega_dot=dw, angle=turned)
    momentum = about * w
    torque = about * dw + np.cross(n, about) * (w * w)
    driving = torque @ n
    return BearingTorques(
        angular_momentum=momentum,
        torque=torque,
        angular_momentum_space=_turned(momentum, n, turned),
        torque_space=_turned(torque, n, turned),
        driving=driving,
        bearing=torque - driving[..., np.newaxis] * n,
    )


@refuses_overflow
def bearing_forces(
    mass: ArrayLike,
    com: ArrayLike,
    omega: ArrayLike,
    omega_dot: ArrayLike = 0.0,
    *,
    axis: ArrayLike = _E3,
) -> Floats:
    """Force of the bearings on a body that turns about a fixed axis, without weight.

    ``F = m (omega' n × c + omega² n × (n × c))`` in the body; zero if the centre of mass
    lies on the axis (Ercan 2016, § 7.2).

    Parameters
    ----------
    mass : array_like, shape (...)
        Mass (kg), >= 0.
    com : array_like, shape (..., 3)
        Centre of mass in the body (m), from a point of the axis.
    omega, omega_dot, axis : array_like
        As in :func:`bearing_torques`.

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    ValueError
        If the mass is negative, the axis is zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> fixed_axis.bearing_forces(2.0, [0.1, 0.0, 5.0], omega=10.0).tolist()
    [-20.0, 0.0, 0.0]
    """
    n = _direction(axis)
    m, w, dw = (
        shaped(name, value, nonnegative=name == "mass")[..., np.newaxis]
        for name, value in (("mass", mass), ("omega", omega), ("omega_dot", omega_dot))
    )
    m, c, w, dw = together(mass=m, com=shaped("com", com, 3), omega=w, omega_dot=dw)
    across = np.cross(n, c)
    return np.asarray(m * (dw * across + w * w * np.cross(n, across)))


@refuses_overflow
def bearing_reactions(
    tensor: ArrayLike,
    mass: ArrayLike,
    com: ArrayLike,
    omega: ArrayLike,
    omega_dot: ArrayLike = 0.0,
    *,
    at: ArrayLike,
    axis: ArrayLike = _E3,
) -> Floats:
    """Forces of two bearings on a body that turns about a fixed axis, without weight.

    The two forces perpendicular to the axis have the sum of :func:`bearing_forces`, and their
    torque about the origin is the part of :func:`bearing_torques` perpendicular to the axis.

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensor of inertia in the body (kg m²), about the origin, which is a point of the axis.
    mass, com, omega, omega_dot, axis : array_like
        As in :func:`bearing_forces`.
    at : array_like, shape (2,)
        Places of the two bearings along the axis, from the origin (m).

    Returns
    -------
    ndarray, shape (..., 2, 3)
        The forces of the first and of the second bearing, components in the body (N).

    Raises
    ------
    ValueError
        If both bearings are in one place, or for the reasons of the two functions.

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> ball = [[0.01, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.01]]  # 1 kg at x = 0.1 m
    >>> forces = fixed_axis.bearing_reactions(ball, 1.0, [0.1, 0, 0], 10.0, at=(-1.0, 3.0))
    >>> forces.tolist()
    [[-7.5, 0.0, 0.0], [-2.5, 0.0, 0.0]]
    """
    first, second = _planes(at)
    force = bearing_forces(mass, com, omega, omega_dot, axis=axis)
    torque = bearing_torques(tensor, omega, omega_dot, axis=axis).bearing
    force, torque = together(com=force, tensor=torque)
    lever = np.cross(torque, _direction(axis))
    far = (lever - first * force) / (second - first)
    near = (second * force - lever) / (second - first)
    return np.stack([near, far], axis=-2)


@refuses_overflow
def two_plane_balance(
    tensor: ArrayLike, mass: ArrayLike, com: ArrayLike, *, at: ArrayLike, axis: ArrayLike = _E3
) -> Floats:
    """Unbalances to add in two planes, so that a body turns without load on its bearings.

    A mass ``m`` at the distance ``r`` from the axis is the unbalance ``m r`` in its direction. So
    ``|u| / r`` is the mass that a workshop adds at the radius ``r``, or takes away opposite to it.
    The two make the centre of mass lie on the axis and the axis a principal one (ISO 21940-11,
    balancing of rigid rotors in two planes).

    Parameters
    ----------
    tensor, mass, com, axis : array_like
        As in :func:`bearing_reactions`.
    at : array_like, shape (2,)
        Places of the two planes along the axis, from the origin (m).

    Returns
    -------
    ndarray, shape (..., 2, 3)
        The unbalances in the first and in the second plane, components in the body (kg m).

    Raises
    ------
    ValueError
        If both planes are in one place, the mass is negative, the tensor is not symmetric or no
        body has it, the axis is zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> ball = [[0.01, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.01]]  # 1 kg at x = 0.1 m
    >>> fixed_axis.two_plane_balance(ball, 1.0, [0.1, 0, 0], at=(-1.0, 1.0)).tolist()
    [[-0.05, 0.0, 0.0], [-0.05, 0.0, 0.0]]
    """
    first, second = _planes(at)
    inertia, n = possible_tensor("tensor", tensor), _direction(axis)
    m = shaped("mass", mass, nonnegative=True)[..., np.newaxis]
    # Twice the cross product with the axis is minus the part across the axis.
    across = np.cross(n, np.cross(n, m * shaped("com", com, 3)))
    product = np.cross(n, np.cross(n, inertia @ n))  # the integral of z (x, y) over the mass
    across, product = together(com=across, tensor=product)
    far = (-product - first * across) / (second - first)
    near = (second * across + product) / (second - first)
    return np.asarray(np.stack([near, far], axis=-2) + 0.0)


@refuses_overflow
def balance_test(
    tensor: ArrayLike,
    *,
    mass: ArrayLike,
    com: ArrayLike,
    axis: ArrayLike = _E3,
    rtol: float = BALANCE,
) -> Balance:
    """Static and dynamic balance of a body about an axis.

    A steady rotation needs no force if the centre of mass lies on the axis, and no torque if the
    axis is a principal axis (Ercan 2016, §§ 6, 7.2).

    Parameters
    ----------
    tensor : array_like, shape (..., 3, 3)
        Tensor of inertia in the body (kg m²), about a point of the axis.
    mass : array_like, shape (...)
        Mass (kg), positive.
    com : array_like, shape (..., 3)
        Centre of mass in the body (m), from the point of the tensor.
    axis : array_like, shape (3,)
        Direction of the axis in the body, of any length.
    rtol : float
        Offsets up to this fraction of the radius of gyration, and products up to this fraction of
        the moments, count as zero.

    Returns
    -------
    Balance

    Raises
    ------
    ValueError
        If the mass is not positive, the tensor is not symmetric or no body has it, the axis is
        zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> wheel = fixed_axis.balance_test(
    ...     [[2.0, 0.0, -0.1], [0.0, 2.0, 0.0], [-0.1, 0.0, 3.0]], mass=10.0, com=[0, 0, 0]
    ... )
    >>> bool(wheel.static), bool(wheel.dynamic), float(wheel.product)
    (True, False, 0.1)
    """
    inertia, n = possible_tensor("tensor", tensor), _direction(axis)
    m, c = shaped("mass", mass, positive=True), shaped("com", com, 3)
    share = finite_float("rtol", rtol, nonnegative=True)
    # Components perpendicular to the axis come from a cross product, which loses no digits.
    offset = np.linalg.norm(np.cross(n, c), axis=-1)
    product = np.linalg.norm(np.cross(n, inertia @ n), axis=-1)
    moments = 0.5 * np.trace(inertia, axis1=-2, axis2=-1)
    offset, product, moments, m = together(com=offset, product=product, tensor=moments, mass=m)
    return Balance(
        offset=offset,
        product=product,
        static=offset <= share * np.sqrt(moments / m),
        dynamic=product <= share * moments,
    )


def analogy_table() -> tuple[Analogy, ...]:
    """The seven quantities of rotation about the z axis and the analogous ones of translation.

    Ercan 2016, table 1.

    Returns
    -------
    tuple of Analogy

    Examples
    --------
    >>> from rigid import fixed_axis
    >>> for row in fixed_axis.analogy_table():
    ...     print(row.rotation.symbol, "~", row.translation.symbol)
    I_zz ~ m
    phi ~ z
    omega ~ v
    omega' ~ a
    L_z ~ p_z
    I_zz omega²/2 ~ m v²/2
    N_z ~ F_z
    """
    return _TABLE


_TABLE = tuple(
    Analogy(Quantity(*rotation), Quantity(*translation))
    for rotation, translation in (
        (("moment of inertia", "I_zz", "kg m²", (1, 2, 0)), ("mass", "m", "kg", (1, 0, 0))),
        (("angle", "phi", "rad", (0, 0, 0)), ("position", "z", "m", (0, 1, 0))),
        (("angular velocity", "omega", "rad/s", (0, 0, -1)), ("velocity", "v", "m/s", (0, 1, -1))),
        (
            ("angular acceleration", "omega'", "rad/s²", (0, 0, -2)),
            ("acceleration", "a", "m/s²", (0, 1, -2)),
        ),
        (
            ("angular momentum", "L_z", "kg m²/s", (1, 2, -1)),
            ("momentum", "p_z", "kg m/s", (1, 1, -1)),
        ),
        (
            ("rotational energy", "I_zz omega²/2", "J", (1, 2, -2)),
            ("kinetic energy", "m v²/2", "J", (1, 2, -2)),
        ),
        (("torque", "N_z", "N m", (1, 2, -2)), ("force", "F_z", "N", (1, 1, -2))),
    )
)


def _direction(axis: ArrayLike) -> Floats:
    n = vector("axis", axis, 3)
    largest = np.abs(n).max()
    if largest == 0.0:
        raise ValueError("axis = [0.0, 0.0, 0.0]: an axis needs a direction")
    n = n / largest  # no square leaves the range of doubles
    return np.asarray(n / np.linalg.norm(n))


def _planes(at: ArrayLike) -> tuple[float, float]:
    first, second = vector("at", at, 2).tolist()
    if first == second:
        raise ValueError(f"at = {[first, second]}: must be two places along the axis")
    return first, second


def _turned(vectors: Floats, axis: Floats, angle: Floats) -> Floats:
    """Vectors (..., 3) turned about a unit axis; angles (..., 1)."""
    along = (vectors @ axis)[..., np.newaxis] * axis
    across = vectors - along
    return np.asarray(along + np.cos(angle) * across + np.sin(angle) * np.cross(axis, across))
