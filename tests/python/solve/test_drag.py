"""Quadratic drag: closed forms, the loss of energy, and what is refused."""

import dataclasses
from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid.model.scene import scene_from_dict

METHODS = [method.name for method in rigid.methods() if "drag" in method.forces]


BODY = rigid.Body((1.0, 1.5, 2.0))


@pytest.mark.parametrize("method", METHODS)
def test_a_sphere_slows_with_one_over_the_time(method: str) -> None:
    # I w' = -c |w| w is w = w0 / (1 + c |w0| t / I), about the axis of the start.
    sphere = rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)), drag=0.3)
    omega, t = np.array([1.8, -0.7, 2.4]), np.array([0.0, 1.0, 10.0])
    run = rigid.simulate(sphere, omega, t=t, method=method)
    slower = 1.0 + 0.3 / 2.0 * np.linalg.norm(omega) * t
    # The stated error, and some roundings.
    allowed = run.error + 1e-14
    assert np.abs(run.omega * slower[:, np.newaxis] - omega).max() < allowed * np.abs(omega).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_motor_brings_a_body_at_rest_to_the_rate_at_which_drag_holds_it(
    method: str, sign: float
) -> None:
    # I w' = N - c w^2 from rest is w = sqrt(N / c) tanh(sqrt(N c) t / I).
    torque = rigid.Torque.body((0.0, 0.0, 2.0 * sign))
    motor = rigid.FreeBody(rigid.Body((1.0, 1.0, 2.0)), torque=torque, drag=(0.0, 0.1, 0.5))
    t = np.array([0.0, 0.5, 2.0, 5.0])
    run = rigid.simulate(motor, [0.0, 0.0, 0.0], t=t, method=method)
    truth = 2.0 * sign * np.tanh(0.5 * t)
    assert np.abs(run.omega[:, 2] - truth).max() < 2.0 * run.error + 1e-14
    assert run.error < 1e-8


@pytest.mark.parametrize("method", [*METHODS, None])
def test_the_energy_of_a_top_falls_by_the_power_of_the_drag(method: str) -> None:
    drag = np.array([0.05, 0.02, 0.1])
    top = rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), drag=drag)
    t = np.linspace(0.0, 5.0, 2001)
    run: Any = rigid.simulate(top, [0.3, 2.0, 4.0], t=t, method=method)
    assert run.energy_drift < 1e-8
    power = -np.linalg.norm(run.omega, axis=1) * (drag * run.omega**2).sum(axis=1)
    # Simpson's rule of the power; its error is h^4 / 180 times five seconds and a fourth
    # derivative of some 100 W/s^4 at most.
    inner = 4.0 * power[1::2].sum() + 2.0 * power[2:-1:2].sum()
    lost = (t[1] / 3.0) * (power[0] + power[-1] + inner)
    assert abs(run.work[-1] - lost) < 1e-8
    assert np.abs(run.energy() - run.energy()[0] - run.work).max() < 1e-8 * run.energy().max()
    balance = rigid.free.power_balance(run)
    # Differences of order 2 of a power that oscillates at some 10 rad/s.
    assert np.abs(balance.residual).max() < 1e-2
    # Of many bodies and times each has the power of its own rates.
    rates = np.stack([run.omega, 0.5 * run.omega])
    many = rigid.free.power_balance(rigid.FreeBody(BODY, drag=drag), rates, t=t)
    np.testing.assert_allclose(many.power, np.multiply.outer([1.0, 0.125], power), rtol=1e-14)


def test_drag_acts_in_maps_motions_and_files() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), drag=0.2)
    assert scene_from_dict(scene.to_dict()) == scene
    assert "drag 0.2" in scene.words()
    made = rigid.stability_map(
        scene, axes={"I2": [1.2, 1.5]}, samples=8, t_end=5.0, stable=rigid.no_flip(), rng=1
    )
    assert made.stable.shape == (2,)
    motion = rigid.Motion(scene, [0.3, 1.0, 0.2], method="rk4")
    for _ in range(10):
        motion.step(0.1)
    run = rigid.simulate(scene, [0.3, 1.0, 0.2], t=[1.0], method="rk4", step=0.1)
    assert np.abs(motion.omega - run.omega[-1]).max() < 1e-14


def test_a_scene_keeps_its_forces_when_a_field_is_replaced() -> None:
    scene = rigid.FreeBody(BODY, drag=0.3, rotor=(0.0, 0.0, 1.0))
    changes: dict[str, Any] = {"damping": 0.1}
    damped = dataclasses.replace(scene, **changes)
    assert damped == rigid.FreeBody(BODY, drag=0.3, rotor=(0.0, 0.0, 1.0), damping=0.1)
    changes = {"rotor": (0.0, 0.0, 0.0)}
    assert dataclasses.replace(damped, **changes) == rigid.FreeBody(BODY, drag=0.3, damping=0.1)


def test_methods_of_bodies_that_may_stop_are_no_series() -> None:
    stops = rigid.HeavyTop(BODY, mgl=1.0, drag=0.1)
    plan = rigid.plan(stops, omega=[0.1, 0.2, 3.0], t_end=10.0, accuracy=1e-10)
    assert plan.method in ("rk4", "dop853")
    turns = rigid.FreeBody(BODY, drag=0.1)
    assert rigid.plan(turns, omega=[0.1, 0.2, 3.0], t_end=10.0).method in METHODS
    # Nor the method for strong damping, which does not know drag.
    damped = rigid.FreeBody(BODY, drag=0.1, damping=100.0)
    assert rigid.plan(damped, omega=[0.1, 0.2, 0.3], t_end=10.0).method == "dop853"


test_impossible_drag_is_refused = refuses(
    [
        (-0.1, "drag = -0.1: must not be negative"),
        ((0.1, np.nan, 0.0), "drag"),
        ((0.1, 0.2), r"drag: expected shape \(\) or \(..., 3\), got \(2,\)"),
        (0.1, "'midpoint': does not integrate drag"),
    ],
    by=lambda drag: rigid.simulate(
        rigid.FreeBody(BODY, drag=drag), [0.3, 1.0, 0.2], t=[1.0], method="midpoint"
    ),
)
