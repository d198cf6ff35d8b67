"""Steps by a tolerance, events and sections under the torque of a function, against their twins.

A damping and a ramp in space have built-in twins, which a Taylor series integrates to rounding.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid

BODY = rigid.Body((1.0, 1.5, 2.0))
OMEGA = np.array([0.3, 2.0, 1.0])
TILTED = rigid.rotations.euler_to_quaternion([0.3, 0.5, 0.2])
TIMES = np.array([-1.0, -0.3, 0.0, 0.41, 1.7, 3.0, 6.0])
DOUBLES = ctypes.POINTER(ctypes.c_double)
SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)
DAMPING = (0.1, 0.2, 0.3)


@SIGNATURE  # type: ignore[untyped-decorator]
def damping(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[k] * omega[k]


@SIGNATURE  # type: ignore[untyped-decorator]
def in_space(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque (0.1, 0.2, 0.3) in space, in body components."""
    w, x, y, z = attitude[:4]
    a, b, c = 0.1, 0.2, 0.3
    torque[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    torque[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    torque[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c


@SIGNATURE  # type: ignore[untyped-decorator]
def saturated(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = max(-data[1], min(data[1], -data[0] * omega[k]))


def top(**acting: Any) -> rigid.HeavyTop:
    return rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.6, 0.8), **acting)


def pairs() -> list[tuple[str, rigid.HeavyTop, rigid.HeavyTop]]:
    """Tops under a function, without a bound of their rates, and their twins."""
    twin = top(torque=rigid.Torque.space((0.1, 0.2, 0.3)))
    return [
        ("damping", top(torque=rigid.Torque.call(damping, DAMPING)), top(damping=DAMPING)),
        ("torque in space", top(torque=rigid.Torque.call(in_space)), twin),
    ]


PAIRS = pairs()
NAMES = [name for name, *_ in PAIRS]


def turn(one: Any, other: Any) -> Any:
    """The angle between attitudes (rad)."""
    apart = np.minimum(np.linalg.norm(one - other, axis=-1), np.linalg.norm(one + other, axis=-1))
    return 2.0 * apart


@pytest.mark.parametrize(("called", "twin"), [pair[1:] for pair in PAIRS], ids=NAMES)
def test_a_tolerance_tells_the_error_that_the_run_states(called: Any, twin: Any) -> None:
    truth = rigid.simulate(twin, OMEGA, TILTED, t=TIMES, accuracy=1e-13)
    fastest = np.linalg.norm(truth.omega, axis=-1).max()
    steps = []
    for tolerance in (1e-4, 1e-7, 1e-10, 1e-13, 1e-14):
        run = rigid.simulate(called, OMEGA, TILTED, t=TIMES, method="dop853", tolerance=tolerance)
        off = max(
            np.linalg.norm(run.omega - truth.omega, axis=-1).max() / fastest,
            turn(run.attitude, truth.attitude).max(),
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

    truth = solve_ivp(rate, (0.0, 12.0), OMEGA, "DOP853", rtol=1e-13, atol=1e-15, max_step=1e-3)
    scene = rigid.FreeBody(BODY, torque=rigid.Torque.call(saturated, data))
    run = rigid.simulate(scene, OMEGA, t=[12.0], method="dop853", tolerance=1e-9)
    off = np.linalg.norm(run.omega[-1] - truth.y[:, -1]) / np.linalg.norm(OMEGA)
    # A step across a corner has no order, and there are three; its estimate is right to a hundred.
    assert off <= float(run.error) < 1e-6


@pytest.mark.parametrize(("called", "twin"), [pair[1:] for pair in PAIRS], ids=NAMES)
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


def test_until_ends_the_record_of_a_body_at_its_event() -> None:
    # Each of three bodies has its own coefficient; |omega3| of a wheel decays as exp(-k t / I3).
    gain = np.array([0.2, 0.5, 1.0])
    data = gain[:, np.newaxis] * np.ones(3)
    wheel = rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, data, fastest=2.0))
    run = rigid.simulate(
        wheel, [0.0, 0.0, 1.0], t=[0.0, 30.0], until=rigid.crosses("omega3", value=0.1)
    )
    assert run.plan.method == "dop853"
    assert run.end is not None
    assert np.abs(run.end - np.log(10.0) * 2.0 / gain).max() < 1e-10
    assert np.isnan(run.omega[:, 1]).all()
    assert np.all(run.status == rigid.Status.STOPPED)


@pytest.mark.parametrize(("called", "twin"), [pair[1:] for pair in PAIRS], ids=NAMES)
def test_a_section_has_the_points_of_its_twin(called: Any, twin: Any) -> None:
    known = rigid.poincare(twin, OMEGA, TILTED, t_end=30.0)
    points = rigid.poincare(called, OMEGA, TILTED, t_end=30.0)
    assert len(points.t) == len(known.t) > 5
    assert bool(points.complete)
    assert np.all(np.abs(points.t - known.t) <= points.error + known.error)


def test_a_run_without_a_method_chooses_steps_for_the_accuracy() -> None:
    called, twin = PAIRS[1][1:]
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
    called = rigid.FreeBody(BODY, torque=rigid.Torque.call(damping, DAMPING) + motor)
    known = rigid.FreeBody(BODY, torque=motor, damping=DAMPING)
    run = rigid.simulate(called, OMEGA, t=[1.0, 4.0], method="dop853", tolerance=1e-11)
    truth = rigid.simulate(known, OMEGA, t=[1.0, 4.0], accuracy=1e-13)
    assert np.abs(run.omega - truth.omega).max() < 2.0 * float(run.error) + 1e-13
    assert float(run.error) < 1e-9


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"method": "rk4", "tolerance": 1e-9}, "only 'dop853' chooses its steps by a tolerance"),
        ({"method": "dop853", "tolerance": 1e-15}, "tolerance = 1e-15: must be at least 1e-14"),
        (
            {"method": "rk4", "step": 0.1, "events": rigid.crosses("omega1")},
            "'rk4': has no events, because a function is known inside the steps of 'dop853' alone",
        ),
        ({"method": "rk4"}, "step: is needed.*or leave the method out: dop853 chooses its steps"),
        (
            {"step": 0.1, "tangent": True},
            "the derivative of a function is not known",
        ),
    ],
)
def test_what_steps_under_a_function_cannot_do_is_refused(asked: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        rigid.simulate(PAIRS[0][1], OMEGA, t=[1.0], **asked)


def test_other_sections_and_growth_are_refused() -> None:
    scene = PAIRS[0][1]
    with pytest.raises(ValueError, match="only 'dop853' under a function is a polynomial"):
        rigid.poincare(scene, OMEGA, t_end=1.0, method="taylor16")
    for method in (None, "dop853"):
        with pytest.raises(ValueError, match="take starts that differ by 1e-6"):
            rigid.lyapunov(scene, OMEGA, t=[1.0], method=method)
