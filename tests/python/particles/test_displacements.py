"""Displacements and velocities of clouds that move as one body."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from clouds import cloud
from physics import ROUNDOFF
from rigid import particles

RNG_SEED = 11


# Displacements


@pytest.mark.parametrize("seed", range(5))
def test_a_displacement_is_recovered_from_its_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng)
    shift = rng.normal(size=3)
    m, r, _, _ = cloud(5, seed)
    found = particles.rigid_motion(r, turn.apply(r) + shift, m)
    np.testing.assert_allclose(found.rotation, turn.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(found.translation, shift, atol=1e-12)
    assert found.residual < 1e-14
    assert found.determined
    # Any base point gives the same turn (Chasles); the shift is that of the base.
    for base in (r[2], np.array([10.0, -3.0, 0.1])):
        other = particles.rigid_motion(r - base, turn.apply(r) + shift - base, m)
        np.testing.assert_allclose(other.rotation, found.rotation, atol=1e-12)
        np.testing.assert_allclose(
            other.translation, turn.apply(base) + shift - base, atol=1e-12 * 10
        )


def test_a_disturbed_displacement_is_fitted_as_by_scipy() -> None:
    rng = np.random.default_rng(8)
    a = rng.normal(size=(4, 9, 3))
    turns = Rotation.random(4, rng=rng)
    w = rng.uniform(0.2, 1.0, 9)
    b = np.stack([turn.apply(x) for turn, x in zip(turns, a, strict=True)])
    b = b + 0.05 * rng.normal(size=b.shape)
    found = particles.rigid_motion(a, b, w)
    for k in range(4):
        mean_a, mean_b = w @ a[k] / w.sum(), w @ b[k] / w.sum()
        best, distance = Rotation.align_vectors(b[k] - mean_b, a[k] - mean_a, weights=w)
        np.testing.assert_allclose(found.rotation[k], best.as_matrix(), atol=1e-12)
        assert found.residual[k] == pytest.approx(distance / np.sqrt(w.sum()), rel=1e-9)
    assert found.determined.all()


def test_what_the_points_do_not_tell_is_flagged() -> None:
    turn = Rotation.from_rotvec([0.3, -0.5, 0.9])
    plane = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 2, 0]])
    flat = particles.rigid_motion(plane, turn.apply(plane))
    np.testing.assert_allclose(flat.rotation, turn.as_matrix(), atol=1e-14)
    assert flat.determined
    line = np.linspace(-1.0, 2.0, 5)[:, np.newaxis] * [1.0, 0.3, 0.0]
    thin = particles.rigid_motion(line, turn.apply(line) + 1.0)
    assert not thin.determined
    assert np.linalg.det(thin.rotation) == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(line @ thin.rotation.T + thin.translation, turn.apply(line) + 1.0)
    single = particles.rigid_motion([[1.0, 2.0, 3.0]], [[2.0, 2.0, 3.0]])
    assert not single.determined
    assert single.rotation.tolist() == np.eye(3).tolist()
    assert single.translation.tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("angle", [1e-6, 0.4, 2.0, np.pi - 1e-7, np.pi])
def test_a_screw_gives_the_displacement_back(angle: float) -> None:
    rng = np.random.default_rng(2)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    shift = rng.normal(size=3)
    matrix = Rotation.from_rotvec(angle * axis).as_matrix()
    found = particles.screw(matrix, shift)
    # An angle is seen in a matrix to rounding, a small one relative to itself the worse.
    assert found.angle == pytest.approx(angle, abs=8 * ROUNDOFF)
    sign = np.sign(found.axis @ axis)
    assert angle > 3.0 or sign > 0.0
    np.testing.assert_allclose(sign * found.axis, axis, atol=1e-15 / min(angle, 1.0) + 1e-15)
    assert found.point @ found.axis == pytest.approx(
        0.0, abs=1e-15 * float(np.linalg.norm(found.point))
    )
    # A turn about the line through the point, then the shift along it.
    again = Rotation.from_rotvec(found.angle * found.axis)
    np.testing.assert_allclose(again.as_matrix(), matrix, atol=8 * ROUNDOFF)
    along = found.point - again.apply(found.point) + found.advance * found.axis
    np.testing.assert_allclose(along, shift, atol=1e-15 / min(angle, 1.0) + 1e-15)
    assert found.pitch == pytest.approx(float(found.advance / found.angle))


def test_a_pure_translation_has_an_axis_but_no_turn() -> None:
    found = particles.screw(np.eye(3), [[0.0, 3.0, 4.0], [0.0, 0.0, 0.0]])
    assert found.angle.tolist() == [0.0, 0.0]
    assert found.axis.tolist() == [[0.0, 0.6, 0.8], [0.0, 0.0, 0.0]]
    assert found.advance.tolist() == [5.0, 0.0]
    assert found.pitch.tolist() == [np.inf, 0.0]
    assert found.point.tolist() == [[0.0, 0.0, 0.0]] * 2
    assert particles.screw(np.zeros((0, 3, 3)), np.zeros((0, 3))).axis.shape == (0, 3)


# Velocities


def test_velocities_of_a_body_keep_its_distances_and_do_not_depend_on_the_base() -> None:
    _, r, _, _ = cloud(6)
    omega, drift = np.array([0.7, -1.1, 0.4]), np.array([0.2, 0.0, 1.0])
    v = particles.velocity_field(omega, r, velocity=drift)
    for i, j in combinations(range(6), 2):
        rate = (r[i] - r[j]) @ (v[i] - v[j])
        assert abs(rate) < 8 * ROUNDOFF * np.linalg.norm(r[i] - r[j]) * np.linalg.norm(v[i] - v[j])
    again = particles.velocity_field(omega, r, velocity=v[3], base=r[3])
    np.testing.assert_allclose(again, v, atol=16 * ROUNDOFF * np.abs(v).max())
    # Against the displacement that these velocities lead to in a short time: order 2.
    step = 1e-4
    ahead, back = (Rotation.from_rotvec(omega * dt).apply(r) + drift * dt for dt in (step, -step))
    np.testing.assert_allclose((ahead - back) / (2 * step), v, atol=step**2 * 10.0)


def test_a_point_held_keeps_spheres_and_two_keep_circles() -> None:
    _, r, _, _ = cloud(5)
    v = particles.velocity_field([0.7, -1.1, 0.4], r, base=r[0])
    assert v[0].tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(((r - r[0]) * v).sum(axis=1), 0.0, atol=32 * ROUNDOFF)
    axis = r[1] - r[0]
    about = particles.velocity_field(2.0 * axis, r, base=r[0])
    np.testing.assert_allclose(about[1], 0.0, atol=8 * ROUNDOFF)
    np.testing.assert_allclose(about @ axis, 0.0, atol=64 * ROUNDOFF)


def test_the_angular_velocity_is_the_same_from_every_base() -> None:
    _, r, _, _ = cloud(6)
    omega, drift = np.array([1.0, -0.4, 0.6]), np.array([0.2, 0.0, 1.0])
    v = particles.velocity_field(omega, r, velocity=drift)
    bound = 5e-15
    for base in (None, np.zeros(3), r[2], np.array([5.0, 1.0, -3.0])):
        found = particles.fit_omega(r, v, base=base)
        np.testing.assert_allclose(found.omega, omega, atol=bound)
        assert found.rank == 3
        assert found.residual < bound
        truth = particles.velocity_field(omega, found.base, velocity=drift)
        np.testing.assert_allclose(found.velocity, truth, atol=10 * bound)
    # And seen from each particle, with the relative velocities of the others alone.
    for k in range(6):
        seen = particles.fit_omega(r - r[k], v - v[k])
        np.testing.assert_allclose(seen.omega, omega, atol=bound)
    # An arm from the origin instead of the base, as printed, is another field.
    printed = v[2] + np.cross(omega, r)
    assert np.abs(printed - v).max() > 0.1


def test_points_on_a_line_do_not_tell_the_turn_about_it() -> None:
    line = np.array([[-1.0, 0, 0], [0.5, 0, 0], [2, 0, 0]])
    v = particles.velocity_field([7.0, 2.0, -3.0], line, velocity=[0, 1, 0])
    found = particles.fit_omega(np.stack([line, 0 * line]), np.stack([v, 0 * v]))
    assert found.rank.tolist() == [2, 0]
    np.testing.assert_allclose(found.omega[0], [0.0, 2.0, -3.0], atol=1e-14)
    assert found.residual[0] < 1e-14
    # What no body does is left over.
    strange = particles.fit_omega(
        line, np.diag([-1.0, 0.0, 1.0]) @ np.ones((3, 1)) * [1.0, 0.0, 0.0]
    )
    assert strange.residual > 0.5  # of 0.5 * sqrt(1.5)
    assert strange.omega.tolist() == [0.0, 0.0, 0.0]
