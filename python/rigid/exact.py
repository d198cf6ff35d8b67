"""Closed forms of the free body and the Lagrange top, and the elliptic functions they are made of.

Periods, flip times, precession and nutation without a step of integration. The formulas are those
of Whittaker, *Analytical Dynamics*, §§ 69, 71; Landau and Lifshitz, *Mechanics*, §§ 35, 37;
Goldstein, *Classical Mechanics*, §§ 5.6, 5.7; in the symmetric integrals of B. C. Carlson,
*Numerical Algorithms* 10 (1995) 13, and arranged so that nothing cancels near a separatrix, a pole,
a symmetric or a spherical body.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, positive_int, rows
from ._given import finite_array, require
from .bodies import Body
from .columns import check_scene, columns, each_row
from .criteria import NoFlip
from .plan import closed_forms, lagrange_axes
from .scenes import FreeBody, HeavyTop, Scene, scene_words
from .starts import body_axis

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "FreeMotion",
    "TopMotion",
    "agm",
    "carlson_rc",
    "carlson_rd",
    "carlson_rf",
    "carlson_rj",
    "flip_times",
    "free_body",
    "jacobi",
    "lagrange_top",
    "pendulum_period",
    "sleeping_spin",
    "steady_precession",
    "tilt_time",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeMotion:
    """The motion of free bodies. With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    axis : ndarray of int8, shape (n,)
        The body axis 1, 2 or 3 that the polhode encircles, with the sign of the rate along it; 0
        where there is none: at rest, on the separatrix and for a spherical body.
    m, mc : ndarray, shape (n,)
        Parameter of the elliptic functions and ``1 - m``, which keeps its digits near the
        separatrix.
    period : ndarray, shape (n,)
        Period of the rates in the body (s); inf on the separatrix and for constant rates.
    flip_time : ndarray, shape (n,)
        Time between reversals of the rates that reverse (s), half the period; inf if none does.
    amplitude : ndarray, shape (n, 3)
        Largest ``|omega_k|`` (rad/s).
    precession : ndarray, shape (n,)
        Mean rate of turning about the angular momentum (rad/s).
    turn : ndarray, shape (n,)
        Angle of that turning in a period (rad); inf without a period.
    """

    axis: NDArray[np.int8]
    m: Floats
    mc: Floats
    period: Floats
    flip_time: Floats
    amplitude: Floats
    precession: Floats
    turn: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TopMotion:
    """The motion of Lagrange tops. With a single top the leading axis ``n`` is absent.

    Tilts are angles of the direction from the fixed point to the centre of mass from the upward
    vertical.

    Attributes
    ----------
    kind : str, or tuple of str of length n
        ``"cusp"``, ``"loop"`` or ``"monotone"`` by the path of the axis; ``"steady"``;
        ``"spherical pendulum"`` without spin, ``"planar"`` if it swings in a plane; ``"sleeping"``,
        ``"upright"`` (it would fall) or ``"hanging"`` if it stands on the vertical.
    retrograde : ndarray of bool, shape (n,)
        Whether the mean precession is against the spin.
    tilt_min, tilt_max : ndarray, shape (n,)
        Turning points of the nutation (rad).
    period : ndarray, shape (n,)
        Period of the nutation (s); inf on the homoclinic orbit and on the vertical.
    precession_advance, spin_advance : ndarray, shape (n,)
        Advance of the Euler angles phi and psi in a period of the nutation, about the upward
        vertical and about the direction to the centre of mass (rad); NaN on the vertical.
    precession : ndarray, shape (n,)
        Mean rate of precession (rad/s); NaN on the vertical.
    mc : ndarray, shape (n,)
        Complementary parameter ``1 - m`` of the elliptic functions.
    """

    kind: str | tuple[str, ...]
    retrograde: NDArray[np.bool_]
    tilt_min: Floats
    tilt_max: Floats
    period: Floats
    precession_advance: Floats
    spin_advance: Floats
    precession: Floats
    mc: Floats


def free_body(body: Body | FreeBody, omega: ArrayLike) -> FreeMotion:
    """Period, flip time, amplitudes and precession of a free body.

    Landau and Lifshitz, *Mechanics*, § 37.

    Parameters
    ----------
    body : Body or FreeBody
        The body.
    omega : array_like, shape (3,) or (n, 3)
        Angular velocity in the body at any time of the motion (rad/s).

    Returns
    -------
    FreeMotion

    Raises
    ------
    TypeError
        If ``body`` is neither a body nor a free one.
    ValueError
        If ``omega`` is not finite or has the wrong shape.

    Examples
    --------
    >>> import rigid
    >>> motion = rigid.exact.free_body(rigid.Body((1.0, 2.0, 3.0)), [1e-6, 1.0, 0.0])
    >>> int(motion.axis), round(float(motion.flip_time), 6)
    (1, 52.660597)
    """
    if isinstance(body, FreeBody):
        _undriven(body)
        body = body.body
    if not isinstance(body, Body):
        raise TypeError(f"body = {body!r}: must be a rigid.Body or a rigid.FreeBody")
    rates, single = rows("omega", omega, 3)
    moments = np.ascontiguousarray(np.broadcast_to(np.array(body.moments), rates.shape))
    values = _core.free_quantities(moments=moments, omega=rates)
    return FreeMotion(**_of_one(values) if single else values)


def flip_times(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    axis: int | None = None,
    count: int = 1,
) -> Floats:
    """When the rate about a body axis changes its sign, for the first ``count`` times.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body; a top must be one that :func:`lagrange_top` accepts, and the axis that of its
        symmetry, about which the rate is constant.
    omega, attitude : array_like
        Where the bodies start, as in :func:`rigid.simulate`.
    axis : {1, 2, 3}, optional
        The body axis; by default that of the largest rate of each body.
    count : int
        How many.

    Returns
    -------
    ndarray, shape (count,) or (n, count)
        Times > 0 (s), ascending; inf where there is no further change.

    Raises
    ------
    ValueError
        If there is no closed form, or no single largest rate.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> times = rigid.exact.flip_times(scene, [1e-3, 1.0, 0.0], count=3)
    >>> np.round(np.diff(times), 6)
    array([28.731424, 28.731424])
    """
    _undriven(check_scene(scene))
    number = positive_int("count", count)
    table, single = columns(scene, omega, attitude)
    axes = _largest(table["omega"]) if axis is None else body_axis(axis)
    table = each_row(table)
    times = np.empty((len(table["omega"]), number))
    for chosen in np.unique(axes).tolist():
        if "" in closed_forms(NoFlip(chosen), table["moments"][:1], table["weight"]):
            raise ValueError(
                f"axis = {chosen}: no closed form for the {scene_words(scene)}; there is one for a "
                "free body, and for the symmetry axis of a Lagrange top"
            )
        mine = np.broadcast_to(axes == chosen, len(times))
        some = {name: _pick(values, mine) for name, values in table.items()}
        times[mine] = _core.flip_times(**some, axis=int(chosen), count=number)
    return times[0] if single else times


def lagrange_top(
    scene: HeavyTop, omega: ArrayLike, attitude: ArrayLike | Rotation | None = None
) -> TopMotion:
    """Nutation and precession of a symmetric top with its centre of mass on its axis.

    Whittaker, *Analytical Dynamics*, § 71; Goldstein, *Classical Mechanics*, § 5.7.

    Parameters
    ----------
    scene : HeavyTop
        Two moments equal to the bit, the centre of mass exactly on the third axis, on either side.
    omega, attitude : array_like
        Where the tops start, as in :func:`rigid.simulate`.

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
    lagrange_axis(scene)
    table, single = columns(scene, omega, attitude)
    values = _core.top_quantities(**_without_scene(table))
    kinds = values.pop("kind")
    if single:
        return TopMotion(kind=kinds[0], **_of_one(values))
    return TopMotion(kind=tuple(kinds), **values)


