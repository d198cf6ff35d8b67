"""Rotations and Euler angles made from each other, against SciPy and printed formulas."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy import cos, pi, sin
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation, RotationSpline

import rigid
from physics import ROUNDOFF, Floats, derivative, present, rotation_angle, rotation_matrix
from refusals import refuses
from rigid import rotations
from rigid.rotations import sampled
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


@pytest.mark.parametrize(("method", "lost"), [("splitting", 1e-12), ("rk4", 1e-9)])
def test_long_runs_stay_rotations(method: str, lost: float) -> None:
    """A hundred thousand steps: the splitting turns; RK4 loses length, which is reported."""
    scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    t = np.linspace(0.0, 1e3, 11)
    run = rigid.simulate(scene, [0.3, 1.0, 0.2], t=t, method=method, step=1e-2)
    attitude = present(run.attitude)
    # The matrix of a quaternion as it stands, not brought to length one.
    square = np.vecdot(attitude, attitude)[..., None, None]
    matrices = square * rotations.quaternion_to_matrix(attitude)
    error = rotations.orthogonality_error(matrices).error.max()
    assert error < lost
    assert (method == "rk4") == (error > 1e-11)
    nearest = rotations.nearest_rotation(matrices)
    assert rotations.orthogonality_error(nearest).error.max() < ROUNDED


def test_empty_batches() -> None:
    assert rotations.log_so3(np.empty((0, 3, 3))).shape == (0, 3)
    assert rotations.matrix_to_euler(np.empty((4, 0, 3, 3))).shape == (4, 0, 3)
    none = np.empty((0, 3))
    assert rotations.euler_rates_from_omega(none, none).rates.shape == (0, 3)
    assert rotations.nearest_rotation(np.empty((0, 3, 3))).shape == (0, 3, 3)


# Euler angles


def test_euler_angles_have_the_nine_printed_elements() -> None:
    """A = BCD of Goldstein, § 4.4, and of Ercan 2016, § 3."""
    phi, theta, psi = 0.7, 1.1, -0.4
    c, s = np.cos, np.sin
    printed = [
        [
            c(psi) * c(phi) - c(theta) * s(phi) * s(psi),
            c(psi) * s(phi) + c(theta) * c(phi) * s(psi),
            s(psi) * s(theta),
        ],
        [
            -s(psi) * c(phi) - c(theta) * s(phi) * c(psi),
            -s(psi) * s(phi) + c(theta) * c(phi) * c(psi),
            c(psi) * s(theta),
        ],
        [s(theta) * s(phi), -s(theta) * c(phi), c(theta)],
    ]
    a = rotations.euler_to_matrix([phi, theta, psi], passive=True)
    assert a == pytest.approx(np.array(printed), abs=ROUNDED)
    assert a @ a.T == pytest.approx(np.eye(3), abs=ROUNDED)
    angles = RNG.uniform(-7.0, 7.0, (50, 3))
    truth = Rotation.from_euler("ZXZ", angles)
    assert rotations.euler_to_matrix(angles) == pytest.approx(truth.as_matrix(), abs=ROUNDED)
    q = rotations.euler_to_quaternion(angles)
    assert q == pytest.approx(truth.as_quat(canonical=True, scalar_first=True), abs=ROUNDED)


@pytest.mark.parametrize("tilt", [0.0, 1e-300, 1e-17, 1e-15, 1e-12, 1e-8, 1e-3, 1.0])
@pytest.mark.parametrize("below", [False, True])
def test_euler_angles_come_back(tilt: float, below: bool) -> None:
    theta = pi - tilt if below else tilt
    angles = np.stack(
        np.broadcast_arrays(RNG.uniform(-pi, pi, 200), theta, RNG.uniform(-pi, pi, 200)), axis=-1
    )
    matrices, q = rotations.euler_to_matrix(angles), rotations.euler_to_quaternion(angles)
    for found in (
        rotations.matrix_to_euler(matrices),
        rotations.quaternion_to_euler(q),
        rotations.matrix_to_euler(np.swapaxes(matrices, -1, -2), passive=True),
    ):
        assert np.all(np.isfinite(found))
        assert np.abs(rotations.euler_to_matrix(found) - matrices).max() < ROUNDED
        assert np.abs(found[:, 1] - theta).max() < ROUNDED
        assert np.all((found[:, ::2] > -pi) & (found[:, ::2] <= pi))
        if tilt >= 1e-12:  # each angle alone is known as well as the small tilt is
            apart = np.abs(found - angles)[:, ::2]
            assert np.minimum(apart, 2 * pi - apart).max() < ROUNDED / tilt + ROUNDED
        elif tilt < 1e-17:
            assert np.all(found[:, 2] == 0.0)


def test_on_the_vertical_psi_is_zero() -> None:
    up = rotations.matrix_to_euler(rotations.rotation_z([0.3, -2.0]))
    assert up == pytest.approx(np.array([[0.3, 0.0, 0.0], [-2.0, 0.0, 0.0]]), abs=ROUNDED)
    half = np.diag([1.0, -1.0, -1.0])
    assert np.array_equal(rotations.matrix_to_euler(half), [0.0, pi, 0.0])
    assert np.array_equal(rotations.quaternion_to_euler([0, 1, 0, 0]), [0.0, pi, 0.0])
    assert np.array_equal(rotations.quaternion_to_euler([1, 0, 0, 0]), [0.0, 0.0, 0.0])
    # Half a turn back is half a turn: its angle is pi, never -pi.
    back = rotations.matrix_to_euler([[-1.0, 0.0, -0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    assert np.array_equal(np.abs(back), [pi, pi / 2.0, 0.0])
    assert back[0] == pi
    # Rounding of a product of matrices is no tilt.
    noisy = rotations.rotation_z(0.3) @ rotations.rotation_x(1e-17) @ rotations.rotation_z(0.5)
    assert rotations.matrix_to_euler(noisy) == pytest.approx([0.8, 0.0, 0.0], abs=ROUNDED)


# Euler rates


def moving(t: float) -> Floats:
    return np.array([0.7 + 0.9 * t + 0.3 * sin(t), 1.1 + 0.4 * sin(1.3 * t), -0.4 + 2.1 * t])


STEP = 1e-3
#: Rounding of a difference quotient; differences of order 6 err by 1e-15 here.
DIFFERENCE = 100 * ROUNDOFF / STEP
T0 = 0.37
ANGLES0 = moving(T0)
RATES0 = derivative(moving, T0, STEP)


def attitude_of(t: float) -> Floats:
    return rotations.euler_to_matrix(moving(t))


def measured(frame: str) -> Floats:
    """The angular velocity as the derivative of the matrix shows it."""
    r, rate = attitude_of(T0), derivative(attitude_of, T0, STEP)
    body = rotations.vee(r.T @ rate)
    if frame == "body":
        return body
    if frame == "space":
        return rotations.vee(rate @ r.T)
    return rotations.rotation_z(ANGLES0[2]) @ body


@pytest.mark.parametrize("frame", ["body", "space", "node"])
def test_omega_of_euler_rates_in_each_frame(frame: str) -> None:
    omega = rotations.omega_from_euler_rates(ANGLES0, RATES0, frame=frame)
    assert omega == pytest.approx(measured(frame), abs=DIFFERENCE)
    back = rotations.euler_rates_from_omega(ANGLES0, omega, frame=frame)
    assert back.rates == pytest.approx(RATES0, abs=ROUNDED * 10)
    assert not back.singular
    assert back.residual == 0.0
    axes = rotations.euler_axes(ANGLES0, frame=frame)
    assert np.linalg.norm(axes, axis=0) == pytest.approx(np.ones(3), abs=ROUNDED)
    assert np.linalg.det(axes) == pytest.approx(-sin(ANGLES0[1]), abs=ROUNDED)


def test_the_axes_are_the_vertical_the_node_line_and_body_axis_3() -> None:
    r = attitude_of(T0)
    space = rotations.euler_axes(ANGLES0, frame="space")
    assert space[:, 0] == pytest.approx([0.0, 0.0, 1.0], abs=ROUNDED)
    assert space[:, 2] == pytest.approx(r[:, 2], abs=ROUNDED)
    assert np.cross(space[:, 0], space[:, 2]) == pytest.approx(
        sin(ANGLES0[1]) * space[:, 1], abs=ROUNDED
    )
    assert rotations.euler_axes(ANGLES0) == pytest.approx(r.T @ space, abs=ROUNDED)


def test_printed_parts_of_omega_that_are_wrong() -> None:
    """Ercan 2016, § 5: D-08, D-09, D-10; § 9.2: D-24. Each misses what the matrix shows."""
    (_, theta, psi), (dphi, dtheta, dpsi) = ANGLES0, RATES0
    e_phi, e_theta, e_psi = rotations.euler_axes(ANGLES0).T
    assert e_phi == pytest.approx(attitude_of(T0).T[:, 2], abs=ROUNDED)
    printed = np.array([sin(psi) * cos(theta), cos(psi) * sin(theta), cos(theta)])
    assert np.abs(dphi * (printed - e_phi)).max() > 0.1  # D-09
    assert e_psi.tolist() == [0.0, 0.0, 1.0]
    assert np.abs(dpsi * np.array([1.0, 0.0, 0.0]) - dpsi * e_psi).max() > 1.0  # D-10
    assert np.abs(dtheta * np.array([1.0, 0.0, 0.0]) - dtheta * e_theta).max() > 0.1  # D-08
    node = measured("node")
    exchanged = np.array([dtheta, dpsi * sin(theta), dpsi * cos(theta) + dphi])
    assert np.abs(exchanged - node).max() > 0.5  # D-24


def test_omega_needs_the_matrix_from_body_to_space() -> None:
    """The lecture takes R of eq. (5.2) for that of (5.1), which is its transpose: erratum G-07."""
    passive = attitude_of(T0).T
    wrong = rotations.vee(passive.T @ derivative(lambda t: attitude_of(t).T, T0, STEP))
    assert np.abs(wrong - rotations.omega_from_euler_rates(ANGLES0, RATES0)).max() > 1.0


def test_turning_the_rates_with_the_wrong_angle() -> None:
    """G-08: phi' along the vertical is turned into the body by theta and then psi, not phi."""
    vertical, e_phi = np.array([0.0, 0.0, 1.0]), rotations.euler_axes(ANGLES0)[:, 0]
    tilt = rotations.rotation_x(ANGLES0[1], passive=True)
    spun = [rotations.rotation_z(angle, passive=True) @ tilt @ vertical for angle in ANGLES0[::2]]
    assert spun[1] == pytest.approx(e_phi, abs=ROUNDED)
    assert np.abs(spun[0] - e_phi).max() > 0.5


