"""Euler angles and their rates, against printed formulas and differences in time."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy import cos, pi, sin
from scipy.spatial.transform import Rotation

from physics import ROUNDOFF, Floats
from rigid import rotations

RNG = np.random.default_rng(20)

#: Rounding of a product of three matrices of entries up to one, or of an angle made from one.
ROUNDED = 16 * ROUNDOFF


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


def derivative(f: Callable[[float], Floats], t: float, h: float = 1e-3) -> Floats:
    """By central differences of order 6: error h⁶ times a seventh derivative, here below 1e-15."""
    weights = {3: 1.0, 2: -9.0, 1: 45.0}
    total = sum((w * (f(t + k * h) - f(t - k * h)) for k, w in weights.items()), np.array(0.0))
    return np.asarray(total / (60.0 * h))


#: Rounding of such a difference quotient.
DIFFERENCE = 100 * ROUNDOFF / 1e-3
T0 = 0.37
ANGLES0 = moving(T0)
RATES0 = derivative(moving, T0)


def attitude_of(t: float) -> Floats:
    return rotations.euler_to_matrix(moving(t))


def measured(frame: str) -> Floats:
    """The angular velocity as the derivative of the matrix shows it."""
    r, rate = attitude_of(T0), derivative(attitude_of, T0)
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
    wrong = rotations.vee(passive.T @ derivative(lambda t: attitude_of(t).T, T0))
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
