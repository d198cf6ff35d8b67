"""Free bodies: the middle axis, the wobbling plate, the geometric phase, the flat spin."""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np

from ..exact import agm
from ..free import asymmetric_free_top
from ..model.body import Body
from ..model.events import crosses
from ..model.forces import EnergySink
from ..model.scene import FreeBody
from ..solve.frequencies import frequencies
from ..solve.simulate import simulate

RACKET = (0.00121, 0.01638, 0.01748)
"""Moments of a tennis racket (kg m²)."""

FLIPPING = (0.0, 10.0, 0.1)
"""Rates of the racket thrown about its middle axis (rad/s)."""

WOBBLE = 0.01
"""Rate of the plate across its axis, over its spin."""

PHASE_BODY, PHASE_START = (1.0, 2.0, 3.0), (0.1, 0.5, 1.0)
"""A body and rates (rad/s) for the geometric phase."""

ROD = (1.0, 49.0, 50.0)
"""Moments of a long satellite."""


def growth_by_formula() -> float:
    """Growth rate of a perturbation of the rotation about the middle axis at 1 rad/s."""
    i1, i2, i3 = RACKET
    return sqrt((i2 - i1) * (i3 - i2) / (i1 * i3))


def growth_by_motion() -> float:
    """Growth rate of a perturbation of 1e-10, between the times with exp(k t) = e⁸ and e¹⁴."""
    times = np.array([8.0, 14.0]) / growth_by_formula()
    run = simulate(FreeBody(Body(RACKET)), [1e-10, 1.0, 0.0], t=times, record="rates")
    first, last = np.abs(run.omega[:, 0])
    return log(last / first) / float(times[1] - times[0])


def period_by_formula() -> float:
    """Period of the motion by the elliptic integral of Landau and Lifshitz, eq. (37.12)."""
    i1, i2, i3 = RACKET
    moments = np.array(RACKET)
    rates = np.array(FLIPPING)
    twice_energy, square = float(moments @ rates**2), float(moments**2 @ rates**2)
    # The motion encircles the axis of the largest moment: L² > 2 E I2.
    complement = (
        (i3 - i1) * (square - twice_energy * i2) / ((i3 - i2) * (square - twice_energy * i1))
    )
    quarter = 0.5 * pi / float(agm(1.0, sqrt(complement)))
    unit = sqrt(i1 * i2 * i3 / ((i3 - i2) * (square - twice_energy * i1)))
    return 4.0 * quarter * unit


def period_by_motion() -> float:
    """Time between two flips of the same sense, from an integration that looks for them."""
    run = simulate(
        FreeBody(Body(RACKET)),
        FLIPPING,
        t=[0.0, 10.0],
        method="taylor16",
        events=crosses("omega2", 0.0, -1),
    )
    (flips,) = run.events
    return float(flips.t[1] - flips.t[0])


def wobble_of_a_plate() -> float:
    """Rate at which the axis of a thin plate goes round, over its spin, from its motion."""
    moments = np.array([1.0, 1.0, 2.0])
    t = np.linspace(0.0, 100.0, 2001)
    run = simulate(FreeBody(Body(moments)), [WOBBLE, 0.0, 1.0], t=t)
    axis = run.rotation().apply([0.0, 0.0, 1.0])
    pole = run.momentum("space")[0]
    across = np.cross(pole, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    ahead = np.cross(pole / np.linalg.norm(pole), across)
    return float(frequencies(t, axis @ across + 1j * (axis @ ahead)).frequency[0])


def phase_by_formula() -> float:
    """``2 E T / L`` less the solid angle of the polhode of L, modulo a turn (rad)."""
    moments, rates = np.array(PHASE_BODY), np.array(PHASE_START)
    period = float(asymmetric_free_top(moments, rates).period)
    # The trapezium rule over a period of a smooth function converges faster than any power.
    t = np.linspace(0.0, period, 513)
    motion = asymmetric_free_top(moments, rates, t=t)
    assert motion.omega is not None
    momentum = motion.omega * moments
    size = float(np.linalg.norm(momentum[0]))
    unit = momentum / size
    rate = np.cross(unit, motion.omega)
    turning = (unit[:, 0] * rate[:, 1] - unit[:, 1] * rate[:, 0]) / (1.0 + unit[:, 2])
    solid = abs(float(turning[:-1].mean()) * period)
    twice_energy = float(moments @ rates**2)
    return (twice_energy * period / size - solid) % (2.0 * pi)


def phase_by_closed_form() -> float:
    """The turn of the body about L in a period of its rates, modulo a turn (rad)."""
    return float(asymmetric_free_top(PHASE_BODY, PHASE_START).turn) % (2.0 * pi)


def flat_spin() -> float:
    """Final rate of a long body with dissipation that began to spin at 1 rad/s about its length."""
    scene = FreeBody(Body(ROD), dissipation=EnergySink(0.5))
    run = simulate(scene, [1.0, 1e-5, 0.0], t=[0.0, 2e5], record="rates")
    return float(np.abs(run.omega[-1, 2]))
