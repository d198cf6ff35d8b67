"""Heavy tops: sleeping, fast precession, integrable cases."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from .._checks.arrays import Floats
from ..exact import lagrange_top
from ..model.body import Body
from ..model.scene import HeavyTop
from ..sections.starts import on_surface
from ..solve.run import Run
from ..solve.simulate import simulate

TOP = HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)
"""A Lagrange top that sleeps from 4 rad/s on."""

STEP_OF_SPIN = 0.0025
"""Distance of the spins that are tried (rad/s)."""

FAST = 200.0
"""Spin of the fast top (rad/s)."""


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
