"""Damping of any strength: the methods that act by its exponential, and who chooses them."""

import re
from typing import Any

import numpy as np
import pytest

import rigid
from physics import (
    ROUNDOFF,
    Floats,
    angular_momentum,
    energy,
    gamma_of,
    golden,
    golden_scene,
    present,
    rotation_angle,
)
from processes import python_process
from rigid.model.scene import Scene
from rigid.solve.status import ARRIVED

STIFF = {method.name: method for method in rigid.methods() if method.stiff}
BODY = rigid.Body((1.0, 1.5, 2.0))
SHAPE = np.array([[1.0, 0.1, 0.0], [0.1, 1.2, 0.2], [0.0, 0.2, 0.9]])
START = ([3.0, -2.0, 5.0], [0.8, 0.36, -0.48, 0.0])
TILTED_COM = (0.0, 0.6, 0.8)


def errors(run: rigid.Run, truth: rigid.Run) -> tuple[float, float]:
    rates = np.linalg.norm(run.omega[-1] - truth.omega[-1]) / np.linalg.norm(truth.omega[-1])
    angle = rotation_angle(present(run.attitude)[-1], present(truth.attitude)[-1])
    return float(rates), float(angle)


def damped_top(c: float) -> rigid.HeavyTop:
    """An asymmetric top that damping lets sink at a rate of about 10 1/s, whatever its strength."""
    return rigid.HeavyTop(BODY, mgl=10.0 * c, com=TILTED_COM, damping=c * SHAPE)


def test_three_methods_do_not_mind_the_strength() -> None:
    assert list(STIFF) == ["splitting", "etd4", "midpoint"]


@pytest.mark.parametrize("method", STIFF)
def test_measured_order_of_the_methods_for_damping(method: str) -> None:
    """Of moderate damping, with a torque that changes in time, in body and space."""
    torque = rigid.Torque.body([(0.2, -0.5, 0.9), (1.0, 0.3, -0.7)], times=[0.0, 2.0])
    scene = rigid.HeavyTop(
        BODY,
        mgl=1.5,
        com=(0.6, 0.0, 0.8),
        torque=torque + rigid.Torque.space((0.3, -0.2, 0.1)),
        damping=SHAPE,
    )
    truth = rigid.simulate(scene, *START, t=[2.0], method="taylor26")
    order = STIFF[method].order
    steps = (0.04 if order == 4 else 0.02) * 0.5 ** np.arange(5)
    runs = [
        rigid.simulate(scene, *START, t=[2.0], method=method, step=float(step), check=False)
        for step in steps
    ]
    for error in np.array([errors(run, truth) for run in runs]).T:
        slope = np.polyfit(np.log(steps), np.log(error), 1)[0]
        assert slope == pytest.approx(order, abs=0.25)
    # So fall the residuals of energy and momentum; the splitting keeps the latter, the
    # midpoint rule both.
    drift = np.array([float(run.energy_drift) for run in runs])
    if method == "midpoint":
        assert drift.max() < 1e-13
    else:
        assert np.polyfit(np.log(steps), np.log(drift), 1)[0] == pytest.approx(order, abs=0.4)
    assert all(run.unit_drift < 1e-13 for run in runs)


#: Products of step and damping of each trajectory: of weak damping longer steps are bounded by the
#: motion, of strong damping shorter ones would be millions.
PRODUCTS = {
    "damped_medium": (1e-2, 1.0),
    "damped_heavy": (1e-2, 1.0),
    "damped_1e3": (1e-2, 1.0, 1e2, 1e4),
    "damped_1e6": (1.0, 1e2, 1e4),
    "overdamped_heavy": (1.0, 1e2, 1e4),
}


@pytest.mark.parametrize(
    ("name", "product"), [(name, one) for name, every in PRODUCTS.items() for one in every]
)
def test_reference_trajectories_at_any_product_of_step_and_damping(
    name: str, product: float
) -> None:
    """Of the scene's own motion a step takes at most a third of a radian.

    The error is of order 4 in the angle of a step; of damping that no step resolves, it is at most
    2e-2 of its fourth power and 1e-8, that of the layer in which the start is forgotten.
    """
    case = golden_scene(f"forced_damped/{name}")
    forcing: Any = case.scene.acting()
    rate = forcing.damping_rates(np.array([case.scene.body.moments]))[0]
    # Strong damping stops what the body started with before it turns.
    moving = case.t > 5.0 / rate if rate > 100.0 else case.t >= 0.0
    speed = np.linalg.norm(case.omega[moving], axis=-1).max()
    step = min(product / rate, 0.3 / speed)
    size = np.linalg.norm(case.omega, axis=-1).max()
    found = []
    for refined in (1.0, 2.0):
        run = case.run("etd4", step=step / refined, check=False)
        assert run.status in ARRIVED
        off = np.linalg.norm(run.omega - case.omega, axis=-1).max() / size
        found.append(np.array([off, rotation_angle(present(run.attitude), case.attitude).max()]))
    layer = 1e-8 if rate * step > 0.5 else 1e-13
    assert (found[0] < 2e-2 * (step * speed) ** 4 + layer).all()
    if rate < 100.0:
        assert (found[1] < found[0] / 14.0).all()


