"""Elementary rotations and Euler angles z-x-z, with their rates.

``R = Rz(phi) Rx(theta) Rz(psi)``, active, body to space: precession, nutation, spin. Goldstein's
passive matrix, space to body, is ``A = B C D = R.T`` (*Classical Mechanics*, § 4.4; Ercan 2016,
eqs. (1)-(7)). If body axis 3 is vertical, phi and psi are not unique: at ``theta = 0`` only
``phi + psi`` is defined, at pi only ``phi - psi``. The functions then return ``psi = 0``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import first_place, one_of, shaped
from .._checks.arrays import Floats
from .._checks.matrices import rotation_matrices
from .quaternions import canonical_quaternion

FRAMES = ("body", "space", "node")

_ON_THE_VERTICAL = 2.0**-50
"""A sine of theta below this value is rounding of a product of three rotations."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EulerRates:
    """Rates of the Euler angles.

    Attributes
    ----------
    rates : ndarray, shape (..., 3)
        ``phi', theta', psi'`` (rad/s).
    singular : ndarray of bool, shape (...)
        Whether body axis 3 is vertical, so that the rates of least norm are returned.
    residual : ndarray, shape (...)
        The part of the angular velocity that no Euler rates produce (rad/s): zero unless singular,
        then the component along the horizontal direction perpendicular to the node line.
    """

    rates: Floats
    singular: NDArray[np.bool_]
    residual: Floats


def rotation_x(angle: ArrayLike, *, passive: bool = False) -> Floats:
    """The elementary rotation about axis 1.

    Active: a vector turns by the angle. Passive: the axes turn, ``C`` of Goldstein, § 4.4, and
    of Ercan 2016, eq. (5); the transpose.

    Parameters
    ----------
    angle : array_like, shape (...)
        Angle (rad).
    passive : bool
        Whether the axes turn instead of the vector.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If an angle is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.rotation_x(np.pi / 2).round(15) @ [0.0, 1.0, 0.0]
    array([0., 0., 1.])
    >>> rotations.rotation_x(np.pi / 2, passive=True).round(15) @ [0.0, 0.0, 1.0]
    array([0., 1., 0.])
    """
    return _elementary(0, angle, passive)


def rotation_y(angle: ArrayLike, *, passive: bool = False) -> Floats:
    """The elementary rotation about axis 2; arguments and conventions as in :func:`rotation_x`.

    Parameters
    ----------
    angle : array_like, shape (...)
        Angle (rad).
    passive : bool
        Whether the axes turn instead of the vector.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If an angle is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.rotation_y(np.pi / 2).round(15) @ [0.0, 0.0, 1.0]
    array([1., 0., 0.])
    """
    return _elementary(1, angle, passive)


def rotation_z(angle: ArrayLike, *, passive: bool = False) -> Floats:
    """The elementary rotation about axis 3; arguments and conventions as in :func:`rotation_x`.

    The passive matrix is ``D`` for ``phi`` and ``B`` for ``psi`` of Goldstein, § 4.4,
    and of Ercan 2016, eqs. (3), (7).

    Parameters
    ----------
    angle : array_like, shape (...)
        Angle (rad).
    passive : bool
        Whether the axes turn instead of the vector.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If an angle is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.rotation_z(np.pi / 2).round(15) @ [1.0, 0.0, 0.0]
    array([0., 1., 0.])
    """
    return _elementary(2, angle, passive)


