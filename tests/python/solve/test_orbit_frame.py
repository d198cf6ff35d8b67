"""Starts and results in the frame of the orbit, against Kepler's equation and rest on an orbit."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import Floats, place_on_orbit

ORBITS = {
    "circle": rigid.Orbit(0.7, anomaly=0.3),
    "ellipse": rigid.Orbit(0.7, 0.6, 2.1, normal=(0.0, 0.6, 0.8), periapsis=(1.0, 0.0, 0.0)),
    "hyperbola": rigid.Orbit(0.7, 2.5, -3.0, normal=(0.0, 0.6, 0.8), periapsis=(0.0, -0.8, 0.6)),
}
TIMES = np.linspace(0.0, 9.0, 10)


def kepler(orbit: rigid.Orbit, t: float) -> tuple[Floats, float]:
    """Columns radial, along, normal from the place, and n sqrt|1 - e²| (a/r)²."""
    place, normal = place_on_orbit(orbit, t), np.array(orbit.normal)
    distance = np.linalg.norm(place)
    radial = place / distance
    frame = np.stack([radial, np.cross(normal, radial), normal], axis=-1)
    e = float(np.asarray(orbit.eccentricity))
    return frame, float(orbit.rate * np.sqrt(abs(1.0 - e * e)) / distance**2)


@pytest.mark.parametrize("name", ORBITS)
def test_states_beside_the_orbit_are_those_of_keplers_frame(name: str) -> None:
    orbit = ORBITS[name]
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=orbit)
    start, rates = Rotation.from_rotvec([0.3, -0.8, 0.4]), np.array([0.2, -0.1, 0.4])
    omega, attitude = orbit.to_space(rates, start)
    frame, turning = kepler(orbit, 0.0)
    expected = frame @ start.as_matrix()
    # Rounding of the place and of three products.
    np.testing.assert_allclose(rigid.rotations.quaternion_to_matrix(attitude), expected, atol=2e-15)
    np.testing.assert_allclose(omega, rates + expected.T @ frame[:, 2] * turning, atol=2e-15)

    run: Any = rigid.simulate(scene, omega, attitude, t=TIMES)
    beside = run.in_orbit_frame()
    np.testing.assert_allclose(beside.omega[0], rates, atol=2e-15)
    for k, t in enumerate(TIMES):
        frame, turning = kepler(orbit, t)
        matrix = rigid.rotations.quaternion_to_matrix(run.attitude[k])
        relative = rigid.rotations.quaternion_to_matrix(beside.attitude[k])
        np.testing.assert_allclose(relative, frame.T @ matrix, atol=1e-14)
        slower = run.omega[k] - matrix.T @ frame[:, 2] * turning
        np.testing.assert_allclose(beside.omega[k], slower, atol=1e-14)
        # And back, at this time.
        back, turned = orbit.to_space(beside.omega[k], beside.attitude[k], t)
        np.testing.assert_allclose(back, run.omega[k], atol=1e-14)
        same = rigid.rotations.quaternion_to_matrix(turned)
        np.testing.assert_allclose(same, matrix, atol=1e-14)


@pytest.mark.parametrize("name", ORBITS)
def test_the_relative_rate_is_the_rate_of_the_relative_attitude(name: str) -> None:
    """Differences of the attitude over 1e-4 s: at up to 6 rad/s they err by 6³ 1e-8 / 6 = 4e-7."""
    orbit, step = ORBITS[name], 1e-4
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=orbit)
    around = (TIMES[1:, np.newaxis] + step * np.array([-1.0, 0.0, 1.0])).ravel()
    run = rigid.simulate(scene, [0.5, 0.8, -1.1], t=around, method="taylor20")
    beside = run.in_orbit_frame()
    before, _, after = (
        Rotation.from_quat(beside.attitude, scalar_first=True)
        .as_matrix()
        .reshape(-1, 3, 3, 3)
        .transpose(1, 0, 2, 3)
    )
    turned = Rotation.from_matrix(np.swapaxes(before, -1, -2) @ after).as_rotvec() / (2.0 * step)
    np.testing.assert_allclose(beside.omega[1::3], turned, atol=5e-7)


def test_a_satellite_at_rest_stays_at_rest_beside_its_circle() -> None:
    orbit = rigid.Orbit(1.1e-3, anomaly=1.0, normal=(0.0, 0.6, 0.8), periapsis=(1.0, 0.0, 0.0))
    # Axes 1, 2, 3 along the motion, along the normal, and towards the planet's other side.
    at_rest = Rotation.from_matrix([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    scene = rigid.FreeBody(rigid.Body((2.0, 2.1, 0.3)), orbit=orbit)
    start = orbit.to_space([0.0, 0.0, 0.0], at_rest)
    run = rigid.simulate(scene, *start, t=np.linspace(0.0, 2e4, 21), accuracy=1e-9)
    beside = run.in_orbit_frame()
    np.testing.assert_allclose(beside.omega, 0.0, atol=1.1e-3 * run.error.max())
    angles = rigid.free.roll_pitch_yaw(scene, run.attitude, run.t, axes=(3, 2))
    np.testing.assert_allclose(angles, 0.0, atol=2.0 * run.error.max())


def test_many_bodies_with_orbits_and_times_of_their_own() -> None:
    orbits = rigid.Orbit([0.7, 0.9], [0.0, 0.3], [0.1, 0.2])
    rates = np.array([[0.1, 0.2, 0.3], [-0.1, 0.0, 0.2]])
    omega, attitude = orbits.to_space(rates)
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=orbits)
    times = np.array([[0.0, 1.0, 2.0], [0.0, 3.0, 4.0]])
    beside = rigid.simulate(scene, omega, attitude, t=times).in_orbit_frame()
    for k, orbit in enumerate((rigid.Orbit(0.7, 0.0, 0.1), rigid.Orbit(0.9, 0.3, 0.2))):
        own, turned = orbit.to_space(rates[k])
        np.testing.assert_array_equal(own, omega[k])
        np.testing.assert_array_equal(turned, attitude[k])
        body = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=orbit)
        alone = rigid.simulate(body, own, turned, t=times[k]).in_orbit_frame()
        np.testing.assert_array_equal(beside.omega[k], alone.omega)
        np.testing.assert_array_equal(beside.attitude[k], alone.attitude)


def test_axes_of_a_drawing_and_the_end_of_a_body() -> None:
    frame = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    orbit = ORBITS["ellipse"]
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=orbit)
    until = rigid.crosses("pitch", 0.5)
    run: Any = rigid.simulate(scene, *orbit.to_space([0.2, 0.1, 0.3]), t=TIMES, until=until)
    beside, drawn = run.in_orbit_frame(), run.in_frame(frame).in_orbit_frame()
    ended = run.end < TIMES
    assert 0 < ended.sum() < len(TIMES)
    assert np.isnan(beside.omega[ended]).all()
    assert np.isnan(beside.attitude[ended]).all()
    np.testing.assert_allclose(drawn.omega, beside.omega @ frame.T, atol=2e-15)
    relative = (Rotation.from_quat(q[~ended], scalar_first=True) for q in (drawn[1], beside[1]))
    one, other = relative
    np.testing.assert_allclose(one.as_matrix(), other.as_matrix() @ frame.T, atol=2e-15)


def body(**options: Any) -> rigid.Run:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.6, 0.7)), orbit=rigid.Orbit(1.0))
    return rigid.simulate(scene, [0.1, 0.2, 0.3], t=[0.0, 1.0], **options)


def test_what_has_no_frame_of_an_orbit() -> None:
    with pytest.raises(ValueError, match="scene: has no orbit; give rigid"):
        rigid.simulate(rigid.Body((1, 2, 3)), [0, 0, 1], t=[0.0, 1.0]).in_orbit_frame()
    with pytest.raises(ValueError, match="record = 'attitude' was not asked for"):
        body(record="rates").in_orbit_frame()
    with pytest.raises(ValueError, match=r"omega: expected shape \(..., 3\)"):
        rigid.Orbit(1.0).to_space([0.0, 1.0])
    with pytest.raises(ValueError, match=r"orbit \(2,\), omega \(3,\): the axes of"):
        rigid.Orbit([1.0, 2.0]).to_space(np.zeros((3, 3)))
