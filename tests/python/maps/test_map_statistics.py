"""What a map counts: classes by construction, the share, first flips, tilts, drifts."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.special import betaincinv, ellipk, ellipkinc
from scipy.stats import binom, binomtest

import rigid
from free_motions import of_jacobi
from refusals import refuses
from rigid import _core
from rigid.maps.data import CONFIDENCE, interval
from small_maps import Floats, small_map, spec_of

COUNTS = ("stable", "unstable", "undecided", "failed")


def counted(**counts: list[int]) -> rigid.StabilityMap:
    """A result with these numbers of bodies in the pixels of a row."""
    spec = spec_of(axes={"spin": np.arange(1.0, len(counts["stable"]) + 1.0)}, samples=100)
    return rigid.StabilityMap.from_counts(spec, **counts)


# The share


def test_share_is_that_of_the_decided() -> None:
    result = counted(
        stable=[3, 0, 0, 0], unstable=[1, 0, 4, 0], undecided=[6, 5, 0, 0], drifted=[2, 0, 0, 7]
    )
    np.testing.assert_array_equal(result.share, [0.75, np.nan, 0.0, np.nan])
    np.testing.assert_array_equal(result.samples, [12, 5, 4, 7])
    np.testing.assert_array_equal(np.isnan(result.lower), [False, False, False, True])
    np.testing.assert_array_equal(np.isnan(result.upper), [False, False, False, True])


def test_undecided_bodies_widen_the_interval_both_ways() -> None:
    # They count as unstable for the lower end and as stable for the upper one.
    result = counted(stable=[20, 20, 30, 20], unstable=[30, 40, 30, 30], undecided=[10, 0, 0, 0])
    assert result.lower[0] == result.lower[1]
    assert result.upper[0] == result.upper[2]
    assert result.share[0] == result.share[3]
    assert result.lower[0] < result.lower[3]
    assert result.upper[0] > result.upper[3]


def test_failed_bodies_are_no_evidence() -> None:
    result = counted(stable=[20, 20], unstable=[30, 30], drifted=[0, 50])
    assert result.lower[0] == result.lower[1]
    assert result.upper[0] == result.upper[1]
    assert result.share[0] == result.share[1]


# Classes by construction


@pytest.mark.parametrize("method", ["rk4", "splitting"])
def test_a_body_whose_step_is_far_too_long_gets_no_verdict(method: str) -> None:
    # Three turns a step: what comes out is no motion. RK4 loses the energy at once; the splitting
    # keeps it bounded, but not the class that the second method finds.
    result = small_map(
        axes={"spin": [1e-3, 20.0]},
        start=rigid.Start(spin=1.0, axis=2, tilt=0.5),
        samples=5,
        step=1.0,
        t_end=1e5,
        method=method,
    )
    assert result.failed[0] == result.undecided[0] == 0
    assert result.failed[1] + result.undecided[1] == 5
    assert math.isnan(result.share[1])
    if method == "rk4":
        assert result.replay(1, 0, t=[0.0]).status in ("not finite", "drifted")
        assert result.energy_drift[1] > 0.1  # what failed is stated too


def test_a_body_that_needs_more_steps_than_allowed_has_failed() -> None:
    # A spin of 8 needs eight times the steps of a spin of 1.
    options: dict[str, Any] = {
        "axes": {"spin": [1.0, 8.0]},
        "start": rigid.Start(spin=1.0, axis=3),
        "samples": 4,
        "check": 0.0,
    }
    needed = small_map(**options).steps // 4
    result = small_map(**options, max_steps=int(needed[0]))
    np.testing.assert_array_equal(result.stable, [4, 0])
    for of_steps in (result.failed, result.step_limit):
        np.testing.assert_array_equal(of_steps, [0, 4])
    assert result.steps[1] == 0
    body = result.replay(1, 2)
    assert (body.outcome, body.status, body.steps) == ("failed", "step limit", 0)
    assert body.run.t.tolist() == [0.0]
    assert body.run.omega[0].tolist() == body.omega.tolist() == [0.0, 0.0, 8.0]
    assert small_map(**options, max_steps=int(needed[0]) - 1).failed.tolist() == [4, 4]


# Undecided

# 32 steps: two whole bursts, and so are 64 of half the size. Left to itself, the second method
# would take longer ones.
COARSE, HORIZON = 1.0, 32.0


def near_the_horizon(method: str, *, step: float, check: float, samples: int = 8) -> Any:
    """Bodies without noise whose first flip comes just before or after the horizon."""
    return small_map(
        axes={"spin": np.linspace(0.6, 0.9, 6001)},
        start=rigid.Start(spin=1.0, axis=2, tilt=1e-3),
        samples=samples,
        t_end=HORIZON,
        step=step,
        check=check,
        method=method,
    )


@pytest.mark.parametrize("method", ["rk4", "splitting"])
def test_undecided_is_a_body_that_the_second_method_puts_in_another_class(method: str) -> None:
    full = near_the_horizon(method, step=COARSE, check=0.0)
    second = near_the_horizon("dop853", step=COARSE / 2, check=0.0)
    for result in (full, second):
        assert not result.undecided.any()
        assert not result.checked.any()
        np.testing.assert_array_equal(
            result.steps[result.stable > 0], 8 * HORIZON / result.spec.step
        )
    changes = full.stable != second.stable
    assert changes.sum() >= 1, "the two flip at the same side of the horizon everywhere"
    assert (full.stable + full.unstable == 8).all()

    for check, checked in ((1.0, 8), (0.25, 2), (0.26, 3), (1e-9, 1)):
        result = near_the_horizon(method, step=COARSE, check=check)
        np.testing.assert_array_equal(result.checked, checked)
        np.testing.assert_array_equal(result.undecided, np.where(changes, checked, 0))
        kept = np.where(changes, 8 - checked, 8)
        np.testing.assert_array_equal(result.stable, np.where(full.stable > 0, kept, 0))
        np.testing.assert_array_equal(result.unstable, np.where(full.unstable > 0, kept, 0))
        np.testing.assert_array_equal(result.failed, 0)
        both = checked * (full.steps + second.steps) + (8 - checked) * full.steps
        np.testing.assert_array_equal(result.steps, both // 8)
        pixel = int(np.flatnonzero(changes)[0])
        assert result.replay(pixel, checked - 1).outcome == "undecided"
        if checked < 8:
            assert result.replay(pixel, checked).outcome in ("stable", "unstable")


def test_a_fine_step_decides_everything() -> None:
    assert not near_the_horizon("rk4", step=COARSE / 16, check=1.0, samples=1).undecided.any()


# The first flip


def first_zero_of_the_middle_rate(moments: Floats, omega: Floats) -> float:
    """Exact time, for moments ascending and a motion about the largest axis; omega3 > 0.

    omega = (A1 cn, A2 sn, A3 dn)(p t + F(phi0, m), m): Landau and Lifshitz, Mechanics, § 37.
    """
    i1, i2, i3 = moments
    w1, w2, w3 = omega
    assert i3 * (i3 - i2) * w3**2 > i1 * (i2 - i1) * w1**2, "a motion about the smallest axis"
    m, p, below = of_jacobi(moments, omega)
    a1, a2 = math.sqrt(below / (i1 * (i3 - i1))), math.sqrt(below / (i2 * (i3 - i2)))
    phase = math.atan2(w2 / a2, w1 / a1)
    target = 0.0 if phase < 0.0 else 2.0 * float(ellipk(m))
    return (target - float(ellipkinc(phase, m))) / p


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("splitting", 2)])
@pytest.mark.parametrize("omega", [(0.5, 0.3, 1.2), (-0.4, 0.8, 0.9), (0.6, -0.5, 1.1)])
def test_the_earliest_flip_is_that_of_the_elliptic_functions(
    omega: tuple[float, float, float], method: str, order: int
) -> None:
    exact = first_zero_of_the_middle_rate(np.array([1.0, 1.5, 2.0]), np.array(omega))
    steps = 0.1 * 0.5 ** np.arange(5)
    errors = []
    for step in steps:
        result = small_map(
            axes={"omega1": [omega[0]]},
            start=rigid.Start(omega=omega),
            stable=rigid.no_flip(2),
            samples=1,
            check=0.0,
            step=float(step),
            t_end=16.0,  # a whole number of bursts of every step, which is therefore kept
            method=method,
        )
        assert result.unstable.tolist() == [1]
        errors.append(abs(result.earliest[0] - exact))
    # The cubic that locates the zero inside the step is itself of order 4. The step ends elsewhere
    # in the flip each time, so its part of the error scatters and single ratios do too.
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.5)
    assert errors[-1] < (1e-7 if order == 4 else 1e-3)


# Tilts


def test_a_direction_that_lost_its_length_gives_no_verdict() -> None:
    """The rates of a permanent rotation are exact for any step, the direction carried is not."""
    result = small_map(
        rigid.FreeBody(rigid.Body((1.0, 1.2, 1.9))),
        axes={"omega1": [1.0]},
        start=rigid.Start(omega=(1.0, 0.0, 0.0)),
        stable=rigid.tilt_below(3.1, axis=3),
        samples=1,
        t_end=100.0,
        step=1.3,
    )
    assert result.failed[0] == 1
    assert result.replay(0, 0, t=[0.0]).status == "drifted"


def test_a_map_says_by_which_quantity_its_bodies_failed() -> None:
    """Runge-Kutta steps of order 4 of a steady turn shrink what turns, and change nothing else.

    A direction across the axis shrinks in the square by 1 - z^6/72 + z^8/576 in a step, with the
    turn z of a step; the error is that of half the square after the 16 steps of a block. At half
    the length of the step the body is within the limit of 0.1 until the horizon.
    """
    coarse, fine = (
        small_map(
            rigid.FreeBody(rigid.Body((1.0, 1.2, 1.9))),
            axes={"omega1": [1.0, 1.1]},
            start=rigid.Start(omega=(1.0, 0.0, 0.0)),
            stable=rigid.tilt_below(3.13, axis=3),
            samples=2,
            t_end=100.0,
            step=step,
            check=0.0,
        )
        for step in (1.25, 0.625)
    )
    shrunk = [1.0 - z**6 / 72.0 + z**8 / 576.0 for z in (1.25, 1.1 * 1.25)]
    np.testing.assert_allclose(coarse.unit_drift, 0.5 * (1.0 - np.array(shrunk) ** 16), rtol=1e-12)
    np.testing.assert_array_equal(coarse.drifted, 2)
    for result in (coarse, fine):
        assert max(result.energy_drift.max(), result.momentum_drift.max()) < 1e-14
        words = f"unit lengths {result.unit_drift.max():.1e} (relative)"
        (line,) = (one for one in result.summary().splitlines() if one.startswith("worst drift"))
        assert line.endswith(words)
    assert coarse.replay(1, 0, t=[0.0]).unit_drift == coarse.unit_drift[1]
    np.testing.assert_array_equal(fine.failed, 0)
    z = np.array([1.0, 1.1]) * 0.625
    assert fine.unit_drift.max() < 0.1
    square = (1.0 - z**6 / 72.0 + z**8 / 576.0) ** 160
    np.testing.assert_allclose(fine.unit_drift, 0.5 * (1.0 - square), rtol=1e-11)


def test_the_summary_tells_each_drift_by_its_name() -> None:
    """Steps of ``rk4`` shorten the rates of a turning body: its energy errs twice as much as L."""
    result = small_map(
        rigid.FreeBody(rigid.Body((1.0, 1.2, 1.9))),
        axes={"spin": [1.0, 1.1]},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
        samples=2,
        step=0.5,
        check=0.0,
    )
    energy, momentum = result.energy_drift.max(), result.momentum_drift.max()
    assert 1.5 < energy / momentum < 2.5
    words = f"worst drift energy {energy:.1e}, momentum {momentum:.1e}, unit lengths "
    assert words in result.summary()


def test_the_summary_counts_the_bodies_that_were_repeated() -> None:
    result = small_map(
        rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
        axes={"spin": [1.0, 1.1]},
        start=rigid.Start(spin=1.0, axis=1, noise=rigid.normal(1e-3)),
        t_end=16.0,
        step=0.1,
        max_steps=160,  # enough for the step asked, not for half of it
    )
    assert result.checked.sum() == 0
    assert result.undecided.sum() == result.failed.sum() == 0
    assert "none cross-checked by dop853" in result.summary()


def test_a_share_to_check_is_not_rounded_up_by_its_binary_digits() -> None:
    assert small_map(axes={"spin": [1.0]}, samples=100, t_end=1.0, check=0.07).checked[0] == 7


def test_a_map_is_shown_with_the_share_of_each_class() -> None:
    result = small_map()
    done = int(result.samples.sum())
    for name in ("stable", "unstable", "undecided", "failed"):
        assert f"{100.0 * int(getattr(result, name).sum()) / done:.1f}% {name}" in repr(result)


# The 95 % interval of a share: its two tails, and how often it covers.


HALF = 0.025


def all_intervals(trials: int) -> tuple[Floats, Floats]:
    """The intervals of 0, 1, ... successes."""
    successes = np.arange(trials + 1)
    return interval(successes, np.full_like(successes, trials))


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


@cache
def coverage(trials: int) -> tuple[Floats, Floats]:
    """True shares, and the chances with which the intervals of their counts hold them."""
    lower, upper = all_intervals(trials)
    even = np.linspace(0.0, 1.0, 2001)
    small = np.geomspace(1e-7, 0.5, 200)
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


# What a map says of itself: intervals cover as they say, and wrong verdicts are caught.


SIDE = 80


def maps() -> dict[str, dict[str, Any]]:
    """A throw and a top, one body in each pixel, both with closed forms to judge by."""
    return {
        "throw": {
            "scene": rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)),
            "axes": {
                "b": np.linspace(0.012, 0.248, SIDE),
                "noise": np.geomspace(1e-4, 1.0, SIDE),
            },
            "start": rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)),
            "stable": rigid.no_flip(2),
            "t_end": 1.0,
        },
        "top": {
            "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
            "axes": {
                "spin": np.linspace(1.0, 6.0, SIDE),
                "tilt": np.linspace(0.01, 1.0, SIDE),
            },
            "stable": rigid.tilt_below(1.2),
            "t_end": 20.0,
        },
    }


# Steps at which the method alone judges some of the bodies wrongly.
TOO_LONG = [
    ("throw", "splitting", 0.03),
    ("throw", "splitting", 0.0625),
    ("throw", "splitting4", 0.0625),
    ("top", "splitting", 0.2),
    ("top", "splitting", 1.25),
    ("top", "splitting4", 1.25),
    ("top", "chin4a", 1.25),
    ("top", "dop853", 0.625),
]


@pytest.mark.parametrize(("name", "method", "step"), TOO_LONG)
def test_wrong_verdicts_of_coarse_steps_are_caught(name: str, method: str, step: float) -> None:
    options: dict[str, Any] = {"samples": 1, "rng": 5, "progress": False, **maps()[name]}
    truth = rigid.stability_map(**options, method="exact")
    alone = rigid.stability_map(**options, method=method, step=step, check=0.0)
    checked = rigid.stability_map(**options, method=method, step=step)
    judged = (alone.failed == 0) & (truth.undecided == 0)
    wrong = judged & (alone.stable != truth.stable)
    assert wrong.sum() >= 5, "the steps are not coarse enough to show anything"
    assert checked.undecided[wrong].mean() >= 0.99
    # The second method is right but within 1e-12 of the border: it flags no right verdict here.
    assert checked.undecided[judged & ~wrong].mean() <= 0.001
    # Failed is failed with either.
    np.testing.assert_array_equal(checked.failed, alone.failed)


def test_reasons_of_failure_sum_up_and_harm_no_neighbour() -> None:
    """Faster bodies overflow, a fast one drifts."""
    options: dict[str, Any] = {
        "start": rigid.Start(spin=1.0, axis=3, tilt=0.8),
        "step": 0.1,
        "samples": 3,
        "t_end": 100.0,
    }
    result = small_map(axes={"spin": [1.0, 30.0, 1e200]}, **options)
    alone = small_map(axes={"spin": [1.0, 30.0]}, **options)
    assert result.drifted.tolist() == [0, 3, 0]
    assert result.not_finite.tolist() == [0, 0, 3]
    assert "6 failed (66.67%): 3 not finite, 3 drifted" in result.summary()
    np.testing.assert_array_equal(result.failed, result.not_finite + result.drifted)
    for name in ("stable", "unstable", "earliest", "energy_drift"):
        np.testing.assert_array_equal(getattr(result, name)[:2], getattr(alone, name))
    assert result.replay(2, 0, t=[0.0]).status == "not finite"


@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_a_pair_of_flips_inside_a_long_step_is_seen(method: str) -> None:
    """In two of these pixels the rate passes zero and comes back within a long step."""
    options: dict[str, Any] = {
        "axes": {
            "omega1": np.linspace(-1.5, 1.5, 41),
            "omega2": np.linspace(-1.5, 1.5, 40),
        },
        "start": rigid.Start(omega=(0.0, 0.0, 0.4), tilt=0.7),
        "stable": rigid.no_flip(3),
        "t_end": 3.0,
        "samples": 1,
        "check": 0.0,
        "rng": 1,
    }
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    fine = rigid.stability_map(top, method="rk4", step=2e-3, **options)
    long = rigid.stability_map(top, method=method, **options)
    np.testing.assert_array_equal(long.stable, fine.stable)


# The share that is checked

GROUP = 64
"""Bodies with common audits."""

COM = np.array([0.36, 0.24, 1.1]) / np.linalg.norm([0.36, 0.24, 1.1])
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0, com=COM)
REQUEST: dict[str, Any] = {
    "method": "auto",
    "axes": {"mgl": np.linspace(0.05, 1.2, 6), "noise": [1e-3, 1e-2, 1e-1]},
    "start": rigid.Start(spin=1.5, axis=3, noise=rigid.normal(1e-3)),
    "stable": rigid.tilt_below(3.0),
    "t_end": 20.0,
    "samples": 2 * GROUP + 20,
}


@pytest.fixture(scope="module")
def asymmetric() -> rigid.StabilityMap:
    return small_map(TOP, **REQUEST)


def test_two_or_three_bodies_of_each_group_are_audited(asymmetric: rigid.StabilityMap) -> None:
    """The first two and the one that ran longest, if it is another."""
    groups = 3
    assert ((2 * groups <= asymmetric.audited) & (asymmetric.audited <= 3 * groups)).all()
    assert (asymmetric.audited <= asymmetric.checked).all()
    # The motion inside a step errs by 1e-6 rad, which asks for a margin of 0.03 rad.
    assert asymmetric.checked.sum() < 0.3 * asymmetric.samples.sum()
    assert not asymmetric.audited_undecided.any()


def test_the_summary_tells_the_audit(asymmetric: rigid.StabilityMap) -> None:
    words = (
        f"{asymmetric.checked.sum():,} cross-checked by dop853, "
        f"{asymmetric.audited.sum():,} of these as an audit: 0 differ"
    )
    assert words in asymmetric.summary()


def test_the_classes_are_those_of_a_check_of_all(asymmetric: rigid.StabilityMap) -> None:
    everything = small_map(TOP, **REQUEST, check=1.0)
    np.testing.assert_array_equal(everything.audited, everything.checked)
    np.testing.assert_array_equal(everything.checked, everything.samples)
    for name in ("stable", "unstable", "undecided", "failed", "earliest"):
        np.testing.assert_array_equal(getattr(asymmetric, name), getattr(everything, name), name)


def test_no_wrong_class_of_coarse_steps_is_kept() -> None:
    """The steps err by 0.01 rad and more, for which no margin is wide enough."""
    coarse: dict[str, Any] = {**REQUEST, "method": "splitting", "step": 0.4}
    alone, checked = small_map(TOP, **coarse, check=0.0), small_map(TOP, **coarse)
    truth = small_map(TOP, **{**REQUEST, "method": "dop853"})
    assert np.abs(alone.stable - truth.stable).sum() >= 100
    assert checked.checked.sum() > 0.5 * checked.samples.sum()
    assert (np.abs(checked.stable - truth.stable) <= checked.undecided).all()


def test_a_flip_does_not_tell_its_margin() -> None:
    flips = small_map(TOP, **{**REQUEST, "stable": rigid.no_flip(3)})
    np.testing.assert_array_equal(flips.checked, flips.samples)
    np.testing.assert_array_equal(flips.audited, flips.samples)


def test_chaotic_bodies_are_seen_by_the_audits() -> None:
    """Tops whose errors grow by a factor of 1e8: a check of all bodies leaves some undecided."""
    rng = np.random.default_rng(1072)
    moments = np.sort(rng.uniform(0.5, 2.0, 3))
    moments[2] = min(moments[2], 0.95 * (moments[0] + moments[1]))
    moments = rng.permutation(moments)
    com = rng.standard_normal(3)
    rng.choice([20, 50, 100, 200])
    limit, spin = float(rng.uniform(1.5, 3.1)), float(rng.uniform(0.5, 3.0))
    axis, tilt = int(rng.integers(1, 4)), float(rng.uniform(0.0, 2.0))
    top = rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=com / np.linalg.norm(com))
    request: dict[str, Any] = {
        "method": "auto",
        "axes": {"mgl": np.linspace(0.1, 3.0, 8), "noise": np.geomspace(1e-4, 0.3, 6)},
        "start": rigid.Start(spin=spin, axis=axis, tilt=tilt, noise=rigid.normal(1e-3)),
        "stable": rigid.tilt_below(limit),
        "t_end": 100.0,
        "samples": GROUP,
        "rng": 72,
    }
    some, everything = small_map(top, **request), small_map(top, **request, check=1.0)
    assert everything.undecided.sum() >= 20
    assert some.checked.sum() < 0.5 * some.samples.sum()
    np.testing.assert_array_equal(some.undecided, everything.undecided)
