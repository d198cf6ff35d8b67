"""Euler's equations: what they keep, what the power does, and what is refused."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from free_motions import OBLATE, SPUN, moments_at_random
from physics import gamma_of, present, rotation_matrix, tilted
from refusals import refuses
from rigid import exact, free, rotations, top

RANDOM = np.random.default_rng(38)


# Euler's equations


def test_the_momentum_in_space_changes_by_the_torque() -> None:
    moments, omega = moments_at_random(200, RANDOM), RANDOM.normal(size=(200, 3))
    torque, attitude = RANDOM.normal(size=(200, 3)), RANDOM.normal(size=(200, 4))
    turn = rotation_matrix(attitude)
    change = free.euler_rhs(moments, omega, torque)
    # d(R I omega)/dt = R (I omega' + omega × I omega).
    inside = moments * change + np.cross(omega, moments * omega)
    np.testing.assert_allclose(inside, torque, atol=1e-14)
    # The same torque, given in space.
    outside = np.einsum("nij,nj->ni", turn, torque)
    again = free.euler_rhs(moments, omega, outside, attitude=attitude, frame="space")
    np.testing.assert_allclose(again, change, atol=1e-13)
    # Power: omega·I omega' = torque·omega.
    power = (omega * moments * change).sum(axis=1)
    np.testing.assert_allclose(power, (torque * omega).sum(axis=1), atol=1e-13)


def test_a_sphere_keeps_its_rates_exactly() -> None:
    assert (free.euler_rhs((0.3, 0.3, 0.3), RANDOM.normal(size=(50, 3))) == 0.0).all()


def test_leading_axes_and_empty_batches() -> None:
    omega = RANDOM.normal(size=(4, 1, 3))
    moments = moments_at_random(5, RANDOM)
    assert free.euler_rhs(moments, omega).shape == (4, 5, 3)
    assert free.euler_rhs(moments, omega, [0.0, 0.0, 1.0]).shape == (4, 5, 3)
    assert free.asymmetric_free_top(moments, omega).amplitude.shape == (4, 5, 3)
    assert free.circulation(moments, omega).margin.shape == (4, 5)
    nobody = np.empty((0, 3))
    assert free.euler_rhs(nobody, nobody).shape == (0, 3)
    assert free.euler_rhs(rigid.Body((1, 2, 3)), nobody).shape == (0, 3)
    assert free.asymmetric_free_top((1, 2, 3), nobody, t=[0.0, 1.0]).period.shape == (0,)
    assert free.symmetric_free_top((1, 1, 1.5), nobody).k.shape == (0,)
    assert free.cones((1, 1, 1.5), nobody, samples=5).body_curve.shape == (0, 5, 3)
    assert free.poinsot((1, 2, 2.5), np.empty((0, 4, 3))).distance.shape == (0,)


# Invariants and power


def test_a_free_body_keeps_its_momentum_but_not_its_rates() -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    run = rigid.simulate(scene, [0.02, 1.0, 0.02], t=np.linspace(0.0, 40.0, 4001))
    kept = free.invariants(run)
    assert kept.drift("energy") < 1e-14
    assert kept.drift("L") < 1e-14
    assert kept.drift("L_space") < 1e-13
    # D-02: zero torque would leave the rotation as it is.
    assert np.ptp(run.omega[:, 1]) == pytest.approx(2.0004, abs=5e-5)
    assert kept.p_psi is None


def test_a_heavy_top_keeps_less() -> None:
    t = np.linspace(0.0, 5.0, 51)
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.5)), mgl=1.0)
    run = rigid.simulate(scene, [0.2, 0.1, 5.0], tilted(np.pi / 3), t=t, method="dop853", step=1e-3)
    kept = free.invariants(run)
    # 5000 steps with rounding of 5 units in omega.
    assert kept.drift("energy") < 1e-12
    assert kept.drift("p_phi") < 1e-12
    change = present(kept.p_psi)[-1] - present(kept.p_psi)[0]
    assert change == pytest.approx(-0.00728107, abs=5e-9)
    # The same states as arrays.
    again = free.invariants(scene, run.omega, run.attitude)
    np.testing.assert_allclose(again.energy, kept.energy, atol=1e-14)


def test_states_of_a_body_with_a_rotor_have_the_momentum_of_the_rotor() -> None:
    """L = I omega + h; the wheel keeps its share of the energy (Hughes 1986, § 6.1)."""
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), rotor=(0.1, 0.0, 3.0))
    kept = free.invariants(scene, [0.2, 1.0, -0.5])
    assert float(kept.L) == pytest.approx(np.sqrt(0.3**2 + 1.5**2 + 2.0**2), rel=1e-15)
    assert float(kept.energy) == pytest.approx(0.5 * (0.04 + 1.5 + 0.5), rel=1e-15)


def test_the_weight_moves_the_momentum() -> None:
    # D-19: a top "under the torque of its own weight" is no free top. Body and start of the proof.
    scene = rigid.HeavyTop(rigid.Body((1.3, 1.3, 0.7)), mgl=2.1)
    omega = [0.35, 0.25 * np.sin(0.9), 5.0]
    t = np.linspace(0.0, 12.0, 12001)
    heavy = free.invariants(rigid.simulate(scene, omega, tilted(0.9), t=t))
    freely = free.invariants(rigid.simulate(rigid.FreeBody(scene.body), omega, tilted(0.9), t=t))
    assert np.ptp(present(heavy.L_space)[:, 0]) == pytest.approx(5.78, abs=5e-3)
    assert np.ptp(present(heavy.L_space)[:, 2]) < 1e-13
    assert np.ptp(present(freely.L_space), axis=0).max() < 1e-13


def test_a_run_that_an_event_ends_has_invariants_up_to_it() -> None:
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.5)), mgl=1.0)
    t = np.linspace(0.0, 20.0, 2001)
    starts = [[0.2, 0.1, 2.0], [0.1, 0.3, 2.0]]
    run = rigid.simulate(scene, starts, tilted(1.0), t=t, until=rigid.crosses("omega1"))
    known = t < present(run.end)[:, np.newaxis]
    assert 0 < known.sum() < known.size
    kept = free.invariants(run)
    for values in (kept.energy, present(kept.p_phi), present(kept.L_space)[..., 0]):
        np.testing.assert_array_equal(np.isfinite(values), known)
    assert kept.drift("energy").max() < 1e-8
    residual = np.abs(free.power_balance(run).residual)
    assert np.nanmax(residual) < 1e-3  # differences of second order, of steps of a hundredth
    # The difference over the last known time needs the next one.
    assert (np.isfinite(residual).sum(axis=-1) >= known.sum(axis=-1) - 1).all()


def test_the_kinetic_energy_changes_by_the_power() -> None:
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.5)), mgl=1.0)
    left = []
    for count in (401, 801):
        t = np.linspace(0.0, 2.0, count)
        run = rigid.simulate(scene, [0.2, 0.1, 5.0], tilted(1.0), t=t, method="dop853", step=2.5e-3)
        balance = free.power_balance(run)
        assert balance.residual.shape == balance.power.shape == (count,)
        left.append(np.abs(balance.residual[5:-5]).max())
        assert np.abs(balance.power).max() > 0.1
    # Differences of second order.
    assert left[0] / left[1] == pytest.approx(4.0, abs=0.1)
    assert left[1] < 1e-4
    quiet = rigid.simulate(
        rigid.FreeBody(scene.body), [0.2, 0.1, 5.0], t=np.linspace(0.0, 2.0, 201)
    )
    assert np.abs(free.power_balance(quiet).residual).max() < 1e-11


# Refusals

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
RUN = rigid.simulate(FREE, [0.1, 1.0, 0.2], t=[0.0, 1.0, 2.0])
NO_SCENE: Any = (1.0, 2.0, 3.0)
WHEEL = rigid.RotorTable([0.0, 1.0], [[0.0, 0.0, 1.0]] * 2)
ORBITER = rigid.FreeBody(FREE.body, orbit=rigid.Orbit(1.0))


test_what_has_no_answer_is_refused = refuses(
    [
        (lambda: free.euler_rhs((1, 1, 3), [1, 2, 3]), "triangle inequality"),
        (lambda: free.euler_rhs((1, -1, 2), [1, 2, 3]), "moments = (1, -1, 2)"),
        (lambda: free.euler_rhs((1, 2, np.nan), [1, 2, 3]), "moments[2] = nan"),
        (lambda: free.euler_rhs((1, 2), [1, 2, 3]), "moments: expected shape (..., 3)"),
        (lambda: free.euler_rhs((1, 2, 3), [1, 2]), "omega: expected shape (..., 3)"),
        (lambda: free.euler_rhs((1, 2, 3), [1, 2, np.inf]), "omega[2] = inf: must be"),
        (
            lambda: free.euler_rhs((1, 2, 3), [1, 2, 3], [0, 0, 1], frame="space"),
            "frame = 'space': a torque in space needs the attitude",
        ),
        (
            lambda: free.euler_rhs((1, 2, 3), [1, 2, 3], [0, 0, 1], frame="lab"),
            "frame = 'lab': must be one of",
        ),
        (
            lambda: free.euler_rhs(
                (1, 2, 3), [1, 2, 3], [0, 0, 1], attitude=[0, 0, 0, 0], frame="space"
            ),
            "attitude = [0.0, 0.0, 0.0, 0.0]: a zero quaternion is no attitude",
        ),
        (lambda: free.invariants(NO_SCENE, [1, 2, 3]), TypeError, "must be a rigid.FreeBody or"),
        (
            lambda: free.invariants(rigid.FreeBody(FREE.body, rotor=WHEEL), [1, 2, 3]),
            "rotor = RotorTable(2 times from 0 to 1): is a table, which only invariants(run) knows",
        ),
        (lambda: free.invariants(FREE), "omega = None: states are needed"),
        (lambda: free.invariants(RUN, [1, 2, 3]), "a run has its own states"),
        (lambda: free.invariants(HEAVY, [1, 2, 3]), "attitude = None: the energy of"),
        (lambda: free.invariants(RUN).drift("p_psi"), "p_psi is not known"),
        (lambda: free.invariants(RUN).drift("speed"), "name = 'speed': must be one"),
        (
            lambda: free.invariants(FREE, [1, 2, 3]).drift("energy"),
            "energy of shape (): has no times to compare",
        ),
        (lambda: free.power_balance(RUN, t=[0.0, 1.0, 2.0]), "t: a run has its own"),
        (
            lambda: free.power_balance(ORBITER, [[1, 2, 3]] * 3, t=[0, 1, 2]),
            "attitude = None: the torque of a gravity gradient needs it",
        ),
        (
            lambda: free.jacobi_integral(
                rigid.FreeBody(FREE.body, orbit=ORBITER.orbit, rotor=WHEEL),
                [1, 2, 3],
                [1, 0, 0, 0],
                0,
            ),
            "no Jacobi integral is constant under a table",
        ),
        (lambda: free.power_balance(HEAVY, [[1, 2, 3]] * 3, t=[0, 1, 2]), "the weight"),
        (lambda: free.power_balance(FREE, [[1, 2, 3]] * 3), "t of shape (0,), omega"),
        (lambda: free.symmetric_free_top((1, 2, 2.5), [1, 2, 3]), "two exactly equal"),
        (
            lambda: free.symmetric_free_top((1, 2, 2), [1, 2, 3], axis=3),
            "the two across the axis of symmetry must be equal",
        ),
        (
            lambda: free.symmetric_free_top((1, 1, 2), [1, 2, 3], [1, 0, 0, 0]),
            "attitude: without times t",
        ),
        (
            lambda: free.asymmetric_free_top((1, 1, 2), [1, 2, 3], [1, 0, 0, 0]),
            "attitude: without times t",
        ),
        (lambda: free.asymmetric_free_top((1, 1, 2), [1, 2, 3], t=[1, 0]), "ascending"),
        (lambda: free.cones((1, 1, 2), [0, 0, 0]), "a body at rest has no cones"),
        (lambda: free.cones((1, 1, 2), [0, 0, 1], samples=1), "samples = 1: must be"),
        (lambda: free.steady_axis_frame((1, 1, 1), 1.0), "a sphere has no axis"),
        (lambda: free.steady_axis_frame((1, 1.5, 1), 1.0), "across the third axis"),
        (lambda: free.steady_axis_frame((1, 1, 2), 1.0, 1.6), "tilt = 1.6: must lie"),
        (lambda: free.steady_axis_spin((1, 1, 2), [1, 2]), "frame_rate: expected"),
        (lambda: free.poinsot((1, 2, 2.5), [1, 2, 3]), "omega: expected the states"),
        (lambda: free.poinsot((1, 1, 0), [[0, 0, 2]]), "|L| = 0.0: a body without"),
        (
            lambda: free.poinsot((1, 2, 2.5), [[1, 2, 3]], [1, 0, 0, 0]),
            "attitude: expected shape (1, 4) to go with omega",
        ),
    ],
    literal=True,
)


def test_attitudes_are_normalised_to_the_same_bits_everywhere() -> None:
    """Of any length: simulate, the free tops and the rotations start from the same quaternion."""
    given = RANDOM.normal(size=(500, 4)) * 10.0 ** RANDOM.uniform(-300, 300, (500, 1))
    given[:4] = [
        [0.0, 0.0, 0.0, 5e-324],
        [1e308, 1e308, -1e308, 1e308],
        [1e-170, 1.0, 0.0, 0.0],
        [0.0, 3.0, 4.0, 0.0],
    ]
    scene, times = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5))), np.array([0.0, 1.7])
    run = rigid.simulate(scene, [0.9, 0.3, 2.3], given, t=times, method="exact")
    found = free.asymmetric_free_top(scene, [0.9, 0.3, 2.3], given, t=times)
    np.testing.assert_array_equal(found.attitude, present(run.attitude))
    start = present(rigid.simulate(scene, [0.9, 0.3, 2.3], given, t=[0.0], method="rk4").attitude)[
        :, 0
    ]
    sign = np.sign(np.take_along_axis(start, np.argmax(start != 0.0, axis=1)[:, None], axis=1))
    np.testing.assert_array_equal(rotations.canonical_quaternion(given), sign * start)
    np.testing.assert_array_equal(
        rotations.attitude_from_omega(np.zeros_like, t=[0.0], attitude=given).attitude[:, 0], start
    )


def test_scipy_rotations_are_attitudes() -> None:
    attitude = np.array([0.8, 0.36, -0.48, 0.0])
    rotation = Rotation.from_quat(attitude, scalar_first=True)
    ours = free.symmetric_free_top(OBLATE, SPUN, attitude, t=[1.0])
    theirs = free.symmetric_free_top(OBLATE, SPUN, rotation, t=[1.0])
    np.testing.assert_allclose(present(ours.attitude), present(theirs.attitude), atol=1e-15)
    assert exact.free_body(rigid.Body(OBLATE), SPUN).period == pytest.approx(ours.period)
    weight = top.gravity_torque(HEAVY, rotation)
    np.testing.assert_allclose(weight, np.cross(gamma_of(attitude), [0, 0, 1.0]), atol=1e-15)


# Roll, pitch and yaw: turns 3-2-1 from the frame of the orbit to the body


def test_angles_are_those_of_scipy() -> None:
    """On an inclined ellipse, from the axes *along*, *normal* and *radial* of its frame."""
    orbit = rigid.Orbit(0.3, 0.4, 0.2, normal=(0.0, 0.6, 0.8), periapsis=(0.0, -0.8, 0.6))
    rng = np.random.default_rng(4)
    t, given = rng.uniform(0.0, 50.0, 200), rng.uniform(-1.5, 1.5, (200, 3))
    frame = orbit.frame(t)
    axes = Rotation.from_matrix(np.stack([frame[..., 1], frame[..., 2], frame[..., 0]], axis=-1))
    yaw, pitch, roll = given.T
    attitude = axes * Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    found = rigid.free.roll_pitch_yaw(orbit, attitude, t, axes=(3, 2))
    # Near a pitch of 1.5 the angles lose a factor of 1 / cos(1.5) = 14 of some roundings.
    np.testing.assert_allclose(found, np.stack([roll, pitch, yaw], axis=-1), atol=1e-13)


def test_straight_up_and_down_has_a_pitch() -> None:
    """Rounding makes some of many sines larger than one. The arcsine has half of the digits."""
    rng = np.random.default_rng(5)
    t, yaw, pitch = (
        rng.uniform(0.0, 50.0, 200),
        rng.uniform(-3.0, 3.0, 200),
        np.full(200, np.pi / 2),
    )
    pitch[::2] *= -1.0
    axes = Rotation.from_matrix(rigid.Orbit(0.3, 0.4).frame(t)[..., [1, 2, 0]])
    attitude = axes * Rotation.from_euler("ZYX", np.stack([yaw, pitch, 0.0 * yaw], axis=-1))
    found = rigid.free.roll_pitch_yaw(rigid.Orbit(0.3, 0.4), attitude, t, axes=(3, 2))
    np.testing.assert_allclose(found[:, 1], pitch, atol=1e-7)


def test_a_satellite_at_rest_has_none() -> None:
    """Body axes 1, 2, 3 along the motion, the normal and the line from the planet stay there."""
    orbit = rigid.Orbit(1.0)
    scene = rigid.FreeBody(rigid.Body((2.0, 2.1, 0.3)), orbit=orbit)
    t = np.linspace(0.0, 15.0, 16)
    run = rigid.simulate(scene, [0.0, 1.0, 0.0], [0.5, 0.5, 0.5, 0.5], t=t, accuracy=1e-10)
    assert run.attitude is not None
    angles = rigid.free.roll_pitch_yaw(scene, run.attitude, t)
    np.testing.assert_allclose(angles, 0.0, atol=1e-9)


PAIRS = [a for a in itertools.permutations((1, 2, 3, -1, -2, -3), 2) if abs(a[0]) != abs(a[1])]


@pytest.mark.parametrize("axes", PAIRS)
def test_angles_belong_to_the_axes_that_are_named(axes: tuple[int, int]) -> None:
    """The same turns of a body whose axes have other numbers."""
    orbit, t = rigid.Orbit(0.3, 0.4), np.linspace(0.0, 9.0, 50)
    given = np.random.default_rng(4).uniform(-1.4, 1.4, (50, 3))
    roll, pitch, yaw = given.T
    turns = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))
    yaw_axis, pitch_axis = (np.sign(one) * np.eye(3)[abs(one) - 1] for one in axes)
    own = np.stack([np.cross(pitch_axis, yaw_axis), pitch_axis, yaw_axis])
    frame = orbit.frame(t)[..., [1, 2, 0]]
    attitude = Rotation.from_matrix(frame) * turns * Rotation.from_matrix(own)
    found = rigid.free.roll_pitch_yaw(orbit, attitude, t, axes=axes)
    np.testing.assert_allclose(found, given, atol=1e-13)


def test_a_moon_that_faces_its_planet_has_none() -> None:
    """Axis 1 along the line to the planet, as the attitude is by default: no gimbal lock."""
    moon = rigid.FreeBody(rigid.Body.ellipsoid(1.3, 1.1, 1.0), orbit=rigid.Orbit(1.0))
    t = np.linspace(0.0, 15.0, 16)
    run = rigid.simulate(moon, [0.0, 0.0, 1.0], t=t, accuracy=1e-10)
    np.testing.assert_allclose(
        rigid.free.roll_pitch_yaw(moon, present(run.attitude), t), 0.0, atol=1e-9
    )


test_what_has_no_axes_is_refused = refuses(
    [
        (rigid.Orbit(1.0), "axes: an orbit alone has no body; give the body axes"),
        (rigid.FreeBody(rigid.Body((1, 2, 2)), orbit=rigid.Orbit(1.0)), "axes: two of the moments"),
        (rigid.FreeBody(rigid.Body((1, 1.5, 2))), "has no orbit; give rigid.FreeBody one"),
    ],
    by=lambda scene: rigid.free.roll_pitch_yaw(scene, [1, 0, 0, 0], 0.0),
)
