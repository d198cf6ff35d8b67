"""What a run says of its error is true under drag, rotors, sinks, orbits, tables and functions.

The truth is in 128 bits; ``tests/long/stated_errors.py --kinds`` takes thousands of each force.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import quad_motion
import rigid
from adversarial import KINDS
from physics import Floats, present
from rigid.model.scene import Scene
from verdicts import judge


@pytest.fixture(scope="module", autouse=True)
def _quad_numbers() -> None:
    if not quad_motion.is_available():
        pytest.skip("the C compiler has no 128-bit numbers")


def true_error(scene: Scene, run: rigid.Run, omega: Any, attitude: Any) -> float:
    """Of the rates relative to the fastest of them, of vertical and attitude in rad."""
    truth = quad_motion.motion(scene, omega, attitude, run.t)
    assert truth is not None
    fastest = float(np.linalg.norm(truth.omega, axis=-1).max())
    off = [truth.rates_off(run.omega).max() / fastest]
    if run.gamma is not None:
        off.append(truth.gamma_off(run.gamma).max())
    if run.attitude is not None:
        off.append(truth.attitude_off(run.attitude).max())
    return float(max(off))


# The truth itself


def printed_equations(
    scene: Scene, omega: Floats, attitude: Floats, times: Floats
) -> tuple[Floats, Floats]:
    """Rates and rotation matrices by SciPy's Dormand-Prince, from the equations of the guides."""
    moments = np.array(scene.body.moments)
    drag = np.zeros(3) if scene.drag is None else np.array(scene.drag)
    function = None if scene.torque is None else scene.torque.function
    data = np.zeros(13) if function is None else present(function.data)
    push, varying, cubic, dipole, field = np.split(data, [3, 4, 7, 10])

    def rate(t: float, y: Floats) -> Floats:
        w, matrix = y[:3], y[3:].reshape(3, 3)
        acting = np.cross(moments * w, w) - np.cross(scene.weight, matrix[2])
        acting = acting - np.linalg.norm(w) * drag * w
        acting = acting + push * np.cos(varying * t) - cubic * w**3
        acting = acting + np.cross(dipole, matrix.T @ field)
        turning = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        return np.concatenate([acting / moments, (matrix @ turning).ravel()])

    matrix = Rotation.from_quat(attitude, scalar_first=True).as_matrix()
    start = np.concatenate([omega, matrix.ravel()])
    found = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-13, atol=1e-15)
    return found.y[:3].T, found.y[3:].T.reshape(-1, 3, 3)


BODY = rigid.Body((1.0, 1.6, 0.8))
NUMBERS = (0.3, -0.2, 0.1, 1.7, 0.1, 0.2, 0.05, 0.4, 0.1, -0.3, 0.2, 0.5, -0.1)


def _scenes() -> dict[str, Scene]:
    called = rigid.Torque.call(quad_motion.called(), NUMBERS, fastest=10.0)
    return {
        "drag": rigid.FreeBody(BODY, drag=(0.1, 0.3, 0.0)),
        "drag of a top": rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), drag=0.2),
        "pendulum": rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 1.0, 0.0), drag=0.2),
        "function": rigid.FreeBody(BODY, torque=called),
    }


@pytest.mark.parametrize("name", ["drag", "drag of a top", "pendulum", "function"])
def test_the_truth_agrees_with_a_fine_integration_of_the_printed_equations(name: str) -> None:
    scene, times = _scenes()[name], np.linspace(0.5, 8.0, 6)
    plane = name == "pendulum"
    omega = np.zeros(3) if plane else np.array([0.4, 1.0, -0.3])
    attitude = np.array([0.8, 0.6, 0.0, 0.0]) if plane else np.array([0.5, -0.3, 0.7, 0.4])
    truth = quad_motion.motion(scene, omega, attitude, times)
    assert truth is not None
    rates, matrices = printed_equations(scene, omega, attitude, times)
    # DOP853 keeps 1e-13 in each of some hundred steps.
    assert np.abs(truth.omega - rates).max() < 2e-12
    quaternions = Rotation.from_quat(truth.high[:, 3:7], scalar_first=True)
    assert np.abs(quaternions.as_matrix() - matrices).max() < 2e-12


# Drag that stops a body


ENDS = np.arange(7.5, 14.0)


