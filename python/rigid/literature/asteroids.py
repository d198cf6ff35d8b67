"""Tumbling asteroids: periods, energies and a time of damping."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from ..free import damping_time, spin_periods, spin_state
from ..model.body import Body
from ..solve.simulate import simulate


def toutatis_of_1995(quantity: str) -> float:
    """A quantity of the state of Hudson and Ostro; axes short, middle and long, time in days."""
    state = spin_periods((3.22, 3.09, 1.0), np.radians([31.3, 20.7, 98.0]))
    return float(getattr(state, quantity))


def toutatis_of_2013(quantity: str) -> float:
    """A quantity of the state of Takahashi, Busch and Scheeres; time in days."""
    state = spin_periods((3.0836, 3.235, 1.0), np.radians([14.5, 33.7, -98.5]))
    return float(getattr(state, quantity))


def from_radar(days: float, turns: Sequence[float]) -> float:
    """Angle (degrees) of the rates of Toutatis by radar from the motion since 9 November 1992.

    ``turns`` are the rates (degrees a day) so many days later; no torque acts until then.
    """
    body = Body((3.0836, 3.235, 1.0))
    run = simulate(body, np.radians([14.51, 33.529, -98.709]), t=[days])
    here, there = run.omega[0], np.radians(turns)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(here, there)), here @ there)))


def radar_energy() -> float:
    """Energy of Apophis over the least with its momentum, by moments and rates of radar."""
    moments, rates = np.array([0.729, 0.947, 1.0]), np.array([96.506, 50.799, 264.953])
    return float(np.sum(moments * rates**2) / np.sum((moments * rates) ** 2))


def apophis(quantity: str) -> float:
    """A quantity of the state by moments and periods of Pravec et al.; time in hours."""
    state = spin_state((0.61, 0.965, 1.0), precession=27.38, rotation=263.0, mode="SAM")
    return float(getattr(state, quantity))


def period_of_light_curve() -> float:
    """Period (h) of the main peak of the light curve of Apophis."""
    return 1.0 / (1.0 / apophis("precession") - 1.0 / apophis("rotation"))


def period_of_damping() -> float:
    """Period (h) of a body of 1 km that is damped in 1e9 years; the time goes as its cube."""
    hour, age = 3600.0, 1e9 * 365.25 * 86400.0
    of_an_hour = damping_time(500.0, 2.0 * pi / hour, density=2000.0, rigidity=5e9, quality=100.0)
    return float((age / of_an_hour) ** (1.0 / 3.0))
