"""The torque of a function: against its built-in twin, its data, and what is refused."""

from __future__ import annotations

import ctypes
import signal
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rigid
from interrupts import sigint

METHODS = [method.name for method in rigid.methods() if "function" in method.forces]
BODY = rigid.Body((1.0, 1.5, 2.0))
OMEGA = np.array([0.3, 2.0, 1.0])
TILTED = rigid.rotations.euler_to_quaternion([0.3, 0.5, 0.2])
DOUBLES = ctypes.POINTER(ctypes.c_double)
SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)


def states(*given: Any, **asked: Any) -> Any:
    """A run whose arrays are all there."""
    return rigid.simulate(*given, **asked)


def top(**acting: Any) -> rigid.HeavyTop:
    return rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), **acting)


@SIGNATURE  # type: ignore[untyped-decorator]
def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[k] * omega[k]


@SIGNATURE  # type: ignore[untyped-decorator]
def ramp_in_space(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque (0.1, 0.2, 0.1 + 0.05 t) in space, in body components."""
    w, x, y, z = attitude[:4]
    a, b, c = 0.1, 0.2, 0.1 + 0.05 * t
    # The transposed matrix of the quaternion.
    torque[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    torque[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    torque[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c


@SIGNATURE  # type: ignore[untyped-decorator]
def nothing(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """Writes no torque."""


@pytest.mark.parametrize("method", METHODS)
def test_damping_by_a_function_is_damping(method: str) -> None:
    # The steps are the same. The derivative of the midpoint rule is that of differences, whose
    # errors Newton's method leaves below 1e-13.
    coefficients = (0.1, 0.2, 0.3)
    called = top(torque=rigid.Torque.call(damping, coefficients))
    mine = states(called, OMEGA, TILTED, t=[-0.5, 3.0], method=method, step=0.02)
    known = top(damping=coefficients)
    twin = states(known, OMEGA, TILTED, t=[-0.5, 3.0], method=method, step=0.02)
    assert np.abs(mine.omega - twin.omega).max() < 1e-12
    # Both signs of a quaternion are the same attitude.
    sign = np.sign((mine.attitude * twin.attitude).sum(axis=-1, keepdims=True))
    assert np.abs(mine.attitude - sign * twin.attitude).max() < 1e-12
    assert np.abs(mine.work - twin.work).max() < 1e-11
    assert mine.energy_drift < 1e-6


FURTHER: dict[str, dict[str, Any]] = {
    "orbit": {"orbit": rigid.Orbit(0.3, 0.2)},
    "rotor": {"rotor": (0.1, 0.2, 0.3)},
    "drag": {"drag": 0.05},
    "energy sink": {"dissipation": rigid.EnergySink(0.01)},
}
FURTHER["all"] = {name: force for one in FURTHER.values() for name, force in one.items()}


@pytest.mark.parametrize("steps", [{"method": "rk4", "step": 0.02}, {"accuracy": 1e-9}], ids=str)
@pytest.mark.parametrize("acting", FURTHER.values(), ids=FURTHER)
def test_a_function_acts_beside_each_force(acting: Any, steps: Any) -> None:
    # The twin is damped by its matrix, and a Taylor series integrates the twin.
    coefficients, times = (0.02, 0.03, 0.05), [-2.0, 5.0, 20.0]
    torque = rigid.Torque.call(damping, coefficients, fastest=3.0)
    called = rigid.FreeBody(BODY, torque=torque, **acting)
    twin = rigid.FreeBody(BODY, damping=coefficients, **acting)
    truth = states(twin, OMEGA, TILTED, t=times, method="taylor20", tolerance=1e-14)
    run = states(called, OMEGA, TILTED, t=times, **steps)
    assert not np.any(run.flagged)
    allowed = (
        float(np.max(run.error) + np.max(truth.error)) * np.linalg.norm(truth.omega, axis=-1).max()
    )
    assert np.abs(run.omega - truth.omega).max() <= allowed < 1e-6
    assert np.abs(run.work - truth.work).max() <= 10.0 * allowed
    assert run.energy_drift < 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_a_function_is_told_time_and_attitude_in_the_order_of_the_method(method: str) -> None:
    # A ramp in space; its table has knots at which steps end, as the output times do.
    table = rigid.Torque.space([(0.1, 0.2, 0.1), (0.1, 0.2, 0.25)], times=[0.0, 3.0])
    truth = states(top(torque=table), OMEGA, TILTED, t=[3.0], method="taylor20")
    scene = top(torque=rigid.Torque.call(ramp_in_space))
    order = next(one.order for one in rigid.methods() if one.name == method)
    steps = {2: 0.02, 4: 0.05, 8: 0.3}[order]
    errors = []
    for step in (steps, steps / 2.0):
        run = states(scene, OMEGA, TILTED, t=[3.0], method=method, step=step, check=False)
        errors.append(np.abs(run.omega - truth.omega).max())
    # Half the step divides the error by 2^order, up to terms of the next order.
    assert errors[0] / errors[1] > 0.6 * 2.0**order
    assert errors[1] < 1e-4


def test_each_body_has_data_of_its_own() -> None:
    data = np.array([[0.1, 0.1, 0.1], [0.0, 0.0, 0.3], [0.2, 0.0, 0.0]])
    many = top(torque=rigid.Torque.call(damping, data, fastest=5.0))
    assert len(many) == 3
    assert many[1].torque == rigid.Torque.call(damping, data[1], fastest=5.0)
    run = states(many, OMEGA, t=[1.0, 2.0], accuracy=1e-10, threads=2)
    assert np.all(run.error < 1e-10)
    for k, row in enumerate(data):
        one = states(many[k], OMEGA, t=[1.0, 2.0], method=run.plan.method, step=0.05)
        twin = states(top(damping=row), OMEGA, t=[1.0, 2.0], accuracy=1e-12)
        assert np.abs(run.omega[k] - twin.omega).max() < 1e-9
        assert np.abs(one.omega - twin.omega).max() < 1e-9


def test_a_motion_calls_the_function_at_its_time() -> None:
    scene = top(torque=rigid.Torque.call(ramp_in_space))
    motion = rigid.Motion(scene, OMEGA, TILTED, method="dop853")
    for _ in range(30):
        motion.step(0.1)
    run = states(scene, OMEGA, TILTED, t=[3.0], method="dop853", step=0.1)
    assert np.abs(motion.omega - run.omega[-1]).max() < 1e-13


def test_a_function_adds_to_other_torques() -> None:
    both = rigid.Torque.call(damping, [0.1] * 3) + rigid.Torque.body((0.0, 0.0, 0.2))
    assert both.words() == "torque by a function, torque (0, 0, 0.2) in the body"
    known = rigid.FreeBody(BODY, torque=rigid.Torque.body((0.0, 0.0, 0.2)), damping=0.1)
    runs = [
        states(scene, OMEGA, t=[2.0], method="dop853", step=0.05)
        for scene in (rigid.FreeBody(BODY, torque=both), known)
    ]
    assert np.abs(runs[0].omega - runs[1].omega).max() < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_a_torque_that_is_not_written_ends_the_body(method: str) -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(nothing))
    run = states(scene, OMEGA, t=[0.0, 1.0], method=method, step=0.1)
    assert run.status == rigid.Status.NOT_FINITE
    assert np.isnan(run.omega[1]).any()


def test_a_compiled_function_of_numba() -> None:
    numba: Any = pytest.importorskip("numba")
    c_type = numba.types.CPointer(numba.float64)

    @numba.cfunc(numba.void(numba.float64, c_type, c_type, c_type, c_type))  # type: ignore[untyped-decorator]
    def compiled(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        for k in range(3):
            torque[k] = -data[k] * omega[k]

    for given in (compiled, compiled.address):
        scene = top(torque=rigid.Torque.call(given, (0.1, 0.2, 0.3)))
        run = states(scene, OMEGA, t=[3.0], method="dop853", step=0.02, threads=2)
        twin = states(top(damping=(0.1, 0.2, 0.3)), OMEGA, t=[3.0], method="dop853")
        assert np.abs(run.omega - twin.omega).max() < 1e-11


def test_a_function_of_cffi() -> None:
    cffi: Any = pytest.importorskip("cffi")
    c_type = "void(double, double *, double *, double *, double *)"

    @cffi.FFI().callback(c_type)  # type: ignore[untyped-decorator]
    def called(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        for k in range(3):
            torque[k] = -data[k] * omega[k]

    runs = [
        states(
            top(torque=rigid.Torque.call(one, (0.1, 0.2, 0.3))),
            OMEGA,
            t=[2.0],
            method="rk4",
            step=0.1,
        )
        for one in (called, damping)
    ]
    assert runs[0].omega.tobytes() == runs[1].omega.tobytes()


@pytest.mark.parametrize(
    ("address", "error", "words"),
    [
        (0, ValueError, "address = 0: must be the address of a function"),
        (-4, ValueError, "address = -4: must be the address"),
        (1.5, TypeError, "address = 1.5: must be a function or the address of one, an int"),
        (True, TypeError, "address = True: must be a function or the address"),
        (
            ctypes.CFUNCTYPE(None, ctypes.c_double)(lambda t: None),
            TypeError,
            r"must take \(double, double \*.* it takes \(double\) and returns None",
        ),
        (
            ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, *4 * [DOUBLES])(lambda *given: 0.0),
            TypeError,
            "and return nothing; it takes .* and returns c_double",
        ),
        (
            # As numba's functions tell it.
            SimpleNamespace(address=8, _sig=SimpleNamespace(args=("int64",), return_type="none")),
            TypeError,
            r"it takes \(int64\) and returns none",
        ),
    ],
)
def test_what_is_no_address_is_refused(address: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        rigid.Torque.call(address)


@SIGNATURE  # type: ignore[untyped-decorator]
def with_a_gap(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    torque[0] = torque[1] = 0.0
    torque[2] = {"known": 0.1}["known" if t < 0.5 else "unknown"]


def test_what_a_function_raises_is_raised_by_the_call() -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(with_a_gap))
    motion = rigid.Motion(scene, OMEGA)

    def fails(states: Any) -> Any:
        raise AssertionError("no states are reached")

    def steps_of(motion: rigid.Motion) -> None:
        for _ in range(3):
            motion.step(0.3)

    calls: list[Callable[[], object]] = [
        lambda: rigid.simulate(scene, OMEGA, t=[1.0]),
        lambda: rigid.simulate(scene, [OMEGA] * 40, t=[1.0], method="rk4", step=0.1, threads=2),
        lambda: rigid.simulate(scene, OMEGA, t=[1.0], events=rigid.crosses("omega1")),
        lambda: steps_of(motion),
        lambda: rigid.stability_map(
            lambda gain: scene, axes={"gain": [1.0]}, stable=rigid.judged(fails, t=[1.0]), samples=1
        ),
    ]
    before = sys.unraisablehook
    for call in calls:
        with pytest.raises(KeyError, match="unknown") as raised:
            call()
        # The function and its line end the traceback.
        assert raised.traceback[-1].name == "with_a_gap"
        assert sys.unraisablehook is before


def test_runs_of_two_threads_raise_what_their_own_functions_raise() -> None:
    scenes = [
        rigid.FreeBody(BODY, torque=rigid.Torque.call(torque, [0.1] * 3))
        for torque in (with_a_gap, damping)
    ]

    def outcome(number: int) -> str:
        try:
            rigid.simulate(scenes[number % 2], OMEGA, t=[1.0], threads=2)
        except KeyError:
            return "raised"
        return "ended"

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(outcome, range(20))) == ["raised", "ended"] * 10


def test_a_sliding_torque_reaches_the_limit_and_names_a_dead_zone() -> None:
    @SIGNATURE  # type: ignore[untyped-decorator]
    def switches(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        torque[0] = torque[1] = 0.0
        torque[2] = -np.sign(omega[2]) if abs(omega[2]) > data[0] else -omega[2] / data[0]

    def run(zone: float, most: int) -> Any:
        scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(switches, [zone]))
        return rigid.simulate(scene, [0.0, 0.0, 1.0], t=[1.0, 3.0], max_steps=most)

    sliding = run(5e-324, 2000)
    assert sliding.status == rigid.Status.STEP_LIMIT
    assert "needs a dead zone" in sliding.reasons()[0]
    settled = run(1e-3, 2000)
    # At 1 s it has half of its rate; then it reaches the zone, and rests.
    assert abs(settled.omega[0, 2] - 0.5) <= float(settled.error)
    assert settled.status == rigid.Status.OK
    assert abs(settled.omega[1, 2]) < 1e-3


def test_ctrl_c_within_a_function_of_python_ends_the_run() -> None:
    # ctypes ignores what a callback raises: the handler of the signal must not run in it.
    calls = 0

    @SIGNATURE  # type: ignore[untyped-decorator]
    def interrupted(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == 100:
            signal.raise_signal(signal.SIGINT)
        torque[0] = torque[1] = torque[2] = 0.0

    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(interrupted))
    with sigint(signal.default_int_handler), pytest.raises(KeyboardInterrupt):
        rigid.simulate(scene, OMEGA, t=[1.0], method="rk4", step=1e-6, check=False)
    assert calls < 4 * 10**6


def test_what_a_function_does_not_go_with_is_refused() -> None:
    torque = rigid.Torque.call(damping, [0.1] * 3)
    scene = top(torque=torque)
    run = states(scene, OMEGA, t=[0.0, 0.5, 1.0], method="rk4", step=0.1)
    turned = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    one: dict[str, Any] = {"t": [1.0], "step": 0.1}
    for words, refused in (
        ("step: is needed", lambda: rigid.simulate(scene, OMEGA, t=[1.0], method="rk4")),
        (
            "'taylor16': does not integrate the torque of a function",
            lambda: rigid.simulate(scene, OMEGA, method="taylor16", **one),
        ),
        ("a run under a function keeps no function", lambda: run.at([0.5])),
        ("frame: a function", lambda: rigid.FreeBody(BODY, torque=torque, frame=turned)),
        ("both are functions", lambda: torque + torque),
        ("fastest = -1", lambda: rigid.Torque.call(damping, fastest=-1.0)),
        ("data: expected shape", lambda: rigid.Torque.call(damping, 1.0)),
        ("data", lambda: rigid.Torque.call(damping, [np.nan])),
        (
            "torque: the torque of a function is not known",
            lambda: rigid.free.power_balance(run),
        ),
        (
            "'midpoint': does not integrate drag; use one of 'rk4', 'dop853'",
            lambda: rigid.simulate(
                rigid.FreeBody(BODY, torque=torque, drag=0.1), OMEGA, method="midpoint", **one
            ),
        ),
    ):
        with pytest.raises(ValueError, match=words):
            refused()


def test_a_saved_run_has_its_states_but_no_function(tmp_path: Path) -> None:
    scene = top(torque=rigid.Torque.call(damping, [0.1] * 3, fastest=5.0))
    run = states(scene, OMEGA, t=[0.0, 1.0], method="rk4")
    read = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert np.array_equal(read.energy(), run.energy())
    with pytest.raises(ValueError, match="a run under a function keeps no function"):
        read.at([0.5])
