"""The cost of a plan is measured on some of the bodies, in a given time. No test asserts a time."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from rigid import _timing as timing
from rigid import planning
from rigid.maps.plan import shortened
from small_maps import small_map

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0, com=(0.6, 0.0, 0.8))
PAIR = rigid.FreeBody(rigid.Body([[[1.0, 2.0, 3.0]], [[1.0, 1.5, 2.0]]]))
RATES = [0.3, 1.0, 2.0]


class Clock:
    """A clock that stands still but for what is said to take time (s)."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        monkeypatch.setattr(timing, "time", self)

    def process_time(self) -> float:
        return self.now


CALLS: dict[str, tuple[float, float, float, int]] = {
    "one in closed form": (3e-5, 1e-6, 0.0, 1),
    "many in closed form": (3e-5, 5e-7, 0.0, 10**7),
    "one by steps": (1e-3, 0.0, 1e-3, 1),
    "a thousand": (1e-3, 1e-6, 1e-5, 1000),
    "more than can be run": (1e-3, 1e-6, 1e-4, 10**6),
    "a long one": (1e-3, 0.0, 1e4, 1),
    "a thousand long ones": (1e-3, 1e-6, 1.0, 1000),
    "much before the first step": (1e-2, 2e-3, 1e-3, 1000),
    "a slow call": (1e-2, 1e-6, 1e-5, 1000),
}
"""Time of the call, of a body, and of the motion of a body, and bodies."""


