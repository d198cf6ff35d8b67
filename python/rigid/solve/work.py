"""The work of a call in units that hold on any machine, and the time of a unit on this one.

The unit is a step of a reference run, its set-up shared out: ratios of costs are much the same on
all processors, times are not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import IDENTITY
from .bodies import Bodies
from .request import Request

__all__ = ["LANES", "MANY", "Work", "reference_nanoseconds", "unit_nanoseconds"]

Floats = NDArray[np.float64]

LANES = 32
"""Number of bodies that take a step side by side, in packs."""

PACK = 8
"""Bodies of a pack: a body alone takes as long as all of them."""

MANY = 1024
"""Number of bodies of a call if it is unknown."""

STEPS = 512
"""Steps of the reference run."""

PROBES = 4
"""Number of reference runs; the fastest counts, because another program may interrupt some."""


@dataclass(frozen=True, slots=True)
class Work:
    """The work of a call by its parts, in units.

    Attributes
    ----------
    call, body : float
        Once for each call and for each body.
    group_state, state : float
        For each output state: of a group of bodies side by side, and of a body.
    step_of_one, step : float
        A step of a group with one body, and of a full group.
    end : float
        Another end of steps in a group: bodies of unlike steps reach an output time one after
        another, and the others go on.
    """

    call: float
    body: float
    group_state: float
    state: float
    step_of_one: float
    step: float
    end: float

    def of_a_body(self, bodies: int, states: int, steps: float, ends: float = 1.0) -> float:
        """The work of one of so many bodies, each with so many states and steps.

        The bodies of a group reach each output time after so many unlike numbers of steps.
        """
        full, rest = divmod(bodies, LANES)
        step = full * self.step
        if rest:
            share = (math.ceil(rest / PACK) - 1) / (LANES / PACK - 1)
            step += (1.0 - share) * self.step_of_one + share * self.step
        of_a_state = self.group_state + (ends - 1.0) * self.end
        states_of_groups = states * math.ceil(bodies / LANES) * of_a_state
        of_call = self.call + states_of_groups + steps * step
        return of_call / bodies + self.body + states * self.state


def reference_nanoseconds() -> float:
    """Processor time of a unit (ns), measured now: it takes about 0.1 ms."""
    count = LANES
    bodies = Bodies(
        kind="top",
        shape=(count,),
        moments=np.array([[1.0, 1.2, 0.5]]),
        weight=np.array([[0.6, 0.0, 0.8]]),
        omega=np.tile([0.1, 0.2, 2.0], (count, 1)),
        attitude=IDENTITY[np.newaxis],
    )
    request = Request(
        bodies=bodies,
        times=np.ones(1),
        method="rk4",
        record="attitude",
        max_steps=STEPS,
        threads=1,
    )
    return float(request.states(np.full(count, 1.0 / STEPS))["nanoseconds"]) / STEPS


@cache
def unit_nanoseconds() -> float:
    """Processor time of a unit on this machine (ns), measured once."""
    return min(reference_nanoseconds() for _ in range(PROBES))