@pytest.mark.parametrize("theta", [0.0, pi])
def test_on_the_vertical_the_rates_are_those_of_least_norm(theta: float) -> None:
    angles = [0.4, theta, 0.9]
    omega = np.array([0.3, -0.2, 1.7])
    found = rotations.euler_rates_from_omega(angles, omega, least_norm=True)
    axes = rotations.euler_axes(angles)
    truth = np.linalg.lstsq(axes, omega, rcond=1e-8)[0]
    assert found.rates == pytest.approx(truth, abs=ROUNDED)
    assert found.singular
    residual = np.linalg.norm(axes @ found.rates - omega)
    assert found.residual == pytest.approx(residual, abs=ROUNDED)
    mixed = rotations.euler_rates_from_omega([angles, [0.4, 1.0, 0.9]], omega, least_norm=True)
    assert mixed.singular.tolist() == [True, False]


# Along a motion


def follow(frame: str, until: float) -> Floats:
    """The attitude by a Runge–Kutta method of order 8, which shares no code."""

    def rate(t: float, q: Floats) -> Floats:
        w = np.concatenate([[0.0], prescribed(np.array(t))])
        product = rotations.quaternion_product
        return 0.5 * (product(q, w) if frame == "body" else product(w, q))

    solved = solve_ivp(
        rate, (0.0, until), [1.0, 0.0, 0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14
    )
    end: Floats = solved.y[:, -1]
    return end


@pytest.mark.parametrize("frame", ["body", "space"])
def test_attitude_follows_the_rates(frame: str) -> None:
    truth = follow(frame, 5.0)
    for tolerance in (1e-6, 1e-9, 1e-12):
        path = rotations.attitude_from_omega(
            prescribed, [0.0, 1.7, 5.0], frame=frame, tolerance=tolerance
        )
        error = float(rotation_angle(path.attitude[-1], truth))
        assert error <= path.error + 1e-13  # of the reference
        assert path.error <= tolerance
        assert np.linalg.norm(path.attitude, axis=-1) == pytest.approx(np.ones(3), abs=ROUNDED)


def test_a_constant_rate_is_exact_and_composes_with_the_start() -> None:
    start = Rotation.from_euler("ZXZ", [0.3, 1.1, -0.4])
    omega = np.array([0.3, -1.0, 2.0])
    t = np.array([1.0, 1.0, 2.5, 4.0])

    def constant(times: Floats) -> Floats:
        return np.broadcast_to(omega, (len(times), 3))

    for frame in ("body", "space"):
        path = rotations.attitude_from_omega(constant, t, start, frame=frame)
        turn = Rotation.from_rotvec(np.outer(t - 1.0, omega))
        truth = start * turn if frame == "body" else turn * start
        assert rotation_angle(path.attitude, truth.as_quat(scalar_first=True)).max() < 1e-14
    # exp(t hat(omega(t))), as the lecture's (5.1) may be read, holds for a constant rate only: G-22
    naive = rotations.exp_quaternion(5.0 * prescribed(np.array(5.0)))
    assert rotation_angle(naive, follow("body", 5.0)) > 1.0


@pytest.mark.parametrize("frame", ["body", "space"])
def test_steps_of_the_magnus_series_have_order_6(frame: str) -> None:
    """Any angle is below the tolerance: two steps in each of so many intervals."""
    truth, errors = follow(frame, 20.0), []
    for intervals in (128, 256):
        t = np.linspace(0.0, 20.0, intervals + 1)
        path = rotations.attitude_from_omega(prescribed, t, frame=frame, tolerance=10.0)
        assert path.steps == 2 * intervals
        errors.append(float(rotation_angle(path.attitude[-1], truth)))
    assert errors[1] > 1e-11  # far above the error of the reference
    assert np.log2(errors[0] / errors[1]) == pytest.approx(6.0, abs=0.2)


@pytest.mark.parametrize("frame", ["body", "space"])
@pytest.mark.parametrize("uneven", [False, True])
def test_attitudes_of_sampled_rates_have_order_4_within_their_error(
    frame: str, uneven: bool
) -> None:
    """Of order 4 the third of the difference is five times the error of even samples."""
    truth, errors = follow(frame, 5.0), []
    for n in (41, 81, 161, 321):
        gaps = np.where(uneven & (np.arange(n - 1) % 3 == 0), 2.0, 1.0)
        t = 5.0 * np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()])
        path = rotations.attitude_from_samples(prescribed(t), t, frame=frame, tolerance=1e-12)
        errors.append(float(rotation_angle(path.attitude[-1], truth)))
        assert errors[-1] <= path.error < 40.0 * errors[-1]
    assert np.log2(errors[-2] / errors[-1]) > 3.7


