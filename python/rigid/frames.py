"""Moving frames: motion as seen from a moving frame, and fictitious forces.

The origin of a frame is at ``R`` and moves with the velocity ``V`` and the acceleration ``A``; the
frame turns with the angular velocity ``omega``. The functions do not turn components: all vectors
of a call must have components along the same axes, either the space axes or the momentary axes of
the frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._checks.arguments import finite_float, require, shaped, together, vectors_together
from ._checks.arrays import Floats
from ._checks.overflow import refuses_overflow

__all__ = [
    "EarthFrame",
    "FictitiousForces",
    "PointMotion",
    "earth_frame",
    "fictitious_forces",
    "rotating_frame",
    "translating_frame",
    "transport",
]


_ZERO = (0.0, 0.0, 0.0)

EARTH_RATE = 7.292115e-5
"""Sidereal rotation of the Earth (rad/s): one turn in 86164.1 s, not in 24 h (WGS 84)."""

EARTH_RADIUS = 6.371e6
"""Mean radius of the Earth (m)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointMotion:
    """Position, velocity and acceleration of a point in one frame.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (..., 3)
        In m, m/s and m/s².
    """

    position: Floats
    velocity: Floats
    acceleration: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FictitiousForces:
    """Fictitious forces (N) of a moving frame; each of shape (..., 3).

    Attributes
    ----------
    translation : ndarray
        ``-m A``, from the acceleration of the origin.
    coriolis : ndarray
        ``-2 m omega × v'``.
    centrifugal : ndarray
        ``-m omega × (omega × r')``.
    euler : ndarray
        ``-m omega' × r'``, from the change of the angular velocity.
    """

    translation: Floats
    coriolis: Floats
    centrifugal: Floats
    euler: Floats

    @property
    def total(self) -> Floats:
        """Sum of the forces."""
        return np.asarray(self.translation + self.coriolis + self.centrifugal + self.euler)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EarthFrame:
    """The frame of an observer on the turning Earth: axes to the east, to the north and up.

    Attributes
    ----------
    omega : ndarray, shape (..., 3)
        Rotation of the Earth (rad/s).
    acceleration : ndarray, shape (..., 3)
        Acceleration of the origin, towards the axis of the Earth (m/s²). A plumb line measures
        ``g`` with this acceleration included.
    """

    omega: Floats
    acceleration: Floats


def translating_frame(
    position: ArrayLike,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    *,
    origin: ArrayLike = _ZERO,
    origin_velocity: ArrayLike = _ZERO,
    origin_acceleration: ArrayLike = _ZERO,
    back: bool = False,
) -> PointMotion:
    """Position, velocity and acceleration relative to a frame that does not turn.

    ``r' = r - R``, ``v' = v - V``, ``a' = a - A``; in the frame Newton's law has the additional
    force ``-m A`` (Landau and Lifshitz, *Mechanics*, § 39; Ercan 2016, eqs. (8)–(11)).

    Parameters
    ----------
    position, velocity, acceleration : array_like, shape (..., 3)
        Motion of the point (m, m/s, m/s²) seen from space; with ``back``, seen from the frame.
    origin, origin_velocity, origin_acceleration : array_like, shape (..., 3)
        Motion of the origin of the frame, seen from space.
    back : bool
        Whether to transform from the frame to space.

    Returns
    -------
    PointMotion
        Seen from the frame; with ``back``, seen from space.

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import frames
    >>> lamp = frames.translating_frame(  # in a lift that falls freely
    ...     [0, 0, 2], [0, 0, 0], [0, 0, 0], origin_acceleration=[0, 0, -9.81]
    ... )
    >>> lamp.acceleration.tolist()
    [0.0, 0.0, 9.81]
    """
    return rotating_frame(
        position,
        velocity,
        acceleration,
        omega=_ZERO,
        origin=origin,
        origin_velocity=origin_velocity,
        origin_acceleration=origin_acceleration,
        back=back,
    )


@refuses_overflow
def rotating_frame(
    position: ArrayLike,
    velocity: ArrayLike,
    acceleration: ArrayLike = _ZERO,
    *,
    omega: ArrayLike,
    omega_dot: ArrayLike = _ZERO,
    origin: ArrayLike = _ZERO,
    origin_velocity: ArrayLike = _ZERO,
    origin_acceleration: ArrayLike = _ZERO,
    back: bool = False,
) -> PointMotion:
    """Position, velocity and acceleration relative to a frame that turns and whose origin moves.

    ``v = V + v' + omega × r'`` and
    ``a = A + a' + 2 omega × v' + omega' × r' + omega × (omega × r')`` with the arm ``r' = r - R``
    (Landau and Lifshitz, *Mechanics*, § 39; Ercan 2016, eqs. (17), (18), where the arm lacks its
    prime, erratum D-06).

    Parameters
    ----------
    position, velocity, acceleration : array_like, shape (..., 3)
        Motion of the point (m, m/s, m/s²) seen from space; with ``back``, seen from the frame.
    omega, omega_dot : array_like, shape (..., 3)
        Angular velocity of the frame (rad/s) and its derivative (rad/s²), the same in both frames.
    origin, origin_velocity, origin_acceleration : array_like, shape (..., 3)
        Motion of the origin of the frame, seen from space.
    back : bool
        Whether to transform from the frame to space.

    Returns
    -------
    PointMotion
        Seen from the frame; with ``back``, seen from space. Components are along the axes of the
        arguments.

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import frames
    >>> rider = frames.rotating_frame([2, 0, 0], [0, 6, 0], [-18, 0, 0], omega=[0, 0, 3])
    >>> rider.velocity.tolist(), rider.acceleration.tolist()  # at rest on the carousel
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    """
    r, v, a, w, dw, r0, v0, a0 = vectors_together(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        omega=omega,
        omega_dot=omega_dot,
        origin=origin,
        origin_velocity=origin_velocity,
        origin_acceleration=origin_acceleration,
    )
    arm = r if back else r - r0
    carried = v0 + np.cross(w, arm)
    own = v if back else v - carried
    dragged = a0 + 2.0 * np.cross(w, own) + np.cross(dw, arm) + np.cross(w, np.cross(w, arm))
    if back:
        return PointMotion(position=r + r0, velocity=v + carried, acceleration=a + dragged)
    return PointMotion(position=arm, velocity=own, acceleration=a - dragged)