def euler_to_matrix(angles: ArrayLike, *, passive: bool = False) -> Floats:
    """The rotation matrix of Euler angles ``(phi, theta, psi)``.

    Goldstein, § 4.4; Ercan 2016, § 3 (``A = BCD``, the passive matrix). In the lecture notes the
    matrix of eqs. (5.2), (5.3) is the passive one as well, although eq. (5.1) uses the same letter
    for the active one (erratum G-07).

    Parameters
    ----------
    angles : array_like, shape (..., 3)
        ``phi, theta, psi`` (rad), of any size.
    passive : bool
        Whether to give ``A = R.T``, which takes components in space to those in the body.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``R``, active, body to space.

    Raises
    ------
    ValueError
        If an angle is not finite.

    Examples
    --------
    >>> from rigid import rotations
    >>> R = rotations.euler_to_matrix([0.3, 1.1, -0.4])
    >>> bool(abs(R.T - rotations.euler_to_matrix([0.3, 1.1, -0.4], passive=True)).max() == 0.0)
    True
    """
    phi, theta, psi = np.moveaxis(shaped("angles", angles, 3), -1, 0)
    matrix = _elementary(2, phi, False) @ _elementary(0, theta, False) @ _elementary(2, psi, False)
    return np.swapaxes(matrix, -1, -2) if passive else matrix


def matrix_to_euler(matrix: ArrayLike, *, passive: bool = False) -> Floats:
    """The Euler angles ``(phi, theta, psi)`` of a rotation matrix.

    ``theta`` is between 0 and pi, ``phi`` and ``psi`` are in (-pi, pi]. If ``sin(theta)`` is zero
    to rounding, ``psi = 0`` and ``theta`` is 0 or pi. The matrix of the angles is always the given
    one to rounding, because ``psi`` is measured from the node line that ``phi`` defines.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)
        Rotations.
    passive : bool
        Whether the matrix is ``A = R.T``.

    Returns
    -------
    ndarray, shape (..., 3)
        ``phi, theta, psi`` (rad).

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4; within, the nearest rotation is taken.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.matrix_to_euler(rotations.euler_to_matrix([0.3, 1.1, -0.4]))
    array([ 0.3,  1.1, -0.4])
    >>> rotations.matrix_to_euler(rotations.euler_to_matrix([0.3, 0.0, 0.5]))
    array([0.8, 0. , 0. ])
    """
    r = rotation_matrices("matrix", matrix)
    r = np.swapaxes(r, -1, -2) if passive else r
    sine = np.hypot(r[..., 0, 2], r[..., 1, 2])
    vertical = sine <= _ON_THE_VERTICAL
    theta = np.arctan2(np.where(vertical, 0.0, sine), r[..., 2, 2])
    phi = np.where(
        vertical,
        np.arctan2(r[..., 1, 0], r[..., 0, 0]),
        np.arctan2(r[..., 0, 2], -r[..., 1, 2]),
    )
    # The node line in body components: Rz(-phi) R has the first row (cos psi, -sin psi, 0).
    node = np.cos(phi)[..., None] * r[..., 0, :2] + np.sin(phi)[..., None] * r[..., 1, :2]
    psi = np.where(vertical, 0.0, np.arctan2(-node[..., 1], node[..., 0]))
    return np.stack([_wrapped(phi), theta, _wrapped(psi)], axis=-1) + 0.0  # no negative zeros


def euler_to_quaternion(angles: ArrayLike) -> Floats:
    """The unit quaternion of Euler angles; its first component that is not zero is positive.

    With ``s = (phi + psi)/2`` and ``d = (phi - psi)/2`` it is ``(cos(theta/2) cos s,
    sin(theta/2) cos d, sin(theta/2) sin d, cos(theta/2) sin s)`` (Goldstein, § 4.5).

    Parameters
    ----------
    angles : array_like, shape (..., 3)
        ``phi, theta, psi`` (rad).

    Returns
    -------
    ndarray, shape (..., 4)
        Quaternions, scalar first.

    Raises
    ------
    ValueError
        If an angle is not finite or has another shape.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.euler_to_quaternion([0.0, np.pi, 0.0]).round(15)
    array([0., 1., 0., 0.])
    """
    phi, theta, psi = np.moveaxis(shaped("angles", angles, 3), -1, 0)
    total, difference = 0.5 * (phi + psi), 0.5 * (phi - psi)
    cosine, sine = np.cos(0.5 * theta), np.sin(0.5 * theta)
    return canonical_quaternion(
        np.stack(
            [
                cosine * np.cos(total),
                sine * np.cos(difference),
                sine * np.sin(difference),
                cosine * np.sin(total),
            ],
            axis=-1,
        )
    )


