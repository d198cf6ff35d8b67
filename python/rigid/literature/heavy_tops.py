"""Heavy tops: sleeping, fast precession, integrable cases."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from ..exact import lagrange_top
from ..model.body import Body
from ..model.scene import HeavyTop
from ..sections.starts import on_surface
from ..solve.run import Run
from ..solve.simulate import simulate
from .entry import Entry

Floats = NDArray[np.float64]

TOP = HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)
"""A Lagrange top that sleeps from 4 rad/s on."""

STEP_OF_SPIN = 0.0025
"""Distance of the spins that are tried (rad/s)."""

FAST = 200.0
"""Spin of the fast top (rad/s)."""

LANDAU = "L. D. Landau, E. M. Lifshitz, Mechanics, 3rd edition (1976), section 35"
TEXTBOOK = "formula of the textbook, from memory"


def least_spin_of_sleep() -> float:
    """The least of a row of spins with which a top, tilted by 1e-6 rad, stays upright."""
    spins = 4.0 + STEP_OF_SPIN * (np.arange(81.0) - 40.0)
    omega = np.zeros((len(spins), 3))
    omega[:, 2] = spins
    tilted = [1.0, 0.5e-6, 0.0, 0.0]
    run = simulate(TOP, omega, tilted, t=np.linspace(0.0, 400.0, 201), accuracy=1e-9)
    assert run.gamma is not None
    stays = np.arccos(np.clip(run.gamma[..., 2], -1.0, 1.0)).max(axis=1) < 1e-3
    return float(spins[stays].min())


def precession_of_a_fast_top() -> float:
    """Mean precession of a fast top that is let go at a tilt of 60 degrees (rad/s)."""
    tilted = [cos(pi / 6.0), sin(pi / 6.0), 0.0, 0.0]
    return float(lagrange_top(TOP, [0.0, 0.0, FAST], tilted).precession)


def _runs(moments: tuple[float, float, float], l_gamma: float) -> Run:
    """Motions of eight tops of one energy, with the centre of mass on axis 1."""
    top = HeavyTop(Body(moments), mgl=1.0, com=(1.0, 0.0, 0.0))
    omega, attitude = on_surface(top, energy=1.5, l_gamma=l_gamma, count=8, rng=2026)
    return simulate(top, omega, attitude, t=np.linspace(0.0, 100.0, 401), accuracy=1e-10)


def _change(values: Floats) -> float:
    """The largest change of a quantity along a motion, over its largest size."""
    return float((np.ptp(values, axis=1) / np.abs(values).max(axis=1)).max())


def kovalevskaya_change(moments: tuple[float, float, float] = (2.0, 2.0, 1.0)) -> float:
    """Largest relative change of Kovalevskaya's integral along motions of tops."""
    run = _runs(moments, 0.5)
    assert run.gamma is not None
    # The energy has mgl gamma1, the vertical pointing up: c = mgl / I3 enters with this sign.
    flat = (run.omega[..., 0] + 1j * run.omega[..., 1]) ** 2
    flat -= (run.gamma[..., 0] + 1j * run.gamma[..., 1]) / moments[2]
    return _change(np.abs(flat) ** 2)


def goryachev_chaplygin_change(
    moments: tuple[float, float, float] = (4.0, 4.0, 1.0), l_gamma: float = 0.0
) -> float:
    """Largest relative change of the integral of Goryachev and Chaplygin along motions of tops."""
    run = _runs(moments, l_gamma)
    assert run.gamma is not None
    p, q, r = np.moveaxis(run.omega, -1, 0)
    return _change(r * (p**2 + q**2) - p * run.gamma[..., 2] / moments[2])


ENTRIES = (
    Entry(
        name="sleeping-top",
        quantity="upright top with I1 = 1, I3 = 1/2, mgl = 1: least spin with which it sleeps, "
        "from motions",
        printed="(I3 ω3)² = 4 mgl I1",
        value=4.0,
        within=STEP_OF_SPIN,
        interval="distance of the spins",
        unit="rad/s",
        source=LANDAU,
        seen=TEXTBOOK,
        compute=least_spin_of_sleep,
    ),
    Entry(
        name="fast-top",
        quantity="fast top with I1 = 1, I3 = 1/2, mgl = 1, ω3 = 200: mean rate of precession, from "
        "the closed form",
        printed="mgl/(I3 ω3)",
        value=0.01,
        within=1e-6,
        interval="next order of the formula, mgl I1/(I3 ω3)²",
        unit="rad/s",
        source=LANDAU,
        seen=TEXTBOOK,
        compute=precession_of_a_fast_top,
    ),
    Entry(
        name="kovalevskaya",
        quantity="top with I1 = I2 = 2 I3 and its centre of mass on axis 1: largest relative "
        "change of the fourth integral along motions",
        printed="|(p + i q)² - (mgl/I3)(γ1 + i γ2)|² is constant",
        value=0.0,
        within=1e-9,
        interval="error of the integration",
        source="S. Kowalevski, Sur le problème de la rotation d'un corps solide autour d'un point "
        "fixe, Acta Math. 12 (1889) 177-232, doi 10.1007/BF02592182",
        seen="moments: A. M. Perelomov, arXiv:math-ph/0111025; integral: from memory",
        compute=kovalevskaya_change,
    ),
    Entry(
        name="goryachev-chaplygin",
        quantity="top with I1 = I2 = 4 I3, its centre of mass on axis 1 and L·γ = 0: largest "
        "relative change of the fourth integral along motions",
        printed="r (p² + q²) - (mgl/I3) p γ3 is constant",
        value=0.0,
        within=1e-9,
        interval="error of the integration",
        source="D. N. Goryachev, Mat. Sb. 21 (1900) 431-438; S. A. Chaplygin, Trudy Otd. Fiz. Nauk "
        "Obshch. Lyub. Estestv. 10 (1901) 31-34; A. V. Borisov, I. S. Mamaev, arXiv:nlin/0204005",
        seen="case: arXiv:nlin/0204005; integral: from memory",
        compute=goryachev_chaplygin_change,
    ),
)
