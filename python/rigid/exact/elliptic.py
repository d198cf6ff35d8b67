"""Elliptic integrals and functions that the closed forms use.

Carlson's symmetric integrals by his duplication algorithms (B. C. Carlson, *Numerical Algorithms*
10 (1995) 13), Jacobi's functions from the complementary parameter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import require, shaped
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow

LARGEST = 1e200
"""Largest argument of R_D and R_J, whose duplication multiplies three square roots."""

TINY = np.finfo(np.float64).tiny
"""Smallest double with all its digits."""


@refuses_overflow
def carlson_rf(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    """Carlson's integral R_F of the first kind, for arguments that are not negative.

    It is half the integral of ``1 / sqrt((t + x)(t + y)(t + z))`` over t > 0.

    DLMF 19.16.1. The arguments broadcast; they are not negative, and at most one is zero.

    Parameters
    ----------
    x, y, z : array_like
        Arguments, not negative; at most one is zero.

    Returns
    -------
    ndarray
        The integral, in the shape of the broadcast arguments.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rf(1.0, 2.0, 0.0)), 12)
    1.311028777146
    """
    return _carlson("rf", {"x": x, "y": y, "z": z}, positive=())


@refuses_overflow
def carlson_rc(x: ArrayLike, y: ArrayLike) -> Floats:
    """Carlson's degenerate integral, ``R_F(x, y, y)``; for ``y < 0`` Cauchy's principal value.

    DLMF 19.16.17, 19.2.20. ``x`` is not negative, ``y`` not zero, and ``x`` is positive where ``y``
    is negative; the arguments broadcast.

    Parameters
    ----------
    x, y : array_like
        Arguments: ``x`` not negative, ``y`` not zero.

    Returns
    -------
    ndarray
        The integral, in the shape of the broadcast arguments.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rc(0.0, 0.25)), 12)
    3.14159265359
    """
    first, second = np.broadcast_arrays(shaped("x", x), shaped("y", y))
    require("x", first, first >= 0.0, "must not be negative")
    require("y", second, second != 0.0, "must not be zero")
    require("x", first, (first > 0.0) | (second > 0.0), "must be positive where y is negative")
    return _called("rc", first, second)[0]


@refuses_overflow
def carlson_rd(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    """Carlson's integral of the second kind, ``R_J(x, y, z, z)``, for ``z > 0``.

    DLMF 19.16.5. Arguments and errors are as for :func:`carlson_rf`; no argument is above 1e200.

    Parameters
    ----------
    x, y, z : array_like
        Arguments, not negative, at most 1e200; ``z`` is positive, and at most one is zero.

    Returns
    -------
    ndarray
        The integral, in the shape of the broadcast arguments.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rd(0.0, 2.0, 1.0)), 12)
    1.797210352103
    """
    return _carlson("rd", {"x": x, "y": y, "z": z}, positive=("z",))


@refuses_overflow
def carlson_rj(x: ArrayLike, y: ArrayLike, z: ArrayLike, p: ArrayLike) -> Floats:
    """Carlson's integral of the third kind, for ``p > 0``.

    DLMF 19.16.2. Arguments and errors are as for :func:`carlson_rf`; no argument is above 1e200.

    Parameters
    ----------
    x, y, z, p : array_like
        Arguments, not negative, at most 1e200; ``p`` is positive, and at most one is zero.

    Returns
    -------
    ndarray
        The integral, in the shape of the broadcast arguments.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rj(0.0, 1.0, 2.0, 3.0)), 12)
    0.776886237786
    """
    return _carlson("rj", {"x": x, "y": y, "z": z, "p": p}, positive=("p",))


@refuses_overflow
def agm(a: ArrayLike, b: ArrayLike) -> Floats:
    """Arithmetic-geometric mean of numbers that are not negative; the arguments broadcast.

    DLMF 19.8. ``K = pi / (2 agm(1, sqrt(1 - m)))``.

    Parameters
    ----------
    a, b : array_like
        Numbers, not negative; a quotient above 1e460 is refused.

    Returns
    -------
    ndarray
        The mean, in the shape of the broadcast arguments.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.agm(1.0, 2.0**0.5)), 12)
    1.198140234736
    """
    first, second = np.broadcast_arrays(shaped("a", a), shaped("b", b))
    require("a", first, first >= 0.0, "must not be negative")
    require("b", second, second >= 0.0, "must not be negative")
    # By a power of two, which changes no digit, to numbers whose product is a double.
    power = np.frexp(np.maximum(first, second))[1] - 511
    one, other = np.ldexp(first, -power), np.ldexp(second, -power)
    if ((one < TINY) & (first > 0.0) | (other < TINY) & (second > 0.0)).any():
        raise OverflowError
    return np.asarray(np.ldexp(_called("agm", one, other)[0], power))[()]


def jacobi(u: ArrayLike, mc: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Jacobi's elliptic functions sn, cn, dn from the complementary parameter ``mc = 1 - m``.

    ``mc`` keeps the digits that ``m`` loses near 1: with ``mc = 0`` they are tanh, sech and sech.
    DLMF 22.2.

    Parameters
    ----------
    u : array_like
        Argument; its size must be below 2**50, since the phase of larger arguments has no digits.
    mc : array_like
        Complementary parameter in [0, 1]; broadcasts with ``u``.

    Returns
    -------
    sn, cn, dn : ndarray

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule.

    Examples
    --------
    >>> import rigid
    >>> [round(float(value), 12) for value in rigid.exact.jacobi(0.5, mc=0.3)]
    [0.467292005359, 0.884103037959, 0.920405740535]
    """
    arguments, parameters = np.broadcast_arrays(shaped("u", u), shaped("mc", mc))
    require("u", arguments, np.abs(arguments) < 2.0**50, "must lie below 2**50 in size")
    require("mc", parameters, (parameters >= 0.0) & (parameters <= 1.0), "must lie in [0, 1]")
    sn, cn, dn = _called("jacobi", arguments, parameters)
    return sn, cn, dn


def _carlson(name: str, arguments: dict[str, ArrayLike], *, positive: tuple[str, ...]) -> Floats:
    arrays = np.broadcast_arrays(*(shaped(key, value) for key, value in arguments.items()))
    for key, array in zip(arguments, arrays, strict=True):
        if key in positive:
            require(key, array, array > 0.0, "must be positive")
        else:
            require(key, array, array >= 0.0, "must not be negative")
        if positive:
            require(key, array, array <= LARGEST, f"must be at most {LARGEST:g}")
    zeros = sum((array == 0.0).astype(np.int64) for array in arrays)
    names = ", ".join(arguments)
    require(f"number of zeros among {names}", zeros, zeros <= 1, "must be at most 1")
    (value,) = _called(name, *arrays)
    if not np.isfinite(value).all():
        raise OverflowError
    return value


def _called(name: str, *arrays: Floats) -> tuple[Floats, ...]:
    """Evaluate a function of the core at each element of arrays of equal shape."""
    flat = [np.ascontiguousarray(array).ravel() for array in arrays]
    values = _core.elliptic(name, flat)
    return tuple(value.reshape(arrays[0].shape)[()] for value in values)
