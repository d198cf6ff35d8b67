"""When a body axis reaches an angle from a direction, and when roll, pitch and yaw reach a value.

Truths: events of SciPy's integration of the equations of motion, which are written down once more
here, and closed forms.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipkinc

import rigid
from physics import Floats, cross, place_on_orbit
from printed_equations import printed, starting
from refusals import refuses

BODY = (1.0, 1.6, 0.7)
OMEGA, ATTITUDE = (0.5, 0.8, -1.1), (0.9, 0.3, 0.2, 0.1)
UNTIL = 12.0
LATE = 1e-10
"""SciPy's states at a tolerance of 1e-13 are good to some 1e-12 here, and slopes exceed 2e-2."""

SOON = 1e-7
"""After a crossing the quantity has moved by more than its error, and is far from a turn."""

IN_SPACE = np.array([1.0, 2.0, -0.5])
ANGLES = ("roll", "pitch", "yaw")


@cache
def frame_of(orbit: rigid.Orbit, t: float) -> Floats:
    """The columns radial, along and normal, from the place alone."""
    place = place_on_orbit(orbit, t)
    radial, normal = place / np.linalg.norm(place), np.array(orbit.normal)
    return np.stack([radial, cross(normal, radial), normal], axis=-1)


def quantity(event: rigid.Event, orbit: rigid.Orbit | None, t: float, matrix: Floats) -> float:
    """What the event watches at an attitude, less its value, from -pi to pi."""
    if event.name == "pointing":
        if isinstance(event.of, str):
            assert orbit is not None
            of = frame_of(orbit, t)[:, ["radial", "along", "normal"].index(event.of)]
        else:
            of = np.array(event.of)
        assert event.axis is not None
        axis = np.sign(event.axis) * matrix[:, abs(event.axis) - 1]
        return float(np.arctan2(np.linalg.norm(cross(axis, of)), axis @ of)) - event.value
    assert orbit is not None
    # A 3-2-1 sequence from rest, with the axes along, normal, radial.
    axes = frame_of(orbit, t)[:, [1, 2, 0]]
    at_rest = matrix[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]  # body axes 3, 1 at rest radial and normal
    yaw, pitch, roll = Rotation.from_matrix(axes.T @ at_rest).as_euler("ZYX")
    angle = {"roll": roll, "pitch": pitch, "yaw": yaw}[event.name] - event.value
    return float(np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi)


def true_events(
    events: list[rigid.Event], orbit: rigid.Orbit | None, torque: Any = None
) -> list[list[tuple[float, int]]]:
    """Times and directions of the events by SciPy."""
    scene = rigid.FreeBody(rigid.Body(BODY), orbit=orbit)
    called = None if torque is None else lambda t, omega, _: torque(t, omega)

    def function(event: rigid.Event) -> Any:
        # The leap of an angle from pi to -pi is none of a sine.
        return lambda t, y: float(np.sin(quantity(event, orbit, t, y[3:].reshape(3, 3))))

    found = solve_ivp(
        printed(scene, called),
        (0.0, UNTIL),
        starting(OMEGA, ATTITUDE),
        "DOP853",
        rtol=1e-13,
        atol=1e-15,
        max_step=0.05,
        events=[function(event) for event in events],
        dense_output=True,
    )
    every = []
    for event, times, states in zip(events, found.t_events, found.y_events, strict=True):
        # Of the zeros of the sine those of the angle; it rises where it is positive soon after.
        zeros = [
            float(t)
            for t, y in zip(times, states, strict=True)
            if np.cos(quantity(event, orbit, t, y[3:].reshape(3, 3))) > 0.0
        ]
        after = ((t + SOON, found.sol(t + SOON)[3:].reshape(3, 3)) for t in zeros)
        ways = [1 if quantity(event, orbit, *state) > 0.0 else -1 for state in after]
        every.append(list(zip(zeros, ways, strict=True)))
    return every


