"""Motions in body axes that are not principal axes, against Euler's equations of a full tensor."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import rigid
from refusals import refuses

TENSOR = np.array([[2.0, 0.3, -0.2], [0.3, 2.6, 0.1], [-0.2, 0.1, 3.1]])
BODY, AXES = rigid.Body.from_tensor(TENSOR)
OMEGA = np.array([0.4, -0.7, 1.1])
ATTITUDE = Rotation.from_rotvec([0.3, -0.2, 0.5])
TIMES = np.linspace(0.0, 6.0, 13)
COM = np.array([0.48, 0.6, 0.64])
TORQUE = np.array([0.1, -0.05, 0.2])
PUSH = rigid.Torque.body(TORQUE)
ROTOR = np.array([0.3, 0.8, -0.4])
MATRIX = np.array([[0.2, 0.05, 0.0], [0.05, 0.1, 0.02], [0.0, 0.02, 0.3]])


def by_full_tensor(
    mgl: float = 0.0, torque: Any = 0.0, damping: Any = 0.0, rotor: Any = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Rates and rotation matrices, all in the axes of the drawing; DOP853 of SciPy at 1e-13."""
    inverse = np.linalg.inv(TENSOR)
    damping = damping * np.eye(3) if np.ndim(damping) < 1 else damping
    weight = mgl * COM

    def rate(_t: float, y: np.ndarray) -> np.ndarray:
        omega, turn = y[:3], y[3:].reshape(3, 3)
        moment = torque - damping @ omega - np.cross(weight, turn[2])
        change = inverse @ (np.cross(TENSOR @ omega + rotor, omega) + moment)
        x, y_, z = omega
        hat = np.array([[0.0, -z, y_], [z, 0.0, -x], [-y_, x, 0.0]])
        return np.concatenate([change, (turn @ hat).ravel()])

    start = np.concatenate([OMEGA, ATTITUDE.as_matrix().ravel()])
    found = solve_ivp(rate, (0.0, TIMES[-1]), start, "DOP853", TIMES, rtol=1e-13, atol=1e-14).y.T
    return found[:, :3], found[:, 3:].reshape(-1, 3, 3)


SCENES: dict[str, tuple[rigid.FreeBody | rigid.HeavyTop, dict[str, Any]]] = {
    "free": (rigid.FreeBody(BODY), {}),
    "torque": (rigid.FreeBody(BODY, torque=PUSH, frame=AXES), {"torque": TORQUE}),
    "damping along axes": (
        rigid.FreeBody(BODY, damping=(0.1, 0.0, 0.4), frame=AXES),
        {"damping": np.diag([0.1, 0.0, 0.4])},
    ),
    "damping matrix": (rigid.FreeBody(BODY, damping=MATRIX, frame=AXES), {"damping": MATRIX}),
    "rotor": (rigid.FreeBody(BODY, rotor=ROTOR, frame=AXES), {"rotor": ROTOR}),
    "top": (rigid.HeavyTop(BODY, mgl=1.7, com=COM, frame=AXES), {"mgl": 1.7}),
    "driven top": (
        rigid.HeavyTop(BODY, mgl=1.7, com=COM, torque=PUSH, damping=0.1, frame=AXES),
        {"mgl": 1.7, "torque": TORQUE, "damping": 0.1},
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_is_that_of_the_full_tensor(name: str) -> None:
    scene, acting = SCENES[name]
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=TIMES, accuracy=1e-10, frame=AXES)
    omega, turns = by_full_tensor(**acting)
    # 1e-10 of the run, and 1e-13 a step of the reference over some hundred steps.
    assert np.allclose(run.omega, omega, rtol=0, atol=2e-10 * np.abs(omega).max())
    assert np.allclose(run.rotation().as_matrix(), turns, rtol=0, atol=3e-10)
    momentum = omega @ TENSOR + acting.get("rotor", 0.0)
    assert np.allclose(run.momentum(), momentum, rtol=0, atol=1e-9)
    in_space = np.einsum("nij,nj->ni", turns, momentum)
    assert np.allclose(run.momentum("space"), in_space, rtol=0, atol=1e-9)
    energy = 0.5 * np.einsum("ni,ij,nj->n", omega, TENSOR, omega)
    energy += acting.get("mgl", 0.0) * turns[:, 2] @ COM
    assert np.allclose(run.energy(), energy, rtol=0, atol=1e-9)
    if run.gamma is not None:
        assert np.allclose(run.gamma, turns[:, 2], rtol=0, atol=3e-10)


@pytest.mark.parametrize("name", ["free", "driven top"])
def test_a_motion_is_that_in_principal_axes_turned_by_hand(name: str) -> None:
    scene, _ = SCENES[name]
    by_hand = rigid.simulate(
        scene, AXES.T @ OMEGA, ATTITUDE * Rotation.from_matrix(AXES), t=TIMES, accuracy=1e-10
    )
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=TIMES, accuracy=1e-10, frame=AXES)
    assert np.allclose(run.omega, by_hand.omega @ AXES.T, rtol=0, atol=1e-14)
    turned = (by_hand.rotation() * Rotation.from_matrix(AXES.T)).as_matrix()
    assert np.allclose(run.rotation().as_matrix(), turned, rtol=0, atol=2e-14)
    assert by_hand.frame is None
    assert run.frame is not None
    assert np.allclose(run.frame, AXES, rtol=0, atol=1e-15)
    back = run.in_frame(None)
    assert back.frame is None
    assert np.allclose(back.omega, by_hand.omega, rtol=0, atol=1e-14)
    # The turn adds its rounding. Products with matrices round otherwise on another processor: the
    # estimates are those of two starts, and differ by some rounding of numbers of the size 1.
    assert abs(run.error - by_hand.error) < 1e-14
    for kept in ("kinetic", "energy", "L_space", "p_phi"):
        here, there = (getattr(rigid.free.invariants(some), kept) for some in (run, by_hand))
        assert np.allclose(here, there, rtol=1e-13)