@pytest.mark.parametrize("name", CALLS)
def test_the_time_of_a_body_is_found_in_a_given_time(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    call, body, motion, most = CALLS[name]
    clock, runs = Clock(monkeypatch), []

    def run(count: int, share: float) -> tuple[int, float]:
        runs.append((count, share))
        clock.now += call + count * (body + share * motion)
        return runs[-1]

    seconds, whole = timing.seconds_of_one(run, most)
    assert seconds == pytest.approx(call / most + body + motion, rel=0.25)
    assert clock.now <= timing.BUDGET
    assert max(count for count, _ in runs) <= most
    assert (whole is None) == (runs[-1][1] < 1.0)
    if whole is not None:
        assert whole[1] == 1.0


def test_no_more_bodies_are_run_than_the_time_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, runs = Clock(monkeypatch), []

    def slow(scene: Any, omega: Any, attitude: Any, *, t: Any, **asked: Any) -> rigid.Run:
        """Each body takes 1 ms for each second of its motion."""
        runs.append((len(omega), float(t[-1])))
        clock.now += 1e-3 * len(omega) * float(t[-1])
        return rigid.simulate(scene, omega, attitude, t=t, **asked)

    monkeypatch.setattr(planning, "simulate", slow)
    rows = np.tile(RATES, (2000, 1))
    plan = rigid.plan(HEAVY, omega=rows, t_end=1.0, times=3, cost=True)
    assert plan.cost == pytest.approx(1e6, rel=1e-5)
    assert sum(count * end for count, end in runs) <= 1e3 * timing.BUDGET
    assert max(count for count, _ in runs) == 512
    plan = rigid.plan(HEAVY, omega=rows[:9], t_end=1.0, cost=True)
    assert plan.cost == pytest.approx(1e6, rel=1e-5)
    assert runs[-1] == (9, 1.0)


STATES: dict[str, tuple[rigid.FreeBody | rigid.HeavyTop, dict[str, Any]]] = {
    "free body": (FREE, {"omega": RATES}),
    "top": (HEAVY, {"omega": RATES, "attitude": Rotation.from_rotvec([0.1, 0.2, 0.3])}),
    "one repeated": (HEAVY, {"omega": RATES, "bodies": 20}),
    "many": (HEAVY, {"omega": np.tile(RATES, (20, 1)), "times": 5, "accuracy": 1e-6}),
    "broadcast": (PAIR, {"omega": np.tile(RATES, (3, 1)), "attitude": np.eye(4)[0]}),
    "step": (HEAVY, {"omega": RATES, "method": "rk4", "step": 0.01}),
}


@pytest.mark.parametrize("name", STATES)
def test_only_a_cost_that_is_asked_for_is_measured(name: str) -> None:
    scene, asked = STATES[name]
    plan = rigid.plan(scene, "axis", t_end=1.0, **asked)
    assert plan.cost is None
    assert "cost" not in str(plan)
    timed: Any = rigid.plan(scene, "axis", t_end=1.0, cost=True, **asked)
    assert timed.cost > 0.0
    assert " a body\n" in str(timed)
    assert dataclasses.replace(timed, cost=None, error=plan.error) == plan
    assert 0.0 < timed.error < 1.0


@pytest.mark.parametrize(
    ("nanoseconds", "words"),
    [
        (999.0, "999 ns"),
        (1e3, "1 µs"),
        (2.5e4, "25 µs"),
        (1e6, "1 ms"),
        (1e9, "1 s"),
        (9e10, "90 s"),
    ],
)
def test_a_cost_is_told_in_the_largest_unit_that_it_reaches(nanoseconds: float, words: str) -> None:
    plan = rigid.plan(HEAVY, "axis", omega=RATES, t_end=1.0)
    assert f"cost        {words} a body\n" in f"{dataclasses.replace(plan, cost=nanoseconds)}\n"


def test_the_error_of_steps_is_that_of_the_bodies_that_were_run() -> None:
    rows = np.random.default_rng(1).normal(size=(10, 3))
    run = rigid.simulate(HEAVY, rows, t=[5.0], method="dop853")
    plan = rigid.plan(HEAVY, omega=rows, t_end=5.0, method="dop853", cost=True)
    assert plan.error == run.error.max()
    # Of many bodies by a method few are checked; the others have no error.
    plan = rigid.plan(HEAVY, omega=np.tile(rows, (5, 1)), t_end=5.0, method="dop853", cost=True)
    assert plan.error == pytest.approx(run.error.max(), rel=1e-6)
    coarse = rigid.plan(HEAVY, omega=rows, t_end=300.0, method="rk4", step=0.5, cost=True)
    assert coarse.error is None


def test_the_error_of_a_part_of_the_horizon_is_not_that_of_the_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(timing, "BUDGET", 0.0)
    plan = rigid.plan(HEAVY, omega=RATES, t_end=10.0, cost=True)
    assert plan.error is None
    assert plan.cost is not None


def refused(call: Callable[[], object]) -> str:
    with pytest.raises(ValueError) as error:
        call()
    return str(error.value)


def test_what_a_cost_needs_is_named() -> None:
    rule = "cost = True: some of the bodies are run, "
    message = refused(lambda: rigid.plan(HEAVY, t_end=1.0, cost=True))
    assert message == f"{rule}for which omega is missing"
    message = refused(lambda: rigid.plan(HEAVY, omega=RATES, cost=True))
    assert message == f"{rule}for which t_end is missing"
    message = refused(lambda: rigid.plan(HEAVY, omega=np.empty((0, 3)), t_end=1.0, cost=True))
    assert message == f"{rule}and there are none"
    message = refused(lambda: rigid.plan(HEAVY, rigid.no_flip(3), t_end=1.0, bodies=0))
    assert message.startswith("bodies = 0: must be")


# Maps

CRITERIA: dict[str, Any] = {
    "flip": rigid.no_flip(3),
    "tilt": rigid.tilt_below(0.5),
    "regular": rigid.regular(),
    "judged": rigid.judged(lambda states: states.omega[:, -1, 2] > 0.0, [0.0, 1.0, 2.0]),
}


@pytest.mark.parametrize("name", CRITERIA)
def test_the_cost_of_a_criterion_is_that_of_a_sample(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: dict[str, Any] = {"t_end": 2.0, "start": rigid.Start(spin=5.0)}
    plan = rigid.plan(HEAVY, CRITERIA[name], **asked)
    timed: Any = rigid.plan(HEAVY, CRITERIA[name], bodies=20, cost=True, **asked)
    assert plan.cost is None
    assert timed.cost > 0.0
    assert dataclasses.replace(timed, cost=None) == plan
    assert capsys.readouterr().err == ""  # the bar of a map would count its samples


def test_a_map_is_shortened_by_a_share_of_its_horizon() -> None:
    spec = small_map().spec
    short = shortened(spec, 0.25)
    assert (short.t_end, short.axes) == (0.25 * spec.t_end, spec.axes)
    assert short.max_steps == 0.25 * spec.max_steps
    assert shortened(spec, 1.0) is spec
    few = spec.replace(max_steps=7)
    assert shortened(few, 0.25).max_steps == 7
    ends = small_map(axes={"t_end": [1.0, 2.0]}).spec
    assert shortened(ends, 0.5).axes[0].values == (0.5, 1.0)
    assert shortened(ends, 0.5).t_end == 1.0
    judged = small_map(axes={"I1": [0.9]}, stable=CRITERIA["judged"], t_end=2.0, method=None).spec
    assert shortened(judged, 0.5).stable.times == (0.0, 0.5, 1.0)  # type: ignore[attr-defined]
