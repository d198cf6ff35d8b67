"""The torque of a function: against its built-in twin, its data, and what is refused."""

from __future__ import annotations

import ctypes
import math
import signal
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from interrupts import sigint
from physics import present, rotation_angle
from refusals import refuses

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


def plain_damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[k] * omega[k]


def ramp(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque (0.1, 0.2, 0.1 + 0.05 t) in space, in body components; without data."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    a, b, c = 0.1, 0.2, 0.1 + 0.05 * t
    # The transposed matrix of the quaternion.
    torque[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    torque[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    torque[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c


damping = SIGNATURE(plain_damping)
ramp_in_space = SIGNATURE(ramp)
#: The torque (0.1, 0.2, 0.3) in space.
in_space = SIGNATURE(lambda _, *given: ramp(4.0, *given))


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
    assert rotation_angle(mine.attitude, twin.attitude).max() < 1e-12
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
    coefficients, times = (0.02, 0.03, 0.05), [-1.0, 3.0, 8.0]
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


def test_a_file_has_the_data_and_the_states_of_a_function() -> None:
    with_states = ctypes.CFUNCTYPE(None, ctypes.c_double, *[DOUBLES] * 7)
    for data, count in ((None, 0), ([1.0, 2.0], 0), ([[1.0], [3.0]], 2)):
        called = (with_states if count else SIGNATURE)(nothing)
        torque = rigid.Torque.call(called, data, fastest=3.0, states=count)
        again = rigid.Torque.from_dict(torque.to_dict())
        assert torque.function is not None
        assert again.function is not None
        for one, other in (
            (torque.function.data, again.function.data),
            (torque.function.start, again.function.start),
        ):
            np.testing.assert_array_equal(one, other)
        assert again.function.fastest == 3.0


@pytest.mark.parametrize("method", METHODS)
def test_a_torque_that_is_not_written_ends_the_body(method: str) -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(nothing))
    run = states(scene, OMEGA, t=[0.0, 1.0], method=method, step=0.1)
    assert run.status == rigid.Status.NOT_FINITE
    assert np.isnan(run.omega[1]).any()


def test_a_compiled_function_of_numba() -> None:
    numba: Any = pytest.importorskip("numba")
    c_type = numba.types.CPointer(numba.float64)

    signature = numba.void(numba.float64, c_type, c_type, c_type, c_type)
    compiled = numba.cfunc(signature)(plain_damping)
    for given in (compiled, compiled.address):
        scene = top(torque=rigid.Torque.call(given, (0.1, 0.2, 0.3)))
        run = states(scene, OMEGA, t=[3.0], method="dop853", step=0.02, threads=2)
        twin = states(top(damping=(0.1, 0.2, 0.3)), OMEGA, t=[3.0], method="dop853")
        assert np.abs(run.omega - twin.omega).max() < 1e-11


def test_a_function_of_cffi() -> None:
    cffi: Any = pytest.importorskip("cffi")
    c_type = "void(double, double *, double *, double *, double *)"

    called = cffi.FFI().callback(c_type)(plain_damping)
    scenes = [top(torque=rigid.Torque.call(one, (0.1, 0.2, 0.3))) for one in (called, damping)]
    runs = [states(scene, OMEGA, t=[2.0], method="rk4", step=0.1) for scene in scenes]
    assert runs[0].omega.tobytes() == runs[1].omega.tobytes()


test_what_is_no_address_is_refused = refuses(
    [
        (0, "address = 0: must be the address of a function"),
        (-4, "address = -4: must be the address"),
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
    by=lambda address: rigid.Torque.call(address),
)


def raises(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    torque[0] = torque[1] = torque[2] = 0.0
    if t > 0.5:
        raise ArithmeticError("too late")


@pytest.mark.parametrize("kind", ["ctypes", "called", "compiled"])
def test_what_a_function_raises_is_raised_by_the_call(
    kind: str, request: pytest.FixtureRequest
) -> None:
    if kind == "called":
        request.getfixturevalue("no_numba")
    torque = rigid.Torque.call(SIGNATURE(raises) if kind == "ctypes" else raises)
    scene = rigid.FreeBody(BODY, torque=torque)

    def fails(states: Any) -> Any:
        raise AssertionError("no states are reached")

    def steps_of(motion: rigid.Motion) -> None:
        for _ in range(3):
            motion.step(0.3)

    calls: list[Callable[[], object]] = [
        lambda: rigid.simulate(scene, OMEGA, t=[1.0]),
        lambda: rigid.simulate(scene, [OMEGA] * 40, t=[1.0], method="rk4", step=0.1, threads=2),
        lambda: rigid.simulate(scene, OMEGA, t=[1.0], events=rigid.crosses("omega1")),
        lambda: steps_of(rigid.Motion(scene, OMEGA)),
        lambda: rigid.stability_map(
            lambda gain: scene, axes={"gain": [1.0]}, stable=rigid.judged(fails, t=[1.0]), samples=1
        ),
    ]
    before = sys.unraisablehook
    for call in calls:
        with pytest.raises(ArithmeticError, match="too late") as raised:
            call()
        # The function and its line end the traceback.
        assert kind == "compiled" or raised.traceback[-1].name == "raises"
        assert sys.unraisablehook is before


def test_runs_of_two_threads_raise_what_their_own_functions_raise() -> None:
    scenes = [
        rigid.FreeBody(BODY, torque=rigid.Torque.call(torque, [0.1] * 3))
        for torque in (SIGNATURE(raises), damping)
    ]

    def outcome(number: int) -> str:
        try:
            rigid.simulate(scenes[number % 2], OMEGA, t=[1.0], threads=2)
        except ArithmeticError:
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


STEPS: dict[str, Any] = {"method": "rk4", "step": 1e-6, "check": 0.0}
MAP: dict[str, Any] = {"axes": {"spin": [1.0]}, "samples": 1, "t_end": 1e3, "rng": 1}

CALLS: dict[str, Callable[[rigid.FreeBody], object]] = {
    "a run": lambda scene: rigid.simulate(scene, OMEGA, t=[1.0], **STEPS),
    "a map": lambda scene: rigid.stability_map(scene, stable=rigid.no_flip(1), **MAP, **STEPS),
}


@pytest.mark.parametrize("name", CALLS)
def test_ctrl_c_within_a_function_of_python_ends_its_call(name: str) -> None:
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
        CALLS[name](scene)
    assert calls < 4 * 10**6


TURNED = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
UNDER = rigid.Torque.call(damping, [0.1] * 3)


def asked(*, drag: Any = None, **options: Any) -> Callable[[], Any]:
    scene = top(torque=UNDER, drag=drag)
    return lambda: rigid.simulate(scene, OMEGA, **{"t": [0.0, 0.5, 1.0], **options})


def grown(method: str | None) -> Callable[[], object]:
    return lambda: rigid.lyapunov(top(torque=UNDER), OMEGA, t=[1.0], method=method)


def loaded() -> rigid.Run:
    with TemporaryDirectory() as folder:
        run: Any = asked(method="rk4", step=0.1)()
        return rigid.load_run(run.save(Path(folder, "run.npz")))


OTHER = r"must take \(t, omega, attitude, data, torque\), or be the address of a compiled"

test_what_a_function_does_not_go_with_is_refused = refuses(
    [
        (asked(method="rk4"), "step: is needed.*or leave the method out: dop853 chooses its steps"),
        (
            asked(method="taylor16", step=0.1),
            "'taylor16': does not integrate the torque of a function",
        ),
        (asked(method="rk4", tolerance=1e-9), "only 'dop853' chooses its steps by a tolerance"),
        (asked(method="dop853", tolerance=1e-15), "tolerance = 1e-15: must be at least 1e-14"),
        (
            asked(method="rk4", step=0.1, events=rigid.crosses("omega1")),
            "'rk4': has no events, because a function is known inside the steps of 'dop853' alone",
        ),
        (asked(step=0.1, tangent=True), "the derivative of a function is not known"),
        (
            asked(drag=0.1, method="midpoint", step=0.1),
            "'midpoint': does not integrate drag; use one of 'rk4', 'dop853'",
        ),
        (
            lambda: rigid.poincare(top(torque=UNDER), OMEGA, t_end=1.0, method="taylor16"),
            "only 'dop853' under a function is a polynomial",
        ),
        (grown(None), "take starts that differ by 1e-6"),
        (grown("dop853"), "take starts that differ by 1e-6"),
        (
            lambda: rigid.free.power_balance(asked(method="rk4", step=0.1)()),
            "torque: the torque of a function is not known",
        ),
        (lambda: loaded().at([0.5]), "a run under a function keeps no function"),
        (lambda: rigid.FreeBody(BODY, torque=UNDER, frame=TURNED), "frame: a function"),
        (lambda: UNDER + UNDER, "both are functions"),
        (lambda: rigid.Torque.call(damping, fastest=-1.0), "fastest = -1"),
        (lambda: rigid.Torque.call(damping, 1.0), "data: expected shape"),
        (lambda: rigid.Torque.call(damping, [np.nan]), "data"),
        (lambda: rigid.Torque.call(lambda t, omega: None), TypeError, OTHER),
        (lambda: rigid.Torque.call(len), TypeError, OTHER),
    ],
)


def test_a_saved_run_has_its_states_but_no_function(tmp_path: Path) -> None:
    scene = top(torque=rigid.Torque.call(damping, [0.1] * 3, fastest=5.0))
    run = states(scene, OMEGA, t=[0.0, 1.0], method="rk4")
    read = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert np.array_equal(read.energy(), run.energy())


def test_a_run_ends_whose_rates_grow_beyond_all_numbers() -> None:
    # The torque grows with the rates, and the steps are far too long.
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, [-50.0] * 3))
    t = np.linspace(0.1, 1.6, 16)
    run = states(scene, [0.0, 0.0, 1e-3], t=t, method="rk4", step=0.1)
    finite = np.abs(run.omega[np.isfinite(run.omega)])
    assert finite.max() > 1e10
    assert run.status != rigid.Status.OK


# Steps by a tolerance, events and sections under the torque of a function, against their twins


TIMES = np.array([-1.0, -0.3, 0.0, 0.41, 1.7, 3.0, 6.0])
DAMPING = (0.1, 0.2, 0.3)


@SIGNATURE  # type: ignore[untyped-decorator]
def saturated(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = max(-data[1], min(data[1], -data[0] * omega[k]))


#: Tops under a function, without a bound of their rates, and their twins.
PAIRS = {
    "damping": (top(torque=rigid.Torque.call(damping, DAMPING)), top(damping=DAMPING)),
    "torque in space": (
        top(torque=rigid.Torque.call(in_space)),
        top(torque=rigid.Torque.space((0.1, 0.2, 0.3))),
    ),
}
beside_its_twin = pytest.mark.parametrize(("called", "twin"), PAIRS.values(), ids=PAIRS)


@beside_its_twin
def test_a_tolerance_tells_the_error_that_the_run_states(called: Any, twin: Any) -> None:
    truth = rigid.simulate(twin, OMEGA, TILTED, t=TIMES, accuracy=1e-13)
    fastest = np.linalg.norm(truth.omega, axis=-1).max()
    steps = []
    for tolerance in (1e-4, 1e-7, 1e-10, 1e-13, 1e-14):
        run = rigid.simulate(called, OMEGA, TILTED, t=TIMES, method="dop853", tolerance=tolerance)
        off = max(
            np.linalg.norm(run.omega - truth.omega, axis=-1).max() / fastest,
            rotation_angle(present(run.attitude), present(truth.attitude)).max(),
        )
        assert off <= float(run.error) + float(truth.error)
        # Some twenty steps err by the tolerance each at most; three times the difference is stated.
        assert float(run.error) < 1e3 * tolerance
        steps.append(int(run.steps))
    # Loose tolerances ask for fewer steps than the 64 that look at the torque often enough.
    assert 64 <= steps[0] == steps[1] <= 64 + len(TIMES)
    # A thousandth of the error of order 8 takes 1000^(1/8) = 2.4 times the steps, less where 64 are
    # enough, and a tenth 10^(1/8) times; steps that are cut by output times are shorter.
    assert np.all(np.divide(steps[1:], steps[:-1]) < 3.0)
    assert np.all(np.diff(steps) >= 0)
    assert steps[-1] / steps[-2] == pytest.approx(10.0 ** (1.0 / 8.0), rel=0.05)


def test_a_tolerance_finds_the_corners_of_a_saturated_torque() -> None:
    # SciPy's method of the same name, with steps that end nowhere near the corners.
    moments, data = np.array(BODY.moments), (2.0, 0.3)

    def rate(t: float, w: Any) -> Any:
        return (np.cross(moments * w, w) + np.clip(-data[0] * w, -data[1], data[1])) / moments

    truth = solve_ivp(rate, (0.0, 12.0), OMEGA, "DOP853", rtol=1e-13, atol=1e-15, max_step=1e-2)
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(saturated, data))
    run = rigid.simulate(scene, OMEGA, t=[12.0], method="dop853", tolerance=1e-9)
    off = np.linalg.norm(run.omega[-1] - truth.y[:, -1]) / np.linalg.norm(OMEGA)
    # A step across a corner has no order, and there are three; its estimate is right to a hundred.
    assert off <= float(run.error) < 1e-6


@beside_its_twin
def test_events_are_those_of_the_twin_within_their_stated_errors(called: Any, twin: Any) -> None:
    passed = 2.0 if twin.damping is None else 0.0
    watched = [rigid.crosses("omega1"), rigid.crosses("L2", passed), rigid.turns("gamma3")]
    known = rigid.simulate(twin, OMEGA, TILTED, t=[12.0], events=watched).events
    ways: list[dict[str, Any]] = [{"tolerance": 1e-6}, {"tolerance": 1e-10}, {"step": 0.05}]
    for asked in ways:
        run = rigid.simulate(
            called, OMEGA, TILTED, t=[12.0], method="dop853", events=watched, **asked
        )
        assert sum(len(mine.t) for mine in run.events) > 6
        for mine, truth in zip(run.events, known, strict=True):
            assert len(mine.t) == len(truth.t) > 0
            assert mine.complete
            assert np.all(np.abs(mine.t - truth.t) <= mine.error + truth.error)
            # A step of the default tolerance errs by 1e-12; some hundred of them, three times.
            largest = 3e2 * asked.get("tolerance", 1e-12) * 3.0
            assert mine.error.max() < largest / np.abs(mine.slope).min()


@beside_its_twin
def test_a_section_has_the_points_of_its_twin(called: Any, twin: Any) -> None:
    known, points = (rigid.poincare(one, OMEGA, TILTED, t_end=30.0) for one in (twin, called))
    assert len(points.t) == len(known.t) > 5
    assert bool(points.complete)
    assert np.all(np.abs(points.t - known.t) <= points.error + known.error)


def test_a_run_without_a_method_chooses_steps_for_the_accuracy() -> None:
    called, twin = PAIRS["torque in space"]
    truth = rigid.simulate(twin, OMEGA, TILTED, t=TIMES, accuracy=1e-13)
    fastest = np.linalg.norm(truth.omega, axis=-1).max()
    asked: list[tuple[dict[str, Any], float]] = [
        ({}, 1e-8),
        ({"accuracy": 1e-5}, 1e-5),
        ({"accuracy": 1e-12}, 1e-12),
        ({"tolerance": 1e-9}, 1e-7),
    ]
    for given, largest in asked:
        run = rigid.simulate(called, OMEGA, TILTED, t=TIMES, **given)
        assert run.plan.method == "dop853"
        assert run.plan.step is None
        off = np.linalg.norm(run.omega - truth.omega, axis=-1).max() / fastest
        assert off <= float(run.error) + float(truth.error)
        assert float(run.error) < largest
        assert run.status == rigid.Status.OK
    plan = rigid.plan(called, "attitude", omega=OMEGA, t_end=6.0, accuracy=1e-8)
    assert "dop853 alone chooses its steps under the torque of a function" in plan.why
    damped = rigid.FreeBody(BODY, torque=UNDER, damping=100.0)
    assert rigid.plan(damped, step=0.01).method == "rk4"


def test_an_accuracy_is_reached_by_smaller_tolerances() -> None:
    # Steps across corners err by some hundred times the tolerance.
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(saturated, (2.0, 0.3)))
    loose = rigid.simulate(scene, OMEGA, t=[12.0], tolerance=1e-10)
    accuracy = 0.1 * float(loose.error)
    run = rigid.simulate(scene, OMEGA, t=[12.0], accuracy=accuracy)
    assert float(run.error) <= accuracy
    alone = rigid.simulate(scene, [OMEGA, 2.0 * OMEGA], t=[12.0], accuracy=accuracy)
    assert alone.omega[0].tobytes() == run.omega.tobytes()


def test_steps_are_made_shorter_where_the_first_one_is_wild() -> None:
    # A body at rest has no time scale: the first step that is tried is the whole time.
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(in_space))
    twin = rigid.FreeBody(BODY, torque=rigid.Torque.space((0.1, 0.2, 0.3)))
    run = rigid.simulate(scene, np.zeros(3), t=[50.0], method="dop853", tolerance=1e-10)
    truth = rigid.simulate(twin, np.zeros(3), t=[50.0], accuracy=1e-12)
    fastest = np.linalg.norm(truth.omega[-1])
    assert np.linalg.norm(run.omega - truth.omega) / fastest <= float(run.error) < 1e-7


def test_a_table_that_jumps_adds_to_a_function() -> None:
    motor = rigid.Torque.body([(0, 0, 1), (0, 0, 1), (0, 0, 0), (0, 0, 0)], times=[0, 2, 2, 9])
    both = rigid.Torque.call(damping, DAMPING) + motor
    assert both.words().startswith("torque by a function, torque ")
    called = rigid.FreeBody(BODY, torque=both)
    known = rigid.FreeBody(BODY, torque=motor, damping=DAMPING)
    run = rigid.simulate(called, OMEGA, t=[1.0, 4.0], method="dop853", tolerance=1e-11)
    truth = rigid.simulate(known, OMEGA, t=[1.0, 4.0], accuracy=1e-13)
    assert np.abs(run.omega - truth.omega).max() < 2.0 * float(run.error) + 1e-13
    assert float(run.error) < 1e-9


# A torque of a function that acts for a short time is seen by runs, events and maps


T_END = 100.0
WAYS: list[dict[str, Any]] = [{}, {"accuracy": 1e-8}, {"tolerance": 1e-9}, {"tolerance": 1e-3}]


def pulse(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """A torque about axis 3 between two times."""
    torque[0] = torque[1] = 0.0
    torque[2] = data[2] if data[0] <= t < data[1] else 0.0


@SIGNATURE  # type: ignore[untyped-decorator]
def smooth(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    torque[0] = torque[1] = 0.0
    torque[2] = 0.5 * math.exp(-(((t - 42.0) / 1.5) ** 2))


@SIGNATURE  # type: ignore[untyped-decorator]
def holds(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """Turns the body to the attitude of its data, and damps it."""
    w, *v = attitude[:4]
    at_w, *at = data[:4]
    turned = np.subtract(np.multiply(at_w, v), np.multiply(w, at)) - np.cross(at, v)
    for k in range(3):
        torque[k] = -2.0 * turned[k] - 1.4 * omega[k]


def pulsed(begin: Any, end: Any, size: Any) -> rigid.FreeBody:
    data = np.stack(np.broadcast_arrays(begin, end, size), axis=-1)
    return rigid.FreeBody(BODY, torque=rigid.Torque.call(pulse, data))


@pytest.mark.parametrize("asked", WAYS, ids=str)
@pytest.mark.parametrize("start", [0.0, 1e-9, 0.2])
def test_a_pulse_changes_the_momentum_by_its_impulse(asked: dict[str, Any], start: float) -> None:
    # Between the ends of the run a body at rest gives a step no reason to be short.
    run = rigid.simulate(pulsed(35.0, 59.0, 0.5), [0.0, 0.0, start], t=[0.0, T_END], **asked)
    gained = start + 0.5 * 24.0 / 2.0
    assert abs(run.omega[-1, 2] - gained) <= (float(run.error) + 1e-15) * gained
    # A step across a corner errs by some tens of times the tolerance; the body then turns for 65 s.
    assert float(run.error) < 1e4 * asked.get("tolerance", 1e-8)


def test_random_pulses_are_seen_or_the_error_says_so() -> None:
    # Lengths from 0.5 % of the run on: a step of a 64th of it looks in gaps of 0.42 %.
    rng = np.random.default_rng(39)
    share = np.exp(rng.uniform(math.log(0.005), math.log(0.2), 40))
    begin = rng.uniform(0.0, 1.0 - share) * T_END
    size = rng.choice([-1.0, 1.0], 40) * np.exp(rng.uniform(math.log(1e-4), math.log(3.0), 40))
    bodies = pulsed(begin, begin + share * T_END, size)
    gained = size * share * T_END / 2.0
    for tolerance in (None, 1e-6):
        run = rigid.simulate(bodies, np.zeros(3), t=[T_END], tolerance=tolerance)
        assert np.all(np.abs(run.omega[:, -1, 2] - gained) <= run.error * np.abs(gained))
        assert np.all(np.isin(run.status, (rigid.Status.OK, rigid.Status.COARSE)))


def test_a_run_looks_at_the_torque_at_every_output_time() -> None:
    # A fifth of a second is 0.2 % of the run, but longer than the time between its states.
    run = rigid.simulate(pulsed(41.03, 41.23, 5.0), np.zeros(3), t=np.linspace(0.0, T_END, 1001))
    assert abs(run.omega[-1, 2] - 0.5) <= float(run.error) * 0.5 < 1e-6


def map_from_rest(scene: Callable[[Any], rigid.FreeBody], **asked: Any) -> rigid.StabilityMap:
    return rigid.stability_map(scene, start=rigid.Start(omega=(0.0, 0.0, 0.0)), samples=1, **asked)


def test_events_and_criteria_see_the_pulse() -> None:
    scene = pulsed(35.0, 59.0, 0.5)
    run = rigid.simulate(scene, np.zeros(3), t=[0.0, T_END], until=rigid.crosses("omega3", 3.0))
    # 3 rad/s after 12 s of 0.25 rad/s².
    (event,) = run.events
    assert event.complete
    assert abs(event.t[0] - 47.0) <= event.error[0] + 1e-12
    assert np.isinf(event.lost_from)
    still = rigid.judged(lambda states: np.abs(states.omega[:, -1, 2]) < 1.0, t=[T_END])
    result = map_from_rest(
        lambda size: pulsed(35.0, 59.0, size), axes={"size": [0.05, 0.5]}, stable=still
    )
    # The rates at the end are 0.6 and 6 rad/s.
    assert result.stable.tolist() == [1, 0]


def test_maps_by_equal_steps_see_the_pulse() -> None:
    # For the bound of the rates 16 steps would do, in whose gap of 1.67 s the pulse lies.
    def scene(size: Any) -> rigid.FreeBody:
        data = np.stack(np.broadcast_arrays(71.0, 72.0, size), axis=-1)
        return rigid.FreeBody(BODY, torque=rigid.Torque.call(pulse, data, fastest=0.02))

    near = rigid.near_start(0.1)
    result = map_from_rest(scene, axes={"size": [0.002, 0.02]}, stable=near, t_end=T_END)
    # At the end the bodies have turned by size / 2 times 28.5 s: 0.03 and 0.3 rad.
    assert result.stable.tolist() == [1, 0]
    assert result.unstable.tolist() == [0, 1]


def test_a_smooth_torque_from_rest_costs_a_bounded_number_of_steps() -> None:
    # It sets in at 1e-323 N m; a share of the rates there would ask for steps without end.
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(smooth))
    run = rigid.simulate(scene, np.zeros(3), t=[0.0, T_END], tolerance=1e-9)
    gained = 0.25 * 1.5 * math.sqrt(math.pi)
    assert abs(run.omega[-1, 2] - gained) <= float(run.error) * gained < 1e-6
    # The 64 of every run, five for each of 39 rad, and the onset.
    assert int(run.steps) < 300


def test_a_controller_that_holds_a_body_at_rest_is_no_noise_to_resolve() -> None:
    # Rounding of the attitude gives torques of 1e-16 N m.
    target = rigid.rotations.euler_to_quaternion([0.3, 0.5, 0.2])
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(holds, target))
    run = rigid.simulate(scene, np.zeros(3), target, t=[0.0, T_END], tolerance=1e-9)
    assert int(run.steps) < 100
    assert float(run.energy_drift) < 1e-9
    assert np.abs(run.omega).max() < 1e-14


# The torque of a function of Python: called as it is, or compiled by numba


@pytest.mark.parametrize("method", METHODS)
def test_a_function_of_python_is_its_twin_of_ctypes(way: str, method: str) -> None:
    one: Any = rigid.Torque.call(plain_damping, DAMPING)
    pair = [one, rigid.Torque.call(SIGNATURE(plain_damping), DAMPING)]
    assert one.function.callback.of_eight == (way == "compiled")
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
    scene = top(torque=rigid.Torque.call(ramp))
    run = rigid.simulate(scene, OMEGA, TILTED, t=[1.0, 3.0], accuracy=1e-11)
    assert np.abs(run.omega - truth.omega).max() < 1e-11 * np.linalg.norm(OMEGA) * 3.0
    assert float(run.error) < 1e-11


def test_a_function_of_python_takes_its_arrays_whole(no_numba: None) -> None:
    def whole(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        w, x, y, z = attitude
        (gain,) = data
        torque[:] = -gain * omega * (w * w + x * x + y * y + z * z)

    damped = rigid.simulate(top(damping=0.3), OMEGA, TILTED, t=[1.0, 3.0], accuracy=1e-13)
    scene = top(torque=rigid.Torque.call(whole, [0.3]))
    assert ", data of shape (1,)" in repr(scene.torque)
    run = rigid.simulate(scene, OMEGA, TILTED, t=[1.0, 3.0], accuracy=1e-11)
    assert np.abs(run.omega - damped.omega).max() < 1e-11 * np.linalg.norm(OMEGA) * 3.0


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
    twin = rigid.simulate(top(damping=DAMPING), OMEGA, TILTED, t=[3.0], accuracy=1e-13)
    scene = top(torque=rigid.Torque.call(plain_damping, np.tile(DAMPING, (3, 1))))
    run = rigid.simulate(
        scene, OMEGA, TILTED, t=[3.0], tolerance=1e-10, events=rigid.crosses("omega1")
    )
    off = np.linalg.norm(run.omega - twin.omega, axis=-1).max() / np.linalg.norm(OMEGA)
    assert off <= run.error.max() < 1e-8
    assert all(len(run.events[0].of(body).t) > 0 for body in range(3))


def test_a_motion_calls_a_function_of_python(way: str) -> None:
    scene = top(torque=rigid.Torque.call(ramp))
    motion = rigid.Motion(scene, OMEGA, TILTED)
    for _ in range(10):
        motion.step(0.1)
    run = rigid.simulate(scene, OMEGA, TILTED, t=[1.0], method="dop853", step=0.1)
    assert np.abs(motion.omega - run.omega[-1]).max() < 1e-13


def test_the_plan_says_that_python_calls_and_what_would_compile(no_numba: None) -> None:
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(plain_damping, DAMPING, fastest=3.0))
    words = "Python calls the torque, some 5 µs for each body and stage: to compile it needs numba"
    told = rigid.plan(scene, omega=OMEGA, t_end=1.0)
    of_map = rigid.plan(scene, rigid.spin_above(0.1), omega=OMEGA, t_end=1.0)
    for plan in (told, of_map):
        assert any(why.startswith(words) and "pip install" in why for why in plan.why)


def test_a_compiled_function_is_not_called_slow() -> None:
    pytest.importorskip("numba")
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(plain_damping, DAMPING, fastest=3.0))
    assert not any("Python calls" in why for why in rigid.plan(scene, omega=OMEGA, t_end=1.0).why)


def test_a_jitted_function_is_compiled_once() -> None:
    numba: Any = pytest.importorskip("numba")
    jitted = numba.njit(plain_damping)
    pair: Any = [rigid.Torque.call(jitted, row) for row in (DAMPING, (0.0, 0.0, 0.1))]
    assert pair[0].function.callback.of_eight
    assert pair[0].function.callback.address == pair[1].function.callback.address
    assert rigid.Torque.call(jitted, DAMPING) == pair[0]


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


def test_without_its_compiler_numba_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    numba: Any = pytest.importorskip("numba")
    monkeypatch.setattr(numba.config, "DISABLE_JIT", True)

    def own(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        torque[:] = -0.1 * omega

    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(own))
    assert any("NUMBA_DISABLE_JIT" in why for why in rigid.plan(scene).why)


def test_a_map_under_a_function_of_python_is_that_of_its_twin(way: str) -> None:
    def by_function(gain: Any) -> rigid.FreeBody:
        torque = rigid.Torque.call(plain_damping, gain[:, np.newaxis] * np.ones(3), fastest=2.5)
        return rigid.FreeBody(BODY, torque=torque)

    def by_damping(gain: Any) -> rigid.FreeBody:
        return rigid.FreeBody(BODY, damping=gain[:, np.newaxis] * np.ones(3))

    options: dict[str, Any] = {
        "axes": {"gain": [0.05, 0.1], "spin": [0.5, 1.5]},
        "start": rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.1)),
        "stable": ~rigid.spin_above(0.8),
        **{"t_end": 15.0, "samples": 4, "rng": 3, "progress": False},
    }
    maps = [rigid.stability_map(scene, **options) for scene in (by_function, by_damping)]
    assert np.array_equal(maps[0].stable, maps[1].stable)
    assert 0 < maps[0].stable.sum() < maps[0].stable.size * 4
