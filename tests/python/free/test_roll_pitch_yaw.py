"""Roll, pitch and yaw: turns 3-2-1 from the frame of the orbit to the body."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import present


def test_angles_are_those_of_scipy() -> None:
    """On an inclined ellipse, from the axes *along*, *normal* and *radial* of its frame."""
    orbit = rigid.Orbit(0.3, 0.4, 0.2, normal=(0.0, 0.6, 0.8), periapsis=(0.0, -0.8, 0.6))
    rng = np.random.default_rng(4)
    t, given = rng.uniform(0.0, 50.0, 200), rng.uniform(-1.5, 1.5, (200, 3))
    frame = orbit.frame(t)
    axes = Rotation.from_matrix(np.stack([frame[..., 1], frame[..., 2], frame[..., 0]], axis=-1))
    yaw, pitch, roll = given.T
    attitude = axes * Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    found = rigid.free.roll_pitch_yaw(orbit, attitude, t, axes=(3, 2))
    # Near a pitch of 1.5 the angles lose a factor of 1 / cos(1.5) = 14 of some roundings.
    np.testing.assert_allclose(found, np.stack([roll, pitch, yaw], axis=-1), atol=1e-13)


def test_a_satellite_at_rest_has_none() -> None:
    """Body axes 1, 2, 3 along the motion, the normal and the line from the planet stay there."""
    orbit = rigid.Orbit(1.0)
    scene = rigid.FreeBody(rigid.Body((2.0, 2.1, 0.3)), orbit=orbit)
    t = np.linspace(0.0, 15.0, 16)
    run = rigid.simulate(scene, [0.0, 1.0, 0.0], [0.5, 0.5, 0.5, 0.5], t=t, accuracy=1e-10)
    assert run.attitude is not None
    angles = rigid.free.roll_pitch_yaw(scene, run.attitude, t)
    np.testing.assert_allclose(angles, 0.0, atol=1e-9)


PAIRS = [a for a in itertools.permutations((1, 2, 3, -1, -2, -3), 2) if abs(a[0]) != abs(a[1])]


@pytest.mark.parametrize("axes", PAIRS)
def test_angles_belong_to_the_axes_that_are_named(axes: tuple[int, int]) -> None:
    """The same turns of a body whose axes have other numbers."""
    orbit, t = rigid.Orbit(0.3, 0.4), np.linspace(0.0, 9.0, 50)
    given = np.random.default_rng(4).uniform(-1.4, 1.4, (50, 3))
    roll, pitch, yaw = given.T
    turns = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    yaw_axis, pitch_axis = (np.sign(one) * np.eye(3)[abs(one) - 1] for one in axes)
    own = np.stack([np.cross(pitch_axis, yaw_axis), pitch_axis, yaw_axis])
    frame = orbit.frame(t)[..., [1, 2, 0]]
    attitude = Rotation.from_matrix(frame) * turns * Rotation.from_matrix(own)
    found = rigid.free.roll_pitch_yaw(orbit, attitude, t, axes=axes)
    np.testing.assert_allclose(found, given, atol=1e-13)


def test_a_moon_that_faces_its_planet_has_none() -> None:
    """Axis 1 along the line to the planet, as the attitude is by default: no gimbal lock."""
    moon = rigid.FreeBody(rigid.Body.ellipsoid(1.3, 1.1, 1.0), orbit=rigid.Orbit(1.0))
    t = np.linspace(0.0, 15.0, 16)
    run = rigid.simulate(moon, [0.0, 0.0, 1.0], t=t, accuracy=1e-10)
    np.testing.assert_allclose(
        rigid.free.roll_pitch_yaw(moon, present(run.attitude), t), 0.0, atol=1e-9
    )


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (rigid.Orbit(1.0), "axes: an orbit alone has no body; give the body axes"),
        (rigid.FreeBody(rigid.Body((1, 2, 2)), orbit=rigid.Orbit(1.0)), "axes: two of the moments"),
        (rigid.FreeBody(rigid.Body((1, 1.5, 2))), "has no orbit; give rigid.FreeBody one"),
    ],
)
def test_what_has_no_axes_is_refused(scene: rigid.FreeBody | rigid.Orbit, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rigid.free.roll_pitch_yaw(scene, [1, 0, 0, 0], 0.0)