def tilt_time(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    limit: float,
) -> Floats:
    """When the tilt of a Lagrange top first reaches an angle, from below or from above.

    Parameters
    ----------
    scene : HeavyTop
        As in :func:`lagrange_top`.
    omega, attitude : array_like
        Where the tops start, as in :func:`rigid.simulate`.
    limit : float
        Angle (rad) of the centre of mass from the upward vertical, in (0, pi].

    Returns
    -------
    ndarray, shape () or (n,)
        Times >= 0 (s); inf if it is never reached.

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
    lagrange_axis(scene)
    angle = finite_float("limit", limit, positive=True)
    if angle > pi:
        raise ValueError(f"limit = {angle}: must lie in (0, pi] (rad)")
    table, single = columns(scene, omega, attitude)
    times = _core.tilt_times(**_without_scene(table), limit=angle)
    return times[0] if single else times


def steady_precession(scene: HeavyTop, tilt: ArrayLike, spin: ArrayLike) -> tuple[Floats, Floats]:
    """Rates of the two steady precessions of a Lagrange top, without nutation.

    The roots ``W`` of ``I1 W² cos(tilt) - I3 spin W + mgl = 0`` (Goldstein, *Classical Mechanics*,
    § 5.7), formed without cancellation.

    Parameters
    ----------
    scene : HeavyTop
        As in :func:`lagrange_top`.
    tilt : array_like
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    spin : array_like
        Rate about the body axis that the centre of mass lies on, a component of ``omega`` (rad/s);
        broadcasts with the tilt.

    Returns
    -------
    slow, fast : ndarray
        Rates about the upward vertical (rad/s), the slow one of smaller size. NaN where there is no
        steady precession; only ``fast`` is NaN for a horizontal axis, which has one.

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or an argument is not finite or out of range.

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> slow, fast = rigid.exact.steady_precession(top, tilt=1.0, spin=8.0)
    >>> round(float(slow), 6), round(float(fast), 6)
    (0.259066, 7.144197)
    """
    axis, side = lagrange_axis(scene)
    angles, spins = np.broadcast_arrays(finite_array("tilt", tilt), finite_array("spin", spin))
    require("tilt", angles, (angles >= 0.0) & (angles <= pi), "must lie in [0, pi] (rad)")
    across, along = scene.body.moments[axis - 2], scene.body.moments[axis - 1]
    momentum = side * along * spins
    # cos(pi / 2) of float64 is not 0, a horizontal axis is.
    cosine = np.where(angles == 0.5 * pi, 0.0, np.cos(angles))
    with np.errstate(divide="ignore", invalid="ignore"):
        below = 4.0 * across * scene.mgl * cosine
        # At the bound the roots are equal, also if it was rounded.
        at_bound = np.abs(momentum**2 - below) <= 4.0 * np.finfo(np.float64).eps * np.abs(below)
        root = np.sqrt(np.where(at_bound, 0.0, momentum**2 - below))
        double = momentum + np.copysign(root, momentum)
        slow = 2.0 * scene.mgl / double
        fast = double / (2.0 * across * cosine)
    finite = np.isfinite(slow)
    return (
        np.where(finite, slow, np.nan)[()],
        np.where(finite & (cosine != 0.0), fast, np.nan)[()],
    )


def sleeping_spin(scene: HeavyTop) -> float:
    """The least spin (rad/s) at which an upright Lagrange top sleeps: ``2 sqrt(mgl I1) / I3``.

    Goldstein, *Classical Mechanics*, § 5.7.

    Parameters
    ----------
    scene : HeavyTop
        As in :func:`lagrange_top`.

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
    axis, _ = lagrange_axis(scene)
    across, along = scene.body.moments[axis - 2], scene.body.moments[axis - 1]
    return float(2.0 * np.sqrt(scene.mgl * across) / along)


