"""Tensors of inertia, energy and angular momentum, against sums over mass points."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import ROUNDOFF, tensor_of_points
from refusals import refuses
from rigid import inertia, rotations, solids
from turning_clouds import MASSES, POINTS, TENSORS

RNG = np.random.default_rng(21)
NAN = float("nan")

#: Rounding of a sum over some mass points, relative to its largest term.
ROUNDED = 64 * ROUNDOFF

OMEGA = RNG.normal(size=(10, 3))
VELOCITIES = np.cross(OMEGA[:, None], POINTS)
ENERGY = 0.5 * (MASSES * np.vecdot(VELOCITIES, VELOCITIES)).sum(axis=1)
MOMENTUM = (MASSES[..., None] * np.cross(POINTS, VELOCITIES)).sum(axis=1)


# Tensor of mass points


def test_the_tensor_gives_momentum_and_energy_of_every_cloud() -> None:
    """Ercan 2016 sums L_i over the wrong index (D-13), and twice in § 7 (D-16)."""
    assert np.matvec(TENSORS, OMEGA) == pytest.approx(MOMENTUM, rel=ROUNDED, abs=ROUNDED)
    free, double = TENSORS[0].sum(axis=0) * OMEGA[0], TENSORS[0].sum(axis=0) @ OMEGA[0]
    assert min(np.abs(free - MOMENTUM[0]).max(), np.abs(double - MOMENTUM[0]).max()) > 0.5
    assert 0.5 * np.vecdot(OMEGA, MOMENTUM) == pytest.approx(ENERGY, rel=ROUNDED)
    assert TENSORS[3] == pytest.approx(
        tensor_of_points(MASSES[3], POINTS[3]), rel=ROUNDED, abs=ROUNDED
    )
    point = np.array([0.5, -1.0, 0.25])
    about = inertia.inertia_tensor(MASSES, POINTS, about=point)
    moved = inertia.inertia_tensor(MASSES, POINTS - point)
    assert np.array_equal(about, moved)


def test_the_printed_matrix_is_wrong() -> None:
    """Lecture notes, § 5.4: corners exchanged and products positive, erratum G-09."""
    x, y, z = POINTS[0].T
    entries = [
        [x * x + y * y, x * y, x * z],
        [x * y, x * x + z * z, y * z],
        [x * z, y * z, y * y + z * z],
    ]
    printed = np.array([[float(MASSES[0] @ entry) for entry in row] for row in entries])
    missed = np.linalg.norm(printed @ OMEGA[0] - MOMENTUM[0]) / np.linalg.norm(MOMENTUM[0])
    assert missed > 0.1
    assert TENSORS[0] @ OMEGA[0] == pytest.approx(MOMENTUM[0], rel=ROUNDED)


def test_point_masses_know_their_centre_far_from_the_origin() -> None:
    """Points on a grid of 1/1024 m, which are exact numbers 2^40 m away too."""
    points, shift = np.round(1024.0 * POINTS) / 1024.0, 2.0**40
    far = inertia.point_masses(MASSES, points + shift)
    for masses, cloud, centre in zip(MASSES, points, far.centre, strict=True):
        exact = [Fraction(mass) for mass in masses]
        for column, found in zip(cloud.T, centre, strict=True):
            sums = [mass * Fraction(x) for mass, x in zip(exact, column, strict=True)]
            truth = Fraction(shift) + sum(sums, Fraction()) / sum(exact, Fraction())
            # Half a unit in the last place: one mean of such numbers alone errs by some units.
            assert abs(Fraction(float(found)) - truth) <= 1.01 * ROUNDOFF * 2.0**40


# Composition


def test_any_cut_of_a_cloud_composes_to_the_whole() -> None:
    whole = inertia.point_masses(MASSES, POINTS)
    for cut in range(1, 7):
        parts = [
            inertia.point_masses(MASSES[:, part], POINTS[:, part])
            for part in (slice(cut), slice(cut, None))
        ]
        together = inertia.compose(parts)
        assert together.mass == pytest.approx(whole.mass, rel=ROUNDED)
        assert together.centre == pytest.approx(whole.centre, abs=ROUNDED)
        assert together.tensor == pytest.approx(whole.tensor, rel=ROUNDED, abs=ROUNDED)


def test_principal_moments_of_parts_do_not_add() -> None:
    """The tensors do; lecture notes, § 5.4, says moments: erratum G-15."""
    halves = [
        inertia.inertia_tensor(MASSES[0, part], POINTS[0, part])
        for part in (slice(3), slice(3, None))
    ]
    assert sum(halves) == pytest.approx(TENSORS[0], rel=ROUNDED, abs=ROUNDED)
    added = sum(inertia.principal_axes(half).moments for half in halves)
    assert np.abs(added - inertia.principal_axes(TENSORS[0]).moments).max() > 0.1


def test_a_body_placed_elsewhere_is_the_cloud_placed_elsewhere() -> None:
    turn = rotations.exp_so3([0.4, -0.8, 1.3])
    shift = np.array([1.0, 2.0, -0.5])
    placed = inertia.point_masses(MASSES, POINTS).placed(shift, turn)
    truth = inertia.point_masses(MASSES, np.matvec(turn, POINTS) + shift)
    assert placed.centre == pytest.approx(truth.centre, abs=ROUNDED)
    assert placed.tensor == pytest.approx(truth.tensor, rel=ROUNDED, abs=ROUNDED)
    assert placed.about(shift) == pytest.approx(
        inertia.rotate_tensor(turn, TENSORS), rel=ROUNDED, abs=ROUNDED
    )


# Steiner


def test_steiner_from_the_centre_from_anywhere_and_back() -> None:
    """The middle line of the lecture has y·a for 2 y·a: off by more than rounding (G-14)."""
    cloud = inertia.point_masses(MASSES, POINTS)
    a = RNG.normal(size=(10, 3))
    there = inertia.steiner(cloud.tensor, cloud.mass, a)
    about = inertia.inertia_tensor(MASSES, POINTS, about=cloud.centre + a)
    assert there == pytest.approx(about, rel=ROUNDED, abs=ROUNDED)
    back = inertia.steiner(there, cloud.mass, -a, centre=-a)
    assert back == pytest.approx(cloud.tensor, rel=ROUNDED, abs=ROUNDED)
    anywhere = inertia.steiner(TENSORS, cloud.mass, a, centre=cloud.centre)
    truth = inertia.inertia_tensor(MASSES, POINTS, about=a)
    assert anywhere == pytest.approx(truth, rel=ROUNDED, abs=ROUNDED)
    y = POINTS[0, 2]
    assert abs(y @ y + a[0] @ a[0] + y @ a[0] - (y + a[0]) @ (y + a[0])) > 0.1
    # The trace grows by twice M a².
    grown = np.trace(there - cloud.tensor, axis1=1, axis2=2)
    assert grown == pytest.approx(2.0 * cloud.mass * np.vecdot(a, a), rel=ROUNDED)


def test_steiner_off_the_centre_of_mass_is_wrong() -> None:
    cloud = inertia.point_masses(MASSES, POINTS)
    a = np.array([0.5, -1.0, 0.25])
    off = inertia.steiner(TENSORS, cloud.mass, a) - inertia.inertia_tensor(MASSES, POINTS, about=a)
    assert np.all(np.abs(off).max(axis=(1, 2)) > 0.1)
    # By m (2 a.c - a c^T - c a^T), with c from the origin to the centre of mass.
    c = cloud.centre
    outer = a[:, None] * c[:, None, :] + c[:, :, None] * a
    mixed = 2.0 * np.vecdot(a, c)[:, None, None] * np.eye(3) - outer
    assert off == pytest.approx(cloud.mass[:, None, None] * mixed, rel=ROUNDED, abs=ROUNDED)


def test_a_pivot_on_the_axis_leaves_the_moment_about_the_axis() -> None:
    """I -> I + M h², I3 unchanged; Ercan 2016, § 10, has it the other way round (D-29)."""
    mass, h = 0.8, 0.3
    top = inertia.steiner(np.diag([1.3, 1.3, 0.7]), mass, [0.0, 0.0, -h])
    assert top.diagonal() == pytest.approx([1.3 + mass * h * h] * 2 + [0.7], rel=ROUNDED)


# Rotated tensors


def test_a_rotated_tensor_is_that_of_the_rotated_cloud() -> None:
    turn = rotations.exp_so3(RNG.normal(size=(10, 3)))
    turned = np.matvec(turn[:, None], POINTS)
    rotated = inertia.rotate_tensor(turn, TENSORS)
    assert rotated == pytest.approx(
        inertia.inertia_tensor(MASSES, turned), rel=ROUNDED, abs=ROUNDED
    )
    assert np.trace(rotated, axis1=1, axis2=2) == pytest.approx(
        np.trace(TENSORS, axis1=1, axis2=2), rel=ROUNDED
    )
    assert np.linalg.det(rotated) == pytest.approx(np.linalg.det(TENSORS), rel=ROUNDED)
    moments = inertia.principal_axes(rotated).moments
    assert moments == pytest.approx(inertia.principal_axes(TENSORS).moments, rel=ROUNDED)
    vector = inertia.rotate_tensor(turn, MOMENTUM, order=1)
    assert vector == pytest.approx(np.matvec(turn, MOMENTUM), rel=ROUNDED, abs=ROUNDED)
    assert np.array_equal(inertia.rotate_tensor(turn, ENERGY, order=0), ENERGY)


def test_the_printed_proof_has_a_third_lambda() -> None:
    """Ercan 2016, § 7: lambda_ik lambda_jl lambda_kl for ... I_kl, erratum D-17."""
    turn = rotations.exp_so3([0.4, -0.8, 1.3])
    truth = tensor_of_points(MASSES[0], POINTS[0] @ turn.T)
    printed = np.einsum("ik,jl,kl->ij", turn, turn, turn)
    corrected = np.einsum("ik,jl,kl->ij", turn, turn, TENSORS[0])
    assert corrected == pytest.approx(truth, rel=ROUNDED, abs=ROUNDED)
    assert np.abs(printed - truth).max() > 0.5 * np.abs(truth).max()


# Energy and angular momentum


def test_three_forms_of_the_energy_agree() -> None:
    """And the printed ones do not: the factor ½ (G-12), a cross for a dot product (D-12)."""
    assert inertia.rotational_energy(OMEGA, TENSORS) == pytest.approx(ENERGY, rel=ROUNDED)
    from_momentum = inertia.energy_from_momentum(MOMENTUM, TENSORS)
    assert from_momentum == pytest.approx(ENERGY, rel=1e-12)
    axes = inertia.principal_axes(TENSORS)
    rates = np.vecmat(OMEGA, axes.axes)
    principal_form = (axes.moments * rates**2).sum(axis=1)
    assert 0.5 * principal_form == pytest.approx(ENERGY, rel=ROUNDED)
    assert np.all(np.abs(principal_form / ENERGY - 1.0) > 0.9)
    r2, w2 = np.vecdot(POINTS, POINTS), np.vecdot(OMEGA, OMEGA)[:, None]
    dot = np.vecdot(OMEGA[:, None], POINTS)
    right = 0.5 * (MASSES * (w2 * r2 - dot**2)).sum(axis=1)
    printed = 0.5 * (MASSES * (w2 * r2 - np.vecdot(VELOCITIES, VELOCITIES))).sum(axis=1)
    assert right == pytest.approx(ENERGY, rel=ROUNDED)
    assert np.all(np.abs(printed / ENERGY - 1.0) > 0.01)


def test_energy_of_a_flying_body_is_the_sum_over_its_points() -> None:
    cloud = inertia.point_masses(MASSES, POINTS)
    velocity = RNG.normal(size=(10, 3))
    v = velocity[:, None] + np.cross(OMEGA[:, None], POINTS - cloud.centre[:, None])
    truth = 0.5 * (MASSES * np.vecdot(v, v)).sum(axis=1)
    found = inertia.kinetic_energy(OMEGA, cloud, cloud.mass, velocity)
    assert found == pytest.approx(truth, rel=ROUNDED)
    # Of the velocity, only the size matters.
    turned = rotations.rotate(velocity, [1.0, 2.0, 3.0], 0.7)
    assert inertia.kinetic_energy(OMEGA, cloud, cloud.mass, turned) == pytest.approx(truth)


def test_momentum_in_the_body_and_in_space_and_back() -> None:
    attitude = Rotation.random(10, rng=RNG)
    assert inertia.angular_momentum(OMEGA, TENSORS) == pytest.approx(MOMENTUM, abs=ROUNDED * 10)
    turn = attitude.as_matrix()
    r, v = np.matvec(turn[:, None], POINTS), np.matvec(turn[:, None], VELOCITIES)
    truth = (MASSES[..., None] * np.cross(r, v)).sum(axis=1)
    space = inertia.angular_momentum(OMEGA, TENSORS, attitude)
    assert space == pytest.approx(truth, abs=ROUNDED * 10)
    for given in (attitude, turn, attitude.as_quat(scalar_first=True)):
        back = inertia.omega_from_momentum(space, TENSORS, given)
        assert back == pytest.approx(OMEGA, abs=1e-12)
    assert inertia.omega_from_momentum(MOMENTUM, TENSORS) == pytest.approx(OMEGA, abs=1e-12)


def test_bodies_mass_properties_moments_and_tensors_mean_the_same() -> None:
    brick = solids.box(0.25, 0.08, 0.01, mass=0.3)
    body = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
    omega = [0.3, 1.0, 0.2]
    given: list[Any] = [body, brick, body.moments, brick.tensor]
    energies = [float(inertia.rotational_energy(omega, each)) for each in given]
    assert energies == pytest.approx([energies[0]] * 4, rel=ROUNDED)
    # Three bodies by their moments are not a tensor.
    moments = np.array([[1.0, 2.0, 2.5]] * 3)
    many = inertia.rotational_energy(omega, moments[..., None] * np.eye(3))
    assert many.shape == (3,)
    assert np.array_equal(inertia.rotational_energy(omega, rigid.Body(moments)), many)


def test_mass_properties_keep_their_numbers_when_the_arrays_of_the_caller_change() -> None:
    mass, centre = np.array([2.0]), np.ones((1, 3))
    kept = inertia.MassProperties(mass=mass, centre=centre, tensor=np.eye(3))
    mass[:], centre[:] = 3.0, 0.0
    assert kept.mass.tolist() == [2.0]
    assert kept.centre.tolist() == [[1.0] * 3]


def test_a_rod_turns_without_momentum_about_itself() -> None:
    rod = solids.rod(2.0, mass=3.0).placed(turn=rotations.exp_so3([0.4, -0.8, 1.3]))
    line = rotations.exp_so3([0.4, -0.8, 1.3])[:, 2]
    omega = np.cross(line, [0.3, 0.4, 0.5])
    momentum = inertia.angular_momentum(omega, rod)
    assert inertia.omega_from_momentum(momentum, rod) == pytest.approx(omega, abs=1e-13)
    assert inertia.energy_from_momentum(momentum, rod) == pytest.approx(
        inertia.rotational_energy(omega, rod), rel=1e-13
    )
    with pytest.raises(ValueError, match="without a moment of inertia"):
        inertia.omega_from_momentum(momentum + line, rod)


# Bodies


def test_bodies_from_points_turn_into_their_principal_axes() -> None:
    for masses, points in zip(MASSES, POINTS, strict=True):
        body, axes = rigid.Body.from_points(masses, points)
        cloud = inertia.point_masses(masses, points)
        assert body.mass == pytest.approx(masses.sum(), rel=ROUNDED)
        assert axes @ np.diag(body.moments) @ axes.T == pytest.approx(cloud.tensor, abs=1e-13)
        pivoted, axes = rigid.Body.from_points(masses, points, about=[0.0, 0.0, 0.0])
        rebuilt_tensor = axes @ np.diag(pivoted.moments) @ axes.T
        assert rebuilt_tensor == pytest.approx(tensor_of_points(masses, points), abs=1e-13)


# Empty batches and bad input


def test_empty_batches() -> None:
    assert inertia.inertia_tensor(np.empty((0, 4)), np.empty((0, 4, 3))).shape == (0, 3, 3)
    assert np.array_equal(inertia.inertia_tensor([], np.empty((0, 3))), np.zeros((3, 3)))
    assert inertia.principal_axes(np.empty((0, 3, 3))).axes.shape == (0, 3, 3)
    none = np.empty((0, 3))
    assert inertia.rotational_energy(none, np.eye(3)).shape == (0,)
    assert inertia.omega_from_momentum(none, np.eye(3)).shape == (0, 3)


LOPSIDED = [[1.0, 0.2, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]]


def test_only_mass_properties_are_mass_properties() -> None:
    wrong: Any = np.eye(3)
    with pytest.raises(TypeError, match=r"must be a rigid\.inertia\.MassProperties"):
        rigid.Body.from_properties(wrong)


test_refused = refuses(
    [
        (lambda: inertia.inertia_tensor([1.0], [[NAN, 0, 0]]), r"points\[0, 0\] = nan"),
        (lambda: inertia.inertia_tensor([1, -1], np.eye(3)[:2]), r"masses\[1\] = -1.0: must not"),
        (lambda: inertia.inertia_tensor([1, 1], np.eye(3)), "masses: expected shape"),
        (lambda: inertia.point_masses([0, 0], np.eye(3)[:2]), "their sum is 0"),
        (lambda: inertia.compose([]), "parts: a body needs at least one"),
        (lambda: inertia.steiner(np.eye(3), -1.0, [1, 0, 0]), "mass = -1.0: must not be negative"),
        (lambda: inertia.steiner(LOPSIDED, 1.0, [1, 0, 0]), "mirror entry"),
        (lambda: inertia.rotate_tensor(2 * np.eye(3), np.eye(3)), "turn: not a rotation"),
        (lambda: inertia.rotate_tensor(np.eye(3), np.eye(3), order=3), "order = 3"),
        (lambda: inertia.principal_axes(LOPSIDED), r"tensor\[0, 1\] = 0.2, but its mirror"),
        (
            lambda: inertia.principal_axes(np.diag([1, 1, 3])),
            r"moments \(1, 1, 3\); none may be negative",
        ),
        (lambda: inertia.principal_axes([np.eye(3), -np.eye(3)]), r"^tensor\[1\]: no body"),
        (lambda: inertia.classify_body([1, 2, NAN]), r"moments\[2\] = nan"),
        (lambda: inertia.classify_body([1, 2, 3], tolerance=-1), "must not be negative"),
        (lambda: inertia.symmetry_check([[1, 2, 3]]), "all mass is in one point"),
        (lambda: inertia.symmetry_check(np.eye(3), [1, 1]), "points: expected shape"),
        (lambda: inertia.rotational_energy([1, 0, 0], [[1, 2, 2.5]]), "diagonal tensors"),
        (lambda: inertia.rotational_energy([1, 0, 0], [1, 1, 3]), "no body has the principal"),
        (lambda: inertia.kinetic_energy([1, 0, 0], [1, 1, 1], -1, [1, 0, 0]), "mass = -1.0"),
        (
            lambda: inertia.MassProperties(mass=0, centre=[0, 0, 0], tensor=np.eye(3)),
            "mass = 0.0: must be positive",
        ),
        (
            lambda: inertia.MassProperties(mass=1, centre=[0, 0, 0], tensor=np.diag([1, 1, 3])),
            "no body has the principal",
        ),
        (lambda: rigid.Body.from_points([1], [[0, 0, 1]]), "moments = "),
        (
            lambda: rigid.Body.from_properties(solids.sphere([1.0, 2.0])),
            r"expected one body, got shape \(2,\)",
        ),
    ]
)
