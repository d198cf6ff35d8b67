"""What rounding leaves in a run and in its check alike: their difference does not show it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import lengths
from .batch import Batch
from .methods import is_compensated, rotations
from .saddle import dampings, verticals

__all__ = ["REST", "common_rounding"]

Floats = NDArray[np.float64]

REST = 1e-13
"""Rates below this share of the fastest that a body can reach, and of the rate of its swing, are
those of a body at rest."""

EQUAL_RUNS = 5e-16
"""Error per radian turned (rad) that rounding may leave in two runs that agree to the bit."""

ROTATION = 1.6e-17
"""Error (rad) that rounding leaves in each rotation of a splitting.

Equal rotations err in both runs alike, all in one direction."""

DRIFT = 5.6e-17
"""Relative change of the rates by which rounding may leave each of many equal steps.

It is half a unit in the last place, always in one direction: a scheme of exact flows turns the
rates of a symmetric free body by the same angle each step, and all but steady rates change by the
same amount."""

UNIT = 2.0**-53
"""Half the distance from 1 to the next number."""


def common_rounding(
    batch: Batch,
    method: str,
    states: Mapping[str, Any],
    rates: Floats,
    scale: Floats,
    span: float | Floats,
    *,
    compensated: bool,
) -> Floats:
    """The error that rounding may leave in two runs alike, shape (n,).

    Parameters
    ----------
    batch : Batch
    method : str
    states : mapping
        States of the first run at the wanted times, with its steps.
    rates : ndarray, shape (n,)
        Bounds of the rates (rad/s).
    scale : ndarray, shape (n,)
        The larger of these bounds and of the rate of the swing (rad/s).
    span : float or ndarray, shape (n,)
        How much time is covered (s).
    compensated : bool
        Whether the rounding of a step is carried to the next one.
    """
    taken = states["steps"].astype(np.float64)
    angle = rates * span
    floor: Floats = EQUAL_RUNS * (1.0 + angle) + ROTATION * rotations(method) * taken
    free = ~batch.weight.any(axis=1)
    if rotations(method) and batch.forcing is None:
        symmetric = np.any(batch.moments == np.roll(batch.moments, 1, axis=1), axis=1)
        floor += np.where(symmetric & free, 0.5 * DRIFT * taken * angle, 0.0)
    if not (compensated or is_compensated(method)):
        floor += _steady_loss(batch, states["omega"], taken, span, angle)
    # Of the rates of a top that hangs all but still, what rounding of its torque adds at random, in
    # each radian that it may turn, is a larger share.
    fastest = lengths(states["omega"]).max(axis=1)
    hangs = (~free & (fastest > REST * scale)).nonzero()[0]
    if len(hangs):
        share = scale[hangs] / fastest[hangs] * _rounded_share_of_torque(batch)[hangs]
        floor[hangs] += EQUAL_RUNS * share * np.sqrt(1.0 + angle)[hangs]
    return floor


def _rounded_share_of_torque(batch: Batch) -> Floats:
    """How much of the largest torque of the weight its components are differences of, shape (n,).

    Each component of ``com x gamma`` is one of two products of which both may be rounded.
    """
    com, gamma = np.abs(batch.weight), np.abs(verticals(batch))
    products = np.roll(com, 1, axis=1) * np.roll(gamma, 2, axis=1)
    products = products + np.roll(com, 2, axis=1) * np.roll(gamma, 1, axis=1)
    share: Floats = lengths(products) / lengths(com)
    return np.broadcast_to(share, len(batch))


def _steady_loss(
    batch: Batch, omega: Floats, taken: Floats, span: float | Floats, angle: Floats
) -> Floats:
    """The error of bodies whose rates change by nearly the same amount each step, shape (n,).

    The rates turn by an angle a in the body each step, their changes by another a. Where a² is
    less than a rounding, the next change is rounded as the last one was: for 2^-53 / a² steps. The
    losses of groups of so many steps add at random.
    """
    turn = _change(batch, omega) / lengths(omega) * np.reshape(span / taken, (-1, 1))
    least = turn.min(axis=1, initial=np.inf)
    equal = np.where(least >= 0.0, np.minimum(UNIT / least**2, taken), 1.0)
    loss = DRIFT * np.sqrt(taken * equal)
    lost: Floats = np.where(equal > 1.0, loss * (1.0 + 0.5 * angle), 0.0)
    return lost


def _change(batch: Batch, omega: Floats) -> Floats:
    """At least ``|d omega / dt|``, shape (n, m); NaN for bodies on which a torque acts."""
    moments = batch.moments[:, np.newaxis, :]
    # The matrices of damping are symmetric.
    torque = np.cross(moments * omega, omega) - omega @ dampings(batch.forcing)
    weight = lengths(batch.weight) / batch.moments.min(axis=1)
    change: Floats = lengths(torque / moments) + np.reshape(weight, (-1, 1))
    return change
