"""Rotation vectors and matrices, rotations about any axis, and the nearest rotation of a matrix.

The functions need no series for small angles: every coefficient is a quotient such as
``sin(x) / x``, which is accurate for all ``x > 0``; at zero the functions use its limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import first_place, shaped
from .._checks.arrays import Floats, of_size_one
from .._checks.matrices import orthogonality
from .._checks.overflow import refuses_overflow


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Orthogonality:
    """Orthogonality error and determinant of matrices.

    Attributes
    ----------
    error : ndarray, shape (...)
        Frobenius norm of ``R.T R - 1``; rounding leaves about 1e-16.
    determinant : ndarray, shape (...)
        +1 for a rotation, -1 for a mirror image.
    """

    error: Floats
    determinant: Floats


def hat(vector: ArrayLike) -> Floats:
    """The antisymmetric matrix of a vector: ``hat(a) b = a × b``.

    Parameters
    ----------
    vector : array_like, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If the vector is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.hat([1.0, 2.0, 3.0]) @ [0.0, 0.0, 1.0]
    array([ 2., -1.,  0.])
    """
    a = shaped("vector", vector, 3)
    matrix = np.zeros((*a.shape, 3))
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = np.moveaxis(a, -1, 0)
    return matrix - np.swapaxes(matrix, -1, -2)


def vee(matrix: ArrayLike) -> Floats:
    """The vector of an antisymmetric matrix: the inverse of :func:`hat`.

    If the matrix is not antisymmetric, the result is the vector of its antisymmetric part; measured
    rates ``R.T dR/dt`` are antisymmetric to their measurement error only.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    ValueError
        If a matrix is not finite or has another shape.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.vee(rotations.hat([1.0, 2.0, 3.0]))
    array([1., 2., 3.])
    """
    w = shaped("matrix", matrix, 3, 3)
    pairs = [w[..., 2, 1] - w[..., 1, 2], w[..., 0, 2] - w[..., 2, 0], w[..., 1, 0] - w[..., 0, 1]]
    return 0.5 * np.stack(pairs, axis=-1)


@refuses_overflow
def exp_so3(vector: ArrayLike) -> Floats:
    """The active rotation of a rotation vector: ``exp(hat(v))``, a turn by ``|v|`` about ``v``.

    ``1 + sin(x)/x hat(v) + (1 - cos x)/x² hat(v)²`` with ``x = |v|`` (Rodrigues; Goldstein, § 4.7).
    To first order a vector turns by ``v × x``.

    Parameters
    ----------
    vector : array_like, shape (..., 3)
        Rotation vectors (rad), of any length.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If a vector is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.exp_so3([0.0, 0.0, np.pi / 2]).round(15) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    v = shaped("vector", vector, 3)
    angle = np.linalg.norm(v, axis=-1)
    once = over(np.sin(angle), angle, 1.0)
    twice = 2.0 * over(np.sin(0.5 * angle), angle, 0.5) ** 2
    return rodrigues(v, once, twice)


def axis_angle_matrix(axis: ArrayLike, angle: ArrayLike, *, passive: bool = False) -> Floats:
    """The rotation matrix of a turn by an angle about an axis.

    Active: the vector turns, ``x cos a + n (n·x)(1 - cos a) + n × x sin a`` (Rodrigues; Goldstein,
    § 4.7, with the sign of an active turn). Passive: the axes turn and the vector stays, which
    equals the active turn by ``-a``. (The lecture notes, § 5.3, give the passive Rodrigues formula;
    ``n × x`` in its second term is a misprint for ``n·x``, erratum G-06.)

    Parameters
    ----------
    axis : array_like, shape (..., 3)
        Axes ``n`` of any length but zero.
    angle : array_like, shape (...)
        Angles ``a`` (rad); broadcast with the leading axes of ``axis``.
    passive : bool
        Whether the axes turn instead of the vector.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If an axis is zero, or anything is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> third = rotations.axis_angle_matrix([1, 1, 1], 2 * np.pi / 3)
    >>> (third @ [1.0, 2.0, 3.0]).round(15)
    array([3., 1., 2.])
    """
    n, sine, versine = _axis_angle(axis, angle, passive)
    return rodrigues(n, sine, versine)


