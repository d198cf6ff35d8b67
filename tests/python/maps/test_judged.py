"""Bodies that a function of the user judges."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from refusals import refuses
from rigid.maps.plan import map_plan
from small_maps import small_map

Verdicts = NDArray[np.bool_]
ANY: Any = 3

T = np.linspace(0.0, 20.0, 401)
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.6)), mgl=1.0)
TOPS: dict[str, Any] = {
    "axes": {"spin": [2.0, 3.5, 4.0, 5.0]},
    "samples": 50,
    "rng": 7,
    "start": rigid.Start(spin=4.0, tilt=0.3, attitude_noise=rigid.normal(0.1)),
}


def keeps_its_sign(states: rigid.States) -> Verdicts:
    """As ``no_flip(2)``, as far as the looks tell."""
    kept: Verdicts = np.all(states.omega[..., 1] > 0.0, axis=1)
    return kept


def stays_low(states: rigid.States) -> Verdicts:
    """As ``tilt_below(0.6)``."""
    assert states.gamma is not None
    kept: Verdicts = np.all(states.gamma[..., 2] > np.cos(0.6), axis=1)
    return kept


def test_the_class_is_that_of_no_flip() -> None:
    """In closed form, and by two methods; two bodies graze between the looks at most."""
    for method in ("auto", "dop853", "rk4"):
        asked: dict[str, Any] = {"method": method, "t_end": 20.0}
        judged = small_map(stable=rigid.judged(keeps_its_sign, T, of="rates"), **asked)
        flips = small_map(**asked)
        assert np.abs(judged.stable - flips.stable).sum() <= 2
        assert 0.1 < judged.stable.sum() / judged.samples.sum() < 0.9
        assert (judged.exact == flips.exact).all()
        assert (judged.checked == flips.checked).all()
        assert judged.complete


def test_the_class_is_that_of_tilt_below() -> None:
    """Of tops that are integrated; the tilt is seen at looks, and its limit may be grazed."""
    judged = rigid.stability_map(TOP, stable=rigid.judged(stays_low, T, of="axis"), **TOPS)
    tilts = rigid.stability_map(TOP, stable=rigid.tilt_below(0.6), t_end=20.0, **TOPS)
    assert np.abs(judged.stable - tilts.stable).max() <= 1
    assert not judged.exact.any()
    assert (judged.checked == 50).all()
    assert not judged.failed.any()
    assert 0.1 < judged.share.mean() < 0.9


def test_the_function_sees_the_motion_and_the_parameters() -> None:
    """Bit by bit what a replay has; every body is judged by each method once."""
    seen: list[rigid.States] = []

    def look(states: rigid.States) -> Verdicts:
        seen.append(states)
        return np.ones(len(states.omega), dtype=bool)

    t = np.linspace(0.0, 4.0, 9)
    asked = {**TOPS, "samples": 3}
    for options in ({}, {"method": "rk4"}, {"method": "rk4", "step": 0.03}):
        seen.clear()
        result = rigid.stability_map(TOP, stable=rigid.judged(look, t), **asked, **options)
        assert [len(states.omega) for states in seen] == [12, 12]
        first, second = seen
        np.testing.assert_array_equal(first.t, t)
        np.testing.assert_array_equal(first.parameters["spin"], np.repeat(TOPS["axes"]["spin"], 3))
        assert first.attitude is not None
        assert second.attitude is not None
        np.testing.assert_allclose(second.attitude, first.attitude, atol=2e-3)
        one = result.replay(1, 2)
        np.testing.assert_array_equal(one.run.omega, first.omega[5])
        np.testing.assert_array_equal(one.run.attitude, first.attitude[5])
        assert one.outcome == "stable"
        assert one.parts[0].outcome == "stable"
        assert str(one.parts[0].criterion) == "judged by look"


def test_the_second_run_of_a_judged_map_is_finer() -> None:
    """By a hundredth of the tolerance and another order; where both methods are one, in half steps.

    Truth: a series by a tolerance of 1e-13.
    """
    seen: list[rigid.States] = []

    def look(states: rigid.States) -> Verdicts:
        seen.append(states)
        return np.ones(len(states.omega), dtype=bool)

    stable = rigid.judged(look, np.linspace(0.0, 20.0, 9))
    few = {**TOPS, "samples": 3}
    rigid.stability_map(TOP, stable=stable, **few)
    errors = []
    for states in seen:
        assert states.attitude is not None
        start = (states.omega[:, 0], states.attitude[:, 0])
        truth = rigid.simulate(
            TOP, *start, t=states.t, method="taylor20", tolerance=1e-13, check=False
        )
        errors.append(np.abs(states.omega - truth.omega).max(axis=(1, 2)))
    assert (errors[1] < 0.1 * errors[0]).all()  # by one tolerance they would be alike

    for step in ({}, {"step": 0.03}):
        options: dict[str, Any] = {**few, **step}
        once, twice = (
            rigid.stability_map(TOP, stable=stable, method="taylor16", check=check, **options)
            for check in (0.0, 1.0)
        )
        # Nine intervals have whole numbers of steps.
        share = (twice.steps - once.steps) / once.steps
        assert share == pytest.approx(2.0, rel=0.05)


def test_the_cost_of_a_judged_map_is_the_processor_time_of_its_function() -> None:
    spent = 0.0

    def slow(states: rigid.States) -> Verdicts:
        nonlocal spent
        begin = time.thread_time()
        while time.thread_time() < begin + 0.02:
            pass
        spent += time.thread_time() - begin
        return np.ones(len(states.omega), dtype=bool)

    begin = time.process_time()
    result = rigid.stability_map(TOP, stable=rigid.judged(slow, [1.0]), threads=1, **TOPS)
    whole = time.process_time() - begin
    assert spent <= 1e-9 * result.nanoseconds.sum() <= whole


def test_the_cost_of_a_judged_map_contains_the_threads_of_the_core() -> None:
    def upright(states: rigid.States) -> Verdicts:
        assert states.gamma is not None
        return np.asarray(states.gamma[:, -1, 2] > 0.9)

    begin = time.process_time()
    request = {**TOPS, "samples": 2048, "check": 1.0}
    result = rigid.stability_map(TOP, stable=rigid.judged(upright, [60.0]), threads=2, **request)
    whole = time.process_time() - begin
    # The caller's thread has half of the steps, and those take nearly all of the time.
    assert 0.75 * whole <= 1e-9 * result.nanoseconds.sum() <= whole


def test_numbers_are_margins_and_nan_is_undecided() -> None:
    def margin(states: rigid.States) -> NDArray[np.float64]:
        spin = states.parameters["spin"]
        return np.where(spin == 3.5, np.nan, spin - 4.0)

    result = rigid.stability_map(TOP, stable=rigid.judged(margin, [1.0], of="rates"), **TOPS)
    assert result.unstable.tolist() == [50, 0, 50, 0]
    assert result.undecided.tolist() == [0, 50, 0, 0]
    assert result.stable.tolist() == [0, 0, 0, 50]


def test_a_second_method_that_disagrees_leaves_the_body_undecided() -> None:
    calls = iter(range(100))

    def fickle(states: rigid.States) -> Verdicts:
        return np.full(len(states.omega), next(calls) % 2 == 0)

    result = rigid.stability_map(
        TOP, stable=rigid.judged(fickle, [1.0], of="rates"), check=0.4, **TOPS
    )
    assert (result.undecided == 20).all()
    assert (result.stable == 30).all()
    assert (result.checked == 20).all()


def test_each_horizon_has_the_bits_of_its_own_map() -> None:
    axes = {"spin": [3.5, 4.0], "t_end": [5.0, 20.0]}
    for options in ({}, {"method": "rk4"}):
        asked = {**TOPS, **options, "axes": axes}
        every = rigid.stability_map(
            TOP, stable=rigid.judged(stays_low, T), measure=rigid.drift(), **asked
        )
        for place, t_end in enumerate((5.0, 20.0)):
            single = rigid.stability_map(
                TOP,
                stable=rigid.judged(stays_low, T[t_end >= T]),
                measure=rigid.drift(),
                **{**asked, "axes": {"spin": [3.5, 4.0]}},
            )
            for name in ("stable", "undecided", "steps", "energy_drift", "momentum_drift"):
                np.testing.assert_array_equal(getattr(every, name)[place], getattr(single, name))
            np.testing.assert_array_equal(
                every.measures["drift"].mean[place], single.measures["drift"].mean
            )
        assert every.replay((0, 1), 3).run.t[-1] == 5.0


def test_the_function_takes_limit_and_horizon_from_the_axes() -> None:
    def below(states: rigid.States) -> Verdicts:
        assert states.gamma is not None
        assert (states.parameters["t_end"] == states.t[-1]).all()
        low: Verdicts = np.all(
            states.gamma[..., 2] > np.cos(states.parameters["limit"])[:, None], axis=1
        )
        return low

    axes = {"spin": [3.5, 4.0], "limit": [0.4, 0.6], "t_end": [5.0, 20.0]}
    result = rigid.stability_map(
        TOP, stable=rigid.judged(below, T, of="axis"), **{**TOPS, "axes": axes}
    )
    plain = rigid.stability_map(
        TOP,
        stable=rigid.judged(stays_low, T, of="axis"),
        **{**TOPS, "axes": {"spin": [3.5, 4.0], "t_end": [5.0, 20.0]}},
    )
    np.testing.assert_array_equal(result.stable[:, 1], plain.stable)
    assert (result.stable[:, 0] < result.stable[:, 1]).any()
    body = result.replay((1, 0, 1), 2)
    assert body.outcome == result.outcomes(2).outcome[1, 0, 1]
    assert result.condition().shape == (2, 2, 2)


@pytest.mark.parametrize("method", ["auto", "rk4"])
def test_values_are_those_of_any_criterion(method: str) -> None:
    """Flips, tilts and mean rates do not depend on what is judged; drifts are those of its runs."""
    own = (rigid.flips(2), rigid.largest_tilt(), rigid.mean_rate(-3))
    asked: dict[str, Any] = {**TOPS, "method": method}
    judged = rigid.stability_map(
        TOP, stable=rigid.judged(stays_low, T, of="axis"), measure=[rigid.drift(), *own], **asked
    )
    tilts = rigid.stability_map(TOP, stable=rigid.tilt_below(0.6), t_end=20.0, measure=own, **asked)
    for name in tilts.measures:
        np.testing.assert_array_equal(judged.measures[name].bins, tilts.measures[name].bins)
    worst = np.fmax.reduce([judged.energy_drift, judged.momentum_drift, judged.unit_drift])
    np.testing.assert_array_equal(judged.measures["drift"].largest, worst)
    body = judged.replay(2, 7)
    assert body.measures == {
        name: values[2] for name, values in judged.outcomes(7).measures.items()
    }


def test_files_have_the_digest_of_the_function(tmp_path: Path) -> None:
    result = rigid.stability_map(TOP, stable=rigid.judged(stays_low, T, of="axis"), **TOPS)
    path = result.save(tmp_path / "map.npz")
    bare = rigid.load_map(path)
    with pytest.raises(ValueError, match=r"stable: a file has no functions; give 'stays_low'"):
        bare.replay(0, 0)
    with pytest.raises(ValueError, match=r"stable = keeps_its_sign: its source differs from"):
        rigid.load_map(path, stable=keeps_its_sign)
    assert bare.spec.criterion == "judged by stays_low until t = 20 s"


def test_bodies_that_fail_are_not_judged() -> None:
    """Steps that are far too long lose the energy."""
    count = 0

    def look(states: rigid.States) -> Verdicts:
        nonlocal count
        count += len(states.omega)
        assert np.isfinite(states.omega).all()
        return np.ones(len(states.omega), dtype=bool)

    stable = rigid.judged(look, [20.0], of="rates")
    result = rigid.stability_map(TOP, stable=stable, method="rk4", step=1.0, check=0.0, **TOPS)
    assert result.failed.sum() > 0
    assert count == result.stable.sum()
    assert (result.drifted + result.not_finite == result.failed).all()
    # A drift of no number would say that no body was integrated.
    assert np.array_equal(np.isinf(result.energy_drift), result.not_finite > 0)
    stopped = rigid.stability_map(TOP, stable=stable, max_steps=3, check=0.0, **TOPS)
    assert (stopped.step_limit == 50).all()


@pytest.mark.parametrize("of", ["attitude", "axis"])
def test_a_free_body_has_a_vertical(of: Any) -> None:
    """The body turns about its vertical axis 3, or about axis 1 at right angles to the vertical."""

    def stays_upright(states: rigid.States) -> Verdicts:
        assert states.gamma is not None
        np.testing.assert_allclose(np.linalg.norm(states.gamma, axis=-1), 1.0, atol=1e-12)
        upright: Verdicts = states.gamma[..., 2].min(axis=1) > 0.99
        return upright

    for axis, share in ((3, 1.0), (1, 0.0)):
        result = rigid.stability_map(
            rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
            axes={"spin": [1.0, 2.0]},
            start=rigid.Start(spin=1.0, axis=axis, attitude=(1.0, 0.0, 0.0, 0.0)),
            stable=rigid.judged(stays_upright, [0.0, 1.0, 2.0], of=of),
            samples=2,
            rng=1,
        )
        assert (result.share == share).all()


def test_under_torque_and_damping() -> None:
    """Bodies of one pixel are computed together, and brake alike."""
    body = rigid.Body((1.0, 1.5, 2.0))

    def brakes(states: rigid.States) -> Verdicts:
        speed = np.linalg.norm(states.omega, axis=-1)
        slowed: Verdicts = speed[:, -1] < 0.5 * speed[:, 0]
        return slowed

    result = rigid.stability_map(
        rigid.FreeBody(body, damping=0.1),
        axes={"damping1": [0.0, 2.0], "damping2": [0.0, 2.0]},
        start=rigid.Start(spin=1.0, axis=1, noise=rigid.normal(1e-3)),
        stable=rigid.judged(brakes, [0.0, 2.0], of="rates"),
        samples=4,
        rng=1,
    )
    assert result.stable.tolist() == [[0, 4], [0, 4]]


def test_plans_and_closed_forms() -> None:
    free = small_map(stable=rigid.judged(keeps_its_sign, T), method="exact", samples=1)
    assert map_plan(free.spec).method == "exact"
    assert (free.exact == 1).all()
    top = rigid.stability_map(TOP, stable=rigid.judged(stays_low, T), **{**TOPS, "samples": 1})
    assert map_plan(top.spec).method != "exact"
    assert (top.exact == 0).all()


test_bad_input_is_named = refuses(
    [
        (lambda: rigid.judged(ANY, T), TypeError, "function = 3: must be a function"),
        (lambda: rigid.judged(stays_low, []), "t: must be times from 0 on"),
        (lambda: rigid.judged(stays_low, [-1.0, 1.0]), "t: must be times from 0 on"),
        (lambda: rigid.judged(stays_low, [2.0, 1.0]), "times must be ascending"),
        (lambda: rigid.judged(stays_low, T, of="all"), "of = 'all': must be one of"),
        (
            lambda: rigid.judged(stays_low, T) & rigid.no_flip(),
            r"judged\(\) has a function, which can join conditions itself: it is not joined",
        ),
        (
            lambda: small_map(stable=rigid.judged(stays_low, T), t_end=10.0),
            r"t_end = 10: must be 20, the last time of judged\(\), or left out",
        ),
        (
            lambda: rigid.stability_map(
                TOP, stable=rigid.judged(stays_low, T), **{**TOPS, "axes": {"t_end": [10.01, 20.0]}}
            ),
            r"axes\['t_end'\]\[0\] = 10.01: must be a time of judged\(\)",
        ),
        (
            lambda: small_map(stable=rigid.judged(stays_low, T), measure=rigid.time_to_leave()),
            r"measure: judged\(\) has no time_to_leave",
        ),
        (
            lambda: small_map(stable=rigid.judged(lambda states: states.omega, T)),
            r"must return a boolean or a number for each body, of shape \(\d+,\), got float64 of",
        ),
        (
            lambda: small_map(samples=1).spec.with_functions(stable=keeps_its_sign),
            "stable: this map has no custom criterion",
        ),
        (
            lambda: rigid.stability_map(
                rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.6)), mgl=1.0),
                stable=rigid.judged(stays_low, T),
                method="exact",
                **TOPS,
            ),
            "no closed form of judged by stays_low .*centre of mass on the third axis, and of a",
        ),
    ]
)