@refuses_overflow
def transport(vector: ArrayLike, rate: ArrayLike, omega: ArrayLike) -> Floats:
    """Rate of change of a vector, seen from space: ``dQ/dt = δQ/δt + omega × Q``.

    Landau and Lifshitz, *Mechanics*, § 36; Goldstein, *Classical Mechanics*, § 4.9; Ercan 2016,
    eqs. (16), (19). Pass ``-omega`` to go from space to the frame. The rate of change of ``omega``
    itself is the same in both.

    Parameters
    ----------
    vector : array_like, shape (..., 3)
        The vector ``Q``.
    rate : array_like, shape (..., 3)
        Rate of change ``δQ/δt`` of ``Q`` seen from the frame.
    omega : array_like, shape (..., 3)
        Angular velocity of the frame (rad/s).

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import frames
    >>> frames.transport([1, 0, 0], [0, 0, 0], omega=[0, 0, 2]).tolist()
    [0.0, 2.0, 0.0]
    """
    q, dq, w = vectors_together(vector=vector, rate=rate, omega=omega)
    return np.asarray(dq + np.cross(w, q))


@refuses_overflow
def fictitious_forces(
    mass: ArrayLike,
    position: ArrayLike = _ZERO,
    velocity: ArrayLike = _ZERO,
    *,
    omega: ArrayLike = _ZERO,
    omega_dot: ArrayLike = _ZERO,
    acceleration: ArrayLike = _ZERO,
) -> FictitiousForces:
    """The fictitious forces (N) on a particle in a moving frame: Coriolis, centrifugal and others.

    Landau and Lifshitz, *Mechanics*, § 39; Goldstein, *Classical Mechanics*, § 4.10. The force of
    the accelerated origin is eq. (11) of Ercan 2016.

    Parameters
    ----------
    mass : array_like, shape (...)
        Mass (kg) of the particle, >= 0.
    position, velocity : array_like, shape (..., 3)
        Position and velocity seen from the frame (m, m/s).
    omega, omega_dot : array_like, shape (..., 3)
        Angular velocity of the frame (rad/s) and its derivative (rad/s²).
    acceleration : array_like, shape (..., 3)
        Acceleration of the origin, seen from space (m/s²).

    Returns
    -------
    FictitiousForces

    Raises
    ------
    ValueError
        If the mass is negative, or an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import frames
    >>> rider = frames.fictitious_forces(70.0, [2, 0, 0], [0, -1, 0], omega=[0, 0, 3])
    >>> float(rider.centrifugal[0]), float(rider.coriolis[0])
    (1260.0, -420.0)
    """
    m = shaped("mass", mass, nonnegative=True)
    r, v, w, dw, a = vectors_together(
        position=position,
        velocity=velocity,
        omega=omega,
        omega_dot=omega_dot,
        acceleration=acceleration,
    )
    m, r, v, w, dw, a = together(
        mass=m[..., np.newaxis], position=r, velocity=v, omega=w, omega_dot=dw, acceleration=a
    )
    return FictitiousForces(
        translation=-m * a,
        coriolis=-2.0 * m * np.cross(w, v),
        centrifugal=-m * np.cross(w, np.cross(w, r)),
        euler=-m * np.cross(dw, r),
    )


def earth_frame(
    latitude: ArrayLike, *, rate: float = EARTH_RATE, radius: float = EARTH_RADIUS
) -> EarthFrame:
    """The frame of an observer at a geographical latitude: axes to the east, to the north and up.

    ``omega = rate (0, cos latitude, sin latitude)``; the Earth as a sphere.

    Parameters
    ----------
    latitude : array_like, shape (...)
        Geographical latitude (rad), in [-pi/2, pi/2], north positive.
    rate : float
        Angular velocity of the planet (rad/s). Default: sidereal rotation of the Earth.
    radius : float
        Distance (m) of the observer from the centre, >= 0.

    Returns
    -------
    EarthFrame
        Pass its ``omega`` and ``acceleration`` to :func:`fictitious_forces`.

    Raises
    ------
    ValueError
        If the latitude is out of range or an argument is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import frames
    >>> paris = frames.earth_frame(np.radians(48.85))
    >>> hours = 2 * np.pi / (3600 * paris.omega[2])  # Foucault's pendulum, by the upward rate
    >>> round(float(hours), 1)
    31.8
    """
    angle = shaped("latitude", latitude)
    require("latitude", angle, np.abs(angle) <= 0.5 * np.pi, "must lie in [-pi/2, pi/2] (rad)")
    spin, arm = finite_float("rate", rate), finite_float("radius", radius, nonnegative=True)
    north, up, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    omega = spin * np.stack([zero, north, up], axis=-1)
    place = arm * np.stack([zero, zero, np.ones_like(angle)], axis=-1)
    return EarthFrame(omega=omega, acceleration=np.cross(omega, np.cross(omega, place)))