def damp(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -0.05 * omega[k]
    torque[1] += 0.3 * np.sin(t)


def damped(t: float, w: Floats) -> Any:
    return -0.05 * w + [0.0, 0.3 * np.sin(t), 0.0]


ORBITS = {
    "free": None,
    "circle": rigid.Orbit(0.7),
    "ellipse": rigid.Orbit(0.7, 0.6, 0.4, normal=(0.0, 0.6, 0.8), periapsis=(1.0, 0.0, 0.0)),
    "hyperbola": rigid.Orbit(0.7, 1.8, -4.0),
    "callback": rigid.Orbit(0.7, 0.3, 0.4),
}


@pytest.mark.parametrize("where", ORBITS)
def test_axes_point_where_the_equations_say(where: str) -> None:
    orbit = ORBITS[where]
    called = where == "callback"
    scene = rigid.FreeBody(
        rigid.Body(BODY), orbit=orbit, torque=rigid.Torque.call(damp) if called else None
    )
    events = [rigid.crosses("pointing", 1.0, axis=axis, of=IN_SPACE) for axis in (1, -3)]
    if orbit is not None:
        events += [
            rigid.crosses("pointing", 1.0, axis=axis, of=of)
            for axis, of in ((1, "radial"), (-2, "along"), (3, "normal"))
        ]
        events += [
            rigid.crosses(name, value, axes=(3, 1))
            for name, values in (
                ("roll", (0.3, -2.5, np.pi)),
                ("pitch", (0.2, -0.7)),
                ("yaw", (-2.0, 0.0, 0.8)),
            )
            for value in values
        ]
    truths = true_events(events, orbit, damped if called else None)
    assert sum(map(len, truths)) >= (4 if orbit is None else 15)
    # The default tolerance of a callback is 1e-12 of each step; of series it is rounding.
    late = 1e-8 if called else LATE
    for method in ("dop853",) if called else (None, "taylor16"):
        run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[0.0, UNTIL], events=events, method=method)
        for found, truth in zip(run.events, truths, strict=True):
            words = f"{method}: {found.event.words()}"
            assert bool(found.complete), words
            np.testing.assert_array_equal(found.direction, [way for _, way in truth], words)
            off = np.abs(found.t - [t for t, _ in truth])
            assert (off <= late).all(), f"{words}: {off}"
            assert (off <= found.error + LATE).all(), words


@pytest.mark.parametrize("name", ["pointing", *ANGLES])
def test_an_angle_turns_where_its_rate_is_zero(name: str) -> None:
    """Slopes and second derivatives are differences of the angle around each event."""
    orbit = rigid.Orbit(0.7, 0.3, 0.4)
    scene = rigid.FreeBody(rigid.Body(BODY), orbit=orbit)
    how: dict[str, Any] = {"axes": (3, 1)} if name in ANGLES else {"axis": -2, "of": "along"}
    turns, crosses = rigid.turns(name, **how), rigid.crosses(name, 0.4, **how)
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[0.0, UNTIL], events=[turns, crosses])
    step = 1e-3

    def angles(t: Floats) -> Floats:
        times = (t[:, np.newaxis] + step * np.arange(-2, 3)).ravel()
        around = rigid.simulate(scene, OMEGA, ATTITUDE, t=times, method="taylor20", check=False)
        assert around.attitude is not None
        every = [
            quantity(turns, orbit, t, rigid.rotations.quaternion_to_matrix(q))
            for t, q in zip(times, around.attitude, strict=True)
        ]
        angles = np.unwrap(np.reshape(every, (-1, 5)), axis=1)
        # The smooth functions whose slopes are told at turns.
        return {"pointing": -np.cos(angles), "pitch": np.sin(angles)}.get(name, angles)

    for found in run.events:
        assert len(found) >= 2
        assert bool(found.complete)
    # Differences of the fourth order err by some step^4 = 1e-12 of derivatives up to 1e2, and by
    # rounding over the step, 1e-12, or its square, 1e-9.
    before_last, before, now, after, after_next = angles(run.events[0].t).T
    slope = (8.0 * (after - before) - (after_next - before_last)) / (12.0 * step)
    bend = 16.0 * (after + before) - (after_next + before_last) - 30.0 * now
    bend /= 12.0 * step**2
    # The derivatives are large at a sharp turn, as that of pitch near pi/2, its time is well known.
    np.testing.assert_allclose(slope / bend, 0.0, atol=1e-8)
    np.testing.assert_allclose(run.events[0].slope, bend, rtol=1e-5, atol=1e-7)
    np.testing.assert_array_equal(run.events[0].direction, np.sign(bend))
    before_last, before, now, after, after_next = angles(run.events[1].t).T
    slope = (8.0 * (after - before) - (after_next - before_last)) / (12.0 * step)
    scale = {"pointing": np.sin(0.4), "pitch": np.cos(0.4)}.get(name, 1.0)
    # Near gimbal lock roll goes at 22 rad/s: 22^5 step^4 / 30 is some 3e-7 of this slope.
    np.testing.assert_allclose(run.events[1].slope * scale, slope, rtol=1e-6, atol=1e-8)


def test_a_body_that_spins_about_an_axis_points_by_its_angle() -> None:
    """Axis 1 is at the angle w t from where it began, folded into 0 to pi."""
    rate, angle = 0.8, 2.1
    run = rigid.simulate(
        rigid.FreeBody(rigid.Body(BODY)),
        [0.0, 0.0, rate],
        t=[0.0, 20.0],
        events=rigid.crosses("pointing", angle, axis=1, of=(3.0, 0.0, 0.0)),
    )
    (found,) = run.events
    expected = np.array([angle, 2 * np.pi - angle, 2 * np.pi + angle, 4 * np.pi - angle]) / rate
    expected = np.append(expected, (4 * np.pi + angle) / rate)
    np.testing.assert_allclose(found.t, expected, rtol=1e-14)
    assert found.direction.tolist() == [1, -1, 1, -1, 1]
    np.testing.assert_allclose(found.slope, rate * found.direction, rtol=1e-12)