@pytest.mark.parametrize("frame", ["body", "space"])
@pytest.mark.parametrize("record", ["with a gap", "at random times"])
def test_attitudes_of_a_record_with_long_intervals_are_within_their_error(
    frame: str, record: str
) -> None:
    """Every second sample left out hardly changes the longest interval, which has the error."""
    truth = follow(frame, 5.0)
    rng = np.random.default_rng(2026)
    for first in range(10, 60, 10):
        if record == "with a gap":
            t = np.linspace(0.0, 5.0, 101)[np.r_[:first, first + 8 : 101]]
        else:
            t = 5.0 * np.concatenate([[0.0], np.sort(rng.uniform(size=99)), [1.0]])
        path = rotations.attitude_from_samples(prescribed(t), t, frame=frame, tolerance=1e-12)
        error = float(rotation_angle(path.attitude[-1], truth))
        assert error <= path.error < 20.0 * error


@pytest.mark.parametrize("n", [4, 5])
def test_attitudes_of_a_few_samples_with_a_gap_are_within_their_error(n: int) -> None:
    """Every second of five samples is a parabola, which may pass the gap as the cubic does."""
    rng = np.random.default_rng(2026)
    for _ in range(20):
        gaps = rng.uniform(0.05, 0.3, size=n - 1)
        gaps[rng.integers(n - 1)] *= rng.uniform(2.0, 8.0)
        t = np.concatenate([[0.0], np.cumsum(gaps)]) + rng.uniform(0.0, 3.0)
        path = rotations.attitude_from_samples(prescribed(t), t, tolerance=1e-12)
        truth = rotations.attitude_from_omega(prescribed, t, tolerance=1e-12)
        error = float(rotation_angle(path.attitude, truth.attitude).max())
        assert error <= path.error < 200.0 * error


