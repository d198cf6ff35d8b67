"""States of the function of a torque: wheels, filters, orbits; against SciPy and closed forms."""

from __future__ import annotations

import ctypes
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import rigid
from physics import cross
from printed_equations import gathers, with_states
from refusals import refuses
from rigid.rotations.apply import to_body, to_space

BODY = rigid.Body((1.0, 1.5, 2.0))
OMEGA = np.array([0.3, -0.2, 0.5])
TILTED = rigid.rotations.euler_to_quaternion([0.3, 0.5, 0.2])
DOUBLES = ctypes.POINTER(ctypes.c_double)
LONG: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, *[DOUBLES] * 7)
SHORT: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, *[DOUBLES] * 4)
MOST = 0.15
"""Torque of a motor (N m) at which it saturates, smoothly."""


def simulate(*given: Any, **asked: Any) -> Any:
    """A run whose arrays are all there."""
    return rigid.simulate(*given, **asked)


def wheels(
    t: float, omega: Any, attitude: Any, data: Any, torque: Any, states: Any, rates: Any
) -> None:
    """Quaternion PD by three wheels, whose motors saturate, from rates that a filter smooths.

    States: the momenta of the wheels, and the filtered rates.
    """
    sign = 1.0 if attitude[0] >= 0.0 else -1.0
    for k in range(3):
        wanted = data[0] * sign * attitude[1 + k] + data[1] * states[3 + k]
        motor = MOST * math.tanh(wanted / MOST)
        rates[k] = motor
        rates[3 + k] = (omega[k] - states[3 + k]) / data[2]
        torque[k] = -motor
    torque[0] -= omega[1] * states[2] - omega[2] * states[1]
    torque[1] -= omega[2] * states[0] - omega[0] * states[2]
    torque[2] -= omega[0] * states[1] - omega[1] * states[0]


GAINS = (0.4, 1.2, 0.3)
STARTS = (0.1, 0.0, -0.2, 0.0, 0.0, 0.0)


@cache
def wheels_by_scipy() -> Any:
    def acting(t: float, omega: Any, q: Any, states: Any) -> Any:
        torque, rates = np.zeros(3), np.zeros(6)
        wheels(t, omega, q, GAINS, torque, states, rates)
        return torque, rates

    return with_states(np.array(BODY.moments), acting, [OMEGA, TILTED, STARTS], TIMES)


TIMES = [0.0, 1.0, 10.0, 30.0]


#: Steps that follow an accuracy, and equal ones.
STEPS = pytest.mark.parametrize(
    "steps", [{"accuracy": 1e-11}, {"method": "dop853", "step": 0.05}], ids=str
)


def scene(torque: Any = None, **acting: Any) -> rigid.FreeBody:
    return rigid.FreeBody(
        BODY, torque=torque or rigid.Torque.call(wheels, GAINS, states=6), **acting
    )


def made_of_gain(gain: Any) -> rigid.FreeBody:
    data = np.stack([gain, 0.0 * gain + GAINS[1], 0.0 * gain + GAINS[2]], axis=-1)
    return scene(rigid.Torque.call(wheels, data, states=6))


@STEPS
def test_wheels_that_saturate_and_a_filter_move_as_by_scipy(way: str, steps: Any) -> None:
    run = simulate(scene(), OMEGA, TILTED, states=STARTS, t=TIMES, **steps)
    truth = wheels_by_scipy()
    # SciPy errs by 1e-12; dop853 by the eighth power of its step, 4e-11, times the rates it damps.
    assert np.abs(run.omega - truth[:, :3]).max() < 1e-10
    assert np.abs(run.attitude - truth[:, 3:7]).max() < 1e-10
    assert run.states.shape == (4, 6)
    assert np.abs(run.states - truth[:, 7:]).max() < 1e-10
    assert np.array_equal(run.states[0], STARTS)
    # The momentum of body and wheels is constant in space.
    whole = to_space(run.attitude, run.momentum() + run.states[:, :3])
    assert np.abs(whole - whole[0]).max() < 1e-10


