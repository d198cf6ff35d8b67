"""Tumbling bodies by the two periods that observers publish: the state from periods, and back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import first_place, one_of, require, shaped
from .._checks.arrays import Floats, of_size_one, unit_vectors, vectors
from .._checks.overflow import refuses_overflow
from .._checks.shown import short_repr
from ..model.body import Body
from ..model.body_like import BodyLike, moments_of
from ..model.scene import FreeBody
from ..rotations import euler_to_matrix, matrix_to_quaternion, rotation_z
from ..solve.simulate import simulate
from .tops import asymmetric_free_top

MODES = ("SAM", "LAM")
"""Short-axis mode and long-axis mode: which axis the angular velocity encircles in the body."""

FIRST, LAST = -20.0, 300.0
"""Range in which states are looked for: logarithms of the tangent of an angle. It is the angle of L
from the encircled axis, as L passes the plane of this axis and the middle one. Before the first,
periods change by less than rounding. After the last, squares of rates are too small."""

HALVINGS = 70
"""Halvings of this interval that leave it below the spacing of doubles."""


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpinState:
    """The spin state of free bodies in the terms of observers of asteroids and comets.

    The long axis is the axis of the smallest moment, the short axis the axis of the largest. The
    Euler angles phi, theta, psi are the angles of the long axis about the angular momentum L:
    Samarasinha and A'Hearn, *Icarus* 93 (1991) 194.

    Attributes
    ----------
    mode : str, or ndarray of str of shape (...)
        ``"SAM"``, the short-axis mode: psi oscillates about the long axis. ``"LAM"``, the long-axis
        mode: the body rotates about the long axis, and psi takes all values. ``""`` for motions
        without two periods: a rotation about a principal axis, the separatrix, a sphere, and rest.
    precession : ndarray, shape (...)
        ``P_phi`` (s): mean period of the precession of the long axis about L. NaN without a mode.
    rotation : ndarray, shape (...)
        ``P_psi`` (s): period of the oscillation (SAM) or rotation (LAM) about the long axis, which
        is the period of the rates in the body. NaN without a mode.
    energy : ndarray, shape (...)
        ``E/E0 = 2 E I_s / L²``, the energy over the least energy with this L: 1 for a rotation
        about the short axis, ``I_s / I_l`` about the long axis; ``I_s / I_i`` separates the modes.
        NaN at rest.
    omega : ndarray, shape (..., 3)
        Angular velocity in the body (rad/s).
    attitude : ndarray, shape (..., 4), or None
        Quaternion, scalar first, body to space, of a state with a pole.
    """

    mode: str | NDArray[np.str_]
    precession: Floats
    rotation: Floats
    energy: Floats
    omega: Floats
    attitude: Floats | None = None


@refuses_overflow
def spin_periods(body: BodyLike, omega: ArrayLike) -> SpinState:
    """Mode, both periods and energy of a tumbling body in closed form.

    :class:`rigid.exact.FreeMotion` has the mean precession of the *encircled* axis. The encircled
    axis is the long axis in the long-axis mode. In the short-axis mode the long axis goes about L
    once less in each period of the rates. Both periods have the meaning of Kaasalainen, *Astron.
    Astrophys.* 376 (2001) 302, and of Pravec et al., *Icarus* 173 (2005) 108 and 233 (2014) 48.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²) in any order.
    omega : array_like, shape (..., 3)
        Angular velocity in the body at any time (rad/s).

    Returns
    -------
    SpinState

    Raises
    ------
    ValueError
        If no body has the moments, or a value is not finite.

    Examples
    --------
    The rates of (4179) Toutatis in degrees a day, axis 3 being the long one: periods in days.

    >>> import numpy as np
    >>> from rigid import free
    >>> found = free.spin_periods((3.0836, 3.235, 1.0), np.radians([14.5, 33.7, -98.5]))
    >>> str(found.mode), round(float(found.precession), 2), round(float(found.rotation), 2)
    ('LAM', 7.4, 5.38)
    """
    moments, rates = np.broadcast_arrays(moments_of(body), vectors("omega", omega))
    motion = asymmetric_free_top(moments, rates)
    period = np.asarray(motion.period)
    has_two = np.isfinite(period) & (motion.axis != 0)
    encircled = np.maximum(np.abs(motion.axis) - 1, 0)[..., np.newaxis]
    own = np.take_along_axis(moments, encircled, axis=-1)[..., 0]
    is_long = own == moments.min(axis=-1)
    # A period of the rates takes the long axis once less about L than the short axis.
    turned = motion.precession - np.where(is_long, 0.0, 2.0 * pi / period)
    mode = np.where(has_two, np.where(is_long, "LAM", "SAM"), "")
    with np.errstate(divide="ignore", invalid="ignore"):
        precession = 2.0 * pi / turned
        energy = _energy(moments, rates)
    return SpinState(
        mode=mode[()],
        precession=np.where(has_two, precession, np.nan)[()],
        rotation=np.where(has_two, period, np.nan)[()],
        energy=energy[()],
        omega=np.array(rates),
    )


def _energy(moments: Floats, rates: Floats) -> Floats:
    """``2 E I_s / L²``; a sum of squares over a sum of squares, in units of the largest numbers."""
    inertia = moments / moments.max(axis=-1, keepdims=True)
    turning = rates / np.abs(rates).max(axis=-1, keepdims=True)
    momentum = inertia * turning
    ratio: Floats = (momentum * turning).sum(axis=-1) / (momentum * momentum).sum(axis=-1)
    return ratio


@refuses_overflow
def spin_state(
    body: BodyLike,
    *,
    precession: ArrayLike,
    rotation: ArrayLike,
    mode: str,
    pole: ArrayLike | None = None,
    phases: ArrayLike | None = None,
) -> SpinState:
    """Angular velocity and energy of a tumbling body from its two periods, and its attitude.

    The ratio of the periods gives the ratio of energy and squared momentum, and the periods then
    give the momentum. Without phases the state is the one at which L lies in the plane of the
    encircled axis and the axis of the middle moment, with positive components; a motion passes this
    state or its mirror image four times in ``rotation``. Of a body whose phases are unknown, both
    are uniform from 0 to 2 pi.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments in any order; their ratios alone matter.
    precession : array_like, shape (...)
        ``P_phi`` (s), positive: mean period of the precession of the long axis about L.
    rotation : array_like, shape (...)
        ``P_psi`` (s), positive: period of the oscillation or rotation about the long axis.
    mode : {"SAM", "LAM"}
        The short-axis or the long-axis mode; see :class:`SpinState`. Both may have these periods.
    pole : array_like, shape (..., 3), optional
        Direction of L in space, a unit vector. The state then has an attitude.
    phases : array_like, shape (..., 2), optional
        The phase of the precession, which is the Euler angle phi (rad) of the long axis about L,
        and the phase of the rotation (rad): ``2 pi / rotation`` times the time since the state
        without phases. Phi counts from the ascending node of the plane across L, which is the
        direction ``e3 × L``, or the second axis of space if L is parallel to the third. Default:
        both are zero.

    Returns
    -------
    SpinState
        With both periods of the state that was found.

    Raises
    ------
    ValueError
        If no body has the moments, the body has no such mode, an argument is not positive, or no
        motion in this mode has the two periods: ``rotation / precession`` is below the ratio of
        small nutations, or beyond the ratios of states that are farther from the separatrix than
        rounding. Of many bodies the message has the index of the first. If the pole is no
        unit vector, or phases have no pole.

    Examples
    --------
    (99942) Apophis by the moments and periods (h) of Pravec et al., *Icarus* 233 (2014) 48, who
    give ``E/E0 = 1.024 ± 0.013``:

    >>> from rigid import free
    >>> found = free.spin_state((0.61, 0.965, 1.0), precession=27.38, rotation=263.0, mode="SAM")
    >>> round(float(found.energy), 3)
    1.029

    Three states of the same body, whose L points to the south pole of the ecliptic:

    >>> periods = {"precession": 27.38, "rotation": 263.0, "mode": "SAM"}
    >>> phases = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]]
    >>> found = free.spin_state((0.61, 0.965, 1.0), **periods, pole=[0, 0, -1], phases=phases)
    >>> found.omega.shape, found.attitude.shape
    ((3, 3), (3, 4))
    """
    name = one_of("mode", mode, MODES)
    long_period = shaped("precession", precession, positive=True, unit="s")
    short_period = shaped("rotation", rotation, positive=True, unit="s")
    moments = moments_of(body)
    if phases is not None and pole is None:
        raise ValueError("phases: count about the pole; give pole, the direction of L in space")
    turned = shaped("phases", [0.0, 0.0] if phases is None else phases, 2, unit="rad")
    to = unit_vectors("pole", [0.0, 0.0, 1.0] if pole is None else pole)
    shape = np.broadcast_shapes(
        moments.shape[:-1],
        long_period.shape,
        short_period.shape,
        turned.shape[:-1],
        to.shape[:-1],
    )
    given = np.broadcast_to(moments, (*shape, 3))
    moments, _ = of_size_one(given)
    to, turned = np.broadcast_to(to, (*shape, 3)), np.broadcast_to(turned, (*shape, 2))
    long_period, short_period = np.broadcast_arrays(
        np.broadcast_to(long_period, shape), short_period
    )
    order = np.argsort(moments, axis=-1, kind="stable")
    smallest, middle, largest = np.moveaxis(np.take_along_axis(moments, order, axis=-1), -1, 0)
    place = 2 if name == "SAM" else 0
    if name == "SAM":
        require(
            "moments",
            given.max(axis=-1),
            largest > middle,
            "a body has a short-axis mode only if this moment is above both others; use mode='LAM'",
        )
        with np.errstate(divide="ignore"):
            least = np.sqrt(smallest * middle / ((largest - smallest) * (largest - middle)))
    else:
        require(
            "moments",
            given.min(axis=-1),
            smallest < middle,
            "a body has a long-axis mode only if this moment is below both others; use mode='SAM'",
        )
        slow = np.sqrt((middle - smallest) * (largest - smallest) / (middle * largest))
        least = (1.0 - slow) / slow
    ratio = short_period / long_period
    below = ~(ratio > least)
    if below.any():
        index, spot = first_place(below)
        others = below.sum() - 1
        also = f"; {others} of the other bodies have no such motion either" if others else ""
        raise ValueError(
            f"rotation / precession{spot} = {ratio[index]:.6g}: must be above {least[index]:.6g}, "
            f"the ratio of small nutations in the {name}; take other moments or the other mode"
            + also
        )

    def at(log_tangent: Floats) -> SpinState:
        momentum = momentum_near(order, place, log_tangent)
        return spin_periods(moments, momentum / moments)

    low, high = np.full(shape, FIRST), np.full(shape, LAST)
    for _ in range(HALVINGS):
        half = 0.5 * (low + high)
        tried = at(half)
        longer = tried.rotation > ratio * tried.precession
        low, high = np.where(longer, low, half), np.where(longer, half, high)
    unit = at(high)
    require(
        "rotation / precession",
        ratio,
        np.isfinite(unit.rotation) & (high < LAST),
        "belongs to a motion so near the separatrix that rounding decides its mode; take a smaller "
        "rotation",
    )
    omega = unit.omega * (unit.precession / long_period)[..., np.newaxis]
    if pole is None:
        return spin_periods(moments, omega)
    times = turned[..., 1] / (2.0 * pi) * short_period
    scene = FreeBody(Body(moments, physical=False))
    later = simulate(scene, omega, t=times[..., np.newaxis], record="rates", method="exact")
    omega = later.omega[..., 0, :]
    attitude = _attitude(moments, omega, np.argmin(moments, axis=-1), to, turned[..., 0])
    return replace(spin_periods(moments, omega), attitude=attitude)


def _attitude(
    moments: Floats, omega: Floats, long: NDArray[np.intp], pole: Floats, phi: Floats
) -> Floats:
    """The attitude in which L points to the pole, and the long axis has its angle about L."""
    up = moments * omega / np.linalg.norm(moments * omega, axis=-1, keepdims=True)
    # The node of the long axis, across L: the Euler angle phi goes from the node of the pole to it.
    node = np.cross(up, np.eye(3)[long])
    node /= np.linalg.norm(node, axis=-1, keepdims=True)
    from_pole = np.stack([node, np.cross(up, node), up], axis=-2)
    x, y, z = np.moveaxis(pole + 0.0, -1, 0)  # no zero has a sign, which would turn by pi
    longitude, colatitude = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
    to_space = euler_to_matrix(np.stack([longitude + 0.5 * pi, colatitude, 0.0 * phi], axis=-1))
    return matrix_to_quaternion(to_space @ rotation_z(phi) @ from_pole)


def momentum_near(order: NDArray[np.intp], encircled: int, log_tangent: Floats) -> Floats:
    """Unit vectors along L in the plane of an axis and the axis of the middle moment.

    Parameters
    ----------
    order : ndarray, shape (..., 3)
        The axes in the order of ascending moments.
    encircled : {0, 2}
        The place of the encircled axis in this order.
    log_tangent : ndarray, shape (...)
        Logarithm of the tangent of the angle of L from the encircled axis.

    Returns
    -------
    ndarray, shape (..., 3)
    """
    across, along = np.exp(np.minimum(log_tangent, 0.0)), np.exp(-np.maximum(log_tangent, 0.0))
    size = np.hypot(across, along)
    momentum = np.zeros((*np.shape(log_tangent), 3))
    axes = np.broadcast_to(order, momentum.shape)
    np.put_along_axis(momentum, axes[..., 1:2], (across / size)[..., np.newaxis], axis=-1)
    own = axes[..., encircled : encircled + 1]
    np.put_along_axis(momentum, own, (along / size)[..., np.newaxis], axis=-1)
    return momentum
