"""Moving frames: Newton's law in them, Foucault's pendulum, the fall to the east."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from physics import ROUNDOFF, Floats, derivative
from refusals import refuses
from rigid import frames

#: A frame in any motion: axes turned by Rz(a) Rx(b), the origin on a curve.
TIME, STEP = 0.37, 1e-3


def axes(t: float) -> Floats:
    """Rotation from the frame to space."""
    angles = [0.4 + 0.9 * t + 0.3 * np.sin(t), 0.7 * t * t]
    return np.asarray(Rotation.from_euler("ZX", angles).as_matrix())


def origin(t: float) -> Floats:
    return np.array([3.0 + np.sin(t), -2.0 * t, 1.0 + t**3])


def seen(t: float) -> Floats:
    """Coordinates of a point in the frame."""
    return np.array([1.0 + 0.2 * t, 0.5 - 0.1 * t * t, np.cos(0.3 * t)])


def rate(t: float) -> Floats:
    """Angular velocity of the frame, in space, from ``R' R.T``."""
    spin = derivative(axes, t, STEP) @ axes(t).T
    return np.array([spin[2, 1], spin[0, 2], spin[1, 0]])


def in_space(t: float) -> Floats:
    return origin(t) + axes(t) @ seen(t)


FRAME: dict[str, Any] = {
    "omega": rate(TIME),
    "omega_dot": derivative(rate, TIME, STEP),
    "origin": origin(TIME),
    "origin_velocity": derivative(origin, TIME, STEP),
    "origin_acceleration": derivative(origin, TIME, STEP, 2),
}


