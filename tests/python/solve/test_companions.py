"""Each body of a call is solved as if it were alone: method, bits, error and status."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid

BODIES = rigid.Body([[1, 1, 2.0], [1, 1.5, 2.2], [1, 1.5, 2.2], [1.0, 1.2, 1.4]])
DAMPING = [
    np.zeros((3, 3)),
    np.diag([0.1, 0.2, 0.3]),
    np.diag([50.0, 90.0, 80.0]),
    np.diag([0.125, 0.15, 0.175]),
]
OMEGA = np.random.default_rng(3).normal(size=(4, 3))
TIMES = [0.0, 3.0, 7.0]

TOPS = rigid.HeavyTop(BODIES, mgl=[1.0, 1.0, 0.0, 2.0])
"""A Lagrange top, a top without symmetry, a body without weight, and another top."""

DAMPED = rigid.FreeBody(BODIES, damping=DAMPING)
"""Damped not at all, weakly, strongly, and evenly."""

MIXED = rigid.HeavyTop(
    BODIES,
    mgl=[1.0, 1.0, 0.0, 2.0],
    damping=DAMPING,
    drag=[[0.0] * 3, [0.1, 0.0, 0.0], [0.0] * 3, [0.0] * 3],
)


def alone(scene: rigid.FreeBody | rigid.HeavyTop, **options: Any) -> list[rigid.Run]:
    return [rigid.simulate(scene[k], OMEGA[k], t=TIMES, **options) for k in range(4)]


def assert_equal(together: rigid.Run, each: list[rigid.Run]) -> None:
    for k, own in enumerate(each):
        for name in ("omega", "attitude", "error", "lost_from", "status", "steps"):
            assert getattr(own, name).tobytes() == getattr(together, name)[k].tobytes(), (k, name)


@pytest.mark.parametrize("scene", [TOPS, DAMPED, MIXED])
@pytest.mark.parametrize(
    "options",
    [{}, {"accuracy": 1e-6}, {"step": 0.05}, {"method": "dop853"}, {"method": "taylor16"}],
    ids=str,
)
def test_a_body_is_solved_as_if_it_were_alone(
    scene: rigid.FreeBody | rigid.HeavyTop, options: dict[str, Any]
) -> None:
    together, each = rigid.simulate(scene, OMEGA, t=TIMES, **options), alone(scene, **options)
    assert_equal(together, each)
    assert_equal(together.at([1.0, 5.0]), [own.at([1.0, 5.0]) for own in each])


def test_bodies_of_one_call_have_the_methods_that_they_need() -> None:
    assert [run.plan.method for run in alone(TOPS)] == ["exact", "dop853", "exact", "dop853"]
    assert [run.plan.method for run in alone(DAMPED)] == ["exact", "dop853", "etd4", "exact"]
    plan = rigid.simulate(DAMPED, OMEGA, t=TIMES).plan
    assert plan.method == "dop853"
    assert plan.why[-2:] == ("2 of 4 bodies in closed form", "1 of 4 bodies by etd4")
    assert rigid.plan(DAMPED, "attitude", omega=OMEGA, t_end=7.0).why[-2:] == plan.why[-2:]


def test_events_are_those_of_each_body_alone() -> None:
    event = rigid.crosses("omega2")
    together = rigid.simulate(TOPS, OMEGA, t=TIMES, until=event)
    each = alone(TOPS, until=event)
    assert_equal(together, each)
    assert together.events[0].count.tolist() == [int(run.events[0].count) for run in each]
    for k, run in enumerate(each):
        own = together.events[0].of(k)
        for name in ("t", "omega", "attitude", "slope", "error"):
            assert getattr(own, name).tobytes() == getattr(run.events[0], name).tobytes()


def test_axes_of_scene_and_starts_broadcast() -> None:
    tops = rigid.HeavyTop(BODIES, mgl=[[1.0], [2.0]])
    together = rigid.simulate(tops, OMEGA, t=TIMES)
    assert together.omega.shape == (2, 4, 3, 3)
    for row in range(2):
        for k in range(4):
            own = rigid.simulate(tops[row, k], OMEGA[k], t=TIMES)
            assert own.omega.tobytes() == together.omega[row, k].tobytes()
            assert own.error == together.error[row, k]


def test_derivatives_are_those_of_each_body_alone() -> None:
    names = ("I1", "damping")
    together = rigid.simulate(DAMPED, OMEGA, t=TIMES, tangent=names)
    for k, own in enumerate(alone(DAMPED, tangent=names)):
        for name in ("tangent", "sensitivity"):
            assert getattr(own, name).tobytes() == getattr(together, name)[k].tobytes()
