"""The plan of a criterion is the plan of its map: method, steps, closed forms and cost."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid.maps.plan import shortened
from rigid.model.criterion import Criterion
from rigid.model.scene import Scene
from small_maps import small_map, spec_of

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0, com=(0.6, 0.0, 0.8))
SCENES: dict[str, Scene] = {
    "free": FREE,
    "symmetric": rigid.FreeBody(rigid.Body((2.0, 3.0, 2.0))),
    "lagrange": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
    "heavy": HEAVY,
    "damped": rigid.HeavyTop(HEAVY.body, mgl=1.0, damping=0.1),
    "strongly damped": rigid.FreeBody(FREE.body, damping=(50.0, 1.0, 1.0)),
    "satellite": rigid.FreeBody(FREE.body, orbit=rigid.Orbit(1.0)),
    "with a wheel": rigid.FreeBody(FREE.body, rotor=(0.0, 0.0, 1.0)),
}
CRITERIA: dict[str, Criterion] = {
    "flip": rigid.no_flip(3),
    "flip of the start": rigid.no_flip(),
    "tilt": rigid.tilt_below(0.5),
    "rate": rigid.rate_within(0.1),
    "back": rigid.returns(0.1, after=1.0),
    "both": rigid.no_flip(3) & rigid.spin_above(1.0),
    "regular": rigid.regular(),
}
STARTS: dict[str, Any] = {
    "no start": None,
    "spin": rigid.Start(spin=3.0, axis=3, tilt=0.2),
    "mixture": rigid.mixture([rigid.Start(spin=s, axis=3) for s in (1.0, 4.0)]),
}
ASKED: dict[str, dict[str, Any]] = {
    "nothing": {},
    "method": {"method": "rk4"},
    "step": {"step": 0.02},
    "exact": {"method": "exact"},
}


def of_map(scene: Scene, start: Any, stable: Criterion, t_end: float, **asked: Any) -> rigid.Plan:
    """The plan of a map of one pixel, whose only axis stands in no word of the plan."""
    start = scene.default_start() if start is None else start
    quiet = [
        dataclasses.replace(one, noise=rigid.normal(0.0), attitude_noise=None)
        for one in start.starts
    ]
    return rigid.stability_map(
        scene,
        axes={"noise": [0.0]},
        start=quiet[0] if len(quiet) == 1 else rigid.mixture(quiet),
        stable=stable,
        t_end=t_end,
        samples=1,
        max_steps=1,  # the plan does not run the map
        **asked,
    ).plan


def answer(make: Callable[[], rigid.Plan]) -> rigid.Plan | str:
    """A plan, or the words of its refusal: the map and the plan refuse the same."""
    try:
        return make()
    except ValueError as refused:
        return str(refused)


def same(one: rigid.Plan, other: rigid.Plan) -> None:
    for field in dataclasses.fields(rigid.Plan):
        assert getattr(one, field.name) == getattr(other, field.name), field.name


#: Each scene twice, in turn with each criterion, start and further request.
CHOICES: tuple[dict[str, Any], ...] = (SCENES, CRITERIA, STARTS, ASKED)
CASES = [[list(of)[k % len(of)] for of in CHOICES] for k in range(2 * len(SCENES))]


@pytest.mark.parametrize(("scene", "criterion", "start", "asked"), CASES)
def test_the_plan_of_a_criterion_is_that_of_the_map(
    scene: str, criterion: str, start: str, asked: str
) -> None:
    body, stable, options = SCENES[scene], CRITERIA[criterion], ASKED[asked]
    expected = answer(lambda: of_map(body, STARTS[start], stable, 20.0, **options))
    made = answer(lambda: rigid.plan(body, stable, start=STARTS[start], t_end=20.0, **options))
    if isinstance(expected, rigid.Plan):
        assert isinstance(made, rigid.Plan)
        same(made, expected)
    else:
        assert made == expected.replace(" of pixel (0,)", "")


@pytest.mark.parametrize(
    ("body", "stable", "method"),
    [
        (HEAVY, rigid.tilt_below(3.1), None),
        (HEAVY, rigid.tilt_below(3.1), "rk4"),
        (HEAVY, rigid.tilt_below(3.1), "dop853"),
        (FREE, rigid.no_flip(3), "rk4"),  # which has a closed form
        (SCENES["lagrange"], rigid.tilt_below(3.1), "rk4"),
    ],
    ids=str,
)
def test_a_map_takes_the_method_and_the_steps_of_the_plan(
    body: Scene, stable: Criterion, method: str | None
) -> None:
    start = rigid.Start(spin=5.0, noise=rigid.normal(0.0))
    asked: dict[str, Any] = {"stable": stable, "t_end": 20.0, "method": method}
    made: Any = rigid.plan(body, stable, start=start, t_end=20.0, method=method)
    result = rigid.stability_map(
        body, axes={"noise": [0.0]}, start=start, samples=1, check=0.0, rng=1, **asked
    )
    assert result.stable.tolist() == [1]
    assert result.replay(0, 0).method == made.method
    # The map makes whole blocks of 16 steps.
    assert made.steps <= result.steps[0] < made.steps + 16


def test_a_direction_in_the_body_needs_no_attitude() -> None:
    for frame, carried in (("body", ("omega",)), ("space", ("omega", "attitude"))):
        stable = rigid.rate_within(0.1, frame=frame)
        plan: Any = rigid.plan(FREE, stable, start=rigid.Start(spin=5.0), t_end=20.0, method="rk4")
        assert plan.carried == carried


def test_rates_are_short_for_a_start() -> None:
    omega = (0.3, 1.0, 2.0)
    made = rigid.plan(HEAVY, rigid.no_flip(), omega=omega, t_end=5.0)
    same(made, rigid.plan(HEAVY, rigid.no_flip(), start=rigid.Start(omega=omega), t_end=5.0))
    assert made.question == "no flip about axis 3 until t = 5 s"


def test_a_judged_criterion_has_its_horizon_and_is_planned_in_the_steps_that_it_takes() -> None:
    stable = rigid.judged(lambda states: states.omega[:, -1, 2] > 0.0, [0.0, 2.0, 7.0])
    adaptive = rigid.plan(HEAVY, stable)
    assert adaptive == rigid.plan(HEAVY, stable, t_end=7.0)
    assert adaptive.question.endswith("until t = 7 s")
    assert (adaptive.tolerance, adaptive.step, adaptive.steps) == (1e-7, None, None)
    equal = rigid.plan(HEAVY, stable, step=0.02)
    assert (equal.tolerance, equal.step, equal.steps) == (None, 0.02, 350)


def test_the_error_of_a_closed_form_beside_a_saddle_is_unknown() -> None:
    start = rigid.Start(omega=(2.0 * np.sin(0.5), 0.0, 0.0), tilt=1.0)
    lagrange, stable = SCENES["lagrange"], rigid.tilt_below(3.0)
    plan = rigid.plan(lagrange, stable, start=start, t_end=30.0)
    assert (plan.method, plan.error) == ("exact", None)
    assert plan.why[-1] == "error unknown: a body passes a saddle, which magnifies it"
    plan = rigid.plan(lagrange, stable, start=rigid.Start(spin=5.0), t_end=30.0)
    assert plan.error is not None
    assert rigid.plan(HEAVY, stable, t_end=30.0).error is None  # of steps it is known after a run


# Refusals


test_what_a_map_does_not_have_is_refused = refuses(
    [
        ({"accuracy": 1e-6}, "accuracy = 1e-06: has no place beside a criterion: a map classifies"),
        ({"times": 3}, "times = 3: has no place beside a criterion: a class is no state at output"),
        ({"attitude": [1, 0, 0, 0]}, "attitude = [1, 0, 0, 0]: has no place beside a criterion"),
        ({"omega": [0, 0, 1], "start": rigid.Start(spin=1.0)}, "omega, start: exclude each other"),
        ({"omega": [[0, 0, 1], [0, 0, 2]]}, "omega: expected shape (3,)"),
        ({"t_end": -1.0}, "t_end = -1.0: must be positive"),
        ({"method": "dmv2"}, "'dmv2'"),
        ({"scene": rigid.FreeBody(rigid.Body([[1, 2, 3], [1, 2, 2]]))}, "scene"),
        ({"t_end": None}, TypeError, "plan() needs t_end"),
        (
            {"question": "rates", "t_end": None, "start": rigid.Start(spin=1.0)},
            ": belongs to a criterion; states start from omega and attitude",
        ),
    ],
    literal=True,
    by=lambda options: rigid.plan(
        **{"scene": HEAVY, "question": rigid.no_flip(3), "t_end": 1.0, **options}
    ),
)


def test_a_shorter_map_is_allowed_its_share_of_the_steps() -> None:
    """At least a thousand, below which a cost is not measured, and never more than the map."""
    for most, share, allowed in ((10**9, 0.1, 10**8), (5000, 0.1, 1000), (300, 0.5, 300)):
        shorter = shortened(spec_of(max_steps=most, t_end=20.0), share)
        assert (shorter.max_steps, shorter.t_end) == (allowed, 20.0 * share)


def test_the_forces_of_axes_of_a_map_are_carried() -> None:
    result = rigid.stability_map(
        FREE, axes={"rotor3": [0.1, 0.2]}, samples=1, t_end=1.0, stable=rigid.no_flip()
    )
    assert result.plan.carried == ("omega", "work")
    assert "one kernel has all further forces" in result.plan.why[-1]


@pytest.mark.parametrize("method", ["rk4", "dop853", "auto"])
@pytest.mark.parametrize(("eccentricity", "anomaly"), [(0.0, 0.0), (0.05, 1.0), (4.25, -20.0)])
def test_the_steps_that_are_planned_for_a_map_over_an_orbit_are_taken(
    method: str, eccentricity: float, anomaly: float
) -> None:
    scene = rigid.FreeBody(FREE.body, orbit=rigid.Orbit(1.0, eccentricity, anomaly))
    result = rigid.stability_map(
        scene,
        axes={"spin": [3.0]},
        start=rigid.Start(spin=3.0, axis=3),
        stable=rigid.no_flip(),
        t_end=60.0,
        samples=1,
        rng=1,
        method=method,
        progress=False,
    )
    body = result.replay(pixel=(0,), sample=0)
    assert body.outcome == "stable"  # a body that flips stops
    planned: Any = result.plan.steps
    # Whole blocks of 16 steps are taken.
    assert planned <= body.steps < planned + 16


# Closed forms in maps


def test_each_pixel_of_a_map_decides_for_itself() -> None:
    options: dict[str, Any] = {
        "axes": {"I1": [0.9, 1.0, 1.1]},
        "stable": rigid.tilt_below(0.5),
        "samples": 8,
        "t_end": 5.0,
        "method": None,
    }
    result = small_map(rigid.HeavyTop, **options)
    assert result.spec.method == "auto"
    assert result.exact.tolist() == [0, 8, 0]
    assert (result.steps > 0).tolist() == [True, False, True]
    assert np.isnan(result.energy_drift).tolist() == [False, True, False]
    assert result.plan.method == "auto"
    assert result.plan.closed_form == "lagrange"
    assert result.plan.why == ("1 of 3 pixels have a closed form",)
    assert "auto: closed form for 8 bodies, else dop853" in result.summary()
    assert "4 of those integrated cross-checked by dop853" in result.summary()
    assert [result.replay(k, 0).method for k in range(3)] == ["dop853", "exact", "dop853"]


def test_a_map_in_closed_form_takes_no_step() -> None:
    result = small_map(method=None)
    assert result.exact.sum() == result.samples.sum()
    assert result.steps.sum() == result.checked.sum() == result.undecided.sum() == 0
    assert result.plan.method == "exact"
    assert "worst drift none: closed form" in result.summary()
    body = result.replay(pixel=(2, 3), sample=5)
    assert (body.method, body.steps, body.run.plan.method) == ("exact", 0, "exact")
    assert np.isnan(body.step)
    assert body.run.omega.shape == (501, 3)
    assert body.run.t[-1] == result.spec.t_end


@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_what_never_leaves_is_stable(method: str) -> None:
    # A spin about the largest moment, and a top that sleeps: times of leaving that are infinite.
    start = rigid.Start(spin=1.0, axis=3, noise=rigid.normal(1e-3))
    body = small_map(axes={"spin": [1.0, 2.0]}, start=start, method=method)
    asleep = {"axes": {"spin": [5.0, 6.0]}, "stable": rigid.tilt_below(0.5), "method": method}
    for result in (body, small_map(rigid.HeavyTop, **asleep)):
        assert result.stable.tolist() == [20, 20]
        assert result.undecided.tolist() == [0, 0]
        assert (result.earliest == np.inf).all()


def test_exact_maps_are_those_of_auto_where_all_have_closed_forms() -> None:
    auto, exact = (small_map(method=method) for method in ("auto", "exact"))
    for name in ("stable", "unstable", "earliest", "exact"):
        np.testing.assert_array_equal(getattr(auto, name), getattr(exact, name))


CLASS_RULE = (
    "closed forms are known of no_flip and regular of a free body, and of tilt_below(axis=±k"
)


def exact_map(i1: list[float]) -> rigid.StabilityMap:
    stable = rigid.tilt_below(0.5)
    return small_map(rigid.HeavyTop, method="exact", axes={"I1": i1}, stable=stable)


def test_an_impossible_body_needs_no_closed_form() -> None:
    assert exact_map([1.0, 5.0]).exact.tolist() == [20, 0]


test_what_has_no_closed_form_is_named = refuses(
    [
        (
            lambda: rigid.plan(FREE, rigid.tilt_below(0.5), t_end=1.0, method="exact"),
            ["no closed form of tilt of axis 3 from its start below 0.5 rad", CLASS_RULE],
        ),
        (
            lambda: exact_map([1.0, 1.1]),
            [
                "method = 'exact': no closed form of tilt of axis 3 from the vertical",
                "for the body of pixel (1,), moments (1.1, 1, 0.5)",
                CLASS_RULE,
            ],
        ),
    ],
    literal=True,
)


# The cost of maps

COSTLY: dict[str, Criterion] = {
    **{name: CRITERIA[name] for name in ("flip", "tilt", "regular")},
    "judged": rigid.judged(lambda states: states.omega[:, -1, 2] > 0.0, [0.0, 1.0, 2.0]),
}


@pytest.mark.parametrize("name", COSTLY)
def test_the_cost_of_a_criterion_is_that_of_a_sample(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: dict[str, Any] = {"t_end": 2.0, "start": rigid.Start(spin=5.0)}
    plan = rigid.plan(HEAVY, COSTLY[name], **asked)
    timed: Any = rigid.plan(HEAVY, COSTLY[name], bodies=20, cost=True, **asked)
    assert plan.cost is None
    assert timed.cost > 0.0
    assert dataclasses.replace(timed, cost=None) == plan
    assert capsys.readouterr().err == ""  # the bar of a map would count its samples


def test_a_map_is_shortened_by_a_share_of_its_horizon() -> None:
    spec = small_map().spec
    short = shortened(spec, 0.25)
    assert (short.t_end, short.axes) == (0.25 * spec.t_end, spec.axes)
    assert shortened(spec, 1.0) is spec
    ends = small_map(axes={"t_end": [1.0, 2.0]}).spec
    assert shortened(ends, 0.5).axes[0].values == (0.5, 1.0)
    assert shortened(ends, 0.5).t_end == 1.0
    judged = small_map(axes={"I1": [0.9]}, stable=COSTLY["judged"], t_end=2.0, method=None).spec
    assert shortened(judged, 0.5).stable.times == (0.0, 0.5, 1.0)  # type: ignore[attr-defined]
