"""Events of functions: quantities that have a name, and such that only their equations tell."""

import importlib.util
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from physics import present
from refusals import refuses

pytestmark = pytest.mark.filterwarnings("ignore:event = ")

BODY = rigid.Body((1.0, 1.6, 0.7))
OMEGA, ATTITUDE = [0.5, 0.8, -1.1], [0.9, 0.3, 0.2, 0.1]
UNTIL = 30.0
SAME = 1e-12
"""Two functions of the same states differ by rounding: 1e-16 over slopes that exceed 1e-2, with
the rounding of polynomials of degree 26."""


def braked(
    t: float, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rates: Any
) -> None:
    """A wheel that takes up momentum."""
    torque[0], torque[1], torque[2] = -0.02 * omega[0], 0.01, -0.05 * omega[2]
    rates[0] = 0.05 * omega[2] - 0.3 * own[0]


SCENES = {
    "free": rigid.FreeBody(BODY),
    "lagrange": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.2),
    "top": rigid.HeavyTop(BODY, mgl=1.2, com=(0.6, 0.0, 0.8)),
    "damped": rigid.FreeBody(BODY, damping=0.02, orbit=rigid.Orbit(0.7, 0.3, 0.4)),
    "flyby": rigid.FreeBody(BODY, orbit=rigid.Orbit(0.7, 1.5, -9.0)),
    "function": rigid.FreeBody(BODY, torque=rigid.Torque.call(braked, states=1)),
}


def spin(t: float, omega: Any, attitude: Any) -> float:
    third: float = omega[2]
    return third


def speed(t: float, omega: Any, attitude: Any) -> float:
    size: float = (omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2) ** 0.5
    return size


def vertical(t: float, omega: Any, attitude: Any) -> float:
    first: float = 2.0 * (attitude[1] * attitude[3] - attitude[0] * attitude[2])
    return first


def found(scene: Any, *events: rigid.Event, **asked: Any) -> list[rigid.Events]:
    return list(rigid.simulate(scene, OMEGA, ATTITUDE, t=[UNTIL], events=events, **asked).events)


def same(of_function: rigid.Events, named: rigid.Events, scale: float = 1.0) -> None:
    """The same events, whose quantities have slopes of this ratio."""
    assert len(named) > 0
    assert np.array_equal(of_function.direction, named.direction)
    np.testing.assert_allclose(of_function.t, named.t, rtol=SAME)
    np.testing.assert_allclose(of_function.omega, named.omega, rtol=0.0, atol=4.0 * SAME)
    np.testing.assert_allclose(of_function.slope * scale, named.slope, rtol=1e-8, atol=1e-9)
    assert of_function.complete == named.complete


@pytest.mark.parametrize("name", SCENES)
def test_a_quantity_with_a_name_happens_when_its_function_says(name: str, way: str) -> None:
    scene = SCENES[name]
    states = rigid.simulate(scene, OMEGA, ATTITUDE, t=np.linspace(0.0, UNTIL, 500))
    level = float(np.median(np.linalg.norm(states.omega, axis=-1)))
    pairs = [
        (rigid.crosses(spin, 0.2), rigid.crosses("omega3", 0.2)),
        (rigid.crosses(speed, level, -1), rigid.crosses("speed", level, -1)),
        (rigid.crosses(vertical, 0.1, 1), rigid.crosses("gamma1", 0.1, 1)),
    ]
    events = found(scene, *(event for pair in pairs for event in pair))
    met = 0
    for first, second in zip(events[::2], events[1::2], strict=True):
        if len(second):
            same(first, second)
            met += 1
    assert met >= 2


def test_the_state_of_a_function_is_seen_by_another(way: str) -> None:
    def wheel(t, omega, attitude, states):  # type: ignore[no-untyped-def]
        return 2.0 * states[0] - 0.1

    events = found(SCENES["function"], rigid.crosses(wheel), rigid.crosses("state1", 0.05))
    same(events[0], events[1], scale=0.5)