@cache
def swings() -> list[tuple[rigid.HeavyTop, Floats, quad_motion.Motion]]:
    """Pendulums with drag, their attitudes at the start, and their true states at the ends."""
    made = []
    for mgl in (0.3, 2.0):
        for drag in (0.05, 0.4):
            for tilt in (0.5, 2.5):
                top = rigid.HeavyTop(BODY, mgl=mgl, com=(0.0, 1.0, 0.0), drag=drag)
                attitude = np.array([np.cos(0.5 * tilt), np.sin(0.5 * tilt), 0.0, 0.0])
                truth = quad_motion.motion(top, [0.0] * 3, attitude, ENDS)
                assert truth is not None
                made.append((top, attitude, truth))
    return made


@pytest.mark.parametrize("method", [None, "dop853", "rk4", "taylor12", "taylor16", "taylor26"])
def test_a_pendulum_with_drag_stops_at_each_end_of_its_swing(method: str | None) -> None:
    """There the speed |omega| has a corner: a series continues with the wrong sign of the drag."""
    for top, attitude, truth in swings():
        for row, end in enumerate(ENDS):
            run = rigid.simulate(top, [0.0] * 3, attitude, t=[end], method=method)
            state = quad_motion.Motion(truth.high[row : row + 1], truth.low[row : row + 1])
            true = float(state.rates_off(run.omega)[0] / np.linalg.norm(state.omega))
            true = max(true, float(state.attitude_off(present(run.attitude))[0]))
            assert true <= run.error or run.status not in (rigid.Status.OK, rigid.Status.COARSE)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_steps_by_a_tolerance_do_not_pass_a_stop_unseen(tolerance: float) -> None:
    torque = rigid.Torque.body((-0.4, 0.0, 0.0))
    scene = rigid.FreeBody(BODY, drag=0.3, torque=torque)
    for end in np.linspace(1.5, 3.0, 11):
        options: dict[str, Any] = {"method": "taylor20", "tolerance": tolerance}
        run = rigid.simulate(scene, [1.0, 0.0, 0.0], t=[end], **options)
        if run.status in (rigid.Status.OK, rigid.Status.COARSE):
            assert true_error(scene, run, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]) <= run.error


# Rounding that is alike in each step


STEADY: dict[str, tuple[Any, ...]] = {
    "almost a sphere with a sink": (
        (2.0 + 4e-15, 2.0 - 4e-15, 2.0),
        {"dissipation": rigid.EnergySink(0.0142)},
        (-0.0296, -0.0783, 0.0198),
        2834.0,
    ),
    "a spin about the axis of the least moment": (
        (0.9664545942669558, 0.10394517165269912, 0.9664545942669558),
        {"dissipation": rigid.EnergySink(0.001967613249548741)},
        (-1.6179383236877785e-08, 0.2505481514788074, 2.842437940406196e-08),
        783.0,
    ),
    "a symmetric gyrostat": (
        (0.11176810117658233, 0.11176810117658173, 0.06337886322194759),
        {"rotor": (0.007260231505677154, -0.01188827706446767, 0.004674141996392469)},
        (-0.12278561903031143, 0.20066394821834924, 0.19316122765204183),
        287.0,
    ),
}


@pytest.mark.parametrize("method", ["taylor12", "taylor16", "dop853"])
@pytest.mark.parametrize("name", STEADY)
def test_rounding_of_each_step_is_not_hidden_by_that_of_the_other_run(
    name: str, method: str
) -> None:
    moments, acting, omega, end = STEADY[name]
    scene = rigid.FreeBody(rigid.Body(moments), **acting)
    attitude = [0.3, -0.2, -0.1, 1.3]
    angle = float(np.linalg.norm(omega)) * end
    for steps in (2.5, 6.0, 40.0):
        options: dict[str, Any] = {"method": method, "step": end / (steps * angle)}
        run = rigid.simulate(scene, omega, attitude, t=[end], **options)
        true = true_error(scene, run, omega, attitude)
        assert true <= run.error


def test_a_rotor_couples_the_rates_of_a_needle_more_closely_than_it_turns() -> None:
    """A nearly steady gyrostat: what steps lose of the slow rates moves the fast one."""
    needle = rigid.Body((0.06679393079630609, 1.9356673666703905e-08, 0.06679392524967576))
    wheel = (0.00305182261214021, 0.0011773741645351088, -0.002060064474771951)
    scene = rigid.FreeBody(needle, rotor=wheel)
    omega = [0.048738172103088714, 0.00909797363102408, -0.03289960812986399]
    attitude = [-0.10700776581902097, 0.019851236045032035, 1.3163374410028454, 0.6100993268009105]
    run = rigid.simulate(scene, omega, attitude, t=np.linspace(1e-4, 1e-3, 9), method="dop853")
    true = true_error(scene, run, omega, attitude)
    assert true <= run.error < 1e-10


