"""Criteria against what a fine motion shows, and joined criteria against their logic."""

import dataclasses
import inspect
import math
from typing import Any

import numpy as np
import pytest

import rigid
from criteria_truth import asymmetric_tops, criteria, job_of, judged, truth, wrong_verdicts
from random_scenes import Scenes, free, tops
from refusals import refuses
from rigid import _core
from rigid.cli.toml_map import read_spec
from rigid.cli.toml_table import names_of
from rigid.maps.axes import make_axes
from rigid.maps.data import CLASSES
from rigid.maps.job import to_core
from rigid.maps.judge import UNDECIDED
from rigid.maps.plan import map_plan
from rigid.model.criterion import CRITERIA, Criterion, Joined, can_be_left
from small_maps import Floats, small_map, spec_of

#: Bodies of each family; ``tests/long/criteria.py`` takes many more.
BODIES = 120

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0)
SPINS = {"spin": [2.0, 4.5]}


def families(rng: np.random.Generator, n: int) -> list[Scenes]:
    return [
        free(rng, n, equal=False),
        free(rng, n, equal=True),
        tops(rng, n),
        asymmetric_tops(rng, n),
    ]


@pytest.mark.parametrize("family", range(4))
def test_verdicts_are_those_of_a_fine_motion(family: int) -> None:
    """Wherever the map decides, also where a limit is passed inside a step only.

    The bodies that almost vanish in their rates are undecided where a direction is watched.
    """
    rng = np.random.default_rng(family)
    scenes = families(rng, BODIES)[family]
    seen: set[bool] = set()
    for criterion in criteria(scenes.kind, rng):
        verdicts = judged(scenes, criterion)
        wrong, late = wrong_verdicts(criterion, scenes, verdicts, truth(scenes, criterion))
        assert not wrong.size, (str(criterion), scenes.written(int(wrong[0])))
        assert verdicts.undecided.mean() < 0.2, str(criterion)
        if late.size:
            # The default steps err by 1e-8 rad for each rad, which tumbling magnifies; a limit that
            # is passed slowly is passed later by more.
            assert np.quantile(late, 0.9) < 1e-4, str(criterion)
        seen |= {*verdicts.stable[~verdicts.undecided].tolist()}
    assert seen == {False, True}


@pytest.mark.parametrize("method", ["rk4", "splitting4", "dop853"])
def test_other_methods_agree(method: str) -> None:
    """By the polynomial of their step, or by the cubic through its ends."""
    scenes = free(np.random.default_rng(5), BODIES, equal=False)
    for criterion in (rigid.rate_within(0.7), rigid.near_start(1.0), rigid.spin_above(0.3, 1)):
        by_map = judged(scenes, criterion, method)
        series = judged(scenes, criterion)
        decided = ~by_map.undecided & ~series.undecided
        assert decided.mean() > 0.9
        assert (by_map.stable == series.stable)[decided].mean() > 0.98, str(criterion)


def test_the_angular_momentum_of_a_free_body_is_constant_in_space() -> None:
    result = small_map(stable=rigid.rate_within(1e-9, of="L"), method="auto")
    assert (result.stable == 20).all()
    assert (result.exact == 20).all()


def test_a_body_about_its_axis_returns_each_turn() -> None:
    """The attitude is back at 2 pi / spin: within an angle, that angle earlier."""
    body = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
    asked: dict[str, Any] = {"samples": 1, "t_end": 10.0, "rng": 1}
    start = rigid.Start(spin=1.0, axis=3)
    result = rigid.stability_map(
        body, axes={"spin": [1.0]}, start=start, stable=rigid.returns(0.1, after=1.0), **asked
    )
    back = result.replay(0, 0)
    assert back.outcome == "stable"
    assert math.isnan(back.left)
    assert back.parts[0].left == pytest.approx(2.0 * math.pi - 0.1, abs=1e-9)
    left = rigid.stability_map(
        body, axes={"spin": [1.0]}, start=start, stable=rigid.near_start(0.1), **asked
    )
    assert left.earliest[0] == pytest.approx(0.1, abs=1e-9)


SINGLE = (
    rigid.tilt_below(0.6),
    rigid.spin_above(1.9, axis=3),
    rigid.rate_within(0.5),
)
COMBINED: tuple[tuple[Criterion, Any], ...] = (
    (SINGLE[0] & SINGLE[1], lambda a, b, c: a & b),
    (SINGLE[0] | SINGLE[2], lambda a, b, c: a | c),
    (~SINGLE[0], lambda a, b, c: ~a),
    ((SINGLE[0] | ~SINGLE[1]) & SINGLE[2], lambda a, b, c: (a | ~b) & c),
    (~(SINGLE[0] & SINGLE[1] & ~SINGLE[2]), lambda a, b, c: ~(a & b & ~c)),
)


