"""Rotations as vectors, matrices and quaternions, each made from the other without loss.

No series and no switch at small angles: every coefficient is a quotient such as ``sin(x) / x``,
which is accurate for all ``x > 0`` and whose limit at zero is put in. Angles come from ``atan2`` of
the vector and the scalar part of a quaternion, so neither small turns nor those near pi lose digits
(the angle from the trace alone would lose half of them).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import first_place, numbers, shaped

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "Orthogonality",
    "axis_angle_matrix",
    "canonical_quaternion",
    "exp_quaternion",
    "exp_so3",
    "hat",
    "log_quaternion",
    "log_so3",
    "matrix_to_quaternion",
    "nearest_rotation",
    "orthogonality_error",
    "quaternion_product",
    "quaternion_to_matrix",
    "rotate",
    "vee",
]

Floats = NDArray[np.float64]

_ROTATION_SLACK = 1e-9
"""How far from orthogonal a matrix may be and still pass for a rotation."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Orthogonality:
    """How nearly matrices are rotations.

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
    antisymmetric: Floats = matrix - np.swapaxes(matrix, -1, -2)
    return antisymmetric


def vee(matrix: ArrayLike) -> Floats:
    """The vector of an antisymmetric matrix: the inverse of :func:`hat`.

    Of any other matrix, the vector of its antisymmetric part: measured rates ``R.T dR/dt`` are
    antisymmetric only to their own error.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3)

    Examples
    --------
    >>> from rigid import rotations
    >>> rotations.vee(rotations.hat([1.0, 2.0, 3.0]))
    array([1., 2., 3.])
    """
    w = shaped("matrix", matrix, 3, 3)
    pairs = [w[..., 2, 1] - w[..., 1, 2], w[..., 0, 2] - w[..., 2, 0], w[..., 1, 0] - w[..., 0, 1]]
    return 0.5 * np.stack(pairs, axis=-1)


def exp_so3(vector: ArrayLike) -> Floats:
    """The rotation by a vector: ``exp(hat(v))``, a turn by ``|v|`` (rad) about ``v``, active.

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
    once = _over(np.sin(angle), angle, 1.0)
    twice = 2.0 * _over(np.sin(0.5 * angle), angle, 0.5) ** 2
    return _rodrigues(v, once, twice)


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
        If a matrix is not a rotation to 1e-9.

    Examples
    --------
    >>> from rigid import rotations
    >>> tiny = [3e-12, 0.0, -4e-12]
    >>> rotations.log_so3(rotations.exp_so3(tiny))
    array([ 3.e-12,  0.e+00, -4.e-12])
    """
    return log_quaternion(matrix_to_quaternion(matrix))


def exp_quaternion(vector: ArrayLike) -> Floats:
    """The unit quaternion of a rotation vector: ``(cos(x/2), sin(x/2) v/x)``, ``x = |v|``.

    Not brought to a fixed sign: it is continuous in ``v``, and turns over after a full turn.

    Parameters
    ----------
    vector : array_like, shape (..., 3)
        Rotation vectors (rad).

    Returns
    -------
    ndarray, shape (..., 4)
        Quaternions, scalar first.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> rotations.exp_quaternion([0.0, np.pi, 0.0]).round(15)
    array([0., 0., 1., 0.])
    """
    v = shaped("vector", vector, 3)
    angle = np.linalg.norm(v, axis=-1)
    share = _over(np.sin(0.5 * angle), angle, 0.5)
    return np.concatenate([np.cos(0.5 * angle)[..., None], share[..., None] * v], axis=-1)


def log_quaternion(quaternion: ArrayLike) -> Floats:
    """The rotation vector of a quaternion, of length at most pi: as :func:`log_so3`.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Quaternions, scalar first; normalised first, and of either sign.

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
    # Where the squares of a tiny vector part vanish, so does the difference from twice that part.
    share = _over(2.0 * np.arctan2(length, q[..., 0]), length, 2.0)
    return share[..., None] * q[..., 1:]


