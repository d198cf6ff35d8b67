"""Free symmetric tops by angles and rates, free asymmetric tops by Jacobi's functions."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import require, shaped, sorted_times
from .._checks.arrays import AttitudeLike, Floats, of_size_one, vectors
from .._checks.overflow import refuses_overflow
from .._checks.shown import short_repr
from ..exact import FreeMotion
from ..model.body import Body
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody
from ..model.start import body_axis
from ..solve.run import of_known_states
from ..solve.simulate import simulate


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SymmetricTop:
    """The rates and the constant angles of a free symmetric top, and its motion.

    ``I3`` is the moment about the axis of symmetry, ``I`` the moment about a perpendicular axis,
    ``omega3`` the rate about the axis of symmetry.

    Attributes
    ----------
    axis : ndarray of int, shape (...)
        The axis of symmetry: 1, 2 or 3.
    rate : ndarray, shape (...)
        ``|omega|``, constant (rad/s).
    k : ndarray, shape (...)
        ``omega3 (I3 - I) / I``, the rate at which omega turns about the axis in the body (rad/s):
        positive in the cyclic order of the axes. Negative for a prolate top with positive spin,
        zero for a sphere.
    period, frequency : ndarray, shape (...)
        ``2 pi / |k|`` (s), inf for k = 0, and ``|k| / 2 pi`` (1/s).
    precession : ndarray, shape (...)
        ``phi' = |L| / I``, the rate at which the axis turns about L in space (rad/s).
    spin : ndarray, shape (...)
        ``psi' = -k``, the third Euler rate about L (rad/s).
    alpha, theta : ndarray, shape (...)
        Angles of omega and of L from the axis (rad), in [0, pi]; 0 at rest. An oblate top has
        ``theta < alpha`` for positive spin.
    body_cone, space_cone : ndarray, shape (...)
        Half angles (rad) of the cones of omega about the axis and about L: alpha, or ``pi - alpha``
        for negative spin, and ``|alpha - theta|``.
    amplitude, phase : ndarray, shape (...)
        Amplitude A and phase (rad/s, rad) of the rates about the other two axes in cyclic order,
        ``A cos(k t + phase)`` and ``A sin(k t + phase)``.
    omega : ndarray, shape (..., m, 3), or None
        Angular velocities in the body at the times ``t`` (rad/s).
    attitude : ndarray, shape (..., m, 4), or None
        Attitudes at the times ``t``.
    """

    axis: NDArray[np.intp]
    rate: Floats
    k: Floats
    period: Floats
    frequency: Floats
    precession: Floats
    spin: Floats
    alpha: Floats
    theta: Floats
    body_cone: Floats
    space_cone: Floats
    amplitude: Floats
    phase: Floats
    omega: Floats | None
    attitude: Floats | None


@refuses_overflow
def symmetric_free_top(
    body: BodyLike,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike | None = None,
    axis: int | None = None,
) -> SymmetricTop:
    """Rates, angles and cones of a free symmetric top, and its motion.

    Landau and Lifshitz, *Mechanics*, §§ 33, 35; Ercan 2016, eqs. (43)-(53): the period of eq. (46)
    needs ``|I3 - I|`` and its frequency is ``|k| / 2 pi``, not ``k / 2`` (erratum D-20), and the
    half angle of the space cone is ``|alpha - theta|``, not theta (D-22).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²), two of them exactly equal.
    omega : array_like, shape (..., 3)
        Angular velocity in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``; by default body and space axes coincide.
    t : array_like, shape (m,), optional
        Times (s) at which to evaluate the closed form of the motion.
    axis : {1, 2, 3}, optional
        The axis of symmetry; by default the axis of the different moment, or axis 3 for a sphere.

    Returns
    -------
    SymmetricTop

    Raises
    ------
    ValueError
        If a top is not symmetric (about the axis), no body has the moments, or a value is not
        finite.

    Examples
    --------
    >>> from rigid import free
    >>> top = free.symmetric_free_top((1.0, 1.0, 1.6), [0.9, 0.0, 2.3])
    >>> round(float(top.k), 9), round(float(top.precession), 9), round(float(top.spin), 9)
    (1.38, 3.78845615, -1.38)
    """
    moments, rates = np.broadcast_arrays(moments_of(body), vectors("omega", omega))
    if axis is None:
        number = _symmetry_axes(moments)
    else:
        number = np.full(moments.shape[:-1], body_axis(axis))
    # The other two axes in cyclic order, and the symmetry axis.
    order = (number[..., np.newaxis] + np.array([0, 1, 2], dtype=np.intp)) % 3
    across, other, along = np.moveaxis(np.take_along_axis(moments, order, axis=-1), -1, 0)
    require("moments", across, across == other, "the two across the axis of symmetry must be equal")
    first, second, spin = np.moveaxis(np.take_along_axis(rates, order, axis=-1), -1, 0)
    transverse = np.hypot(first, second)
    k = spin * ((along - across) / across)
    alpha = np.arctan2(transverse, spin)
    ratio = along / across
    tilting, turning = np.moveaxis(of_size_one(np.stack([transverse, spin], axis=-1))[0], -1, 0)
    theta, separation = cone_angles(tilting, turning, ratio, (along - across) / across)
    states = _states(moments, rates, attitude, t)
    with np.errstate(divide="ignore"):
        period = 2.0 * pi / np.abs(k)
    return SymmetricTop(
        axis=number[()],
        rate=np.hypot(transverse, spin),
        k=k,
        period=period,
        frequency=np.abs(k) / (2.0 * pi),
        precession=np.hypot(transverse, ratio * spin),
        spin=-k,
        alpha=alpha,
        theta=theta,
        body_cone=np.minimum(alpha, pi - alpha),
        space_cone=separation,
        amplitude=transverse,
        phase=np.arctan2(second, first),
        omega=states[0],
        attitude=states[1],
    )


def cone_angles(
    tilting: Floats, turning: Floats, ratio: Floats, ellipticity: Floats
) -> tuple[Floats, Floats]:
    """Angles (rad) of L from the symmetry axis and from omega.

    The rates across and along the axis are in any unit, ``ratio`` is ``I3 / I`` and ``ellipticity``
    ``(I3 - I) / I``, which the ratio would know to fewer digits.
    """
    theta = np.arctan2(tilting, ratio * turning)
    # From products: alpha - theta loses all digits for the Earth.
    sine = np.abs(ellipticity * turning) * tilting
    return theta, np.arctan2(sine, tilting**2 + ratio * turning**2)


def _symmetry_axes(moments: Floats) -> NDArray[np.intp]:
    """The symmetry axis 1, 2 or 3 of each body; 3 for a sphere."""
    i1, i2, i3 = np.moveaxis(moments, -1, 0)
    pairs = np.stack([i1 == i2, i3 == i1, i2 == i3], axis=-1)
    symmetric = pairs.any(axis=-1)
    if not symmetric.all():
        found = moments[~symmetric][0].tolist()
        raise ValueError(f"moments = {found}: a symmetric top has two exactly equal moments")
    axes: NDArray[np.intp] = 3 - pairs.argmax(axis=-1)
    return axes


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AsymmetricTop(FreeMotion):
    """Period, amplitudes and precession of any free body, and its motion in closed form.

    With the argument ``frequency t + phase`` the rate about the encircled axis is ``amplitude dn``,
    about the middle axis ``amplitude sn``, about the third axis ``amplitude cn``; ``period =
    4 K / frequency``.

    Attributes
    ----------
    frequency : ndarray, shape (...)
        Rate of the argument of Jacobi's functions (rad/s); 0 for constant rates of a sphere.
    omega : ndarray, shape (..., m, 3), or None
        Rates in the body at the given times (rad/s).
    attitude : ndarray, shape (..., m, 4), or None
        Attitudes at the given times.
    """

    frequency: Floats
    omega: Floats | None
    attitude: Floats | None


@refuses_overflow
def asymmetric_free_top(
    body: BodyLike,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike | None = None,
) -> AsymmetricTop:
    """Period, amplitudes and parameter of a free body, and its motion by closed form.

    Landau and Lifshitz, *Mechanics*, § 37. The function computes the complementary parameter
    ``mc = 1 - m`` from the components of omega, because energy and momentum lose all its digits
    near the separatrix.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²) in any order.
    omega, attitude, t
        As in :func:`symmetric_free_top`.

    Returns
    -------
    AsymmetricTop

    Raises
    ------
    ValueError
        If no body has the moments, or a value is not finite.

    Examples
    --------
    >>> from rigid import free
    >>> top = free.asymmetric_free_top((1.0, 2.0, 3.0), [0.3, 0.2, 1.2])
    >>> round(float(top.period), 12), int(top.axis)
    (5.251429794838, 3)
    """
    unit, _ = of_size_one(moments_of(body))  # their ratios alone matter
    moments, rates = np.broadcast_arrays(unit, vectors("omega", omega))
    shape = moments.shape[:-1]
    flat = np.ascontiguousarray(moments.reshape(-1, 3)), np.ascontiguousarray(rates.reshape(-1, 3))
    values = _core.free_quantities(moments=flat[0], omega=flat[1])
    known = {
        field.name: values[field.name].reshape(shape + values[field.name].shape[1:])[()]
        for field in fields(FreeMotion)
    }
    states = _states(moments, rates, attitude, t)
    return AsymmetricTop(
        **known,
        frequency=_frequency(moments, rates),
        omega=states[0],
        attitude=states[1],
    )


def _frequency(moments: Floats, rates: Floats) -> Floats:
    """Rate of the argument of Jacobi's functions, from sums of squares."""
    order = np.argsort(moments, axis=-1, kind="stable")
    i1, i2, i3 = np.moveaxis(np.take_along_axis(moments, order, axis=-1), -1, 0)
    rates, power = of_size_one(rates)
    w1, w2, w3 = np.moveaxis(np.take_along_axis(rates, order, axis=-1) ** 2, -1, 0)
    # The two products are (L² - 2 E I1)(I3 - I2) and (2 E I3 - L²)(I2 - I1), divided by the
    # moments; the larger product belongs to the encircled axis.
    about_large = (i3 - i2) * ((i2 - i1) * w2 / i3 + (i3 - i1) * w3 / i2) / i1
    about_small = (i2 - i1) * ((i3 - i1) * w1 / i2 + (i3 - i2) * w2 / i1) / i3
    frequency = np.sqrt(np.maximum(about_large, about_small))
    return np.asarray(np.ldexp(frequency, power[..., 0]))[()]


