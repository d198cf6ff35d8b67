"""Quaternions, to and from vectors and matrices, and the logarithm of a rotation through them.

Angles come from ``atan2`` of the vector and the scalar part of a quaternion, so neither small turns
nor turns near pi lose digits. The angle from the trace of a matrix would lose half of them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import numbers, shaped
from .._checks.arrays import AttitudeLike, Floats, unit_quaternions
from .._checks.matrices import rotation_matrices
from .._checks.overflow import refuses_overflow
from .so3 import over, rodrigues, vee


def quaternion_product(left: ArrayLike, right: ArrayLike) -> Floats:
    """The Hamilton product: the rotation ``left`` after the rotation ``right``.

    Parameters
    ----------
    left, right : array_like, shape (..., 4)
        Quaternions, scalar first; the leading axes broadcast. Not normalised.

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    ValueError
        If a quaternion is not finite or has another shape, or the axes do not broadcast.

    Examples
    --------
    >>> from rigid import rotations
    >>> i, j = [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]
    >>> rotations.quaternion_product(i, j)
    array([0., 0., 0., 1.])
    """
    return product_of_checked(shaped("left", left, 4), shaped("right", right, 4))


def product_of_checked(left: Floats, right: Floats) -> Floats:
    """:func:`quaternion_product` of arrays, NaN where one is: the state of a body that failed."""
    a0, a1, a2, a3 = np.moveaxis(left, -1, 0)
    b0, b1, b2, b3 = np.moveaxis(right, -1, 0)
    return np.stack(
        [
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
            a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
            a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
        ],
        axis=-1,
    )


def quaternion_to_matrix(quaternion: ArrayLike) -> Floats:
    """The active rotation matrix of a quaternion; the function normalises the quaternion.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Quaternions of any length but zero, scalar first.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If a quaternion is zero or not finite.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.quaternion_to_matrix([1.0, 1.0, 0.0, 0.0]).round(15) + 0.0
    array([[ 1.,  0.,  0.],
           [ 0.,  0., -1.],
           [ 0.,  1.,  0.]])
    """
    q = canonical_quaternion(quaternion)
    # 1 + 2 w hat(v) + 2 hat(v)²
    return rodrigues(q[..., 1:], 2.0 * q[..., 0], np.full(q.shape[:-1], 2.0))


def matrix_to_quaternion(matrix: ArrayLike) -> Floats:
    """The unit quaternion of a rotation matrix, with the sign of :func:`canonical_quaternion`.

    All ten products of two components are linear in the matrix. The function divides the row of
    the largest square by the root of that square, so it never divides by a small number (S. W.
    Shepperd, *Journal of Guidance and Control* 1 (1978) 223).

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)
        Rotations.

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4; within, the nearest rotation is taken.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.matrix_to_quaternion([[-1, 0, 0], [0, 1, 0], [0, 0, -1]])
    array([0., 0., 1., 0.])
    """
    r = rotation_matrices("matrix", matrix)
    products = np.empty((*r.shape[:-2], 4, 4))  # 4 q_i q_j
    trace = np.trace(r, axis1=-2, axis2=-1)
    products[..., 0, 0] = 1.0 + trace
    products[..., 0, 1:] = products[..., 1:, 0] = 2.0 * vee(r)
    products[..., 1:, 1:] = r + np.swapaxes(r, -1, -2)
    for i in range(3):
        products[..., i + 1, i + 1] += 1.0 - trace
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    return canonical_quaternion(
        np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :]
    )


def canonical_quaternion(quaternion: ArrayLike) -> Floats:
    """Unit quaternions with a fixed sign: the first component that is not zero is positive.

    Thus ``w >= 0``. The quaternions ``q`` and ``-q`` are the same rotation.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Quaternions of any length but zero, scalar first.

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    ValueError
        If a quaternion is zero or not finite.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.canonical_quaternion([-3.0, 0.0, 4.0, 0.0])
    array([ 0.6,  0. , -0.8,  0. ])
    """
    q = unit_quaternions(
        "quaternion", shaped("quaternion", quaternion, 4), "a zero quaternion is no rotation"
    )
    first = np.argmax(q != 0.0, axis=-1)[..., None]
    leading = np.take_along_axis(q, first, axis=-1)
    return np.where(leading < 0.0, -q, q) + 0.0  # no negative zeros


@refuses_overflow
def exp_quaternion(vector: ArrayLike) -> Floats:
    """The unit quaternion of a rotation vector: ``(cos(x/2), sin(x/2) v/x)``, ``x = |v|``.

    The quaternion is continuous in ``v``, so its sign is not fixed: a full turn gives ``-1``.

    Parameters
    ----------
    vector : array_like, shape (..., 3)
        Rotation vectors (rad).

    Returns
    -------
    ndarray, shape (..., 4)
        Quaternions, scalar first.

    Raises
    ------
    ValueError
        If a rotation vector is not finite or has another shape, or its length
        overflows.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.exp_quaternion([0.0, np.pi, 0.0]).round(15)
    array([0., 0., 1., 0.])
    """
    v = shaped("vector", vector, 3)
    angle = np.linalg.norm(v, axis=-1)
    share = over(np.sin(0.5 * angle), angle, 0.5)
    return np.concatenate([np.cos(0.5 * angle)[..., None], share[..., None] * v], axis=-1)


def log_quaternion(quaternion: ArrayLike) -> Floats:
    """The rotation vector of a quaternion, of length at most pi: as :func:`log_so3`.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Quaternions of any length but zero and of either sign, scalar first.

    Returns
    -------
    ndarray, shape (..., 3)
        Rotation vectors (rad).

    Raises
    ------
    ValueError
        If a quaternion is zero or not finite.

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.log_quaternion([0.0, 0.0, 0.0, -2.0])
    array([0.        , 0.        , 3.14159265])
    """
    q = canonical_quaternion(quaternion)
    length = np.linalg.norm(q[..., 1:], axis=-1)
    # If the squares of a tiny vector part underflow, twice the vector part is exact to rounding.
    share = over(2.0 * np.arctan2(length, q[..., 0]), length, 2.0)
    return share[..., None] * q[..., 1:]


def log_so3(matrix: ArrayLike) -> Floats:
    """The rotation vector of a rotation: the inverse of :func:`exp_so3`, of length at most pi.

    A half turn has two such vectors; the one whose first non-zero component is positive is given.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)
        Rotations.

    Returns
    -------
    ndarray, shape (..., 3)
        Rotation vectors (rad).

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4; within, the nearest rotation is taken.

    Examples
    --------
    >>> from rigid import rotations
    >>> tiny = [3e-12, 0.0, -4e-12]
    >>> rotations.log_so3(rotations.exp_so3(tiny))
    array([ 3.e-12,  0.e+00, -4.e-12])
    """
    return log_quaternion(matrix_to_quaternion(matrix))


def quaternions(name: str, value: AttitudeLike) -> Floats:
    """Attitudes given as quaternions, matrices or a SciPy ``Rotation``, as unit quaternions.

    The result has shape (..., 4); quaternions keep their sign.
    """
    if hasattr(value, "as_quat"):
        value = value.as_quat(scalar_first=True)
    array = numbers(name, value)
    if array.shape[-2:] == (3, 3):
        return matrix_to_quaternion(rotation_matrices(name, array))
    if array.shape[-1:] != (4,):
        raise ValueError(f"{name}: expected shape (..., 4) or (..., 3, 3), got {array.shape}")
    return unit_quaternions(name, shaped(name, array, 4))


def conjugate(quaternion: Floats) -> Floats:
    """The inverse rotations of unit quaternions."""
    inverse: Floats = quaternion * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse
