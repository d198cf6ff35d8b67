"""Criteria and measures of roll, pitch and yaw, and times to settle, against fine motions."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

import rigid
from free_motions import slowing_ball
from physics import Floats
from planar_moons import MOMENTS, beginning_so, planar
from refusals import refuses
from rigid.rotations import quaternion_to_matrix
from small_maps import small_map

ANGLES = ("roll", "pitch", "yaw")
COUNT = 24
TIMES = np.linspace(0.0, 8.0, 8001)
BODY = rigid.Body((1.0, 1.25, 1.5))
INCLINED: dict[str, Any] = {"normal": (0.0, 0.6, 0.8), "periapsis": (0.0, -0.8, 0.6)}
SCENES = {
    # Integrated over the anomaly, in time beside another force, and on a hyperbola.
    "orbit": rigid.FreeBody(BODY, orbit=rigid.Orbit(0.7, 0.3, 1.1, **INCLINED)),
    "rotor": rigid.FreeBody(
        BODY, orbit=rigid.Orbit(0.7, 0.3, 1.1, **INCLINED), rotor=(0.05, 0.02, 0.3)
    ),
    "flyby": rigid.FreeBody(BODY, orbit=rigid.Orbit(0.7, 1.8, -2.0, **INCLINED)),
}
STEEP = 15e-3
"""Radians in a millisecond beyond which an angle may leap unseen: pi in 0.2 s, which is a step."""

MOST_UNKNOWN = 6
"""Bodies whose roll or yaw swings so fast. A body that turns by 0.8 rad/s does where an axis is
within d = 0.8/15 rad of two opposite directions. The axis goes 6 rad, sweeps 12 d of the 4 pi of
all directions, and meets one of the two in 0.10 of the cases, which is 2.4 of 24, give or take
1.5. Measured were 1 to 4."""
CRITERIA = {"roll": rigid.roll_within, "pitch": rigid.pitch_within, "yaw": rigid.yaw_within}
LARGEST = {"roll": rigid.largest_roll, "pitch": rigid.largest_pitch, "yaw": rigid.largest_yaw}


def angles_of(scene: rigid.FreeBody, attitude: Floats, axes: tuple[int, int]) -> Floats:
    """Roll, pitch and yaw by SciPy's Euler angles, from the place on the orbit alone."""
    assert scene.orbit is not None
    place = scene.orbit.position(TIMES)
    radial = place / np.linalg.norm(place, axis=-1, keepdims=True)
    normal = np.broadcast_to(scene.orbit.normal, radial.shape)
    frame = np.stack([np.cross(normal, radial), normal, radial], axis=-1)
    yaw, pitch = (np.sign(one) * np.eye(3)[abs(one) - 1] for one in axes)
    rest = np.stack([np.cross(pitch, yaw), pitch, yaw], axis=-1)
    relative = np.swapaxes(frame, -1, -2) @ quaternion_to_matrix(attitude) @ rest
    shape = relative.shape[:-2]
    angles = Rotation.from_matrix(relative.reshape(-1, 3, 3)).as_euler("ZYX")
    found: Floats = angles.reshape(*shape, 3)[..., ::-1]
    return found


def values(found: rigid.Outcomes, name: str) -> Floats:
    """The values of the measure of this name in the only pixel."""
    (values,) = (each[0] for key, each in found.measures.items() if key.split("(")[0] == name)
    known: Floats = values
    return known


@cache
def fine(where: str, axes: tuple[int, int]) -> Floats:
    scene = SCENES[where]
    starts = small_map(scene, stable=rigid.no_flip(3), samples=COUNT, **OPTIONS).starts(
        range(COUNT)
    )
    run = rigid.simulate(
        scene, starts.omega[0], starts.attitude[0], t=TIMES, method="taylor20", check=False
    )
    assert run.attitude is not None
    return angles_of(scene, run.attitude, axes)


OPTIONS: dict[str, Any] = {
    "axes": {"t_end": [8.0]},
    "start": rigid.Start(
        omega=(0.1, -0.2, 0.5), attitude_noise=rigid.uniform_attitude(), noise=rigid.normal(0.2)
    ),
    "method": "auto",
}


@pytest.mark.parametrize("where", SCENES)
@pytest.mark.parametrize("of", ANGLES)
@pytest.mark.parametrize("axes", [(1, 3), (-3, 2)])
def test_angles_are_those_of_a_fine_motion(where: str, of: str, axes: tuple[int, int]) -> None:
    """The limits lie between two bodies, so that half of them leave, or half settle."""
    scene = SCENES[where]
    angle = np.abs(fine(where, axes)[..., ANGLES.index(of)])
    largest = angle.max(axis=1)
    low, high = np.sort(largest)[11:13]
    limit = min(float(0.5 * (low + high)), 3.0)
    result = small_map(
        scene,
        stable=CRITERIA[of](limit, axes),
        measure=[LARGEST[of](axes), rigid.time_to_settle(1.0, of, axes)],
        samples=COUNT,
        **OPTIONS,
    )
    found = result.outcomes(range(COUNT))
    # Between two times, 1e-3 s apart, the angle changes by its rate, which is large near gimbal
    # lock; its largest value is flat there unless it is pi.
    step = np.abs(np.diff(angle, axis=1))
    unknown = 0
    for k in range(COUNT):
        beyond = angle[k] > limit
        told, steep = str(found.outcome[0, k]), bool(step[k].max() > STEEP)
        if abs(largest[k] - limit) > 2.0 * step[k].max() and not (told == "undecided" and steep):
            assert told == ("unstable" if beyond.any() else "stable")
        left = found.left[0, k]  # not known if only the second run has seen it
        if beyond.any() and told == "unstable" and not (np.isnan(left) and steep):
            first = int(beyond.argmax())
            before, after = TIMES[max(first - 1, 0)], TIMES[first]
            assert before - 1e-6 <= left <= after + 1e-6
        near = int(angle[k].argmax())
        around = step[k, max(near - 2, 0) : near + 2].max()
        # Errors of the steps, 1e-8 for each of some 20 rad, are magnified near gimbal lock. A body
        # whose angle swings faster than STEEP at any time may have no largest one.
        value = values(found, f"largest_{of}")[k]
        unknown += bool(np.isnan(value) or told == "undecided" or (np.isnan(left) and beyond.any()))
        if not (np.isnan(value) and steep):
            assert value == pytest.approx(largest[k], abs=around + 1e-5)
        late = angle[k] > 1.0
        settled = values(found, "time_to_settle")[k]
        if late[-1]:
            assert np.isnan(settled)
        elif not late.any():
            assert settled == 0.0
        else:
            last = len(late) - 1 - int(late[::-1].argmax())
            assert TIMES[last] - 1e-6 <= settled <= TIMES[last + 1] + 1e-6
    assert 6 <= result.stable[0] <= 18 or limit == 3.0
    assert unknown <= (0 if of == "pitch" else MOST_UNKNOWN)


@pytest.mark.parametrize("e", [0.0, 0.3])
def test_pitch_of_a_motion_in_the_plane_is_its_libration(e: float) -> None:
    starts = [(0.0, 1.1), (0.3, 1.3), (-0.4, 0.7), (0.2, 0.9), (0.0, 1.3)]
    result = small_map(
        rigid.FreeBody(rigid.Body(MOMENTS), orbit=rigid.Orbit(1.0, e)),
        axes={"t_end": [20.0]},
        start=beginning_so(starts),
        stable=rigid.pitch_within(0.6),
        measure=[rigid.largest_pitch(), rigid.largest_roll(), rigid.time_to_settle(0.3, "pitch")],
        samples=len(starts),
        method="auto",
    )
    found = result.outcomes(range(len(starts)))
    for k, (angle, speed) in enumerate(starts):
        t, _, libration = planar(angle, speed, e, 20.0)
        pitch = np.abs(np.arcsin(np.sin(libration)))  # from -pi/2 to pi/2
        # At pi/2 it has a cusp, which lies up to 2.5e-4 s from a time, at up to 2 rad/s.
        cusp = 5e-4 if pitch.max() > 1.5 else 1e-5
        assert values(found, "largest_pitch")[k] == pytest.approx(pitch.max(), abs=cusp)
        assert found.outcome[0, k] == ("stable" if pitch.max() < 0.6 else "unstable")
        settled = values(found, "time_to_settle")[k]
        late = pitch > 0.3
        if late[-1]:
            assert np.isnan(settled)
        else:
            last = len(late) - 1 - int(late[::-1].argmax()) if late.any() else -1
            assert settled == pytest.approx(t[last] if last >= 0 else 0.0, abs=1e-3)


def square_of_sine(t: Any, ball: Floats, line: Floats) -> Any:
    """Of the pitch of a ball that keeps its rates in space; axis 2 lies along the line first."""
    axis = Rotation.from_rotvec(np.multiply.outer(t, ball)).apply(line)
    angle = 0.05 * np.asarray(t)
    radial = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    return (axis * radial).sum(axis=-1) ** 2


def test_a_largest_pitch_near_a_right_angle_is_that_of_a_ball_in_closed_form() -> None:
    # Axis 2 passes the line from the planet closely: there the pitch turns back, at once if it is a
    # right angle.
    result = small_map(
        rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)), orbit=rigid.Orbit(0.05)),
        axes={"t_end": [60.0]},
        start=rigid.Start(
            omega=(0.1, -0.2, 0.5), attitude_noise=rigid.uniform_attitude(), noise=rigid.normal(0.3)
        ),
        stable=rigid.no_flip(3),
        measure=rigid.largest_pitch((1, 3)),
        samples=64,
        method="auto",
    )
    starts = result.starts(range(64))
    found = values(result.outcomes(range(64)), "largest_pitch")
    t = np.linspace(0.0, 60.0, 60001)
    near = 0
    for k, (rates, q) in enumerate(zip(starts.omega[0], starts.attitude[0], strict=True)):
        begin = quaternion_to_matrix(q)
        motion = begin @ rates, begin[:, 1]
        squares = square_of_sine(t, *motion)
        place = t[squares.argmax()]
        best = minimize_scalar(
            lambda time, *motion: -square_of_sine(time, *motion),
            args=motion,
            bounds=(place - 1e-3, place + 1e-3),
            options={"xatol": 1e-12},
        )
        # At either end too, which is not a maximum.
        largest = max(-best.fun, squares[0], squares[-1]) if 0.0 < place < 60.0 else squares.max()
        pitch = math.asin(math.sqrt(largest))
        near += pitch > 1.54
        assert found[k] == pytest.approx(pitch, abs=1e-5)
    assert near > 3


@pytest.mark.parametrize("force", ["damping", "drag", "callback"])
def test_a_damped_body_settles_when_its_closed_form_is_slow(force: str) -> None:
    """Each speed is drawn."""
    slow, count = 0.1, 40
    result = small_map(
        slowing_ball(force, fastest=3.0),
        axes={"t_end": [40.0]},
        start=rigid.Start(omega=(0.0, 0.0, 0.4), noise=rigid.normal(0.4)),
        stable=~rigid.spin_above(slow),
        measure=rigid.time_to_settle(slow),
        samples=count,
        method="auto",
    )
    speed = np.linalg.norm(result.starts(range(count)).omega[0], axis=-1)
    expected = 4.0 * (1.0 / slow - 1.0 / speed if force == "drag" else np.log(speed / slow))
    expected = np.maximum(expected, 0.0)
    expected[expected > 40.0] = np.nan
    found = values(result.outcomes(range(count)), "time_to_settle")
    # Errors of steps of 1e-8 for each of some 20 rad, over the share by which the speed falls.
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)
    known = expected[~np.isnan(expected)]
    measured = result.measures["time_to_settle"]
    assert measured.count[0] == len(known) > 20
    np.testing.assert_allclose(measured.mean[0], known.mean(), rtol=1e-6)
    ranked = np.sort(known)[math.ceil(0.5 * len(known)) - 1]
    # Quantiles are known to the width of a bin.
    np.testing.assert_allclose(measured.quantile(0.5)[0], ranked, rtol=1.0 / 64.0)
    assert 0.0 <= measured.error[0] < 1e-4  # from the second run of each body
    assert "undecided" not in next(
        line for line in result.summary().splitlines() if "time_to_settle" in line
    )


def test_a_speed_that_rises_again_settles_for_the_last_time() -> None:
    """A free body that flips is slow for a while, again and again."""
    scene, t = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), np.linspace(0.0, 30.0, 30001)
    result = small_map(
        scene,
        axes={"t_end": [30.0]},
        start=rigid.Start(omega=(0.1, 1.0, 0.1), noise=rigid.normal(0.2)),
        stable=rigid.no_flip(2),
        measure=rigid.time_to_settle(1.0),
        samples=COUNT,
        method="auto",
    )
    found = values(result.outcomes(range(COUNT)), "time_to_settle")
    starts = result.starts(range(COUNT))
    run = rigid.simulate(scene, starts.omega[0], starts.attitude[0], t=t)
    late = np.linalg.norm(run.omega, axis=-1) > 1.0
    kinds = set()
    for k in range(COUNT):
        if late[k, -1]:
            assert np.isnan(found[k])
            kinds.add("fast")
        elif not late[k].any():
            assert found[k] == 0.0
            kinds.add("slow")
        else:
            last = len(t) - 1 - int(late[k, ::-1].argmax())
            assert t[last] - 1e-6 <= found[k] <= t[last + 1] + 1e-6
            kinds.add("settles")
    assert kinds == {"fast", "slow", "settles"}


test_what_no_map_can_watch = refuses(
    [
        (lambda: rigid.roll_within(4.0), r"angle = 4.0: must lie in \(0, pi\]"),
        (lambda: rigid.yaw_within(1.0, (1, -1)), r"axes = \(1, -1\): must be two different axes"),
        (lambda: rigid.largest_pitch(3), "must be two body axes"),  # type: ignore[arg-type]
        (lambda: rigid.time_to_settle(0.0), "limit = 0.0: must be positive"),
        (lambda: rigid.time_to_settle(4.0, "yaw"), r"limit = 4.0: must lie in \(0, pi\]"),
        (lambda: rigid.time_to_settle(1.0, "tilt"), "of = 'tilt': must be one of 'speed'"),
        (lambda: rigid.time_to_settle(1.0, axes=(1, 3)), r"axes = \(1, 3\): the speed has none"),
        (lambda: small_map(stable=rigid.pitch_within(0.1)), r"pitch_within\(\) measures in the fr"),
        (lambda: small_map(measure=rigid.largest_yaw()), r"largest_yaw\(\) measures in the frame"),
    ],
)
