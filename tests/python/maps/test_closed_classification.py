"""Verdicts of maps in closed form, sample by sample against those of fine steps."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import rigid
from criteria_truth import job_of
from random_scenes import Scenes, free, tops
from rigid import _core
from rigid.cli.toml_map import read_spec
from rigid.cli.toml_table import names_of
from rigid.maps.axes import make_axes
from rigid.maps.data import CLASSES
from rigid.maps.job import to_core
from rigid.maps.judge import UNDECIDED
from small_maps import Floats, small_map, spec_of

#: ``tests/long/closed_forms_against_rk4.py`` takes many more scenes.
#: Horizon of random scenes, whose fastest rate lies between 1/2 and 1 rad/s, and the step of RK4.
HORIZON, STEP = 30.0, 2.0**-7


@dataclasses.dataclass(frozen=True)
class Verdicts:
    """What one method says of many scenes, each a pixel with a single sample."""

    job: _core.MapJob
    stable: Floats
    undecided: Floats
    exact: Floats
    steps: Floats
    left: Floats


def judged(
    scenes: Scenes, criterion: str, axis: int, limit: float, method: str, t_end: float = HORIZON
) -> Verdicts:
    job = job_of(
        scenes,
        method=method,
        conditions=[(criterion, axis, [] if criterion == "no_flip" else [limit])],
        logic="0",
        t_end=t_end,
        step=STEP,
    )
    counted: Any = job.run(0, len(scenes), 2)
    assert not counted["failed"].any()
    names = ("stable", "undecided", "exact", "steps", "earliest")
    return Verdicts(job, *(counted[name] for name in names))


def assert_same_verdicts(exact: Verdicts, stepped: Verdicts, graze: float, limit: float) -> Floats:
    """The classes agree; differences of the times of leaving, where both leave.

    They may differ where a body leaves within a step of the horizon, or where a tilt passes its
    limit by less than it can between two looks, ``graze``.
    """
    decided = stepped.undecided + exact.undecided == 0
    assert decided.mean() > 0.99
    for k in np.flatnonzero(decided & (exact.stable != stepped.stable)):
        number = np.array([k], np.uint64)
        one, other = (verdicts.job.outcomes(number, 1) for verdicts in (exact, stepped))
        at_the_end = any(abs(sample["left"][0] - HORIZON) < STEP for sample in (one, other))
        assert at_the_end or abs(other["tilt"][0] - limit) < graze
    both = decided & (exact.stable == 0) & (stepped.stable == 0)
    assert both.any()
    late: Floats = np.abs(exact.left[both] - stepped.left[both])
    return late


@pytest.mark.parametrize("axis", [1, 2, 3])
@pytest.mark.parametrize("equal", [False, True])
def test_bodies_flip_when_steps_see_it(axis: int, equal: bool) -> None:
    """About every axis, in every order of the moments, from any start.

    RK4 loses h^4 t/120 of the phase, its cubic through the ends of a step less. Nine in ten: a
    component that hardly turns, beside large ones, is rounded as they are.
    """
    scenes = free(np.random.default_rng(axis), 1000, equal=equal)
    exact = judged(scenes, "no_flip", axis, 0.0, "exact")
    stepped = judged(scenes, "no_flip", axis, 0.0, "rk4")
    assert exact.exact.all()
    late = assert_same_verdicts(exact, stepped, 0.0, 0.0)
    assert np.quantile(late, 0.9) < STEP**4 * HORIZON / 120.0


@pytest.mark.parametrize("axis", [-3, -2, -1, 1, 2, 3])
@pytest.mark.parametrize("angle", [0.3, 1.5, 3.0])
def test_tops_tilt_when_steps_see_it(axis: int, angle: float) -> None:
    """Both directions of the watched axis, both sides of the centre of mass.

    A tilt is looked at after each step, so that a swing of at most the fastest rate w passes its
    limit unseen by w^2 h^2/8, a few times that by a pole; between the looks it is a straight line.
    """
    drawn = tops(np.random.default_rng(abs(axis)), 2000)
    rows = np.abs(drawn.weight).argmax(axis=1) == abs(axis) - 1
    columns = ("moments", "weight", "omega", "attitude")
    scenes = dataclasses.replace(drawn, **{name: getattr(drawn, name)[rows] for name in columns})
    assert {*np.sign(scenes.weight[:, abs(axis) - 1])} == {-1.0, 1.0}
    exact = judged(scenes, "tilt_from_vertical", axis, angle, "exact")
    stepped = judged(scenes, "tilt_from_vertical", axis, angle, "rk4")
    assert exact.exact.all()
    late = assert_same_verdicts(exact, stepped, STEP**2, angle)
    assert np.quantile(late, 0.9) < STEP**2


def test_a_top_keeps_its_spin() -> None:
    """Nothing to compute about its axis; about the others it is integrated."""
    drawn = tops(np.random.default_rng(1), 600)
    axis = np.abs(drawn.weight).argmax(axis=1)
    exact = judged(drawn, "no_flip", 2, 0.0, "auto")
    stepped = judged(drawn, "no_flip", 2, 0.0, "dop853")
    resting = exact.exact == 1
    about = axis == 1
    assert exact.exact[about].all()
    assert exact.stable[about].all()
    assert not exact.steps[resting].any()
    assert exact.steps[~resting].all()
    np.testing.assert_array_equal(exact.left[~resting], stepped.left[~resting])


def test_a_longer_horizon_costs_nothing_and_changes_no_time() -> None:
    scenes = free(np.random.default_rng(4), 500, equal=False)
    near = judged(scenes, "no_flip", 1, 0.0, "exact", 10.0)
    for t_end in (1e3, 1e9):
        far = judged(scenes, "no_flip", 1, 0.0, "exact", t_end)
        assert not far.steps.any()
        gone = near.stable == 0
        np.testing.assert_array_equal(far.stable[gone], 0)
        assert far.left[gone].tobytes() == near.left[gone].tobytes()
        assert (far.left[~gone] > 10.0).all()


@pytest.mark.parametrize(
    ("name", "step"), [("inertia-triangle", 0.015), ("sleeping-top", 0.0025), ("thrown-box", 0.001)]
)
def test_built_in_maps_are_those_of_fine_steps(name: str, step: float) -> None:
    """A few of their pixels and samples, by steps in which a body turns by about 1/50 rad."""
    assert name in names_of("map")
    spec = read_spec(name).spec
    axes = make_axes({axis.name: axis.values[3::11] for axis in spec.axes})
    exact = dataclasses.replace(spec, axes=axes, samples=8, method="exact")
    jobs = [to_core(exact), to_core(dataclasses.replace(exact, method="rk4", step=step))]
    pixels = math.prod(exact.shape)
    counts = [job.run(0, pixels * exact.samples, 2) for job in jobs]
    closed, stepped = (count for count in counts if count is not None)
    possible = jobs[0].status == 0
    np.testing.assert_array_equal(closed["exact"], np.where(possible, exact.samples, 0))
    assert not closed["steps"].any()
    undecided = closed["undecided"] + stepped["undecided"]
    assert undecided.sum() <= 0.001 * pixels * exact.samples
    for kind in ("stable", "unstable"):
        assert (np.abs(closed[kind] - stepped[kind]) <= undecided).all()
    np.testing.assert_array_equal(closed["failed"], stepped["failed"])
    for pixel in np.flatnonzero(possible)[:: max(1, possible.sum() // 6)]:
        numbers = np.arange(exact.samples, dtype=np.uint64) + np.uint64(pixel * exact.samples)
        for drawn in zip(*(job.starts(numbers) for job in jobs), strict=True):
            assert drawn[0].tobytes() == drawn[1].tobytes()
        one, other = (job.outcomes(numbers, 1) for job in jobs)
        assert one["exact"].all()
        assert not other["exact"].any()
        decided = (one["class"] != UNDECIDED) & (other["class"] != UNDECIDED)
        np.testing.assert_array_equal(one["class"][decided], other["class"][decided])
        for code, kind in enumerate(CLASSES):
            assert (one["class"] == code).sum() == closed[kind][pixel]


def test_only_symmetric_tops_of_a_grid_have_closed_forms() -> None:
    """A grid over I1 through I2 = 1: one column has a closed form, the others keep their bits."""
    options: dict[str, Any] = {
        "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
        "axes": {"I1": [0.8, 0.9, 1.0, 1.1, 1.2], "spin": [3.0, 3.9, 4.1, 5.0]},
        "start": rigid.Start(spin=1.0, axis=3, attitude_noise=rigid.normal(0.05)),
        "stable": rigid.tilt_below(0.5),
        "t_end": 20.0,
        "samples": 40,
        "step": 0.002,
    }
    mixed, stepped = (small_map(method=method, **options) for method in ("auto", "dop853"))
    np.testing.assert_array_equal(mixed.exact, np.tile([0, 0, 40, 0, 0], (4, 1)))
    np.testing.assert_array_equal(stepped.exact, 0)
    np.testing.assert_array_equal(mixed.steps[:, 2], 0)
    undecided = mixed.undecided + stepped.undecided
    assert (np.abs(mixed.stable - stepped.stable) <= undecided).all()
    for column in (0, 1, 3, 4):
        np.testing.assert_array_equal(mixed.steps[:, column], stepped.steps[:, column])
        np.testing.assert_array_equal(mixed.stable[:, column], stepped.stable[:, column])
    with pytest.raises(ValueError, match="exact"):
        spec_of(method="exact", **options)
