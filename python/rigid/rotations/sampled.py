"""Angular velocity from sampled attitudes, and attitudes from a given angular velocity.

Use :func:`rigid.simulate` if the body obeys equations of motion. Use this module if attitudes have
been measured or the angular velocity is prescribed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, log2, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, one_of, shaped, sorted_times
from .._checks.arrays import AttitudeLike, Floats
from .._checks.extras import install_extra
from .._checks.overflow import refuses_overflow
from .quaternions import conjugate, exp_quaternion, log_quaternion, quaternion_product, quaternions

MOST_STEPS = 2**20
"""Largest number of steps of :func:`attitude_from_omega`."""

_NODES = np.array([0.5 - sqrt(0.15), 0.5, 0.5 + sqrt(0.15)])
"""Gauss points of the interval from 0 to 1."""

_FIRST_STEPS = 64
"""Least number of steps, so that the first steps resolve most oscillations of the rates."""

_SMALLEST_TOLERANCE = 1e-14

_FEWEST_SAMPLES = 4
"""A spline through fewer samples is no cubic."""

_FINER_DEGREE = 5
"""Degree of the spline that tells the error in a long interval: there every second sample tells
nothing. The error was at most 1.14 times the difference of both, in 240 records of smooth rates.
Fewer samples have no such spline: of 600 records one had an error above twice the largest change
that leaving one sample out makes, by a twentieth."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AttitudePath:
    """Attitudes that follow from a prescribed angular velocity.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    attitude : ndarray, shape (..., m, 4)
        Unit quaternions, continuous in time.
    error : float
        Error estimate: the largest angle (rad) by which halving the steps changed an attitude; of
        samples also what follows from every second one.
    steps : int
        Number of steps in all intervals together.
    """

    t: Floats
    attitude: Floats
    error: float
    steps: int


def omega_from_attitudes(attitude: AttitudeLike, t: ArrayLike, *, frame: str = "body") -> Floats:
    """Angular velocity (rad/s) from sampled attitudes, by central differences of order 2.

    The constant rate from one attitude to the next approximates the rate in the middle of the
    interval, with an error of order 2 in the length of the interval. The function interpolates
    these rates to the samples and extrapolates them at both ends. The times may be uneven. Two
    samples have one rate.

    For smooth samples without noise SciPy is more accurate away from the ends:
    ``RotationSpline(t, rotations)(t, order=1)`` has order 4 there. For a turn of 0.2 rad between
    samples its error is some 100 times smaller, and decreases 16 times at every halving of the
    intervals. Near the ends it has order 1 and a larger error than this function.

    Parameters
    ----------
    attitude : array_like, shape (..., m, 4) or (..., m, 3, 3), or SciPy Rotation
        Attitudes at two or more times. The turn between neighbours must be less than pi, because
        samples show the shortest turn only. The sign of a quaternion does not matter.
    t : array_like, shape (m,)
        Times (s), strictly ascending.
    frame : {"body", "space"}
        Frame of the components of the angular velocity.

    Returns
    -------
    ndarray, shape (..., m, 3)
        Angular velocity (rad/s).

    Raises
    ------
    ValueError
        If the numbers of times and attitudes differ, the times are not strictly ascending, or an
        attitude is no rotation.

    Notes
    -----
    ``hat(omega) = R.T dR/dt`` with ``R`` from body to space. Lecture notes, eq. (5.1), has the same
    formula, but its matrix of eq. (5.2) is the transpose (erratum G-07).

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid import rotations
    >>> t = np.linspace(0.0, 1.0, 11)
    >>> spin = rotations.exp_quaternion(np.outer(t, [0.0, 0.0, 2.0]))
    >>> rotations.omega_from_attitudes(spin, t)[5].round(12)
    array([0., 0., 2.])
    """
    q = quaternions("attitude", attitude)
    one_of("frame", frame, ("body", "space"))
    times = _times_of("attitudes", q, t, at_least=2)
    gaps = np.diff(times)[:, None]
    turn = _then(conjugate(q[..., :-1, :]), q[..., 1:, :], frame)
    middle = log_quaternion(turn) / gaps
    if len(times) == 2:
        return np.repeat(middle, 2, axis=-2)
    slope = np.diff(middle, axis=-2) / (gaps[:-1] + gaps[1:])  # per half of the time
    inside = middle[..., :-1, :] + slope * gaps[:-1]
    first = middle[..., :1, :] - slope[..., :1, :] * gaps[0]
    last = middle[..., -1:, :] + slope[..., -1:, :] * gaps[-1]
    return np.concatenate([first, inside, last], axis=-2)