def canonical_quaternion(quaternion: ArrayLike) -> Floats:
    """Unit quaternions with a fixed sign: the first component that is not zero is positive.

    So ``w >= 0``; ``q`` and ``-q`` are the same rotation.

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
    q = _unit("quaternion", shaped("quaternion", quaternion, 4), "a zero quaternion is no rotation")
    first = np.argmax(q != 0.0, axis=-1)[..., None]
    leading = np.take_along_axis(q, first, axis=-1)
    return np.where(leading < 0.0, -q, q) + 0.0  # no negative zeros


def quaternion_product(left: ArrayLike, right: ArrayLike) -> Floats:
    """The Hamilton product: the rotation ``left`` after the rotation ``right``.

    Parameters
    ----------
    left, right : array_like, shape (..., 4)
        Quaternions, scalar first; the leading axes broadcast. Not normalised.

    Returns
    -------
    ndarray, shape (..., 4)

    Examples
    --------
    >>> from rigid import rotations
    >>> i, j = [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]
    >>> rotations.quaternion_product(i, j)
    array([0., 0., 0., 1.])
    """
    a0, a1, a2, a3 = np.moveaxis(shaped("left", left, 4), -1, 0)
    b0, b1, b2, b3 = np.moveaxis(shaped("right", right, 4), -1, 0)
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
    """The active rotation matrix of a quaternion, which is normalised first.

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
    return _rodrigues(q[..., 1:], 2.0 * q[..., 0], np.full(q.shape[:-1], 2.0))


def matrix_to_quaternion(matrix: ArrayLike) -> Floats:
    """The unit quaternion of a rotation matrix, its sign that of :func:`canonical_quaternion`.

    All ten products of two components are linear in the matrix; the row of the largest square is
    divided by its root, so nothing small is divided by (S. W. Shepperd, *Journal of Guidance and
    Control* 1 (1978) 223).

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
        If a matrix is not a rotation to 1e-9.

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


def axis_angle_matrix(axis: ArrayLike, angle: ArrayLike, *, passive: bool = False) -> Floats:
    """The rotation by an angle about an axis.

    Active: the vector turns, ``x cos a + n (n·x)(1 - cos a) + n × x sin a`` (Rodrigues; Goldstein,
    eq. (4.62) with the sign of an active turn). Passive: the axes turn and the vector stays, which
    is the active turn by ``-a``. (The lecture's Rodrigues formula, ch. 5.3, is the passive one;
    its ``n × x`` in the second term is a misprint for ``n·x``, erratum G-06.)

    Parameters
    ----------
    axis : array_like, shape (..., 3)
        Axes ``n``, normalised first.
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
    return _rodrigues(n, sine, versine)


def rotate(x: ArrayLike, axis: ArrayLike, angle: ArrayLike, *, passive: bool = False) -> Floats:
    """Vectors turned by an angle about an axis, without forming the matrix.

    Parameters
    ----------
    x : array_like, shape (..., 3)
        Vectors; leading axes broadcast with those of ``axis`` and with ``angle``.
    axis, angle, passive
        As for :func:`axis_angle_matrix`, whose product with ``x`` this is.

    Returns
    -------
    ndarray, shape (..., 3)

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
    turned: Floats = vector + sine[..., None] * across + versine[..., None] * np.cross(n, across)
    return turned


def orthogonality_error(matrix: ArrayLike) -> Orthogonality:
    """How far matrices are from rotations.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    Orthogonality

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> float(rotations.orthogonality_error(1.001 * np.eye(3)).error.round(7))
    0.0034658
    """
    r = shaped("matrix", matrix, 3, 3)
    gram = np.swapaxes(r, -1, -2) @ r - np.eye(3)
    return Orthogonality(
        error=np.linalg.norm(gram, axis=(-2, -1)), determinant=np.asarray(np.linalg.det(r))
    )


def nearest_rotation(matrix: ArrayLike) -> Floats:
    """The rotation with the least Frobenius distance: the orthogonal factor of the matrix.

    By singular values, ``U V.T`` (K. Fan and A. J. Hoffman, *Proceedings of the American
    Mathematical Society* 6 (1955) 111).

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ValueError
        If a determinant is not positive: a mirror image or a singular matrix comes from no rounding
        of a rotation, and the nearest rotation need not be the only one.

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
    return rotation


