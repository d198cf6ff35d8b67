"""How far a run by steps can be believed: the same bodies again with shorter steps.

With steps shorter by ``2**(2/p)``, and at least by a sixth, the truncation error of a method of
order ``p`` falls to a quarter or less: the difference of the two runs is nearly all of it. Where
rounding rules, or chaos amplifies it, the two runs differ by about as much as each of them errs. In
both cases three times the difference is stated: more than the error nearly always, and seldom much
more. The extrapolation is Richardson's (Hairer, Nørsett, Wanner, *Solving Ordinary Differential
Equations I*, § II.4).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .columns import fastest_rates
from .methods import rotations, stiff_methods

__all__ = [
    "SAMPLE",
    "Belief",
    "ahead",
    "around",
    "believe",
    "distances",
    "evenly",
    "span_of",
    "taken_from",
]

Floats = NDArray[np.float64]

SAMPLE = 32
"""Bodies of a call that are run again: as many as go side by side."""

SAFETY = 3.0
"""The difference of two runs times this is stated as the error."""

CHECKS = 16
"""Times of a run, at most, at which the two runs are compared."""

REST = 1e-6
"""Rates below this share of the fastest that a body can reach are those of a body at rest."""

ROUNDING = 5e-16
"""What rounding may leave per radian turned of two runs that agree to the bit (rad)."""


@dataclass(frozen=True, slots=True)
class Belief:
    """Errors of some bodies: the largest at the checked times, and from when on it is lost."""

    error: Floats
    lost_from: Floats


ROTATION = 1.6e-17
"""What rounding leaves of each rotation that a splitting is made of (rad).

Equal rotations err alike in both runs, all one way."""


def evenly(count: int, most: int) -> NDArray[np.intp]:
    """At most ``most`` indices below ``count``, evenly spread, the last one among them."""
    # From the last to the first: of a single one, the last.
    spread = (count - 1) - np.linspace(0, count - 1, min(count, most))
    indices: NDArray[np.intp] = np.unique(spread.round().astype(np.intp))
    return indices


def taken_from(table: Mapping[str, Any], bodies: NDArray[np.intp]) -> dict[str, Any]:
    """The columns of some of the bodies."""
    count = len(table["omega"])
    return {
        name: values[bodies] if isinstance(values, np.ndarray) and len(values) == count else values
        for name, values in table.items()
    }


def distances(
    states: Mapping[str, Any], other: Mapping[str, Any], rest: Floats | float = 0.0
) -> Floats:
    """Relative distance of the states of two runs, shape (n, m).

    The largest of ``|d omega|`` over the largest ``|omega|`` of the body, of the angle between the
    verticals and of the angle between the attitudes. Rates below ``rest`` are compared with that.
    """
    rates, others = states["omega"], other["omega"]
    size = np.maximum(np.linalg.norm(others, axis=-1).max(axis=1, initial=0.0), rest)
    moving = np.where(size > 0.0, size, 1.0)
    parts = [np.linalg.norm(rates - others, axis=-1) / moving[:, None]]
    if states["vertical"] is not None:
        parts.append(np.linalg.norm(states["vertical"] - other["vertical"], axis=-1))
    if states["attitude"] is not None:
        a, b = states["attitude"], other["attitude"]
        apart = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
        parts.append(2.0 * apart)
    largest: Floats = np.max(parts, axis=0)
    return largest


@np.errstate(all="ignore")
def believe(
    table: Mapping[str, Any],
    times: Floats,
    states: Mapping[str, Any],
    *,
    method: str,
    record: str,
    order: int,
    max_steps: int,
    threads: int,
    tolerance: float | None,
) -> Belief:
    """The error of states that were made by steps, from a second run with shorter ones."""
    taken = states["steps"].astype(np.float64)
    span = span_of(times)
    rates = fastest_rates(table, around(times))
    floor = ROUNDING * (1.0 + rates * span)
    floor = floor + ROTATION * rotations(method) * taken
    count = len(taken)
    unknown = Belief(np.full(count, np.nan), np.full(count, np.nan))
    if span == 0.0 or not len(times):
        return Belief(np.zeros(count), np.full(count, np.inf))
    if not taken.any():
        return unknown
    # Several steps to each check, so that the shorter ones differ from them.
    checks = evenly(len(times), int(np.clip(taken[taken > 0].min() // 4, 1, CHECKS)))
    if times[0] < 0.0:
        checks = np.union1d(checks, [0])
    ratio = max(2.0 ** (2.0 / order), 1.2)
    if "outside" in table and method in stiff_methods():
        # Under strong damping their order falls, to one at worst.
        ratio = max(ratio, 2.0)
    shorter = span / np.maximum(taken, 1.0) / ratio
    again = _core.simulate(
        **table,
        method=method,
        record=record,
        step=shorter,
        max_steps=min(4 * max_steps, 2**63),
        threads=threads,
        times=times[checks].tolist(),
        # Steps of their own size go with the tolerance to the power of one over the order.
        tolerance=None if tolerance is None else tolerance / ratio**order,
    )
    seen = {
        name: None if states[name] is None else states[name][:, checks]
        for name in ("omega", "vertical", "attitude")
    }
    error = SAFETY * distances(seen, again, REST * rates) + floor[:, None]
    # What is not a number is not known; a body that was not run has no error.
    error = np.where(np.isfinite(error), error, np.inf)
    if "outside" in table and method in stiff_methods() and tolerance is None:
        # Damping can stop a body within a step: the way it turned meanwhile is lost in both runs.
        error[rates * span > np.pi * taken] = np.inf
    error[taken == 0] = np.nan
    # The one nearest to the start, with its sign.
    lost = np.where(error >= 1.0, np.abs(times[checks]), np.inf)
    nearest = lost.argmin(axis=1)
    lost_from = np.where(np.isfinite(lost.min(axis=1)), times[checks][nearest], np.inf)
    return Belief(error.max(axis=1), lost_from)


def ahead(error: float, wanted: float, order: int) -> float:
    """By which factor shorter steps bring an error below the wanted one."""
    return float(np.clip((2.0 * error / wanted) ** (1.0 / order), 1.05, 8.0))


def around(times: Floats) -> tuple[float, float]:
    """First and last of the times and 0."""
    return float(times.min(initial=0.0)), float(times.max(initial=0.0))


def span_of(times: Floats) -> float:
    """How much time is covered from 0, backward and forward."""
    first, last = around(times)
    return last - first