def test_a_function_of_ctypes_has_the_bits_of_one_of_python() -> None:
    pair = [
        simulate(scene(torque), OMEGA, TILTED, states=STARTS, t=TIMES, tolerance=1e-9)
        for torque in (
            rigid.Torque.call(LONG(_all_arguments), GAINS, states=6),
            rigid.Torque.call(LONG(_all_arguments), GAINS, states=6, fastest=None),
        )
    ]
    truth = wheels_by_scipy()
    assert np.abs(pair[0].states - truth[:, 7:]).max() < 1e-7
    assert np.array_equal(pair[0].states, pair[1].states)


def _all_arguments(
    t: float, omega: Any, attitude: Any, data: Any, torque: Any, states: Any, rates: Any, place: Any
) -> None:
    wheels(t, omega, attitude, data, torque, states, rates)
    assert place[0] == place[1] == place[2] == 0.0  # without an orbit


def test_each_body_has_states_of_its_own_and_none_depends_on_its_companions() -> None:
    starts = np.array([STARTS, np.zeros(6), np.full(6, 0.05)])
    omega = np.array([OMEGA, 2.0 * OMEGA, -OMEGA])
    scenes = made_of_gain(np.array([0.4, 0.6, 0.8]))
    asked: dict[str, Any] = {"t": TIMES, "tolerance": 1e-9}
    asked["until"] = [rigid.crosses(f"state{k}", -0.2) for k in (1, 2, 5)]
    many = simulate(scenes, omega, TILTED, states=starts, threads=2, **asked)
    for k in range(3):
        one = simulate(scenes[k], omega[k], TILTED, states=starts[k], **asked)
        assert np.array_equal(many.states[k], one.states, equal_nan=True)
        assert np.array_equal(many.omega[k], one.omega, equal_nan=True)
        assert many.end[k] == one.end
    assert len(set(many.end.tolist())) == 3
    assert many.spec["scene"]["torque"]["function"]["states"] == starts.tolist()
    parts: Any = rigid.simulate_chunks(scenes, omega, TILTED, states=starts, chunk=2, **asked)
    assert np.array_equal(
        np.concatenate([part.states for part in parts]), many.states, equal_nan=True
    )


def oscillator(
    t: float, omega: Any, attitude: Any, data: Any, torque: Any, states: Any, rates: Any
) -> None:
    """A spring that the body does not feel."""
    for k in range(3):
        torque[k] = 0.0
    rates[0], rates[1] = states[1], -(data[0] ** 2) * states[0]


@pytest.mark.parametrize(
    "steps",
    [{}, {"tolerance": 1e-6}, {"accuracy": 1e-10}, {"method": "rk4", "step": 0.002}],
    ids=str,
)
def test_the_error_is_that_of_the_states_too(steps: Any) -> None:
    # The body turns evenly about an axis and has no error; the spring has 16 swings.
    swinging, times = 10.0, np.linspace(0.0, 10.0, 41)
    torque = rigid.Torque.call(oscillator, [swinging], states=2)
    run = simulate(scene(torque), [0.0, 0.0, 0.1], states=[1e-3, 0.0], t=times, **steps)
    truth = 1e-3 * np.cos(swinging * times), -1e-3 * swinging * np.sin(swinging * times)
    relative = [
        np.abs(run.states[:, k] - truth[k]).max() / np.abs(truth[k]).max() for k in range(2)
    ]
    assert 0.1 * run.error < max(relative) <= run.error < 1e-4
    assert np.abs(run.omega - [0.0, 0.0, 0.1]).max() < 1e-15


def test_a_state_that_is_zero_but_for_rounding_does_not_ask_for_endless_steps() -> None:
    # At rest at its target: the motors see the rounding of the attitude.
    run = simulate(scene(), np.zeros(3), states=np.zeros(6), t=[0.0, 100.0], tolerance=1e-9)
    assert int(run.steps) < 200
    assert np.abs(run.states).max() < 1e-14