def rotate(x: ArrayLike, axis: ArrayLike, angle: ArrayLike, *, passive: bool = False) -> Floats:
    """Turn vectors by an angle about an axis, without forming the matrix.

    Parameters
    ----------
    x : array_like, shape (..., 3)
        Vectors; leading axes broadcast with the axes of ``axis`` and with ``angle``.
    axis, angle, passive
        As for :func:`axis_angle_matrix`; the result is the product of that matrix and ``x``.

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    ValueError
        If a number is not finite, an axis is zero, or the axes do not broadcast.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.rotate([1.0, 0.0, 0.0], [0, 0, 1], np.pi / 2).round(15) + 0.0
    array([0., 1., 0.])
    >>> rotations.rotate([1.0, 0.0, 0.0], [0, 0, 1], np.pi / 2, passive=True).round(15) + 0.0
    array([ 0., -1.,  0.])
    """
    vector = shaped("x", x, 3)
    n, sine, versine = _axis_angle(axis, angle, passive)
    across = np.cross(n, vector)
    return vector + sine[..., None] * across + versine[..., None] * np.cross(n, across)


@refuses_overflow
def orthogonality_error(matrix: ArrayLike) -> Orthogonality:
    """Orthogonality error and determinant of matrices.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    Orthogonality

    Raises
    ------
    ValueError
        If a matrix is not finite or has another shape.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> float(rotations.orthogonality_error(1.001 * np.eye(3)).error.round(7))
    0.0034658
    """
    error, determinant = orthogonality(shaped("matrix", matrix, 3, 3))
    return Orthogonality(error=error, determinant=determinant)


def nearest_rotation(matrix: ArrayLike) -> Floats:
    """The rotation nearest to a matrix in the Frobenius norm: its orthogonal factor.

    The orthogonal factor is ``U V.T`` with the singular vectors ``U`` and ``V`` (K. Fan and A. J.
    Hoffman, *Proceedings of the American Mathematical Society* 6 (1955) 111).

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If a determinant is not positive: rounding does not turn a rotation into a mirror image or a
        singular matrix, and the nearest rotation of such a matrix may not be unique.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.nearest_rotation(np.diag([1.1, 0.9, 1.0])).round(15) + 0.0
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    m = shaped("matrix", matrix, 3, 3)
    left, values, right = np.linalg.svd(m)
    upright = (np.linalg.det(left @ right) > 0.0) & (values[..., 2] > 1e-12 * values[..., 0])
    if not np.all(upright):
        index, place = first_place(~upright)
        raise ValueError(
            f"matrix{place}: its determinant is {np.linalg.det(m)[index]:.3g}; "
            "a mirror image or a singular matrix has no rotation near it"
        )
    rotation: Floats = left @ right
    # One step of Newton's method removes the rounding of the singular vectors.
    return rotation + 0.5 * rotation @ (np.eye(3) - np.swapaxes(rotation, -1, -2) @ rotation)


def _axis_angle(axis: ArrayLike, angle: ArrayLike, passive: bool) -> tuple[Floats, Floats, Floats]:
    """Unit axes, and the sine and ``1 - cos`` of the active turn, broadcast against each other."""
    n, _ = of_size_one(shaped("axis", axis, 3))
    length = np.linalg.norm(n, axis=-1, keepdims=True)
    if not length.all():
        _, place = first_place(length[..., 0] == 0.0)
        raise ValueError(f"axis{place} = {[0.0] * 3}: no direction")
    n = n / length
    a = shaped("angle", angle)
    a = -a if passive else a
    shape = np.broadcast_shapes(n.shape[:-1], a.shape)
    a = np.broadcast_to(a, shape)
    return np.broadcast_to(n, (*shape, 3)), np.sin(a), 2.0 * np.sin(0.5 * a) ** 2


def rodrigues(v: Floats, once: Floats, twice: Floats) -> Floats:
    """``1 + once hat(v) + twice hat(v)²``."""
    square = v[..., :, None] * v[..., None, :]
    square = square - np.trace(square, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    matrix: Floats = np.eye(3) + once[..., None, None] * hat(v) + twice[..., None, None] * square
    return matrix


def over(numerator: Floats, denominator: Floats, limit: float) -> Floats:
    """The quotient, or ``limit`` if the denominator is zero."""
    zero = denominator == 0.0
    return np.where(zero, limit, numerator / np.where(zero, 1.0, denominator))
