"""Closed forms of the Lagrange top, and of a top that swings as a pendulum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import finite_float, require, shaped
from .._checks.arrays import Floats
from .._checks.overflow import refuses_overflow
from .._checks.shown import short_repr
from ..model.batch import batch_shape
from ..model.bodies import bodies_of
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..model.start import body_axis
from .common import in_shape
from .elliptic import agm
from .symmetry import Symmetry, require_each, symmetry_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


LEAST_LIMIT = 1e-150
"""Least angle (rad) whose cosine is told from one by a double, ``1 - cos``."""


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TopMotion:
    """Nutation, precession and periods of Lagrange tops in closed form.

    Arrays of a single top lack the leading axis ``n``.

    Scenes and starts of other leading axes give these axes in the place of ``n``.

    A tilt is the angle between the upward vertical and the direction from the fixed point to the
    centre of mass.

    Attributes
    ----------
    kind : str, or tuple of str of length n (of tuples, with several leading axes)
        By the path of the axis ``"loop"`` if ``phi'`` changes its sign, ``"cusp"`` if it is zero on
        the upper circle, ``"monotone"``, or ``"steady"`` on one circle; without spin ``"spherical
        pendulum"``, or ``"planar"`` if the top swings in a plane; on the vertical ``"sleeping"``,
        ``"upright"`` (unstable) or ``"hanging"``.
    retrograde : ndarray of bool, shape (n,)
        Whether the mean precession is against the spin.
    tilt_min, tilt_max : ndarray, shape (n,)
        Turning points of the nutation (rad).
    period : ndarray, shape (n,)
        Period of the nutation (s); inf on the homoclinic orbit and on the vertical.
    precession_advance, spin_advance : ndarray, shape (n,)
        Advance in a period of the nutation (rad) of the Euler angles phi, about the upward
        vertical, and psi, about the direction to the centre of mass; NaN on the vertical.
    precession : ndarray, shape (n,)
        Mean rate of precession (rad/s); NaN on the vertical.
    mc : ndarray, shape (n,)
        Complementary parameter ``1 - m`` of the elliptic functions.
    """

    kind: str | tuple[Any, ...]
    retrograde: NDArray[np.bool_]
    tilt_min: Floats
    tilt_max: Floats
    period: Floats
    precession_advance: Floats
    spin_advance: Floats
    precession: Floats
    mc: Floats


def lagrange_top(
    scene: HeavyTop, omega: ArrayLike, attitude: ArrayLike | Rotation | None = None
) -> TopMotion:
    """Nutation and precession of a symmetric top whose centre of mass lies on its axis.

    Whittaker, *Analytical Dynamics*, § 71; Goldstein, *Classical Mechanics*, § 5.7.

    Parameters
    ----------
    scene : HeavyTop
        Two moments exactly equal, the centre of mass exactly on the third axis, on either side.
    omega, attitude : array_like
        Initial states of the tops, as in :func:`rigid.simulate`.

    Returns
    -------
    TopMotion

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or has no weight.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(0.25), np.sin(0.25), 0.0, 0.0]
    >>> motion = rigid.exact.lagrange_top(top, [0.0, 0.0, 10.0], tilted)
    >>> motion.kind, round(float(motion.tilt_min), 12)
    ('cusp', 0.5)
    """
    _lagrange(scene, rod=True)
    bodies = bodies_of(scene, omega, attitude, rod=True)
    values = _core.top_quantities(bodies)
    kinds = np.array(values.pop("kind"), dtype=np.str_).reshape(bodies.shape)
    return TopMotion(kind=_tuples(kinds.tolist()), **in_shape(values, bodies.shape))


def tilt_time(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    limit: float,
) -> Floats:
    """Time at which the tilt of a Lagrange top first reaches an angle, from either side.

    Parameters
    ----------
    scene : HeavyTop
        As in :func:`lagrange_top`.
    omega, attitude : array_like
        Initial states of the tops, as in :func:`rigid.simulate`.
    limit : float
        Angle (rad) of the centre of mass from the upward vertical, in (0, pi].

    Returns
    -------
    ndarray, shape () or (n,)
        Times >= 0 (s); inf if the tilt never reaches the limit.

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or the limit is out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(0.25), np.sin(0.25), 0.0, 0.0]
    >>> bool(np.isinf(rigid.exact.tilt_time(top, [0.0, 0.0, 10.0], tilted, limit=1.0)))
    True
    """
    _lagrange(scene, rod=True)
    angle = finite_float("limit", limit, positive=True)
    if not LEAST_LIMIT <= angle <= pi:
        raise ValueError(f"limit = {angle}: must lie in (0, pi] (rad), and reach {LEAST_LIMIT:g}")
    bodies = bodies_of(scene, omega, attitude, rod=True)
    times = _core.tilt_times(bodies, angle)
    return times.reshape(bodies.shape)[()]


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyPrecession:
    """The slow and the fast rate of steady precession at a tilt: ``slow, fast = found``.

    Attributes
    ----------
    slow, fast : ndarray, shape (...)
        Rates about the upward vertical (rad/s); the slow one has the smaller size. NaN where the
        spin is below ``spin_min``. A horizontal axis has the slow precession only, and there
        ``fast`` is NaN.
    slow_approx, fast_approx : ndarray, shape (...)
        Limits of both rates for fast spin, ``mgl / (I3 omega3)`` and ``I3 omega3 / (I1 cos)``
        (rad/s); inf without spin and for a horizontal axis.
    spin_min : ndarray, shape (...)
        Least spin with a steady precession, ``2 sqrt(mgl I1 cos) / I3`` (rad/s), at which both
        rates are equal; 0 for an axis that is horizontal or points down.
    """

    slow: Floats
    fast: Floats
    slow_approx: Floats
    fast_approx: Floats
    spin_min: Floats

    def __len__(self) -> int:
        return 2

    def __getitem__(self, index: int) -> Floats:
        return (self.slow, self.fast)[index]

    def __iter__(self) -> Iterator[Floats]:
        return iter((self.slow, self.fast))


@refuses_overflow
def steady_precession(scene: HeavyTop, tilt: ArrayLike, spin: ArrayLike) -> SteadyPrecession:
    """Slow and fast steady precession of a Lagrange top, and the least spin that has them.

    The rates are the roots ``W`` of ``I1 W² cos(tilt) - I3 spin W + mgl = 0``, formed without
    cancellation: Goldstein, *Classical Mechanics*, § 5.7; Ercan 2016, eqs. (62)-(64), where the
    last term of the quadratic has the wrong sign (erratum D-33), the slow rate has the wrong label
    (D-34), and the bound of the spin excludes equality (D-35).

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`lagrange_top`.
    tilt : array_like, shape (...)
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    spin : array_like, shape (...)
        Rate about the body axis through the centre of mass, a component of ``omega`` (rad/s);
        broadcasts with the tilt, and both with the scene.

    Returns
    -------
    SteadyPrecession

    Raises
    ------
    TypeError
        If the scene is no heavy top.
    ValueError
        If the top is no Lagrange top or has no weight, or an argument is not finite or out of
        range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> slow, fast = rigid.exact.steady_precession(top, tilt=1.0, spin=8.0)
    >>> round(float(slow), 6), round(float(fast), 6)
    (0.259066, 7.144197)
    >>> found = rigid.top.steady_precession(top, np.pi / 3, 5.0)
    >>> round(float(found.slow), 12), round(float(found.fast), 11), round(float(found.spin_min), 11)
    (0.438447187191, 4.56155281281, 2.82842712475)
    """
    symmetry = _lagrange(scene)
    across, along, product = symmetry.across, symmetry.along, _product(scene, symmetry)
    angles, spins = np.broadcast_arrays(shaped("tilt", tilt), shaped("spin", spin))
    require("tilt", angles, (angles >= 0.0) & (angles <= pi), "must lie in [0, pi] (rad)")
    batch_shape({"scene": scene.shape, "tilt and spin": angles.shape})
    momentum = symmetry.side * along * spins
    # cos(pi / 2) of float64 is not 0, but the cosine of a horizontal axis is.
    cosine = np.where(angles == 0.5 * pi, 0.0, np.cos(angles))
    with np.errstate(divide="ignore", invalid="ignore"):
        below = 4.0 * product * cosine
        # At the bound the roots are equal, even if rounding moved the spin off the bound.
        at_bound = np.abs(momentum**2 - below) <= 4.0 * np.finfo(np.float64).eps * np.abs(below)
        root = np.sqrt(np.where(at_bound, 0.0, momentum**2 - below))
        double = momentum + np.copysign(root, momentum)
        slow = 2.0 * scene.mgl / double
        fast = double / (2.0 * across * cosine)
        slow_approx = scene.mgl / momentum
        fast_approx = np.where(cosine == 0.0, np.inf, momentum / (across * cosine))
    finite = np.isfinite(slow)
    bound = np.sqrt(product * np.maximum(cosine, 0.0))
    return SteadyPrecession(
        slow=np.where(finite, slow, np.nan)[()],
        fast=np.where(finite & (cosine != 0.0), fast, np.nan)[()],
        slow_approx=slow_approx[()],
        fast_approx=fast_approx[()],
        spin_min=(2.0 * bound / along)[()],
    )


@refuses_overflow
def sleeping_spin(scene: HeavyTop) -> float | Floats:
    """The least spin (rad/s) at which an upright Lagrange top sleeps, ``2 sqrt(mgl I1) / I3``.

    Goldstein, *Classical Mechanics*, § 5.7.

    Parameters
    ----------
    scene : HeavyTop
        As in :func:`lagrange_top`.

    Returns
    -------
    ndarray, shape (...)
        Spin (rad/s).

    Raises
    ------
    ValueError
        If the top is no Lagrange top.

    Examples
    --------
    >>> import rigid
    >>> rigid.exact.sleeping_spin(rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0))
    4.0
    """
    symmetry = _lagrange(scene)
    spin = 2.0 * np.sqrt(_product(scene, symmetry)) / symmetry.along
    return spin if scene.shape else float(spin)


def pendulum_period(scene: HeavyTop, amplitude: ArrayLike, *, axis: int) -> Floats:
    """Period of a top that swings as a pendulum about a horizontal principal axis.

    ``4 K(sin²(amplitude / 2)) / sqrt(mgl / I)``; Landau and Lifshitz, *Mechanics*, § 11.

    Parameters
    ----------
    scene : HeavyTop
        The body; the direction to its centre of mass is perpendicular to the axis.
    amplitude : array_like
        Largest angle of the centre of mass from the downward vertical (rad), in [0, pi]; broadcasts
        with the scene.
    axis : {1, 2, 3}
        The body axis of the swing.

    Returns
    -------
    ndarray
        Periods (s); inf for the amplitude pi, ``2 pi / sqrt(mgl / I)`` for the amplitude 0.

    Raises
    ------
    ValueError
        If the centre of mass is not exactly perpendicular to the axis, the weight is zero, or an
        amplitude is out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> body = rigid.HeavyTop(rigid.Body((1.0, 2.0, 2.5)), mgl=4.0, com=(0, 0, -1))
    >>> np.round(rigid.exact.pendulum_period(body, [0.0, np.pi / 2], axis=1), 6)
    array([3.141593, 3.708149])
    """
    require_unforced(check_heavy_top(scene, many=True), "a closed form")
    about = body_axis(axis)
    mgl, com = np.asarray(scene.mgl), np.asarray(scene.com)
    require_each(
        scene,
        (mgl != 0.0) & (com[..., about - 1] == 0.0),
        f"a pendulum about axis {about} needs a weight and its centre of mass exactly across that "
        "axis",
        ("mgl", "com"),
    )
    angles = shaped("amplitude", amplitude)
    require("amplitude", angles, (angles >= 0.0) & (angles <= pi), "must lie in [0, pi] (rad)")
    batch_shape({"scene": scene.shape, "amplitude": angles.shape})
    frequency = np.sqrt(mgl / np.asarray(scene.body.moments)[..., about - 1])
    # cos(pi / 2) of float64 is not 0, but on the separatrix the cosine is.
    cosine = np.where(angles == pi, 0.0, np.cos(0.5 * angles))
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * pi / (frequency * agm(1.0, cosine)))[()]


def _lagrange(scene: HeavyTop, *, rod: bool = False) -> Symmetry:
    """The symmetry of Lagrange tops with weight."""
    require_unforced(check_heavy_top(scene, many=True), "a closed form")
    rule = "a top without weight is a free body; use exact.free_body"
    require_each(scene, np.any(scene.weight, axis=-1), rule, ("mgl",))
    symmetry = symmetry_of(scene, scene.weight, rod=rod)
    rule = (
        "a Lagrange top has two exactly equal moments and its centre of mass exactly on the "
        "third axis"
    )
    require_each(scene, symmetry.axis != 0, rule, ("moments", "com"))
    return symmetry


@np.errstate(under="raise")
def _product(scene: HeavyTop, symmetry: Symmetry) -> Floats:
    """``mgl I1``, whose root is a momentum: no rate follows from one that underflows."""
    return symmetry.across * scene.mgl


def _tuples(values: Any) -> Any:
    """Lists of lists as tuples of tuples."""
    return tuple(_tuples(value) for value in values) if isinstance(values, list) else values
