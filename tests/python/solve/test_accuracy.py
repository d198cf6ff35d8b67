"""Runs to an accuracy: how near they come to it, in which steps, and what these depend on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from physics import Floats, present, rotation_angle
from rigid.solve import integrate

BODY = rigid.Body((1.0, 1.6, 0.7))
TOP = rigid.HeavyTop(BODY, mgl=1.2, com=(0.6, 0.0, 0.8))
MANY = 600
"""So many that the errors of a few tell the steps of all."""


def cloud(spin: float = 2.6, count: int = MANY) -> Floats:
    rng = np.random.default_rng(7)
    rates: Floats = spin * (np.array([0.19, 0.15, 0.97]) + 4e-4 * rng.normal(size=(count, 3)))
    return rates


def true_errors(run: rigid.Run) -> Floats:
    """Error of the last states, as runs state it, by a series of order 26."""
    omega, t = run.start_omega, run.t[-1:]
    truth = rigid.simulate(TOP, omega, t=t, method="taylor26", check=False)
    size = np.maximum(*(np.linalg.norm(of.omega[:, -1], axis=-1) for of in (run, truth)))
    rates = np.linalg.norm(run.omega - truth.omega, axis=-1)[:, -1] / size
    angles = rotation_angle(present(run.attitude), present(truth.attitude))[:, -1]
    largest: Floats = np.maximum(rates, angles)
    return largest


@pytest.mark.parametrize("spin", [2.6, 5.0, 10.0])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8])
def test_tops_of_a_cloud_err_less_than_stated_and_the_steps_are_not_much_too_short(
    spin: float, accuracy: float
) -> None:
    run = rigid.simulate(TOP, cloud(spin), t=[50.0 / spin], accuracy=accuracy)
    true = true_errors(run)
    assert np.all(true <= run.error)
    assert not run.flagged.any()
    assert 0.5 * accuracy < run.error.max() <= accuracy
    assert np.median(run.error / true) < 10.0


def test_chaotic_tops_seldom_err_by_more_than_is_stated() -> None:
    """Errors grow by a factor of 1e4 and more: two runs may err alike by chance."""
    rng = np.random.default_rng(5)
    run = rigid.simulate(TOP, rng.normal(size=(MANY, 3)), t=[50.0], accuracy=1e-5)
    assert np.count_nonzero(true_errors(run) > run.error) <= 0.01 * MANY
    assert np.count_nonzero(run.flagged) <= 0.01 * MANY


@pytest.mark.parametrize("accuracy", [1e-4, 1e-7, 1e-10])
@pytest.mark.parametrize("method", [None, "pmlf6", "rk4", "taylor12"])
def test_the_plan_of_a_run_has_the_step_that_was_made(method: str | None, accuracy: float) -> None:
    run = rigid.simulate(TOP, [0.5, 0.4, 2.0], t=[10.0], accuracy=accuracy, method=method)
    assert run.plan.step == 10.0 / run.steps
    assert run.plan.steps == run.steps
    assert run.plan.step is not None
    # The quotient is rounded: a step that is shorter by it would make one step more.
    step = run.plan.step * (1.0 + 1e-15)
    again = rigid.simulate(TOP, [0.5, 0.4, 2.0], t=[10.0], method=run.plan.method, step=step)
    assert again.omega.tobytes() == run.omega.tobytes()


def test_the_shortest_step_of_many_tops_is_that_of_the_plan() -> None:
    rates = [[0.5, 0.4, 2.5], [0.5, 0.4, 25.0]]
    run = rigid.simulate(TOP, rates, t=[3.0, 9.0], accuracy=1e-7, method="dop853")
    assert run.steps[1] > 5 * run.steps[0]
    assert (run.plan.step, run.plan.steps) == (9.0 / run.steps[1], run.steps[1])


def test_a_given_method_moves_a_body_of_a_large_call_as_if_it_were_alone() -> None:
    options: dict[str, Any] = {"t": [20.0], "accuracy": 1e-6, "method": "dop853"}
    run = rigid.simulate(TOP, cloud(), **options)
    for body in (0, 333, MANY - 1):
        alone = rigid.simulate(TOP, cloud()[body], **options)
        assert alone.omega.tobytes() == run.omega[body].tobytes()
        assert alone.error == run.error[body]


def test_the_steps_of_a_large_call_depend_on_neither_threads_nor_the_order_of_bodies() -> None:
    options: dict[str, Any] = {"t": [20.0], "accuracy": 1e-6}
    run = rigid.simulate(TOP, cloud(), threads=1, **options)
    backward = rigid.simulate(TOP, cloud()[::-1], threads=2, **options)
    assert backward.omega[::-1].tobytes() == run.omega.tobytes()
    assert (backward.error[::-1] == run.error).all()


@pytest.mark.parametrize("method", ["chin4a", "pmlf4"])
def test_free_motions_and_kicks_err_in_proportion_to_the_weight_over_the_spin(method: str) -> None:
    """At equal angles a step, four times the spin leaves a sixteenth of ``mgl / (I omega²)``."""
    errors, steps = [], []
    for spin in (8.0, 32.0):
        options: dict[str, Any] = {"t": [30.0 / spin], "method": method}
        run = rigid.simulate(TOP, cloud(spin, 32), step=0.5 / spin, check=False, **options)
        errors.append(float(np.median(true_errors(run))))
        plan = rigid.plan(
            TOP, omega=cloud(spin, 32), t_end=30.0 / spin, method=method, accuracy=1e-8
        )
        assert plan.step is not None
        steps.append(spin * plan.step)
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)
    # They are of order 4: a sixteenth of the error allows twice the angle.
    assert steps[1] / steps[0] == pytest.approx(2.0, rel=0.2)


def test_motions_that_are_lost_tell_no_steps_of_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two runs of a lost motion differ by one, whatever the steps."""
    omega = np.random.default_rng(1).normal(size=(512, 3))
    piloted = rigid.simulate(TOP, omega, t=[120.0], accuracy=1e-3)
    assert np.count_nonzero(piloted.flagged) > 128
    monkeypatch.setattr(integrate, "PILOTED", 513)
    plain = rigid.simulate(TOP, omega, t=[120.0], accuracy=1e-3)
    assert np.array_equal(piloted.steps, plain.steps)


