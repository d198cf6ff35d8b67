"""The attitude: a unit quaternion, scalar first, active, body to space."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import METHODS, ROUNDOFF, present, rotation_angle, rotation_matrix

FREE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.6, 0.0, 0.8))
RATES = [0.3, 1.0, 0.2]
START = np.array([0.5, -0.1, 0.7, 0.5])  # of length one


def test_a_scipy_rotation_goes_in_and_comes_out() -> None:
    given = Rotation.from_quat(START, scalar_first=True)
    t = [0.0, 1.0, 2.0]
    run: Any = rigid.simulate(FREE, RATES, given, t=t)
    plain = rigid.simulate(FREE, RATES, given.as_quat(scalar_first=True), t=t)
    assert run.attitude.tobytes() == present(plain.attitude).tobytes()
    assert run.rotation().shape == (3,)
    assert (run.rotation()[0] * given.inv()).magnitude() < 4 * ROUNDOFF
    assert run.rotation().as_matrix() == pytest.approx(rotation_matrix(run.attitude), abs=1e-15)


def test_a_batch_of_rotations() -> None:
    given = Rotation.random(5, rng=np.random.default_rng(2))
    run = rigid.simulate(FREE, RATES, given, t=[0.0, 1.0])
    assert run.omega.shape == (5, 2, 3)
    assert run.rotation().shape == (5, 2)
    # Each body has the one rate, and its own attitude.
    assert np.array_equal(run.omega[0], run.omega[4])
    matrix = rotation_matrix(present(run.attitude))
    assert matrix[:, 0] == pytest.approx(given.as_matrix(), abs=1e-15)


def test_without_a_word_body_and_space_axes_coincide() -> None:
    run = rigid.simulate(TOP, RATES, t=[0.0])
    assert present(run.attitude)[0].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert present(run.gamma)[0].tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_scalar_first_and_active(method: rigid.Method) -> None:
    """A sphere turning a quarter about axis 1 from rest: body axis 2 points along space axis 3.

    But for the midpoint rule, by which a step turns it by `2 atan(h omega / 2)`.
    """
    sphere = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
    run = rigid.simulate(sphere, [np.pi / 2, 0.0, 0.0], t=1.0, method=method.name, step=1e-3)
    half = 1000.0 * np.arctan(np.pi / 4 * 1e-3) if method.name == "midpoint" else np.pi / 4
    c, s = np.cos([half, 2.0 * half]), np.sin([half, 2.0 * half])
    assert present(run.attitude)[0] == pytest.approx([c[0], s[0], 0.0, 0.0], abs=1e-12)
    assert run.rotation().apply([0.0, 1.0, 0.0])[0] == pytest.approx([0.0, c[1], s[1]], abs=1e-12)


def test_gamma_is_the_vertical_in_body_components() -> None:
    run = rigid.simulate(TOP, RATES, START, t=[0.0, 1.0, 2.0], step=1e-3)
    up = run.rotation().inv().apply([0.0, 0.0, 1.0])
    assert run.gamma == pytest.approx(up, abs=1e-12)


@pytest.mark.parametrize("scene", [FREE, TOP], ids=["free", "top"])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_quaternion_and_its_negative_are_the_same_attitude(
    method: rigid.Method, scene: rigid.FreeBody | rigid.HeavyTop
) -> None:
    plus = rigid.simulate(scene, RATES, START, t=[1.0, 5.0], method=method.name)
    minus = rigid.simulate(scene, RATES, -START, t=[1.0, 5.0], method=method.name)
    assert np.array_equal(plus.omega, minus.omega)
    assert np.array_equal(present(plus.attitude), -present(minus.attitude))


def test_the_start_is_normalised() -> None:
    unit = rigid.simulate(TOP, RATES, START, t=[0.0, 1.0])
    # The squares of the last lengths overflow or vanish.
    for length in (2.0, 1e-3, 12345.6, 1e100, 1e-100, 1e200, 1e-200):
        run = rigid.simulate(TOP, RATES, length * START, t=[0.0, 1.0])
        assert np.linalg.norm(present(run.attitude)[0]) == pytest.approx(1.0, abs=4 * ROUNDOFF)
        assert run.omega == pytest.approx(unit.omega, abs=1e-14)
    two = rigid.simulate(TOP, RATES, [2, 0, 0, 0], t=0.0)
    assert present(two.attitude)[0].tolist() == [1.0, 0.0, 0.0, 0.0]


def test_rotation_angle_of_the_tests_sees_small_angles() -> None:
    tiny = np.array([1.0, 3e-12, 0.0, 4e-12])
    assert rotation_angle(tiny, [1.0, 0.0, 0.0, 0.0]) == pytest.approx(1e-11, rel=1e-12)
    assert rotation_angle(-tiny, [2.0, 0.0, 0.0, 0.0]) == pytest.approx(1e-11, rel=1e-12)