# Steps and tolerances


def test_a_step_that_midpoint_divides_is_not_checked_by_its_parts() -> None:
    """Newton's method fails in the last step, which is made by quarters; so was its check."""
    needle = rigid.Body((0.1009440010458357, 1.059937203326533e-05, 0.10095006617204039))
    push = (-0.004195829647693644, -0.5849202694921044, -0.5646255601779495, 3.8008343763782158)
    cubic = (8.46147326183455e-05, 7.034292679063874e-05, 8.436424598841554e-05)
    dipole = (0.6839347003543198, -0.7248895872563402, -0.08227035880910767)
    field = (-0.02855402699111395, 0.02063327430064514, 0.029700833361111584)
    numbers = [*push, *cubic, *dipole, *field]
    scene = rigid.FreeBody(needle, torque=rigid.Torque.call(quad_motion.called(), numbers))
    omega = [0.0, 0.0, 2.435174521052942]
    attitude = [1.0444769234010371, -0.5462355477141051, -0.06717731117860552, -0.41255362991169653]
    t = [7.289629827673585e-05, 0.0063409968997836215]
    run = rigid.simulate(scene, omega, attitude, t=t, method="midpoint", step=0.0067)
    assert run.status == rigid.Status.FLAGGED or true_error(scene, run, omega, attitude) < run.error


def test_short_midpoint_steps_with_a_function_keep_their_order() -> None:
    """Of each step no more than rounding remains unsolved: what remains would add up."""
    body = rigid.Body((0.8048410640769278, 0.8048410640769278, 0.1287856289190128))
    com = (0.365507345893554, 0.5439261858570715, 0.7553467312677195)
    push = (3.117170485207157e-05, 5.9583011907523526e-05, 1.4148471036108738e-05)
    cubic = (0.006042238935413087, 0.004321917198544746, 0.004836899694109336)
    dipole = (-0.7019338092594152, 0.6731868104831485, -0.23261222154068426)
    field = (-0.004592584247625178, -0.0004005385892071506, 0.015969991577588362)
    numbers = [*push, 0.01855481131667694, *cubic, *dipole, *field]
    torque = rigid.Torque.call(quad_motion.called(), numbers, fastest=10.0)
    top = rigid.HeavyTop(body, mgl=1.8228979671500962, com=com, torque=torque)
    omega, end = [0.0, 0.1052273657111239, 0.0], 0.6284786894562857
    attitude = [0.12625573285713065, 0.2804305477908753, 3.6066621535181835, 0.7931723555217911]
    off = []
    for steps in (5000, 20000):
        options: dict[str, Any] = {"method": "midpoint", "step": end / steps, "check": False}
        run = rigid.simulate(top, omega, attitude, t=[end], **options)
        off.append(true_error(top, run, omega, attitude))
    # 16 by the order, less what rounding of 20 000 steps leaves.
    assert off[0] < 2e-8
    assert off[1] < off[0] / 12.0


def test_the_work_of_strong_damping_converges_more_slowly_than_the_rates() -> None:
    moments, strength = (0.931648853337754, 0.931648853337754, 0.10856695840058495), 22507.2
    scene = rigid.FreeBody(rigid.Body(moments), damping=strength)
    omega = np.array([-0.9592172223327229, -0.04856543631989676, 0.00700584791946999])
    t = np.linspace(0.0, 1.15e-3, 6)
    for tolerance in (1e-13, 7e-14, 3e-14, 1e-14):
        options: dict[str, Any] = {"method": "taylor16", "tolerance": tolerance}
        run = rigid.simulate(scene, omega, t=t, **options)
        truth = quad_motion.motion(scene, omega, [1.0, 0.0, 0.0, 0.0], t)
        assert truth is not None
        # The rates never exceed those of the start with the energy about the least moment.
        energy = 0.5 * float(omega @ (np.array(moments) * omega))
        assert truth.work_off(present(run.work)).max() / energy <= run.error


# Random runs


FORCES = (
    "drag",
    "orbit",
    "rotor",
    "energy sink",
    "function",
    "table in body",
    "table in space",
)


@pytest.mark.parametrize("kind", FORCES)
def test_no_error_under_a_force_is_larger_than_what_is_said_of_it(kind: str) -> None:
    for number in range(30):
        found = judge(number, seed=3, kinds={kind: KINDS[kind]})
        assert found.verdict != "UNDETECTED", (found.true, found.stated, found.case.code())
        assert found.early < 1.0
        # A drift that is computed anew is rounded otherwise.
        assert found.unbalanced < 1e-15
