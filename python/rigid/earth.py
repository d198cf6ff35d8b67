"""The free precession of the Earth as a rigid body."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from ._checks.arguments import require, shaped
from ._checks.arrays import Floats
from ._checks.overflow import refuses_overflow
from .free.tops import cone_angles

__all__ = [
    "MEAN_RADIUS",
    "SIDEREAL_DAY",
    "SOLAR_DAY",
    "Wobble",
    "ellipsoid_moments",
    "ellipticity",
    "euler_period",
    "rotation_rate",
    "wobble",
]


SOLAR_DAY = 86400.0
"""The mean solar day (s), from noon to noon."""

SIDEREAL_DAY = 86164.0905
"""The sidereal day (s): the time of one turn of the Earth. Use this day for rates of rotation."""

MEAN_RADIUS = 6371e3
"""Mean radius of the Earth (m)."""


def rotation_rate(day: ArrayLike = SIDEREAL_DAY) -> Floats:
    """Rate of one turn in a day (rad/s).

    Buller and Wernstål 2011, § 2, use the solar day (erratum S-08), and so miss one turn in 366.

    Parameters
    ----------
    day : array_like, shape (...)
        Length of the day (s), positive; the sidereal day by default.

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    ValueError
        If a day is not finite and positive.

    Examples
    --------
    >>> from rigid import earth
    >>> f"{earth.rotation_rate():.7e}, {earth.rotation_rate(earth.SOLAR_DAY):.7e}"
    '7.2921159e-05, 7.2722052e-05'
    """
    days = shaped("day", day, positive=True)
    return np.asarray(2.0 * pi / days)[()]


@refuses_overflow
def ellipsoid_moments(polar_radius: float, equatorial_radius: float, mass: float = 1.0) -> Floats:
    """Moments of a homogeneous ellipsoid of revolution, ``m (Rp² + Re²)/5`` and ``2 m Re²/5``.

    Parameters
    ----------
    polar_radius, equatorial_radius : float
        Semi axes (m), positive.
    mass : float, optional
        Mass (kg), positive.

    Returns
    -------
    ndarray, shape (3,)
        ``(I0, I0, Iz)`` (kg m²).

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    Examples
    --------
    >>> from rigid import earth
    >>> earth.ellipsoid_moments(1.0, 2.0, mass=5.0).tolist()
    [5.0, 5.0, 8.0]
    """
    polar = shaped("polar_radius", polar_radius, positive=True)
    equator = shaped("equatorial_radius", equatorial_radius, positive=True)
    fifth = shaped("mass", mass, positive=True) / 5.0
    across = fifth * (polar**2 + equator**2)
    return np.array([across, across, 2.0 * fifth * equator**2])


@refuses_overflow
def ellipticity(polar_radius: ArrayLike, equatorial_radius: ArrayLike) -> Floats:
    """``(I3 - I) / I`` of a homogeneous ellipsoid of revolution, from its radii.

    ``(Re² - Rp²) / (Re² + Rp²)``; the function factors the difference, so that a small flattening
    loses no digits. The value of the Earth, which is denser inside, is 0.0032846.

    Parameters
    ----------
    polar_radius, equatorial_radius : array_like, shape (...)
        Semi axes (m), positive.

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    ValueError
        If a radius is not finite and positive.

    Examples
    --------
    >>> from rigid import earth
    >>> round(float(earth.ellipticity(6356752.3, 6378137.0)), 10)
    0.0033584335
    """
    polar = shaped("polar_radius", polar_radius, positive=True)
    equator = shaped("equatorial_radius", equatorial_radius, positive=True)
    flat: Floats = (equator - polar) * (equator + polar) / (equator**2 + polar**2)
    return flat


@refuses_overflow
def euler_period(ellipticity: ArrayLike, rate: ArrayLike) -> Floats:
    """Euler's period, ``2 pi / (|ellipticity| rate)``: the period of the free polar motion.

    Landau and Lifshitz, *Mechanics*, § 36. Ercan 2016, § 9.1, prints 305 d for 0.00329 and
    7.29e-5 rad/s, which give 303.21 d (erratum D-25). The observed period is 433 d, because the
    Earth is not rigid.

    Parameters
    ----------
    ellipticity : array_like, shape (...)
        ``(I3 - I) / I``, > -1.
    rate : array_like, shape (...)
        Rate about the axis (rad/s), positive.

    Returns
    -------
    ndarray, shape (...)
        In s; inf for a sphere.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    Examples
    --------
    >>> from rigid import earth
    >>> round(float(earth.euler_period(0.00329, 7.29e-5) / earth.SOLAR_DAY), 6)
    303.209427
    """
    flat = _ellipticity(ellipticity)
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * pi / (np.abs(flat) * shaped("rate", rate, positive=True)))[()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wobble:
    """The free precession of a slightly oblate body that spins nearly about its symmetry axis.

    Attributes
    ----------
    period : ndarray, shape (...)
        Euler's period, in the body (s).
    precession : ndarray, shape (...)
        Rate of precession of the axis about L in space (rad/s), ``phi' = |L| / I``: about
        ``1 + ellipticity`` times the rate of rotation.
    space_period : ndarray, shape (...)
        Period of this precession (s), nearly a day.
    alpha, theta : ndarray, shape (...)
        Angles of omega and of L from the axis (rad).
    separation : ndarray, shape (...)
        Angle between omega and L (rad), the half angle of the space cone.
    pole_circle, space_circle : ndarray, shape (...)
        Radii (m) of the circles of the pole of rotation at the surface: in the body about the pole
        of the axis, and in space about the pole of L.
    """

    period: Floats
    precession: Floats
    space_period: Floats
    alpha: Floats
    theta: Floats
    separation: Floats
    pole_circle: Floats
    space_circle: Floats


@refuses_overflow
def wobble(
    ellipticity: ArrayLike,
    rate: ArrayLike,
    tilt: ArrayLike,
    *,
    radius: float = MEAN_RADIUS,
) -> Wobble:
    """Periods, angles and circles of the free precession of a symmetric top.

    As :func:`rigid.free.symmetric_free_top`, whose moments would lose digits of the ellipticity of
    a body that is nearly a sphere.

    Ercan 2016, § 9.3, prints ``phi' = 0.00329`` for 1.00329 times the rate (erratum D-26), and a
    circle of the pole of some tens of centimetres, although 0.2 arc seconds give a radius of 6.18 m
    (D-27). The printed period in space, 0.997 d, counts turns of the Earth: it is 0.9943 solar days
    (D-43).

    Parameters
    ----------
    ellipticity : array_like, shape (...)
        ``(I3 - I) / I`` in (-1, 1]; larger values are impossible.
    rate : array_like, shape (...)
        ``|omega|`` (rad/s), positive.
    tilt : array_like, shape (...)
        Angle alpha of omega from the axis (rad), in [0, pi/2].
    radius : float, optional
        Radius of the body (m), positive.

    Returns
    -------
    Wobble

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import earth
    >>> found = earth.wobble(0.00329, 7.29e-5, np.deg2rad(0.2 / 3600))
    >>> round(float(found.pole_circle), 6), f"{found.precession:.7e}"
    (6.177496, '7.3139841e-05')
    """
    flat, speed, angle = np.broadcast_arrays(
        _ellipticity(ellipticity), shaped("rate", rate, positive=True), shaped("tilt", tilt)
    )
    require("ellipticity", flat, flat <= 1.0, "must be at most 1, the value of a flat body")
    require("tilt", angle, (angle >= 0.0) & (angle <= 0.5 * pi), "must lie in [0, pi/2] (rad)")
    size = shaped("radius", radius, positive=True)
    sine, cosine = np.sin(angle), np.cos(angle)
    precession = speed * np.hypot(sine, (1.0 + flat) * cosine)
    theta, separation = cone_angles(sine, cosine, 1.0 + flat, flat)
    return Wobble(
        period=euler_period(flat, speed * cosine),
        precession=precession,
        space_period=2.0 * pi / precession,
        alpha=np.array(angle)[()],
        theta=theta,
        separation=separation,
        pole_circle=size * angle,
        space_circle=size * separation,
    )


def _ellipticity(value: ArrayLike) -> Floats:
    array = shaped("ellipticity", value)
    require("ellipticity", array, array > -1.0, "must be above -1")
    return array
