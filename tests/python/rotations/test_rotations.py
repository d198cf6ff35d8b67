"""Rotations made from each other, against SciPy, matrix exponentials and printed formulas."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy import cos, pi, sin
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from physics import ROUNDOFF, Floats, rotation_angle, rotation_matrix
from refusals import refuses
from rigid import rotations
from rotation_cases import prescribed

RNG = np.random.default_rng(20)
NAN = float("nan")

#: Rounding of a product of three matrices of entries up to one, or of an angle made from one.
ROUNDED = 16 * ROUNDOFF

#: Angles at which formulas of rotations break: none, tiny, about half a turn, more than one.
ANGLES = [
    *(0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 0.3, 1.0, 2.0),
    *(pi - 1e-4, pi - 1e-9, pi - 1e-14, pi),
]
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3), RNG.normal(size=(20, 3))])
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


def random_rotations(n: int) -> Floats:
    return np.asarray(Rotation.random(n, rng=RNG).as_matrix())


# Elementary rotations and axis and angle


def test_elementary_rotations_are_the_printed_matrices() -> None:
    """D, C and B of Goldstein and of Ercan 2016, eqs. (3), (5), (7), are the passive ones."""
    phi, theta, psi = 0.7, 1.1, -0.4
    d = [[cos(phi), sin(phi), 0.0], [-sin(phi), cos(phi), 0.0], [0.0, 0.0, 1.0]]
    c = [[1.0, 0.0, 0.0], [0.0, cos(theta), sin(theta)], [0.0, -sin(theta), cos(theta)]]
    b = [[cos(psi), sin(psi), 0.0], [-sin(psi), cos(psi), 0.0], [0.0, 0.0, 1.0]]
    assert np.array_equal(rotations.rotation_z(phi, passive=True), d)
    assert np.array_equal(rotations.rotation_x(theta, passive=True), c)
    assert np.array_equal(rotations.rotation_z(psi, passive=True), b)


def test_plane_coordinates_seen_from_turned_axes() -> None:
    """Ercan 2016, eqs. (1), (2): a point at r, alpha is at r, alpha - phi; erratum D-03."""
    r, alpha, phi = 2.0, 0.8, 0.7
    seen = rotations.rotation_z(phi, passive=True) @ [r * cos(alpha), r * sin(alpha), 0.0]
    expected = [r * cos(alpha - phi), r * sin(alpha - phi), 0.0]
    assert seen == pytest.approx(expected, abs=ROUNDED)
    assert abs(r * sin(alpha - phi) - r * sin(alpha)) > 1.0  # y'' is not y'


@pytest.mark.parametrize(
    ("turn", "axis"),
    [(rotations.rotation_x, 0), (rotations.rotation_y, 1), (rotations.rotation_z, 2)],
    ids="xyz",
)
def test_elementary_rotations_turn_about_their_axes(turn: Callable[..., Floats], axis: int) -> None:
    a, b = RNG.uniform(-4.0, 4.0, (2, 5))
    matrices = turn(a)
    assert matrices == pytest.approx(
        Rotation.from_rotvec(np.outer(a, np.eye(3)[axis])).as_matrix(), abs=ROUNDED
    )
    assert np.linalg.det(matrices) == pytest.approx(1.0, abs=ROUNDED)
    assert turn(a) @ turn(b) == pytest.approx(turn(a + b), abs=ROUNDED)  # angles add
    assert np.array_equal(turn(a, passive=True), np.swapaxes(matrices, -1, -2))


def test_axis_and_angle_are_the_exponential() -> None:
    for n, angle in zip(DIRECTIONS, RNG.uniform(-7.0, 7.0, len(DIRECTIONS)), strict=True):
        matrix = rotations.axis_angle_matrix(3.0 * n, angle)
        assert matrix == pytest.approx(expm(angle * rotations.hat(n)), abs=1e-13)
        assert matrix == pytest.approx(Rotation.from_rotvec(angle * n).as_matrix(), abs=ROUNDED)
        x = RNG.normal(size=3)
        assert rotations.rotate(x, n, angle) == pytest.approx(matrix @ x, abs=4 * ROUNDED)
        passive = rotations.axis_angle_matrix(n, angle, passive=True)
        assert passive == pytest.approx(matrix.T, abs=ROUNDED)
        assert passive @ (matrix @ x) == pytest.approx(x, abs=4 * ROUNDED)


def test_the_printed_rodrigues_formula_is_wrong() -> None:
    """The lecture's passive formula has n(n × x) for n(n·x): erratum G-06."""
    n, angle, x = DIRECTIONS[10], 0.9, np.array([0.3, -1.0, 0.7])

    def formula(along: Floats) -> Floats:
        result: Floats = x * cos(angle) + along * (1.0 - cos(angle)) - np.cross(n, x) * sin(angle)
        return result

    passive = expm(-angle * rotations.hat(n)) @ x
    ours = rotations.rotate(x, n, angle, passive=True)
    assert ours == pytest.approx(passive, abs=ROUNDED)
    assert formula(n * (n @ x)) == pytest.approx(passive, abs=ROUNDED)
    assert np.abs(formula(np.cross(n, np.cross(n, x))) - passive).max() > 0.1