def test_events_watch_states() -> None:
    swinging = 2.0
    torque = rigid.Torque.call(oscillator, [swinging], states=2)
    events = [
        rigid.crosses("state1", 0.5, -1),
        rigid.turns("state1", 1),
        rigid.crosses("state2", 0.0),
    ]
    run = simulate(
        scene(torque), OMEGA, states=[1.0, 0.0], t=[0.0, 10.0], events=events, tolerance=1e-12
    )
    period = math.pi  # of cos(2 t)
    falls = math.pi / 6.0 + period * np.arange(4)
    least = period / 2.0 + period * np.arange(3)
    zeros = period / 2.0 * np.arange(1, 7)
    for found, truth in zip(run.events, (falls, least, zeros), strict=True):
        assert found.complete
        assert np.abs(found.t - truth).max() < 1e-9
        assert np.all(np.abs(found.t - truth) <= found.error)
        assert np.all(found.error < 1e-7)
        assert np.isinf(found.lost_from)
    states = run.events[0].states
    # The point is as far off as its time, times the rate.
    assert np.abs(states - [0.5, -swinging * math.sqrt(0.75)]).max() < 1e-8
    assert rigid.crosses("state2", 0.1).words() == "state2 = 0.1, both ways"
    plain = simulate(BODY, OMEGA, t=[0.0, 9.0], events=rigid.crosses(omega=(1.0, 0.0, 0.0)))
    assert plain.states is None
    assert plain.events[0].states is None


def test_a_body_stops_when_its_wheel_is_full(no_numba: None) -> None:
    # A motor of 0.1 N m fills a wheel of 0.5 N m s in 5 s, for each of two bodies from its start.
    def motor(
        t: float, omega: Any, attitude: Any, data: Any, torque: Any, states: Any, rates: Any
    ) -> None:
        torque[0], torque[1], torque[2] = 0.0, 0.0, -0.1
        rates[0] = 0.1

    torque = rigid.Torque.call(motor, states=1)
    run = simulate(
        scene(torque),
        np.zeros((2, 3)),
        states=[[0.0], [0.2]],
        t=[0.0, 1.0, 9.0],
        until=rigid.crosses("state1", 0.5),
    )
    assert np.abs(run.end - [5.0, 3.0]).max() < 1e-12
    assert np.isnan(run.states[:, 2]).all()
    assert np.abs(run.states[:, 1, 0] - [0.1, 0.3]).max() < 1e-15
    assert np.array_equal(run.status, [rigid.Status.STOPPED] * 2)


