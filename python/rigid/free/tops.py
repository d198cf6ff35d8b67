"""The free top: symmetric, by angles and rates; asymmetric, by Jacobi's functions."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._check import resolve_threads, sorted_times
from .._given import BodyLike, attitudes, finite_array, moments_of, require, vectors
from ..exact import FreeMotion
from ..methods import EXACT
from ..scenes import FreeBody
from ..starts import body_axis
from ..stepping import Request

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "AsymmetricTop",
    "SymmetricTop",
    "asymmetric_free_top",
    "steady_axis_frame",
    "steady_axis_spin",
    "symmetric_free_top",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SymmetricTop:
    """A free symmetric top: three rates that are not to be confused, and the angles that stay.

    ``I3`` is the moment about the axis of symmetry, ``I`` that across it, ``omega3`` the rate about
    the axis.

    Attributes
    ----------
    axis : ndarray of int, shape (...)
        The axis of symmetry: 1, 2 or 3.
    rate : ndarray, shape (...)
        ``|omega|``, constant (rad/s).
    k : ndarray, shape (...)
        ``omega3 (I3 - I) / I``, at which omega turns about the axis as seen from the body (rad/s):
        positive from the next axis to the one after it in cyclic order. Negative for a prolate top
        with positive spin, zero for a sphere.
    period, frequency : ndarray, shape (...)
        ``2 pi / |k|`` (s), inf for k = 0, and ``|k| / 2 pi`` (1/s).
    precession : ndarray, shape (...)
        ``phi' = |L| / I``, at which the axis turns about L in space (rad/s).
    spin : ndarray, shape (...)
        ``psi' = -k``, the third Euler rate about L (rad/s).
    alpha, theta : ndarray, shape (...)
        Angles of omega and of L from the axis (rad), in [0, pi]; 0 at rest. An oblate top has
        ``theta < alpha`` for positive spin.
    body_cone, space_cone : ndarray, shape (...)
        Half angles (rad) of the cones that omega describes about the axis and about L: alpha, or
        ``pi - alpha`` for negative spin, and ``|alpha - theta|``.
    amplitude, phase : ndarray, shape (...)
        Of the rates across the axis: ``A cos(k t + phase)`` and ``A sin(k t + phase)`` along the
        next axis and the one after it (rad/s, rad).
    omega : ndarray, shape (..., m, 3), or None
        Rates in the body at the wanted times (rad/s).
    attitude : ndarray, shape (..., m, 4), or None
        Attitudes at the wanted times.
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