@pytest.mark.parametrize("method", STIFF)
def test_a_torque_against_strong_damping_turns_a_body_at_their_quotient(method: str) -> None:
    """`omega = N / c` in one step a thousand damping times long, and `N t / c` turned.

    By the Cayley transform of the midpoint rule a hundred steps turn it by `200 atan(h omega / 2)`.
    """
    scene = rigid.FreeBody(
        rigid.Body([2.0] * 3), torque=rigid.Torque.body((0, 0, 1e6)), damping=1e6
    )
    run = rigid.simulate(scene, [0.0, 0.0, 1.0], t=[1.0], method=method, step=0.01, check=False)
    assert run.omega[0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-14)
    half = 100.0 * np.arctan(0.005) if method == "midpoint" else 0.5
    assert present(run.attitude)[0] == pytest.approx([np.cos(half), 0, 0, np.sin(half)], abs=1e-13)


def test_strong_damping_is_noticed() -> None:
    """The default method, the one for an accuracy, and what explicit methods say."""
    scene = damped_top(1e5)
    run = rigid.simulate(scene, *START, t=[0.4])
    assert run.plan.method == "etd4"
    assert any("strong damping" in why for why in run.plan.why)
    assert run.steps < 1e4
    truth = rigid.simulate(scene, *START, t=[0.4], method="etd4", step=2e-5, check=False)
    assert max(errors(run, truth)) < run.error < 1e-3
    wanted = rigid.simulate(scene, *START, t=[0.4], accuracy=1e-5)
    assert wanted.plan.method == "etd4"
    assert max(errors(wanted, truth)) < 1e-5
    assert wanted.error <= 1e-5 or wanted.flagged
    weak = rigid.simulate(damped_top(0.1), *START, t=[1.0])
    asked = rigid.simulate(damped_top(0.1), *START, t=[1.0], accuracy=1e-8)
    assert weak.plan.method == asked.plan.method != "etd4"
    assert rigid.plan(scene, "rates", step=0.01).method == "etd4"
    with pytest.raises(ValueError, match="unstable under damping") as refused:
        rigid.simulate(scene, *START, t=[0.4], method="dop853", step=0.01)
    # The plan of this call too, whatever is known of start and horizon.
    for known in ({}, {"omega": START[0]}, {"t_end": 0.4}, {"omega": START[0], "t_end": 0.4}):
        with pytest.raises(ValueError, match=re.escape(str(refused.value))):
            rigid.plan(scene, "rates", method="dop853", step=0.01, **known)
    # A step is cut to the horizon.
    assert rigid.plan(scene, "rates", t_end=1e-6, method="dop853", step=0.01).step == 0.01
    # Left to itself an explicit method takes the many steps that it needs, and says how many.
    many: Any = rigid.plan(scene, "rates", omega=START[0], t_end=0.4, method="rk4")
    assert many.steps > 1e5


def test_without_damping_the_exponential_method_is_the_classical_one() -> None:
    for case in golden("free_asymmetric")[:2]:
        here, there = (case.run(method, step=0.05, check=False) for method in ("etd4", "rk4"))
        assert here.omega.tobytes() == there.omega.tobytes()


OVERFLOW = """
import signal, numpy as np, rigid
body = rigid.Body((1.0, 1.0, 1e-10))
scene = rigid.FreeBody(body, damping=1e299)
calls = {
    "run": lambda scene: rigid.simulate(scene, [0.1, 1.0, 0.2], t=[1.0]),
    "tolerance": lambda scene: rigid.simulate(
        scene, [0.1, 1.0, 0.2], t=[1.0], method="taylor16", tolerance=1e-9
    ),
    "motion": lambda scene: rigid.Motion(scene, [0.1, 1.0, 0.2], method="etd4"),
    "map": lambda scene: rigid.stability_map(
        scene, axes={"spin": [1.0]}, t_end=1.0, stable=rigid.no_flip(), samples=2, rng=1
    ),
    "exponents": lambda scene: rigid.lyapunov(scene, [0.1, 1.0, 0.2], t=[1.0]),
    "section": lambda scene: rigid.simulate(
        scene, [0.1, 1.0, 0.2], t=[1.0], until=rigid.crosses("omega3", 0.1)
    ),
}
for name, call in calls.items():
    signal.alarm(20)  # ends a process that hangs outside of the interpreter
    try:
        call(scene)
        print(name, "returned")
    except ValueError as error:
        print(name, error)
"""


