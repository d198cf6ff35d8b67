"""What the drift of a run does to a free body next to its separatrix."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core

__all__ = ["next_to_separatrix"]

Floats = NDArray[np.float64]


NEAR = 1e-3
"""A distance from the separatrix below this share of the largest on its side is near."""


FREE = 1e-8
"""What acts on a body is next to nothing below this share of its kinetic energy."""


@np.errstate(all="ignore")
def next_to_separatrix(
    table: Mapping[str, Any], states: Mapping[str, Any], reached: tuple[float, float]
) -> tuple[Floats, Floats]:
    """By how much drift alone may have put bodies out of step, and from when on it may be anywhere.

    ``2 T I2 - L²``, moments ascending, is negative on the polhodes about axis 3 and positive on
    those about axis 1 (Landau & Lifshitz, *Mechanics*, § 37). The time that a body stays at the
    saddle goes with its logarithm: a drift of the states that changes it by a share delays
    each flip by about that share of the time in which the body turns over (first result, in rad;
    0 away from the separatrix). Where they reach all of it the side is lost, which shows once the
    body has passed the saddle, that is from its first flip on (second result; infinite if never).
    Bodies on which next to nothing acts are looked at like free ones.
    """
    count = len(table["omega"])
    delay, never = np.zeros(count), np.full(count, np.inf)
    if not count:
        return delay, never
    moments = np.broadcast_to(table["moments"], (count, 3))
    order = np.argsort(moments[0], kind="stable")
    if len(np.unique(moments[0])) < 3 or not np.all(moments == moments[0]):
        return delay, never
    i1, i2, i3 = moments[0, order]
    momentum2 = np.sum((moments * table["omega"]) ** 2, axis=1)
    kinetic = np.sum(moments * table["omega"] ** 2, axis=1)
    acts = np.linalg.norm(table["weight"], axis=1)
    if states["work"] is not None:
        acts = acts + np.abs(states["work"]).max(axis=1, initial=0.0)

    def sides(omega: Floats) -> tuple[Floats, Floats]:
        # From components: as a difference of energy and momentum nothing would be left of them.
        first, third = omega[..., order[0]] ** 2, omega[..., order[2]] ** 2
        return i1 * (i2 - i1) * first, i3 * (i3 - i2) * third

    about_first, about_third = sides(table["omega"])
    distance = np.abs(about_first - about_third)
    # On either side it is largest for the rotation about the axis there.
    largest = momentum2 * np.where(about_first > about_third, (i2 - i1) / i1, (i3 - i2) / i3)
    near = np.flatnonzero((distance < NEAR * largest) & (momentum2 > 0.0) & (acts < FREE * kinetic))
    if not len(near):
        return delay, never
    later_first, later_third = sides(states["omega"][near])
    moved = (later_first - later_third) - (about_first - about_third)[near, None]
    share = np.abs(moved).max(axis=1, initial=0.0) / distance[near]
    some: dict[str, Any] = {
        "scene": "free",
        "moments": np.ascontiguousarray(moments[near]),
        "weight": np.zeros((1, 3)),
        "omega": np.ascontiguousarray(table["omega"][near]),
        "attitude": np.array([[1.0, 0.0, 0.0, 0.0]]),
    }
    first = _core.flip_times(**some, axis=int(order[1]) + 1, count=1)[:, 0]
    # Backward in time a body passes the saddle about as late.
    passed = np.where(first <= reached[1], first, np.where(first <= -reached[0], -first, np.inf))
    flips = np.isfinite(passed)
    delay[near] = np.where(flips, np.minimum(share, 1.0), 0.0)
    never[near] = np.where(flips & (share >= 1.0), passed, np.inf)
    return delay, never
