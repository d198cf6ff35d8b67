"""Rounding errors that a run by equal steps and its check share, besides the errors in the core."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import lengths, spread_indices, time_ranges, time_span
from .bodies import Bodies
from .methods import preserves_groups, rotations, series_methods
from .request import Request

__all__ = ["ROUNDING", "common_rounding"]

Floats = NDArray[np.float64]

ROUNDING = _core.ROUNDING
"""Rounding error of an attitude per radian turned (rad) in float64, even in closed form."""

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

UNIT = 2.0**-53
"""Half the distance from 1 to the next number."""

LOOKS = 16
"""Most states at which the change of the rates by torques is measured."""

PART = 1024.0
"""Number by which a step is divided to give the time of this measurement."""

PROBE = "rk4"
"""The method of this measurement: it integrates all forces."""


def common_rounding(
    request: Request, states: Mapping[str, Any], rates: Floats, span: float | Floats
) -> Floats:
    """The rounding error that two runs by equal steps may share besides, shape (n,).

    Parameters
    ----------
    request : Request
    states : mapping
        States of the first run at the output times, with its steps.
    rates : ndarray, shape (n,)
        Bounds of the rates (rad/s).
    span : float or ndarray, shape (n,)
        How much time is covered (s).
    """
    bodies, method = request.bodies, request.method
    taken = states["steps"].astype(np.float64)
    angle = rates * span
    floor: Floats = ROTATION * rotations(method) * taken
    floor += _loss_of_turns(bodies, method, taken, angle)
    if method == LIE and bodies.forces is not None:
        floor += TURN * taken
    # The second run of a series carries the rounding of a step on.
    if method not in series_methods():
        differs, angles = _differences(request, states, step=span / taken, angle=angle)
        floor += _steady_loss(differs, taken, span, angles)
    return floor


def _loss_of_turns(bodies: Bodies, method: str, taken: Floats, angle: Floats) -> Floats:
    """The error of free symmetric bodies whose steps turn them by equal angles, shape (n,)."""
    if not rotations(method) or bodies.forces is not None:
        return np.zeros(len(bodies))
    apart = np.abs(np.roll(bodies.moments, 1, axis=1) - bodies.moments)
    symmetric = np.any(apart <= ALIKE * bodies.moments, axis=1)
    free = ~bodies.weight.any(axis=1)
    return np.where(symmetric & free, 0.5 * DRIFT * taken * angle, 0.0)


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
        # The matrices of damping are symmetric; they are NaN where a torque acts too.
        entries = bodies.forces.dampings_alone()
        torque -= omega @ entries[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
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
