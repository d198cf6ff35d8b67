"""Bodies moved step by step: the steps of a run, and torques that change."""

import copy
import math
import pickle
import signal
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import moves
from refusals import refuses
from rigid.model.scene import Scene
from rigid.solve.methods import method_named

BODY = rigid.Body((1.0, 1.6, 2.1))
START = [0.3, 1.1, -0.4]
TILTED = [0.8, 0.36, -0.48, 0.0]
STEP = 2.0**-6
"""Sums of such steps are not rounded."""

KNOTS = [0.0, 5.25 * STEP, 9 * STEP, 1.0]
TORQUES = [[0.2, -0.5, 0.9], [1.0, 0.3, -0.7], [-0.4, 0.8, 0.1], [0.6, -0.2, 0.5]]

SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(BODY),
    "symmetric": rigid.FreeBody(rigid.Body((1.0, 1.0, 1.5))),
    "top": rigid.HeavyTop(BODY, mgl=1.5, com=(0.6, 0.0, 0.8)),
    "lagrange": rigid.HeavyTop(rigid.Body((1.0, 0.6, 1.0)), mgl=1.5, com=(0.0, 1.0, 0.0)),
    "damped": rigid.FreeBody(BODY, damping=0.3),
    "pushed": rigid.HeavyTop(
        BODY,
        mgl=1.5,
        torque=rigid.Torque.body(TORQUES, times=KNOTS) + rigid.Torque.space((0.3, -0.2, 0.1)),
        damping=(0.1, 0.2, 0.0),
    ),
}


CASES = [
    (name, method.name)
    for name, scene in SCENES.items()
    for method in rigid.methods()
    if moves(method, scene)
]


@pytest.mark.parametrize(("name", "method"), CASES)
def test_steps_have_the_bits_of_a_run(name: str, method: str) -> None:
    times = STEP * np.arange(1, 17)
    scene = SCENES[name]
    run = rigid.simulate(scene, START, TILTED, t=times, method=method, step=STEP, check=False)
    motion = rigid.Motion(scene, START, TILTED, method=method)
    assert run.attitude is not None
    for t, omega, attitude in zip(times, run.omega, run.attitude, strict=True):
        motion.step(STEP)
        assert motion.t == t
        assert motion.omega.tobytes() == omega.tobytes()
        assert motion.attitude.tobytes() == attitude.tobytes()


@pytest.mark.parametrize("method", [method.name for method in rigid.methods() if method.forces])
def test_a_torque_that_changes_at_each_step_is_a_table_with_jumps(method: str) -> None:
    knots = STEP * np.repeat(np.arange(len(TORQUES) + 1), 2)[1:-1]
    table = rigid.Torque.body(np.repeat(TORQUES, 2, axis=0), times=knots)
    scene = rigid.FreeBody(BODY, torque=table)
    times = STEP * np.arange(1, len(TORQUES) + 1)
    run = rigid.simulate(scene, START, TILTED, t=times, method=method, step=STEP, check=False)
    motion = rigid.Motion(rigid.FreeBody(BODY), START, TILTED, method=method)
    for torque, omega in zip(TORQUES, run.omega, strict=True):
        motion.step(STEP, torque=tuple(torque))
        assert motion.omega.tobytes() == omega.tobytes()


def test_one_torque_acts_on_bodies_of_different_moments() -> None:
    moments = np.array([[1.0, 2.0, 2.5], [300.0, 200.0, 250.0]])
    motion = rigid.Motion(rigid.Body(moments), [0.0, 0.0, 0.0])
    motion.step(0.5, torque=(0.0, 0.0, 6.0))
    np.testing.assert_allclose(motion.omega[:, 2], 0.5 * 6.0 / moments[:, 2], rtol=1e-15)


def losses(motion: rigid.Motion, steps: int, dt: float) -> float:
    """The largest change of energy, angular momentum and length of the quaternion in some steps.

    Relative to the energies and the momentum of the start; the momentum of a top is the vertical
    one.
    """
    moments, weight = np.array(motion.scene.body.moments), motion.scene.weight

    def invariants() -> list[Any]:
        omega, q = np.atleast_2d(motion.omega), np.atleast_2d(motion.attitude)
        w, x, y, z = q.T
        up = np.stack(
            [x * z - w * y, y * z + w * x, 0.5 * (w * w + z * z - x * x - y * y)], axis=-1
        )
        up *= 2.0 / (q * q).sum(-1, keepdims=True)
        momentum = moments * omega
        conserved = (momentum * up).sum(-1) if np.any(weight) else np.linalg.norm(momentum, axis=-1)
        energy = 0.5 * (momentum * omega).sum(-1) + (up * weight).sum(-1)
        sizes = np.linalg.norm(momentum, axis=-1), 0.5 * (momentum * omega).sum(-1)
        return [energy, conserved, np.linalg.norm(q, axis=-1), *sizes]

    begin = invariants()
    for _ in range(steps):
        motion.step(dt)
    energy, momentum, length, *_ = np.abs(np.subtract(invariants(), begin))
    energies = begin[4] + np.linalg.norm(weight)
    return float(max((energy / energies).max(), (momentum / begin[3]).max(), length.max()))