def test_rounding_of_a_steady_spin_is_left_out_by_a_series() -> None:
    """In closed form the gyrostat turns about its axis 3 by 2 rad a second."""
    scene = rigid.FreeBody(rigid.Body((1.0, 1.1, 1.2)), rotor=(0.0, 0.0, 0.3))
    run = rigid.simulate(scene, [0.0, 0.0, 2.0], t=[12566.0], accuracy=1e-8)
    assert run.attitude is not None
    turned = np.array([np.cos(12566.0), 0.0, 0.0, np.sin(12566.0)])
    true = 2.0 * min(np.linalg.norm(run.attitude[0] + sign * turned) for sign in (1.0, -1.0))
    assert true < run.error < 1e-8
    assert run.status == rigid.Status.OK
    assert run.plan.method == "taylor20"
    assert "1 of 1 bodies by taylor20" in run.plan.why[-1]
    again = run.at([12566.0])
    assert again.omega.tobytes() == run.omega.tobytes()


def test_the_plan_of_a_lost_top_says_that_a_series_was_no_better() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    run = rigid.simulate(top, [0.3, 0.4, 1.0], t=[200.0], accuracy=1e-11)
    assert run.status == rigid.Status.FLAGGED
    assert run.plan.method == "dop853"
    assert run.plan.why[-1] == "taylor20 was no better: rounding or chaos is the error"


def test_the_remedy_of_a_method_that_misses_the_accuracy_works() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.1, 1.2)), rotor=(0.0, 0.0, 0.3))
    given: dict[str, Any] = {"t": [3000.0], "accuracy": 1e-9}
    run = rigid.simulate(scene, [0.0, 0.0, 2.0], method="dop853", **given)
    assert run.status == rigid.Status.FLAGGED
    assert "shorter steps of dop853 do not help: leave out the method" in run.reasons()[0]
    assert rigid.simulate(scene, [0.0, 0.0, 2.0], **given).status == rigid.Status.OK


@pytest.mark.parametrize("times", [2, 31, 301])
def test_steps_are_shortened_for_the_drift_beside_a_separatrix_too(times: int) -> None:
    box = rigid.FreeBody(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3))
    t = np.linspace(0.0, 30.0, times)
    run = rigid.simulate(box, [0.05, 1.02, 0.07], t=t, method="splitting4", accuracy=1e-6)
    exact = rigid.simulate(box, [0.05, 1.02, 0.07], t=t)
    assert run.status == rigid.Status.OK
    assert np.abs(run.omega - exact.omega).max() < run.error * np.linalg.norm([0.05, 1.02, 0.07])


def test_bodies_that_a_series_moves_are_counted_in_the_plan_and_made_again_alike() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.1, 1.2)), rotor=(0.0, 0.0, 0.3))
    run = rigid.simulate(scene, [[0.0, 0.0, 2.0], [0.0, 0.0, 1e-3]], t=[12566.0], accuracy=1e-8)
    assert "1 of 2 bodies by taylor20" in run.plan.why[-1]
    assert run.plan.method == run.spec["method"] != "taylor20"
    assert run.plan.steps == run.steps[1]
    assert run.at([12566.0]).omega.tobytes() == run.omega.tobytes()