def test_sampled_rates_of_many_bodies_and_of_a_polynomial() -> None:
    """A cubic is its own spline: only the steps have an error."""
    t = np.array([0.0, 0.4, 0.5, 1.1, 1.7, 2.0])
    cubic = np.stack([t**3 - t, 1.0 - t**2, 2.0 * t], axis=-1)
    start = Rotation.from_euler("ZXZ", [[0.3, 1.1, -0.4], [2.0, 0.1, 1.0]])
    both = rotations.attitude_from_samples(np.stack([cubic, 2.0 * cubic]), t, start)
    assert both.attitude.shape == (2, 6, 4)
    assert both.error <= 2e-10
    one = rotations.attitude_from_omega(
        lambda s: np.stack([s**3 - s, 1.0 - s**2, 2.0 * s], axis=-1), t, start[0]
    )
    assert rotation_angle(both.attitude[0], one.attitude).max() < 2e-10


def test_many_bodies_and_no_interval() -> None:
    def two(times: Floats) -> Floats:
        return np.stack([prescribed(times), 2.0 * prescribed(times)])

    path = rotations.attitude_from_omega(two, np.linspace(0.0, 3.0, 7))
    assert path.attitude.shape == (2, 7, 4)
    one = rotations.attitude_from_omega(prescribed, np.linspace(0.0, 3.0, 7))
    assert rotation_angle(path.attitude[0], one.attitude).max() < 1e-10
    rest = rotations.attitude_from_omega(prescribed, [1.0], [0.0, 1.0, 0.0, 0.0])
    assert rest.attitude.tolist() == [[0.0, 1.0, 0.0, 0.0]]
    assert (rest.error, rest.steps) == (0.0, 0)