@pytest.mark.parametrize("name", ["free", "rotor", "driven top"])
def test_the_momentum_and_the_power_of_a_run_are_told_in_its_frame(name: str) -> None:
    scene, acting = SCENES[name]
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=TIMES, accuracy=1e-10, frame=AXES)
    momentum = run.omega @ TENSOR + acting.get("rotor", 0.0)
    assert np.allclose(rigid.free.invariants(run).L_body, momentum, rtol=0, atol=1e-14)
    alone, with_more = (rigid.free.power_balance(run, torque=more) for more in (None, TORQUE))
    added = with_more.power - alone.power
    assert np.allclose(added, run.omega @ TORQUE, rtol=0, atol=1e-14)


def test_the_tangent_in_a_frame_is_the_difference_of_runs_in_it() -> None:
    def run(step: np.ndarray, more: float, **options: Any) -> Any:
        top = rigid.HeavyTop(BODY, mgl=1.7 + more, com=COM, frame=AXES)
        start = OMEGA + step[:3], ATTITUDE * Rotation.from_rotvec(step[3:])
        return rigid.simulate(top, *start, t=[2.0], accuracy=1e-12, frame=AXES, **options)

    found, h = run(np.zeros(6), 0.0, tangent=("mgl",)), 1e-5
    columns = np.concatenate([found.tangent[-1], found.sensitivity[-1]], axis=1)
    for column, change in zip(columns.T, h * np.eye(7), strict=True):
        ahead, behind = (run(sign * change[:6], sign * change[6]) for sign in (1.0, -1.0))
        of_rates = (ahead.omega[-1] - behind.omega[-1]) / (2.0 * h)
        between = (behind.rotation().inv() * ahead.rotation()).as_rotvec()[-1] / (2.0 * h)
        # Differences of order 2 with h = 1e-5: h² and 1e-12 / h.
        assert np.allclose(column, np.concatenate([of_rates, between]), rtol=0, atol=2e-7)


def test_many_bodies_and_tables_of_a_torque_are_turned() -> None:
    table = rigid.Torque.body([TORQUE, 2.0 * TORQUE], times=[0.0, 1.0])
    each: Any = rigid.FreeBody(BODY, torque=table, rotor=[ROTOR, 2.0 * ROTOR], frame=AXES)
    assert np.allclose(each.torque.at(1.0)[0], 2.0 * AXES.T @ TORQUE)
    assert each.rotor is not None
    assert not isinstance(each.rotor, rigid.RotorTable)
    assert np.allclose(each.rotor, np.array([ROTOR, 2.0 * ROTOR]) @ AXES)
    tops = rigid.HeavyTop(BODY, mgl=1.0, com=[COM, COM[::-1]], frame=AXES)
    assert np.allclose(tops.com, np.array([COM, COM[::-1]]) @ AXES)
    assert tops[1] == rigid.HeavyTop(BODY, mgl=1.0, com=tops.com[1])
    many = rigid.simulate(BODY, [OMEGA, -OMEGA], t=TIMES, frame=AXES, dtype=np.float32)
    one = rigid.simulate(BODY, OMEGA, t=TIMES, frame=AXES)
    assert many.omega.dtype == np.float32
    assert np.allclose(many.omega[0], one.omega, rtol=0, atol=3e-7)
    parts = rigid.simulate_chunks(BODY, [OMEGA, -OMEGA], t=TIMES, chunk=1, frame=AXES)
    assert np.allclose(next(parts).omega, one.omega, rtol=0, atol=1e-14)


def test_equal_coefficients_stay_equal_in_any_frame() -> None:
    damped = rigid.FreeBody(BODY, damping=0.3, frame=AXES)
    assert damped == rigid.FreeBody(BODY, damping=0.3)
    assert rigid.FreeBody(BODY, drag=0.1, frame=AXES).drag == (0.1, 0.1, 0.1)
    sink = rigid.EnergySink(0.1)
    assert rigid.FreeBody(BODY, dissipation=sink, frame=AXES).dissipation == sink


