"""The 95 % interval of a share: published values, its two tails, and how often it covers."""

import numpy as np
import pytest
from scipy.special import betaincinv
from scipy.stats import binom, binomtest

from refusals import refuses
from rigid import _core
from rigid.maps.data import CONFIDENCE, interval
from small_maps import Floats

HALF = 0.025


def all_intervals(trials: int) -> tuple[Floats, Floats]:
    """The intervals of 0, 1, ... successes."""
    successes = np.arange(trials + 1)
    return interval(successes, np.full_like(successes, trials))


@pytest.mark.parametrize(
    ("successes", "trials", "lower", "upper"),
    [
        # R. G. Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 5.
        (81, 263, 0.2527, 0.3676),
        (15, 148, 0.0578, 0.1617),
        (0, 20, 0.0, 0.1684),
        (1, 29, 0.0009, 0.1776),
    ],
)
def test_clopper_pearson_interval_has_the_published_values(
    successes: int, trials: int, lower: float, upper: float
) -> None:
    found = interval(np.array([successes]), np.array([trials]))
    assert found[0][0] == pytest.approx(lower, abs=5e-5)
    assert found[1][0] == pytest.approx(upper, abs=5e-5)


@pytest.mark.parametrize("trials", [1, 2, 3, 4, 7, 16, 64, 256, 1000, 10**4, 10**5, 10**6])
def test_intervals_are_quantiles_of_the_beta_distribution(trials: int) -> None:
    """SciPy's own error grows to 8e-13 at 10^6 trials; the core is compared with 90 digits."""
    k = np.unique(np.linspace(0, trials, 200).astype(np.int64))
    lower, upper = interval(k, np.full_like(k, trials))
    some, fewer = k > 0, k < trials
    np.testing.assert_allclose(
        lower[some], betaincinv(k[some], trials - k[some] + 1, HALF), rtol=1e-12
    )
    np.testing.assert_allclose(
        upper[fewer], betaincinv(k[fewer] + 1, trials - k[fewer], 1.0 - HALF), rtol=0, atol=1e-12
    )
    # Exactly, or a certain prediction would lie outside.
    assert (lower[~some].tolist(), upper[~fewer].tolist()) == ([0.0], [1.0])
    expected = binomtest(int(k[-2]), trials).proportion_ci(0.95, method="exact")
    assert (lower[-2], upper[-2]) == pytest.approx((expected.low, expected.high), rel=1e-9)


def test_a_share_and_its_complement_have_mirrored_intervals() -> None:
    lower, upper = all_intervals(100)
    np.testing.assert_array_equal(upper, 1.0 - lower[::-1])
    assert (np.diff(lower) > 0.0).all()


def coverage(trials: int) -> tuple[Floats, Floats]:
    """True shares, and the chances with which the intervals of their counts hold them."""
    lower, upper = all_intervals(trials)
    even = np.linspace(0.0, 1.0, 20_001)
    small = np.geomspace(1e-7, 0.5, 2_000)
    # Coverage jumps at the ends of intervals: from both sides.
    ends = np.concatenate([lower, upper])
    beside = [np.nextafter(ends, 0.0), np.nextafter(ends, 1.0)]
    shares = np.concatenate([even, small, 1.0 - small, ends, *beside])
    holds = (lower <= shares[:, np.newaxis]) & (shares[:, np.newaxis] <= upper)
    chances = binom.pmf(np.arange(trials + 1), trials, shares[:, np.newaxis])
    return shares, (holds * chances).sum(axis=1)


@pytest.mark.parametrize("trials", [1, 2, 3, 5, 8, 16, 64, 256])
def test_intervals_cover_every_true_share_as_often_as_they_say(trials: int) -> None:
    """Exact coverage: the binomial chances of the counts whose interval holds the true share.

    Wilson's interval, which maps had before, covers 84 % at worst: of 64 bodies, at 0.0027.
    """
    lower, upper = all_intervals(trials)
    _, covered = coverage(trials)
    # The sum of some hundred chances is rounded to 1e-13.
    assert covered.min() >= CONFIDENCE - 1e-13
    # No interval is wider than it must be: a little shorter at either end, and a tail is lost.
    k = np.arange(1, trials + 1)
    np.testing.assert_allclose(binom.sf(k - 1, trials, lower[1:]), HALF, rtol=1e-11)
    np.testing.assert_allclose(binom.cdf(k - 1, trials, upper[:-1]), HALF, rtol=1e-11)


@pytest.mark.parametrize("trials", [128, 256, 400])
def test_intervals_are_no_wider_than_counts_allow(trials: int) -> None:
    """They cover 95 to 97 % where counts scatter by 5 or more, and always at the ends.

    There an interval covers always or never, because only one count is possible.
    """
    shares, covered = coverage(trials)
    common = trials * shares * (1.0 - shares) >= 25.0
    assert common.any()
    assert covered[common].max() <= 0.97
    assert (covered[np.isin(shares, [0.0, 1.0])] == 1.0).all()


def test_pixels_have_the_intervals_of_their_own_counts() -> None:
    successes = np.array([[3, 0, 3], [0, 64, 0]])
    trials = np.array([[64, 64, 3], [0, 64, 64]])
    lower, upper = interval(successes, trials)
    for place in np.ndindex(2, 3):
        one = interval(successes[place].reshape(1), trials[place].reshape(1))
        np.testing.assert_array_equal([lower[place], upper[place]], np.ravel(one))
    assert np.isnan([lower[1, 0], upper[1, 0]]).all()


def test_other_levels_are_those_asked_for() -> None:
    k, n = np.array([5]), np.array([64])
    lower, upper = _core.clopper_pearson(k, n, 0.965)
    assert binom.sf(4, 64, lower[0]) == pytest.approx(0.0175, rel=1e-12)
    assert binom.cdf(5, 64, upper[0]) == pytest.approx(0.0175, rel=1e-12)


test_counts_that_cannot_be_have_no_interval = refuses(
    [
        ([2], [1], 0.95, "successes = 2 of 1: must be at most the trials"),
        ([-1], [1], 0.95, "successes = -1: must not be negative"),
        ([0], [-1], 0.95, "trials = -1: must not be negative"),
        ([1], [2**51], 0.95, "trials = 2251799813685248: must be at most 2\\^50"),
        ([1], [2], 0.0, "confidence = 0: must lie between 0 and 1"),
        ([1], [2], np.nan, "confidence = NaN: must lie between 0 and 1"),
        ([1, 1], [2], 0.95, r"trials: expected shape \(2, ...\), got \(1, ...\)"),
    ],
    by=lambda successes, trials, confidence: _core.clopper_pearson(
        np.array(successes), np.array(trials), confidence
    ),
)