@pytest.mark.parametrize("rate", [10.0, 20.0, 30.0])
def test_the_default_steps_keep_energy_and_attitude_of_a_tumbling_plate(rate: float) -> None:
    """A minute at 60 steps a second; by rk4 a plate at 20 rad/s an axis loses 8 % of its energy.

    In a radian a method of order 8 loses the eighth power of the angle of its step.
    """
    motion = rigid.Motion(rigid.Body.box(1.0, 0.5, 0.02, mass=1.0), [rate] * 3)
    angle, longest = rate * math.sqrt(3.0) / 60.0, method_named("dop853").longest_angle
    bound = 1e-3 * (3.6 * angle) * (angle / longest) ** 8
    assert losses(motion, 3600, 1.0 / 60.0) < bound


BORNE = [
    rigid.FreeBody(rigid.Body((0.2, 0.8, 1.0))),
    rigid.FreeBody(rigid.Body((1.0, 1.01, 1.9))),
    rigid.FreeBody(rigid.Body((1.0, 1.0, 0.4))),
    rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=0.3, com=(0.6, 0.0, 0.8)),
]


@pytest.mark.parametrize("method", rigid.methods(), ids=lambda method: method.name)
def test_a_method_bears_its_longest_angle_and_not_twice_as_much(method: rigid.Method) -> None:
    """Energy, momentum and length of the quaternion to 1e-3 over 1000 rad."""
    omega = np.random.default_rng(1).standard_normal((24, 3))
    omega /= np.linalg.norm(omega, axis=1)[:, np.newaxis]

    def lost(angle: float) -> float:
        worst = 0.0
        for scene in BORNE:
            if moves(method, scene):
                motion = rigid.Motion(scene, omega, method=method.name)
                # Tops of this weight reach 1.5 rad/s.
                dt = angle / 1.5 if scene.directions else angle
                try:
                    worst = max(worst, losses(motion, int(1000.0 / angle), dt))
                except ValueError:  # The motion is lost.
                    return math.inf
        return worst

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert lost(method.longest_angle) < 1e-3
        # The implicit midpoint rule keeps them at any step; its angle is half a turn.
        assert method.name == "midpoint" or not lost(2.0 * method.longest_angle) < 1e-3


def test_a_step_too_long_for_its_method_warns_once() -> None:
    """At 10 rad/s about each axis `rk4` loses the length of the quaternion."""
    start = [10.0, 10.0, 10.0]
    motion = rigid.Motion(BODY, start, method="rk4")
    with pytest.warns(
        UserWarning, match=r"dt = 0\.02: the step turns the body by 0\.3. rad; 'rk4' "
    ) as told:
        motion.step(0.02)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion.step(0.02)
        rigid.Motion(BODY, start).step(0.02)
        # The knots of a table divide a step.
        table = rigid.Torque.body([[0.0, 0.0, 0.1]] * 9, times=np.linspace(0.0, 0.04, 9))
        divided = rigid.Motion(rigid.FreeBody(BODY, torque=table), start, method="rk4")
        divided.step(0.04)


def test_what_a_motion_began_with_stays() -> None:
    motion = rigid.Motion(SCENES["free"], START)
    for name in ("scene", "method", "t"):
        with pytest.raises(AttributeError):
            setattr(motion, name, getattr(motion, name))


