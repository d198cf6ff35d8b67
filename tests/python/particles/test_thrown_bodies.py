"""Thrown bodies: the path of the centre of mass, and the rotation."""

from typing import Any

import numpy as np
import pytest

import rigid
from clouds import BODY, RATES, TIMES, throw
from physics import angular_momentum, present
from printed_equations import solved
from rigid import particles

# The thrown body


def test_a_free_body_goes_straight_and_a_constant_force_makes_a_parabola() -> None:
    straight = throw([0.0, 0.0, 0.0])
    line = np.array([1.0, 2.0, 3.0]) + TIMES[:, None] * [0.5, -1.0, 4.0]
    assert np.array_equal(straight.position, line)
    assert np.array_equal(straight.velocity, np.broadcast_to([0.5, -1.0, 4.0], (41, 3)))
    force = np.array([0.3, 0.0, -9.81 * 1.7])
    thrown = throw(force)
    np.testing.assert_allclose(
        thrown.position, line + 0.5 * force / 1.7 * TIMES[:, None] ** 2, atol=8e-15 * 60
    )
    np.testing.assert_allclose(
        thrown.velocity, [0.5, -1.0, 4.0] + force / 1.7 * TIMES[:, None], atol=1e-14
    )
    # A force through the centre of mass turns nothing.
    assert thrown.rotation.omega.tobytes() == straight.rotation.omega.tobytes()
    assert thrown.rotation.attitude is not None
    alone = rigid.simulate(rigid.FreeBody(BODY), RATES, t=TIMES)
    assert present(thrown.rotation.attitude).tobytes() == present(alone.attitude).tobytes()


def test_without_torque_the_momentum_is_constant_and_the_rotation_is_not() -> None:
    """ "Zero torque leaves the rotation unchanged" is wrong about any axis but a principal one."""
    path = throw([0.0, 0.0, 0.0], t=np.linspace(0.0, 40.0, 401))
    run = path.rotation
    body_momentum = angular_momentum(rigid.FreeBody(BODY), run.omega)
    momentum = np.stack(
        [turn.apply(one) for turn, one in zip(run.rotation(), body_momentum, strict=True)]
    )
    assert np.ptp(momentum, axis=0).max() < 1e-12
    assert np.ptp(run.omega[:, 1]) > 1.99


def test_sampled_forces_are_integrated_to_fourth_order() -> None:
    def error(count: int) -> float:
        t = np.linspace(-1.0, 3.0, count)
        force = 1.7 * np.stack([np.cos(2 * t), np.exp(-t), 0 * t], axis=1)
        path = throw(force, t=t)
        x = 1.0 + 0.5 * t + (1.0 - np.cos(2 * t)) / 4.0
        y = 2.0 - t + np.exp(-t) + t - 1.0
        truth = np.stack([x, y, 3.0 + 4.0 * t], axis=1)
        start = path.position[np.argmin(np.abs(t))]
        np.testing.assert_allclose(start, [1.0, 2.0, 3.0], atol=1e-14)
        return float(np.abs(path.position - truth).max())

    coarse, fine = error(41), error(81)
    assert fine < 1e-6
    assert coarse / fine == pytest.approx(16.0, rel=0.15)


def test_a_sampled_line_of_forces_is_exact() -> None:
    # A straight line is its own spline: x = F0 t²/2m + F1 t³/6m.
    t = np.array([0.0, 0.3, 1.0, 2.0])
    first, slope = np.array([0.2, -0.4, 1.0]), np.array([1.0, 0.5, -2.0])
    s = t[:, None]
    path = throw(first + slope * s, t=t)
    truth = [1.0, 2.0, 3.0] + s * [0.5, -1.0, 4.0] + (first * s**2 / 2 + slope * s**3 / 6) / 1.7
    np.testing.assert_allclose(path.position, truth, atol=1e-13)


def test_many_bodies_are_thrown_at_once() -> None:
    omega = np.array([[0.0, 1.0, 0.1], [0.3, 0.0, 2.0]])
    path = throw([0.0, 0.0, -1.0], omega=omega, position=[[0.0, 0, 0], [1, 1, 1]])
    assert path.position.shape == (2, 41, 3)
    assert path.rotation.omega.shape == (2, 41, 3)
    np.testing.assert_allclose(path.position[1] - path.position[0], 1.0, atol=1e-13)
    own = np.array([[[0.0, 0.0, -1.0]], [[0.0, 0.0, -2.0]]])
    each = throw(own, omega=omega)
    np.testing.assert_allclose(each.velocity[:, -1, 2], 4.0 - np.array([1.0, 2.0]) * 5.0 / 1.7)
    sampled = throw(own * TIMES[:, np.newaxis], omega=omega)
    fallen = -np.array([1.0, 2.0]) * 5.0**2 / 2.0 / 1.7
    np.testing.assert_allclose(sampled.velocity[:, -1, 2], 4.0 + fallen)
    none = throw([0.0, 0.0, -1.0], omega=np.zeros((0, 3)))
    assert none.position.shape == (0, 41, 3)


FORCES: list[dict[str, Any]] = [
    {"torque": rigid.Torque.space((-0.05, 1.0, 0.05))},
    {"torque": rigid.Torque.body((0.0, 0.1, 0.3))},
    {"damping": 0.5},
    {"drag": 0.2},
    {"rotor": (0.0, 0.0, 2.0)},
    {"dissipation": rigid.EnergySink(0.2)},
]


@pytest.mark.parametrize("forces", FORCES, ids=lambda forces: next(iter(forces)))
def test_a_thrown_body_turns_under_its_torques(forces: dict[str, Any]) -> None:
    scene = rigid.FreeBody(BODY, **forces)
    weight = [0.0, 0.0, -9.81 * 1.7]
    start: Any = [0.0, 0.0, 2.0], [3.0, 0.0, 1.0], RATES
    path = particles.propagate_body(scene, *start, force=weight, t=TIMES)
    alone = particles.propagate_body(BODY, *start, force=weight, t=TIMES)
    assert np.array_equal(path.position, alone.position)
    truth, _ = solved(scene, RATES, [1.0, 0.0, 0.0, 0.0], [5.0])
    assert path.rotation.omega[-1] == pytest.approx(truth[-1], abs=1e-7)
    assert np.abs(path.rotation.omega[-1] - alone.rotation.omega[-1]).max() > 0.01


# Refusals


def test_a_body_on_an_orbit_is_not_thrown() -> None:
    scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(0.1))
    with pytest.raises(ValueError, match="position, velocity and force move its centre of mass"):
        particles.propagate_body(scene, np.zeros(3), np.zeros(3), RATES, t=1.0)


def test_only_bodies_are_thrown() -> None:
    with pytest.raises(TypeError, match=r"body = 3: must be a rigid\.Body"):
        particles.propagate_body(3, np.zeros(3), np.zeros(3), RATES, t=1.0)  # type: ignore[arg-type]