def pendulum_period(scene: HeavyTop, amplitude: ArrayLike, *, axis: int) -> Floats:
    """Period of a top that swings as a pendulum about a horizontal principal axis.

    ``4 K(sin²(amplitude / 2)) / sqrt(mgl / I)``; Landau and Lifshitz, *Mechanics*, § 11.

    Parameters
    ----------
    scene : HeavyTop
        The body; its centre of mass lies across the axis.
    amplitude : array_like
        Largest angle of the centre of mass from the downward vertical (rad), in [0, pi].
    axis : {1, 2, 3}
        The body axis of the swing.

    Returns
    -------
    ndarray
        Periods (s); inf for an amplitude of pi, 2 pi / sqrt(mgl / I) for none.

    Raises
    ------
    ValueError
        If the centre of mass is not exactly across the axis, there is no weight, or an amplitude is
        out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> body = rigid.HeavyTop(rigid.Body((1.0, 2.0, 2.5)), mgl=4.0, com=(0, 0, -1))
    >>> np.round(rigid.exact.pendulum_period(body, [0.0, np.pi / 2], axis=1), 6)
    array([3.141593, 3.708149])
    """
    if not isinstance(scene, HeavyTop):
        raise TypeError(f"scene = {scene!r}: must be a rigid.HeavyTop")
    _undriven(scene)
    about = body_axis(axis)
    if scene.mgl == 0.0 or scene.com[about - 1] != 0.0:
        raise ValueError(
            f"mgl = {scene.mgl:g}, com = {scene.com}: a pendulum about axis {about} needs a weight "
            "and its centre of mass exactly across that axis"
        )
    angles = finite_array("amplitude", amplitude)
    require("amplitude", angles, (angles >= 0.0) & (angles <= pi), "must lie in [0, pi] (rad)")
    frequency = np.sqrt(scene.mgl / scene.body.moments[about - 1])
    # cos(pi / 2) of float64 is not 0, the separatrix is.
    cosine = np.where(angles == pi, 0.0, np.cos(0.5 * angles))
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * pi / (frequency * agm(1.0, cosine)))[()]