def test_joined_criteria_are_the_logic_of_the_single_ones_sample_by_sample() -> None:
    asked: dict[str, Any] = {
        "axes": SPINS,
        "samples": 30,
        "t_end": 12.0,
        "rng": 7,
        "start": rigid.Start(spin=3.0, tilt=0.2, attitude_noise=rigid.normal(0.2)),
    }
    alone = [rigid.stability_map(TOP, stable=stable, **asked) for stable in SINGLE]
    bodies = [(pixel, sample) for pixel in range(2) for sample in range(30)]
    single = [[result.replay(*body, t=[0.0]) for body in bodies] for result in alone]
    truths = [np.array([body.outcome == "stable" for body in bodies_]) for bodies_ in single]
    sure = np.all([[b.outcome in ("stable", "unstable") for b in one] for one in single], axis=0)
    assert sure.mean() > 0.9
    for joined, logic in COMBINED:
        result = rigid.stability_map(TOP, stable=joined, **asked)
        replays = [result.replay(*body, t=[0.0]) for body in bodies]
        outcomes = np.array([body.outcome == "stable" for body in replays])
        expected = logic(*truths)
        np.testing.assert_array_equal(outcomes[sure], expected[sure], str(joined))
        assert {*expected.tolist()} == {False, True}
        # Each part keeps its own time, with the bits of the map of that part alone.
        own = {str(result.spec.stable): single[k] for k, result in enumerate(alone)}
        for k, body in enumerate(replays):
            for part in body.parts:
                other = own[str(part.criterion)][k]
                np.testing.assert_array_equal(part.left, other.left)
                assert part.outcome == other.outcome


def test_a_conjunction_is_left_first_and_a_disjunction_last() -> None:
    asked: dict[str, Any] = {
        "axes": {"spin": [2.0]},
        "samples": 20,
        "t_end": 12.0,
        "rng": 7,
        "start": rigid.Start(spin=3.0, tilt=0.2, attitude_noise=rigid.normal(0.2)),
    }
    one, other = rigid.tilt_below(0.6), rigid.rate_within(0.5)
    both, either = (
        rigid.stability_map(TOP, stable=stable, **asked) for stable in (one & other, one | other)
    )
    for sample in range(20):
        first, last = both.replay(0, sample, t=[0.0]), either.replay(0, sample, t=[0.0])
        times = [part.left for part in first.parts]
        assert [part.left for part in last.parts] == pytest.approx(times, nan_ok=True)
        np.testing.assert_array_equal(first.left, np.fmin.reduce(times))
        np.testing.assert_array_equal(last.left, np.maximum.reduce(times))


def test_plans_of_joined_criteria() -> None:
    """A closed form only where each has one; the work is that of all."""
    spec = small_map(method="auto", samples=1, t_end=1.0).spec
    closed = dataclasses.replace(spec, stable=rigid.no_flip(2) | ~rigid.no_flip(1), method="exact")
    assert map_plan(closed).method == "exact"
    with pytest.raises(ValueError, match="no closed form"):
        dataclasses.replace(closed, stable=rigid.no_flip(2) & rigid.near_start(1.0))


test_bad_input_is_named = refuses(
    [
        (lambda: rigid.tilt_between(-0.1, 1.0), "low = -0.1: must not be negative"),
        (lambda: rigid.tilt_between(0.1, 4.0), r"high = 4.0: must lie in \(0, pi\] \(rad\)"),
        (lambda: rigid.tilt_between(1.0, 0.5), "low = 1.0: must be below high = 0.5"),
        (lambda: rigid.tilt_between(0.1, 0.5, axis=4), "axis = 4"),
        (lambda: rigid.rate_within(0.0), "angle = 0.0: must be positive"),
        (lambda: rigid.rate_within(1.0, of="l"), "of = 'l': must be one of"),
        (lambda: rigid.rate_within(1.0, frame="lab"), "frame = 'lab': must be one of"),
        (lambda: rigid.near_start(4.0), r"angle = 4.0: must lie in \(0, pi\] \(rad\)"),
        (lambda: rigid.returns(4.0, after=1.0), r"angle = 4.0: must lie in \(0, pi\] \(rad\)"),
        (lambda: rigid.returns(1.0, after=-1.0), "after = -1.0: must not be negative"),
        (lambda: rigid.spin_above(-1.0), "rate = -1.0: must not be negative"),
        (lambda: rigid.spin_above(1.0, axis=0), "axis = 0"),
        (lambda: rigid.no_flip() & rigid.regular(), r"regular\(\) integrates a deviation vector"),
        (lambda: Joined("xor", 2 * (rigid.no_flip(),)), "operation = 'xor': must be 'and' or 'or'"),
        (lambda: Joined("and", (rigid.no_flip(),)), "operation = 'and': must be .* of two"),
        (
            lambda: small_map(stable=rigid.tilt_between(0.1, 0.2)),
            "measures from the vertical, which a free body does not know",
        ),
        (
            lambda: small_map(stable=rigid.near_start(0.2), method="dmv10"),
            "method = 'dmv10': integrates no frame with a free body",
        ),
        (
            lambda: small_map(method="taylor16"),
            "method = 'taylor16': a map looks inside its steps, but not inside those of a series",
        ),
    ]
)


