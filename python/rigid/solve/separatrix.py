"""The phase error that the drift of a run causes in a free body next to its separatrix."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import IDENTITY
from .arrays import Range
from .bodies import Bodies

__all__ = ["circulation_terms", "separatrix_error"]

Floats = NDArray[np.float64]

NEAR = 1e-3
"""A distance from the separatrix below this share of the largest on its side is near."""

NEARLY_FREE = 1e-8
"""A body is treated as free if weight and work are below this share of its kinetic energy."""


def circulation_terms(moments: Floats, omega: Floats) -> tuple[Floats, Floats]:
    """The terms of ``2 T I2 - L²`` from the rates about axes 1 and 3; axes in ascending moments.

    The first minus the second term is ``2 T I2 - L²``. The difference of energy and momentum would
    lose all digits near the separatrix.
    """
    i1, i2, i3 = np.moveaxis(moments, -1, 0)
    return i1 * (i2 - i1) * omega[..., 0] ** 2, i3 * (i3 - i2) * omega[..., 2] ** 2


@np.errstate(all="ignore")
def separatrix_error(
    bodies: Bodies, states: Mapping[str, Any], reached: Range
) -> tuple[Floats, Floats] | None:
    """Phase error (rad) from drift near the separatrix, and the time from which it may be lost.

    ``2 T I2 - L²``, moments ascending, is negative on the polhodes about axis 3 and positive on
    those about axis 1 (Landau & Lifshitz, *Mechanics*, § 37). The time that a body stays at the
    saddle goes with the logarithm of this distance: a drift of the states that changes the distance
    by a share delays each flip by about that share of the time in which the body turns over. Where
    the drift reaches the whole distance, the side is lost; this shows once the body has passed the
    saddle, that is from its first flip on.

    Parameters
    ----------
    bodies : Bodies
    states : mapping
        States of the bodies at the requested times.
    reached : tuple of float, or of ndarray of shape (n,)
        First and last time of the run (s), or of each body.

    Returns
    -------
    delay : ndarray, shape (n,)
        Phase error (rad); 0 away from the separatrix.
    lost_from : ndarray, shape (n,)
        Time (s) from which on the phase is unknown; infinite if never.

    None if no body is near its separatrix.
    """
    count = len(bodies)
    if not count:
        return None
    work = None
    if states["work"] is not None:
        work = np.abs(states["work"]).max(axis=1, initial=0.0)
    near = _core.near_separatrix(
        moments=bodies.moments,
        weight=bodies.weight,
        omega=bodies.omega,
        near=NEAR,
        free=NEARLY_FREE,
        work=work,
    )
    if not len(near):
        return None
    delay, never = np.zeros(count), np.full(count, np.inf)
    moments, omega = np.broadcast_to(bodies.moments, (count, 3))[near], bodies.omega[near]
    order = np.argsort(moments, axis=1, kind="stable")
    ascending = np.take_along_axis(moments, order, axis=1)
    about_first, about_third = circulation_terms(
        ascending, np.take_along_axis(omega, order, axis=1)
    )
    later = np.take_along_axis(states["omega"][near], order[:, np.newaxis], axis=2)
    later_first, later_third = circulation_terms(ascending[:, np.newaxis], later)
    moved = (later_first - later_third) - (about_first - about_third)[:, None]
    share = np.abs(moved).max(axis=1, initial=0.0) / np.abs(about_first - about_third)
    first = np.empty(len(near))
    for axis in range(3):
        mine = order[:, 1] == axis
        free = Bodies(
            kind="free",
            shape=(int(mine.sum()),),
            moments=moments[mine],
            weight=np.zeros((1, 3)),
            omega=omega[mine],
            attitude=IDENTITY[np.newaxis],
        )
        first[mine] = _core.flip_times(free, axis + 1, 1)[:, 0]
    # Backward in time a body passes the saddle about as late.
    begin, end = (np.broadcast_to(time, count)[near] for time in reached)
    passed = np.where(first <= end, first, np.where(first <= -begin, -first, np.inf))
    flips = np.isfinite(passed)
    delay[near] = np.where(flips, np.minimum(share, 1.0), 0.0)
    never[near] = np.where(flips & (share >= 1.0), passed, np.inf)
    return delay, never