def test_damping_at_a_rate_beyond_the_doubles_is_refused() -> None:
    """Its first leg had no length, and no interruption ended the search for the next one."""
    for line in python_process(OVERFLOW).stdout.strip().splitlines():
        assert "damping = a rate of inf 1/s: damping over moment must be below 1.8e308 1/s" in line


# What the implicit midpoint rule keeps in steps of any length and under any damping


BODY_LARGE = rigid.Body((1.0, 1.6, 2.1))
START_LARGE = ([0.5, 1.0, 0.8], START[1])
SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(BODY_LARGE),
    "symmetric top": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.6)), mgl=1.0),
    "top": rigid.HeavyTop(BODY_LARGE, mgl=1.0, com=(0.6, 0.0, 0.8)),
}


def by_midpoint(scene: Scene, omega: Any, attitude: Any, t: Any, step: float) -> rigid.Run:
    return rigid.simulate(scene, omega, attitude, t=t, method="midpoint", step=step, check=False)


def turning(scene: Scene, omega: Floats, attitude: Floats) -> float:
    """The bound of the rates that steps follow: the default ones are a sixteenth of a radian."""
    step: Any = rigid.plan(scene, "rates", omega=omega, attitude=attitude, method="midpoint").step
    return float(1.0 / (16.0 * step))


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
    rng, attitude = np.random.default_rng(3), np.array(START_LARGE[1])
    slopes: dict[str, list[float]] = {}
    for _ in range(16):
        omega = START_LARGE[0] + 0.3 * rng.normal(size=3)
        step = 0.5 / turning(scene, omega, attitude)
        t = step * np.linspace(0.0, steps, blocks + 1)
        run = by_midpoint(scene, omega, attitude, t, step)
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
        run = by_midpoint(scene, omega, attitude, [1000 * step], step)
        assert run.status in ARRIVED
        # A thousand steps of up to 64 turns of ten operations, all the same way.
        assert max(run.energy_drift, run.momentum_drift, run.unit_drift) < 1e-10


@pytest.mark.parametrize("angle", [0.3, 1.0])
def test_large_steps_find_the_way_back(angle: float) -> None:
    """Rounding of 2 x 100 steps; chaos may multiply it a thousand times in so many radians."""
    for scene, omega, attitude in random_tops(30, np.random.default_rng(5)):
        step = angle / turning(scene, omega, attitude)
        there = by_midpoint(scene, omega, attitude, [100 * step], step)
        back = by_midpoint(scene, there.omega[0], present(there.attitude)[0], [-100 * step], step)
        missed = np.linalg.norm(back.omega[0] - omega) / np.linalg.norm(omega)
        assert missed < 1e-9
        assert rotation_angle(present(back.attitude)[0], attitude) < 1e-9


@pytest.mark.parametrize("product", [1.0, 1e2, 1e4, 1e6])
def test_strong_damping_never_feeds_a_body(product: float) -> None:
    """`h c/I` up to 1e6: the energy only falls, and the body turns no further than `4 omega I/c`.

    It stops after `omega I/c`; the rule, which is A-stable but not L-stable, swings about there.
    """
    omega, step = np.array(START[0]), 0.05
    scene = rigid.FreeBody(BODY_LARGE, damping=SHAPE * product / step)
    run = by_midpoint(scene, omega, None, step * np.arange(101), step)
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
    scene = rigid.HeavyTop(BODY_LARGE, mgl=3.0 * c, com=TILTED_COM, damping=c * SHAPE)
    attitude = np.array(START_LARGE[1])
    omega = np.linalg.solve(c * SHAPE, np.cross(gamma_of(attitude), scene.weight))
    truth = rigid.simulate(
        scene, omega, attitude, t=[1.0], method="etd4", step=1.0 / 20000, check=False
    )
    errors = []
    for count in (10, 20, 40, 80):
        run = by_midpoint(scene, omega, attitude, [1.0], 1.0 / count)
        assert run.status in ARRIVED
        angle = rotation_angle(present(run.attitude), present(truth.attitude))[0]
        errors.append(float(angle))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-4
