"""A closed form errs by a rounding for each radian turned, and says so."""

from __future__ import annotations

import numpy as np
import pytest

import rigid

#: A ball: its rate is constant, so that the angle turned is known.
BALL = rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)))
OMEGA = np.array([1.0, -2.0, 2.0])
RATE, ROUNDING = 3.0, 1e-15

#: Each component of the rates is bounded by the energy.
BOUND = np.sqrt(3.0) * RATE


@pytest.mark.parametrize("t", [[0.0], [0.25], [1e3], [-7.0], [-40.0, 2.0], [1e3, 1e6]])
def test_the_error_is_a_rounding_for_each_radian(t: list[float]) -> None:
    run = rigid.simulate(BALL, OMEGA, t=t)
    span = max(t[-1], 0.0) - min(t[0], 0.0)
    assert run.error == pytest.approx(ROUNDING * (1.0 + BOUND * span), rel=1e-12, abs=0.0)
    assert run.lost_from == np.inf


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_after_so_many_radians_the_phase_is_lost(sign: float) -> None:
    run = rigid.simulate(BALL, OMEGA, t=np.sort(sign * np.array([1.0, 3e14])))
    assert run.error >= 1.0
    assert run.lost_from == pytest.approx(sign / (ROUNDING * BOUND), rel=1e-12)
    assert run.flagged
