"""Angular velocities of attitudes in time, and attitudes that follow angular velocities."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation, RotationSpline

import rigid
from physics import ROUNDOFF, Floats, present, rotation_angle
from rigid import rotations
from rotation_cases import prescribed

RNG = np.random.default_rng(20)

#: Rounding of a product of three matrices of entries up to one, or of an angle made from one.
ROUNDED = 16 * ROUNDOFF


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


# How nearly a rotation


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


# Bad input


def test_rates_that_jump_are_refused_with_the_error_reached() -> None:
    def jump(t: Floats) -> Floats:
        return np.stack([(t > 1.0 / 3.0) * 1.0, 0.0 * t, 0.0 * t], axis=-1)

    with pytest.raises(ValueError, match=r"tolerance = 1e-12: not reached with .* steps"):
        rotations.attitude_from_omega(jump, [0.0, 1.0], tolerance=1e-12)
