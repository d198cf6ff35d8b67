"""The plan of a criterion is the plan of its map: one planner, whoever asks."""

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
from small_maps import spec_of

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