def _states(
    moments: Floats, rates: Floats, attitude: AttitudeLike | None, t: ArrayLike | None
) -> tuple[Floats | None, Floats | None]:
    """Angular velocities and attitudes at the times in closed form; each body has its moments."""
    if t is None:
        if attitude is not None:
            raise ValueError("attitude: without times t there is no motion to start from it")
        return None, None
    scene = FreeBody(Body(moments, physical=False))
    run = simulate(scene, rates, attitude, t=sorted_times("t", t), method="exact")
    return of_known_states(run).omega, run.attitude


@refuses_overflow
def steady_axis_frame(body: BodyLike, spin: ArrayLike, tilt: ArrayLike = 0.0) -> Floats:
    """Angular velocity of the frame in which a free symmetric top precesses steadily.

    The third direction of the frame is the axis of the top, and the frame turns with Omega. The
    body spins in the frame: ``omega = Omega + nu e3``. Without torque
    ``I omega' + Omega × I omega = 0``, thus ``Omega3 = nu I3 / (I - I3)``, and the component of
    Omega perpendicular to the axis is arbitrary: Buller and Wernstål 2011, eq. (2), where the
    second line has I instead of I3 (erratum S-03); ``|Omega| = |Omega3| / cos(tilt)`` (S-04). Omega
    is then parallel to ``L = I Omega``.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        A symmetric top with axis 3 as the symmetry axis.
    spin : array_like, shape (...)
        ``nu``, the spin in the frame (rad/s).
    tilt : array_like, shape (...), optional
        Angle (rad) between the axis and the line of Omega, in [0, pi/2).

    Returns
    -------
    ndarray, shape (..., 3)
        Omega in the frame of the axis (rad/s): ``(Omega3 tan(tilt), 0, Omega3)``.

    Raises
    ------
    ValueError
        If all moments are equal, because then no rate is finite, or the tilt is out of range.

    Examples
    --------
    >>> from rigid import free
    >>> free.steady_axis_frame((1.0, 1.0, 1.5), spin=-1.0).tolist()
    [0.0, 0.0, 3.0]
    """
    across, along = _third_axis(body)
    nu, angle = shaped("spin", spin), shaped("tilt", tilt)
    require("tilt", angle, (angle >= 0.0) & (angle < 0.5 * pi), "must lie in [0, pi/2) (rad)")
    axial, angle = np.broadcast_arrays(nu * along / (across - along), angle)
    return np.stack([axial * np.tan(angle), np.zeros(axial.shape), axial], axis=-1)


@refuses_overflow
def steady_axis_spin(body: BodyLike, frame_rate: ArrayLike) -> Floats:
    """The spin ``nu = Omega3 (I - I3) / I3`` that follows from the angular velocity of the frame.

    The inverse of :func:`steady_axis_frame`; the spin is ``-k`` of :func:`symmetric_free_top`.

    Parameters
    ----------
    body
        As in :func:`steady_axis_frame`.
    frame_rate : array_like, shape (..., 3)
        Omega in the frame of the axis (rad/s).

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    ValueError
        As for :func:`steady_axis_frame`.

    Examples
    --------
    >>> from rigid import free
    >>> float(free.steady_axis_spin((1.0, 1.0, 1.5), [0.2, 0.0, 3.0]))
    -1.0
    """
    across, along = _third_axis(body)
    return vectors("frame_rate", frame_rate)[..., 2] * (across - along) / along


def _third_axis(body: BodyLike) -> tuple[Floats, Floats]:
    first, second, along = np.moveaxis(moments_of(body), -1, 0)
    require("moments", first, first == second, "the two across the third axis must be equal")
    require("moments", along, along != first, "must differ from those across: a sphere has no axis")
    return first, along