def test_a_body_is_as_far_as_the_semi_major_axis_when_keplers_equation_says(no_numba: None) -> None:
    """The distance is 1 - e cos E, so one at E = 90 degrees, when the mean anomaly is 90° - e."""
    rate, e = 0.7, 0.3

    def distance(t, omega, attitude, orbit_position):  # type: ignore[no-untyped-def]
        x, y, z = orbit_position
        return (x * x + y * y + z * z) ** 0.5

    scene = rigid.FreeBody(BODY, orbit=rigid.Orbit(rate, e))
    (event,) = found(scene, rigid.crosses(distance, 1.0))
    away = (0.5 * np.pi - e) / rate
    period = 2.0 * np.pi / rate
    exact = np.sort(np.concatenate([away + period * np.arange(4), period * np.arange(1, 5) - away]))
    np.testing.assert_allclose(event.t, exact[exact < UNTIL], rtol=SAME)
    assert event.direction.tolist() == [1, -1] * 3 + [1] * (len(event) - 6)


def test_a_quantity_without_a_name_crosses_as_by_scipy(way: str) -> None:
    """The power of weight on an asymmetric top, less a ramp in time: no event of the library."""
    mgl, com, moments = 1.2, np.array([0.6, 0.0, 0.8]), np.array(BODY.moments)

    def power(t, omega, attitude):  # type: ignore[no-untyped-def]
        w, x, y, z = attitude
        g1, g2, g3 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        lever = 0.8 * g1 - 0.6 * g3
        return omega[0] * -0.8 * g2 + omega[1] * lever + omega[2] * 0.6 * g2 - 0.01 * t

    def motion(t: float, y: Any) -> Any:
        omega, gamma = y[:3], y[3:]
        torque = mgl * np.cross(gamma, com)
        rates = (torque - np.cross(omega, moments * omega)) / moments
        return [*rates, *np.cross(gamma, omega)]

    def crossed(t: float, y: Any) -> float:
        (a, b, c), (g1, g2, g3) = y[:3], y[3:]
        return float(-a * 0.8 * g2 + b * (0.8 * g1 - 0.6 * g3) + c * 0.6 * g2 - 0.01 * t)

    (event,) = found(SCENES["top"], rigid.crosses(power))
    gamma = rigid.rotations.quaternion_to_matrix(np.array(ATTITUDE) / np.linalg.norm(ATTITUDE))[2]
    made = solve_ivp(
        motion, (0.0, UNTIL), [*OMEGA, *gamma], "DOP853", events=crossed, rtol=3e-14, atol=1e-15
    )
    assert len(event) > 10
    # SciPy's steps and polynomials err by some 1e-11; the motion magnifies it until the end.
    np.testing.assert_allclose(event.t, made.t_events[0], rtol=0.0, atol=1e-9)
    assert event.complete
    assert np.all(event.error < 1e-9)


def test_the_stated_error_bounds_that_of_legendres_time() -> None:
    """A free body in closed form: its rates and their zeros are known to rounding."""
    body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    start = np.random.default_rng(4).normal(size=(40, 3))
    events = [rigid.crosses(spin), rigid.crosses("omega3")]
    own, named = rigid.simulate(body, start, t=[50.0], events=events).events
    assert np.array_equal(own.body, named.body)
    assert len(own) > 100
    assert np.all(np.abs(own.t - named.t) <= own.error + named.error)
    assert np.all(own.error < 1e-9)


def test_a_record_ends_where_a_function_says(no_numba: None) -> None:
    """Damping with the rate 0.1 halves the energy after ln 2 / 0.2."""

    def energy(t, omega, attitude):  # type: ignore[no-untyped-def]
        return 0.5 * omega[2] ** 2

    body = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)), damping=0.1)
    starts = np.array([[0.0, 0.0, 2.0**0.5], [0.0, 0.0, 2.0]])
    run = rigid.simulate(body, starts, t=[0.0, 1.0, 5.0, 20.0], until=rigid.crosses(energy, 0.5))
    exact = np.log([2.0, 4.0]) / 0.2
    np.testing.assert_allclose(present(run.end), exact, rtol=SAME)
    assert np.array_equal(run.status, [rigid.Status.STOPPED] * 2)
    assert np.isnan(run.omega[:, 3]).all()
    assert not np.isnan(run.omega[1, 2]).any()


