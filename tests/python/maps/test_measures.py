"""Measures of maps against brute force over their bodies."""

import math
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from map_kinds import EVERY_MEASURE
from refusals import refuses
from rigid import _core
from rigid.maps.measured import Measured
from rigid.model.measures import Measure

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)
SAMPLES = 300


def measured(**options: Any) -> rigid.StabilityMap:
    chosen: dict[str, Any] = {
        "axes": {"spin": [2.0, 3.0, 4.5]},
        "samples": SAMPLES,
        "t_end": 8.0,
        "start": rigid.Start(spin=3.0, tilt=0.2, attitude_noise=rigid.normal(0.2)),
        "stable": rigid.tilt_below(0.6),
        "measure": EVERY_MEASURE,
        "rng": 7,
    }
    return rigid.stability_map(TOP, **{**chosen, **options})


def each_body(result: rigid.StabilityMap) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The value of each measure of each body, (measures, pixels, samples)."""
    measures = result.outcomes(range(result.spec.samples)).measures
    return np.array([*measures.values()])


def test_numbers_are_those_of_all_bodies() -> None:
    result = measured()
    values = each_body(result)
    assert [*result.measures] == [
        "time_to_leave",
        "flips(2)",
        "largest_tilt(3)",
        "mean_rate(1)",
        "mean_rate(-3)",
        "drift",
    ]
    for one, of_measure in zip(result.measures.values(), values, strict=True):
        for pixel, row in enumerate(of_measure):
            known = np.sort(row[~np.isnan(row)])
            assert one.count[pixel] == known.size
            if not known.size:
                assert math.isnan(one.mean[pixel])
                assert math.isnan(one.quantile(0.5)[pixel])
                continue
            assert (one.least[pixel], one.largest[pixel]) == (known[0], known[-1])
            mean = sum(map(Fraction, known)) / len(known)
            assert one.mean[pixel] == float(mean)
            spread = sum((Fraction(x) - mean) ** 2 for x in known) / (len(known) - 1)
            assert one.std[pixel] == pytest.approx(math.sqrt(spread), rel=1e-15)
            for q in ("0", "0.1", "0.5", "0.9", "0.99", "1"):
                exact = known[max(math.ceil(Fraction(q) * known.size) - 1, 0)]
                assert one.quantile(float(q))[pixel] == pytest.approx(exact, rel=1 / 64, abs=0.0)
    assert result.measures["flips"].largest.max() > 2
    # Whole numbers have bins of their own.
    quantiles = result.measures["flips"].quantile([0.25, 0.5])
    np.testing.assert_array_equal(quantiles, np.round(quantiles))


def test_the_summary_tells_mean_range_and_unit_of_each_measure() -> None:
    result = measured()
    values = dict(zip(result.measures, each_body(result), strict=True))
    lines = result.summary().splitlines()
    for name, unit in (("flips(2)", ""), ("time_to_leave", " s"), ("mean_rate(1)", " rad/s")):
        known = values[name][~np.isnan(values[name])]
        numbers = (
            f"mean {known.mean():.4g}{unit}, from {known.min():.4g} to {known.max():.4g}{unit}"
        )
        (told,) = (line for line in lines if f"{name}: mean" in line)
        assert f"{name}: {numbers}, " in told
        assert f"of {known.size} bodies" in told


def test_percentiles_of_a_hundred_bodies_are_their_values_in_order() -> None:
    """In doubles 0.07, 0.14, 0.28, 0.55 times 100 are a little more than whole numbers."""
    result = measured(samples=100, measure=rigid.mean_rate(1), axes={"spin": [2.0]})
    values = np.sort(each_body(result)[0])
    of_hundred = result.measures["mean_rate"].quantile(np.arange(1, 101) / 100)
    # A bin is narrower than 1/64 of its values.
    np.testing.assert_allclose(of_hundred[:, 0], values[0], rtol=1 / 64)
    rank = np.array([7, 14, 28, 55])
    assert (np.abs(values[0, rank] / values[0, rank - 1] - 1.0) > 2 / 64).any()


@pytest.mark.parametrize("method", ["rk4", "splitting4", "dop853"])
def test_mean_rates_of_other_methods(method: str) -> None:
    """By the cubic through both ends of a step, in rates and in momenta."""
    asked: dict[str, Any] = {"samples": 20, "measure": rigid.mean_rate(1), "check": 0.0}
    mean = measured(**asked).measures["mean_rate"].mean
    np.testing.assert_allclose(
        measured(**asked, method=method, step=0.005).measures["mean_rate"].mean, mean, atol=1e-6
    )


FINE: dict[str, Any] = {"method": "dop853", "step": 0.01, "check": 0.0}
"""Steps whose errors are rounding."""


@cache
def fine() -> np.ndarray[Any, np.dtype[np.float64]]:
    """The value of each measure of each body by these steps."""
    return each_body(measured(**FINE))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"method": "rk4", "step": 0.05},
        {"method": "dop853"},
        {"method": "dop853", "step": 0.6},
    ],
    ids=str,
)
def test_the_stated_error_is_that_of_the_worst_body(options: dict[str, Any]) -> None:
    result = measured(**options)
    for one, mine, true in zip(result.measures.values(), each_body(result), fine(), strict=True):
        if one.measure.name == "drift":
            assert np.isnan(one.error).all()
            continue
        worst = np.nanmax(np.abs(mine - true), axis=1)
        if not options:
            # The steps of the second run are 1.25 times as long, by a method of order 8.
            assert (worst <= one.error).all(), str(one)
            assert (one.error <= 4.0 * 1.25**8 * worst).all(), str(one)
            continue
        # The second run has an error of its own.
        np.testing.assert_allclose(one.error, worst, rtol=1e-3, atol=1e-13, err_msg=str(one))
    assert result.measures["mean_rate(1)"].error.min() > 0.0


def test_a_chaotic_body_whose_runs_part_has_no_value() -> None:
    chosen: dict[str, Any] = {"t_end": 100.0, "samples": 40, "measure": rigid.mean_rate(1)}
    result, single = measured(**chosen), measured(**chosen, check=0.0)
    fine = measured(**chosen, **{**FINE, "step": 0.005})
    (values,), (alone,), (truth,) = (each_body(one) for one in (result, single, fine))
    has = ~np.isnan(values)
    np.testing.assert_array_equal(values[has], alone[has])
    # To a thousandth of a radian in the whole time, at least.
    share = np.abs(alone - truth) / np.maximum(np.abs(truth), 0.01)
    # The second run errs six times as much.
    np.testing.assert_array_equal(has[share < 1e-4], True)
    np.testing.assert_array_equal(has[share > 1e-3], False)
    assert 0 < np.count_nonzero(~has) < has.size / 8
    (told,) = (line for line in result.summary().splitlines() if "mean_rate(1)" in line)
    assert told.endswith(f"of {has.sum()} bodies, {np.count_nonzero(~has)} undecided")
    assert np.isnan(single.measures["mean_rate(1)"].error).all()
    assert "undecided" not in single.summary().split("measured", 1)[1]


def test_the_error_is_that_of_the_bodies_that_are_checked() -> None:
    half, first = measured(check=0.5), measured(samples=SAMPLES // 2)
    for name in ("time_to_leave", "largest_tilt", "mean_rate(1)"):
        np.testing.assert_array_equal(half.measures[name].error, first.measures[name].error)
        assert (half.measures[name].count >= first.measures[name].count).all()
    # What two deviation vectors show at different times is not compared.
    chaotic = measured(stable=rigid.regular(), t_end=200.0, samples=20)
    assert chaotic.measures["time_to_leave"].count.any()
    assert np.isnan(chaotic.measures["time_to_leave"].error).all()


def test_times_of_joined_criteria_are_compared() -> None:
    chosen: dict[str, Any] = {"stable": rigid.tilt_below(0.6) & rigid.spin_above(1.9, axis=3)}
    rough = {"method": "rk4", "step": 0.1}
    rough_map = measured(**chosen, **rough, measure=rigid.time_to_leave())
    values, truths = each_body(rough_map)[0], each_body(measured(**chosen, **FINE))[0]
    alone = each_body(measured(**chosen, **rough, check=0.0))[0]
    has = ~np.isnan(values)
    np.testing.assert_allclose(values[has], truths[has], rtol=1.001e-3)
    assert np.count_nonzero(np.abs(alone - truths) > 1e-3 * truths) > 0
    # No verdict tells which of the two is left first.
    assert "undecided" not in rough_map.summary().split("measured", 1)[1]


def test_the_smallest_numbers_keep_their_order_and_their_mean() -> None:
    """Those below 2^-1022 share a bin with zero."""
    statistics = _core.MapStatistics(1, 1)
    statistics.add(0, np.zeros(2, np.uint64), np.array([1.5e-323, 5e-324]), np.full(2, np.nan))
    (bins,) = statistics.bins()
    found = Measured(rigid.flips(), bins, (1,))
    assert (found.least[0], found.mean[0], found.largest[0]) == (5e-324, 1e-323, 1.5e-323)


@pytest.mark.parametrize(
    ("row", "column", "value", "message"),
    [
        (0, 0, 9, "is no pixel"),
        (0, 1, 2**40, "is no number"),
        (0, 2, 0, "must count values"),
        (0, 3, -1, "offsets out of their bin"),
        (0, 6, -1, "must not be negative"),
        (0, 5, 0, "sum below its least values"),
        (0, 6, 2**30, "sum above its largest values"),
        (1, 1, 0, "must be sorted"),
        (0, 2, None, "more values than bodies in pixel 0"),
        (0, 9, -2, "has an error that is no number"),
    ],
)
def test_damaged_bins_are_refused(
    tmp_path: Path, row: int, column: int, value: int | None, message: str
) -> None:
    result = measured(measure=rigid.largest_tilt(), samples=20)
    (one,) = result.measures.values()
    if value is None:
        # Twenty times as many of the same value.
        one.bins[row, 2:9] *= [50, 1, 1, 50, 50, 50, 50]
        one.bins[row, 3:7] = [0, 0, 0, 0]
    else:
        one.bins[row, column] = value
    path = result.save(tmp_path / "map.npz")
    with pytest.raises(ValueError, match=message):
        rigid.load_map(path)


def test_another_build_is_noticed() -> None:
    result = measured(measure=rigid.largest_tilt(), samples=20)
    (one,) = result.measures.values()
    one.bins[0, 5] += 1
    with pytest.raises(ValueError, match=r"other values of largest_tilt\(3\)"):
        result.replay(0, 0)


def test_pictures_show_any_number() -> None:
    result = measured(samples=20)
    assert result.plot(what="error of largest_tilt").get_ylabel() == "error of largest_tilt (rad)"
    assert result.plot(what="mean of drift").get_ylabel() == "mean of drift"
    label = result.plot(what="quantile 0.9 of time_to_leave").get_ylabel()
    assert label == "quantile 0.9 of time_to_leave (s)"
    plane = measured(samples=5, axes={"spin": [2.0, 3.0], "tilt": [0.1, 0.2]})
    bar = plane.plot(what="median of largest_tilt").figure.axes[1]
    assert bar.get_ylabel() == "median of largest_tilt (rad)"
    for what, message in (
        ("largest_tilt", "'largest_exponent', or such as 'mean of time_to_leave'"),
        ("mean of spin", "is not measured once"),
        ("mean of mean_rate", "is not measured once"),
        ("quantile 2 of flips", r"a quantile lies in \[0, 1\]"),
    ):
        with pytest.raises(ValueError, match=message):
            result.plot(what=what)


def test_datasets_have_the_measures() -> None:
    result = measured(samples=20)
    data = result.to_xarray()
    np.testing.assert_array_equal(
        data["mean_rate_minus3_std"], result.measures["mean_rate(-3)"].std
    )
    assert data["time_to_leave_mean"].attrs["units"] == "s"


def test_measures_change_no_class() -> None:
    with_, without = measured(), measured(measure=())
    for name in ("stable", "unstable", "undecided", "failed", "earliest", "energy_drift"):
        np.testing.assert_array_equal(getattr(with_, name), getattr(without, name))
    assert "measure" not in without.spec.to_dict()
    assert repr(without.measures) == "<measures: none>"


OF_FREE: dict[str, Any] = {
    "axes": {"spin": [1.0]}, "samples": 1, "t_end": 1.0, "stable": rigid.no_flip()
}  # fmt: skip
DAMPED = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=0.1)


def of_free(measure: Any, scene: Any = rigid.FreeBody, **options: Any) -> rigid.StabilityMap:
    return rigid.stability_map(scene, **OF_FREE, measure=measure, **options)


test_bad_input_is_named = refuses(
    [
        (lambda: measured(measure="flips"), TypeError, "measure = 'flips': must be a measure: rig"),
        (lambda: measured(measure=3), TypeError, "measure = 3: must be a measure"),
        (lambda: measured(measure=[rigid.drift()] * 17), "at most 16 may be"),
        (lambda: measured(measure=[rigid.flips(2)] * 2), "flips(2) is asked for 2 times"),
        (lambda: rigid.mean_rate(4), "axis = 4"),
        (lambda: rigid.flips(-2), "axis = -2"),
        (lambda: rigid.largest_tilt(reference="up"), "reference = 'up': must be one of"),
        (lambda: Measure("spin"), "name = 'spin': must be one of"),
        (
            lambda: of_free(rigid.largest_tilt(reference="vertical")),
            "a free body knows no vertical",
        ),
        (
            lambda: of_free(rigid.flips(1), method="exact"),
            "method = 'exact': flips(1) is measured along steps",
        ),
        (lambda: of_free(rigid.largest_tilt(), DAMPED), "damping a map watches tilts from the ver"),
        (
            lambda: measured(samples=2).measures["drift"].quantile(1.5),
            "q = 1.5: must lie in [0, 1]",
        ),
    ],
    literal=True,
)


def test_a_rate_near_zero_that_moves_away_first_leaves_when_it_comes_back() -> None:
    """Both zeros of the rate lie in the first step; that beside the start is before the start."""
    moments = (2.3538564033371814, 2.301986905611685, 2.413438159543108)
    com = (-0.7658415773092293, -0.37204379705739976, -0.5244712494843011)
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body(moments), mgl=1.6184190125364024, com=com),
        axes={"spin": [1.981643120982107]},
        start=rigid.Start(
            spin=1.0,
            axis=1,
            tilt=1.4175614754368684,
            noise=rigid.normal(1e-3),
            attitude_noise=rigid.normal(0.3),
        ),
        stable=rigid.no_flip(3),
        measure=rigid.time_to_leave(),
        samples=40,
        t_end=9.219408887671822,
        rng=3226265198303360585,
    )
    left = result.outcomes(range(2), pixel=0).measures["time_to_leave"]
    t = np.linspace(0.0, 0.5, 50_001)
    starts = result.starts(range(2), pixel=0)
    for body in range(2):
        scene = result.spec.grid.scene[0]
        omega, attitude = starts.omega[body], starts.attitude[body]
        rates = rigid.simulate(scene, omega, attitude, t=t, method="taylor20").omega[:, 2]
        change = t[1:][np.flatnonzero(rates[1:] * rates[:-1] < 0.0)[0]]
        # The step of the times, and the cubic of a step of the map.
        assert abs(left[body] - change) < 1e-4


@cache
def first_changes(pixel: int) -> tuple[Any, Any]:
    """Bodies whose rate about axis 1, which begins at zero, has changed its sign by 0.1 s; when."""
    result = measured(samples=SAMPLES, measure=())
    starts, t = result.starts(range(SAMPLES), pixel=pixel), np.linspace(0.0, 0.1, 1001)
    assert not starts.omega[:, 0].any()
    scene = result.spec.grid.scene[pixel]
    rates = rigid.simulate(
        scene, starts.omega, starts.attitude, t=t, method="taylor20", step=0.01, check=False
    ).omega[:, 1:, 0]
    changed = rates[:, :-1] * rates[:, 1:] < 0.0
    early = np.flatnonzero(changed.any(axis=1))
    first = np.argmax(changed[early], axis=1)
    before, after = rates[early, first], rates[early, first + 1]
    return early, t[1 + first] + 1e-4 * before / (before - after)


@pytest.mark.parametrize(
    "options", [{"method": "rk4", "step": 0.05}, {"method": "dop853", "step": 0.1}]
)
def test_a_rate_that_begins_at_zero_and_comes_back_leaves_then(options: dict[str, Any]) -> None:
    """The start is no change of the sign, however long the first step is."""
    chosen: dict[str, Any] = {"stable": rigid.no_flip(1), "measure": rigid.time_to_leave()}
    result = measured(**chosen, **options)
    found = np.zeros(2)
    for pixel in range(3):
        early, changes = first_changes(pixel)
        left = result.outcomes(range(SAMPLES), pixel=pixel).measures["time_to_leave"]
        # Both runs agree to a thousandth, or there is no time; a straight line between times
        # h = 1e-4 s apart misses a return at t by h²/4t.
        has = ~np.isnan(left[early])
        np.testing.assert_allclose(left[early][has], changes[has], rtol=1e-3, atol=1e-5)
        found += np.array([len(early), has.sum()])
    assert found[0] > 20
    assert found[1] > 0.7 * found[0]


@pytest.mark.parametrize("moment", [0.5, 0.50000005])
def test_symmetric_tops_are_measured_as_well_as_their_neighbours(moment: float) -> None:
    """Mean rates by the steps of the map against those by steps ten times shorter."""

    def means(**options: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
        result = rigid.stability_map(
            rigid.HeavyTop(rigid.Body((0.5, moment, 0.9)), mgl=1.5),
            axes={"t_end": [100.0]},
            samples=32,
            stable=rigid.spin_above(0.3, axis=3),
            start=rigid.Start(
                omega=(1.0, 2.0, -1.5), attitude=(0.9, 0.2, 0.3, 0.1), noise=rigid.normal(0.4)
            ),
            measure=rigid.mean_rate(2),
            rng=1,
            **options,
        )
        return result.outcomes(sample=range(32)).measures["mean_rate(2)"]

    # 1e-8 rad per radian turned; the bodies turn at 4 rad/s at most.
    np.testing.assert_allclose(means(), means(step=0.01), rtol=0, atol=4e-8)
