"""What the implicit midpoint rule keeps in steps of any length and under any damping."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, Floats, angular_momentum, energy, gamma_of, present, rotation_angle
from rigid.model.scene import Scene
from rigid.solve.status import ARRIVED

BODY = rigid.Body((1.0, 1.6, 2.1))
START = ([0.5, 1.0, 0.8], [0.8, 0.36, -0.48, 0.0])
SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(BODY),
    "symmetric top": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.6)), mgl=1.0),
    "top": rigid.HeavyTop(BODY, mgl=1.0, com=(0.6, 0.0, 0.8)),
}


def turning(scene: Scene, omega: Floats, attitude: Floats) -> float:
    """The bound of the rates that steps follow: the default ones are a sixteenth of a radian."""
    step = rigid.plan(scene, "rates", omega=omega, attitude=attitude, method="midpoint").step
    assert step is not None
    return 1.0 / (16.0 * step)


def kept(scene: Scene, run: rigid.Run) -> dict[str, Floats]:
    """All that is quadratic in momenta and directions, relative to its size."""
    q = present(run.attitude)
    momentum, up = angular_momentum(scene, run.omega), gamma_of(q)
    kinetic = energy(scene, run.omega)
    size = np.linalg.norm(momentum, axis=-1)
    if isinstance(scene, rigid.FreeBody):
        return {
            "energy": kinetic / kinetic[0],
            "L": size / size[0],
            "L along the vertical": (momentum * up).sum(axis=-1) / size[0],
        }
    gamma = present(run.gamma)
    assert isinstance(scene, rigid.HeavyTop)
    return {
        "energy": energy(scene, run.omega, gamma) / (kinetic[0] + scene.mgl),
        "L along the vertical": (momentum * gamma).sum(axis=-1) / size[0],
        "vertical": np.linalg.norm(gamma, axis=-1),
    }


@pytest.mark.parametrize("name", SCENES)
def test_nothing_drifts_over_many_steps_of_half_a_radian(name: str) -> None:
    """Rounding is a random walk: what 16 bodies gain in a hundredth of the time is none of a drift.

    The invariants feel the roundings of a step's last turn and kick: about ten, of a roundoff each.
    """
    scene, steps, blocks = SCENES[name], 100_000, 100
    rng, attitude = np.random.default_rng(3), np.array(START[1])
    slopes: dict[str, list[float]] = {}
    for _ in range(16):
        omega = START[0] + 0.3 * rng.normal(size=3)
        step = 0.5 / turning(scene, omega, attitude)
        t = step * np.linspace(0.0, steps, blocks + 1)
        run = rigid.simulate(scene, omega, attitude, t=t, method="midpoint", step=step, check=False)
        assert run.steps == steps
        for what, value in kept(scene, run).items():
            gained = np.diff(value)
            slopes.setdefault(what, []).append(gained.mean() / gained.std(ddof=1) * np.sqrt(blocks))
            assert np.abs(value - value[0]).max() < 4.0 * ROUNDOFF * np.sqrt(10.0 * steps), what
    for what, found in slopes.items():
        assert abs(np.mean(found)) < 3.0 / np.sqrt(len(found)), what
        # Of a symmetric top the vertical comes back to the same few angles: roundings repeat.
        if (name, what) != ("symmetric top", "vertical"):
            assert max(map(abs, found)) < 3.0, what


def random_tops(count: int, rng: np.random.Generator) -> list[tuple[Scene, Floats, Floats]]:
    """Free bodies and tops of all shapes, slow and fast."""
    found: list[tuple[Scene, Floats, Floats]] = []
    for k in range(count):
        parts = rng.uniform(0.02, 1.2, 3)
        body = rigid.Body(parts.sum() - parts)
        omega = rng.normal(size=3) * 10.0 ** rng.uniform(-2.0, 1.0)
        com = rng.normal(size=3)
        scene = (
            rigid.FreeBody(body)
            if k % 3 == 0
            else rigid.HeavyTop(body, mgl=rng.uniform(0.3, 3.0), com=com / np.linalg.norm(com))
        )
        found.append((scene, omega, rng.normal(size=4)))
    return found


@pytest.mark.parametrize("angle", [1.0, 3.0, 10.0, 30.0])
def test_energy_and_momentum_stay_in_steps_of_many_radians(angle: float) -> None:
    """Where the equation of a step has no solution at hand it is taken as several."""
    for scene, omega, attitude in random_tops(60, np.random.default_rng(4)):
        step = angle / turning(scene, omega, attitude)
        run = rigid.simulate(
            scene, omega, attitude, t=[1000 * step], method="midpoint", step=step, check=False
        )
        assert run.status in ARRIVED
        # A thousand steps of up to 64 turns of ten operations, all the same way.
        assert max(run.energy_drift, run.momentum_drift, run.unit_drift) < 1e-10


@pytest.mark.parametrize("angle", [0.3, 1.0])
def test_large_steps_find_the_way_back(angle: float) -> None:
    """Rounding of 2 x 100 steps; chaos may multiply it a thousand times in so many radians."""
    for scene, omega, attitude in random_tops(30, np.random.default_rng(5)):
        step = angle / turning(scene, omega, attitude)
        t = 100 * step
        there = rigid.simulate(
            scene, omega, attitude, t=[t], method="midpoint", step=step, check=False
        )
        back = rigid.simulate(
            scene,
            there.omega[0],
            present(there.attitude)[0],
            t=[-t],
            method="midpoint",
            step=step,
            check=False,
        )
        missed = np.linalg.norm(back.omega[0] - omega) / np.linalg.norm(omega)
        assert missed < 1e-9
        assert rotation_angle(present(back.attitude)[0], attitude) < 1e-9


def test_the_error_of_rates_and_attitude_falls_with_the_square_of_the_step() -> None:
    """Of the three kinds of scene, and under torque and damping."""
    torque = rigid.Torque.body([(0.2, -0.5, 0.9), (1.0, 0.3, -0.7)], times=[0.0, 4.0])
    driven = rigid.HeavyTop(
        BODY,
        mgl=1.0,
        com=(0.6, 0.0, 0.8),
        torque=torque + rigid.Torque.space((0.3, -0.2, 0.1)),
        damping=(0.3, 0.2, 0.4),
    )
    for scene in (*SCENES.values(), driven):
        truth = rigid.simulate(scene, *START, t=[4.0], method="taylor26")
        errors = []
        for count in (100, 200, 400, 800):
            run = rigid.simulate(
                scene, *START, t=[4.0], method="midpoint", step=4.0 / count, check=False
            )
            of_rates = np.linalg.norm(run.omega - truth.omega)
            angle = rotation_angle(present(run.attitude), present(truth.attitude))[0]
            errors.append((of_rates, angle))
            # Energy less work, momentum less impulse: the rule keeps the balances too.
            assert max(run.energy_drift, run.momentum_drift) < 1e-13
        slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        assert slopes == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("product", [1.0, 1e2, 1e4, 1e6])
def test_strong_damping_never_feeds_a_body(product: float) -> None:
    """`h c/I` up to 1e6: the energy only falls, and the body turns no further than `4 omega I/c`.

    It stops after `omega I/c`; the rule, which is A-stable but not L-stable, swings about there.
    """
    damping = np.array([[1.0, 0.1, 0.0], [0.1, 1.2, 0.2], [0.0, 0.2, 0.9]])
    omega, step = np.array([3.0, -2.0, 5.0]), 0.05
    scene = rigid.FreeBody(BODY, damping=damping * product / step)
    t = step * np.arange(101)
    run = rigid.simulate(scene, omega, t=t, method="midpoint", step=step, check=False)
    assert run.status in ARRIVED
    kinetic = energy(scene, run.omega)
    assert np.all(np.diff(kinetic) <= 1e-14 * kinetic[0])
    slowest = product / step * 0.8 / 2.1
    attitudes = present(run.attitude)
    turned = rotation_angle(attitudes, np.broadcast_to(attitudes[0], attitudes.shape))
    assert turned.max() < 4.0 * np.linalg.norm(omega) / slowest
    assert run.energy_drift < 1e-11


@pytest.mark.parametrize("c", [1e2, 1e4, 1e6])
def test_a_top_that_sinks_through_strong_damping(c: float) -> None:
    """Started as it sinks, `D omega = torque`; the error of the attitude falls with `h^2`.

    Steps are up to 1e5 damping times long, and the rule follows the motion that they leave.
    """
    shape = np.array([[1.0, 0.1, 0.0], [0.1, 1.2, 0.2], [0.0, 0.2, 0.9]])
    scene = rigid.HeavyTop(BODY, mgl=3.0 * c, com=(0.0, 0.6, 0.8), damping=c * shape)
    attitude = np.array(START[1])
    omega = np.linalg.solve(c * shape, np.cross(gamma_of(attitude), scene.weight))
    truth = rigid.simulate(
        scene, omega, attitude, t=[1.0], method="etd4", step=1.0 / 20000, check=False
    )
    errors = []
    for count in (10, 20, 40, 80):
        run = rigid.simulate(
            scene, omega, attitude, t=[1.0], method="midpoint", step=1.0 / count, check=False
        )
        assert run.status in ARRIVED
        angle = rotation_angle(present(run.attitude), present(truth.attitude))[0]
        errors.append(float(angle))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-4