def test_corners_and_jumps_are_found_where_the_sign_changes(no_numba: None) -> None:
    """A limit switch of the third rate, and the distance of its size from a value."""

    def switch(t, omega, attitude):  # type: ignore[no-untyped-def]
        return 1.0 if omega[2] > 0.2 else -1.0

    def corner(t, omega, attitude):  # type: ignore[no-untyped-def]
        return abs(omega[2]) - 0.2

    def bend(t, omega, attitude):  # type: ignore[no-untyped-def]
        return max(omega[2] - 0.2, 3.0 * (omega[2] - 0.2))

    functions: list[Callable[..., float]] = [switch, corner, bend]
    events = [rigid.crosses("omega3", value) for value in (0.2, -0.2)]
    jumped, cornered, bent, *named = found(SCENES["top"], *map(rigid.crosses, functions), *events)
    np.testing.assert_allclose(jumped.t, named[0].t, rtol=SAME)
    assert np.array_equal(jumped.direction, named[0].direction)
    assert np.isnan(jumped.slope).all()
    assert np.isnan(jumped.error).all()
    assert np.isinf(jumped.lost_from)
    both = np.sort(np.concatenate([one.t for one in named]))
    np.testing.assert_allclose(cornered.t, both, rtol=SAME)
    same(cornered.of(0), cornered)
    np.testing.assert_allclose(bent.t, named[0].t, rtol=SAME)


def test_a_function_that_has_its_value_all_along_crosses_nothing(no_numba: None) -> None:
    def still(t, omega, attitude):  # type: ignore[no-untyped-def]
        return 0.7

    (event,) = found(SCENES["top"], rigid.crosses(still, 0.7))
    assert len(event) == 0
    assert not event.complete


def test_what_a_function_raises_is_raised_and_no_number_ends_the_body() -> None:
    def lost(t, omega, attitude):  # type: ignore[no-untyped-def]
        return np.nan if t > 1.0 else 1.0

    def raises(t, omega, attitude):  # type: ignore[no-untyped-def]
        raise LookupError("no such star")

    run = rigid.simulate(SCENES["top"], OMEGA, ATTITUDE, t=[UNTIL], events=rigid.crosses(lost))
    assert not run.events[0].complete
    warns = pytest.warns(UserWarning, match="event = .*raises")
    has_numba = importlib.util.find_spec("numba") is not None
    with warns if has_numba else nullcontext(), pytest.raises(LookupError, match="no such star"):
        found(SCENES["top"], rigid.crosses(raises))


def test_files_keep_events_but_no_function(tmp_path: Path) -> None:
    run = rigid.simulate(SCENES["top"], OMEGA, ATTITUDE, t=[UNTIL], events=rigid.crosses(spin, 0.2))
    again = rigid.load_run(run.save(tmp_path / "run.npz"))
    event = again.events[0].event
    assert np.array_equal(again.events[0].t, run.events[0].t)
    assert event.words() == run.events[0].event.words() == "spin() = 0.2, both ways"
    with pytest.raises(ValueError, match=r"events: no file has the function spin\(\); give it"):
        found(SCENES["top"], event)


def no_state(t: float, omega: Any, attitude: Any, states: Any) -> float:
    return float(states[0])


def no_place(t: float, omega: Any, attitude: Any, orbit_position: Any) -> float:
    return float(orbit_position[0])


test_what_no_function_can_be_is_refused = refuses(
    [
        (lambda: rigid.crosses(lambda t: t), TypeError, r"must take \(t, omega, attitude\), or"),
        (lambda: rigid.crosses(len, 1.0), TypeError, "must take"),
        (lambda: rigid.crosses(spin, axis=1), "axis = 1: belongs to pointing"),
        (lambda: rigid.crosses(spin, omega=[1, 0, 0]), "leave the name out"),
        (lambda: rigid.crosses(spin, np.inf), "value = inf"),
        (lambda: rigid.turns(cast(Any, spin)), "has no known rate; let rigid.crosses find"),
        (lambda: found(SCENES["top"], rigid.crosses(no_state)), "states: no_state"),
        (lambda: found(SCENES["top"], rigid.crosses(no_place)), "no orbit"),
        (
            lambda: found(SCENES["top"], rigid.crosses(spin), frame=np.eye(3)),
            "frame: the function of an event is told principal axes",
        ),
    ],
)
