"""Runs to an accuracy: how near they come to it, in which steps, and what these depend on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rigid
from physics import Floats, present, rotation_angle
from rigid.solve.arrays import roots

BODY = rigid.Body((1.0, 1.6, 0.7))
TOP = rigid.HeavyTop(BODY, mgl=1.2, com=(0.6, 0.0, 0.8))
MANY = 600


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
def test_tops_of_a_cloud_err_less_than_stated(spin: float, accuracy: float) -> None:
    run = rigid.simulate(TOP, cloud(spin), t=[50.0 / spin], accuracy=accuracy)
    assert np.all(true_errors(run) <= run.error)
    assert not run.flagged.any()


def test_chaotic_tops_seldom_err_by_more_than_is_stated() -> None:
    """Errors grow by a factor of 1e4 and more: two runs may err alike by chance."""
    rng = np.random.default_rng(5)
    run = rigid.simulate(TOP, rng.normal(size=(MANY, 3)), t=[50.0], accuracy=1e-5)
    assert np.count_nonzero(true_errors(run) > run.error) <= 0.01 * MANY
    assert np.count_nonzero(run.flagged) <= 0.01 * MANY


@pytest.mark.parametrize("accuracy", [1e-4, 1e-7, 1e-10])
@pytest.mark.parametrize("method", ["pmlf6", "rk4", "dop853"])
def test_the_plan_of_a_run_has_the_step_that_was_made(method: str, accuracy: float) -> None:
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


@pytest.mark.parametrize("method", ["chin4a", "pmlf4"])
def test_free_motions_and_kicks_err_in_proportion_to_the_weight_over_the_spin(method: str) -> None:
    """At equal angles a step, four times the spin leaves a sixteenth of ``mgl / (I omega²)``."""
    errors = []
    for spin in (8.0, 32.0):
        options: dict[str, Any] = {"t": [30.0 / spin], "method": method}
        run = rigid.simulate(TOP, cloud(spin, 32), step=0.5 / spin, check=False, **options)
        errors.append(float(np.median(true_errors(run))))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)


def test_rounding_of_a_steady_spin_does_not_grow_with_its_steps() -> None:
    """In closed form the gyrostat turns about its axis 3 by 2 rad a second."""
    scene = rigid.FreeBody(rigid.Body((1.0, 1.1, 1.2)), rotor=(0.0, 0.0, 0.3))
    run = rigid.simulate(scene, [0.0, 0.0, 2.0], t=[12566.0], accuracy=1e-8)
    assert run.attitude is not None
    turned = np.array([np.cos(12566.0), 0.0, 0.0, np.sin(12566.0)])
    true = 2.0 * min(np.linalg.norm(run.attitude[0] + sign * turned) for sign in (1.0, -1.0))
    assert true < run.error < 1e-8
    assert run.status == rigid.Status.OK
    again = run.at([12566.0])
    assert again.omega.tobytes() == run.omega.tobytes()


def test_the_remedy_of_a_lost_top_is_an_earlier_end() -> None:
    run = rigid.simulate(TOP, [0.3, 0.4, 1.0], t=[200.0], accuracy=1e-11)
    assert run.status == rigid.Status.FLAGGED
    assert "end the run earlier" in run.reasons()[0]
    assert rigid.simulate(TOP, [0.3, 0.4, 1.0], t=[10.0], accuracy=1e-11).status == rigid.Status.OK


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


@pytest.mark.parametrize("order", [2, 4, 6, 8, 10])
def test_roots_of_steps_are_those_of_each_number_alone(order: int) -> None:
    numbers: Floats = np.random.default_rng(1).uniform(1e-12, 1e3, 999)
    found = roots(numbers, order)
    assert all(roots(numbers[k : k + 1], order)[0] == found[k] for k in range(0, 999, 37))
    # The rounded exponent, 1/6 or 1/10, errs by half a unit, which ``|ln x| <= 28`` multiplies; the
    # power by an order multiplies the rounding of each root by it.
    unit = np.finfo(np.float64).eps
    assert np.abs(found**order / numbers - 1.0).max() < (14.0 + order) * unit


@pytest.mark.parametrize("order", [2, 4, 8])
def test_roots_of_the_orders_of_most_methods_are_exact_where_they_can_be(order: int) -> None:
    whole: Floats = np.ldexp(np.ones(41), np.arange(-20, 21))
    powers: Floats = whole**order
    assert (roots(powers, order) == whole).all()


SPUN = rigid.Body((1.0, 1.1, 1.2))

STEADY: dict[str, tuple[rigid.FreeBody, float]] = {
    "rotor": (rigid.FreeBody(SPUN, rotor=(0.0, 0.0, 0.3)), 0.0),
    "sink": (rigid.FreeBody(SPUN, dissipation=rigid.EnergySink(0.05)), 0.0),
    "orbit": (rigid.FreeBody(rigid.Body((1.0, 1.0, 1.2)), orbit=rigid.Orbit(rate=1.0)), 0.0),
    "torque": (rigid.FreeBody(SPUN, torque=rigid.Torque.body([0.0, 0.0, 1e-9])), 1e-9 / 1.2),
}
"""Bodies that spin about axis 3, and the acceleration of the spin (rad/s²)."""


@pytest.mark.parametrize("name", STEADY)
def test_a_steady_spin_of_twenty_thousand_radians_is_accurate(name: str) -> None:
    """Rounding of equal steps, all alike, exceeds the accuracy; a series does not add it up."""
    scene, acceleration = STEADY[name]
    t = 12566.0
    run = rigid.simulate(scene, [0.0, 0.0, 2.0], t=[t], accuracy=1e-8)
    half = t + 0.25 * acceleration * t * t
    turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    assert run.attitude is not None
    apart = 2.0 * min(
        np.linalg.norm(run.attitude[0] - turn), np.linalg.norm(run.attitude[0] + turn)
    )
    assert run.status == rigid.Status.OK
    assert apart <= float(run.error) < 1e-8


def test_the_limit_of_steps_holds_for_the_run_and_not_for_its_check() -> None:
    """A series of order 16 needs more steps for the check than one of order 26 for the run."""
    options: dict[str, Any] = {"t": [20.0], "method": "taylor26", "accuracy": 1e-8}
    free = rigid.simulate(TOP, [0.3, 0.4, 1.0], **options)
    limited = rigid.simulate(TOP, [0.3, 0.4, 1.0], **options, max_steps=int(free.steps))
    assert limited.status == rigid.Status.OK
    assert limited.error == free.error


def test_no_body_is_planned_by_the_method_that_was_asked_for() -> None:
    none = rigid.simulate(TOP, np.zeros((0, 3)), t=[1.0], method="rk4", accuracy=1e-6)
    assert (none.plan.method, none.plan.tolerance) == ("rk4", None)


def test_an_accuracy_above_one_is_as_one_under_a_function() -> None:
    def brake(t: float, omega: Floats, attitude: Floats, data: Floats, torque: Floats) -> None:
        torque[:] = -0.1 * omega

    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 2.0)), torque=rigid.Torque.call(brake))
    run, same = (
        rigid.simulate(scene, [0.3, 0.4, 1.0], t=[1.0], accuracy=accuracy)
        for accuracy in (200.0, 1.0)
    )
    assert run.omega.tobytes() == same.omega.tobytes()