def test_the_axis_of_a_steady_top_goes_round() -> None:
    """Axis 3 at the tilt b is at the angle acos(sin b cos(p t)) from the axis on which it began."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.2)
    tilt, precession, angle = 0.6, 0.4, 1.3
    # mgl = p (I3 w3 - I1 p cos b)
    spin = (1.2 / precession + precession * np.cos(tilt)) / 0.5
    attitude = rigid.rotations.euler_to_quaternion([0.0, tilt, 0.0])
    matrix = rigid.rotations.quaternion_to_matrix(attitude)
    omega = precession * matrix[2] + [0.0, 0.0, spin - precession * np.cos(tilt)]
    begin = matrix[:, 2] * [1.0, 1.0, 0.0]
    found = rigid.simulate(
        top,
        omega,
        attitude,
        t=[0.0, 20.0],
        events=rigid.crosses("pointing", angle, axis=3, of=begin),
    ).events[0]
    phase = np.arccos(np.cos(angle) / np.sin(tilt))
    expected = np.array([phase, 2 * np.pi - phase, 2 * np.pi + phase]) / precession
    np.testing.assert_allclose(found.t, expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ["moon", "satellite"])
def test_a_planar_libration_is_a_pendulum(kind: str) -> None:
    """Pitch obeys a'' = -k² sin(2 a) / 2 with k² = 3 n² (I_roll - I_yaw) / I_pitch."""
    n, roll, pitch, yaw, largest, angle = 0.9, 1.7, 2.2, 0.8, 1.1, 0.7
    swing = n * np.sqrt(3.0 * (roll - yaw) / pitch)
    # Axes 1, 2, 3 at rest along, normal, radial; or radial, along, normal. The defaults follow.
    satellite = kind == "satellite"
    moments = (roll, pitch, yaw) if satellite else (yaw, roll, pitch)
    attitude = (0.5, 0.5, 0.5, 0.5) if satellite else (1.0, 0.0, 0.0, 0.0)
    rates = n + swing * np.sin(largest)
    omega = (0.0, rates, 0.0) if satellite else (0.0, 0.0, rates)
    scene = rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(n))
    whole = 4.0 * ellipkinc(0.5 * np.pi, np.sin(largest) ** 2) / swing
    events = [rigid.crosses("pitch", angle), rigid.turns("pitch"), rigid.crosses("roll", 0.1)]
    run = rigid.simulate(scene, omega, attitude, t=[0.0, 1.2 * whole], events=events)
    crossed, turned, never = run.events
    phase = np.arcsin(np.sin(angle) / np.sin(largest))
    first = ellipkinc(phase, np.sin(largest) ** 2) / swing
    expected = [first, 0.5 * whole - first, whole + first]
    np.testing.assert_allclose(crossed.t, expected, rtol=1e-12)
    np.testing.assert_allclose(turned.t, [0.25 * whole, 0.75 * whole], rtol=1e-12)
    assert len(never) == 0
    assert bool(never.complete)
    same = rigid.crosses("pointing", angle, axis=3 if satellite else 1, of="radial")
    again = rigid.simulate(scene, omega, attitude, t=[0.0, 1.2 * whole], until=[same], count=4)
    expected = sorted([*expected[:2], 0.5 * whole + first, whole - first])
    np.testing.assert_allclose(again.events[0].t, expected, rtol=1e-12)
    assert again.end == again.events[0].t[-1]


def test_an_angle_that_stays_at_its_value_or_opposite_to_it() -> None:
    """A body at rest has roll zero all along; one upside down has pi, which is not zero."""
    scene = rigid.FreeBody(rigid.Body((0.8, 1.7, 2.2)), orbit=rigid.Orbit(1.0))
    upside_down = (0.0, 1.0, 0.0, 0.0)  # half a turn about the radial axis 1
    for attitude, rate, complete in ((None, 1.0, False), (upside_down, -1.0, True)):
        run = rigid.simulate(
            scene, [0.0, 0.0, rate], attitude, t=[0.0, 9.0], events=rigid.crosses("yaw")
        )
        assert len(run.events[0]) == 0
        assert bool(run.events[0].complete) is complete


def test_axes_of_a_drawing_and_each_orbit_of_many() -> None:
    """The same motion told in axes that are turned by a frame; and bodies with their own orbits."""
    frame = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    orbits = rigid.Orbit([0.7, 0.9], [0.0, 0.3])
    scene = rigid.FreeBody(rigid.Body(BODY), orbit=orbits)
    event = rigid.crosses("roll", 0.3)
    both = rigid.simulate(scene, OMEGA, ATTITUDE, t=[0.0, UNTIL], events=event)
    for k, orbit in enumerate((rigid.Orbit(0.7), rigid.Orbit(0.9, 0.3))):
        alone = rigid.simulate(
            rigid.FreeBody(rigid.Body(BODY), orbit=orbit),
            OMEGA,
            ATTITUDE,
            t=[0.0, UNTIL],
            events=event,
        ).events[0]
        together = both.events[0].of(k)
        for name in ("t", "attitude", "slope", "error"):
            np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
        # The default axes are principal axes of the body, whatever the frame.
        drawn = frame @ np.array(OMEGA)
        turned = Rotation.from_quat(ATTITUDE, scalar_first=True) * Rotation.from_matrix(frame.T)
        events = [
            event,
            rigid.crosses("pointing", 1.0, axis=2, of="along"),
            rigid.crosses("yaw", 0.2, axes=(1, 2)),
        ]
        told = rigid.simulate(
            rigid.FreeBody(rigid.Body(BODY), orbit=orbit),
            drawn,
            turned.as_quat(scalar_first=True),
            t=[0.0, UNTIL],
            events=events,
            frame=frame,
        )
        # Rounding of the start by the turns.
        np.testing.assert_allclose(told.events[0].t, alone.t, rtol=1e-12)
        for found in told.events[1:]:
            assert len(found) > 0
            angles = [
                quantity(found.event, orbit, t, rigid.rotations.quaternion_to_matrix(q))
                if found.event.name == "pointing"
                else rigid.free.roll_pitch_yaw(orbit, q, t, axes=(1, 2))[2] - 0.2
                for t, q in zip(found.t, found.attitude, strict=True)
            ]
            np.testing.assert_allclose(angles, 0.0, atol=1e-12)


def test_an_event_is_kept_in_files(tmp_path: Any) -> None:
    events = [
        rigid.crosses("pointing", 0.4, axis=-1, of=(0.0, 3.0, 4.0)),
        rigid.crosses("yaw", 0.2, axes=(3, 1)),
    ]
    assert events[0].of == (0.0, 0.6, 0.8)
    scene = rigid.FreeBody(rigid.Body(BODY), orbit=rigid.Orbit(0.7))
    run = rigid.simulate(scene, OMEGA, ATTITUDE, t=[0.0, UNTIL], events=events)
    run.save(tmp_path / "run.npz")
    kept = rigid.load_run(tmp_path / "run.npz")
    assert [one.event for one in kept.events] == events
    assert kept.events[0].event.words() == "angle of axis -1 from (0.0, 0.6, 0.8) = 0.4, both ways"
    assert kept.events[1].event.words() == "yaw = 0.2, both ways"


test_what_is_no_angle = refuses(
    [
        ({"name": "pointing"}, "value = 0.0: never crossed; an angle between two directions"),
        ({"name": "pitch", "value": 1.6}, "value = 1.6: never crossed; a pitch lies between"),
        ({"name": "roll", "value": -3.2}, "value = -3.2: never crossed; a roll lies between -pi"),
        ({"name": "pointing", "value": 1.0, "of": (0, 0, 0)}, "of: is zero, so it is no direction"),
        ({"name": "pointing", "value": 1.0, "of": "up"}, "of = 'up': must be one of 'radial'"),
        ({"name": "pointing", "value": 1.0, "axis": 4}, "axis = 4: must be one of"),
        ({"name": "yaw", "axis": 1}, "axis = 1: belongs to pointing"),
        ({"name": "yaw", "of": "radial"}, "of = 'radial': belongs to pointing"),
        ({"name": "tilt3", "value": 1.0, "axes": (1, 3)}, "belongs to roll or pitch or yaw"),
        ({"name": "yaw", "axes": (1, 1)}, r"axes = \(1, 1\): must be two different axes"),
    ],
    by=lambda how: rigid.crosses(**how),
)


test_what_a_scene_does_not_tell = refuses(
    [
        (BODY, rigid.crosses("pitch", 0.1), False, r"crosses\(\) measures in the frame of an orb"),
        (BODY, rigid.turns("pointing", of="along"), False, r"turns\(\) measures in the frame of"),
        ((1, 1, 2), rigid.crosses("pitch", 0.1), True, "axes: two of the moments"),
        ([BODY, (1, 2, 3)], rigid.turns("yaw"), True, "axes: the long and short axes"),
        ([BODY, (1, 2, 3)], rigid.turns("pointing"), True, "axis: is needed, because the long ax"),
    ],
    by=lambda moments, event, orbit: rigid.simulate(
        rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(1.0) if orbit else None),
        OMEGA,
        t=[0.0, 1.0],
        events=event,
    ),
)
