"""Satellites on a circular orbit: libration about the position of rest, and the Jacobi integral."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, shaped
from .._checks.arrays import AttitudeLike, Floats, attitudes, vectors
from .._libration import frequencies, squares
from ..model.body_like import BodyLike, moments_of
from ..model.orbit import Orbit
from ..model.orbit_axes import Axes, at_rest, checked_axes, rest_axes
from ..model.scene import Scene, check_scene
from ..rotations.apply import to_body


@dataclass(frozen=True, slots=True, eq=False)
class Libration:
    """Small oscillations of a satellite or a moon about rest on its orbit.

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
    reason : ndarray of str, shape (...)
        What is unstable or neutral, where a frequency is NaN; ``""`` where none is.
    axes : ndarray of int, shape (..., 2)
        The body axes at rest along the line from the planet (yaw) and along the normal of the orbit
        (pitch).
    """

    pitch: Floats
    roll_yaw: Floats
    stable: NDArray[np.bool_]
    region: NDArray[np.str_]
    reason: NDArray[np.str_]
    axes: NDArray[np.intp]


def libration(body: BodyLike, rate: ArrayLike, *, axes: Axes | None = None) -> Libration:
    """Frequencies of roll, pitch and yaw of a body whose axes lie along its circular orbit.

    At rest roll is about the axis along the motion, pitch about the axis along the normal of the
    orbit, yaw about the axis along the line from the planet. With ``k1 = (I_pitch - I_yaw)/I_roll``
    and ``k3 = (I_pitch - I_roll)/I_yaw`` the squares of the frequencies of roll and yaw, over the
    square of the orbital rate, are the roots of ``x² - (1 + 3 k1 + k1 k3) x + 4 k1 k3``
    (Hughes, *Spacecraft Attitude Dynamics*, 1986, § 9.2; DeBra and Delp, *J. Astronaut. Sci.* 8
    (1961) 14-17).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²).
    rate : array_like, shape (...)
        Rate of the orbit (rad/s), positive.
    axes : (int, int), optional
        The body axes along the line from the planet and along the normal. By default the long axis,
        of the smallest moment, and the axis of the largest moment: the rest of least energy.

    Returns
    -------
    Libration

    Raises
    ------
    ValueError
        If the moments are impossible, the rate is not positive, or the axes are no two axes.

    Examples
    --------
    >>> import rigid
    >>> found = rigid.free.libration((2.0, 2.1, 0.3), rate=1e-3)
    >>> found.axes.tolist(), str(found.region)
    ([3, 2], 'Lagrange')
    >>> round(float(found.pitch), 6), found.roll_yaw.round(6).tolist()
    (0.001558, [0.001917, 0.000572])
    >>> str(rigid.free.libration((2.0, 2.1, 0.3), rate=1e-3, axes=(2, 3)).reason)
    'pitch is unstable; roll and yaw are unstable'
    """
    moments = np.asarray(moments_of(body))
    n = shaped("rate", rate, positive=True)
    if axes is None:
        long = moments.argmin(axis=-1)
        # Of a sphere any other axis.
        others = np.where(np.arange(3) == long[..., np.newaxis], -np.inf, moments)
        chosen = np.stack([long, others.argmax(axis=-1)], axis=-1) + 1
    else:
        chosen = np.broadcast_to(np.array(checked_axes(axes)), (*moments.shape[:-1], 2))
    places = np.abs(chosen) - 1
    yaw, pitch = np.moveaxis(np.take_along_axis(moments, places, axis=-1), -1, 0)
    roll = np.take_along_axis(moments, 3 - places.sum(axis=-1, keepdims=True), axis=-1)[..., 0]
    swing, fast, slow = frequencies(roll, pitch, yaw)
    square, _, product = squares(roll, pitch, yaw)
    coupled = np.stack([fast, slow], axis=-1)
    stable = np.isfinite(swing) & np.isfinite(fast)
    region = np.where(stable, np.where(pitch > roll, "Lagrange", "DeBra-Delp"), "")
    in_pitch = np.where(square == 0.0, "pitch is neutral", "pitch is unstable")
    in_both = np.where(product == 0.0, "roll and yaw are neutral", "roll and yaw are unstable")
    reason = np.select(
        [stable, np.isfinite(fast), np.isfinite(swing)],
        ["", in_pitch, in_both],
        np.char.add(np.char.add(in_pitch, "; "), in_both),
    )
    return Libration(n * swing, n[..., np.newaxis] * coupled, stable, region, reason, chosen)


def jacobi_integral(scene: Scene, omega: ArrayLike, attitude: AttitudeLike, t: ArrayLike) -> Floats:
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
    orbit = _orbit_of(scene)
    if orbit.eccentricity:
        raise ValueError(
            f"orbit = {orbit}: the Jacobi integral is constant on a circle; take the orbit with "
            "eccentricity 0, or compare run.energy()"
        )
    rates, turned, times = vectors("omega", omega), attitudes(attitude), shaped("t", t)
    moments = np.asarray(scene.body.moments)
    o, normal = radial(orbit, turned, times), to_body(turned, np.asarray(orbit.normal))
    if scene.tables:
        raise ValueError(f"scene = {scene.words()}: no Jacobi integral is constant under a table")
    momentum = moments * rates + (0.0 if scene.rotor is None else np.asarray(scene.rotor))
    twice = np.sum(moments * (rates**2 + 3.0 * orbit.rate**2 * o**2), axis=-1)
    energy: Floats = 0.5 * twice - orbit.rate * np.sum(normal * momentum, axis=-1)
    return energy


def roll_pitch_yaw(
    scene: Scene | Orbit,
    attitude: AttitudeLike,
    t: ArrayLike,
    *,
    axes: Axes | None = None,
) -> Floats:
    """Roll, pitch and yaw of a body on an orbit (rad), shape (..., 3).

    The attitude follows from rest by a 3-2-1 sequence: by yaw about the body axis along the line
    from the planet, then by pitch about the one along the normal, then by roll about the one along
    the motion. So they are zero of a body at rest on its orbit.

    Parameters
    ----------
    scene : FreeBody or Orbit
        One body on an orbit, or an orbit alone.
    attitude : array_like, shape (..., 4), or scipy Rotation
        Attitudes of the principal axes. For a run with ``frame=`` take the
        attitudes of ``run.in_frame(None)``, or name the axes of the drawing by ``axes``.
    t : array_like, shape (...)
        Times (s) of the attitudes.
    axes : (int, int), optional
        As in :func:`libration`: the body axes at rest along the line from the planet and along the
        normal. A negative axis has the opposite direction. An orbit alone needs them, and so does a
        body with two equal smallest or largest moments.

    Returns
    -------
    ndarray, shape (..., 3)
        Roll and yaw from -pi to pi, pitch from -pi/2 to pi/2.

    Raises
    ------
    ValueError
        If there is no orbit, the axes are needed or are no two axes, the shapes do not broadcast,
        or an attitude is zero.

    Examples
    --------
    A moon, its long axis along the line to the planet and its short one along the normal:

    >>> import rigid
    >>> moon = rigid.FreeBody(rigid.Body.ellipsoid(1.3, 1.1, 1.0), orbit=rigid.Orbit(1.0))
    >>> rigid.free.roll_pitch_yaw(moon, [1.0, 0.0, 0.0, 0.0], 0.0).tolist()
    [0.0, 0.0, 0.0]
    >>> rigid.free.roll_pitch_yaw(moon, [1.0, 0.0, 0.0, 0.0], 0.2).round(3).tolist()
    [0.0, -0.2, 0.0]
    >>> at_rest = [0.5, 0.5, 0.5, 0.5]  # axes 1, 2, 3 along y, z, x
    >>> rigid.free.roll_pitch_yaw(rigid.Orbit(1.0), at_rest, 0.0, axes=(3, 2)).tolist()
    [0.0, 0.0, 0.0]
    """
    body, orbit = (None, scene) if isinstance(scene, Orbit) else (scene, _orbit_of(scene))
    directions = at_rest(rest_axes(body) if axes is None else checked_axes(axes)).T
    turned, times = attitudes(attitude), shaped("t", t)
    along, normal, radial = (
        to_body(turned, orbit.frame(times)[..., column]) @ directions for column in (1, 2, 0)
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


def _orbit_of(scene: Scene) -> Orbit:
    orbit = check_scene(scene).orbit
    if orbit is None:
        raise ValueError(f"scene = {brief(scene)}: has no orbit; give rigid.FreeBody one by orbit=")
    return orbit


def radial(orbit: Orbit, attitude: Floats, t: Floats) -> Floats:
    """The unit vector from the planet to the body, in body axes at times ``t``, shape (..., 3)."""
    return to_body(attitude, orbit.frame(t)[..., 0])
