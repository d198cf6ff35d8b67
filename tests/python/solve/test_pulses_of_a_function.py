"""A torque of a function that acts for a short time is seen by runs, events and maps."""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np
import pytest

import rigid

BODY = rigid.Body((1.0, 1.5, 2.0))
DOUBLES = ctypes.POINTER(ctypes.c_double)
SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)
T_END = 100.0
WAYS: list[dict[str, Any]] = [{}, {"accuracy": 1e-8}, {"tolerance": 1e-9}, {"tolerance": 1e-3}]


@SIGNATURE  # type: ignore[untyped-decorator]
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


def test_events_and_criteria_see_the_pulse() -> None:
    scene = pulsed(35.0, 59.0, 0.5)
    run = rigid.simulate(scene, np.zeros(3), t=[0.0, T_END], until=rigid.crosses("omega3", 3.0))
    # 3 rad/s after 12 s of 0.25 rad/s².
    (event,) = run.events
    assert event.complete
    assert abs(event.t[0] - 47.0) <= event.error[0] + 1e-12
    assert np.isinf(event.lost_from)
    still = rigid.judged(lambda states: np.abs(states.omega[:, -1, 2]) < 1.0, t=[T_END])
    result = rigid.stability_map(
        lambda size: pulsed(35.0, 59.0, size),
        axes={"size": [0.05, 0.5]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0)),
        stable=still,
        samples=1,
    )
    # The rates at the end are 0.6 and 6 rad/s.
    assert result.stable.tolist() == [1, 0]


def test_maps_by_equal_steps_see_the_pulse() -> None:
    # For the bound of the rates 16 steps would do, in whose gap of 1.67 s the pulse lies.
    def scene(size: Any) -> rigid.FreeBody:
        data = np.stack(np.broadcast_arrays(71.0, 72.0, size), axis=-1)
        return rigid.FreeBody(BODY, torque=rigid.Torque.call(pulse, data, fastest=0.02))

    result = rigid.stability_map(
        scene,
        axes={"size": [0.002, 0.02]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0)),
        stable=rigid.near_start(0.1),
        t_end=T_END,
        samples=1,
    )
    # At the end the bodies have turned by size / 2 times 28.5 s: 0.03 and 0.3 rad.
    assert result.stable.tolist() == [1, 0]
    assert result.unstable.tolist() == [0, 1]


def test_a_smooth_torque_from_rest_costs_a_bounded_number_of_steps() -> None:
    # It sets in at 1e-323 N m; a share of the rates there would ask for steps without end.
    run = rigid.simulate(
        rigid.FreeBody(BODY, torque=rigid.Torque.call(smooth)),
        np.zeros(3),
        t=[0.0, T_END],
        tolerance=1e-9,
    )
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
