"""The cases of the stress suite: extreme and stiff bodies, family by family.

A new case is one line in the function of its family.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._checks.arrays import Floats
from ..model.body import Body
from ..model.forces import EnergySink
from ..model.orbit import Orbit
from ..model.scene import FreeBody, HeavyTop, Scene
from ..model.torque import Torque

TUMBLE = (0.3, -0.5, 1.1)
"""Rates of a body that turns about no axis in particular (rad/s)."""

TILTED = (0.8, 0.4, -0.4, 0.2)
"""A generic attitude."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One extreme body with its start and the time at which its state is compared.

    Attributes
    ----------
    family, name : str
        Name of the case: the extreme parameter and its value.
    scene : FreeBody or HeavyTop
    omega, attitude : tuple of float
        Start.
    t : float
        Time (s), perhaps negative.
    step : float or None
        The step of the run; None for a run with an accuracy.
    truth : tuple of array, or None
        Rates and attitude at ``t`` from a formula; None if the reference is the closed form or,
        without a closed form, a converged run.
    """

    family: str
    name: str
    scene: Scene
    omega: tuple[float, float, float] = TUMBLE
    attitude: tuple[float, float, float, float] = TILTED
    t: float = 10.0
    step: float | None = None
    truth: tuple[Floats, Floats] | None = None


def cases() -> tuple[Case, ...]:
    """All cases, family by family."""
    return tuple(case for family in _FAMILIES for case in family())


def _free(family: str, name: str, moments: tuple[float, float, float], **rest: Any) -> Case:
    return Case(family=family, name=name, scene=FreeBody(Body(moments)), **rest)


def _shapes() -> Iterator[Case]:
    for ratio in (1e-12, 1e-9, 1e-6, 1e-3):
        # Spinning about its length a needle nutates at 1/ratio times its rate.
        yield _free("needle", f"I3/I1 = {ratio:g}", (1.0, 1.0 - ratio / 2.0, ratio), t=4.0 * ratio)
        yield _free("needle", f"I3/I1 = {ratio:g}, symmetric", (1.0, 1.0, ratio))
    for small in (1.0, 1e-3, 1e-6, 1e-12):
        yield _free("lamina", f"moments 1, {small:g} and their sum", (1.0, small, 1.0 + small))
    yield _free("lamina", "I3/I1 = 2", (0.5, 0.5, 1.0))


def _spherical() -> Iterator[Case]:
    for digits in (3, 6, 9, 12, 15):
        apart = 10.0**-digits
        moments = (1.0, 1.0 + apart, 1.0 + 3.0 * apart)
        yield _free("near spherical", f"moments 1e-{digits} apart", moments, t=100.0)
    yield _free("near spherical", "sphere", (1.0, 1.0, 1.0), t=100.0)


def _separatrix() -> Iterator[Case]:
    for digits in (1, 2, 4, 6, 8, 10, 12, 14):
        aside = 10.0**-digits
        name, rates = f"omega = (1e-{digits}, 1, 1e-{digits})", (aside, 1.0, aside)
        yield _free("separatrix", name, (1.0, 2.0, 3.0), omega=rates, t=8.0 * digits + 20.0)
    yield _free("separatrix", "on the middle axis", (1.0, 2.0, 3.0), omega=(0.0, 1.0, 0.0), t=60.0)


def _sizes() -> Iterator[Case]:
    for power in (-12, -6, 6, 12):
        size = 10.0**power
        first, second, third = TUMBLE
        rates = (size * first, size * second, size * third)
        yield _free("spin", f"1e{power} rad/s", (1.0, 1.6, 2.0), omega=rates, t=20.0 / size)
    for unit in (-1060, -1000, 1000, 1020):
        scaled = tuple(math.ldexp(moment, unit) for moment in (1.0, 1.625, 2.0))
        yield _free("unit", f"moments near 2^{unit}", (scaled[0], scaled[1], scaled[2]))


def _top(family: str, name: str, mgl: float, *, lagrange: bool, **rest: Any) -> Case:
    body = Body((1.0, 1.0, 0.5)) if lagrange else Body((1.0, 1.6, 0.7))
    com = (0.0, 0.0, 1.0) if lagrange else (0.6, 0.0, 0.8)
    return Case(family=family, name=name, scene=HeavyTop(body, mgl=mgl, com=com), **rest)


def _leaning(tilt: float) -> tuple[float, float, float, float]:
    return (math.cos(0.5 * tilt), math.sin(0.5 * tilt), 0.0, 0.0)


def _sleeping(name: str, spin: float, tilt: float) -> Case:
    start: dict[str, Any] = {"omega": (0.0, 0.0, spin), "attitude": _leaning(tilt), "t": 30.0}
    return _top("sleeping top", name, 1.0, lagrange=True, **start)


def _tops() -> Iterator[Case]:
    for power in (-12, -6, 6, 12):
        mgl = 10.0**power
        for lagrange in (True, False):
            kind = "symmetric" if lagrange else "asymmetric"
            t = 10.0 / max(1.0, math.sqrt(mgl))
            yield _top("weight", f"mgl = 1e{power}, {kind}", mgl, lagrange=lagrange, t=t)
    for tilt in (1e-16, 1e-12, 1e-8, 1e-4, 1.0):
        for spin, state in ((3.0, "waking"), (6.0, "asleep")):
            yield _sleeping(f"{state}, tilt {tilt:g}", spin, tilt)
    for off in (-1e-12, 0.0, 1e-12):
        name = f"spin {off:+g} from the threshold" if off else "spin at the threshold"
        yield _sleeping(name, 4.0 * (1.0 + off), 1e-4)
    for tilt, pole in ((0.0, "upright"), (math.pi, "hanging")):
        for lagrange in (True, False):
            kind = "symmetric" if lagrange else "asymmetric"
            lean = _leaning(tilt)
            yield _top("pole", f"{pole}, {kind}", 1.0, lagrange=lagrange, attitude=lean)


def _times() -> Iterator[Case]:
    for t, name in ((0.0, "t = 0"), (-20.0, "t = -20"), (1e12, "t = 1e12 rad"), (1e15, "t = 1e15")):
        yield _free("time", name, (1.0, 1.6, 2.0), t=t)
        yield _top("time", f"{name}, top", 1.0, lagrange=True, t=t)
        yield _top("time", f"{name}, asymmetric top", 1.0, lagrange=False, t=t)
    # Moments and rate of the Earth (IERS Conventions 2010), its axis 0.2 arc seconds off.
    day, off, years = 7.292115e-5, 1e-6, 26_000.0 * 365.25 * 86_400.0
    for moments, name in (
        ((8.0101e37, 8.0101e37, 8.0365e37), "symmetric"),
        ((8.0101e37, 8.0103e37, 8.0365e37), "triaxial"),
    ):
        rates = (off * day, 0.0, day)
        yield _free("Earth", f"26 000 years, {name}", moments, omega=rates, t=years)


def _damped() -> Iterator[Case]:
    """Closed forms of a cube that a motor turns against damping, and of one that slows down."""
    for power in (-6, -3, 0, 3, 6, 9):
        c = 10.0**power
        t = 3.0
        for torque in (0.0, 2.0):
            motor = None if torque == 0.0 else Torque.body((0.0, 0.0, torque))
            scene = FreeBody(Body((1.0, 1.0, 1.0)), damping=c, torque=motor)
            gone = -math.expm1(-c * t)
            # (N/c)(t - (1 - e^{-ct})/c) loses its digits where c t is small: its series there.
            ahead = (
                torque * (t * t / 2.0 - c * t**3 / 6.0 + c * c * t**4 / 24.0 - c**3 * t**5 / 120.0)
                if c * t < 1e-2
                else torque / c * (t - gone / c)
            )
            rate = 1.5 * (1.0 - gone) + torque * gone / c
            angle = 1.5 * gone / c + ahead
            yield Case(
                family="damping",
                name=f"c/I = 1e{power}" + (", with a motor" if torque else ""),
                scene=scene,
                omega=(0.0, 0.0, 1.5),
                attitude=(1.0, 0.0, 0.0, 0.0),
                t=t,
                truth=(
                    np.array([0.0, 0.0, rate]),
                    np.array([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)]),
                ),
            )


def _coarse() -> Iterator[Case]:
    """Steps that are far too long: the results must be flagged."""
    for turns in (1.0, 10.0, 1000.0):
        step = 2.0 * math.pi * turns
        name = f"{turns:g} turns a step"
        yield _free("long steps", name, (1.0, 1.6, 2.0), step=step, t=40.0 * step)
        yield _top("long steps", f"{name}, top", 1.0, lagrange=False, step=step, t=40.0 * step)
        if turns > 100.0:
            continue  # the truth would take minutes
        scene = FreeBody(Body((1.0, 1.6, 2.0)), damping=1.0)
        yield Case(
            family="long steps",
            name=f"{name}, damped",
            scene=scene,
            step=step,
            t=40.0 * step,
        )


def _satellites() -> Iterator[Case]:
    """Weak and strong sinks, slow and fast rotors, and orbits slower and faster than the body."""
    body = Body((1.0, 1.6, 2.0))
    for power in (-6, -3, -1, 0):
        sink = EnergySink(10.0**power)
        yield _satellite(f"sink of 1e{power} I / |omega|", FreeBody(body, dissipation=sink))
    for power in (-6, -2, 0, 2, 4):
        h = 10.0**power
        rotor = (0.6 * h, 0.0, 0.8 * h)
        scene = FreeBody(body, rotor=rotor)
        yield _satellite(f"rotor of 1e{power} |L|", scene, t=10.0 / max(1.0, h))
    for power in (-4, -2, 0, 2):
        rate = 10.0**power
        scene = FreeBody(body, orbit=Orbit(rate))
        yield _satellite(f"orbit of 1e{power} |omega|", scene, t=10.0 / max(1.0, rate))
    needle = FreeBody(
        Body((1.0, 1.0 - 5e-4, 1e-3)),
        orbit=Orbit(1.0),
        rotor=(0.0, 1.0, 0.0),
    )
    yield _satellite("needle with a rotor on an orbit", needle, t=0.1)


def _satellite(name: str, scene: FreeBody, t: float = 10.0) -> Case:
    return Case(family="satellites", name=name, scene=scene, t=t)


_FAMILIES = (
    *(_shapes, _spherical, _separatrix, _sizes, _tops, _times, _damped, _satellites, _coarse),
)