def test_joining_what_is_no_criterion() -> None:
    with pytest.raises(TypeError, match=r"& 0\.5: must be a criterion"):
        rigid.no_flip() & 0.5  # type: ignore[operator]
    with pytest.raises(TypeError, match=r"joined by &, \| and ~, not by and, or and not"):
        rigid.no_flip() and rigid.near_start(1.0)
    many: Criterion = rigid.near_start(1.0)
    for _ in range(7):
        many = many & rigid.near_start(1.0)
    with pytest.raises(ValueError, match="9 criteria are joined: at most 8 may be"):
        many & rigid.near_start(1.0)
    while len(many.logic()) < 64:
        many = ~many
    with pytest.raises(ValueError, match="more than 64 terms"):
        assert ~many


def _upright(states: rigid.States) -> Any:
    """Whether axis 3 keeps its direction."""
    return states.gamma[..., 2].min(axis=1) > 0.9  # type: ignore[index]


FORCED: dict[str, Any] = {
    "a rotor": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), rotor=(0.0, 0.0, 1.0)),
        r"reference = 'start': under a rotor a map watches tilts from the vertical only; "
        r"take no_flip\(\), or judged\(\) with a function of the attitudes",
        [rigid.no_flip(3), rigid.judged(_upright, [0.0, 1.0])],
    ),
    "damping and drag": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=0.1, drag=0.1),
        r"under damping and drag a map watches .*; take no_flip\(\), or judged\(\)",
        [rigid.no_flip(3), rigid.judged(_upright, [0.0, 1.0])],
    ),
    "an orbit": (
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=rigid.Orbit(0.1)),
        r"under the gravity gradient of an orbit a map .*; give reference='vertical'",
        [rigid.tilt_below(0.5, reference="vertical")],
    ),
}


@pytest.mark.parametrize("force", FORCED)
def test_what_a_map_cannot_watch_names_the_force_and_what_can_be_watched(force: str) -> None:
    """Each criterion that the message names is computed; spin about a stable axis keeps it."""
    scene, message, remedies = FORCED[force]
    asked: dict[str, Any] = {
        "axes": {"spin": [1.0, 2.0]},
        "start": rigid.Start(spin=1.0, axis=3),
        "samples": 2,
        "rng": 1,
    }
    with pytest.raises(ValueError, match=message):
        rigid.stability_map(scene, stable=rigid.tilt_below(0.5), t_end=1.0, **asked)
    for stable in remedies:
        horizon: dict[str, Any] = {} if stable.name == "judged" else {"t_end": 1.0}
        result = rigid.stability_map(scene, stable=stable, **horizon, **asked)
        assert (result.stable == 2).all()


@pytest.mark.parametrize("name", CRITERIA)
def test_a_function_that_makes_a_criterion_has_the_defaults_of_its_class(name: str) -> None:
    of_function = inspect.signature(getattr(rigid, name)).parameters
    for own in dataclasses.fields(CRITERIA[name]):  # type: ignore[arg-type]
        known = of_function[own.name].default
        assert known == (
            inspect.Parameter.empty if own.default is dataclasses.MISSING else own.default
        )


def test_joined_criteria_are_left_if_one_that_they_need_is_left() -> None:
    a, b, back = rigid.no_flip(1), rigid.tilt_between(0.1, 0.2), rigid.returns(0.1, after=1.0)
    for left in (a, a & b, a | ~b, ~(~a & b), ~back, ~(back | ~a)):
        assert can_be_left(left.logic()), left
    # A body that has left a criterion does not come back to it.
    for never in (~a, ~a & ~b, ~(a | b), back, back | ~b, ~(~back & a)):
        assert not can_be_left(never.logic()), never


# Verdicts of maps in closed form, sample by sample against those of fine steps.


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


def classified(
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
    exact = classified(scenes, "no_flip", axis, 0.0, "exact")
    stepped = classified(scenes, "no_flip", axis, 0.0, "rk4")
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
    exact = classified(scenes, "tilt_from_vertical", axis, angle, "exact")
    stepped = classified(scenes, "tilt_from_vertical", axis, angle, "rk4")
    assert exact.exact.all()
    late = assert_same_verdicts(exact, stepped, STEP**2, angle)
    assert np.quantile(late, 0.9) < STEP**2


def test_a_top_keeps_its_spin() -> None:
    """Nothing to compute about its axis; about the others it is integrated."""
    drawn = tops(np.random.default_rng(1), 600)
    axis = np.abs(drawn.weight).argmax(axis=1)
    exact = classified(drawn, "no_flip", 2, 0.0, "auto")
    stepped = classified(drawn, "no_flip", 2, 0.0, "dop853")
    resting = exact.exact == 1
    about = axis == 1
    assert exact.exact[about].all()
    assert exact.stable[about].all()
    assert not exact.steps[resting].any()
    assert exact.steps[~resting].all()
    np.testing.assert_array_equal(exact.left[~resting], stepped.left[~resting])


def test_a_longer_horizon_costs_nothing_and_changes_no_time() -> None:
    scenes = free(np.random.default_rng(4), 500, equal=False)
    near = classified(scenes, "no_flip", 1, 0.0, "exact", 10.0)
    for t_end in (1e3, 1e9):
        far = classified(scenes, "no_flip", 1, 0.0, "exact", t_end)
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