def test_no_turn_half_a_turn_and_a_full_turn() -> None:
    x = np.array([0.3, -1.0, 0.7])
    for n in DIRECTIONS:
        assert np.array_equal(rotations.rotate(x, n, 0.0), x)
        assert np.array_equal(rotations.axis_angle_matrix(n, 0.0), np.eye(3))
        half = 2.0 * n * (n @ x) - x
        assert rotations.rotate(x, n, pi) == pytest.approx(half, abs=ROUNDED)
        assert rotations.rotate(x, n, 2.0 * pi) == pytest.approx(x, abs=ROUNDED)


def test_axes_angles_and_vectors_broadcast() -> None:
    turned = rotations.rotate(np.ones((4, 1, 3)), np.eye(3), np.zeros((5, 1, 1)) + 0.1)
    assert turned.shape == (5, 4, 3, 3)
    assert rotations.axis_angle_matrix(np.empty((0, 3)), 1.0).shape == (0, 3, 3)
    assert rotations.rotation_x(np.empty((2, 0))).shape == (2, 0, 3, 3)


# Exponential and logarithm


def test_hat_and_vee() -> None:
    a, b = RNG.normal(size=(2, 7, 3))
    assert np.matvec(rotations.hat(a), b) == pytest.approx(np.cross(a, b), abs=ROUNDED)
    assert np.array_equal(rotations.vee(rotations.hat(a)), a)
    # Of any matrix, the antisymmetric part.
    assert rotations.vee(rotations.hat(a) + np.ones((3, 3))) == pytest.approx(a, abs=ROUNDED)


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_and_logarithm_at_every_angle(angle: float) -> None:
    """To a rounding of the vector itself for small turns, and of pi for large ones."""
    vectors = angle * DIRECTIONS
    matrices = rotations.exp_so3(vectors)
    assert rotations.orthogonality_error(matrices).error.max() < ROUNDED
    back = rotations.log_so3(matrices)
    quaternion = rotations.log_quaternion(rotations.exp_quaternion(vectors))
    for found in (back, quaternion):
        if angle == pi:  # then v and -v are one rotation
            found = np.where((np.vecdot(found, vectors) < 0.0)[:, None], -found, found)
        error = np.abs(found - vectors).max()
        # exp_so3 stores a tiny angle beside 1 - x²/2, each with its own rounding.
        assert error <= 8 * ROUNDOFF * angle + (ROUNDED if angle > 3.0 else 0.0)


