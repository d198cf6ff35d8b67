"""Roll, pitch and yaw: turns 3-2-1 from the frame of the orbit to the body."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import rigid


def test_angles_are_those_of_scipy() -> None:
    """On an inclined ellipse, from the axes *along*, *normal* and *radial* of its frame."""
    orbit = rigid.Orbit(0.3, 0.4, 0.2, normal=(0.0, 0.6, 0.8), periapsis=(0.0, -0.8, 0.6))
    rng = np.random.default_rng(4)
    t, given = rng.uniform(0.0, 50.0, 200), rng.uniform(-1.5, 1.5, (200, 3))
    frame = orbit.frame(t)
    axes = Rotation.from_matrix(np.stack([frame[..., 1], frame[..., 2], frame[..., 0]], axis=-1))
    yaw, pitch, roll = given.T
    attitude = axes * Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    found = rigid.free.roll_pitch_yaw(orbit, attitude, t)
    # Near a pitch of 1.5 the angles lose a factor of 1 / cos(1.5) = 14 of some roundings.
    np.testing.assert_allclose(found, np.stack([roll, pitch, yaw], axis=-1), atol=1e-13)


def test_a_satellite_at_rest_has_none() -> None:
    """Body axes 1, 2, 3 along the motion, the normal and the line from the planet stay there."""
    orbit = rigid.Orbit(1.0)
    scene = rigid.FreeBody(rigid.Body((2.0, 2.1, 0.3)), orbit=orbit)
    t = np.linspace(0.0, 15.0, 16)
    run = rigid.simulate(scene, [0.0, 1.0, 0.0], [0.5, 0.5, 0.5, 0.5], t=t, accuracy=1e-10)
    assert run.attitude is not None
    angles = rigid.free.roll_pitch_yaw(orbit, run.attitude, t)
    np.testing.assert_allclose(angles, 0.0, atol=1e-9)