def carlson_rf(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    """Carlson's integral of the first kind: half that of ``1 / sqrt((t+x)(t+y)(t+z))`` over t > 0.

    DLMF 19.16.1. The arguments broadcast; they are not negative, and at most one is zero.

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


def carlson_rc(x: ArrayLike, y: ArrayLike) -> Floats:
    """Carlson's degenerate integral, ``R_F(x, y, y)``; for ``y < 0`` Cauchy's principal value.

    DLMF 19.16.17, 19.2.20. ``x`` is not negative, ``y`` not zero, and ``x`` is positive where ``y``
    is negative; the arguments broadcast.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rc(0.0, 0.25)), 12)
    3.14159265359
    """
    first, second = np.broadcast_arrays(finite_array("x", x), finite_array("y", y))
    require("x", first, first >= 0.0, "must not be negative")
    require("y", second, second != 0.0, "must not be zero")
    require("x", first, (first > 0.0) | (second > 0.0), "must be positive where y is negative")
    return _called("rc", first, second)[0]


def carlson_rd(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    """Carlson's integral of the second kind, ``R_J(x, y, z, z)``, for ``z > 0``.

    DLMF 19.16.5. Arguments and errors are those of :func:`carlson_rf`.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rd(0.0, 2.0, 1.0)), 12)
    1.797210352103
    """
    return _carlson("rd", {"x": x, "y": y, "z": z}, positive=("z",))


def carlson_rj(x: ArrayLike, y: ArrayLike, z: ArrayLike, p: ArrayLike) -> Floats:
    """Carlson's integral of the third kind, for ``p > 0``.

    DLMF 19.16.2. Arguments and errors are those of :func:`carlson_rf`.

    Examples
    --------
    >>> import rigid
    >>> round(float(rigid.exact.carlson_rj(0.0, 1.0, 2.0, 3.0)), 12)
    0.776886237786
    """
    return _carlson("rj", {"x": x, "y": y, "z": z, "p": p}, positive=("p",))


def agm(a: ArrayLike, b: ArrayLike) -> Floats:
    """Arithmetic-geometric mean of numbers that are not negative; the arguments broadcast.

    DLMF 19.8. ``K = pi / (2 agm(1, sqrt(1 - m)))``.

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
    first, second = np.broadcast_arrays(finite_array("a", a), finite_array("b", b))
    require("a", first, first >= 0.0, "must not be negative")
    require("b", second, second >= 0.0, "must not be negative")
    return _called("agm", first, second)[0]


