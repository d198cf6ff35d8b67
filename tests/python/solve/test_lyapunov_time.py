"""Lyapunov times with their spread, and what the error of the growth is an error of."""

import numpy as np
import pytest

import rigid

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
OMEGA, ATTITUDE = (0.3, 0.4, 1.0), (0.9, 0.3, 0.2, 0.1)


def test_the_error_of_parts_is_the_scatter_of_an_ensemble() -> None:
    """64 neighbours in one chaotic zone are independent after some hundred Lyapunov times.

    Their standard deviation is known to 1/sqrt(2 63) = 9 %, that of seven parts to 27 % of each
    body, and to 4 % of all: three of both together are a third.
    """
    near = ATTITUDE + 1e-6 * np.random.default_rng(1).normal(size=(64, 4))
    growth = rigid.lyapunov(TOP, OMEGA, near, t=np.linspace(100.0, 1600.0, 16))
    assert (growth.verdict == "chaotic").all()
    found, exponent = growth.lyapunov_time(), growth.exponent[:, -1]
    np.testing.assert_allclose(found.time, 1.0 / exponent, rtol=1e-14)
    # The error of one over a number is the error of the number over its square.
    errors = found.error * exponent**2
    ratio = np.sqrt(np.mean(errors**2)) / exponent.std(ddof=1)
    assert 0.67 < ratio < 1.5


@pytest.mark.parametrize("parts", [4, 8])
def test_the_error_of_equal_parts_is_that_of_a_mean(parts: int) -> None:
    growth = rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=np.linspace(50.0, 400.0, 8))
    log = np.concatenate([[0.0], growth.log_growth])[:: 8 // parts]
    exponents = np.diff(log) / (400.0 / parts)
    expected = exponents.std(ddof=1) / np.sqrt(parts) / exponents.mean() ** 2
    found = growth.lyapunov_time(parts)
    np.testing.assert_allclose(found.time, 1.0 / exponents.mean(), rtol=1e-14)
    np.testing.assert_allclose(found.error, expected, rtol=1e-12)


def test_regular_motions_have_no_lyapunov_time() -> None:
    """A box far from its separatrix is regular, one beside it neither."""
    box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    rates = [[1.0, 0.1, 0.1], [1e-12, 1.0, 0.0]]
    growth = rigid.lyapunov(box, rates, t=np.linspace(5.0, 40.0, 8))
    assert growth.verdict.tolist() == ["regular", "undecided"]
    found = growth.lyapunov_time()
    assert np.isinf(found.time[0])
    assert np.isnan(found.time[1])
    assert np.isnan(found.error).all()


def test_growth_has_no_error_once_the_motion_is_lost() -> None:
    """Until then it is that of the same run to an earlier time; after it none is stated."""
    times = np.array([20.0, 40.0, 60.0, 400.0, 600.0])
    whole = rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=times, step=0.05)
    assert 60.0 < whole.lost_from < 400.0
    assert whole.error < 1e-3
    again = rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=times, step=0.03, method="taylor20")
    apart = np.abs(whole.log_growth - again.log_growth)
    assert (apart[:3] <= whole.error + again.error).all()
    assert apart[-1] > 0.1  # two motions, whose growth differs by chance
    late = rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=[400.0, 600.0], step=0.05)
    assert np.isnan(late.error)


def test_parts_need_times() -> None:
    growth = rigid.lyapunov(TOP, OMEGA, ATTITUDE, t=[100.0, 200.0])
    with pytest.raises(ValueError, match="parts = 8: the run has 2 times"):
        growth.lyapunov_time()
    with pytest.raises(ValueError, match="parts = 3: must be"):
        growth.lyapunov_time(3)
