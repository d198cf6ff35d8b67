"""Stated errors of the midpoint rule where its own errors are known in closed form.

A step of a sphere turns it by `2 atan(h omega / 2)`. Damping at the rate `k` multiplies
the rate by `(1 - h k / 2) / (1 + h k / 2)`, close to -1 in long steps, where `exp(-h k)` is 0.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

import rigid

INERTIA = 2.0
SPHERE = rigid.Body([INERTIA] * 3)

FOURFOLD = 4.0
"""Three times the difference of two runs, which is the whole error at most, and what rings."""


def lag(steps: int, angle: float) -> float:
    """By how much the rule is late after steps of this angle (rad)."""
    return float(steps * (angle - 2.0 * np.arctan(angle / 2.0)))


def spinning(steps: int, angle: float, times: list[float]) -> rigid.Run:
    """A sphere after so many equal steps of this angle (rad)."""
    spin = [0.0, 0.0, steps * angle / times[-1]]
    step = times[-1] / steps
    return rigid.simulate(rigid.FreeBody(SPHERE), spin, t=times, method="midpoint", step=step)


@pytest.mark.parametrize("angle", [0.1, 0.2, 0.3, 0.35, 0.5])
def test_the_lag_of_a_sphere_is_stated(angle: float) -> None:
    """Also where the two runs are compared on the way: from 0.3 rad a step on."""
    error = lag(100, angle)
    run = spinning(100, angle, [1.0])
    assert run.steps == 100
    assert error < run.error < FOURFOLD * error


@pytest.mark.parametrize("end", [0.05, 20.0])
def test_two_runs_that_part_by_a_whole_turn_are_told_apart(end: float) -> None:
    """In half the steps it is late by a quarter: both runs are about a third of a turn off."""
    steps, low, high = 800, 0.1, 1.0
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        parted = lag(steps, middle) - lag(2 * steps, 0.5 * middle)
        low, high = (middle, high) if parted < 2.0 * np.pi else (low, middle)
    off = lag(steps, low) % (2.0 * np.pi)
    assert off > 2.0
    # A time soon after the start does not show it.
    assert spinning(steps, low, [end / steps, end]).error > off


def damped(damping: ArrayLike, rates: ArrayLike, times: list[float], steps: int) -> rigid.Run:
    scene = rigid.FreeBody(SPHERE, damping=damping)
    step = times[-1] / steps
    return rigid.simulate(scene, rates, t=times, method="midpoint", step=step, record="rates")


@pytest.mark.parametrize(("product", "steps"), [(100, 64), (100, 16), (3, 8)])
def test_rates_that_damping_should_have_ended_are_stated(product: float, steps: int) -> None:
    """Of steps of so many damping times, of which some is left after an even number of them.

    The truth is below 1e-5 of what is recorded, so that all of that is error. Stated is three times
    by what two runs part, the second of twice the steps, and what is left of the first. What
    they part by is relative to the rates of the first, which err by as much.
    """
    end, half = 1.4, 0.5 * product
    strength = INERTIA * product * steps / end
    run = damped(strength, [0.0, 0.0, 1e-3], [0.5 * end, end], steps)
    taken = np.array([steps // 2, steps])
    left = ((half - 1.0) / (half + 1.0)) ** taken
    again = ((half / 2 - 1.0) / (half / 2 + 1.0)) ** (2 * taken)
    np.testing.assert_allclose(run.omega[:, 2], 1e-3 * left, rtol=1e-9)
    parted = 3.0 * np.abs(left - again) / left[0]
    parted = np.where(parted < 1.0, parted / (1.0 - parted), parted)
    assert run.error == pytest.approx(np.max(parted + left / left[0]), rel=1e-6)
    assert run.flagged


def test_rates_that_damping_leaves_alone_are_stated() -> None:
    """Of steps of 1e7 damping times both runs leave the rates as they were."""
    run = damped(INERTIA * 1e7 * 64, [0.0, 0.0, 1e-3], [1.0], 64)
    assert run.omega[0, 2] == pytest.approx(1e-3, rel=1e-4)
    assert 1.0 <= run.error < FOURFOLD
    assert run.flagged


def test_nothing_rings_at_the_start() -> None:
    """Relative to the start, which is exact, the rest is small."""
    steps, product = 64, 8.0
    run = damped(INERTIA * product * steps, [0.0, 0.0, 1.0], [0.0, 1.0], steps)
    off = abs(run.omega[1, 2])
    assert off == pytest.approx((3.0 / 5.0) ** steps, rel=1e-6)
    assert off < run.error < FOURFOLD * off + 1e-13


def test_a_body_at_rest_does_not_ring() -> None:
    assert damped(1e6, [0.0, 0.0, 0.0], [1.0], 4).error < 1e-14


def test_a_small_rate_that_rings_beside_a_large_one_that_has_ended() -> None:
    """The first rate falls below one, as it should; the third stays at one, and should not."""
    steps, slow = 64, 10.0
    run = damped(np.diag([slow, 1e8, 1e8]), [100.0, 0.0, 1.0], [1.0], steps)
    truth = np.array([[100.0 * np.exp(-slow / INERTIA), 0.0, 0.0]])
    np.testing.assert_allclose(run.omega[:, 0], truth[:, 0], rtol=0.01)
    assert run.omega[0, 2] == pytest.approx(1.0, abs=1e-3)
    off = np.linalg.norm(run.omega - truth) / np.linalg.norm(run.omega)
    assert off > 0.8
    assert run.error > off


def test_a_step_that_resolves_the_damping_does_not_ring() -> None:
    """`h k = 1/16`: the rate falls as it should, in five damping times."""
    rate = 5.0
    run = damped(INERTIA * rate, [0.0, 0.0, 1.0], [0.2, 1.0], 80)
    truth = np.exp(-rate * np.array([0.2, 1.0]))
    off = np.abs(run.omega[:, 2] - truth).max() / truth.max()
    assert off < run.error < FOURFOLD * off
