"""How far a saddle of a top magnifies the rounding of the start.

No method can do better: the start itself is known to rounding only. Two runs from one start share
its rounding, so their difference does not tell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .batch import Batch

__all__ = ["departure", "separatrices"]

Floats = NDArray[np.float64]

NEAR = 1e-4
"""A start whose rates of change are below this share of its own rates is near an equilibrium."""

SLOWEST = 1e-4
"""Exponents below this share of the rates are those of neutral directions, rounded."""

START = 6.7e-16
"""Rounding of a start: three units in the last place."""


def separatrices(batch: Batch) -> tuple[Floats, Floats]:
    """Relative distance from the separatrix, and exponent of its saddle (1/s); shape (n,) each.

    Of tops and pendulums in closed form; 1 and 0 for free bodies.
    """
    if batch.forcing is not None or not batch.weight.any():
        return np.ones(len(batch)), np.zeros(len(batch))
    columns = batch.full_columns()
    del columns["scene"]
    mc, exponent = _core.saddles(**columns).T
    return mc, exponent


@np.errstate(all="ignore")
def departure(batch: Batch, times: Floats) -> Floats:
    """Error that the rounding of a start beside an unstable equilibrium becomes, shape (n, m).

    Rounding grows with the largest exponent of the linearised motion until the body has left:
    until its distance from the equilibrium, and that of its rounded neighbour, is of order one. A
    start that is in equilibrium to the bit stays, as exact arithmetic has it.
    """
    error = np.zeros((len(batch), len(times)))
    damping = np.zeros((3, 3)) if batch.forcing is None else _damping_matrix(batch.forcing)
    if damping is None or not batch.weight.any():
        return error
    moments = np.broadcast_to(batch.moments, (len(batch), 3))
    weight = np.broadcast_to(batch.weight, (len(batch), 3))
    vertical, omega = _verticals(batch), batch.omega
    # Not by `@`: OpenBLAS ends the process where its own memory cannot be had.
    damped = np.einsum("ni,ij->nj", omega, damping)
    torque = _cross(moments * omega, omega) + _cross(vertical, weight) - damped
    rate = np.sqrt(np.sum(omega**2, axis=1) + np.linalg.norm(weight, axis=1) / moments.min(axis=1))
    away = np.maximum(
        np.linalg.norm(torque / moments, axis=1) / rate**2,
        np.linalg.norm(_cross(vertical, omega), axis=1) / rate,
    )
    since = np.abs(times) if batch.forcing is None else np.maximum(times, 0.0)
    for body in np.flatnonzero((away > 0.0) & (away < NEAR)):
        flow = _linearised(moments[body], weight[body], omega[body], vertical[body], damping)
        exponent = np.linalg.eigvals(flow).real.max()
        if exponent > rate[body] * max(SLOWEST, 10.0 * np.sqrt(away[body])):
            left = max(away[body], START)
            error[body] = START * np.minimum(np.expm1(exponent * since), 1.0 / left)
    return error


def _verticals(batch: Batch) -> Floats:
    """The upward verticals in body components, shape (n, 3)."""
    w, x, y, z = np.broadcast_to(batch.attitude, (len(batch), 4)).T
    return np.stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z], axis=-1
    )


def _damping_matrix(forcing: _core.Forcing) -> Floats | None:
    """The damping matrix, None if a torque acts too."""
    entries = forcing.damping_alone()
    if entries is None:
        return None
    d11, d22, d33, d23, d31, d12 = entries
    return np.array([[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]])


def _cross(a: Floats, b: Floats) -> Floats:
    """The products ``a x b``, shape (n, 3); for a single body faster than that of NumPy."""
    (a1, a2, a3), (b1, b2, b3) = a.T, b.T
    return np.stack([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1], axis=-1)


def _cross_matrix(v: Floats) -> Floats:
    """The matrix of ``v x``."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _linearised(
    moments: Floats, weight: Floats, omega: Floats, vertical: Floats, damping: Floats
) -> Floats:
    """Derivative of the rates of change of rates and vertical, shape (6, 6)."""
    turning = _cross_matrix(moments * omega) - _cross_matrix(omega) * moments - damping
    falling = -_cross_matrix(weight)
    return np.block(
        [
            [turning / moments[:, None], falling / moments[:, None]],
            [_cross_matrix(vertical), -_cross_matrix(omega)],
        ]
    )