def quaternion_to_euler(quaternion: ArrayLike) -> Floats:
    """The Euler angles of a quaternion, in the ranges of :func:`matrix_to_euler`.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Quaternions of any length but zero, scalar first.

    Returns
    -------
    ndarray, shape (..., 3)
        ``phi, theta, psi`` (rad).

    Raises
    ------
    ValueError
        If a quaternion is zero or not finite.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.quaternion_to_euler(rotations.euler_to_quaternion([0.3, 1.1, -0.4]))
    array([ 0.3,  1.1, -0.4])
    """
    w, x, y, z = np.moveaxis(canonical_quaternion(quaternion), -1, 0)
    lying, standing = np.hypot(x, y), np.hypot(w, z)
    up, down = 2.0 * lying <= _ON_THE_VERTICAL, 2.0 * standing <= _ON_THE_VERTICAL
    theta = 2.0 * np.arctan2(np.where(up, 0.0, lying), np.where(down, 0.0, standing))
    total, difference = np.arctan2(z, w), np.arctan2(y, x)
    phi = np.select([up, down], [2.0 * total, 2.0 * difference], total + difference)
    psi = np.where(up | down, 0.0, total - difference)
    return np.stack([_wrapped(phi), theta, _wrapped(psi)], axis=-1) + 0.0


def euler_axes(angles: ArrayLike, *, frame: str = "body") -> Floats:
    """The unit axes ``e_phi, e_theta, e_psi`` about which the Euler angles turn, as columns.

    ``e_phi`` is the vertical, ``e_theta`` the node line, ``e_psi`` body axis 3. They are not
    orthogonal: the determinant is ``-sin(theta)``. Lecture notes, eq. (5.5), in body components.

    Parameters
    ----------
    angles : array_like, shape (..., 3)
        ``phi, theta, psi`` (rad).
    frame : {"body", "space", "node"}
        The frame of the components. The axes of the node frame are the node line, the direction
        perpendicular to the node line and to body axis 3, and body axis 3 (Ercan 2016, Fig. 13).

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Column k belongs to angle k.

    Raises
    ------
    ValueError
        If an angle is not finite or the frame is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.euler_axes([0.0, np.pi / 2, 0.0]).round(15) + 0.0
    array([[0., 1., 0.],
           [1., 0., 0.],
           [0., 0., 1.]])
    """
    angles = shaped("angles", angles, 3)
    sine, cosine = np.sin(angles[..., 1]), np.cos(angles[..., 1])
    axes = np.zeros((*angles.shape, 3))  # in the node frame
    axes[..., 1, 0], axes[..., 2, 0] = sine, cosine
    axes[..., 0, 1] = axes[..., 2, 2] = 1.0
    return _from_node(angles, frame) @ axes


def omega_from_euler_rates(angles: ArrayLike, rates: ArrayLike, *, frame: str = "body") -> Floats:
    """Angular velocity from Euler rates: ``e_phi phi' + e_theta theta' + e_psi psi'``.

    In the body ``(phi' sin theta sin psi + theta' cos psi, phi' sin theta cos psi - theta' sin psi,
    phi' cos theta + psi')`` (Goldstein, § 4.9; Ercan 2016, eq. (20); lecture notes, eq. (5.4)).
    In the node frame ``(theta', phi' sin theta, phi' cos theta + psi')`` (Ercan 2016, eq. (49)).
    Ercan's components of the parts are misprinted in § 5, ``cos theta`` in the first of ``phi'``
    (erratum D-09) and ``psi'`` along axis 1 (D-10); in § 9.2 ``phi'`` and ``psi'`` change places
    (D-24).

    Parameters
    ----------
    angles, rates : array_like, shape (..., 3)
        ``phi, theta, psi`` (rad) and their rates (rad/s); leading axes broadcast.
    frame : {"body", "space", "node"}
        The axes whose components are given, as in :func:`euler_axes`.

    Returns
    -------
    ndarray, shape (..., 3)
        Angular velocity (rad/s).

    Raises
    ------
    ValueError
        If a number is not finite or the frame is unknown.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.omega_from_euler_rates([0.0, 0.5, 0.0], [0.0, 2.0, 3.0])
    array([2., 0., 3.])
    """
    rates = shaped("rates", rates, 3)
    omega: Floats = np.matvec(euler_axes(angles, frame=frame), rates)
    return omega