def test_exponential_against_scipy_and_to_first_order() -> None:
    vectors = RNG.normal(size=(100, 3)) * RNG.uniform(0.0, 4.0, (100, 1))
    truth = Rotation.from_rotvec(vectors)
    assert rotations.exp_so3(vectors) == pytest.approx(truth.as_matrix(), abs=2 * ROUNDED)
    assert rotations.log_so3(truth.as_matrix()) == pytest.approx(truth.as_rotvec(), abs=2 * ROUNDED)
    n, x, small = DIRECTIONS[8], np.array([0.3, -1.0, 0.7]), 1e-6
    moved = (rotations.exp_so3(small * n) @ x - x) / small
    assert moved == pytest.approx(np.cross(n, x), abs=1e-6)
    # The lecture's small turn x' = x - eps n × x is the passive one.
    moved = (rotations.rotate(x, n, small, passive=True) - x) / small
    assert moved == pytest.approx(-np.cross(n, x), abs=1e-6)


def test_finite_turns_do_not_commute() -> None:
    """The commutator of two small turns is their cross product, to third order."""
    a, b = 1e-3 * DIRECTIONS[8], 1e-3 * DIRECTIONS[9]
    there, back = rotations.exp_so3([a, b]), rotations.exp_so3([-a, -b])
    around = rotations.log_so3(there[0] @ there[1] @ back[0] @ back[1])
    assert np.abs(around).max() > 1e-7
    assert around == pytest.approx(np.cross(a, b), abs=2e-9)


# Quaternions


def test_quaternions_against_scipy() -> None:
    p, q = Rotation.random(50, rng=RNG), Rotation.random(50, rng=RNG)
    a, b = p.as_quat(scalar_first=True), q.as_quat(scalar_first=True)
    product = rotations.quaternion_product(a, b)
    assert rotation_angle(product, (p * q).as_quat(scalar_first=True)).max() < ROUNDED
    assert rotations.quaternion_to_matrix(a) == pytest.approx(p.as_matrix(), abs=ROUNDED)
    found = rotations.matrix_to_quaternion(p.as_matrix())
    assert found == pytest.approx(p.as_quat(canonical=True, scalar_first=True), abs=ROUNDED)
    assert rotations.quaternion_to_matrix(b) == pytest.approx(rotation_matrix(b), abs=ROUNDED)


def test_the_sign_of_a_quaternion_is_fixed() -> None:
    q = np.array([[1, 2, 3, 4], [0, 2, -3, 4], [0, 0, -3, 4], [0, 0, 0, -1], [-1, 0, 0, 0.0]])
    plus, minus = rotations.canonical_quaternion(q), rotations.canonical_quaternion(-q)
    assert np.array_equal(plus, minus)
    assert np.sign(plus[range(5), [0, 1, 2, 3, 0]]).tolist() == [1.0] * 5
    assert not np.signbit(plus[3]).any()
    for k in range(3):
        half_turn = np.diag(2.0 * np.eye(3)[k] - 1.0)
        assert np.array_equal(rotations.log_so3(half_turn), pi * np.eye(3)[k])
    half_turns = rotations.axis_angle_matrix(DIRECTIONS, pi)
    assert np.all(rotations.matrix_to_quaternion(half_turns)[:, 0] >= 0.0)
    for scale in (1e-300, 1e300):
        assert rotations.canonical_quaternion(scale * q) == pytest.approx(plus, abs=ROUNDOFF * 4)


# How nearly a rotation


