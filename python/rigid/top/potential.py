"""The effective potential of the nutation of a symmetric top."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import first_place
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from ..model.scene import HeavyTop
from .constants import over_tops, symmetric, tilts
from .cubic import f_roots


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EffectivePotential:
    """The effective potential and its slope.

    Attributes
    ----------
    value : ndarray, shape (...)
        ``V'`` (J).
    slope : ndarray, shape (...)
        ``dV'/dtheta`` (J/rad).
    """

    value: Floats
    slope: Floats


@refuses_overflow
def effective_potential(
    scene: HeavyTop, tilt: ArrayLike, *, a: ArrayLike, b: ArrayLike
) -> EffectivePotential:
    """``V'(theta) = I1 (a - b cos)² / (2 sin²) + mgl cos``, the potential (J) of the nutation.

    Goldstein, *Classical Mechanics*, § 5.7; Ercan 2016, eq. (61).

    Parameters
    ----------
    scene : HeavyTop
        Two moments exactly equal, the centre of mass exactly on the third axis; one top or many.
    tilt : array_like, shape (...)
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    a, b : array_like, shape (...)
        Constants of :func:`rigid.top.heavy_constants` (rad/s). They broadcast with the tilt and the
        tops.

    Returns
    -------
    EffectivePotential
        On the vertical the value is inf, with the slope -inf at 0 and inf at pi. If ``a = b``, the
        value at 0 is finite with slope 0; if ``a = -b``, the value at pi (the range of Ercan
        excludes both, erratum D-40).

    Raises
    ------
    ValueError
        If the top is not symmetric, or an argument is not finite or out of range.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> rigid.top.effective_potential(scene, 0.0, a=2.5, b=2.5).value.tolist()
    1.0
    """
    i1 = symmetric(scene).across
    angle, first, second = over_tops(scene, tilt=tilts(tilt), a=a, b=b)
    upper = angle < 0.5 * np.pi
    lack = np.where(upper, first - second, first + second)
    sine, cosine = np.sin(angle), np.cos(angle)
    vertical = (angle == 0.0) | (angle == np.pi)
    sine = np.where(vertical, 0.0, sine)
    # The rate phi' sin = (a - b cos) / sin as the sum of its pole and a regular part.
    half = np.where(upper, 0.5 * angle, 0.5 * (np.pi - angle))
    sign = np.where(upper, 1.0, -1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        pole = np.where(lack == 0.0, 0.0, lack / sine)
        bend = np.where(lack == 0.0, 0.0, -lack * cosine / sine**2)
    rate = pole + sign * second * np.tan(half)
    rate_slope = bend + 0.5 * second / np.cos(half) ** 2
    with np.errstate(invalid="ignore"):
        slope = i1 * rate * rate_slope - scene.mgl * sine
    wall = vertical & (lack != 0.0)
    return EffectivePotential(
        value=(0.5 * i1 * rate**2 + scene.mgl * cosine)[()],
        slope=np.where(wall, -np.inf * sign, slope)[()],
    )


def effective_minimum(scene: HeavyTop, *, a: ArrayLike, b: ArrayLike) -> Floats:
    """The tilt of the only minimum of the effective potential: the tilt of steady precession.

    The function needs SciPy.

    Parameters
    ----------
    scene, a, b
        As in :func:`effective_potential`; the top has weight, or a and b are not both zero.

    Returns
    -------
    ndarray, shape (...)
        Tilt (rad); 0 for a sleeping top (``a = b``, ``b² >= 4 mgl / I1``), pi for ``a = -b``.

    Raises
    ------
    ImportError
        Without SciPy.
    ValueError
        As in :func:`effective_potential`, and if the potential is constant.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilt = rigid.top.effective_minimum(scene, a=1.25, b=2.5)
    >>> bool(abs(rigid.top.effective_potential(scene, tilt, a=1.25, b=2.5).slope) < 1e-14)
    True
    """
    from scipy.optimize.elementwise import find_root

    across = symmetric(scene).across
    first, second = over_tops(scene, a=a, b=b)
    swing = np.broadcast_to(np.sqrt(scene.mgl) / np.sqrt(across), first.shape)
    constant = (swing == 0.0) & (first == 0.0) & (second == 0.0)
    if constant.any():
        _, place = first_place(constant)
        raise ValueError(
            f"mgl = 0, a{place} = 0, b{place} = 0: the effective potential is constant"
        )

    def slope(tilt: Floats, a: Floats, b: Floats, swing: Floats) -> Floats:
        """Zero with ``dV'/dtheta sin³ = I1 (a - b cos)(b - a cos) - mgl sin⁴``, and of its sign.

        Without squares of a and b, which leave the range of doubles.
        """
        upper = tilt < 0.5 * np.pi
        depth = 2.0 * np.where(upper, np.sin(0.5 * tilt), np.cos(0.5 * tilt)) ** 2
        # From the nearer end of the vertical, so that no digits cancel.
        one = np.where(upper, a - b + b * depth, a + b - b * depth)
        other = np.where(upper, b - a + a * depth, a + b - a * depth)
        root = np.sqrt(np.abs(one)) * np.sqrt(np.abs(other))
        sine = np.where(tilt == np.pi, 0.0, np.sin(tilt))
        value: Floats = np.sign(one) * np.sign(other) * root - swing * sine**2
        return value

    upright, hanging = first == second, first == -second
    ordinary = ~(upright | hanging)
    # If the potential is finite at an end, its slope is zero there: use the closed forms.
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(swing > 0.0, np.abs(second) / (2.0 * swing), np.inf)
    fallen = 2.0 * np.arccos(np.sqrt(np.minimum(np.where(np.isnan(share), 1.0, share), 1.0)))
    tilt = np.where(hanging, np.pi, fallen)
    if ordinary.any():
        arguments = first[ordinary], second[ordinary], swing[ordinary]
        tilt[ordinary] = find_root(slope, (0.0, np.pi), args=arguments).x
    return tilt[()]


@refuses_overflow
def turning_angles(
    scene: HeavyTop, *, a: ArrayLike, b: ArrayLike, E_prime: ArrayLike
) -> tuple[Floats, Floats]:
    """The tilts (rad) with ``V' = E'``, between which a top with the energy E' nutates.

    Parameters
    ----------
    scene, a, b
        As in :func:`effective_potential`.
    E_prime : array_like, shape (...)
        Energy of the nutation (J), see :func:`rigid.top.heavy_constants`.

    Returns
    -------
    upper, lower : ndarray, shape (...)
        Tilts (rad) of the upper circle and of the lower circle.

    Raises
    ------
    ValueError
        If the energy lies below the minimum, and as in :func:`effective_potential`.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> upper, lower = rigid.top.turning_angles(scene, a=1.25, b=2.5, E_prime=0.5)
    >>> round(float(upper), 9), round(float(lower), 9)
    (1.047197551, 1.377833075)
    """
    i1 = symmetric(scene).across
    a, b, energy = over_tops(scene, a=a, b=b, E_prime=E_prime)
    roots = f_roots(a=a, b=b, alpha=2.0 * energy / i1, beta=2.0 * scene.mgl / i1)
    return roots.theta_upper, roots.theta_lower
