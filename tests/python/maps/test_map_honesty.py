"""What a map says of itself: intervals cover as they say, and wrong verdicts are caught."""

from typing import Any

import numpy as np
import pytest

import rigid
from small_maps import small_map

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
COARSE = [
    ("throw", "splitting", 0.03),
    ("throw", "splitting", 0.0625),
    ("throw", "splitting4", 0.0625),
    ("top", "splitting", 0.2),
    ("top", "splitting", 1.25),
    ("top", "splitting4", 1.25),
    ("top", "chin4a", 1.25),
    ("top", "dop853", 0.625),
]


@pytest.mark.parametrize(("name", "method", "step"), COARSE)
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


def test_reasons_of_failure_sum_up() -> None:
    """Faster bodies overflow, a fast one drifts."""
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"spin": [1.0, 30.0, 1e200]},
        start=rigid.Start(spin=1.0, axis=3, tilt=0.8),
        stable=rigid.no_flip(3),
        method="rk4",
        step=0.1,
        samples=3,
        t_end=100.0,
        rng=1,
    )
    assert result.drifted.tolist() == [0, 3, 0]
    assert result.not_finite.tolist() == [0, 0, 3]
    assert "6 failed (66.67%): 3 not finite, 3 drifted" in result.summary()
    np.testing.assert_array_equal(result.failed, result.not_finite + result.drifted)


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
