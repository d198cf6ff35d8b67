"""How fast a top leaves an unstable rest, against the textbook's exponents."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from rigid.solve.saddle import START, RateSizes, departure
from rigid.solve.starts import bodies_of

SMALL = 1e-9
TIMES = np.array([0.0, 1.0, 2.0, 4.0])


def departures(top: rigid.HeavyTop, spin: float) -> NDArray[np.float64]:
    """Of a top that spins upright, tilted by next to nothing."""
    tilted = rigid.rotations.exp_quaternion(np.array([SMALL, 0.0, 0.0]))
    bodies = bodies_of(top, np.array([0.0, 0.0, spin]), tilted)
    # Relative to fast rates those of the fall add nothing to its angle.
    fast = np.array([1e9])
    found: NDArray[np.float64] = departure(bodies, TIMES, RateSizes(fast, fast, fast))[0]
    return found


@pytest.mark.parametrize("spin", [0.0, 1.0, 3.0])
def test_a_slow_sleeping_top_falls_with_its_exponent(spin: float) -> None:
    """`exponent² = mgl / I1 - (I3 spin / 2 I1)²`, as the characteristic equation has it."""
    mgl, first, third = 6.0, 2.0, 0.8
    top = rigid.HeavyTop(rigid.Body((first, first, third)), mgl=mgl)
    exponent = np.sqrt(mgl / first - (third * spin / (2.0 * first)) ** 2)
    found = departures(top, spin)
    # The tilt and the eigenvalue are rounded relative to one, which the tilt itself is far below.
    np.testing.assert_allclose(found, START * np.expm1(exponent * TIMES), rtol=1e-6)


@pytest.mark.parametrize("moments", [(2.0, 1.2, 1.0), (1.2, 2.0, 1.0)])
def test_an_upright_pendulum_falls_about_its_smaller_moment(
    moments: tuple[float, float, float],
) -> None:
    top = rigid.HeavyTop(rigid.Body(moments), mgl=6.0)
    exponent = np.sqrt(6.0 / min(moments[:2]))
    np.testing.assert_allclose(departures(top, 0.0), START * np.expm1(exponent * TIMES), rtol=1e-6)


def test_a_fast_sleeping_top_stays() -> None:
    top = rigid.HeavyTop(rigid.Body((2.0, 2.0, 0.8)), mgl=6.0)
    assert not departures(top, 20.0).any()