@pytest.mark.parametrize("framed", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_rates_and_attitude_that_are_set_begin_a_motion_there(name: str, framed: bool) -> None:
    frame = Rotation.from_rotvec([0.2, -0.1, 0.4]).as_matrix() if framed else None
    motion = rigid.Motion(SCENES[name], START, TILTED, frame=frame)
    for _ in range(4):
        motion.step(STEP)
    here = motion.omega
    motion.omega = START[::-1]
    motion.attitude = Rotation.from_rotvec([0.1, 0.2, 0.3])
    turned = motion.attitude
    assert np.allclose(motion.omega, START[::-1], rtol=0.0, atol=1e-15)
    assert np.allclose(motion.rotation().as_rotvec(), [0.1, 0.2, 0.3], rtol=0.0, atol=1e-15)
    assert motion.t == 4 * STEP
    fresh = rigid.Motion(SCENES[name], START[::-1], turned, t0=4 * STEP, frame=frame)
    for one in (motion, fresh):
        one.step(STEP)
    # The axes of a frame are turned to principal axes and back once more.
    assert np.allclose(motion.omega, fresh.omega, rtol=0.0, atol=2e-15 if framed else 0.0)
    assert np.allclose(motion.attitude, fresh.attitude, rtol=0.0, atol=2e-15 if framed else 0.0)
    assert np.abs(here - motion.omega).max() > 0.1


@pytest.mark.parametrize("pushed", [False, True])
@pytest.mark.parametrize(("name", "method"), CASES)
def test_setting_one_body_changes_no_bit_of_the_others(
    name: str, method: str, pushed: bool
) -> None:
    forced = next(one for one in rigid.methods() if one.name == method).forces
    if pushed and "torque" not in forced:
        pytest.skip("the method does not integrate a torque")
    starts = np.array([START, START[::-1], [0.1, 0.2, 0.3]])
    motion = rigid.Motion(SCENES[name], starts, TILTED, method=method)
    for _ in range(5):
        motion.step(STEP, torque=(0.1, 0.2, -0.1) if pushed else None)
    alone = motion.copy()
    omega, attitude = motion.omega, motion.attitude
    omega[1], attitude[2] = 0.5, [1.0, 0.0, 0.0, 0.0]
    motion.omega = omega
    motion.attitude = attitude
    assert motion.omega[1].tolist() == [0.5, 0.5, 0.5]
    for one in (motion, alone):
        one.step(STEP)
    assert motion.omega[0].tobytes() == alone.omega[0].tobytes()
    assert motion.attitude[0].tobytes() == alone.attitude[0].tobytes()
    assert np.any(motion.omega[1] != alone.omega[1])
    assert np.any(motion.attitude[2] != alone.attitude[2])


@pytest.mark.parametrize(
    ("method", "forces"),
    [("splitting4", {}), ("dop853", {}), ("dop853", {"orbit": rigid.Orbit(1.0, 0.3, 0.4)})],
)
def test_bodies_that_are_set_move_as_if_made_anew(method: str, forces: dict[str, Any]) -> None:
    rng = np.random.default_rng(5)
    moments = rng.uniform(1.0, 1.5, (70, 3))
    moments[::3, 1] = moments[::3, 0]
    scene = rigid.FreeBody(rigid.Body(moments), **forces)
    motion = rigid.Motion(scene, rng.normal(size=(70, 3)), rng.normal(size=(70, 4)), method=method)
    for _ in range(3):
        motion.step(STEP)
    kept, chosen = motion.copy(), rng.random(70) < 0.5
    attitude = motion.attitude
    motion.omega = np.where(chosen[:, np.newaxis], rng.normal(size=(70, 3)), motion.omega)
    fresh = rigid.Motion(scene, motion.omega, attitude, t0=motion.t, method=method)
    for one in (motion, kept, fresh):
        one.step(STEP)
    for name in ("omega", "attitude"):
        found = getattr(motion, name)
        np.testing.assert_array_equal(found[chosen], getattr(fresh, name)[chosen])
        np.testing.assert_array_equal(found[~chosen], getattr(kept, name)[~chosen])


def set_states(motion: rigid.Motion, **states: Any) -> None:
    for name, value in states.items():
        setattr(motion, name, value)


test_states_that_cannot_be_set = refuses(
    [
        ({"omega": [0.0, 1.0]}, "omega: expected shape (..., 3), got (2,)"),
        ({"omega": np.zeros((2, 3))}, "omega: expected bodies of shape (), got (2,)"),
        ({"attitude": np.ones((2, 4))}, "attitude: expected bodies of shape (), got (2,)"),
        ({"omega": [0.0, math.nan, 0.0]}, "omega[1] = nan: must be finite"),
        ({"attitude": [0.0] * 4}, "attitude = [0.0, 0.0, 0.0, 0.0]: a zero quaternion"),
    ],
    literal=True,
    by=lambda states: set_states(rigid.Motion(BODY, START), **states),
)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a timer of Unix")
def test_a_step_over_many_knots_can_be_interrupted_and_changes_nothing() -> None:
    """A step over 60 000 knots takes a third of a second, and kept the interpreter to its end."""
    times = np.linspace(0.0, 1.0, 60_001)
    table = rigid.Torque.body(np.ones((len(times), 3)), times=times)
    scene = rigid.FreeBody(BODY, torque=table)
    motion = rigid.Motion(scene, START, TILTED, method="taylor26")
    motion.step(0.25)
    before = motion.t, motion.omega.tobytes(), motion.attitude.tobytes()

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    known = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(KeyboardInterrupt):
            motion.step(0.75)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, known)
    assert (motion.t, motion.omega.tobytes(), motion.attitude.tobytes()) == before
    whole = rigid.Motion(scene, START, TILTED, method="taylor26")
    for one in (motion, whole):
        one.step(0.5 if one is motion else 0.75)
    assert np.abs(motion.omega - whole.omega).max() < 1e-12