def state(function: Callable[[float], Floats], turn: Any = None) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and acceleration, turned from the frame to space if asked."""
    values = [function(TIME), derivative(function, TIME, STEP), derivative(function, TIME, STEP, 2)]
    x, v, a = values if turn is None else [turn @ value for value in values]
    return x, v, a


def test_a_motion_seen_from_a_frame_and_back() -> None:
    truth, own = state(in_space), state(seen, axes(TIME))
    there = frames.rotating_frame(*truth, **FRAME)
    found = [there.position, there.velocity, there.acceleration]
    for value, expected, tolerance in zip(found, own, (1e-14, 1e-10, 1e-7), strict=True):
        np.testing.assert_allclose(value, expected, atol=tolerance)
    here = frames.rotating_frame(*found, **FRAME, back=True)
    for value, expected in zip(
        (here.position, here.velocity, here.acceleration), truth, strict=True
    ):
        np.testing.assert_allclose(value, expected, atol=64 * ROUNDOFF * 10)


def test_the_arm_is_that_from_the_origin_of_the_frame() -> None:
    """Printed with the whole position, the velocity misses by several times its size."""
    r, v, _ = state(in_space)
    there = frames.rotating_frame(r, v, **FRAME)
    printed = v - FRAME["origin_velocity"] - np.cross(FRAME["omega"], r)
    assert np.linalg.norm(printed - there.velocity) > 2.0 * np.linalg.norm(there.velocity)


def test_without_turning_only_the_origin_is_taken_away() -> None:
    only = {name: value for name, value in FRAME.items() if name.startswith("origin")}
    truth = state(in_space)
    there = frames.translating_frame(*truth, **only)
    assert np.array_equal(there.position, truth[0] - only["origin"])
    assert np.array_equal(there.velocity, truth[1] - only["origin_velocity"])
    assert np.array_equal(there.acceleration, truth[2] - only["origin_acceleration"])
    back = frames.translating_frame(
        there.position, there.velocity, there.acceleration, **only, back=True
    )
    np.testing.assert_allclose(back.position, truth[0], atol=4 * ROUNDOFF * 5)
    np.testing.assert_allclose(back.acceleration, truth[2], atol=4 * ROUNDOFF * 5)
    # Newton's law with the force -m A: a spring's force, seen from both.
    force = 2.0 * truth[2]
    shift = frames.fictitious_forces(2.0, acceleration=only["origin_acceleration"]).translation
    np.testing.assert_allclose(2.0 * there.acceleration, force + shift, atol=16 * ROUNDOFF * 10)


def test_transport_of_any_vector() -> None:
    truth = derivative(lambda t: axes(t) @ seen(t), TIME, STEP)
    own = axes(TIME) @ derivative(seen, TIME, STEP)
    q = axes(TIME) @ seen(TIME)
    found = frames.transport(q, own, FRAME["omega"])
    np.testing.assert_allclose(found, truth, atol=1e-10)
    np.testing.assert_allclose(frames.transport(q, found, -FRAME["omega"]), own, atol=1e-14)
    # That of the angular velocity is the same in both frames.
    own_rate = axes(TIME) @ derivative(lambda t: axes(t).T @ rate(t), TIME, STEP)
    np.testing.assert_allclose(own_rate, FRAME["omega_dot"], atol=1e-7)
    change = frames.transport(FRAME["omega"], own_rate, FRAME["omega"])
    assert np.array_equal(change, own_rate)


def test_an_axis_of_the_frame_turns_about_the_others() -> None:
    # A turn about e2 moves e1 towards -e3, not along e1 itself.
    assert frames.transport([1, 0, 0], [0, 0, 0], [0, 1, 0]).tolist() == [0.0, 0.0, -1.0]


def integrated(
    start: Floats, t: float, force: Callable[[Floats, Floats, float], Floats]
) -> tuple[Floats, Floats]:
    """Position and velocity in a frame, of a mass of 1 kg."""

    def change(now: float, both: Floats) -> Floats:
        return np.concatenate([both[3:], force(both[:3], both[3:], now)])

    path = solve_ivp(change, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-13)
    assert path.success
    return path.y[:3, -1], path.y[3:, -1]


def test_a_free_particle_is_straight_while_the_frame_bends_its_path() -> None:
    """Along the turning axes; a frame that turns faster and faster, its origin thrown upwards."""
    omega0, growth = np.array([0.0, 0.0, 0.8]), np.array([0.0, 0.0, 0.6])
    throw = np.array([0.3, -0.2, 1.5])

    def turn(t: float) -> Floats:
        return np.asarray(Rotation.from_rotvec([0.0, 0.0, 0.8 * t + 0.3 * t * t]).as_matrix())

    def force(r: Floats, v: Floats, t: float) -> Floats:
        return frames.fictitious_forces(
            1.0, r, v, omega=omega0 + growth * t, omega_dot=growth, acceleration=turn(t).T @ throw
        ).total

    r0, v0 = np.array([1.0, -0.4, 0.2]), np.array([0.1, 0.7, -0.5])
    own = frames.rotating_frame(r0, v0, omega=omega0)
    t = 4.0
    r, v = integrated(np.concatenate([own.position, own.velocity]), t, force)
    seen_at_rest = turn(t) @ r + 0.5 * throw * t * t
    np.testing.assert_allclose(seen_at_rest, r0 + v0 * t, atol=1e-10)
    carried = np.cross(omega0 + growth * t, turn(t) @ r)
    np.testing.assert_allclose(turn(t) @ v + carried + throw * t, v0, atol=1e-10)
    # Each of them is needed.
    forces = frames.fictitious_forces(1.0, r, v, omega=omega0, omega_dot=growth, acceleration=throw)
    for name in ("translation", "coriolis", "centrifugal", "euler"):
        assert np.linalg.norm(getattr(forces, name)) > 0.1


def test_forces_of_a_frame_at_rest_are_zero() -> None:
    forces = frames.fictitious_forces(3.0, [1, 2, 3], [4, 5, 6])
    assert forces.total.tolist() == [0.0, 0.0, 0.0]
    many = frames.fictitious_forces([1.0, 2.0], np.ones((5, 1, 3)), omega=[0, 0, 1])
    assert many.centrifugal.shape == (5, 2, 3)
    assert many.centrifugal[0, 1].tolist() == [2.0, 2.0, 0.0]
    assert frames.fictitious_forces(1.0, np.zeros((0, 3))).total.shape == (0, 3)


@pytest.mark.parametrize("degrees", [-70.0, 0.0, 48.85])
def test_foucaults_pendulum_turns_with_the_sine_of_the_latitude(degrees: float) -> None:
    # A fast planet, so that the turn is large: 0.01 rad/s against a swing of 2 rad/s.
    latitude, swing, spin = np.radians(degrees), 2.0, 0.01
    place = frames.earth_frame(latitude, rate=spin, radius=0.0)
    omega = place.omega

    def force(r: Floats, v: Floats, t: float) -> Floats:
        # A small swing is harmonic in the plane of the horizon, which holds the height.
        total = frames.fictitious_forces(1.0, r, v, omega=omega).coriolis - swing**2 * r
        return np.asarray(total * [1.0, 1.0, 0.0])

    # Let go at rest in a frame that turns with the plane, it goes through the middle every time:
    # r'' = -W² r - 2 w × r' has x + i y = exp(-i w t) cos(sqrt(W² + w²) t), w = spin sin(latitude).
    vertical = spin * np.sin(latitude)
    frequency = np.hypot(swing, vertical)
    t = 10 * np.pi / frequency
    start = np.array([1.0, 0.0, 0.0, 0.0, -vertical, 0.0])
    r, _ = integrated(start, t, force)
    assert np.arctan2(r[1], r[0]) == pytest.approx(-vertical * t, abs=1e-9)
    assert np.hypot(r[0], r[1]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("degrees", [-35.0, 0.0, 50.0])
def test_what_falls_is_carried_to_the_east(degrees: float) -> None:
    g, t = 9.81, 5.0
    place = frames.earth_frame(np.radians(degrees))

    def force(r: Floats, v: Floats, _: float) -> Floats:
        return frames.fictitious_forces(1.0, r, v, omega=place.omega).total - [0.0, 0.0, g]

    r, _ = integrated(np.zeros(6), t, force)
    east = g * frames.EARTH_RATE * t**3 * np.cos(np.radians(degrees)) / 3.0
    # The next order is (rate t)² = 1.3e-7 of it, to the east; to the south it is g rate² t⁴ / 6 at
    # most, 3e-8 of the height.
    assert r[0] == pytest.approx(east, rel=1e-6)
    assert abs(r[1]) < g * frames.EARTH_RATE**2 * t**4
    # Seen at rest, the weight turns with the Earth.
    turn = Rotation.from_rotvec(place.omega * t)

    def turning_weight(r: Floats, v: Floats, now: float) -> Floats:
        return np.asarray(Rotation.from_rotvec(place.omega * now).apply([0.0, 0.0, -g]))

    there, _ = integrated(np.zeros(6), t, turning_weight)
    np.testing.assert_allclose(turn.inv().apply(there), r, atol=1e-9)


def test_the_observer_on_the_earth_turns_about_its_axis() -> None:
    places = frames.earth_frame(np.radians([0.0, 30.0, -90.0]))
    np.testing.assert_allclose(np.linalg.norm(places.omega, axis=-1), frames.EARTH_RATE)
    # 3.4 cm/s² at the equator, towards the centre; nothing at the poles.
    assert places.acceleration[0, 2] == pytest.approx(-(frames.EARTH_RATE**2) * 6.371e6)
    assert np.abs(places.acceleration[2]).max() < 1e-17
    # At 30 degrees north it points into the axis: rate² R cos(30°), up by -cos, north by +sin.
    size = frames.EARTH_RATE**2 * 6.371e6 * np.cos(np.radians(30))
    expected = size * np.array([0.0, 0.5, -np.cos(np.radians(30))])
    np.testing.assert_allclose(places.acceleration[1], expected, rtol=1e-14, atol=1e-17)


NAN = float("nan")
REFUSED: list[tuple[Any, ...]] = [
    (
        lambda: frames.translating_frame([1, 2], [0, 0, 0], [0, 0, 0]),
        "position: expected shape (..., 3), got (2,)",
    ),
    (
        lambda: frames.rotating_frame([1, 2, 3], [0, NAN, 0], omega=[0, 0, 1]),
        "velocity[1] = nan: must be finite",
    ),
    (
        lambda: frames.transport(np.ones((2, 3)), np.ones((4, 3)), [0, 0, 1]),
        "vector (2, 3), rate (4, 3), omega (3,): the shapes do not broadcast",
    ),
    (lambda: frames.fictitious_forces(-1.0), "mass = -1.0: must not be negative"),
    (lambda: frames.fictitious_forces([1.0, 2.0], np.ones((3, 3))), "mass (2, 1), position (3, 3)"),
    (lambda: frames.earth_frame(48.85), "latitude = 48.85: must lie in [-pi/2, pi/2] (rad)"),
    (lambda: frames.earth_frame(NAN), "latitude = nan: must be finite"),
    (lambda: frames.earth_frame(1.0, radius=-1.0), "radius = -1.0: must not be negative"),
    (lambda: frames.earth_frame(1.0, rate=NAN), "rate = nan: must be finite"),
]


test_refusals_name_the_argument_and_the_rule = refuses(REFUSED, literal=True)
