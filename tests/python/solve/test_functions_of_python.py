"""The torque of a function of Python: called as it is, or compiled by numba."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.model import compiling

METHODS = [method.name for method in rigid.methods() if "function" in method.forces]
BODY = rigid.Body((1.0, 1.5, 2.0))
OMEGA = np.array([0.3, 2.0, 1.0])
TILTED = rigid.rotations.euler_to_quaternion([0.3, 0.5, 0.2])
COEFFICIENTS = (0.1, 0.2, 0.3)
DOUBLES = ctypes.POINTER(ctypes.c_double)
SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)


def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[k] * omega[k]


def in_space(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque (0.1, 0.2, 0.1 + 0.05 t) in space, in body components; without data."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    a, b, c = 0.1, 0.2, 0.1 + 0.05 * t
    torque[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    torque[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    torque[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c


def top(**acting: Any) -> rigid.HeavyTop:
    return rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), **acting)


@pytest.fixture
def no_numba(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if numba were not installed."""
    monkeypatch.setitem(sys.modules, "numba", None)
    compiling._made.cache_clear()
    yield
    compiling._made.cache_clear()


@pytest.fixture(params=["called", "compiled"])
def way(request: pytest.FixtureRequest) -> str:
    """With and without numba, if it is installed."""
    if request.param == "called":
        request.getfixturevalue("no_numba")
    else:
        pytest.importorskip("numba")
    return str(request.param)


@pytest.mark.parametrize("method", METHODS)
def test_a_function_of_python_is_its_twin_of_ctypes(way: str, method: str) -> None:
    one = rigid.Torque.call(damping, COEFFICIENTS)
    pair = [one, rigid.Torque.call(SIGNATURE(damping), COEFFICIENTS)]
    assert one.function is not None
    assert one.function.of_eight == (way == "compiled")
    runs: list[Any] = [
        rigid.simulate(top(torque=torque), OMEGA, TILTED, t=[-0.5, 3.0], method=method, step=0.02)
        for torque in pair
    ]
    # The same products: numba contracts none.
    assert runs[0].omega.tobytes() == runs[1].omega.tobytes()
    assert runs[0].work.tobytes() == runs[1].work.tobytes()


def test_a_function_without_data_is_told_time_and_attitude(way: str) -> None:
    table = rigid.Torque.space([(0.1, 0.2, 0.1), (0.1, 0.2, 0.25)], times=[0.0, 3.0])
    truth = rigid.simulate(top(torque=table), OMEGA, TILTED, t=[1.0, 3.0], accuracy=1e-13)
    scene = top(torque=rigid.Torque.call(in_space))
    run = rigid.simulate(scene, OMEGA, TILTED, t=[1.0, 3.0], accuracy=1e-11)
    assert np.abs(run.omega - truth.omega).max() < 1e-11 * np.linalg.norm(OMEGA) * 3.0
    assert float(run.error) < 1e-11


@pytest.mark.parametrize("method", METHODS)
def test_only_bodies_that_move_are_called(method: str) -> None:
    # As many calls of all bodies together as of each alone: none of a body that is not there.
    told: list[tuple[float, float]] = []

    @SIGNATURE  # type: ignore[untyped-decorator]
    def counted(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        told.append((data[0], t))
        torque[0] = torque[1] = torque[2] = -data[0]

    data = np.array([[0.1], [0.2], [0.3]])
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(counted, data, fastest=1.0))
    omega = OMEGA * np.array([[3.0], [12.0], [30.0]])  # 60 and more steps, which follow from rates
    asked: dict[str, Any] = {"t": [0.0, 1.0], "method": method, "check": False}
    steps = rigid.simulate(scene, omega, **asked).steps
    assert len(set(steps)) == 3
    together = sorted(told)
    told.clear()
    for k in range(3):
        rigid.simulate(scene[k], omega[k], **asked)
    assert sorted(told) == together


def test_steps_by_a_tolerance_and_events_under_a_function_of_python(way: str) -> None:
    twin = rigid.simulate(top(damping=COEFFICIENTS), OMEGA, TILTED, t=[3.0], accuracy=1e-13)
    scene = top(torque=rigid.Torque.call(damping, np.tile(COEFFICIENTS, (3, 1))))
    run = rigid.simulate(
        scene, OMEGA, TILTED, t=[3.0], tolerance=1e-10, events=rigid.crosses("omega1")
    )
    off = np.linalg.norm(run.omega - twin.omega, axis=-1).max() / np.linalg.norm(OMEGA)
    assert off <= run.error.max() < 1e-8
    assert all(len(run.events[0].of(body).t) > 0 for body in range(3))