def test_a_step_back_undoes_a_step() -> None:
    motion = rigid.Motion(SCENES["top"], START, TILTED, method="splitting4")
    motion.step(0.1)
    motion.step(-0.1)
    assert motion.t == 0.0
    assert np.abs(motion.omega - START).max() < 1e-15
    assert np.abs(motion.attitude - TILTED).max() < 1e-15


def test_a_step_of_zero_changes_nothing() -> None:
    motion = rigid.Motion(SCENES["top"], START, TILTED)
    before = motion.omega, motion.attitude
    motion.step(0.0)
    assert motion.t == 0.0
    assert all((a == b).all() for a, b in zip(before, (motion.omega, motion.attitude), strict=True))


@pytest.mark.parametrize("torque", [[], np.empty((0, 3))])
def test_there_may_be_no_bodies(torque: Any) -> None:
    motion = rigid.Motion(SCENES["free"], np.empty((0, 3)))
    motion.step(0.5, torque=torque)
    assert (motion.omega.shape, motion.attitude.shape, motion.t) == ((0, 3), (0, 4), 0.5)


def stepped(
    name: str = "free", dt: Any = STEP, torque: Any = None, **options: Any
) -> Callable[[], Any]:
    omega = np.tile(START, (3, 1))
    return lambda: rigid.Motion(SCENES[name], omega, **options).step(dt, torque)


test_refused = refuses(
    [
        (stepped(dt="1"), TypeError, "dt = '1': must be a real number"),
        (stepped(dt=True), TypeError, "dt = True: must be a real number"),
        (stepped(dt=math.nan), "dt = NaN: must be finite"),
        (stepped(torque=(1.0, "a", 2.0)), TypeError, "torque = (1.0, 'a', 2.0): must be real num"),
        (stepped(torque=(1.0, math.inf, 2.0)), "torque = inf: must be finite"),
        (stepped(torque=np.ones((2, 3))), "torque: expected shape (3,) or (3, 3), got (2, 3)"),
        (stepped(torque=[1.0, 2.0]), "torque: expected shape (3,) or (n, 3), got (2,)"),
        (stepped(torque=[[], []]), "torque: expected shape (3,) or (n, 3), got (2, 0)"),
        (stepped(torque=(1.0, 2.0)), "torque: expected shape (3,) or (n, 3), got (2,)"),
        (stepped(torque=[]), "torque: expected shape (3,) or (3, 3), got (0, 3)"),
        (stepped(torque=()), "torque: expected shape (3,) or (3, 3), got (0, 3)"),
        (
            lambda: rigid.Motion(SCENES["free"], START).step(STEP, []),
            "torque: expected shape (3,) or (1, 3), got (0, 3)",
        ),
        (
            stepped(torque=TORQUES[0], method="chin4a"),
            "method = 'chin4a': moves bodies without torque and damping only",
        ),
        (stepped(method="exact"), "method = 'exact': must be one of 'rk4'"),
        (
            stepped("damped", method="chin4a"),
            "method = 'chin4a': does not integrate damping; use one of",
        ),
        (stepped("damped", dt=40.0), "step = 4e1: 'dop853' is unstable under damping"),
        (
            stepped("pushed", dt=-STEP),
            "t = -0.015625: the table of the torque does not reach this time",
        ),
        (lambda: rigid.Motion(None, START), TypeError, "scene = None: must be a rigid.FreeBody"),  # type: ignore[arg-type]
        (
            lambda: rigid.Motion(rigid.Body([[(1.0, 1.6, 2.1)] * 2]), START),
            ["scene: expected one body or n in a row, got ", "(1, 2)"],
        ),
    ],
    literal=True,
)