def test_states_are_saved_exported_and_in_tables(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    run = simulate(
        scene(), OMEGA, states=STARTS, t=TIMES, tolerance=1e-9, events=rigid.crosses("state1")
    )
    again: Any = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert np.array_equal(again.states, run.states)
    assert np.array_equal(again.events[0].states, run.events[0].states)
    assert again.spec["scene"]["torque"]["function"]["states"] == list(STARTS)
    data = run.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert data.states.dims == ("t", "state")
    head = run.to_csv(tmp_path / "run.csv").read_text().splitlines()[0]
    assert head.endswith(",state1,state2,state3,state4,state5,state6,work")


# The place on the orbit


NORMAL, PERIAPSIS = np.array([2.0, 1.0, 2.0]) / 3.0, np.array([1.0, 2.0, -2.0]) / 3.0
RATE, BEGIN = 0.5, -0.8


@cache
def gathered(e: float) -> Any:
    """The integral of the place until each time, by Kepler's equation and quadrature."""
    along, across = PERIAPSIS, np.cross(NORMAL, PERIAPSIS)

    def place(t: float) -> Any:
        mean = BEGIN + RATE * t
        E = math.copysign(3.0, mean)  # right of the zero, where Newton's method begins
        for _ in range(100):
            E -= (
                (E - e * math.sin(E) - mean) / (1.0 - e * math.cos(E))
                if e < 1.0
                else (e * math.sinh(E) - E - mean) / (e * math.cosh(E) - 1.0)
            )
        if e < 1.0:
            return (math.cos(E) - e) * along + math.sqrt(1.0 - e * e) * math.sin(E) * across
        return (e - math.cosh(E)) * along + math.sqrt(e * e - 1.0) * math.sinh(E) * across

    return [
        [quad(lambda s, i=i: place(s)[i], 0.0, t, epsabs=1e-13, epsrel=1e-13)[0] for i in range(3)]
        for t in (2.0, 5.0)
    ]


@pytest.mark.parametrize("eccentricity", [0.0, 0.6, 1.5])
@STEPS
def test_a_function_is_told_the_place_on_the_orbit(
    way: str, eccentricity: float, steps: Any
) -> None:
    orbit = rigid.Orbit(RATE, eccentricity, BEGIN, NORMAL, PERIAPSIS)
    torque = rigid.Torque.call(gathers, states=3)
    run = simulate(scene(torque, orbit=orbit), OMEGA, t=[2.0, 5.0], **steps)
    # The quadrature errs by 1e-13, dop853 by a rounding in each of 100 steps.
    assert np.abs(run.states - gathered(eccentricity)).max() < 1e-11


def test_a_torque_by_the_place_alone_needs_no_states(way: str) -> None:
    # The gradient torque of the orbit, taken away by the place: the body moves as if it were free.
    rate, moments = 0.3, np.array(BODY.moments)

    def pulls(
        t: float, omega: Any, attitude: Any, data: Any, torque: Any, orbit_position: Any
    ) -> None:
        w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
        a, b, c = orbit_position[0], orbit_position[1], orbit_position[2]
        r = math.sqrt(a * a + b * b + c * c)
        o1 = ((1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c) / r
        o2 = (2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c) / r
        o3 = (2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c) / r
        strength = -3.0 * data[0] ** 2 / r**3
        torque[0] = strength * (data[3] - data[2]) * o2 * o3
        torque[1] = strength * (data[1] - data[3]) * o3 * o1
        torque[2] = strength * (data[2] - data[1]) * o1 * o2

    torque = rigid.Torque.call(pulls, [rate, *moments])
    pulled = scene(torque, orbit=rigid.Orbit(rate, 0.3, 0.4, NORMAL, PERIAPSIS))
    run = simulate(pulled, OMEGA, t=[5.0, 20.0], accuracy=1e-10)
    free = simulate(BODY, OMEGA, t=[5.0, 20.0], method="exact")
    assert np.abs(run.omega - free.omega).max() < 1e-9
    assert np.abs(run.attitude - free.attitude).max() < 1e-9
    assert run.states is None


# A satellite: magnetic control beside the gravity gradient, and a wheel


def brakes(
    t: float,
    omega: Any,
    attitude: Any,
    data: Any,
    torque: Any,
    states: Any,
    rates: Any,
    orbit_position: Any,
) -> None:
    """B-dot in the field of a dipole along the space axis 3; a wheel about axis 2 runs up.

    Data: the field on the equator (T), the gain (A m² s/T), the momentum of the wheel (mN m s).
    """
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    a, b, c = orbit_position[0], orbit_position[1], orbit_position[2]
    f1, f2, f3 = -3.0 * c * a * data[0], -3.0 * c * b * data[0], (1.0 - 3.0 * c * c) * data[0]
    b1 = (1 - 2 * (y * y + z * z)) * f1 + 2 * (x * y + w * z) * f2 + 2 * (x * z - w * y) * f3
    b2 = 2 * (x * y - w * z) * f1 + (1 - 2 * (x * x + z * z)) * f2 + 2 * (y * z + w * x) * f3
    b3 = 2 * (x * z + w * y) * f1 + 2 * (y * z - w * x) * f2 + (1 - 2 * (x * x + y * y)) * f3
    # The moment is -k B', and a field that is fixed in space changes in the body by B x omega.
    m1 = -data[1] * (b2 * omega[2] - b3 * omega[1])
    m2 = -data[1] * (b3 * omega[0] - b1 * omega[2])
    m3 = -data[1] * (b1 * omega[1] - b2 * omega[0])
    rates[0] = (data[2] - states[0]) / 1000.0
    momentum, motor = 1e-3 * states[0], 1e-3 * rates[0]
    torque[0] = m2 * b3 - m3 * b2 + omega[2] * momentum
    torque[1] = m3 * b1 - m1 * b3 - motor
    torque[2] = m1 * b2 - m2 * b1 - omega[0] * momentum


SLOW_ORBIT = rigid.Orbit(1.107e-3, normal=(0.0, -0.6, 0.8))
SATELLITE, TUMBLING = np.array([0.04, 0.05, 0.03]), np.array([0.02, -0.03, 0.05])
FIELD_GAIN_WHEEL, LATER = (2.4e-5, 2e4, 2.0), np.array([0.0, 500.0, 1500.0])


@cache
def braked_by_scipy() -> Any:
    rate, normal, periapsis = SLOW_ORBIT.rate, SLOW_ORBIT.normal, np.array(SLOW_ORBIT.periapsis)

    def acting(t: float, omega: Any, q: Any, states: Any) -> Any:
        place = math.cos(rate * t) * periapsis + math.sin(rate * t) * cross(normal, periapsis)
        torque, rates = np.empty(3), np.empty(1)
        brakes(t, omega, q, FIELD_GAIN_WHEEL, torque, states, rates, place)
        o = to_body(q, place)
        return torque + 3.0 * rate**2 * cross(o, SATELLITE * o), rates

    return with_states(SATELLITE, acting, [TUMBLING, TILTED, [0.0]], LATER)


def test_magnetic_control_beside_the_gradient_and_a_wheel_moves_as_by_scipy(way: str) -> None:
    torque = rigid.Torque.call(brakes, FIELD_GAIN_WHEEL, states=1)
    satellite = rigid.FreeBody(rigid.Body(SATELLITE), torque=torque, orbit=SLOW_ORBIT)
    run, truth = simulate(satellite, TUMBLING, TILTED, t=LATER, accuracy=1e-10), braked_by_scipy()
    # SciPy errs by 1e-11 after 80 rad.
    assert np.abs(run.omega - truth[:, :3]).max() < 1e-9 * np.linalg.norm(TUMBLING)
    sign = np.sign((run.attitude * truth[:, 3:7]).sum(axis=1, keepdims=True))
    assert np.abs(run.attitude - sign * truth[:, 3:7]).max() < 1e-9
    assert np.abs(run.states - truth[:, 7:]).max() < 1e-9 * FIELD_GAIN_WHEEL[2]
    # It brakes, and the wheel approaches its momentum as an exponential.
    assert np.linalg.norm(run.omega[-1]) < 0.7 * np.linalg.norm(TUMBLING)
    wheel = -FIELD_GAIN_WHEEL[2] * np.expm1(-LATER / 1000.0)
    assert np.abs(run.states[:, 0] - wheel).max() < 1e-9


# Maps


def judged_by_wheel(states: Any) -> Any:
    """Whether the third wheel has stayed below a limit."""
    return (np.abs(states.states[:, :, 2]) < 0.9).all(axis=1)


def test_a_map_judges_the_states_of_wheels(tmp_path: Path) -> None:
    times = np.linspace(0.0, 20.0, 41)
    result = rigid.stability_map(
        scene(rigid.Torque.call(wheels, GAINS, states=6)),
        axes={"spin": [0.1, 0.4, 0.8]},
        start=rigid.Start(spin=0.1, axis=3, noise=rigid.normal(0.02), states=STARTS),
        stable=rigid.judged(judged_by_wheel, times),
        samples=6,
        rng=4,
        progress=False,
    )
    counts = []
    for pixel in range(3):
        starts = result.starts(np.arange(6), pixel=pixel)
        run = simulate(
            scene(), starts.omega, starts.attitude, states=STARTS, t=times, accuracy=1e-9
        )
        counts.append(int((np.abs(run.states[..., 2]) < 0.9).all(axis=-1).sum()))
    assert result.stable.tolist() == counts
    assert 0 < sum(counts) < 18
    assert result.spec.start.describe().endswith("states (0.1, 0, -0.2, 0, 0, 0)")
    again = rigid.Start.from_dict(result.spec.start.to_dict())
    assert again == result.spec.start
    # A file has no function: the scene that is given again begins at the states of the start.
    path = result.save(tmp_path / "map.npz")
    loaded = rigid.load_map(path, scene=scene(), stable=judged_by_wheel)
    replayed: Any = loaded.replay(1, 0).run
    assert np.array_equal(replayed.states[0], STARTS)
    other = scene(rigid.Torque.call(wheels, (0.1, 1.2, 0.3), states=6))
    with pytest.raises(ValueError, match="scene: differs from the scene of the map"):
        rigid.load_map(path, scene=other)


def test_a_criterion_of_rates_sees_bodies_with_wheels() -> None:
    # The controller stops each body; a Runge-Kutta run tells which has been slow by then.
    asked = rigid.Torque.call(wheels, GAINS, states=6, fastest=4.0)
    result = rigid.stability_map(
        scene(asked),
        axes={"spin": [0.2, 0.5, 0.8]},
        start=rigid.Start(spin=0.2, axis=3, noise=rigid.normal(0.1), states=STARTS),
        stable=~rigid.spin_above(0.15, axis=3),
        t_end=3.0,
        samples=8,
        rng=4,
        progress=False,
    )
    fine = np.linspace(0.0, 3.0, 3001)
    for pixel in range(3):
        starts = result.starts(np.arange(8), pixel=pixel)
        run = simulate(scene(), starts.omega, starts.attitude, states=STARTS, t=fine, accuracy=1e-8)
        slow = (run.omega[..., 2] < 0.15).any(axis=-1)
        assert result.stable[pixel] == slow.sum()
    assert 0 < result.stable.sum() < 24


# What is refused


test_states_that_no_function_has_are_refused = refuses(
    [
        ({"states": 9}, "states = 9: must lie in 0 to 8"),
        ({"states": -1}, "states = -1: must lie in 0 to 8"),
        ({"states": 1.0}, TypeError, r"states = 1\.0: must be a whole number"),
        ({"states": 0}, TypeError, r"must take \(t, omega, attitude, data, torque\), or be"),
    ],
    by=lambda given: rigid.Torque.call(wheels, GAINS, **given),
)


def test_a_function_of_other_arguments_is_refused() -> None:
    def short(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None: ...

    with pytest.raises(TypeError, match=r"torque, states, rates\), or be the address"):
        rigid.Torque.call(short, states=1)
    with pytest.raises(TypeError, match=r"must take \(double(, double \*){7}\) and return nothing"):
        rigid.Torque.call(SHORT(short), states=1)
    torque = rigid.Torque.call(gathers, states=3)
    with pytest.raises(ValueError, match="orbit_position: the function takes it, but the scene"):
        simulate(scene(torque), OMEGA, t=[1.0])


def test_starts_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match=r"states: expected shape \(\.\.\., 6\), got \(2,\)"):
        simulate(scene(), OMEGA, states=[0.0, 0.0], t=[1.0])
    for body in (rigid.FreeBody(BODY), rigid.FreeBody(BODY, torque=rigid.Torque.body((0, 0, 1)))):
        with pytest.raises(ValueError, match=r"states: the scene has none; give Torque\.call"):
            simulate(body, OMEGA, states=[0.0], t=[1.0])
    with pytest.raises(ValueError, match="the axes of the bodies do not broadcast"):
        simulate(scene(), np.zeros((2, 3)), states=np.zeros((3, 6)), t=[1.0])
    with pytest.raises(ValueError, match="name = 'state7': the scene has 6 states"):
        simulate(scene(), OMEGA, t=[1.0], events=rigid.crosses("state7", 1.0))
    with pytest.raises(ValueError, match="'midpoint': does not integrate the states of a function"):
        simulate(scene(), OMEGA, t=[1.0], method="midpoint", step=0.1)
    with pytest.raises(ValueError, match="states = 6: a motion carries none; use simulate"):
        rigid.Motion(scene(), OMEGA, method="dop853")
    starts = [rigid.Start(spin=1.0, states=(k,)) for k in (0.0, 1.0)]
    asked: dict[str, Any] = {
        "axes": {"spin": [1.0]},
        "t_end": 1.0,
        "stable": rigid.no_flip(),
        "samples": 2,
    }
    with pytest.raises(ValueError, match="states: must be the same in all starts of the mixture"):
        rigid.stability_map(scene(), start=rigid.mixture(starts), **asked)
    with pytest.raises(ValueError, match="states: are not given to scenes that a function makes"):
        rigid.stability_map(
            made_of_gain,
            start=rigid.Start(omega=(0.0, 0.0, 0.0), states=STARTS),
            **{**asked, "axes": {"gain": [1.0]}},
        )


def test_a_rate_that_is_not_written_ends_the_body(no_numba: None) -> None:
    def forgets(
        t: float, omega: Any, attitude: Any, data: Any, torque: Any, states: Any, rates: Any
    ) -> None:
        torque[0] = torque[1] = torque[2] = 0.0
        rates[0] = 1.0

    forgetful = scene(rigid.Torque.call(forgets, states=2))
    ways: list[dict[str, Any]] = [{}, {"method": "rk4", "step": 0.1}]
    for steps in ways:
        assert simulate(forgetful, OMEGA, t=[1.0], **steps).status == rigid.Status.NOT_FINITE