def attitude_from_omega(
    omega: Callable[[Floats], ArrayLike],
    t: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    frame: str = "body",
    tolerance: float = 1e-10,
) -> AttitudePath:
    """Attitudes that follow from a given angular velocity (rad/s), by ``R' = R hat(omega)``.

    Each step applies the Magnus series of order 6 with three Gauss points (S. Blanes, F. Casas, J.
    Ros, *BIT* 40 (2000) 434), so the attitude stays a rotation, and a constant rate is integrated
    exactly. The function multiplies the steps in a binary tree, which keeps the rounding small, and
    halves the steps until no attitude changes by more than the tolerance. (``R =
    exp(t hat(omega))``, a possible reading of eq. (5.1) of the lecture notes, holds for a constant
    rate only: erratum G-22.)

    Parameters
    ----------
    omega : callable
        Given times of shape ``(k,)``, returns the angular velocity (rad/s), shape ``(k, 3)``, or
        ``(..., k, 3)`` for many bodies. For samples see :func:`attitude_from_samples`.
    t : array_like, shape (m,)
        Ascending times (s).
    attitude : array_like, shape (..., 4) or (..., 3, 3), or SciPy Rotation, optional
        Attitude at ``t[0]``; without it, the axes of body and space coincide.
    frame : {"body", "space"}
        Frame of the components of ``omega``.
    tolerance : float
        Largest estimated error (rad), at least 1e-14.

    Returns
    -------
    AttitudePath

    Raises
    ------
    TypeError
        If ``omega`` is no function.
    ValueError
        If the rates have the wrong shape or are not finite, or if ``2**20`` steps do not reach the
        tolerance. In this case split the times where the rates jump, or pass shorter times.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> def omega(t):
    ...     return np.stack([np.cos(3 * t), np.sin(3 * t), 0 * t + 2.0], axis=-1)
    >>> path = rotations.attitude_from_omega(omega, [0.0, 1.0, 2.0])
    >>> path.attitude.shape, path.error < 1e-10
    ((3, 4), True)
    """
    if not callable(omega):
        raise TypeError(
            f"omega = {brief(omega)}: must be a function of the times; of samples take "
            "attitude_from_samples"
        )
    times = sorted_times("t", t)
    if len(times) == 0:
        raise ValueError("t: expected at least one time, when the first attitude is given")
    one_of("frame", frame, ("body", "space"))
    tolerance = finite_float("tolerance", tolerance, positive=True)
    if tolerance < _SMALLEST_TOLERANCE:
        raise ValueError(f"tolerance = {tolerance}: must be at least {_SMALLEST_TOLERANCE}")
    start = quaternions("attitude", [1.0, 0.0, 0.0, 0.0] if attitude is None else attitude)

    intervals = len(times) - 1
    if intervals == 0:
        return AttitudePath(t=times, attitude=start[..., None, :], error=0.0, steps=0)
    each = 1 << max(0, ceil(log2(_FIRST_STEPS / intervals)))
    path = _path(omega, times, each, start, frame)
    error = inf
    while error > tolerance:
        each *= 2
        if each * intervals > MOST_STEPS and error < inf:
            raise ValueError(
                f"tolerance = {tolerance}: not reached with {each // 2 * intervals} steps, which "
                f"changed an attitude by {error:.2g} rad"
            )
        coarse, path = path, _path(omega, times, each, start, frame)
        error = _largest_angle(coarse, path)
    return AttitudePath(t=times, attitude=path, error=error, steps=each * intervals)


@refuses_overflow
def attitude_from_samples(
    omega: ArrayLike,
    t: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    frame: str = "body",
    tolerance: float = 1e-10,
) -> AttitudePath:
    """Attitudes that follow from sampled angular velocities (rad/s), as a gyroscope records them.

    A cubic spline through the samples is the rate that :func:`attitude_from_omega` integrates. The
    attitudes of smooth rates have order 4 in the length of the intervals.

    Parameters
    ----------
    omega : array_like, shape (..., m, 3)
        Angular velocity (rad/s) at four or more times. If a gyroscope measures angles, divide each
        by its interval and take the time in its middle.
    t : array_like, shape (m,)
        Times (s), strictly ascending; they may be uneven.
    attitude : array_like, shape (..., 4) or (..., 3, 3), or SciPy Rotation, optional
        Attitude at ``t[0]``; without it, the axes of body and space coincide.
    frame : {"body", "space"}
        Frame of the components of ``omega``.
    tolerance : float
        Largest estimated error (rad) of the integration of the spline, at least 1e-14.

    Returns
    -------
    AttitudePath
        At the times of the samples. Its ``error`` contains the error of the spline: a third of the
        largest angle by which attitudes change if every second sample is left out, or twice the
        angle by which a spline of degree 5 differs, which is larger beside a gap of the record. Of
        four or five samples it is twice the largest angle if any one of them is left out.
        Noise of the samples, and what happens between them, is not in it.

    Raises
    ------
    ImportError
        If SciPy is missing.
    ValueError
        If the numbers of times and samples differ, the times are not strictly ascending, the rates
        are not finite, or ``2**20`` steps do not reach the tolerance.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import rotations
    >>> t = np.linspace(0.0, 2.0, 41)
    >>> samples = np.stack([np.cos(3 * t), np.sin(3 * t), 0 * t + 2.0], axis=-1)
    >>> path = rotations.attitude_from_samples(samples, t)
    >>> path.attitude.shape, path.error < 1e-5
    ((41, 4), True)
    """
    rates = shaped("omega", omega, 3)
    times = _times_of("samples", rates, t, at_least=_FEWEST_SAMPLES)
    try:
        from scipy.interpolate import CubicSpline, make_interp_spline
    except ImportError:
        raise ImportError(install_extra("a spline needs SciPy", "maps")) from None

    def path_of(spline: Callable[[Floats], ArrayLike]) -> AttitudePath:
        return attitude_from_omega(spline, times, attitude, frame=frame, tolerance=tolerance)

    def change(kept: NDArray[np.intp]) -> float:
        """The largest angle by which attitudes differ if only these samples are known."""
        fewer = path_of(CubicSpline(times[kept], rates[..., kept, :], axis=-2))
        return _largest_angle(path.attitude, fewer.attitude)

    path, every = path_of(CubicSpline(times, rates, axis=-2)), np.arange(len(times))
    if len(times) > _FINER_DEGREE:
        finer = path_of(make_interp_spline(times, rates, k=_FINER_DEGREE, axis=-2))
        of_spline = max(
            change(np.union1d(every[::2], every[-1])) / 3.0,
            2.0 * _largest_angle(path.attitude, finer.attitude),
        )
    else:
        of_spline = 2.0 * max(change(np.delete(every, k)) for k in every)
    return replace(path, error=path.error + of_spline)


