"""The quantities from which the error of steps follows, and motions outside the models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .arrays import Range, lengths, spread_indices
from .bodies import Bodies
from .cost_model import Motions
from .rounding import planned_rounding
from .saddle import gammas, separatrices
from .separatrix import circulation_terms

__all__ = ["motions_of", "why_unforeseen"]

Floats = NDArray[np.float64]

SAMPLE = 32
"""Number of bodies of a large call that are examined."""

SLOW = 10.0
"""A body this many times slower than the rate for its steps is nearly at rest."""

NEAR = 0.01
"""Relative distance from a separatrix, or from the energy of rest upright, that counts as near."""

APART = 50.0
"""Largest ratio of moments that the models cover."""

POLE = 7.0
"""Angle (rad) that bodies of the models turn until the nearest pole of their motion."""

CHAOS = 200.0
"""Angle (rad) after which a top without closed form may be chaotic."""


@np.errstate(all="ignore")
def motions_of(
    bodies: Bodies,
    method: str,
    times: Range,
    span: float | Floats | None,
    steps: Floats,
    *,
    states: int,
) -> Motions:
    """The quantities that determine the error of steps of these longest lengths (s), shape (n,).

    Parameters
    ----------
    bodies : Bodies
    method : str
    times : tuple of float, or of ndarray of shape (n,)
        First and last time (s).
    span : float, ndarray of shape (n,), or None
        How much time is covered (s); None if it is not known.
    steps : ndarray, shape (n,)
    states : int
        Number of requested states of a body.
    """
    rates, bounds = (bodies.fastest_rates(times, name) for name in (method, None))
    damping: float | Floats = 0.0
    if bodies.forces is not None:
        damping = np.broadcast_to(bodies.forces.damping_rates(bodies.moments), len(bodies))
    gains = bodies.weight.any(axis=1) | bodies.under_forces()
    motions = Motions(
        rates=rates,
        ratios=bodies.weight_ratios(bounds),
        steps=steps,
        span=span,
        states=states,
        damping=damping,
        nearness=_nearness_of_poles(bodies, rates),
        slowness=np.where(gains, np.fmax(bounds / lengths(bodies.omega), 1.0), 1.0),
    )
    if span is None:
        return motions
    return replace(motions, rounding=planned_rounding(bodies, method, bounds, motions.taken, span))


def why_unforeseen(bodies: Bodies, times: Range, *, by_steps: bool) -> str | None:
    """The reason why no model foresees the error of the bodies; None if one does.

    Of bodies under torque or damping only a stop by drag is looked for.
    """
    if bodies.may_stop:
        return "drag may stop a body, and the speed has a corner there"
    if not by_steps and not np.count_nonzero(bodies.weight):
        return None
    with np.errstate(all="ignore"):
        return _why_unforeseen(bodies, times, by_steps=by_steps)


def _why_unforeseen(bodies: Bodies, times: Range, *, by_steps: bool) -> str | None:
    """The reason why no model foresees the error of bodies that drag does not stop."""
    looked_at = np.flatnonzero(~bodies.under_forces())
    looked_at = looked_at[spread_indices(len(looked_at), SAMPLE)]
    if not len(looked_at):
        return None
    some = bodies if len(looked_at) == len(bodies) else bodies.select(looked_at)
    first, last = (np.broadcast_to(time, len(bodies))[looked_at] for time in times)
    weighs = np.broadcast_to(some.weight.any(axis=1), len(some))
    if weighs.any():
        rates = some.fastest_rates(times)
        above_rest, from_upright = _distances_in_energy(some)
        if np.any(rates > SLOW * above_rest):
            return "a body is nearly at rest, and its small rates are what the error is relative to"
        distance, exponent = separatrices(some)
        growth = np.exp(exponent * np.maximum(-first, last))
        if np.any(np.fmin(growth, 1.0 / distance) > 1.0 / NEAR):
            return "a body passes a saddle, which magnifies it"
        # A top in closed form has its saddle in its error.
        by_form = (exponent != 0.0) | ~weighs
        if by_steps and np.any(~by_form & (from_upright < NEAR)):
            return "a body has about the energy of its rest upright, a saddle that magnifies it"
        if by_steps and np.any(~by_form & (rates * (last - first) > CHAOS)):
            return f"a top without closed form may be chaotic: it turns by more than {CHAOS:g} rad"
    if by_steps and np.any(~weighs & (_distance_from_separatrix(some) < NEAR)):
        return "a body is near its separatrix, a saddle that magnifies it"
    if by_steps and np.any(some.moments.max(axis=1) > APART * some.moments.min(axis=1)):
        return f"the moments of a body are more than {APART:g} times apart"
    return None


def _distances_in_energy(bodies: Bodies) -> tuple[Floats, Floats]:
    """Fastest rate by the energy above hanging, and distance from rest upright; (n,) each.

    The distance is a difference of energies, relative to ``mgl``. NaN for a body without weight.
    """
    size = lengths(bodies.weight)
    up = bodies.weight / size[:, None]
    kinetic = 0.5 * np.sum(bodies.moments * bodies.omega**2, axis=1)
    gamma = gammas(bodies)
    # Differences of unit vectors: small angles lose no digits.
    raised, fallen = (0.5 * np.sum((gamma + sign * up) ** 2, axis=1) for sign in (1.0, -1.0))
    fastest = np.sqrt(2.0 * (kinetic + size * raised) / bodies.moments.min(axis=1))
    return fastest, np.abs(kinetic / size - fallen)


def _ascending(bodies: Bodies) -> tuple[Floats, Floats]:
    """Moments and rates of each body, axes in ascending moments; (n, 3) each."""
    moments = np.broadcast_to(bodies.moments, bodies.omega.shape)
    order = np.argsort(moments, axis=1)
    ascending, rates = (np.take_along_axis(a, order, axis=1) for a in (moments, bodies.omega))
    return ascending, rates


def _distance_from_separatrix(bodies: Bodies) -> Floats:
    """Distance of free bodies from their separatrix over its distance from the axis; (n,).

    It is 1 if two moments are equal.
    """
    ascending, rates = _ascending(bodies)
    first, third = circulation_terms(ascending, rates)
    i1, i2, i3 = ascending.T
    momentum2 = np.sum((ascending * rates) ** 2, axis=1)
    largest = momentum2 * np.where(first > third, (i2 - i1) / i1, (i3 - i2) / i3)
    distance: Floats = np.where(largest > 0.0, np.abs(first - third) / largest, 1.0)
    return distance


def _nearness_of_poles(bodies: Bodies, rates: Floats) -> Floats:
    """Factor by which steps must be shorter than in the models for the same error; shape (n,).

    The rates of a free body are elliptic functions of time, and ``K(1 - m)/s`` beside the real
    times they have poles (Landau & Lifshitz, *Mechanics*, § 37): that is where series end to
    converge. A flat or slender body has them near. It is 1 for other bodies than free ones.
    """
    nearness = _core.nearness_of_poles(
        moments=bodies.moments, weight=bodies.weight, omega=bodies.omega, rates=rates, pole=POLE
    )
    return nearness if bodies.forces is None else np.where(bodies.under_forces(), 1.0, nearness)