def test_orthogonality_error_and_the_nearest_rotation() -> None:
    clean = random_rotations(50)
    how = rotations.orthogonality_error(clean)
    assert how.error.max() < ROUNDED
    assert how.determinant == pytest.approx(np.ones(50), abs=ROUNDED)
    assert rotations.orthogonality_error(-clean).determinant == pytest.approx(-np.ones(50))
    noise = RNG.normal(size=clean.shape)
    for size in (1e-12, 1e-6, 1e-2):
        bent = clean + size * noise
        found = rotations.nearest_rotation(bent)
        assert rotations.orthogonality_error(found).error.max() < ROUNDED
        assert np.abs(found - clean).max() < 8.0 * size
        # No small turn brings it nearer to what was given.
        distance = np.linalg.norm(found - bent, axis=(-2, -1))
        for turn in rotations.exp_so3(1e-3 * np.concatenate([np.eye(3), -np.eye(3)])):
            assert np.all(np.linalg.norm(found @ turn - bent, axis=(-2, -1)) > distance)
    stretched = rotations.nearest_rotation(clean @ np.diag([2.0, 1.0, 0.1]))
    assert stretched == pytest.approx(clean, abs=ROUNDED)
    flat = rotations.nearest_rotation(np.diag([1.0, 1.0, 1e-6]))
    assert flat == pytest.approx(np.eye(3), abs=ROUNDED)


def test_empty_batches() -> None:
    assert rotations.log_so3(np.empty((0, 3, 3))).shape == (0, 3)
    assert rotations.matrix_to_euler(np.empty((4, 0, 3, 3))).shape == (4, 0, 3)
    none = np.empty((0, 3))
    assert rotations.euler_rates_from_omega(none, none).rates.shape == (0, 3)
    assert rotations.nearest_rotation(np.empty((0, 3, 3))).shape == (0, 3, 3)


# Bad input

MIRROR = np.diag([1.0, 1.0, -1.0])


test_refused = refuses(
    [
        (lambda: rotations.rotation_x(NAN), "angle.* = nan: must be finite"),
        (lambda: rotations.hat([1.0, 2.0]), r"vector: expected shape \(\.\.\., 3\), got \(2,\)"),
        (lambda: rotations.exp_so3([0, 0, np.inf]), r"vector\[2\] = inf: must be finite"),
        (lambda: rotations.log_so3(MIRROR), r"matrix: not a rotation: .*det R = -1"),
        (lambda: rotations.matrix_to_euler([np.eye(3), 2 * np.eye(3)]), r"matrix\[1\]: not a rot"),
        (lambda: rotations.nearest_rotation(MIRROR), "its determinant is -1; a mirror image"),
        (lambda: rotations.nearest_rotation(np.diag([1.0, 1.0, 0.0])), "a singular matrix"),
        (lambda: rotations.canonical_quaternion([0, 0, 0, 0]), "a zero quaternion is no rotation"),
        (lambda: rotations.axis_angle_matrix([0, 0, 0], 1.0), r"axis = \[0.0, 0.0, 0.0\]: no dir"),
        (lambda: rotations.euler_axes([0, 0, 0], frame="bod"), "did you mean 'body'"),
        (lambda: rotations.euler_rates_from_omega([0, pi, 0], [1, 0, 0]), "on the vertical"),
        (lambda: rotations.omega_from_attitudes(np.eye(4), [0, 1, 1, 2]), "strictly ascending"),
        (lambda: rotations.omega_from_attitudes(np.eye(4), [0, 1]), "times of at least 2 att"),
        (lambda: rotations.omega_from_attitudes(np.zeros((2, 5)), [0, 1]), r"\(\.\.\., 4\) or"),
        (lambda: rotations.omega_from_attitudes(np.zeros((2, 4)), [0, 1]), "no attitude"),
        (lambda: rotations.attitude_from_samples(np.eye(3), [0, 1, 2]), "at least 4 samples"),
        (lambda: rotations.attitude_from_omega(prescribed, []), "at least one time"),
        (lambda: rotations.attitude_from_omega(prescribed, [0, 1], tolerance=0), "positive"),
        (lambda: rotations.attitude_from_omega(prescribed, [0, 1], tolerance=1e-16), "at least"),
        (lambda: rotations.attitude_from_omega(lambda t: [1, 0, 0], [0, 1]), r"omega\(t\): exp"),
        (lambda: rotations.attitude_from_omega(prescribed, [0, 1], frame="node"), "frame = 'node'"),
    ],
)
