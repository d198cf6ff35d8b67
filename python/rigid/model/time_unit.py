"""The unit in which words and pictures of a map show times; its numbers have their own unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import tau
from typing import TypeAlias

import numpy as np

from .._checks.arguments import brief, finite_float
from .scene import Scene

LENGTHS: Mapping[str, float] = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "a": 31557600.0}
"""Units of time by their names, and their lengths in seconds; ``a`` is the Julian year."""

ORBIT = "orbit"
"""The period of the orbit of a scene as a unit."""

LONGEST_NAME = 40
"""Most letters of a name, so that it fits beside a number."""

TimeUnit: TypeAlias = str | tuple[str, float]


@dataclass(frozen=True, slots=True)
class Clock:
    """Times and rates in words.

    Attributes
    ----------
    name : str
        Name of the unit.
    size : float
        Its length in the unit of the numbers.
    by_motion : bool
        Whether the numbers are in units of an orbit: its mean motion is 1.
    """

    name: str = "s"
    size: float = 1.0
    by_motion: bool = False

    def time(self, t: float) -> str:
        """A time of the map in words.

        >>> Clock().time(100.0), Clock("d", 86400.0).time(6.048e6), Clock("orbit", tau).time(500.0)
        ('100 s', '70 d', '79.6 orbits')
        """
        if self == SECONDS:
            return f"{t:g} s"
        count = f"{t / self.size:.3g}"
        return f"{count} {self.name}{'s' if self.name == ORBIT and count != '1' else ''}"

    def rate(self, rate: float) -> str:
        """A rate of the map, such as an exponent, in words.

        >>> Clock().rate(0.05), Clock("orbit", tau).rate(0.02)
        ('0.05/s', '0.126/orbit')
        """
        return f"{rate * self.size:.3g}/{self.name}"

    def shown(self, unit: str) -> tuple[str, float]:
        """The unit in which numbers of this unit are shown, and the factor that they get."""
        if unit == "s":
            return f"{self.name}s" if self.name == ORBIT else self.name, 1.0 / self.size
        if unit == "1/s":
            return f"1/{self.name}", self.size
        return ("n" if self.by_motion and unit == "rad/s" else unit), 1.0


SECONDS = Clock()
"""Times are shown as they are."""


def clock_of(time_unit: object, scene: Scene) -> Clock:
    """The clock of a unit for a scene.

    Raises
    ------
    ValueError
        If no unit has this name; if a given length is not positive; if the scene has no orbit with
        one period.
    """
    if isinstance(time_unit, (tuple, list)) and len(time_unit) == 2:
        name, size = time_unit
        if not isinstance(name, str) or not 0 < len(name) <= LONGEST_NAME:
            raise ValueError(
                f"time_unit = {brief(time_unit)}: the name must have 1 to {LONGEST_NAME} letters"
            )
        return Clock(name, finite_float("time_unit[1]", size, positive=True))
    if time_unit == ORBIT:
        orbit = scene.orbit
        if orbit is None or np.size(orbit.rate) != 1 or np.max(orbit.eccentricity) > 1.0:
            raise ValueError("time_unit = 'orbit': the scene must have one orbit with a period")
        rate = float(orbit.rate)
        return Clock(ORBIT, tau / rate, by_motion=rate == 1.0)
    if not isinstance(time_unit, str) or time_unit not in LENGTHS:
        names = ", ".join(map(repr, (*LENGTHS, ORBIT)))
        raise ValueError(
            f"time_unit = {brief(time_unit)}: must be one of {names}, or a name and its length, "
            "such as ('sol', 88775.2)"
        )
    return Clock(time_unit, LENGTHS[time_unit])
