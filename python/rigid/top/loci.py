"""The path of the axis of a symmetric top on the sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import exact
from .._checks.arguments import require, shaped
from .._checks.arrays import AttitudeLike, Floats, attitudes
from .._checks.overflow import refuses_overflow
from ..model.scene import HeavyTop, check_heavy_top
from ..rotations.apply import to_space
from ..solve.run import of_known_states
from ..solve.simulate import simulate
from .constants import over_tops, symmetric, tilts


def classify_locus(
    scene: HeavyTop, omega: ArrayLike, attitude: AttitudeLike | None = None
) -> str | NDArray[np.str_]:
    """The kind of path of the axis of a Lagrange top.

    The kind follows from the sign of ``phi'`` between the roots u1 and u2 of the cubic, which is
    the sign of ``a/b - u`` for positive spin: Goldstein, *Classical Mechanics*, § 5.7; Landau and
    Lifshitz, *Mechanics*, § 35; Ercan 2016, Fig. 16. The lecture notes lack monotone precession
    against the spin, ``a/b < u1`` (erratum G-18).

    Parameters
    ----------
    scene : HeavyTop
        A Lagrange top with weight, as in :func:`rigid.exact.lagrange_top`, or many.
    omega, attitude : array_like, shapes (..., 3) and (..., 4)
        State at any time of the motion; by default body and space axes coincide. The leading axes
        broadcast with each other and with the axes of the tops.

    Returns
    -------
    str, or ndarray of str of shape (...)
        ``"monotone"``: ``phi'`` keeps its sign; ``"loop"``: ``phi'`` changes its sign; ``"cusp"``:
        the axis stops on the upper circle; ``"steady"``: on one circle. Without spin ``"spherical
        pendulum"``, or ``"planar"`` in one plane; on the vertical ``"sleeping"``, ``"upright"``
        (unstable) or ``"hanging"``. :func:`rigid.exact.lagrange_top` has the same words, and
        ``retrograde``.

    Raises
    ------
    ValueError
        If the top is no Lagrange top, or the state is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> pushed = np.array([0.0, -0.3, 0.2]) * np.sin(np.pi / 3)
    >>> states = np.stack([0.0 * pushed, pushed, 0.0 * pushed + 5.0], axis=-1)
    >>> rigid.top.classify_locus(scene, states, tilted).tolist()
    ['cusp', 'loop', 'monotone']
    """
    motion = exact.lagrange_top(scene, omega, attitude)
    return np.array(motion.kind, dtype=np.str_).reshape(np.shape(motion.retrograde))[()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Advance:
    """Advance of the Euler angles in a period of the nutation.

    Attributes
    ----------
    period : ndarray, shape (...)
        Period of the nutation (s); inf on the homoclinic orbit and on the vertical.
    precession, spin : ndarray, shape (...)
        Advance (rad) of phi, about the upward vertical, and of psi, about the direction to the
        centre of mass; NaN on the vertical, where the angles are not defined.
    mean_precession : ndarray, shape (...)
        Mean rate of precession (rad/s); NaN on the vertical.
    """

    period: Floats
    precession: Floats
    spin: Floats
    mean_precession: Floats


def advance(scene: HeavyTop, omega: ArrayLike, attitude: AttitudeLike | None = None) -> Advance:
    """Advance of precession and spin in a period of the nutation.

    The mean precession of a top with loops never opposes the spin. The numbers come from
    :func:`rigid.exact.lagrange_top`.

    Parameters
    ----------
    scene, omega, attitude
        As in :func:`classify_locus`.

    Returns
    -------
    Advance

    Raises
    ------
    ValueError
        As in :func:`classify_locus`.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> round(float(rigid.top.advance(scene, [0.0, 0.0, 5.0], tilted).precession), 11)
    1.14228871898
    """
    motion = exact.lagrange_top(scene, omega, attitude)
    return Advance(
        period=motion.period,
        precession=motion.precession_advance,
        spin=motion.spin_advance,
        mean_precession=motion.precession,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Locus:
    """The axis of a top at given times.

    Attributes
    ----------
    theta : ndarray, shape (..., m)
        Tilt of the centre of mass from the upward vertical (rad).
    phi : ndarray, shape (..., m)
        Azimuth of the node line (rad), continuous: it changes by less than half a turn from one
        time to the next; 0 on the vertical, where there is no node line.
    point : ndarray, shape (..., m, 3)
        Unit vector to the centre of mass in space,
        ``(sin(theta) sin(phi), -sin(theta) cos(phi), cos(theta))``.
    """

    theta: Floats
    phi: Floats
    point: Floats


def locus(
    scene: HeavyTop,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike,
) -> Locus:
    """The path of the axis of a top on the unit sphere, in closed form if there is one.

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top, or many; the axis of a top is the direction to its centre of mass.
    omega, attitude : array_like, shapes (..., 3) and (..., 4)
        State at ``t = 0``; by default body and space axes coincide. The leading axes broadcast with
        each other and with the axes of the tops.
    t : array_like, shape (m,) or (..., m)
        Times (s), ascending; the same for all tops, or for each.

    Returns
    -------
    Locus

    Raises
    ------
    TypeError
        If the scene is no heavy top.
    ValueError
        As in :func:`rigid.simulate`.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> path = rigid.top.locus(scene, [0.0, 0.0, 5.0], tilted, t=np.linspace(0.0, 10.0, 101))
    >>> path.point[-1].round(9).tolist()
    [-0.869282411, 0.435218414, 0.234377947]
    """
    check_heavy_top(scene, many=True)
    run = of_known_states(simulate(scene, omega, attitude, t=t))
    assert run.attitude is not None  # recorded by default
    point = to_space(attitudes(run.attitude), np.asarray(scene.com)[..., np.newaxis, :])
    x, y, z = np.moveaxis(point, -1, 0)
    across = np.hypot(x, y)
    phi = np.unwrap(np.where(across > 0.0, np.arctan2(x, -y), 0.0), axis=-1)
    return Locus(theta=np.arctan2(across, z), phi=phi, point=point)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FastTop:
    """The small nutation of a fast top, approximately.

    Attributes
    ----------
    mean_precession : ndarray, shape (...)
        ``omega_P = mgl / (I3 omega3)`` (rad/s).
    nutation : ndarray, shape (...)
        Frequency of the nutation, ``omega_l = I3 omega3 / I1`` (rad/s).
    kind : str, or ndarray of str of shape (...)
        ``"monotone"``, ``"cusp"`` or ``"loop"`` as ``|omega_P - precession| / |omega_P|`` is
        below, at or above 1; ``"steady"`` at 0.
    theta_start, theta_other : ndarray, shape (...)
        Tilts of the two circles (rad): the given tilt, and
        ``theta + 2 sin(theta) (omega_P - precession) / omega_l``; the sign decides which circle is
        the upper one.
    phi_rate, phi, theta : ndarray, shape (..., m), or None
        Rate of precession (rad/s), azimuth relative to the start, and tilt (rad) at the times.
    error : ndarray, shape (..., m), or None
        Estimate of the error of theta, relative to the width of the band between the circles:
        ``|omega_P cos(theta)| t``, because the true frequency is lower by ``2 omega_P cos(theta)``,
        plus ``(|omega_P - precession| + |omega_P|) / |omega_l|``. For a given number of nutations
        the error falls as ``1 / omega3²``.
    """

    mean_precession: Floats
    nutation: Floats
    kind: str | NDArray[np.str_]
    theta_start: Floats
    theta_other: Floats
    phi_rate: Floats | None
    phi: Floats | None
    theta: Floats | None
    error: Floats | None


@refuses_overflow
def fast_top_approx(
    scene: HeavyTop,
    tilt: ArrayLike,
    spin: ArrayLike,
    *,
    precession: ArrayLike = 0.0,
    t: ArrayLike | None = None,
) -> FastTop:
    """Nutation and precession of a top that spins fast, to first order in its amplitude.

    ``phi' = omega_P - (omega_P - omega_0) cos(omega_l t)`` and
    ``theta = theta_0 + sin(theta_0) (omega_P - omega_0) (1 - cos(omega_l t)) / omega_l``, from
    ``I1 sin phi'' = I3 omega3 theta' - 2 I1 cos theta' phi'``: Goldstein, *Classical Mechanics*,
    § 5.7; Ercan 2016, eqs. (65)-(68), with ``2 I1 cos`` for ``I sin 2 theta`` in eq. (65) (erratum
    D-37). The amplitude must be small; the tilt need not be small (D-38).

    Parameters
    ----------
    scene : HeavyTop
        Two moments exactly equal, the centre of mass exactly on the third axis; one top or many.
    tilt : array_like, shape (...)
        Tilt at ``t = 0`` (rad), in [0, pi], a turning point: ``theta' = 0``.
    spin : array_like, shape (...)
        Rate about the body axis through the centre of mass, not zero (rad/s).
    precession : array_like, shape (...), optional
        ``omega_0``, the rate of precession at ``t = 0`` (rad/s); 0 for a top released from rest.
        Tilt, spin and precession broadcast with each other and with the tops.
    t : array_like, shape (m,) or (..., m), optional
        Times (s) of the motion; the same for all tops, or for each.

    Returns
    -------
    FastTop

    Raises
    ------
    ValueError
        If the top is not symmetric, has no spin, or an argument is not finite or out of range.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> found = rigid.top.fast_top_approx(scene, 1.0, 5.0)
    >>> float(found.mean_precession), float(found.nutation), str(found.kind)
    (0.4, 2.5, 'cusp')
    """
    symmetry = symmetric(scene)
    times = None if t is None else shaped("t", t)
    if times is not None and not times.ndim:
        raise ValueError("t: expected shape (m,) or (..., m), got ()")
    spins = shaped("spin", spin)
    require("spin", spins, spins != 0.0, "a fast top needs a spin")
    angle, rate, initial = over_tops(
        scene,
        tilt=tilts(tilt),
        spin=spins,
        precession=precession,
        times=() if times is None else times.shape[:-1],
    )
    momentum = symmetry.side * symmetry.along * rate
    omega_p, omega_l = scene.mgl / momentum, momentum / symmetry.across
    excess = omega_p - initial
    size = np.abs(excess)
    kind = np.select(
        [size == 0.0, size < np.abs(omega_p), size == np.abs(omega_p)],
        ["steady", "monotone", "cusp"],
        "loop",
    )
    swing = np.sin(angle) * excess / omega_l
    phi_rate = phi = theta = error = None
    if times is not None:
        every = (..., np.newaxis)
        phase = omega_l[every] * times
        mean, more = omega_p[every], excess[every]
        phi_rate = mean - more * np.cos(phase)
        phi = mean * times - more / omega_l[every] * np.sin(phase)
        theta = angle[every] + swing[every] * (1.0 - np.cos(phase))
        secular = np.abs(omega_p * np.cos(angle))[every] * np.abs(times)
        error = secular + ((size + np.abs(omega_p)) / np.abs(omega_l))[every]
    return FastTop(
        mean_precession=omega_p[()],
        nutation=omega_l[()],
        kind=kind[()],
        theta_start=np.array(angle)[()],
        theta_other=(angle + 2.0 * swing)[()],
        phi_rate=phi_rate,
        phi=phi,
        theta=theta,
        error=error,
    )