def euler_rates_from_omega(
    angles: ArrayLike, omega: ArrayLike, *, frame: str = "body", least_norm: bool = False
) -> EulerRates:
    """Euler rates from the angular velocity: the inverse of :func:`omega_from_euler_rates`.

    If body axis 3 is vertical, ``e_phi`` and ``e_psi`` coincide, and there are either no such rates
    or infinitely many.

    Parameters
    ----------
    angles : array_like, shape (..., 3)
        ``phi, theta, psi`` (rad).
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s); leading axes broadcast.
    frame : {"body", "space", "node"}
        The axes of its components, as in :func:`euler_axes`.
    least_norm : bool
        Whether to return, if body axis 3 is vertical, the least-squares solution of least norm
        instead of raising ValueError.

    Returns
    -------
    EulerRates

    Raises
    ------
    ValueError
        If ``sin(theta)`` is zero to rounding and ``least_norm`` is false.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.euler_rates_from_omega([0.3, 1.1, -0.4], [0.2, 0.1, 5.0]).rates.round(6)
    array([0.015959, 0.223154, 4.992761])
    >>> upright = rotations.euler_rates_from_omega([0, 0, 0], [0.2, 0.1, 5.0], least_norm=True)
    >>> upright.rates, bool(upright.singular), float(upright.residual)
    (array([2.5, 0.2, 2.5]), True, 0.1)
    """
    angles, omega = shaped("angles", angles, 3), shaped("omega", omega, 3)
    along, across, axial = np.moveaxis(
        np.matvec(np.swapaxes(_from_node(angles, frame), -1, -2), omega), -1, 0
    )
    theta = np.broadcast_to(angles[..., 1], along.shape)
    sine, cosine = np.sin(theta), np.cos(theta)
    singular = np.abs(sine) <= _ON_THE_VERTICAL
    if np.any(singular) and not least_norm:
        index, place = first_place(singular)
        raise ValueError(
            f"angles{place}: theta = {theta[index]} is on the vertical, where phi and psi turn "
            "about one axis; pass least_norm=True for the rates of least norm"
        )
    regular = across / np.where(singular, 1.0, sine)
    phi = np.where(singular, 0.5 * np.sign(cosine) * axial, regular)
    psi = np.where(singular, 0.5 * axial, axial - regular * cosine)
    return EulerRates(
        rates=np.stack([phi, along, psi], axis=-1),
        singular=singular,
        residual=np.where(singular, np.abs(across), 0.0),
    )


def _elementary(axis: int, angle: ArrayLike, passive: bool) -> Floats:
    a = shaped("angle", angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*a.shape, 3, 3))
    sine = -np.sin(a) if passive else np.sin(a)
    matrix[..., axis, axis] = 1.0
    matrix[..., i, i] = matrix[..., j, j] = np.cos(a)
    matrix[..., i, j], matrix[..., j, i] = -sine, sine
    return matrix


def _from_node(angles: Floats, frame: str) -> Floats:
    """Matrices that take components in the node frame to components in ``frame``."""
    frame = one_of("frame", frame, FRAMES)
    phi, theta, psi = np.moveaxis(angles, -1, 0)
    if frame == "body":
        return _elementary(2, psi, True)
    if frame == "space":
        return _elementary(2, phi, False) @ _elementary(0, theta, False)
    return np.broadcast_to(np.eye(3), (*angles.shape, 3))


def _wrapped(angle: Floats) -> Floats:
    """Angles from -2 pi to 2 pi brought into (-pi, pi]; those inside keep their bits."""
    turns = np.where(angle > np.pi, 1.0, np.where(angle <= -np.pi, -1.0, 0.0))
    return angle - 2.0 * np.pi * turns
