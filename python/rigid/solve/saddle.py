"""The growth of the rounding of a start at a saddle of a top.

No method can do better: the start itself is known to rounding only. Two runs from one start share
its rounding, so their difference does not show it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..rotations.so3 import hat
from .arrays import lengths
from .bodies import Bodies

__all__ = ["RateSizes", "departure", "gammas", "homoclinic", "separatrices"]

Floats = NDArray[np.float64]

NEAR = 1e-4
"""A start is near an equilibrium if its rates of change are below this share of its rates."""

SLOWEST = 1e-4
"""Exponents below this share of the rates are rounded zeros of neutral directions."""

START = 6.7e-16
"""Rounding of a start: three units in the last place."""


@dataclass(frozen=True, slots=True)
class RateSizes:
    """The sizes to which the errors of rates are relative; shape (n,) each.

    Attributes
    ----------
    fastest : ndarray
        The fastest rate of the record (rad/s).
    rest, scale : ndarray
        Rates below the first count as rest; they are compared with the second.
    """

    fastest: Floats
    rest: Floats
    scale: Floats

    def with_rates(self, error: Floats, rate: Floats) -> Floats:
        """The larger of the errors of directions and of rates that move at this rate; (n, m)."""
        moved = rate[:, None] * error
        # All rates may come from the departure, of the run or of the true motion.
        size = np.maximum(self.fastest, moved.max(axis=1, initial=0.0))
        size = np.where(size > self.rest, size, np.where(self.scale > 0.0, self.scale, 1.0))
        larger: Floats = np.maximum(error, moved / size[:, None])
        return larger


def separatrices(bodies: Bodies) -> tuple[Floats, Floats]:
    """Relative distance from the separatrix, and exponent of its saddle (1/s); shape (n,) each.

    Of tops and pendulums in closed form; 1 and 0 for free bodies.
    """
    if bodies.forces is not None or not bodies.weight.any() or not bodies.closed_forms().any():
        return np.ones(len(bodies)), np.zeros(len(bodies))
    mc, exponent = _core.saddles(bodies).T
    weighs = bodies.weight.any(axis=1)
    return np.where(weighs, mc, 1.0), np.where(weighs, exponent, 0.0)


@np.errstate(all="ignore")
def homoclinic(bodies: Bodies, times: Floats, sizes: RateSizes, drift: Floats) -> Floats:
    """Growth of rounding errors beside the separatrix of a top in closed form, shape (n, m).

    Where it makes an error of one of the drift of the energy (n,) too, either side of the
    separatrix is as likely: two runs may take the same wrong one.
    """
    distance, exponent = separatrices(bodies)
    if not exponent.any():
        return np.zeros((len(bodies), times.shape[-1]))
    passed = exponent[:, None] * np.abs(times)
    magnified = np.fmin(np.exp(passed), (1.0 + passed) / distance[:, None]) - 1.0
    lost = np.where(drift[:, None] * magnified >= 1.0, np.inf, 0.0)
    return sizes.with_rates(START * magnified, exponent) + lost


@np.errstate(all="ignore")
def departure(bodies: Bodies, times: Floats, sizes: RateSizes) -> Floats:
    """Error from the rounding of a start beside an unstable equilibrium, shape (n, m).

    Rounding grows with the largest exponent of the linearised motion until the body has left:
    until its distance from the equilibrium, and the distance of its rounded neighbour, is of order
    one. A start that is exactly in equilibrium stays, as exact arithmetic has it.
    """
    error = np.zeros((len(bodies), times.shape[-1]))
    if not bodies.weight.any():
        return error
    moments = np.broadcast_to(bodies.moments, (len(bodies), 3))
    weight = np.broadcast_to(bodies.weight, (len(bodies), 3))
    gamma, omega = gammas(bodies), bodies.omega
    swing2 = lengths(bodies.weight) / bodies.moments.min(axis=1)
    rate = np.sqrt(np.einsum("ni,ni->n", omega, omega) + swing2)
    tilts = lengths(_cross(gamma, omega)) / rate
    if not np.any(tilts < NEAR):
        return error
    damping = np.broadcast_to(dampings(bodies.forces, alone=True), (len(bodies), 3, 3))
    torque = _cross(moments * omega, omega) + _cross(gamma, weight)
    if bodies.forces is not None:
        # Not by `@`: OpenBLAS ends the process where its own memory cannot be had.
        torque -= np.einsum("ni,nij->nj", omega, damping)
    away = np.maximum(lengths(torque / moments) / rate**2, tilts)
    stays = (away == 0.0) & _is_upright_to_the_bit(bodies)
    since = np.abs(times) if bodies.forces is None else np.maximum(times, 0.0)
    since = np.broadcast_to(since, error.shape)
    near = ~stays & (away < NEAR) & weight.any(axis=1)
    for body in np.flatnonzero(near):
        flow = _linearised(moments[body], weight[body], omega[body], gamma[body], damping[body])
        exponent = np.linalg.eigvals(flow).real.max()
        if exponent > rate[body] * max(SLOWEST, 10.0 * np.sqrt(away[body])):
            left = max(away[body], START)
            error[body] = START * np.minimum(np.expm1(exponent * since[body]), 1.0 / left)
    return sizes.with_rates(error, rate)


def _is_upright_to_the_bit(bodies: Bodies) -> NDArray[np.bool_]:
    """Whether the weight acts exactly along a principal axis that is exactly vertical; (n,)."""
    w, x, y, z = np.abs(np.broadcast_to(bodies.attitude, (len(bodies), 4)).T)
    vertical = np.stack(
        [
            (w == y) & (x == z),
            (w == x) & (y == z),
            ((x == 0.0) & (y == 0.0)) | ((w == 0.0) & (z == 0.0)),
        ],
        axis=-1,
    )
    acts = np.broadcast_to(bodies.weight, vertical.shape) != 0.0
    upright: NDArray[np.bool_] = (acts.sum(axis=1) == 1) & np.any(acts & vertical, axis=1)
    return upright


def gammas(bodies: Bodies) -> Floats:
    """The upward verticals in body components, shape (n, 3)."""
    w, x, y, z = np.broadcast_to(bodies.attitude, (len(bodies), 4)).T
    return np.stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z], axis=-1
    )


def dampings(forces: _core.Forces | None, *, alone: bool) -> Floats:
    """The damping matrices, shape (n, 3, 3), or (1, 3, 3) of all.

    With ``alone`` they are NaN where a torque acts too.
    """
    if forces is None:
        return np.zeros((1, 3, 3))
    entries = forces.dampings(alone)
    return entries[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]


def _cross(a: Floats, b: Floats) -> Floats:
    """The products ``a x b``, shape (n, 3); for a single body faster than by NumPy."""
    (a1, a2, a3), (b1, b2, b3) = a.T, b.T
    return np.stack([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1], axis=-1)


def _linearised(
    moments: Floats, weight: Floats, omega: Floats, gamma: Floats, damping: Floats
) -> Floats:
    """Derivative of the rates of change of rates and vertical, shape (6, 6)."""
    turning = hat(moments * omega) - hat(omega) * moments - damping
    falling = -hat(weight)
    return np.block(
        [
            [turning / moments[:, None], falling / moments[:, None]],
            [hat(gamma), -hat(omega)],
        ]
    )
