"""Bodies on eccentric orbits: the periapsis magnifies rounding, and the stated error knows it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from physics import Floats

#: Moments, orbit, rates, attitude, time, and the rates and attitude then in 128-bit numbers, by
#: series of order 40 at 1e-32 and at 1e-34.
CASES: list[tuple[Any, ...]] = [
    (
        (0.96, 1.4, 1.08),
        rigid.Orbit(1.0, 0.95, 3.0),
        (1.5, -0.8, 0.0),
        (-0.9, 1.6, -0.5, 1.0),
        21.0,
        [-47.144768105891046, 18.015249793679153, -51.307041785797004],
        [0.1937888712995388, -0.4636536523376335, 0.8557385984334749, 0.12321775515539854],
    ),
    (
        (0.46, 0.34, 0.4),
        rigid.Orbit(1.0, 0.9, 3.0),
        (-1.0, 0.9, 1.4),
        (0.6, -1.6, 0.6, -0.5),
        26.0,
        [-8.289400899970136, -9.798108551795925, -1.2103222050030062],
        [-0.004653530758618171, 0.6118211325020102, -0.49415420292933127, 0.6176284240566602],
    ),
]

TUMBLING = rigid.FreeBody(rigid.Body((0.9, 1.3, 1.1)), orbit=rigid.Orbit(1.0, 0.9, 2.0))


def cloud(count: int) -> Floats:
    rates: Floats = np.random.default_rng(5).normal(size=(count, 3))
    return rates


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-5}])
def test_rounding_that_a_periapsis_magnifies_is_in_the_stated_error(
    case: tuple[Any, ...], options: dict[str, Any]
) -> None:
    moments, orbit, omega, attitude, t, rates, turned = case
    scene = rigid.FreeBody(rigid.Body(moments), orbit=orbit)
    run = rigid.simulate(scene, omega, attitude, t=[t], **options)
    assert run.attitude is not None
    sign = np.sign(run.attitude[0] @ turned)
    true = max(
        np.linalg.norm(run.omega[0] - rates) / np.linalg.norm(rates),
        2.0 * np.linalg.norm(sign * run.attitude[0] - turned),
    )
    assert run.status == rigid.Status.OK
    # Equal steps were off by 1.1e-5 and 5.3e-8.
    assert true < float(run.error) < 1e-6


def test_the_accuracy_that_is_asked_for_changes_no_bit_on_an_orbit() -> None:
    every: list[dict[str, Any]] = [{}, {"accuracy": 1e-4}, {"accuracy": 1e-11}, {"check": False}]
    runs = [rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0], **options) for options in every]
    assert len({run.omega.tobytes() for run in runs}) == 1


def test_a_run_on_an_orbit_has_the_same_bits_at_other_times() -> None:
    run = rigid.simulate(TUMBLING, cloud(3), t=[0.0, 20.0], accuracy=1e-6)
    again = run.at([7.0, 20.0])
    assert again.omega[:, 1].tobytes() == run.omega[:, 1].tobytes()
    assert (again.error <= 1e-6).all()


def test_the_plan_of_a_run_on_an_orbit_says_how_it_steps() -> None:
    plan = rigid.plan(TUMBLING, omega=[1.0, 0.3, 0.2], t_end=20.0)
    run = rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0])
    assert plan.method == run.plan.method == run.spec["method"] == "taylor20"
    assert plan.step is run.plan.step is None
    assert any("short near the periapsis" in reason for reason in plan.why)
    assert plan.why == run.plan.why
    given = rigid.simulate(TUMBLING, [1.0, 0.3, 0.2], t=[20.0], step=0.01)
    assert given.plan.method == "rk4"


def test_drag_that_stops_a_libration_on_an_orbit_is_in_the_stated_error() -> None:
    # In the plane of the orbit: the rate passes zero, where the speed has a corner.
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.6, 2.0)),
        orbit=rigid.Orbit(1.0, 0.7, 2.0),
        torque=rigid.Torque.body((0.0, 0.0, -0.2)),
        drag=0.3,
    )
    run = rigid.simulate(scene, [0.0, 0.0, 0.4], t=np.linspace(0.0, 12.0, 25))
    fine = rigid.simulate(
        scene, [0.0, 0.0, 0.4], t=np.linspace(0.0, 12.0, 25), method="rk4", step=2e-4, check=False
    )
    assert (run.omega[:, 2] > 0.0).any()
    assert (run.omega[:, 2] < 0.0).any()
    off = np.abs(run.omega - fine.omega).max() / np.abs(fine.omega).max()
    assert off < float(run.error) < 1e-8


def test_a_body_that_drag_stops_has_its_bits_without_a_check_and_reaches_an_accuracy() -> None:
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.5, 2.0)),
        orbit=rigid.Orbit(1e-9),
        torque=rigid.Torque.body((0.0, 0.0, -0.2)),
        drag=0.5,
    )
    rates, t = [0.0, 0.0, 0.5], [0.0, 1.0, 3.0, 10.0]
    # 2 w' = -0.2 - 0.5 |w| w, the gradient of 1e-18 apart: w goes through 0 as tan, then as tanh.
    end, rate = np.sqrt(0.4), 0.5 * np.sqrt(0.1)
    stop = np.arctan(0.5 / end) / rate
    true = [end * (np.tan if s < stop else np.tanh)(rate * (stop - s)) for s in t]
    runs = [rigid.simulate(scene, rates, t=t), rigid.simulate(scene, rates, t=t, check=False)]
    assert runs[0].omega.tobytes() == runs[1].omega.tobytes()
    assert runs[1].at(t).omega.tobytes() == runs[1].omega.tobytes()
    fine = rigid.simulate(scene, rates, t=t, accuracy=1e-10)
    for run, accuracy in ((runs[0], 1e-8), (fine, 1e-10)):
        off = np.abs(run.omega[:, 2] - true).max() / 0.5
        assert off < float(run.error) < accuracy
        assert run.status == rigid.Status.OK
    # The steps of a companion that tumbles are those of the series.
    both = rigid.simulate(scene, [rates, [0.3, 0.2, 0.5]], t=t, check=False)
    assert both.omega[0].tobytes() == runs[0].omega.tobytes()


def test_the_plan_under_all_further_forces_has_nothing_to_leave_out() -> None:
    scene = rigid.FreeBody(
        rigid.Body((0.9, 1.3, 1.1)),
        orbit=rigid.Orbit(1.0, 0.5),
        rotor=(0.0, 0.1, 0.0),
        drag=0.1,
        dissipation=rigid.EnergySink(1e-3),
    )
    plan = rigid.plan(scene, omega=[1.0, 0.3, 0.2], t_end=20.0)
    assert not any("computed as zeros" in reason for reason in plan.why)
