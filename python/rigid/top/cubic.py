"""The cubic of the symmetric top, ``u'² = f(u)`` of the height ``u = cos(tilt)``.

``f(u) = (alpha - beta u)(1 - u²) - (a - b u)²`` with the constants of
:func:`rigid.top.heavy_constants`: Landau and Lifshitz, *Mechanics*, § 35; Goldstein, *Classical
Mechanics*, § 5.7.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import require, shaped
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from ..exact import agm, carlson_rf, jacobi

SLACK = 1e-12
"""Largest error of roots that the rounding of the constants may cause."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Roots:
    """The roots of the cubic f; the top nutates between the first two.

    Attributes
    ----------
    u1, u2, u3 : ndarray, shape (...)
        Roots, ``-1 <= u1 <= u2 <= 1 <= u3``; u3 is inf without weight.
    theta_upper, theta_lower : ndarray, shape (...)
        Tilts of the upper circle, ``arccos u2``, and of the lower circle, ``arccos u1`` (rad).
    """

    u1: Floats
    u2: Floats
    u3: Floats
    theta_upper: Floats
    theta_lower: Floats


@refuses_overflow
def f_u(u: ArrayLike, *, a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike) -> Floats:
    """The cubic ``f(u) = (alpha - beta u)(1 - u²) - (a - b u)²`` of the height, equal to ``u'²``.

    ``f(1) = -(a - b)²`` and ``f(-1) = -(a + b)²``.

    Parameters
    ----------
    u : array_like, shape (...)
        Heights; any real numbers.
    a, b, alpha, beta : array_like, shape (...)
        Constants of :func:`rigid.top.heavy_constants`.

    Returns
    -------
    ndarray, shape (...)
        Values of f (1/s²).

    Raises
    ------
    ValueError
        If a value is not finite.

    Examples
    --------
    >>> from rigid import top
    >>> float(top.f_u(0.5, a=1.25, b=2.5, alpha=1.0, beta=2.0))  # released at 60 degrees
    0.0
    """
    u, a = shaped("u", u), shaped("a", a)
    b, alpha = shaped("b", b), shaped("alpha", alpha)
    return (alpha - shaped("beta", beta) * u) * (1.0 - u * u) - (a - b * u) ** 2


@refuses_overflow
def f_roots(*, a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike) -> Roots:
    """The three roots of the cubic f, by Newton's method and a deflation without cancellation.

    The constants determine a double root (steady precession) to the square root of their rounding
    only. For all digits use :func:`rigid.exact.lagrange_top`, which takes a state.

    Parameters
    ----------
    a, b, alpha, beta : array_like, shape (...)
        Constants of :func:`rigid.top.heavy_constants`; ``beta >= 0``.

    Returns
    -------
    Roots

    Raises
    ------
    ValueError
        If no motion has these constants (``f < 0`` between -1 and 1), or a value is not finite.

    Examples
    --------
    >>> from rigid import top
    >>> found = top.f_roots(a=1.25, b=2.5, alpha=1.0, beta=2.0)
    >>> [round(float(root), 9) for root in (found.u1, found.u2, found.u3)]
    [0.191767988, 0.5, 2.933232012]
    """
    low, middle, high = _depths(a, b, alpha, beta)
    return Roots(
        u1=(1.0 - high)[()],
        u2=(1.0 - middle)[()],
        u3=(1.0 - low)[()],
        theta_upper=2.0 * np.arcsin(np.sqrt(0.5 * middle)),
        theta_lower=2.0 * np.arcsin(np.sqrt(0.5 * high)),
    )


@refuses_overflow
def nutation_period(*, a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike) -> Floats:
    """Period of the nutation, ``4 K(m) / sqrt(beta (u3 - u1))`` with ``m = (u2-u1)/(u3-u1)``.

    Parameters
    ----------
    a, b, alpha, beta
        As in :func:`f_roots`.

    Returns
    -------
    ndarray, shape (...)
        Periods (s); at a double root the period of small oscillations; inf on the homoclinic orbit
        and for an upright top at the bound of sleeping.

    Raises
    ------
    ValueError
        As in :func:`f_roots`.

    Examples
    --------
    >>> from rigid import top
    >>> round(float(top.nutation_period(a=1.25, b=2.5, alpha=1.0, beta=2.0)), 11)
    2.76392864943
    """
    rate, complement = _argument(b, alpha, beta, *_depths(a, b, alpha, beta))
    with np.errstate(divide="ignore"):
        return np.asarray(pi / (agm(1.0, np.sqrt(complement)) * rate))[()]