def symmetric_free_top(
    body: BodyLike,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
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
        The body, or principal moments (kg m²), two of them equal to the bit.
    omega : array_like, shape (..., 3)
        Angular velocity in the body at ``t = 0`` (rad/s).
    attitude : array_like, shape (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``; by default body and space axes coincide.
    t : array_like, shape (m,), optional
        Times (s) at which the motion is wanted, by its closed form.
    axis : {1, 2, 3}, optional
        The axis of symmetry; by default the one that the moments tell, the third of a sphere.

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
    # The next axis, the one after it, the axis itself.
    order = (number[..., np.newaxis] + np.array([0, 1, 2], dtype=np.intp)) % 3
    across, other, along = np.moveaxis(np.take_along_axis(moments, order, axis=-1), -1, 0)
    require("moments", across, across == other, "the two across the axis of symmetry must be equal")
    first, second, spin = np.moveaxis(np.take_along_axis(rates, order, axis=-1), -1, 0)
    transverse = np.hypot(first, second)
    k = spin * (along - across) / across
    alpha = np.arctan2(transverse, spin)
    # The angle of L and omega from their products: alpha - theta cancels, for the Earth all digits.
    momentum = np.hypot(across * transverse, along * spin)
    twice_energy = across * transverse**2 + along * spin**2
    states = None if t is None else _states(moments, rates, attitude, t)
    if states is None and attitude is not None:
        raise ValueError("attitude: without times t there is no motion to start from it")
    with np.errstate(divide="ignore"):
        period = 2.0 * pi / np.abs(k)
    return SymmetricTop(
        axis=number[()],
        rate=np.hypot(transverse, spin),
        k=k,
        period=period,
        frequency=np.abs(k) / (2.0 * pi),
        precession=momentum / across,
        spin=-k,
        alpha=alpha,
        theta=np.arctan2(across * transverse, along * spin),
        body_cone=np.minimum(alpha, pi - alpha),
        space_cone=np.arctan2(np.abs((along - across) * spin) * transverse, twice_energy),
        amplitude=transverse,
        phase=np.arctan2(second, first),
        omega=None if states is None else states[0],
        attitude=None if states is None else states[1],
    )


def _symmetry_axes(moments: Floats) -> NDArray[np.intp]:
    """The axis 1, 2 or 3 across which the moments are equal; the third one of a sphere."""
    i1, i2, i3 = np.moveaxis(moments, -1, 0)
    pairs = np.stack([i1 == i2, i3 == i1, i2 == i3], axis=-1)
    symmetric = pairs.any(axis=-1)
    if not symmetric.all():
        found = moments[~symmetric][0].tolist()
        raise ValueError(f"moments = {found}: a symmetric top has two moments equal to the bit")
    axes: NDArray[np.intp] = 3 - pairs.argmax(axis=-1)
    return axes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AsymmetricTop(FreeMotion):
    """A free body of any moments: what :class:`rigid.exact.FreeMotion` says of it, and its motion.

    About the encircled axis the rate is ``amplitude dn``, about the middle axis ``amplitude sn``,
    about the third ``amplitude cn`` of ``frequency t + phase``; ``period = 4 K / frequency``.

    Attributes
    ----------
    frequency : ndarray, shape (...)
        Rate of the argument of Jacobi's functions (rad/s); 0 for constant rates of a sphere.
    omega : ndarray, shape (..., m, 3), or None
        Rates in the body at the wanted times (rad/s).
    attitude : ndarray, shape (..., m, 4), or None
        Attitudes at the wanted times.
    """

    frequency: Floats
    omega: Floats | None
    attitude: Floats | None


def asymmetric_free_top(
    body: BodyLike,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike | None = None,
) -> AsymmetricTop:
    """Period, amplitudes and parameter of a free body, and its motion by closed form.

    Landau and Lifshitz, *Mechanics*, § 37. The complementary parameter ``mc = 1 - m`` is formed
    from the components of omega: from energy and momentum it has no digits near the separatrix.

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
    moments, rates = np.broadcast_arrays(moments_of(body), vectors("omega", omega))
    shape = moments.shape[:-1]
    flat = np.ascontiguousarray(moments.reshape(-1, 3)), np.ascontiguousarray(rates.reshape(-1, 3))
    values = _core.free_quantities(moments=flat[0], omega=flat[1])
    known = {
        field.name: values[field.name].reshape(shape + values[field.name].shape[1:])[()]
        for field in fields(FreeMotion)
    }
    states = None if t is None else _states(moments, rates, attitude, t)
    if states is None and attitude is not None:
        raise ValueError("attitude: without times t there is no motion to start from it")
    return AsymmetricTop(
        **known,
        frequency=_frequency(moments, rates),
        omega=None if states is None else states[0],
        attitude=None if states is None else states[1],
    )


def _frequency(moments: Floats, rates: Floats) -> Floats:
    """Rate of the argument of Jacobi's functions; both classes of motion, as sums of squares."""
    order = np.argsort(moments, axis=-1, kind="stable")
    i1, i2, i3 = np.moveaxis(np.take_along_axis(moments, order, axis=-1), -1, 0)
    w1, w2, w3 = np.moveaxis(np.take_along_axis(rates, order, axis=-1) ** 2, -1, 0)
    # The two products are (L² - 2 E I1)(I3 - I2) and (2 E I3 - L²)(I2 - I1), divided by the
    # moments; the larger one belongs to the axis that is encircled.
    about_large = (i3 - i2) * ((i2 - i1) * w2 / i3 + (i3 - i1) * w3 / i2) / i1
    about_small = (i2 - i1) * ((i3 - i1) * w1 / i2 + (i3 - i2) * w2 / i1) / i3
    frequency: Floats = np.sqrt(np.maximum(about_large, about_small))
    return frequency


def _states(
    moments: Floats, rates: Floats, attitude: ArrayLike | Rotation | None, t: ArrayLike
) -> tuple[Floats, Floats]:
    """Rates and attitudes at the times, by closed form, of bodies with moments of their own."""
    start = np.array([1.0, 0.0, 0.0, 0.0]) if attitude is None else attitudes(attitude)
    shape = np.broadcast_shapes(rates.shape[:-1], start.shape[:-1])
    times = sorted_times("t", t)
    request = Request(
        table={
            "scene": FreeBody.kind,
            "moments": _rows(moments, shape),
            "weight": np.zeros((1, 3)),
            "omega": _rows(rates, shape),
            "attitude": _rows(start, shape),
        },
        times=times,
        method=EXACT,
        record="attitude",
        max_steps=1,
        threads=resolve_threads(None),
        tolerance=None,
    )
    found = request.states(request.table, None)
    leading = (*shape, len(times))
    return found["omega"].reshape(*leading, 3), found["attitude"].reshape(*leading, 4)


def _rows(array: Floats, shape: tuple[int, ...]) -> Floats:
    width = array.shape[-1]
    return np.ascontiguousarray(np.broadcast_to(array, (*shape, width)).reshape(-1, width))


def steady_axis_frame(body: BodyLike, spin: ArrayLike, tilt: ArrayLike = 0.0) -> Floats:
    """Rate of the frame of the axis in which a free symmetric top precesses steadily.

    The frame turns with Omega, carries the axis as its third direction and does not spin: the body
    turns by ``omega = Omega + nu e3``. Without torque ``I omega' + Omega × I omega = 0`` asks for
    ``Omega3 = nu I3 / (I - I3)``, with any part across the axis: Buller and Wernstål 2011, eq. (2),
    whose second line has I where I3 is meant (erratum S-03), so that
    ``|Omega| = |Omega3| / cos(tilt)`` (S-04). Omega is then parallel to ``L = I Omega``.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        A symmetric top, the third axis being that of symmetry.
    spin : array_like, shape (...)
        ``nu``, the spin within that frame (rad/s).
    tilt : array_like, shape (...), optional
        Angle (rad) between the axis and the line of Omega, in [0, pi/2).

    Returns
    -------
    ndarray, shape (..., 3)
        Omega in the frame of the axis (rad/s): ``(Omega3 tan(tilt), 0, Omega3)``.

    Raises
    ------
    ValueError
        If the moments are all equal, for which no rate is finite, or the tilt is out of range.

    Examples
    --------
    >>> from rigid import free
    >>> free.steady_axis_frame((1.0, 1.0, 1.5), spin=-1.0).tolist()
    [0.0, 0.0, 3.0]
    """
    across, along = _third_axis(body)
    nu, angle = finite_array("spin", spin), finite_array("tilt", tilt)
    require("tilt", angle, (angle >= 0.0) & (angle < 0.5 * pi), "must lie in [0, pi/2) (rad)")
    axial, angle = np.broadcast_arrays(nu * along / (across - along), angle)
    return np.stack([axial * np.tan(angle), np.zeros(axial.shape), axial], axis=-1)


def steady_axis_spin(body: BodyLike, frame_rate: ArrayLike) -> Floats:
    """The spin ``nu = Omega3 (I - I3) / I3`` that goes with a rate of the frame of the axis.

    The inverse of :func:`steady_axis_frame`; it is ``-k`` of :func:`symmetric_free_top`.

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
    spin: Floats = vectors("frame_rate", frame_rate)[..., 2] * (across - along) / along
    return spin


def _third_axis(body: BodyLike) -> tuple[Floats, Floats]:
    first, second, along = np.moveaxis(moments_of(body), -1, 0)
    require("moments", first, first == second, "the two across the third axis must be equal")
    require("moments", along, along != first, "must differ from those across: a sphere has no axis")
    return first, along
