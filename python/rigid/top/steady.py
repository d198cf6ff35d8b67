"""The sleeping top, and the decay of its spin by friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact
from .._checks.arguments import require, shaped
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from ..model.scene import HeavyTop
from .constants import over_tops, symmetric, tilts


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SleepingTop:
    """Whether an upright top sleeps.

    Attributes
    ----------
    stable : ndarray of bool, shape (...)
        Whether the top stays upright; true at the bound.
    margin : ndarray, shape (...)
        ``|spin| / spin_min - 1``.
    spin_min : float, or ndarray with the axes of the tops
        The bound ``2 sqrt(mgl I1) / I3`` (rad/s).
    """

    stable: NDArray[np.bool_]
    margin: Floats
    spin_min: float | Floats


@refuses_overflow
def sleeping_top(scene: HeavyTop, spin: ArrayLike) -> SleepingTop:
    """Whether a top with its centre of mass vertically above the fixed point stays upright.

    The top stays upright if ``(I3 omega3)² >= 4 I1 mgl``: Landau and Lifshitz, *Mechanics*, § 35.
    Ercan 2016 excludes equality (erratum D-35); the approximation of :func:`upright_f` does not
    decide it (G-19). A hanging top is always stable.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`, or many.
    spin : array_like, shape (...)
        Rate about the body axis through the centre of mass (rad/s); broadcasts with the tops.

    Returns
    -------
    SleepingTop

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or the spin is not finite.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> rigid.top.sleeping_top(scene, [3.9, 4.0, -4.1]).stable.tolist()
    [False, True, True]
    """
    bound = exact.sleeping_spin(scene)
    (size,) = over_tops(scene, spin=np.abs(shaped("spin", spin)))
    return SleepingTop(stable=size >= bound, margin=size / bound - 1.0, spin_min=bound)


@refuses_overflow
def spin_from_precession(scene: HeavyTop, tilt: ArrayLike, precession: ArrayLike) -> Floats:
    """The spin with which a Lagrange top precesses steadily at a measured rate.

    ``I3 spin = I1 W cos(tilt) + mgl / W``, the condition of :func:`rigid.exact.steady_precession`
    (Goldstein, *Classical Mechanics*, § 5.7).

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`, or many.
    tilt : array_like, shape (...)
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    precession : array_like, shape (...)
        Rate ``W`` about the upward vertical (rad/s), not zero. All broadcast.

    Returns
    -------
    ndarray, shape (...)
        Rate about the body axis through the centre of mass, a component of ``omega`` (rad/s).

    Raises
    ------
    ValueError
        If the top is no Lagrange top or has no weight, the precession is zero, or an argument is
        not finite or out of range.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> slow = rigid.exact.steady_precession(scene, tilt=1.0, spin=8.0).slow
    >>> round(float(rigid.top.spin_from_precession(scene, 1.0, slow)), 12)
    8.0
    """
    exact.sleeping_spin(scene)  # raises if the scene is no Lagrange top with weight
    symmetry = symmetric(scene)
    rate = shaped("precession", precession)
    require("precession", rate, rate != 0.0, "must not be zero")
    angle, rate = over_tops(scene, tilt=tilts(tilt), precession=rate)
    momentum = symmetry.across * rate * np.cos(angle) + scene.mgl / rate
    spin: Floats = symmetry.side * momentum / symmetry.along
    return spin[()]


@refuses_overflow
def upright_f(scene: HeavyTop, spin: ArrayLike, u: ArrayLike) -> tuple[Floats, Floats]:
    """The cubic f of an upright top, and its approximation near ``u = 1``.

    ``f = (1 - u)² (alpha (1 + u) - a²)`` is negative near ``u = 1`` if the top sleeps. The
    approximation ``(1 - u)² (2 alpha - a²)`` is zero at the bound of sleeping, where
    ``f = -alpha (1 - u)³`` (erratum G-19).

    Parameters
    ----------
    scene, spin
        As in :func:`sleeping_top`.
    u : array_like, shape (...)
        Heights ``cos(tilt)``; they broadcast with the spins and the tops.

    Returns
    -------
    exact, approximate : ndarray, shape (...)
        Values of the cubic and of its approximation (1/s²).

    Raises
    ------
    ValueError
        As in :func:`sleeping_top`.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> [float(value) for value in rigid.top.upright_f(scene, 4.0, 0.5)]
    [-0.25, 0.0]
    """
    exact.sleeping_spin(scene)  # raises if the scene is no Lagrange top with weight
    symmetry = symmetric(scene)
    alpha = 2.0 * scene.mgl / symmetry.across
    rate, height = over_tops(scene, spin=spin, u=u)
    square = (symmetry.along * rate / symmetry.across) ** 2
    depth2 = (1.0 - height) ** 2
    return depth2 * (alpha * (1.0 + height) - square), depth2 * (2.0 * alpha - square)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpinDown:
    """An upright top with the damping torque ``-c omega3`` about its axis.

    Attributes
    ----------
    onset : ndarray, shape (...)
        Time (s) at which the spin falls to the bound of sleeping, ``(I3 omega3)² = 4 I1 mgl``: 0 if
        the spin is below the bound from the start, inf without damping.
    spin_min : float, or ndarray with the axes of the tops
        The bound of sleeping (rad/s).
    decay : float, or ndarray with the axes of the tops and of the damping
        Decay rate of the spin, ``c / I3`` (1/s).
    """

    onset: Floats
    spin_min: float | Floats
    decay: float | Floats


@refuses_overflow
def spin_down(scene: HeavyTop, spin: ArrayLike, *, damping: ArrayLike) -> SpinDown:
    """Time (s) at which friction wakes a sleeping top.

    While the top is upright ``I3 omega3' = -c omega3``, thus ``omega3 = spin exp(-c t / I3)``; the
    power of the torque is ``-c omega3²``. The motion after the onset is not steady; compute it by
    :func:`rigid.simulate`.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`, or many.
    spin : array_like, shape (...)
        Spin about the axis at ``t = 0`` (rad/s); broadcasts with the tops.
    damping : array_like, shape (...)
        ``c`` (N m s), >= 0; broadcasts with the spins and the tops.

    Returns
    -------
    SpinDown

    Raises
    ------
    ValueError
        If the top is no Lagrange top, the spin is not finite, or the damping is negative.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> round(float(rigid.top.spin_down(scene, 8.0, damping=0.05).onset), 9)  # 10 ln 2
    6.931471806
    """
    bound = exact.sleeping_spin(scene)
    friction = shaped("damping", damping, nonnegative=True)
    size, _ = over_tops(scene, spin=np.abs(shaped("spin", spin)), damping=friction)
    decay = np.asarray(friction / symmetric(scene).along)
    excess = np.log(np.maximum(size / bound, 1.0))
    still = np.where(size > bound, np.inf, 0.0)
    onset = np.where(decay > 0.0, excess / np.where(decay > 0.0, decay, 1.0), still)
    return SpinDown(onset=onset[()], spin_min=bound, decay=decay if decay.shape else float(decay))