@refuses_overflow
def time_of(
    u: ArrayLike, *, a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike
) -> Floats:
    """Time from the lower circle up to a height, the integral of ``du / sqrt(f)`` from u1 to u.

    The quadrature of Landau and Lifshitz, § 35, while the top rises. The time down is the same.

    Parameters
    ----------
    u : array_like, shape (...)
        Heights ``cos(tilt)`` between u1 and u2, or at most 1e-12 outside.
    a, b, alpha, beta
        As in :func:`f_roots`.

    Returns
    -------
    ndarray, shape (...)
        Times (s) in [0, half the period]; inf for the highest point of the homoclinic orbit.

    Raises
    ------
    ValueError
        If the top does not reach a height, and as in :func:`f_roots`.

    Examples
    --------
    >>> from rigid import top
    >>> constants = {"a": 1.25, "b": 2.5, "alpha": 1.0, "beta": 2.0}
    >>> round(float(top.time_of(0.5, **constants)), 9)  # half a period
    1.381964325
    """
    depths = _depths(a, b, alpha, beta)
    rate, complement = _argument(b, alpha, beta, *depths)
    heights, _, middle, high, rate, complement = np.broadcast_arrays(
        shaped("u", u), *depths, rate, complement
    )
    depth = 1.0 - heights
    reached = (depth >= middle - 1e-12) & (depth <= high + 1e-12)
    require("u", heights, reached, "must lie between the roots u1 and u2")
    span = high - middle
    moving = span > 0.0
    sine2 = np.clip(np.where(moving, high - depth, 0.0) / np.where(moving, span, 1.0), 0.0, 1.0)
    cosine2 = np.clip(np.where(moving, depth - middle, 1.0) / np.where(moving, span, 1.0), 0.0, 1.0)
    never = (cosine2 == 0.0) & (complement == 0.0)
    delta2 = np.where(never, 1.0, cosine2 + complement * sine2)
    integral = np.sqrt(sine2) * carlson_rf(np.where(never, 1.0, cosine2), delta2, 1.0)
    still = np.where(rate > 0.0, rate, 1.0)
    return np.where(never & moving, np.inf, integral / still)[()]


@refuses_overflow
def u_of(t: ArrayLike, *, a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike) -> Floats:
    """Height ``cos(tilt)`` at a time after the lower circle: the inverse of :func:`time_of`.

    Parameters
    ----------
    t : array_like, shape (...)
        Times (s), of either sign.
    a, b, alpha, beta
        As in :func:`f_roots`.

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    ValueError
        As in :func:`f_roots`.

    Examples
    --------
    >>> from rigid import top
    >>> constants = {"a": 1.25, "b": 2.5, "alpha": 1.0, "beta": 2.0}
    >>> round(float(top.u_of(top.nutation_period(**constants), **constants)), 9)
    0.191767988
    """
    low, middle, high = _depths(a, b, alpha, beta)
    rate, complement = _argument(b, alpha, beta, low, middle, high)
    sn, cn, _ = jacobi(rate * shaped("t", t), complement)
    return np.asarray(1.0 - (middle * sn**2 + high * cn**2))[()]