def rotation_matrices(name: str, value: ArrayLike) -> Floats:
    """``value`` as finite matrices ``(..., 3, 3)`` that are rotations to 1e-9."""
    r = shaped(name, value, 3, 3)
    how = orthogonality_error(r)
    bad = (how.error > _ROTATION_SLACK) | (how.determinant < 0.0)
    if np.any(bad):
        index, place = first_place(bad)
        error, det = how.error[index], how.determinant[index]
        raise ValueError(
            f"{name}{place}: not a rotation: |R.T R - 1| = {error:.3g}, det R = {det:.3g} "
            "(nearest_rotation mends small errors)"
        )
    return r


def quaternions(name: str, value: ArrayLike | Rotation) -> Floats:
    """Attitudes given as quaternions, matrices or a SciPy ``Rotation``, as ``(..., 4)``.

    Quaternions keep their sign; all are of length one.
    """
    if hasattr(value, "as_quat"):
        value = value.as_quat(scalar_first=True)
    array = numbers(name, value)
    if array.shape[-2:] == (3, 3):
        rotation_matrices(name, array)
        return matrix_to_quaternion(array)
    if array.shape[-1:] != (4,):
        raise ValueError(f"{name}: expected shape (..., 4) or (..., 3, 3), got {array.shape}")
    return _unit(name, shaped(name, array, 4), "a zero quaternion is no attitude")


def conjugate(quaternion: Floats) -> Floats:
    """The inverse rotations of unit quaternions."""
    inverse: Floats = quaternion * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def _axis_angle(axis: ArrayLike, angle: ArrayLike, passive: bool) -> tuple[Floats, Floats, Floats]:
    """Unit axes, and the sine and ``1 - cos`` of the active turn, broadcast to each other."""
    n = _unit("axis", shaped("axis", axis, 3), "no direction")
    a = shaped("angle", angle)
    a = -a if passive else a
    shape = np.broadcast_shapes(n.shape[:-1], a.shape)
    a = np.broadcast_to(a, shape)
    return np.broadcast_to(n, (*shape, 3)), np.sin(a), 2.0 * np.sin(0.5 * a) ** 2


def _rodrigues(v: Floats, once: Floats, twice: Floats) -> Floats:
    """``1 + once hat(v) + twice hat(v)²``."""
    square = v[..., :, None] * v[..., None, :]
    square = square - np.trace(square, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    matrix: Floats = np.eye(3) + once[..., None, None] * hat(v) + twice[..., None, None] * square
    return matrix


def _unit(name: str, array: Floats, rule: str) -> Floats:
    """Vectors divided by their lengths, which may be as small or large as doubles are."""
    largest = np.abs(array).max(axis=-1, keepdims=True)
    if np.any(largest == 0.0):
        _, place = first_place(largest[..., 0] == 0.0)
        raise ValueError(f"{name}{place} = {[0.0] * array.shape[-1]}: {rule}")
    # Scaled by a power of two, which is exact, so that no square leaves the range of doubles.
    scaled = np.ldexp(array, -np.frexp(largest)[1])
    unit: Floats = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    return unit


def _over(numerator: Floats, denominator: Floats, limit: float) -> Floats:
    """The quotient, or its limit where the denominator is zero."""
    zero = denominator == 0.0
    quotient: Floats = np.where(zero, limit, numerator / np.where(zero, 1.0, denominator))
    return quotient