def _times_of(what: str, values: Floats, t: ArrayLike, *, at_least: int) -> Floats:
    """Strictly ascending times, one for each row of values."""
    times = sorted_times("t", t)
    if values.ndim < 2 or values.shape[-2] != len(times) or len(times) < at_least:
        raise ValueError(
            f"t: expected the times of at least {at_least} {what}, got shape {times.shape} "
            f"for {what} of shape {values.shape}"
        )
    gaps = np.diff(times)
    if not np.all(gaps > 0.0):
        k = int(np.argmin(gaps))
        raise ValueError(f"t[{k}] = t[{k + 1}] = {times[k]}: times must be strictly ascending")
    return times


def _path(
    omega: Callable[[Floats], ArrayLike], times: Floats, each: int, start: Floats, frame: str
) -> Floats:
    """The attitudes at all times; ``each`` steps, a power of two, in each interval."""
    gaps = np.diff(times)[:, None]
    turns = exp_quaternion(_steps(omega, times, gaps, each, frame))
    while turns.shape[-2] > 1:
        turns = _then(turns[..., 0::2, :], turns[..., 1::2, :], frame)
    leading = np.broadcast_shapes(start.shape[:-1], turns.shape[:-3])
    path = np.empty((*leading, len(times), 4))
    path[..., 0, :], path[..., 1:, :] = start, turns[..., 0, :]
    # Prefix products over spans of 2, 4, ... factors (W. D. Hillis and G. L. Steele 1986).
    shift = 1
    while shift < len(times):
        path[..., shift:, :] = _then(path[..., :-shift, :], path[..., shift:, :], frame)
        shift *= 2
    unit: Floats = path / np.linalg.norm(path, axis=-1, keepdims=True)
    return unit


def _steps(
    omega: Callable[[Floats], ArrayLike], times: Floats, gaps: Floats, each: int, frame: str
) -> Floats:
    """The rotation vectors of the steps, shape (..., m - 1, each, 3).

    The Magnus series solves ``Y' = A Y``. In space ``Y = R`` and ``A = hat(omega)``; in the body
    ``Y = R.T`` and ``A = -hat(omega)``. The commutator of two antisymmetric matrices is the cross
    product of their vectors.
    """
    step = gaps / each
    nodes = (times[:-1, None] + step * np.arange(each))[..., None] + step[..., None] * _NODES
    rates = shaped("omega(t)", omega(nodes.ravel()), 3)
    if rates.ndim < 2 or rates.shape[-2] != nodes.size:
        raise ValueError(
            f"omega(t): expected shape (..., {nodes.size}, 3) for {nodes.size} times, "
            f"got {rates.shape}"
        )
    sign = -1.0 if frame == "body" else 1.0
    rates = rates.reshape(*rates.shape[:-2], *nodes.shape, 3)
    early, mean, late = np.moveaxis(sign * step[..., None, None] * rates, -2, 0)
    slope = sqrt(15.0) / 3.0 * (late - early)
    bend = 10.0 / 3.0 * (late - 2.0 * mean + early)
    first = np.cross(mean, slope)
    second = -np.cross(mean, 2.0 * bend + first) / 60.0
    series = mean + bend / 12.0
    series = series + np.cross(first - 20.0 * mean - bend, slope + second) / 240.0
    turns: Floats = sign * series
    return turns


def _then(earlier: Floats, later: Floats, frame: str) -> Floats:
    """Product of two turns: in the body frame the later turn is the right factor."""
    if frame == "body":
        return quaternion_product(earlier, later)
    return quaternion_product(later, earlier)


def _largest_angle(left: Floats, right: Floats) -> float:
    apart = quaternion_product(conjugate(left), right)
    sines = np.linalg.norm(apart[..., 1:], axis=-1)
    return float(np.max(2.0 * np.arctan2(sines, np.abs(apart[..., 0])), initial=0.0))
