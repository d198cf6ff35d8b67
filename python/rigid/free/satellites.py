"""Satellites on a circular orbit: libration about the position of rest, and the Jacobi integral."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, shaped
from .._checks.arrays import attitudes, vectors
from .._libration import frequencies
from ..model.body_like import BodyLike, moments_of
from ..model.orbit import Orbit
from ..model.scene import Scene, check_scene
from ..rotations.apply import to_body

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Libration", "jacobi_integral", "libration", "radial", "roll_pitch_yaw"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Libration:
    """Small oscillations of a satellite about rest on its orbit, in units of ``rate``.

    Attributes
    ----------
    pitch : ndarray, shape (...)
        Frequency about the normal of the orbit (rad/s), ``n sqrt(3 (I_roll - I_yaw) / I_pitch)``;
        NaN where rest is unstable in pitch.
    roll_yaw : ndarray, shape (..., 2)
        Both frequencies (rad/s) of the coupled motion of roll and yaw, the larger first; NaN where
        rest is unstable in them.
    stable : ndarray of bool, shape (...)
        Whether all of them are real and not zero.
    region : ndarray of str, shape (...)
        ``"Lagrange"`` where rest has the least energy, so that dissipation leaves it stable;
        ``"DeBra-Delp"`` where it is stable without dissipation only; else ``""``.
    """

    pitch: Floats
    roll_yaw: Floats
    stable: NDArray[np.bool_]
    region: NDArray[np.str_]


def libration(body: BodyLike, rate: ArrayLike) -> Libration:
    """Frequencies of roll, pitch and yaw of a satellite whose axes lie along its circular orbit.

    At rest axis 1 (roll) lies along the motion, axis 2 (pitch) along the normal of the orbit, axis
    3 (yaw) along the line from the planet, as in :func:`roll_pitch_yaw`. With
    ``k1 = (I2 - I3)/I1`` and ``k3 = (I2 - I1)/I3`` the squares of the frequencies of roll and yaw,
    over the square of the orbital rate, are the roots of ``x² - (1 + 3 k1 + k1 k3) x + 4 k1 k3``
    (Hughes, *Spacecraft Attitude Dynamics*, 1986, § 9.2; DeBra and Delp, *J. Astronaut. Sci.* 8
    (1961) 14-17).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or its moments (kg m²) of roll, pitch and yaw.
    rate : array_like, shape (...)
        Rate of the orbit (rad/s), positive.

    Returns
    -------
    Libration

    Raises
    ------
    ValueError
        If the moments are impossible, or the rate is not positive.

    Examples
    --------
    >>> import rigid
    >>> found = rigid.free.libration((2.0, 2.1, 0.3), rate=1e-3)
    >>> round(float(found.pitch), 6), found.roll_yaw.round(6).tolist(), str(found.region)
    (0.001558, [0.001917, 0.000572], 'Lagrange')
    """
    moments = moments_of(body)
    n = shaped("rate", rate, positive=True)
    roll, pitch, yaw = np.moveaxis(np.asarray(moments, dtype=np.float64), -1, 0)
    swing, fast, slow = frequencies(roll, pitch, yaw)
    coupled = np.stack([fast, slow], axis=-1)
    stable = np.isfinite(swing) & np.isfinite(fast)
    region = np.where(stable, np.where(pitch > roll, "Lagrange", "DeBra-Delp"), "")
    return Libration(n * swing, n[..., np.newaxis] * coupled, stable, region)


def jacobi_integral(
    scene: Scene, omega: ArrayLike, attitude: ArrayLike | Rotation, t: ArrayLike
) -> Floats:
    """Energy of a satellite in the frame of its circular orbit (J); constant without other forces.

    ``omega·I omega / 2 + 3 n² o·I o / 2 - n N·L``, with the direction ``o`` from the planet, the
    normal ``N`` and the rate ``n`` of the orbit, and the angular momentum ``L``, with the part of a
    rotor (Hughes, *Spacecraft Attitude Dynamics*, 1986, § 9.2). It falls by dissipation.

    Parameters
    ----------
    scene : FreeBody
        One satellite on a circular orbit.
    omega : array_like, shape (..., 3)
        Angular velocities in the body (rad/s).
    attitude : array_like, shape (..., 4), or scipy Rotation
        Attitudes.
    t : array_like, shape (...)
        Times (s) of the states.

    Returns
    -------
    ndarray, shape (...)
        Energy (J).

    Raises
    ------
    ValueError
        If there is no orbit, the orbit is not circular (nothing is constant on an ellipse), or the
        shapes do not broadcast.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)), orbit=rigid.Orbit(0.1))
    >>> t = np.linspace(0.0, 500.0, 6)
    >>> run = rigid.simulate(scene, [0.1, 0.2, 0.3], t=t, accuracy=1e-9)
    >>> jacobi = rigid.free.jacobi_integral(scene, run.omega, run.attitude, t)
    >>> bool(np.ptp(jacobi) < 1e-9 * run.energy()[0])
    True
    """
    orbit = check_scene(scene).orbit
    if orbit is None:
        raise ValueError(f"scene = {brief(scene)}: has no orbit; give rigid.FreeBody one by orbit=")
    if orbit.eccentricity:
        raise ValueError(
            f"orbit = {orbit}: the Jacobi integral is constant on a circle; take the orbit with "
            "eccentricity 0, or compare run.energy()"
        )
    rates, turned, times = vectors("omega", omega), attitudes(attitude), shaped("t", t)
    moments = np.asarray(scene.body.moments)
    o, normal = radial(orbit, turned, times), to_body(turned, np.asarray(orbit.normal))
    momentum = moments * rates + (0.0 if scene.rotor is None else np.asarray(scene.rotor))
    twice = np.sum(moments * (rates**2 + 3.0 * orbit.rate**2 * o**2), axis=-1)
    energy: Floats = 0.5 * twice - orbit.rate * np.sum(normal * momentum, axis=-1)
    return energy


def roll_pitch_yaw(orbit: Orbit, attitude: ArrayLike | Rotation, t: ArrayLike) -> Floats:
    """Roll, pitch and yaw of a body on an orbit (rad), shape (..., 3).

    The attitude follows from the directions *along*, *normal* and *radial* of :meth:`Orbit.frame`,
    turned by yaw about *radial*, then by pitch about the new axis 2, then by roll about the new
    axis 1: a 3-2-1 sequence. They are zero if body axes 1, 2, 3 lie along these directions.

    Parameters
    ----------
    orbit : Orbit
        One orbit.
    attitude : array_like, shape (..., 4), or scipy Rotation
        Attitudes.
    t : array_like, shape (...)
        Times (s) of the attitudes.

    Returns
    -------
    ndarray, shape (..., 3)
        Roll and yaw from -pi to pi, pitch from -pi/2 to pi/2.

    Raises
    ------
    ValueError
        If the shapes do not broadcast, or an attitude is zero.

    Examples
    --------
    >>> import rigid
    >>> at_rest = [0.5, 0.5, 0.5, 0.5]  # axes 1, 2, 3 along y, z, x
    >>> rigid.free.roll_pitch_yaw(rigid.Orbit(1.0), at_rest, 0.0).tolist()
    [0.0, 0.0, 0.0]
    >>> rigid.free.roll_pitch_yaw(rigid.Orbit(1.0), at_rest, 0.2).round(3).tolist()
    [0.0, -0.2, 0.0]
    """
    turned, times = attitudes(attitude), shaped("t", t)
    along, normal, radial = (
        to_body(turned, orbit.frame(times)[..., column]) for column in (1, 2, 0)
    )
    angles: Floats = np.stack(
        [
            np.arctan2(radial[..., 1], radial[..., 2]),
            np.arcsin(np.clip(-radial[..., 0], -1.0, 1.0)),
            np.arctan2(normal[..., 0], along[..., 0]),
        ],
        axis=-1,
    )
    return angles + 0.0  # no negative zeros


def radial(orbit: Orbit, attitude: Floats, t: Floats) -> Floats:
    """The unit vector from the planet to the body, in body axes at times ``t``, shape (..., 3)."""
    return to_body(attitude, orbit.frame(t)[..., 0])
