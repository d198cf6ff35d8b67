"""Constants of motion of a heavy top, Euler rates at a tilt, and the torque of the weight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import one_of, require, shaped
from .._checks.arrays import AttitudeLike, Floats, attitudes
from .._checks.overflow import refuses_overflow
from ..exact.symmetry import Symmetry, require_each, symmetry_of
from ..free import invariants
from ..model.batch import Shape, batch_shape
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..rotations.apply import to_body, to_space


def symmetric(scene: HeavyTop) -> Symmetry:
    """The symmetry of tops on which nothing but weight acts; ValueError if a top has none."""
    require_unforced(check_heavy_top(scene, many=True), "a formula with constants of motion")
    symmetry = symmetry_of(scene)
    rule = (
        "a symmetric top has two exactly equal moments and its centre of mass exactly on the "
        "third axis"
    )
    require_each(scene, symmetry.axis != 0, rule, ("moments", "com"))
    return symmetry


def over_tops(scene: HeavyTop, *, times: Shape = (), **arguments: ArrayLike) -> tuple[Floats, ...]:
    """The finite arguments, broadcast to the axes of the tops and of each other.

    ``times`` has the axes of the tops that the times have.
    """
    arrays = {name: shaped(name, value) for name, value in arguments.items()}
    shapes = {name: array.shape for name, array in arrays.items()}
    shape = batch_shape({"scene": scene.shape, **shapes, "t": times})
    return tuple(np.broadcast_to(array, shape) for array in arrays.values())


def tilts(tilt: ArrayLike) -> Floats:
    """Angles of the centre of mass from the upward vertical, in [0, pi]."""
    angles = shaped("tilt", tilt)
    require("tilt", angles, (angles >= 0.0) & (angles <= np.pi), "must lie in [0, pi] (rad)")
    return angles


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeavyConstants:
    """Constants of motion of a heavy top, or of many.

    Constants of symmetric tops are None for another top, and NaN for another top among many.

    Attributes
    ----------
    kinetic, potential : ndarray, shape (...)
        Kinetic and potential energy in the given state (J); they are not constant.
    energy : ndarray, shape (...)
        ``E = T + V`` (J).
    p_phi : ndarray, shape (...)
        Angular momentum about the upward vertical (kg m²/s).
    p_psi : ndarray, shape (...), or None
        Angular momentum about the direction to the centre of mass, ``I3 omega3`` (kg m²/s).
    E_prime : ndarray, shape (...), or None
        ``E - p_psi² / (2 I3)``, the energy of the nutation (J).
    a, b : ndarray, shape (...), or None
        ``p_phi / I1`` and ``p_psi / I1`` (rad/s).
    alpha, beta : ndarray, shape (...), or None
        ``2 E' / I1`` and ``2 mgl / I1`` (1/s²).
    """

    kinetic: Floats
    potential: Floats
    energy: Floats
    p_phi: Floats
    p_psi: Floats | None
    E_prime: Floats | None
    a: Floats | None
    b: Floats | None
    alpha: Floats | None
    beta: Floats | None


@refuses_overflow
def heavy_constants(scene: HeavyTop, omega: ArrayLike, attitude: AttitudeLike) -> HeavyConstants:
    """Energy and angular momenta of a heavy top, and the constants a, b, alpha, beta.

    Under further forces they are the values of the given states, and change with time. Goldstein,
    *Classical Mechanics*, § 5.7; Landau and Lifshitz, *Mechanics*, § 35. Ercan 2016, eqs.
    (54)-(60), with the moment I1 in both terms of the energy (erratum D-32), and with a instead of
    b on the right side before eq. (57) (D-31).

    Parameters
    ----------
    scene : HeavyTop
        The top, or many. If the top is not symmetric, only the energy and the angular momentum
        about the vertical are constant.
    omega : array_like, shape (..., 3)
        Angular velocity in the body (rad/s); its leading axes broadcast with the attitudes
        and of the tops.
    attitude : array_like, shape (..., 4), or scipy Rotation
        Attitude.

    Returns
    -------
    HeavyConstants

    Raises
    ------
    TypeError
        If the scene is no heavy top.
    ValueError
        If a value is not finite or has the wrong shape, or the axes of the tops, rates and
        attitudes do not broadcast.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]  # by 60 degrees
    >>> found = rigid.top.heavy_constants(scene, [0.0, 0.0, 5.0], tilted)
    >>> round(float(found.a), 12), float(found.b), round(float(found.E_prime), 12)
    (1.25, 2.5, 0.5)
    >>> tops = rigid.HeavyTop(scene.body, mgl=[1.0, 2.0])
    >>> rigid.top.heavy_constants(tops, [0.0, 0.0, 5.0], tilted).beta.tolist()
    [2.0, 4.0]
    """
    symmetry = symmetry_of(check_heavy_top(scene, many=True))
    kept = invariants(scene, omega, attitude)
    assert kept.p_phi is not None  # there is an attitude
    assert kept.p_psi is not None  # of a heavy top
    named: dict[str, Floats | None]
    if not scene.shape and not symmetry.axis:
        named = dict.fromkeys(("p_psi", "E_prime", "a", "b", "alpha", "beta"))
    else:
        i1 = symmetry.across
        # From squares of the other two rates: E - p_psi² / (2 I3) loses all digits of fast tops.
        others = (symmetry.axis[..., np.newaxis] + np.array([0, 1])) % 3
        others = np.broadcast_to(others, (*kept.L_body.shape[:-1], 2))
        rates = np.take_along_axis(kept.L_body, others, axis=-1) / i1[..., np.newaxis]
        e_prime = np.asarray(0.5 * i1 * (rates * rates).sum(axis=-1) + kept.potential)
        named = {
            "p_psi": np.where(symmetry.axis == 0, np.nan, kept.p_psi)[()],
            "E_prime": e_prime[()],
            "a": kept.p_phi / i1,
            "b": kept.p_psi / i1,
            "alpha": (2.0 * e_prime / i1)[()],
            "beta": np.array(np.broadcast_to(2.0 * scene.mgl / i1, e_prime.shape))[()],
        }
    return HeavyConstants(
        kinetic=kept.kinetic,
        potential=kept.potential,
        energy=kept.energy,
        p_phi=kept.p_phi,
        **named,
    )


@refuses_overflow
def precession_spin_rates(
    scene: HeavyTop, tilt: ArrayLike, *, a: ArrayLike, b: ArrayLike
) -> tuple[Floats, Floats]:
    """Precession ``phi'`` and spin ``psi'`` (rad/s) of a symmetric top at a tilt.

    ``phi' = (a - b cos) / sin²`` and ``psi' = I1 b / I3 - phi' cos``: Goldstein, *Classical
    Mechanics*, § 5.7; Ercan 2016, eqs. (57), (58).

    Parameters
    ----------
    scene : HeavyTop
        Two moments exactly equal, the centre of mass exactly on the third axis; one top or many.
    tilt : array_like, shape (...)
        Angle of the centre of mass from the upward vertical (rad), in [0, pi].
    a, b : array_like, shape (...)
        Constants of :func:`heavy_constants` (rad/s). They broadcast with the tilt and the tops.

    Returns
    -------
    precession, spin : ndarray, shape (...)
        Rates (rad/s). At tilt 0, which only a top with ``a = b`` reaches, the limit
        ``phi' = b / 2``; at tilt pi, which only a top with ``a = -b`` reaches, ``phi' = -b / 2``.

    Raises
    ------
    ValueError
        If no top with these constants reaches the tilt 0 or pi, or an argument is not finite or out
        of range.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> rates = rigid.top.precession_spin_rates(scene, 0.0, a=2.5, b=2.5)
    >>> [float(rate) for rate in rates]
    [1.25, 3.75]
    """
    symmetry = symmetric(scene)
    angle, first, second = over_tops(scene, tilt=tilts(tilt), a=a, b=b)
    upper = angle < 0.5 * np.pi
    lack = np.where(upper, first - second, first + second)
    vertical = (angle == 0.0) | (angle == np.pi)
    require("tilt", angle, ~vertical | (lack == 0.0), "is reached only if a = b, and pi if a = -b")
    # a - b cos = (a - b) + b (1 - cos) = (a + b) - b (1 + cos): use the form that does not cancel.
    sine = np.where(vertical, 1.0, np.sin(angle))
    half = np.where(upper, np.cos(0.5 * angle), np.sin(0.5 * angle))
    precession = lack / sine**2 + np.where(upper, 0.5, -0.5) * second / half**2
    spin = symmetry.across * second / symmetry.along - precession * np.cos(angle)
    return precession[()], spin[()]


def gravity_torque(scene: HeavyTop, attitude: AttitudeLike, *, frame: str = "body") -> Floats:
    """Torque of the weight about the fixed point (N m), ``-mgl com × gamma``.

    The torque has the size ``mgl sin(tilt)`` and the direction of the node line. So it is
    perpendicular to the vertical and to the direction to the centre of mass (Ercan 2016, § 10).

    Parameters
    ----------
    scene : HeavyTop
        Any heavy top, or many.
    attitude : array_like, shape (..., 4), or scipy Rotation
        Attitude; its leading axes broadcast with the axes of the tops.
    frame : {"body", "space"}
        Frame of the components of the torque.

    Returns
    -------
    ndarray, shape (..., 3)
        Torque (N m).

    Raises
    ------
    TypeError
        If the scene is no heavy top.
    ValueError
        If the attitude is not finite or is zero, its axes do not broadcast with the axes of the
        tops, or the frame is unknown.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=2.0)
    >>> lying = [0.5**0.5, 0.5**0.5, 0.0, 0.0]  # by 90 degrees about the node line, axis 1
    >>> torque = rigid.top.gravity_torque(scene, lying, frame="space")
    >>> bool(np.allclose(torque, [2.0, 0.0, 0.0]))
    True
    """
    check_heavy_top(scene, many=True)
    one_of("frame", frame, ("body", "space"))
    quaternions = attitudes(attitude)
    batch_shape({"scene": scene.shape, "attitude": quaternions.shape[:-1]})
    weight = np.broadcast_to(scene.weight, (*scene.shape, 3))
    up = np.array([0.0, 0.0, 1.0])
    if frame == "body":
        return np.cross(to_body(quaternions, up), weight)
    return np.cross(up, to_space(quaternions, weight))