def test_damping_in_the_axes_of_a_drawing_is_symmetric_to_the_bit() -> None:
    axes = rigid.rotations.quaternion_to_matrix(np.array([0.8, 0.1, 0.5, -0.3]) / np.sqrt(0.99))
    one = np.array([[0.3, 0.05, -0.1], [0.05, 0.2, 0.02], [-0.1, 0.02, 0.4]])
    for given in (one, np.stack([one, 2.0 * one, one[::-1, ::-1]])):
        scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=given, frame=axes)
        found = np.array(scene.damping)
        assert (found == np.swapaxes(found, -1, -2)).all()
        np.testing.assert_allclose(axes @ found @ axes.T, given, rtol=0.0, atol=1e-15)


def test_a_run_in_a_frame_is_kept(tmp_path: Path) -> None:
    run = rigid.simulate(BODY, OMEGA, t=TIMES, frame=AXES)
    again = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert again.frame is not None
    assert run.frame is not None
    assert np.array_equal(again.frame, run.frame)
    assert np.array_equal(again.momentum(), run.momentum())


def test_pictures_show_the_principal_axes() -> None:
    run = rigid.simulate(BODY, OMEGA, t=TIMES, frame=AXES)
    drawn = rigid.figures.poinsot(run)
    principal = rigid.figures.poinsot(run.in_frame(None))
    assert np.allclose(drawn.polhode, principal.polhode, rtol=0, atol=1e-14)


@pytest.mark.parametrize("single", [True, False])
def test_steps_in_a_frame_are_those_of_the_full_tensor(single: bool) -> None:
    start = OMEGA if single else np.array([OMEGA, OMEGA])
    motion = rigid.Motion(BODY, start, ATTITUDE, method="dop853", frame=AXES)
    for _ in range(60):
        motion.step(0.1, torque=tuple(TORQUE.tolist()))
    omega, turns = by_full_tensor(torque=TORQUE)
    # dop853 with steps of 0.1 s: below 1e-11 a step, sixty of them.
    rates, last = np.atleast_2d(motion.omega), np.atleast_2d(motion.attitude)
    for k in range(len(rates)):
        assert np.allclose(rates[k], omega[-1], rtol=0, atol=1e-9)
        matrix = rigid.rotations.quaternion_to_matrix(last[k])
        assert np.allclose(matrix, turns[-1], rtol=0, atol=1e-9)


def test_events_and_states_between_are_in_the_frame() -> None:
    run = rigid.simulate(BODY, OMEGA, ATTITUDE, t=TIMES, frame=AXES)
    assert np.allclose(run.at(TIMES[3:5]).omega, run.omega[3:5], rtol=0, atol=1e-13)


def test_bodies_without_states_leave_the_others_in_the_frame() -> None:
    """A body that overflows beside one that moves, and one whose record an event has ended."""
    omega = [[0.4, -0.7, 1.1], [1e307, 1e307, 1.0]]
    run: Any = rigid.simulate(BODY, omega, t=TIMES, frame=AXES)
    alone: Any = rigid.simulate(BODY, omega[0], t=TIMES, frame=AXES)
    assert run.status.tolist() == [rigid.Status.OK, rigid.Status.NOT_FINITE]
    until = rigid.crosses("omega1", 0.5)
    ended: Any = rigid.simulate(BODY, omega[0], t=TIMES, frame=AXES, until=until)
    assert np.array_equal(run.attitude[0], alone.attitude)
    assert np.isnan(run.attitude[1, 1:]).all()
    left = ended.end >= TIMES
    assert 0 < left.sum() < len(TIMES)
    assert np.array_equal(ended.attitude[left], alone.attitude[left])
    assert np.isnan(ended.attitude[~left]).all()


def moving(**options: Any) -> Any:
    return rigid.simulate(BODY, OMEGA, t=TIMES, **options)


HUGE = [1.7e308, -1.7e308, 1.7e308]
SINK = rigid.EnergySink((0.1, 0.2, 0.3))

test_what_is_no_frame_is_refused = refuses(
    [
        (lambda: moving(frame=[1.0, 0.0, 0.0]), r"frame: expected shape \(3, 3\).*got \(3,\)"),
        (lambda: rigid.FreeBody(BODY, frame=np.diag([1.0, 1.0, -1.0])), "frame"),
        (
            lambda: rigid.FreeBody(BODY, frame=AXES),
            "turns the forces of a scene, and there are none",
        ),
        (lambda: moving().in_frame(2.0 * np.eye(3)), "frame"),
        (lambda: moving(frame=AXES, out={}), "frame, out: exclude each other"),
        (lambda: rigid.Motion(BODY, OMEGA, frame=np.zeros((3, 3))), "frame"),
        (
            lambda: rigid.FreeBody(BODY, drag=(0.1, 0.2, 0.3), frame=AXES),
            r"drag = .*with a frame give one number",
        ),
        (
            lambda: rigid.FreeBody(BODY, dissipation=SINK, frame=AXES),
            r"dissipation = .*with a frame give one number",
        ),
        (
            lambda: rigid.simulate(BODY, HUGE, t=TIMES, frame=AXES),
            "omega: must be finite along the principal axes",
        ),
    ]
)