def test_a_motion_calls_a_function_of_python(way: str) -> None:
    scene = top(torque=rigid.Torque.call(in_space))
    motion = rigid.Motion(scene, OMEGA, TILTED)
    for _ in range(10):
        motion.step(0.1)
    run = rigid.simulate(scene, OMEGA, TILTED, t=[1.0], method="dop853", step=0.1)
    assert np.abs(motion.omega - run.omega[-1]).max() < 1e-13


def test_the_plan_says_that_python_calls_and_what_would_compile(no_numba: None) -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, COEFFICIENTS, fastest=3.0))
    words = "Python calls the torque, some 5 µs for each body and stage: to compile it needs numba"
    told = rigid.plan(scene, omega=OMEGA, t_end=1.0)
    of_map = rigid.plan(scene, rigid.spin_above(0.1), omega=OMEGA, t_end=1.0)
    for plan in (told, of_map):
        assert any(why.startswith(words) and "pip install" in why for why in plan.why)


def test_a_compiled_function_is_not_called_slow() -> None:
    pytest.importorskip("numba")
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, COEFFICIENTS, fastest=3.0))
    assert not any("Python calls" in why for why in rigid.plan(scene, omega=OMEGA, t_end=1.0).why)


def test_a_jitted_function_is_compiled_once() -> None:
    numba: Any = pytest.importorskip("numba")
    jitted = numba.njit(damping)
    pair = [rigid.Torque.call(jitted, row) for row in (COEFFICIENTS, (0.0, 0.0, 0.1))]
    assert pair[0].function is not None
    assert pair[1].function is not None
    assert pair[0].function.of_eight
    assert pair[0].function.address == pair[1].function.address
    assert rigid.Torque.call(jitted, COEFFICIENTS) == pair[0]


def test_what_numba_cannot_compile_is_called_and_said() -> None:
    pytest.importorskip("numba")
    known = {"gain": 0.1}

    def by_dictionary(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        torque[:] = -known["gain"] * np.asarray(list(map(float, omega)))

    with pytest.warns(UserWarning, match="numba cannot compile it: .") as warned:
        torque = rigid.Torque.call(by_dictionary)
    assert warned[0].filename == __file__
    scene = rigid.FreeBody(BODY, torque=torque)
    run = rigid.simulate(scene, OMEGA, t=[1.0], method="dop853", step=0.1)
    twin = rigid.simulate(rigid.FreeBody(BODY, damping=0.1), OMEGA, t=[1.0], accuracy=1e-12)
    assert np.abs(run.omega - twin.omega).max() < 1e-9
    assert any("numba cannot compile it" in why for why in run.plan.why)


def raises(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    torque[0] = torque[1] = torque[2] = 0.0
    if t > 0.5:
        raise ArithmeticError("too late")


def test_what_a_function_of_python_raises_is_raised_by_the_call(way: str) -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(raises))
    calls: list[Callable[[], object]] = [
        lambda: rigid.simulate(scene, OMEGA, t=[1.0]),
        lambda: rigid.simulate(scene, [OMEGA] * 40, t=[1.0], method="rk4", step=0.1, threads=2),
    ]
    for call in calls:
        with pytest.raises(ArithmeticError, match="too late") as raised:
            call()
        if way == "called":
            assert raised.traceback[-1].name == "raises"


def test_a_map_under_a_function_of_python_is_that_of_its_twin(way: str) -> None:
    def by_function(gain: Any) -> rigid.FreeBody:
        torque = rigid.Torque.call(damping, gain[:, np.newaxis] * np.ones(3), fastest=2.5)
        return rigid.FreeBody(BODY, torque=torque)

    def by_damping(gain: Any) -> rigid.FreeBody:
        return rigid.FreeBody(BODY, damping=gain[:, np.newaxis] * np.ones(3))

    maps = [
        rigid.stability_map(
            scene,
            axes={"gain": [0.05, 0.1], "spin": [0.5, 1.5]},
            start=rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.1)),
            stable=~rigid.spin_above(0.2),
            t_end=30.0,
            samples=8,
            rng=3,
            progress=False,
        )
        for scene in (by_function, by_damping)
    ]
    assert np.array_equal(maps[0].stable, maps[1].stable)
    assert 0 < maps[0].stable.sum() < maps[0].stable.size * 8


@pytest.mark.parametrize("wrong", [lambda t, omega: None, len])
def test_a_function_of_other_arguments_is_refused(wrong: Any) -> None:
    words = r"must take \(t, omega, attitude, data, torque\), or be the address of a compiled"
    with pytest.raises(TypeError, match=words):
        rigid.Torque.call(wrong)