def jacobi(u: ArrayLike, mc: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Jacobi's elliptic functions sn, cn, dn from the complementary parameter ``mc = 1 - m``.

    ``mc`` keeps the digits that ``m`` loses near 1: with ``mc = 0`` they are tanh, sech and sech.
    DLMF 22.2.

    Parameters
    ----------
    u : array_like
        Argument, below 2**50 in size: no digit of the phase is left beyond.
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
    arguments, parameters = np.broadcast_arrays(finite_array("u", u), finite_array("mc", mc))
    require("u", arguments, np.abs(arguments) < 2.0**50, "must lie below 2**50 in size")
    require("mc", parameters, (parameters >= 0.0) & (parameters <= 1.0), "must lie in [0, 1]")
    sn, cn, dn = _called("jacobi", arguments, parameters)
    return sn, cn, dn


def _carlson(name: str, arguments: dict[str, ArrayLike], *, positive: tuple[str, ...]) -> Floats:
    arrays = np.broadcast_arrays(*(finite_array(key, value) for key, value in arguments.items()))
    for key, array in zip(arguments, arrays, strict=True):
        if key in positive:
            require(key, array, array > 0.0, "must be positive")
        else:
            require(key, array, array >= 0.0, "must not be negative")
    zeros = sum((array == 0.0).astype(np.int64) for array in arrays)
    names = ", ".join(arguments)
    require(f"number of zeros among {names}", zeros, zeros <= 1, "must be at most 1")
    return _called(name, *arrays)[0]


def _called(name: str, *arrays: Floats) -> tuple[Floats, ...]:
    """A function of the core at each element of arrays of one shape."""
    flat = [np.ascontiguousarray(array).ravel() for array in arrays]
    values = _core.elliptic(name, flat)
    return tuple(value.reshape(arrays[0].shape)[()] for value in values)


def _undriven(scene: Scene) -> None:
    """Raise for a scene under torque or damping: what follows from conserved numbers is lost."""
    if scene.outside is not None:
        raise ValueError(f"scene = {scene_words(scene)}: no closed form under torque and damping")


def lagrange_axis(scene: object) -> tuple[int, float]:
    """Symmetry axis of a Lagrange top, and on which side of the fixed point its weight is."""
    if not isinstance(scene, HeavyTop):
        raise TypeError(f"scene = {scene!r}: must be a rigid.HeavyTop")
    _undriven(scene)
    if scene.mgl == 0.0:
        raise ValueError("mgl = 0: a top without weight is a free body; use exact.free_body")
    axis = int(lagrange_axes(np.array([scene.body.moments]), scene.weight[np.newaxis])[0])
    if axis == 0:
        raise ValueError(
            f"moments = {scene.body.moments}, com = {scene.com}: a Lagrange top has two moments "
            "equal to the bit and its centre of mass exactly on the third axis"
        )
    return axis, float(np.sign(scene.com[axis - 1]))


def _largest(omega: Floats) -> NDArray[np.intp]:
    """The body axis of the largest rate of each body."""
    size = np.abs(omega)
    several = np.count_nonzero(size == size.max(axis=1, keepdims=True), axis=1) > 1
    if several.any():
        body = int(np.flatnonzero(several)[0])
        raise ValueError(
            f"omega[{body}] = {omega[body].tolist()}: has no single largest component; say axis=..."
        )
    axes: NDArray[np.intp] = size.argmax(axis=1) + 1
    return axes


def _pick(values: Any, mine: NDArray[np.bool_]) -> Any:
    """The rows of some bodies; one row serves all."""
    return values[mine] if isinstance(values, np.ndarray) and len(values) == len(mine) else values


def _without_scene(table: dict[str, Any]) -> dict[str, Any]:
    return {name: values for name, values in each_row(table).items() if name != "scene"}


def _of_one(values: dict[str, Any]) -> dict[str, Any]:
    return {name: array[0] for name, array in values.items()}
