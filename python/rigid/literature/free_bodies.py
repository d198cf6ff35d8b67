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
from .entry import Entry

RACKET = (0.00121, 0.01638, 0.01748)
"""Moments of a tennis racket (kg m²)."""
RACKET_SEEN = (
    "formula of the textbook, from memory; moments of the racket by Ashbaugh, Chicone and "
    "Cushman, J. Dyn. Differ. Equ. 3 (1991) 67, as a thread of physics.stackexchange.com has them"
)
LANDAU = "L. D. Landau, E. M. Lifshitz, Mechanics, 3rd edition (1976), section 37"
TEXTBOOK = "formula of the textbook, from memory"

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


ENTRIES = (
    Entry(
        name="middle-axis-growth",
        quantity="tennis racket at 1 rad/s about its middle axis: growth rate of a perturbation, "
        "from its motion",
        printed="ω √((I2 - I1)(I3 - I2)/(I1 I3))",
        value=growth_by_formula(),
        within=1e-6,
        interval="size of the perturbation",
        unit="1/s",
        source=LANDAU,
        seen=RACKET_SEEN,
        compute=growth_by_motion,
    ),
    Entry(
        name="flip-period",
        quantity="tennis racket thrown at 10 rad/s about its middle axis (Dzhanibekov's effect): "
        "period of the flips, from an integration",
        printed="4 K √(I1 I2 I3/((I3 - I2)(L² - 2 E I1)))",
        value=period_by_formula(),
        within=1e-9,
        interval="error of the integration",
        unit="s",
        source=LANDAU,
        seen=RACKET_SEEN,
        compute=period_by_motion,
    ),
    Entry(
        name="feynman-plate",
        quantity="thin plate, thrown with a small wobble: rate of the wobble over the spin, from "
        "its motion",
        printed="2",
        within=WOBBLE**2,
        interval="size of the wobble",
        source="S. Tuleja, B. Gazovic, A. Tomori, J. Hanc, Feynman's wobbling plate, Am. J. Phys. "
        "75 (2007) 240-244",
        seen="letter of B. Holst, New Scientist, 14 January 1995: the wobble is twice as fast, and "
        "not the spin, as Feynman tells it; S. M. Blinder, Wolfram Demonstrations (2011)",
        compute=wobble_of_a_plate,
    ),
    Entry(
        name="geometric-phase",
        quantity="free asymmetric body: turn about L in a period of the rates, modulo a turn, from "
        "the closed form",
        printed="2 E T/L - solid angle",
        value=phase_by_formula(),
        within=1e-12,
        interval="rounding of the quadrature",
        unit="rad",
        source="R. Montgomery, How much does the rigid body rotate? A Berry's phase from the 18th "
        "century, Am. J. Phys. 59 (1991) 394-398",
        seen=TEXTBOOK,
        compute=phase_by_closed_form,
    ),
    Entry(
        name="explorer-1-flat-spin",
        quantity="long satellite with dissipation, I3/I1 = 50, that spins about its length: final "
        "rate about the axis of the largest moment, over the first",
        printed="I1/I3",
        value=0.02,
        within=1e-8,
        interval="size of the first nutation",
        source="R. N. Bracewell, O. K. Garriott, Rotation of artificial Earth satellites, Nature "
        "182 (1958) 760-762",
        seen="the story of Explorer 1: J. H. Lienhard, Engines of Our Ingenuity 47 and 1332; the "
        "formula is constant angular momentum",
        compute=flat_spin,
    ),
)
