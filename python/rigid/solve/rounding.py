"""Rounding errors that a run and its check share, so that their difference does not show them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import lengths, spread_indices, time_ranges, time_span
from .bodies import Bodies
from .methods import is_compensated, preserves_groups, rotations, series_methods
from .request import Request
from .saddle import dampings, gammas

__all__ = ["REST", "common_rounding", "planned_rounding", "rounding_of_damping"]

Floats = NDArray[np.float64]

REST = 1e-13
"""Rates count as rest below this share of the fastest possible rate of a body and of the rate of
its swing."""

EQUAL_RUNS = 5e-16
"""Rounding error per radian turned (rad) that two runs which agree bit for bit may share."""

ROTATION = 1.6e-17
"""Rounding error (rad) of each rotation of a splitting.

Equal rotations err in both runs alike, all in one direction."""

LIE = "etd4"
"""The method whose steps each turn a damped body by one rotation."""

TURN = 1.3e-16
"""Rounding error (rad) of such a rotation, if all rotations are equal and about one direction."""

DRIFT = 5.6e-17
"""Relative rounding error of the rates in each of many equal steps.

It is half a unit in the last place, always in one direction: a method of exact flows turns the
rates of a symmetric free body by the same angle each step, and all but steady rates change by the
same amount."""

ALIKE = 1e-4
"""Relative difference of moments below which a body turns as with equal moments."""

ROUNDED = 3.0
"""Most rounding of the rates in a step, in units of :data:`DRIFT`, besides the rounding of
rotations."""

UNIT = 2.0**-53
"""Half the distance from 1 to the next number."""

FORGOTTEN = 30.0
"""Number of damping times after which a rate has fallen below :data:`REST` of its first value."""

LOOKS = 16
"""Most states at which the change of the rates by torques is measured."""

PART = 1024.0
"""Number by which a step is divided to give the time of this measurement."""

PROBE = "rk4"
"""The method of this measurement: it integrates all forces."""


def common_rounding(
    request: Request,
    states: Mapping[str, Any],
    rates: Floats,
    scale: Floats,
    span: float | Floats,
) -> Floats:
    """The rounding error that two runs may share, shape (n,).

    Parameters
    ----------
    request : Request
    states : mapping
        States of the first run at the output times, with its steps.
    rates : ndarray, shape (n,)
        Bounds of the rates (rad/s).
    scale : ndarray, shape (n,)
        The larger of these bounds and of the rate of the swing (rad/s).
    span : float or ndarray, shape (n,)
        How much time is covered (s).
    """
    bodies, method = request.bodies, request.method
    taken = states["steps"].astype(np.float64)
    angle = rates * span
    floor: Floats = EQUAL_RUNS * (1.0 + angle) + ROTATION * rotations(method) * taken
    floor += _loss_of_turns(bodies, method, taken, angle)
    if method == LIE and bodies.forces is not None:
        floor += TURN * taken
    # The second run of a series carries the rounding of a step on, as steps by a tolerance do.
    if method not in series_methods() and request.tolerance is None:
        differs, angles = _differences(request, states, step=span / taken, angle=angle)
        floor += _steady_loss(differs, taken, span, angles)
    # Of the rates of a top that hangs all but still, what rounding of its torque adds at random, in
    # each radian that it may turn, is a larger share.
    fastest = lengths(states["omega"]).max(axis=1)
    weighs = bodies.weight.any(axis=1)
    hangs = (weighs & (fastest > REST * scale)).nonzero()[0]
    if len(hangs):
        share = scale[hangs] / fastest[hangs] * _rounded_share_of_torque(bodies)[hangs]
        floor[hangs] += EQUAL_RUNS * share * np.sqrt(1.0 + angle)[hangs]
    return floor


@np.errstate(all="ignore")
def planned_rounding(
    bodies: Bodies, method: str, rates: Floats, taken: Floats, span: float | Floats
) -> Floats:
    """The rounding error after so many steps, besides the error of each radian turned; (n,).

    Known are the rates of the start alone, and these bounds of all (rad/s).
    """
    start = bodies.omega[:, np.newaxis]
    loss = _loss_of_turns(bodies, method, taken, rates * span)
    if not is_compensated(method):
        differs = _second_difference(bodies, method, start)
        loss += _steady_loss(differs, taken, span, rates * span)
        loss += DRIFT * np.sqrt(taken)  # at random
    planned: Floats = ROTATION * rotations(method) * taken + ROUNDED * loss
    return planned


def _loss_of_turns(bodies: Bodies, method: str, taken: Floats, angle: Floats) -> Floats:
    """The error of free symmetric bodies whose steps turn them by equal angles, shape (n,)."""
    if not rotations(method) or bodies.forces is not None:
        return np.zeros(len(bodies))
    apart = np.abs(np.roll(bodies.moments, 1, axis=1) - bodies.moments)
    symmetric = np.any(apart <= ALIKE * bodies.moments, axis=1)
    free = ~bodies.weight.any(axis=1)
    return np.where(symmetric & free, 0.5 * DRIFT * taken * angle, 0.0)


def rounding_of_damping(bodies: Bodies, omega: Floats, times: Floats) -> Floats:
    """The error from the rounding of the damping that two runs may share, shape (n, m).

    The damping of a slow direction is a difference of large products if other directions are fast
    and the directions are not along the axes. Each product is rounded, so the direction has a
    damping rate that is off by a rounding of their sum, as long as its rates last: relative to them
    the error grows with the time, and after the time of its damping it follows from the balance of
    a torque with the damping.

    Parameters
    ----------
    bodies : Bodies
    omega : ndarray, shape (n, m, 3)
        Rates of the first run at the output times (rad/s).
    times : ndarray, shape (m,) or (n, m)
        The output times (s).
    """
    matrix = dampings(bodies.forces, alone=False)
    moments = bodies.moments[:, np.newaxis]
    size, time = lengths(omega), np.abs(times)
    along = omega / size[..., np.newaxis]
    inertia = (along * moments * along).sum(axis=-1)
    products = _quadratic(np.abs(matrix), np.abs(along))
    power = np.maximum(_quadratic(matrix, along), UNIT * products)
    lasts = inertia / power
    started = np.abs((along * moments * bodies.omega[:, np.newaxis]).sum(axis=-1)) / inertia
    angle = size * time + started * np.minimum(time, lasts)
    of_rates = np.minimum(time, FORGOTTEN * lasts)
    error = UNIT * products / inertia * (of_rates + angle * np.minimum(time, lasts))
    # A body at rest, or without damping, has no such error.
    known: Floats = np.where(np.isfinite(error), error, 0.0)
    return known


def _quadratic(matrices: Floats, vectors: Floats) -> Floats:
    """``v . M v``, shape (n, m); not by ``@``, which needs memory of OpenBLAS."""
    product: Floats = np.einsum("nmi,nij,nmj->nm", vectors, matrices, vectors)
    return product


def _rounded_share_of_torque(bodies: Bodies) -> Floats:
    """Size of the products whose differences are the torque of the weight, over its largest; (n,).

    Each component of ``com x gamma`` is one of two products of which both may be rounded.
    """
    com, gamma = np.abs(bodies.weight), np.abs(gammas(bodies))
    products = np.roll(com, 1, axis=1) * np.roll(gamma, 2, axis=1)
    products = products + np.roll(com, 2, axis=1) * np.roll(gamma, 1, axis=1)
    share: Floats = lengths(products) / lengths(com)
    return np.broadcast_to(share, len(bodies))


def _steady_loss(differs: Floats, taken: Floats, span: float | Floats, angle: Floats) -> Floats:
    """The error of bodies whose rates change by nearly the same amount each step, shape (n,).

    Where the change of a step differs from the change of the last one by a share of the rates that
    is less than a rounding, it is rounded as the last one was: for as many steps as make up one.
    The losses of groups of so many steps add at random.
    """
    least = differs.min(axis=1, initial=np.inf) * (span / taken) ** 2
    equal = np.where(least >= 0.0, np.minimum(UNIT / least, taken), 1.0)
    loss = DRIFT * np.sqrt(taken * equal)
    lost: Floats = np.where(equal > 1.0, loss * (1.0 + 0.5 * angle), 0.0)
    return lost


def _second_difference(bodies: Bodies, method: str, omega: Floats) -> Floats:
    """About ``|d2 omega / dt2| / |omega|``, 1/s², shape (n, m); NaN if a torque acts.

    Without weight the rates turn in the body, and so do their changes. The change by the weight
    turns with the body. Methods that preserve ``|L|`` add it apart from the turn.
    """
    moments = bodies.moments[:, np.newaxis, :]
    torque = np.cross(moments * omega, omega)
    if bodies.forces is not None:
        # The matrices of damping are symmetric.
        torque -= omega @ dampings(bodies.forces, alone=True)
    turning: Floats = (lengths(torque / moments) / lengths(omega)) ** 2
    weight = np.reshape(lengths(bodies.weight) / bodies.moments.min(axis=1), (-1, 1))
    apart = preserves_groups(method) & (weight > 0.0)
    differs: Floats = np.where(apart & ~np.isnan(turning), 0.0, turning) + weight
    return differs


def _differences(
    request: Request, states: Mapping[str, Any], step: Floats, angle: Floats
) -> tuple[Floats, Floats]:
    """Second differences of the rates and the angles turned, measured where a torque acts."""
    omega = states["omega"]
    differs = _second_difference(request.bodies, request.method, omega)
    forced: NDArray[np.bool_] = np.all(np.isnan(differs), axis=1)
    if not forced.any():
        return differs, angle
    some = spread_indices(omega.shape[1], LOOKS)
    change = _measured_change(request, states, some, np.reshape(step / PART, (-1, 1)))
    differs = np.where(forced[:, None], (change / lengths(omega[:, some])) ** 2, differs[:, some])
    # A rotor couples the rates more closely than the body turns.
    following = request.bodies.fastest_rates(time_ranges(request.times), request.method)
    return differs, np.where(forced, following * time_span(request.times), angle)


def _measured_change(
    request: Request, states: Mapping[str, Any], some: NDArray[np.intp], time: Floats
) -> Floats:
    """``|d omega / dt|`` from some of the states on, in a short time (n, 1); shape (n, m).

    What acts is what acts at the start, in the attitude of the state if that is recorded.
    """
    bodies = request.bodies.repeat(len(some))
    omega = states["omega"][:, some].reshape(-1, 3)
    known = np.isfinite(omega).all(axis=1, keepdims=True)
    omega, attitude = np.where(known, omega, bodies.omega), bodies.attitude
    if states["attitude"] is not None:
        attitude = np.where(known, states["attitude"][:, some].reshape(-1, 4), attitude)
    forward = np.where(np.max(request.times, axis=-1) > 0.0, 1.0, -1.0)
    moved = replace(
        request,
        bodies=replace(bodies, omega=omega, attitude=attitude),
        times=np.repeat(time * np.reshape(forward, (-1, 1)), len(some), axis=0),
        method=PROBE,
        record="rates",
    ).states(None)
    apart: Floats = lengths(moved["omega"][:, 0] - omega).reshape(-1, len(some)) / time
    return apart