@pytest.mark.parametrize("frame", ["body", "space"])
def test_omega_of_sampled_attitudes_has_order_2(frame: str) -> None:
    """Ends included; each other interval is twice as long as its neighbours."""
    errors = []
    for n in (101, 201, 401):
        gaps = np.where(np.arange(n - 1) % 2, 1.0, 2.0)
        t = 5.0 * np.concatenate([[0.0], np.cumsum(gaps) / gaps.sum()])
        attitude = rotations.attitude_from_omega(prescribed, t, frame=frame, tolerance=1e-12)
        found = rotations.omega_from_attitudes(attitude.attitude, t, frame=frame)
        errors.append(np.abs(found - prescribed(t)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)


def test_attitudes_as_quaternions_matrices_or_rotations_and_of_either_sign() -> None:
    t = np.linspace(0.0, 2.0, 21)
    q = rotations.attitude_from_omega(prescribed, t).attitude
    omega = rotations.omega_from_attitudes(q, t)
    signs = RNG.choice([-1.0, 1.0], (21, 1))
    matrices = rotations.quaternion_to_matrix(q)
    for given in (signs * q, matrices, Rotation.from_quat(q, scalar_first=True)):
        assert rotations.omega_from_attitudes(given, t) == pytest.approx(omega, abs=1e-13)
    # A turn has one axis in both frames; only what lies between two of them is interpolated.
    middle = 0.5 * (np.matvec(matrices[:-1], omega[:-1]) + np.matvec(matrices[1:], omega[1:]))
    space = rotations.omega_from_attitudes(q, t, frame="space")
    assert 0.5 * (space[:-1] + space[1:]) == pytest.approx(middle, abs=0.02)
    two = rotations.omega_from_attitudes(q[:2], t[:2])
    assert np.array_equal(two[0], two[1])


def test_where_scipy_does_better() -> None:
    """Its spline has order 4 far from the ends, and order 1 near them."""
    inside, ends, ours = [], [], []
    for n in (101, 201):
        t = np.linspace(0.0, 5.0, n)
        q = rotations.attitude_from_omega(prescribed, t, tolerance=1e-12).attitude
        spline = RotationSpline(t, Rotation.from_quat(q, scalar_first=True))(t, 1)
        error = np.abs(spline - prescribed(t)).max(axis=1)
        inside.append(error[20:-20].max())
        ends.append(error.max())
        ours.append(np.abs(rotations.omega_from_attitudes(q, t) - prescribed(t)).max())
    assert np.log2(inside[0] / inside[1]) == pytest.approx(4.0, abs=0.3)
    assert np.log2(ends[0] / ends[1]) == pytest.approx(1.0, abs=0.3)
    assert 100.0 * inside[0] < ours[0] < ends[0]


def test_rates_that_jump_are_refused_with_the_error_reached(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sampled, "MOST_STEPS", 2**12)

    def jump(t: Floats) -> Floats:
        return np.stack([(t > 1.0 / 3.0) * 1.0, 0.0 * t, 0.0 * t], axis=-1)

    with pytest.raises(ValueError, match=r"tolerance = 1e-12: not reached with 4096 steps"):
        rotations.attitude_from_omega(jump, [0.0, 1.0], tolerance=1e-12)


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
        (lambda: rotations.nearest_rotation(np.zeros((3, 3))), "its determinant is 0"),
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
    ]
)