def test_a_refused_step_leaves_the_motion_as_it_was() -> None:
    motion = rigid.Motion(SCENES["free"], START, TILTED)
    motion.step(STEP)
    before = motion.t, motion.omega.tobytes(), motion.attitude.tobytes()
    for dt, torque in [(math.inf, None), (1e308 * 1e308, None), (STEP, (math.nan, 0.0, 0.0))]:
        with pytest.raises(ValueError, match="must be finite"):
            motion.step(dt, torque)
    assert before == (motion.t, motion.omega.tobytes(), motion.attitude.tobytes())


def copies(motion: rigid.Motion) -> list[rigid.Motion]:
    found: list[rigid.Motion] = [motion.copy(), copy.copy(motion), copy.deepcopy(motion)]
    return [*found, pickle.loads(pickle.dumps(motion))]


@pytest.mark.parametrize(("name", "method"), CASES)
def test_a_copy_goes_on_with_the_same_bits_and_leaves_the_motion(name: str, method: str) -> None:
    motion = rigid.Motion(SCENES[name], [START, START[::-1]], TILTED, method=method)
    for steps in (0, 5):
        for _ in range(steps):
            motion.step(STEP)
        before, after = (motion.omega, motion.attitude), motion.copy()
        after.step(STEP)
        for other in copies(motion):
            np.testing.assert_array_equal(other.omega, motion.omega)
            np.testing.assert_array_equal(other.attitude, motion.attitude)
            other.step(STEP)
            assert other.t == after.t == motion.t + STEP
            assert other.omega.tobytes() == after.omega.tobytes()
            assert other.attitude.tobytes() == after.attitude.tobytes()
        assert motion.omega.tobytes() == before[0].tobytes()
        assert motion.attitude.tobytes() == before[1].tobytes()


def test_a_copy_knows_that_a_torque_has_acted() -> None:
    frame = rigid.Body.from_tensor([[2.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 1.0]])[1]
    motion = rigid.Motion(BODY, START, TILTED, frame=frame)
    motion.step(STEP, torque=(0.1, -0.2, 0.3))
    motion.step(STEP)
    for other in copies(motion):
        assert other.omega.tobytes() == motion.omega.tobytes()
        assert other.attitude.tobytes() == motion.attitude.tobytes()
        other.step(STEP)
        again = motion.copy()
        again.step(STEP)
        assert other.omega.tobytes() == again.omega.tobytes()


def test_a_motion_begins_at_its_time() -> None:
    # The torque of the table and the orbit are those of the times, whenever the motion begins.
    table = rigid.Torque.body([[0.2, -0.5, 0.9], [1.0, 0.3, -0.7]], times=[0.0, 1.0])
    around = rigid.Orbit(2.0, 0.3)
    for acting in ({"torque": table}, {"orbit": around}):
        scene = rigid.FreeBody(BODY, **acting)
        whole = rigid.Motion(scene, START, TILTED, method="dop853")
        for _ in range(16):
            whole.step(STEP)
        rest = rigid.Motion(scene, whole.omega, whole.attitude, method="dop853", t0=whole.t)
        assert rest.t == 16 * STEP
        for _ in range(16):
            whole.step(STEP)
            rest.step(STEP)
        # The attitude is normalised, and the rows of the matrix are made anew from it: some
        # roundings of numbers of the order of one.
        np.testing.assert_allclose(rest.omega, whole.omega, rtol=0.0, atol=16 * 2.0**-52)
        np.testing.assert_allclose(rest.attitude, whole.attitude, rtol=0.0, atol=16 * 2.0**-52)


@pytest.mark.parametrize("dt", [10.0, 1e200])
def test_steps_too_long_for_a_rotation_are_refused(dt: float) -> None:
    """A step of fifty radians: the quaternion of ``rk4`` would be thousands of units long."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    motion = rigid.Motion(top, [[0.0, 0.0, 5.0], [0.0, 0.0, 0.0]])
    with pytest.raises(ValueError, match="the attitude is no rotation any more"):
        motion.step(dt)


def test_a_motion_tells_its_time_and_method() -> None:
    motion = rigid.Motion(BODY, [START, START], method="dop853")
    motion.step(0.5)
    assert repr(motion) == "Motion(2 bodies at t = 0.5 s; dop853)"
    assert repr(rigid.Motion(BODY, START)) == "Motion(one body at t = 0 s; dop853)"
