"""Directions and rotations with four decimals, or in single precision, are what they stand for."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from rigid import inertia, particles, rotations
from rigid._checks import matrices

Floats = NDArray[np.float64]

COUNT = 2000
TURNS = Rotation.random(COUNT, random_state=5)
ROUNDED: dict[str, Callable[[Floats], Any]] = {
    "single": lambda array: array.astype(np.float32),
    "four decimals": lambda array: array.round(4),
}
OFF = {"single": 2.0**-25, "four decimals": 0.5e-4}
"""Largest error of a number of size one."""

BODY = rigid.Body((1.0, 1.5, 2.0))


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_directions_have_length_one(kind: str) -> None:
    exact = TURNS.as_matrix()[:, :, 0]
    given = ROUNDED[kind](exact)
    normal, across = ROUNDED[kind](TURNS.as_matrix()[:, :, 1]), given
    tops = rigid.HeavyTop(BODY, mgl=1.0, com=given)
    orbit = rigid.Orbit(1.0, normal=normal, periapsis=across)
    for found in (tops.com, orbit.normal, orbit.periapsis):
        assert np.abs(np.linalg.norm(found, axis=-1) - 1.0).max() < 1e-15
    assert np.abs(np.vecdot(orbit.normal, orbit.periapsis)).max() < 1e-15
    # The component across is off by the rounding of three numbers.
    assert np.abs(tops.com - exact).max() <= 2.0 * OFF[kind]
    assert rigid.HeavyTop(BODY, mgl=1.0, com=given[0]).com == tuple(np.array(tops.com)[0].tolist())
    again = rigid.HeavyTop(BODY, mgl=1.0, com=tops.com)
    assert np.array_equal(again.com, tops.com)


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_matrices_are_the_nearest_rotations(kind: str) -> None:
    exact = TURNS.as_matrix()
    given = ROUNDED[kind](exact)
    nearest = rotations.nearest_rotation(given)
    quaternion = rotations.matrix_to_quaternion(given)
    # The singular vectors have errors of some 20 roundings.
    assert np.abs(rotations.quaternion_to_matrix(quaternion) - nearest).max() < 1e-14
    turned = inertia.rotate_tensor(given, np.diag([1.0, 2.0, 2.5]))
    assert np.abs(np.linalg.eigvalsh(turned) - [1.0, 2.0, 2.5]).max() < 2e-14
    assert np.abs(nearest - exact).max() <= 3.0 * OFF[kind]
    turn = particles.screw(given[0], [0.0, 0.0, 0.0])
    assert turn.angle == pytest.approx(Rotation.from_matrix(nearest[0]).magnitude(), abs=1e-14)
    start, times = [0.3, 1.0, 0.2], [0.0, 5.0]
    run: Any = rigid.simulate(BODY, start, t=times, frame=given[1])
    same: Any = rigid.simulate(BODY, start, t=times, frame=nearest[1])
    assert np.abs(run.omega - same.omega).max() < 1e-13
    assert np.abs(run.attitude - same.attitude).max() < 1e-13


def test_exact_rotations_keep_their_bits() -> None:
    exact = TURNS.as_matrix()
    assert (matrices.rotation_matrices("R", exact) == exact).all()
    products = exact @ np.roll(exact, 1, axis=0)
    assert (matrices.rotation_matrices("R", products) == products).all()


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_samples_of_attitudes_are_unit_quaternions(kind: str) -> None:
    exact = TURNS.as_quat(scalar_first=True)
    taken = np.array(rigid.samples(None, ROUNDED[kind](exact)).attitude)
    assert np.abs(np.linalg.norm(taken, axis=1) - 1.0).max() < 1e-15
    assert np.abs(taken - exact).max() <= 2.0 * OFF[kind]
    assert np.array_equal(np.array(rigid.samples(None, taken).attitude), taken)


def test_what_is_further_off_is_refused_with_its_misfit() -> None:
    with pytest.raises(ValueError, match=r"must be a unit vector to 0.0001, its length is 1.0002;"):
        rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.0, 1.0002))
    with pytest.raises(ValueError, match=r"R - 1\| = 0.00347, must be at most 0.00031, det R"):
        rotations.matrix_to_quaternion(1.001 * np.eye(3))
    with pytest.raises(ValueError, match=r"their product is 0.0009, above 0.0002$"):
        rigid.Orbit(1.0, normal=(0.0, 0.0, 1.0), periapsis=(1.0, 0.0, 0.0009))
