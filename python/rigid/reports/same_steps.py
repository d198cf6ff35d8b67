"""Which names are one method on the bodies of a report: they make the same steps, bit for bit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..solve.methods import EXACT, order_of
from .ensemble import Ensemble

__all__ = ["same_steps"]

ANGLES = tuple(2.0**k for k in range(-2, 5))
"""Angles (rad) by which the bodies turn in a step. Series of high orders agree bit for bit in short
steps; in long ones not every method arrives."""

STEPS = 4
"""Steps of each length; the rounding of the first step may hide a difference."""


def same_steps(ensemble: Ensemble, names: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
    """Each method that differs from all others on these bodies, and its other names.

    Many methods are one on simple bodies: without damping exponential Runge-Kutta is Runge-Kutta,
    and whatever moves a symmetric free body by its exact flow makes the same steps. The name of the
    highest order stands for all, of equal orders the first.
    """
    groups: dict[object, list[str]] = {}
    for name in names:
        groups.setdefault(_bits(ensemble, name), []).append(name)
    same = {}
    for group in groups.values():
        best = group[0] if len(group) == 1 else max(group, key=order_of)
        same[best] = tuple(name for name in group if name != best)
    return {name: same[name] for name in names if name in same}


def _bits(ensemble: Ensemble, method: str) -> object:
    """The bits of the states after some steps of several lengths."""
    if method == EXACT:
        return method
    rate, torque = float(ensemble.rates.max()), ensemble.spec.scene.torque
    known = torque.times[-1] if torque is not None and torque.times else math.inf
    every: list[tuple[bytes, bytes] | None] = []
    for angle in ANGLES:
        step = min(angle / rate if rate > 0.0 else ensemble.spec.t_end, known / STEPS)
        try:
            run = ensemble.run_until(STEPS * step, method, step)
        except ValueError:  # so long a step would be unstable
            every.append(None)
            continue
        assert run.attitude is not None
        every.append((run.omega.tobytes(), run.attitude.tobytes()))
    return method if all(bits is None for bits in every) else tuple(every)
