"""Clouds of particles: sums, conditions, displacements and velocities; thrown bodies."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import ROUNDOFF, Floats, angular_momentum, present
from printed_equations import solved
from refusals import refuses
from rigid import particles

NAN = float("nan")


def cloud(count: int, seed: int = 11) -> tuple[Floats, Floats, Floats, Floats]:
    """Masses, positions, velocities and forces of that many particles."""
    rng = np.random.default_rng(seed)
    return (
        rng.uniform(0.5, 2.0, count),
        rng.normal(size=(count, 3)),
        rng.normal(size=(count, 3)),
        rng.normal(size=(count, 3)),
    )


BODY = rigid.Body((1.0, 2.0, 3.0), mass=1.7)
TIMES = np.linspace(0.0, 5.0, 41)
RATES = np.array([0.02, 1.0, 0.02])


def throw(force: Any, t: Any = TIMES, **options: Any) -> particles.BodyPath:
    start = {"position": [1.0, 2.0, 3.0], "velocity": [0.5, -1.0, 4.0], "omega": RATES, **options}
    return particles.propagate_body(BODY, force=force, t=t, **start)


def sizes(masses: Floats, positions: Floats, velocities: Floats) -> float:
    """A bound of the terms that the sums are made of."""
    lengths = np.linalg.norm(positions, axis=-1) + np.linalg.norm(velocities, axis=-1)
    return float((masses * (1.0 + lengths) ** 2).sum())


# Sums


def test_totals_of_two_masses_by_hand() -> None:
    # 2 kg at (1, 0, 0) with (0, 3, 0) m/s under (0, 0, 5) N; 1 kg at (0, 4, 0) with (1, 0, 1) m/s
    # under (1, 0, 0) N.
    totals = particles.particle_totals(
        [2.0, 1.0], [[1, 0, 0], [0, 4, 0]], [[0, 3, 0], [1, 0, 1]], [[0, 0, 5], [1, 0, 0]]
    )
    assert totals.mass == 3.0
    assert totals.com.tolist() == [2.0 / 3.0, 4.0 / 3.0, 0.0]
    assert totals.momentum.tolist() == [1.0, 6.0, 1.0]
    # 2 (1, 0, 0) × (0, 3, 0) = (0, 0, 6) and (0, 4, 0) × (1, 0, 1) = (4, 0, -4).
    assert totals.angular_momentum.tolist() == [4.0, 0.0, 2.0]
    assert totals.kinetic_energy == 10.0
    assert totals.force.tolist() == [1.0, 0.0, 5.0]
    # (1, 0, 0) × (0, 0, 5) = (0, -5, 0) and (0, 4, 0) × (1, 0, 0) = (0, 0, -4).
    assert totals.torque.tolist() == [0.0, -5.0, -4.0]


def test_forces_between_particles_along_their_line_have_no_sum_and_no_torque() -> None:
    m, r, v, _ = cloud(7)
    strength = np.random.default_rng(1).normal(size=(7, 7))
    strength = strength + strength.T
    apart = r[:, np.newaxis] - r
    internal = (strength[..., np.newaxis] * apart).sum(axis=1)
    totals = particles.particle_totals(m, r, v, internal, about=[0.3, -2.0, 1.0])
    bound = 49 * ROUNDOFF * np.abs(strength).max() * (1.0 + np.abs(apart).max()) ** 2 * 4.0
    assert np.abs(totals.force).max() < bound
    assert np.abs(totals.torque).max() < bound


def test_about_another_point_the_sums_shift_by_momentum_and_force() -> None:
    m, r, v, f = cloud(7)
    c = np.array([1.0, 2.0, -1.0])
    here, there = (particles.particle_totals(m, r, v, f, about=at) for at in (np.zeros(3), c))
    bound = 16 * ROUNDOFF * (sizes(m, r, v) + sizes(np.ones(7), r, f))
    moved = here.angular_momentum - np.cross(c, here.momentum)
    np.testing.assert_allclose(there.angular_momentum, moved, atol=bound)
    np.testing.assert_allclose(there.torque, here.torque - np.cross(c, here.force), atol=bound)


def test_each_arm_has_its_own_force() -> None:
    """Printed without an index, the torque of the total force on every arm is another number."""
    m, r, v, f = cloud(7)
    torque = particles.particle_totals(m, r, v, f).torque
    truth = np.zeros(3)
    for (x, y, z), (a, b, c) in zip(r, f, strict=True):
        truth += [y * c - z * b, z * a - x * c, x * b - y * a]
    np.testing.assert_allclose(torque, truth, atol=16 * ROUNDOFF * sizes(np.ones(7), r, f))
    printed = np.cross(r, f.sum(axis=0)).sum(axis=0)
    assert np.abs(printed - truth).max() > 0.1 * np.abs(truth).max()


@pytest.mark.parametrize("seed", range(5))
def test_koenig_splits_angular_momentum_and_energy(seed: int) -> None:
    m, r, v, _ = cloud(9, seed)
    r += [3.0, 0.0, -1.0]
    v += [0.0, 2.0, 0.0]
    about = np.array([0.5, -0.2, 0.9])
    whole = particles.particle_totals(m, r, v, about=about)
    parts = particles.split_com(m, r, v, about=about)
    assert parts.kinetic_energy_com + parts.kinetic_energy_relative == pytest.approx(
        float(whole.kinetic_energy), rel=1e-14
    )
    np.testing.assert_allclose(
        parts.angular_momentum_com + parts.angular_momentum_relative,
        whole.angular_momentum,
        atol=1e-14 * sizes(m, r - about, v),
    )
    np.testing.assert_allclose(parts.com, whole.com, rtol=1e-15)
    # What is left has no momentum, and its angular momentum no reference point.
    relative = particles.particle_totals(m, r - parts.com, v - parts.velocity)
    assert np.abs(relative.momentum).max() < 1e-14 * sizes(m, r, v)
    np.testing.assert_allclose(parts.angular_momentum_relative, relative.angular_momentum)
    elsewhere = particles.split_com(m, r, v, about=[9.0, 9.0, 9.0])
    assert np.array_equal(elsewhere.angular_momentum_relative, parts.angular_momentum_relative)


def test_sums_of_many_clouds_are_those_of_each() -> None:
    m, r, v, f = (np.array(of) for of in zip(*(cloud(4, k) for k in range(6)), strict=True))
    many = particles.particle_totals(m, r, v, f)
    split = particles.split_com(m, r, v)
    for k in range(6):
        one = particles.particle_totals(m[k], r[k], v[k], f[k])
        for name in ("mass", "com", "momentum", "angular_momentum", "kinetic_energy", "torque"):
            np.testing.assert_allclose(getattr(many, name)[k], getattr(one, name), rtol=1e-14)
        alone = particles.split_com(m[k], r[k], v[k]).angular_momentum_relative
        np.testing.assert_allclose(split.angular_momentum_relative[k], alone, rtol=1e-12)
    none = particles.particle_totals(m[:0], r[:0], v[:0])
    assert none.com.shape == (0, 3)
    assert none.mass.shape == (0,)


# Conditions


def test_coordinates_of_one_to_eleven_points() -> None:
    rng = np.random.default_rng(3)
    for count in range(1, 12):
        free = particles.degrees_of_freedom(rng.normal(size=(count, 3)))
        pairs = count * (count - 1) // 2
        assert free.rigid == {1: 3, 2: 5}.get(count, 6)
        assert free.conditions == pairs
        assert free.first_order == free.rigid
        assert free.independent == 3 * count - free.rigid
        assert free.redundant == pairs - free.independent
        # Redundant from five points on, while pairs exceed 3 N from eight on only.
        assert (free.redundant > 0) == (count >= 5)
        assert (pairs > 3 * count) == (count > 7)


@pytest.mark.parametrize("count", [2, 3, 7])
def test_points_on_a_line_have_five_coordinates(count: int) -> None:
    along = np.linspace(-1.0, 1.0, count)[:, np.newaxis] * [1.0, 2.0, -0.5] + [4.0, 0.0, 1e3]
    free = particles.degrees_of_freedom(along)
    assert free.rigid == 5
    # To first order distances hold a line along itself only.
    assert free.independent == count - 1
    assert free.first_order == 2 * count + 1


def test_a_plane_is_held_by_distances_to_second_order_only() -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    free = particles.degrees_of_freedom(square)
    assert [free.rigid, free.independent, free.first_order] == [6, 5, 7]
    # Four bars make a linkage in the plane, and fold out of it.
    bars = particles.degrees_of_freedom(square, pairs=[[0, 1], [1, 2], [2, 3], [3, 0]])
    assert [bars.rigid, bars.independent, bars.redundant, bars.first_order] == [6, 4, 0, 8]


def test_points_held_in_space_take_three_two_and_one_coordinates() -> None:
    points = np.random.default_rng(4).normal(size=(6, 3))
    assert [
        int(particles.degrees_of_freedom(points, fixed=range(held)).rigid) for held in range(5)
    ] == [6, 3, 1, 0, 0]
    line = np.arange(4.0)[:, np.newaxis] * [1.0, 1.0, 0.0]
    assert [
        int(particles.degrees_of_freedom(line, fixed=range(held)).rigid) for held in range(4)
    ] == [5, 2, 0, 0]
    # The turn about a line that is held.
    beside = np.concatenate([line, [[0.0, 5.0, 1.0]]])
    assert particles.degrees_of_freedom(beside, fixed=(0, 1, 3)).rigid == 1


def test_the_mirror_image_has_the_same_distances_and_is_no_displacement() -> None:
    _, r, _, _ = cloud(4)
    mirrored = r * [1.0, 1.0, -1.0]
    assert particles.rigidity_residual([r, mirrored]).max() < 4 * ROUNDOFF
    with pytest.raises(ValueError, match="after: a mirror image of before; no rotation"):
        particles.rigid_motion(r, mirrored)


def test_counts_do_not_depend_on_units_or_origin() -> None:
    clouds = np.random.default_rng(5).normal(size=(3, 5, 3))
    plain = particles.degrees_of_freedom(clouds)
    assert plain.rigid.tolist() == [6, 6, 6]
    for scale, shift in ((1e-9, 0.0), (1e12, 0.0), (1.0, 1e4)):
        free = particles.degrees_of_freedom(scale * clouds + shift)
        for name in ("rigid", "independent", "first_order"):
            assert np.array_equal(getattr(free, name), getattr(plain, name))


def test_residual_of_a_body_is_rounding_and_of_springs_is_not() -> None:
    _, r, _, _ = cloud(6)
    scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
    run = rigid.simulate(scene, [0.3, 1.0, 0.2], t=np.linspace(0.0, 50.0, 101))
    path = np.stack([turn.apply(r) for turn in run.rotation()]) + run.t[:, None, None]
    residual = particles.rigidity_residual(path)
    assert residual.shape == (101,)
    assert residual[0] == 0.0
    assert residual.max() < 1e-12
    stretched = path * (1.0 + 1e-6 * run.t[:, None, None])
    np.testing.assert_allclose(
        particles.rigidity_residual(stretched), 1e-6 * run.t, atol=1e-12 * run.t.max()
    )
    assert particles.rigidity_residual(path[:, :1]).tolist() == [0.0] * 101


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
    found = particles.screw(np.eye(3), [[0.0, 0.3, 0.4], [0.0, 0.0, 0.0]])
    assert found.angle.tolist() == [0.0, 0.0]
    assert found.axis.tolist() == [[0.0, 0.6, 0.8], [0.0, 0.0, 0.0]]
    assert found.advance.tolist() == [0.5, 0.0]
    assert found.pitch.tolist() == [np.inf, 0.0]
    assert found.point.tolist() == [[0.0, 0.0, 0.0]] * 2
    # Squares of these shifts are no doubles.
    assert particles.screw(np.eye(3), [[1e-200, 0, 0], [0, 1e300, 0]]).advance.tolist() == [
        1e-200,
        1e300,
    ]
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


# The thrown body


def test_a_free_body_goes_straight_and_a_constant_force_makes_a_parabola() -> None:
    straight = throw([0.0, 0.0, 0.0])
    line = np.array([1.0, 2.0, 3.0]) + TIMES[:, None] * [0.5, -1.0, 4.0]
    assert np.array_equal(straight.position, line)
    assert np.array_equal(straight.velocity, np.broadcast_to([0.5, -1.0, 4.0], (41, 3)))
    force = np.array([0.3, 0.0, -9.81 * 1.7])
    thrown = throw(force)
    np.testing.assert_allclose(
        thrown.position, line + 0.5 * force / 1.7 * TIMES[:, None] ** 2, atol=8e-15 * 60
    )
    np.testing.assert_allclose(
        thrown.velocity, [0.5, -1.0, 4.0] + force / 1.7 * TIMES[:, None], atol=1e-14
    )
    # A force through the centre of mass turns nothing.
    assert thrown.rotation.omega.tobytes() == straight.rotation.omega.tobytes()
    assert thrown.rotation.attitude is not None
    alone = rigid.simulate(rigid.FreeBody(BODY), RATES, t=TIMES)
    assert present(thrown.rotation.attitude).tobytes() == present(alone.attitude).tobytes()


def test_without_torque_the_momentum_is_constant_and_the_rotation_is_not() -> None:
    """ "Zero torque leaves the rotation unchanged" is wrong about any axis but a principal one."""
    path = throw([0.0, 0.0, 0.0], t=np.linspace(0.0, 40.0, 401))
    run = path.rotation
    body_momentum = angular_momentum(rigid.FreeBody(BODY), run.omega)
    momentum = np.stack(
        [turn.apply(one) for turn, one in zip(run.rotation(), body_momentum, strict=True)]
    )
    assert np.ptp(momentum, axis=0).max() < 1e-12
    assert np.ptp(run.omega[:, 1]) > 1.99


def test_sampled_forces_are_integrated_to_fourth_order() -> None:
    def error(count: int) -> float:
        t = np.linspace(-1.0, 3.0, count)
        force = 1.7 * np.stack([np.cos(2 * t), np.exp(-t), 0 * t], axis=1)
        path = throw(force, t=t)
        x = 1.0 + 0.5 * t + (1.0 - np.cos(2 * t)) / 4.0
        y = 2.0 - t + np.exp(-t) + t - 1.0
        truth = np.stack([x, y, 3.0 + 4.0 * t], axis=1)
        start = path.position[np.argmin(np.abs(t))]
        np.testing.assert_allclose(start, [1.0, 2.0, 3.0], atol=1e-14)
        return float(np.abs(path.position - truth).max())

    coarse, fine = error(41), error(81)
    assert fine < 1e-6
    assert coarse / fine == pytest.approx(16.0, rel=0.15)


def test_a_sampled_line_of_forces_is_exact() -> None:
    # A straight line is its own spline: x = F0 t²/2m + F1 t³/6m.
    t = np.array([0.0, 0.3, 1.0, 2.0])
    first, slope = np.array([0.2, -0.4, 1.0]), np.array([1.0, 0.5, -2.0])
    s = t[:, None]
    path = throw(first + slope * s, t=t)
    truth = [1.0, 2.0, 3.0] + s * [0.5, -1.0, 4.0] + (first * s**2 / 2 + slope * s**3 / 6) / 1.7
    np.testing.assert_allclose(path.position, truth, atol=1e-13)


def test_many_bodies_are_thrown_at_once() -> None:
    omega = np.array([[0.0, 1.0, 0.1], [0.3, 0.0, 2.0]])
    path = throw([0.0, 0.0, -1.0], omega=omega, position=[[0.0, 0, 0], [1, 1, 1]])
    assert path.position.shape == (2, 41, 3)
    assert path.rotation.omega.shape == (2, 41, 3)
    np.testing.assert_allclose(path.position[1] - path.position[0], 1.0, atol=1e-13)
    own = np.array([[[0.0, 0.0, -1.0]], [[0.0, 0.0, -2.0]]])
    each = throw(own, omega=omega)
    np.testing.assert_allclose(each.velocity[:, -1, 2], 4.0 - np.array([1.0, 2.0]) * 5.0 / 1.7)
    sampled = throw(own * TIMES[:, np.newaxis], omega=omega)
    fallen = -np.array([1.0, 2.0]) * 5.0**2 / 2.0 / 1.7
    np.testing.assert_allclose(sampled.velocity[:, -1, 2], 4.0 + fallen)
    none = throw([0.0, 0.0, -1.0], omega=np.zeros((0, 3)))
    assert none.position.shape == (0, 41, 3)


FORCES: list[dict[str, Any]] = [
    {"torque": rigid.Torque.space((-0.05, 1.0, 0.05))},
    {"torque": rigid.Torque.body((0.0, 0.1, 0.3))},
    {"damping": 0.5},
    {"drag": 0.2},
    {"rotor": (0.0, 0.0, 2.0)},
    {"dissipation": rigid.EnergySink(0.2)},
]


@pytest.mark.parametrize("forces", FORCES, ids=lambda forces: next(iter(forces)))
def test_a_thrown_body_turns_under_its_torques(forces: dict[str, Any]) -> None:
    scene = rigid.FreeBody(BODY, **forces)
    weight = [0.0, 0.0, -9.81 * 1.7]
    start: Any = [0.0, 0.0, 2.0], [3.0, 0.0, 1.0], RATES
    path = particles.propagate_body(scene, *start, force=weight, t=TIMES)
    alone = particles.propagate_body(BODY, *start, force=weight, t=TIMES)
    assert np.array_equal(path.position, alone.position)
    truth, _ = solved(scene, RATES, [1.0, 0.0, 0.0, 0.0], [5.0])
    assert path.rotation.omega[-1] == pytest.approx(truth[-1], abs=1e-7)
    assert np.abs(path.rotation.omega[-1] - alone.rotation.omega[-1]).max() > 0.01


# Refusals

POINTS = np.eye(3)


def thrown(body: Any) -> particles.BodyPath:
    return particles.propagate_body(body, np.zeros(3), np.zeros(3), RATES, t=1.0)


test_what_has_no_totals_is_refused = refuses(
    [
        ([1.0, -1.0, 2.0], POINTS, POINTS, "masses[1] = -1.0: must not be negative"),
        (np.zeros(3), POINTS, POINTS, "masses, shape (3,): their sum must be positive"),
        (np.ones(3), POINTS * NAN, POINTS, "positions[0, 0] = nan: must be finite"),
        (np.ones(3), POINTS, [1.0, 2.0, 3.0], "velocities: expected shape (..., N, 3), got (3,)"),
        (
            *(np.ones(3), POINTS, POINTS, np.ones((2, 3))),
            "forces (2, 3), positions (3, 3): must have as many particles each",
        ),
    ],
    by=particles.particle_totals,
    literal=True,
)

test_what_has_no_coordinates_is_refused = refuses(
    [
        ({"positions": np.zeros((0, 3))}, "positions: expected at least one point"),
        ({"fixed": [3]}, "fixed = 3: there are 3 points, counted from 0"),
        ({"pairs": [[0, 1], [2, 2]]}, "pairs = [2, 2]: must be two different points of 3"),
        ({"pairs": [0, 1]}, "pairs: expected whole numbers of shape (P, 2), got (2,)"),
        ({"positions": POINTS[[0, 1, 1]]}, "positions: points 1 and 2 coincide"),
    ],
    by=lambda given: particles.degrees_of_freedom(**{"positions": POINTS, **given}),
    literal=True,
)


REFUSED: list[tuple[Any, ...]] = [
    (
        lambda: particles.split_com([], np.zeros((0, 3)), np.zeros((0, 3))),
        "masses, shape (0,): their sum must be positive",
    ),
    (
        lambda: particles.split_com([1.0], POINTS, POINTS),
        "masses (1,), positions (3, 3), velocities (3, 3): must have as many particles each",
    ),
    (
        lambda: particles.rigidity_residual(np.zeros((0, 3, 3))),
        "positions: expected at least one time",
    ),
    (
        lambda: particles.rigid_motion(POINTS, POINTS[:2]),
        "before (3, 3), after (2, 3), weights (3,): must have as many points each",
    ),
    (
        lambda: particles.rigid_motion(POINTS, POINTS, [1.0, -1.0, 1.0]),
        "weights: must not be negative, and not all be zero",
    ),
    (
        lambda: particles.screw(2.0 * np.eye(3), np.zeros(3)),
        "rotation: not a rotation: |R.T R - 1| = 5.2, must be at most 0.00031",
    ),
    (
        lambda: particles.screw(np.diag([1.0, 1.0, -1.0]), np.zeros(3)),
        "rotation: not a rotation: |R.T R - 1| = 0, must be at most 0.00031, det R = -1",
    ),
    (
        lambda: particles.velocity_field([1.0, 2.0], POINTS),
        "omega: expected shape (..., 3), got (2,)",
    ),
    (
        lambda: particles.velocity_field(np.ones((2, 3)), POINTS),
        "omega (2, 3), points (3, 3), velocity (3,), base (3,): the shapes do not broadcast",
    ),
    (
        lambda: particles.fit_omega(POINTS, POINTS[:2]),
        "points (3, 3), velocities (2, 3): must have as many points each",
    ),
    (
        lambda: particles.propagate_body(
            rigid.Body((1, 1, 1)), np.zeros(3), np.zeros(3), RATES, force=[0, 0, 1], t=1.0
        ),
        "body: its mass is None",
    ),
    (
        lambda: throw(np.zeros((3, 3))),
        "force: expected shape (3,) or (..., 41, 3), a row for each of the times, got",
    ),
    (
        lambda: throw(np.zeros((2, 3)), t=[1.0, 2.0]),
        "t = 1 ... 2: times of sampled forces must be strictly ascending and reach",
    ),
    (lambda: throw([0.0, 0.0, NAN]), "force[2] = nan: must be finite"),
    (
        lambda: thrown(rigid.FreeBody(BODY, orbit=rigid.Orbit(0.1))),
        "position, velocity and force move its centre of mass",
    ),
    (lambda: thrown(3), TypeError, "body = 3: must be a rigid.Body"),
]


test_refusals_name_the_argument_and_the_rule = refuses(REFUSED, literal=True)
