"""Clouds of particles: sums and conditions."""

from typing import Any

import numpy as np
import pytest

import rigid
from clouds import RATES, cloud, throw
from physics import ROUNDOFF, Floats
from refusals import refuses
from rigid import particles

NAN = float("nan")


def sizes(masses: Floats, positions: Floats, velocities: Floats) -> float:
    """A bound of the terms that the sums are made of."""
    lengths = np.linalg.norm(positions, axis=-1) + np.linalg.norm(velocities, axis=-1)
    return float((masses * (1.0 + lengths) ** 2).sum())


# Sums


def test_totals_of_two_masses_by_hand() -> None:
    # 2 kg at (1, 0, 0) with (0, 3, 0) m/s under (0, 0, 5) N; 1 kg at (0, 4, 0) with (1, 0, 1) m/s
    # under (1, 0, 0) N.
    totals = particles.particle_totals(
        [2.0, 1.0],
        [[1, 0, 0], [0, 4, 0]],
        [[0, 3, 0], [1, 0, 1]],
        [[0, 0, 5], [1, 0, 0]],
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


# Refusals

POINTS = np.eye(3)
REFUSED: list[tuple[Any, ...]] = [
    (
        lambda: particles.particle_totals([1.0, -1.0, 2.0], POINTS, POINTS),
        "masses[1] = -1.0: must not be negative",
    ),
    (
        lambda: particles.particle_totals(np.zeros(3), POINTS, POINTS),
        "masses, shape (3,): their sum must be positive",
    ),
    (
        lambda: particles.split_com([], np.zeros((0, 3)), np.zeros((0, 3))),
        "masses, shape (0,): their sum must be positive",
    ),
    (
        lambda: particles.split_com([1.0], POINTS, POINTS),
        "masses (1,), positions (3, 3), velocities (3, 3): must have as many particles each",
    ),
    (
        lambda: particles.particle_totals(np.ones(3), POINTS * NAN, POINTS),
        "positions[0, 0] = nan: must be finite",
    ),
    (
        lambda: particles.particle_totals(np.ones(3), POINTS, [1.0, 2.0, 3.0]),
        "velocities: expected shape (..., N, 3), got (3,)",
    ),
    (
        lambda: particles.particle_totals(np.ones(3), POINTS, POINTS, np.ones((2, 3))),
        "forces (2, 3), positions (3, 3): must have as many particles each",
    ),
    (
        lambda: particles.degrees_of_freedom(np.zeros((0, 3))),
        "positions: expected at least one point",
    ),
    (
        lambda: particles.degrees_of_freedom(POINTS, fixed=[3]),
        "fixed = 3: there are 3 points, counted from 0",
    ),
    (
        lambda: particles.degrees_of_freedom(POINTS, pairs=[[0, 1], [2, 2]]),
        "pairs = [2, 2]: must be two different points of 3",
    ),
    (
        lambda: particles.degrees_of_freedom(POINTS, pairs=[0, 1]),
        "pairs: expected whole numbers of shape (P, 2), got (2,)",
    ),
    (
        lambda: particles.degrees_of_freedom([[0, 0, 0], [1, 0, 0], [1, 0, 0]]),
        "positions: points 1 and 2 coincide",
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
]


test_refusals_name_the_argument_and_the_rule = refuses(
    REFUSED,
    literal=True,
)