def _argument(
    b: ArrayLike, alpha: ArrayLike, beta: ArrayLike, low: Floats, middle: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """Rate of the argument and complementary parameter of Jacobi's functions."""
    weightless = np.isneginf(low)
    span = high - np.where(weightless, 0.0, low)
    # Without weight u3 goes to infinity as (alpha + b²) / beta.
    at_infinity = shaped("alpha", alpha) + shaped("b", b) ** 2
    square = np.where(weightless, at_infinity, shaped("beta", beta) * span)
    apart = np.where(span > 0.0, span, 1.0)
    complement = np.where(span > 0.0, (middle - np.where(weightless, 0.0, low)) / apart, 0.0)
    return 0.5 * np.sqrt(square), np.where(weightless, 1.0, complement)


def _depths(
    a: ArrayLike, b: ArrayLike, alpha: ArrayLike, beta: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Roots of f in the depth ``w = 1 - u``, ascending: the first is not positive, or zero.

    ``f = w (2 - w)(eps + beta w) - (d + b w)²`` with ``d = a - b``, ``eps = alpha - beta``. Divided
    by beta, ``-w³ + c2 w² + c1 w - c0``.
    """
    a, b, alpha, beta = np.broadcast_arrays(
        shaped("a", a),
        shaped("b", b),
        shaped("alpha", alpha),
        shaped("beta", beta),
    )
    require("beta", beta, beta >= 0.0, "must not be negative")
    light = beta == 0.0
    require("alpha", alpha, ~light | (alpha + b * b > 0.0), "must be positive without weight")
    d, eps = a - b, alpha - beta
    unit = np.where(light, 1.0, beta)
    c2, c1, c0 = 2.0 - (eps + b * b) / unit, 2.0 * (eps - d * b) / unit, d * d / unit
    below = _largest_root(c2, c1, c0)
    # Sum and product of the other two roots; the sum in the form that does not cancel.
    nearby = np.where(below > 0.0, below, 1.0)
    total = np.where(below > 1.0, (c0 / nearby + c1) / nearby, c2 + below)
    product = c0 / nearby
    square = np.where(light, alpha + b * b, 1.0)
    total = np.where(light, 2.0 * (eps - d * b) / square, total)
    product = np.where(light, d * d / square, product)
    half = 0.5 * total
    # Squares of half the distance of two roots come from f between them: half² less the product
    # loses the digits of fast tops and of small swings about the lowest point.
    free = half * (2.0 - half) * (eps + beta * half) - (d + b * half) ** 2
    steep = np.where(light, square, unit * (half + below))
    free = free / np.where(steep > 0.0, steep, 1.0)
    # A top that passes the vertical, d = 0, has the root 0 besides the roots of w² - c2 w - c1.
    through, mid = (d == 0.0) & ~light, 0.5 * c2
    beyond = ((2.0 - mid) * (eps + beta * mid) - b * b * mid) / unit
    larger = mid + np.copysign(np.sqrt(np.maximum(beyond, 0.0)), mid)
    smaller = -c1 / np.where(larger != 0.0, larger, 1.0)
    least, middle, highest = np.sort(np.stack([larger, np.zeros(d.shape), smaller]), axis=0)
    # Rounding of the constants may make a double root (steady precession) complex.
    real = np.where(through, beyond >= -SLACK * c2 * c2, free >= -SLACK * np.abs(half))
    inside = np.where(through, middle, half) >= -SLACK
    inside &= through | (half <= 2.0 + SLACK)
    require("alpha", alpha, real & inside, "no motion has this energy and these momenta")
    wide = half + np.sqrt(np.maximum(free, 0.0))
    narrow = product / np.where(wide > 0.0, wide, 1.0)
    low = np.where(through, least, np.where(light, -np.inf, -below))
    return (
        low,
        np.clip(np.where(through, middle, np.minimum(narrow, wide)), 0.0, 2.0) + 0.0,  # no -0
        np.clip(np.where(through, highest, wide), 0.0, 2.0) + 0.0,
    )


def _largest_root(c2: Floats, c1: Floats, c0: Floats) -> Floats:
    """The largest root of ``x³ + c2 x² - c1 x - c0``, which is not negative for ``c0 >= 0``.

    Newton's method descends from Fujiwara's bound to the root and passes the root by rounding only.
    For a root near zero the rounding may be as large as the root, so the last steps may go up.
    """
    x: Floats = 2.0 * np.maximum(np.maximum(np.abs(c2), np.sqrt(np.abs(c1))), np.cbrt(c0))
    for _ in range(100):
        lower = _newton(x, c2, c1, c0)
        if not (lower < x).any():
            break
        x = np.minimum(lower, x)
    return _newton(_newton(x, c2, c1, c0), c2, c1, c0)


def _newton(x: Floats, c2: Floats, c1: Floats, c0: Floats) -> Floats:
    slope = (3.0 * x + 2.0 * c2) * x - c1
    step = (((x + c2) * x - c1) * x - c0) / np.where(slope > 0.0, slope, np.inf)
    return np.maximum(x - step, 0.0)
