"""Steady precession, the sleeping top, and the spin that friction takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact
from .._check import finite_float
from .._given import finite_array
from ..scenes import HeavyTop
from .constants import symmetric

__all__ = [
    "SleepingTop",
    "SpinDown",
    "SteadyPrecession",
    "sleeping_top",
    "spin_down",
    "steady_precession",
    "upright_f",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyPrecession:
    """The steady precessions at a tilt.

    Attributes
    ----------
    slow, fast : ndarray, shape (...)
        Rates about the upward vertical (rad/s), the slow one of smaller size. NaN where the spin is
        below ``spin_min``; only ``fast`` is NaN for a horizontal axis, which has one.
    slow_approx, fast_approx : ndarray, shape (...)
        What they tend to for fast spin, ``mgl / (I3 omega3)`` and ``I3 omega3 / (I1 cos)`` (rad/s);
        inf without spin and for a horizontal axis.
    spin_min : ndarray, shape (...)
        The least spin, ``2 sqrt(mgl I1 cos) / I3`` (rad/s), at which there is one, the two being
        equal; 0 for an axis that is horizontal or below, which needs none.
    """

    slow: Floats
    fast: Floats
    slow_approx: Floats
    fast_approx: Floats
    spin_min: Floats


def steady_precession(scene: HeavyTop, tilt: ArrayLike, spin: ArrayLike) -> SteadyPrecession:
    """Slow and fast steady precession of a symmetric top, and how fast it must spin.

    ``I1 W² cos - I3 spin W + mgl = 0``, by :func:`rigid.exact.steady_precession`: Goldstein,
    *Classical Mechanics*, § 5.7; Ercan 2016, eqs. (62)-(64), where the quadratic has the wrong sign
    of its last term (erratum D-33) and the slow rate the wrong label (D-34), and where the bound
    itself is left out (D-35).

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`.
    tilt : array_like, shape (...)
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    spin : array_like, shape (...)
        Rate about the body axis that the centre of mass lies on, a component of omega (rad/s).

    Returns
    -------
    SteadyPrecession

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or an argument is not finite or out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> found = rigid.top.steady_precession(scene, np.pi / 3, 5.0)
    >>> round(float(found.slow), 12), round(float(found.fast), 11), round(float(found.spin_min), 11)
    (0.438447187191, 4.56155281281, 2.82842712475)
    """
    slow, fast = exact.steady_precession(scene, tilt, spin)
    symmetry = symmetric(scene)
    angles, spins = np.broadcast_arrays(finite_array("tilt", tilt), finite_array("spin", spin))
    cosine = np.where(angles == 0.5 * np.pi, 0.0, np.cos(angles))
    momentum = symmetry.side * symmetry.along * spins
    with np.errstate(divide="ignore", invalid="ignore"):
        slow_approx = scene.mgl / momentum
        fast_approx = np.where(cosine == 0.0, np.inf, momentum / (symmetry.across * cosine))
    bound = np.sqrt(scene.mgl * symmetry.across * np.maximum(cosine, 0.0))
    return SteadyPrecession(
        slow=slow,
        fast=fast,
        slow_approx=slow_approx[()],
        fast_approx=fast_approx[()],
        spin_min=(2.0 * bound / symmetry.along)[()],
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SleepingTop:
    """Whether an upright top sleeps.

    Attributes
    ----------
    stable : ndarray of bool, shape (...)
        Whether it stays upright; at the bound it does.
    margin : ndarray, shape (...)
        ``|spin| / spin_min - 1``.
    spin_min : float
        The bound ``2 sqrt(mgl I1) / I3`` (rad/s).
    """

    stable: NDArray[np.bool_]
    margin: Floats
    spin_min: float


def sleeping_top(scene: HeavyTop, spin: ArrayLike) -> SleepingTop:
    """Whether a top with its centre of mass straight above the fixed point stays there.

    It does if ``(I3 omega3)² >= 4 I1 mgl``: Landau and Lifshitz, *Mechanics*, § 35. Equality
    belongs to it, which Ercan 2016 leaves out (erratum D-35) and the approximation of
    :func:`upright_f` cannot tell (G-19). A top that hangs is always stable.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`.
    spin : array_like, shape (...)
        Rate about the body axis that the centre of mass lies on (rad/s).

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
    size = np.abs(finite_array("spin", spin))
    return SleepingTop(stable=size >= bound, margin=size / bound - 1.0, spin_min=bound)


def upright_f(scene: HeavyTop, spin: ArrayLike, u: ArrayLike) -> tuple[Floats, Floats]:
    """The cubic f of an upright top, and its approximation near ``u = 1``.

    ``f = (1 - u)² (alpha (1 + u) - a²)``, negative beside ``u = 1`` if the top sleeps; near it
    ``(1 - u)² (2 alpha - a²)``, which vanishes at the bound, where f is ``-alpha (1 - u)³``
    (erratum G-19).

    Parameters
    ----------
    scene, spin
        As in :func:`sleeping_top`.
    u : array_like, shape (...)
        Heights ``cos(tilt)``.

    Returns
    -------
    exact, approximate : ndarray, shape (...)
        In 1/s².

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
    exact.sleeping_spin(scene)  # refuses what is no Lagrange top with weight
    symmetry = symmetric(scene)
    alpha = 2.0 * scene.mgl / symmetry.across
    square = (symmetry.along * finite_array("spin", spin) / symmetry.across) ** 2
    height = finite_array("u", u)
    depth2 = (1.0 - height) ** 2
    return depth2 * (alpha * (1.0 + height) - square), depth2 * (2.0 * alpha - square)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpinDown:
    """An upright top whose spin a torque ``-c omega3`` about its axis takes.

    Attributes
    ----------
    onset : ndarray, shape (...)
        When its spin has fallen to the bound of sleeping, ``(I3 omega3)² = 4 I1 mgl`` (s): 0 if it
        is below at once, inf without damping.
    spin_min : float
        That bound (rad/s).
    decay : float
        ``c / I3``, at which the spin decays (1/s).
    """

    onset: Floats
    spin_min: float
    decay: float


def spin_down(scene: HeavyTop, spin: ArrayLike, *, damping: float) -> SpinDown:
    """When friction wakes a sleeping top.

    While it is upright ``I3 omega3' = -c omega3``, ``omega3 = spin exp(-c t / I3)``; the power
    ``-c omega3²`` is that of the torque. What follows the onset is no steady motion and is not
    said here.

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`.
    spin : array_like, shape (...)
        Rate about the axis at ``t = 0`` (rad/s).
    damping : float
        ``c`` (N m s), >= 0.

    Returns
    -------
    SpinDown

    Raises
    ------
    ValueError
        If the top is no Lagrange top, the spin is not finite, or the damping negative.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> round(float(rigid.top.spin_down(scene, 8.0, damping=0.05).onset), 9)  # 10 ln 2
    6.931471806
    """
    bound = exact.sleeping_spin(scene)
    size = np.abs(finite_array("spin", spin))
    decay = finite_float("damping", damping, nonnegative=True) / symmetric(scene).along
    excess = np.log(np.maximum(size / bound, 1.0))
    still = np.where(size > bound, np.inf, 0.0)
    onset = excess / decay if decay > 0.0 else still
    return SpinDown(onset=np.asarray(onset)[()], spin_min=bound, decay=decay)
