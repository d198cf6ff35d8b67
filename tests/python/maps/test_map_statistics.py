"""What a map counts: classes by construction, the share, first flips, tilts, drifts."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

import rigid
from rigid.maps.data import FAILURES
from small_maps import Floats, small_map, spec_of

COUNTS = ("stable", "unstable", "undecided", "failed")


def counted(**counts: list[int]) -> rigid.StabilityMap:
    """A result with these numbers of bodies in the pixels of a row."""
    length = len(next(iter(counts.values())))
    spec = spec_of(axes={"spin": np.arange(1.0, length + 1.0)})
    zero = np.zeros(length, dtype=np.int64)
    arrays: dict[str, Any] = dict.fromkeys((*COUNTS, *FAILURES, "checked", "steps", "exact"), zero)
    numbers = ("energy_drift", "momentum_drift", "unit_drift", "earliest")
    arrays |= {name: np.zeros(length) for name in numbers}
    arrays["status"] = zero.astype(np.uint8)
    arrays |= {name: np.array(values) for name, values in counts.items()}
    return rigid.StabilityMap.from_arrays(spec, arrays)


# The share


def test_share_is_that_of_the_decided() -> None:
    result = counted(
        stable=[3, 0, 0, 0], unstable=[1, 0, 4, 0], undecided=[6, 5, 0, 0], failed=[2, 0, 0, 7]
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
    result = counted(stable=[20, 20], unstable=[30, 30], failed=[0, 50])
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


def test_numbers_that_overflow_fail_and_harm_no_neighbour() -> None:
    options: dict[str, Any] = {
        "start": rigid.Start(spin=1.0, axis=2, tilt=0.5),
        "samples": 3,
        "step": 0.05,
    }
    result = small_map(axes={"spin": [1.0, 2.0, 1e200]}, **options)
    alone = small_map(axes={"spin": [1.0, 2.0]}, **options)
    np.testing.assert_array_equal(result.failed, [0, 0, 3])
    np.testing.assert_array_equal(result.unstable[:2], [3, 3])
    np.testing.assert_array_equal(result.earliest[:2], alone.earliest)
    np.testing.assert_array_equal(result.energy_drift[:2], alone.energy_drift)
    assert result.replay(2, 0, t=[0.0]).status == "not finite"


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
    above = i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2  # L² - 2 E I1
    below = i1 * (i3 - i1) * w1**2 + i2 * (i3 - i2) * w2**2  # 2 E I3 - L²
    assert i3 * (i3 - i2) * w3**2 > i1 * (i2 - i1) * w1**2, "a motion about the smallest axis"
    m = (i2 - i1) * below / ((i3 - i2) * above)
    p = math.sqrt((i3 - i2) * above / (i1 * i2 * i3))
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
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.2, 1.9))),
        axes={"omega1": [1.0]},
        start=rigid.Start(omega=(1.0, 0.0, 0.0)),
        stable=rigid.tilt_below(3.1, axis=3),
        method="rk4",
        samples=1,
        t_end=100.0,
        step=1.3,
        rng=1,
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
        stable=rigid.no_flip(),
        samples=2,
        t_end=20.0,
        method="rk4",
        step=0.5,
        check=0.0,
    )
    energy, momentum = result.energy_drift.max(), result.momentum_drift.max()
    assert 1.5 < energy / momentum < 2.5
    words = f"worst drift energy {energy:.1e}, momentum {momentum:.1e}, unit lengths "
    assert words in result.summary()


def test_the_summary_counts_the_bodies_that_were_repeated() -> None:
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
        axes={"spin": [1.0, 1.1]},
        start=rigid.Start(spin=1.0, axis=1, noise=rigid.normal(1e-3)),
        stable=rigid.no_flip(),
        samples=10,
        t_end=16.0,
        method="rk4",
        step=0.1,
        max_steps=160,  # enough for the step asked, not for half of it
        rng=1,
    )
    assert result.checked.sum() == 0
    assert result.undecided.sum() == result.failed.sum() == 0
    assert "none cross-checked by dop853" in result.summary()


def test_a_share_to_check_is_not_rounded_up_by_its_binary_digits() -> None:
    result = rigid.stability_map(
        rigid.FreeBody, axes={"spin": [1.0]}, samples=100, t_end=1.0, check=0.07,
        stable=rigid.no_flip(), method="rk4", rng=1, progress=False,
    )  # fmt: skip
    assert result.checked[0] == 7


def test_a_map_is_shown_with_the_share_of_each_class() -> None:
    result = small_map()
    done = int(result.samples.sum())
    for name in ("stable", "unstable", "undecided", "failed"):
        assert f"{100.0 * int(getattr(result, name).sum()) / done:.1f}% {name}" in repr(result)
