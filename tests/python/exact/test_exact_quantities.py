"""Periods, flips, precession and nutation, against printed tables and the motion itself."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.special import ellipk

import rigid
from physics import ROUNDOFF, Floats, angular_momentum, gamma_of, present, rotation_matrix, tilted
from refusals import refuses
from rigid import exact

STANDARD = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)

#: Rounding of a phase turned by that angle (rad), with room for the constants of the motion.
PHASE = 16 * ROUNDOFF


def state(scene: Any, omega: ArrayLike, attitude: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
    """Rates and attitudes by closed form."""
    run = rigid.simulate(scene, omega, attitude, t=t, method="exact")
    return run.omega, present(run.attitude)


# Free body

#: Size of the perturbation: half the period for it along axis 1, along axis 3 and along both, of a
#: body (1, 2, 3) turning with 1 rad/s and of the box with 10 rad/s about their middle axes (s).
#: Computed in multiple precision from 2 K / lam (Landau & Lifshitz § 37).
FLIPS = {
    1e-1: (12.755489, 10.821061, 11.498131, 0.825801, 0.805952, 1.009655),
    1e-2: (20.754610, 18.851036, 19.552867, 1.345707, 1.326085, 1.532385),
    1e-3: (28.731424, 26.828561, 27.530841, 1.864129, 1.844512, 2.050852),
    1e-4: (36.707819, 34.804967, 35.507253, 2.382524, 2.362907, 2.569248),
    1e-6: (52.660597, 50.757745, 51.460031, 3.419313, 3.399696, 3.606036),
    1e-8: (68.613374, 66.710522, 67.412808, 4.456102, 4.436485, 4.642825),
    1e-10: (84.566152, 82.663300, 83.365586, 5.492890, 5.473273, 5.679614),
    1e-12: (100.518929, 98.616077, 99.318363, 6.529679, 6.510062, 6.716402),
}
PERTURBED = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])


@pytest.mark.parametrize("size", FLIPS)
def test_flip_times_of_the_middle_axis_are_those_of_the_table(size: float) -> None:
    omega = size * PERTURBED + [0.0, 1.0, 0.0]
    found = [exact.free_body(STANDARD, omega).flip_time, exact.free_body(BOX, 10 * omega).flip_time]
    # Half a unit of the last digit printed.
    np.testing.assert_allclose(np.ravel(found), FLIPS[size], rtol=0.0, atol=0.51e-6)


def test_the_encircled_axis_keeps_its_number_and_sign() -> None:
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]):
        body = rigid.Body(np.array([1.0, 2.0, 3.0])[order])
        for role, sign in ((0, 1), (0, -1), (2, 1), (2, -1)):
            omega = np.full(3, 0.1)
            axis = order.index(role)
            omega[axis] = sign
            assert exact.free_body(body, omega).axis == sign * (axis + 1)
    for body, omega in (
        (STANDARD.body, np.zeros(3)),
        (rigid.Body((2.0, 2.0, 2.0)), np.array([1.0, 2.0, 3.0])),
    ):
        motion = exact.free_body(body, omega)
        assert motion.axis == 0
        assert motion.period == motion.flip_time == np.inf
        assert not any(np.isnan(getattr(motion, name)).any() for name in ("m", "mc", "precession"))


def test_on_the_separatrix_there_is_no_period() -> None:
    # I1 (I2 - I1) w1² = I3 (I3 - I2) w3² for any w2: 4 * 2.5 * 3² = 9 * 2.5 * 2².
    for spin in (0.0, 0.5, -7.0):
        motion = exact.free_body(rigid.Body((4.0, 6.5, 9.0)), [3.0, spin, 2.0])
        assert motion.axis == 0
        assert motion.m == 1.0
        assert motion.mc == 0.0
        assert motion.period == motion.flip_time == np.inf


CASES: list[tuple[rigid.FreeBody, list[float]]] = [
    (STANDARD, [0.3, 1.0, 0.2]),
    (STANDARD, [-0.2, 1.0, 0.3]),
    (BOX, [0.5, -7.0, 1.0]),
    (rigid.FreeBody(rigid.Body((3.0, 1.0, 2.0))), [0.1, 0.4, 2.0]),
    (rigid.FreeBody(rigid.Body((1.0, 1.0 + 1e-9, 1.7))), [1.0, 0.3, 0.4]),
    (rigid.FreeBody(rigid.Body((2.0, 1.2, 2.0))), [1.0, 0.3, 0.4]),
]
START = np.array([0.8, 0.36, -0.48, 0.0])


@pytest.mark.parametrize(("scene", "omega"), CASES)
def test_the_rates_return_after_a_period_and_the_body_has_turned(
    scene: rigid.FreeBody, omega: list[float]
) -> None:
    motion = exact.free_body(scene, omega)
    period = float(motion.period)
    t = [0.0, period, 3.0 * period]
    rates, attitude = state(scene, omega, START, t)
    tolerance = PHASE * (1.0 + 3.0 * period * np.abs(omega).max())
    np.testing.assert_allclose(
        rates, rates[[0, 0, 0]], rtol=0.0, atol=tolerance * np.abs(rates).max()
    )
    # Over a period the body turns about the angular momentum, which stands still in space.
    momentum = rotation_matrix(START) @ angular_momentum(scene, omega)
    along = momentum / np.linalg.norm(momentum)
    for count, now in ((1, attitude[1]), (3, attitude[2])):
        turned = rotation_matrix(now) @ rotation_matrix(START).T
        angle = count * float(motion.turn)
        across = np.cross(along, [0.6, 0.8, 0.0])
        expected = np.cos(angle) * across + np.sin(angle) * np.cross(along, across)
        np.testing.assert_allclose(turned @ along, along, atol=tolerance)
        np.testing.assert_allclose(turned @ across, expected, atol=tolerance + PHASE * abs(angle))
    assert motion.precession * period == pytest.approx(float(motion.turn), rel=4 * ROUNDOFF)


@pytest.mark.parametrize(("scene", "omega"), CASES)
def test_amplitudes_are_reached_and_not_passed(scene: rigid.FreeBody, omega: list[float]) -> None:
    motion = exact.free_body(scene, omega)
    t = np.linspace(0.0, float(motion.period), 20_001)
    largest = np.abs(state(scene, omega, START, t)[0]).max(axis=0)
    # Half a step from the crest: 1/2 (2 pi / 40000)² of it, and more where the crest is sharp.
    assert (largest <= motion.amplitude * (1.0 + PHASE)).all()
    np.testing.assert_allclose(largest, motion.amplitude, rtol=1e-6)


@pytest.mark.parametrize(("scene", "omega"), CASES)
def test_the_rate_vanishes_at_its_flips_and_nowhere_between(
    scene: rigid.FreeBody, omega: list[float]
) -> None:
    motion = exact.free_body(scene, omega)
    for axis in (1, 2, 3):
        times = exact.flip_times(scene, omega, axis=axis, count=5)
        assert times.shape == (5,)
        if axis == abs(int(motion.axis)):
            assert (times == np.inf).all()
            continue
        assert (times > 0.0).all()
        np.testing.assert_allclose(np.diff(times), motion.flip_time, rtol=1e-13)
        rates = state(scene, omega, START, times)[0]
        slope = np.abs(np.cross(angular_momentum(scene, rates), rates) / scene.body.moments)
        allowed = slope[:, axis - 1] * times * PHASE + motion.amplitude[axis - 1] * PHASE
        assert (np.abs(rates[:, axis - 1]) <= allowed).all()
        between = np.concatenate([[0.0], times])
        middle = state(scene, omega, START, 0.5 * (between[:-1] + between[1:]))[0][:, axis - 1]
        assert (np.sign(middle[:-1]) == -np.sign(middle[1:])).all()
        assert np.sign(middle[0]) == np.sign(omega[axis - 1])


def test_flips_of_many_bodies_by_their_largest_rates() -> None:
    omega = np.array([[1e-3, 1.0, 0.0], [0.0, 1e-3, 1.0], [1e-6, 1.0, 0.0], [0.3, 1.0, 1.2]])
    times = exact.flip_times(STANDARD, omega, count=2)
    assert times.shape == (4, 2)
    # The first starts at the crest of its middle rate: a quarter of the period comes first.
    np.testing.assert_allclose(times[0], [0.5 * 28.731424, 1.5 * 28.731424], atol=1e-6)
    assert (times[1] == np.inf).all()
    np.testing.assert_array_equal(exact.flip_times(STANDARD, omega), times[:, :1])


def test_a_single_body_has_no_leading_axis() -> None:
    one = exact.free_body(STANDARD, [0.3, 1.0, 0.2])
    many = exact.free_body(STANDARD.body, [[0.3, 1.0, 0.2]] * 4)
    for name in ("axis", "m", "mc", "period", "flip_time", "precession", "turn"):
        assert np.shape(getattr(one, name)) == ()
        assert getattr(many, name).tolist() == [getattr(one, name)] * 4
    assert one.amplitude.shape == (3,)
    assert many.amplitude.shape == (4, 3)
    assert one.m + one.mc == pytest.approx(1.0, abs=2 * ROUNDOFF)


# Lagrange top


def turned(vector: ArrayLike, axis: int) -> Floats:
    """Components of a frame whose third axis is that axis of the body, in the body."""
    renamed: Floats = np.roll(np.asarray(vector, dtype=np.float64), axis, axis=-1)
    return renamed


def top(
    axis: int, side: float, *, moments: ArrayLike = (1.0, 1.0, 0.5), mgl: float = 1.0
) -> rigid.HeavyTop:
    """A top symmetric about that axis with its centre of mass on one side of the fixed point."""
    return rigid.HeavyTop(
        rigid.Body(turned(moments, axis)), mgl=mgl, com=turned([0.0, 0.0, side], axis)
    )


def start(tilt: float, axis: int, side: float) -> Floats:
    """An attitude with the centre of mass at that tilt, towards -e2 of space."""
    if side < 0.0:
        tilt = tilt + np.pi
    cyclic = {1: [0.5, -0.5, -0.5, -0.5], 2: [0.5, 0.5, 0.5, 0.5], 3: [1.0, 0.0, 0.0, 0.0]}
    w, x, y, z = cyclic[axis]
    c, s = np.cos(tilt / 2), np.sin(tilt / 2)
    return np.array([c * w - s * x, c * x + s * w, c * y - s * z, c * z + s * y])


def tilts(scene: rigid.HeavyTop, attitude: ArrayLike) -> Floats:
    """Angles of the centre of mass from the upward vertical, small ones without cancellation."""
    gamma, com = gamma_of(attitude), np.array(scene.com)
    angle: Floats = np.arctan2(np.linalg.norm(np.cross(gamma, com), axis=-1), gamma @ com)
    return angle


EVERY_SIDE = pytest.mark.parametrize(
    ("axis", "side"), [(axis, side) for axis in (1, 2, 3) for side in (1.0, -1.0)]
)


@EVERY_SIDE
@pytest.mark.parametrize("tilt", [0.5, 1.2, 2.5])
@pytest.mark.parametrize("spin", [1.5, 6.0, -6.0])
def test_released_at_rest_the_top_nutates_between_the_roots(
    tilt: float, spin: float, axis: int, side: float
) -> None:
    # Goldstein § 5.7: sin² x = a (cos tilt - cos x), a = (I3 w)² / (2 I1 mgl), besides x = tilt.
    motion = exact.lagrange_top(
        top(axis, side), turned([0.0, 0.0, spin], axis), start(tilt, axis, side)
    )
    a = (0.5 * spin) ** 2 / 2.0
    lowest = (a - np.sqrt(a * a - 4.0 * a * np.cos(tilt) + 4.0)) / 2.0
    assert motion.kind == "cusp"
    # The start is rounded, its cosine seen through 1 / sin.
    assert motion.tilt_min == pytest.approx(tilt, rel=8 * ROUNDOFF)
    assert motion.tilt_max == pytest.approx(np.arccos(lowest), rel=32 * ROUNDOFF)
    # It precesses with the spin of its own angular momentum along the centre of mass.
    assert np.sign(motion.precession) == np.sign(side * spin)


@EVERY_SIDE
@pytest.mark.parametrize(("tilt", "precession"), [(0.6, 0.3), (1.4, -1.0), (2.0, 2.0)])
def test_the_top_returns_after_a_period_of_nutation(
    tilt: float, precession: float, axis: int, side: float
) -> None:
    scene = top(axis, side)
    omega = turned([0.1, precession * np.sin(tilt), 3.0], axis)
    attitude = start(tilt, axis, side)
    motion = exact.lagrange_top(scene, omega, attitude)
    period = float(motion.period)
    _, after = state(scene, omega, attitude, [0.0, period])
    tolerance = PHASE * (1.0 + 6.0 * period)
    assert tilts(scene, after[1]) == pytest.approx(float(tilts(scene, after[0])), abs=tolerance)
    # In between: Rz(advance of phi), then the body as it was, turned by that of psi about the line
    # from the fixed point to the centre of mass.
    first, second = (rotation_matrix(q) for q in after)
    about = rotation_about(np.eye(3)[2], float(motion.precession_advance))
    own = rotation_about(np.array(scene.com), float(motion.spin_advance))
    np.testing.assert_allclose(about @ first @ own, second, atol=4.0 * tolerance)
    assert motion.precession == pytest.approx(float(motion.precession_advance) / period, rel=1e-15)
    assert bool(motion.retrograde) == bool(motion.precession * side * 3.0 < 0.0)
    t = np.linspace(0.0, period, 4001)
    seen = tilts(scene, state(scene, omega, attitude, t)[1])
    assert seen.min() == pytest.approx(float(motion.tilt_min), abs=1e-6)
    assert seen.max() == pytest.approx(float(motion.tilt_max), abs=1e-6)


def rotation_about(axis: Floats, angle: float) -> Floats:
    return rotation_matrix(np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)]))


@EVERY_SIDE
@pytest.mark.parametrize("tilt", [0.4, 1.0, 0.5 * np.pi, 2.2])
@pytest.mark.parametrize("spin", [4.0, -9.0])
def test_steady_precession_is_steady(tilt: float, spin: float, axis: int, side: float) -> None:
    scene = top(axis, side)
    for rate in exact.steady_precession(scene, tilt, spin):
        if tilt == 0.5 * np.pi and np.isnan(rate):
            continue  # a horizontal axis precesses steadily in one way only
        # The root of the quadratic, relative to its largest term.
        terms = [rate**2 * np.cos(tilt), -0.5 * side * spin * rate, 1.0]
        assert abs(sum(terms)) < 16 * ROUNDOFF * np.abs(terms).max()
        # Turning about the vertical with that rate, and about its own axis with what is missing.
        gamma = gamma_of(start(tilt, axis, side))
        omega = rate * gamma
        omega[axis - 1] = spin
        t = np.linspace(0.0, 10.0, 11)
        attitude = state(scene, omega, start(tilt, axis, side), t)[1]
        np.testing.assert_allclose(tilts(scene, attitude), tilt, atol=1e-6)
        motion = exact.lagrange_top(scene, omega, start(tilt, axis, side))
        # A turning point that is nearly double: the square root of what the rates were rounded by.
        assert motion.precession == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize(("tilt", "up"), [(0.0, 1.0), (np.pi, -1.0)])
def test_steady_precession_of_a_vertical_axis_is_the_limit_of_a_tilted_one(
    tilt: float, up: float
) -> None:
    """`I1 up rate² - I3 spin rate + mgl = 0`."""
    found = exact.steady_precession(TOP, tilt, 8.0)
    for rate in (float(found.slow), float(found.fast)):
        terms = [up * rate**2, -0.5 * 8.0 * rate, 1.0]
        assert abs(sum(terms)) < 16 * ROUNDOFF * np.abs(terms).max()


def test_a_needle_precesses_as_a_wheel_of_its_momentum() -> None:
    """The nutation depends on I3 omega3 alone; a needle turns 1e12 times as far about its axis."""
    thin = 2.0 ** -np.array([1.0, 10.0, 40.0])
    bodies = rigid.Body(np.stack([np.ones(3), np.ones(3), thin], axis=-1))
    spins = np.stack([np.full(3, 0.1), np.zeros(3), 10.0 / thin], axis=-1)
    motion = exact.lagrange_top(rigid.HeavyTop(bodies, mgl=1.0), spins, tilted(1.0))
    # A few roundings of two pi, the phase of a nutation, over an advance of 0.06.
    np.testing.assert_allclose(motion.precession_advance, motion.precession_advance[0], rtol=2e-13)
    np.testing.assert_allclose(motion.precession, motion.precession[0], rtol=2e-13)


def test_steady_precession_exists_above_a_spin() -> None:
    slow, fast = exact.steady_precession(TOP, [[0.1], [1.0], [2.0]], [1.0, 3.0, 4.0, 5.0])
    assert slow.shape == fast.shape == (3, 4)
    # (I3 spin)² >= 4 I1 mgl cos(tilt), always true below the horizontal.
    possible = [[False, False, True, True], [False, True, True, True], [True] * 4]
    np.testing.assert_array_equal(np.isfinite(slow), possible)
    np.testing.assert_array_equal(np.isfinite(fast), possible)
    known = np.isfinite(slow)
    assert (np.abs(slow[known]) <= np.abs(fast[known])).all()
    # Fast top: mgl / (I3 spin) and I3 spin / (I1 cos tilt).
    slow, fast = exact.steady_precession(TOP, 1.0, 1e6)
    assert slow == pytest.approx(2e-6, rel=1e-10)
    assert fast == pytest.approx(5e5 / np.cos(1.0), rel=1e-10)
    # Without spin: the conical pendulum, below the horizontal only.
    slow, fast = exact.steady_precession(TOP, [2.0, 1.0], 0.0)
    assert slow[0] == pytest.approx(np.sqrt(-1.0 / np.cos(2.0)), rel=4 * ROUNDOFF)
    assert fast[0] == pytest.approx(-slow[0], rel=4 * ROUNDOFF)
    assert np.isnan([slow[1], fast[1]]).all()


def test_the_sleeping_bound_divides_staying_from_falling() -> None:
    for scene in (TOP, top(2, -1.0, moments=(1.3, 1.3, 0.4), mgl=2.0)):
        axis = int(np.argmax(np.abs(scene.com))) + 1
        side = float(np.sign(scene.com[axis - 1]))
        bound = float(exact.sleeping_spin(scene))
        across, along = scene.body.moments[axis - 2], scene.body.moments[axis - 1]
        assert bound == pytest.approx(2.0 * np.sqrt(scene.mgl * across) / along, rel=4 * ROUNDOFF)
        omega = np.outer([1.01, 0.99], turned([0.0, 0.0, bound], axis))
        motion = exact.lagrange_top(scene, omega, start(1e-6, axis, side))
        # Above it the tilt grows by a bounded factor; below it to 1 - cos x = 2 (1 - (w/bound)²).
        assert motion.tilt_max[0] < 1e-5
        assert motion.tilt_max[1] == pytest.approx(np.arccos(2.0 * 0.99**2 - 1.0), rel=1e-9)


def test_what_a_top_does_has_a_name() -> None:
    upright = [1.0, 0.0, 0.0, 0.0]
    asleep = exact.lagrange_top(TOP, [[0.0, 0.0, 5.0], [0.0, 0.0, 3.0]], upright)
    assert asleep.kind == ("sleeping", "upright")
    hanging = exact.lagrange_top(TOP, [0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0])
    assert hanging.kind == "hanging"
    # Pushed with the precession, against it, and not at all (Goldstein § 5.7).
    slow = exact.steady_precession(TOP, 1.0, 8.0)[0]
    push = [0.9 * slow, -0.5 * slow, 0.0]
    omega = [[0.0, rate * np.sin(1.0), 8.0] for rate in push]
    assert exact.lagrange_top(TOP, omega, tilted(1.0)).kind == ("monotone", "loop", "cusp")


@EVERY_SIDE
def test_a_lagrange_top_never_flips_about_its_own_axis(axis: int, side: float) -> None:
    times = exact.flip_times(top(axis, side), [0.1, 0.2, 0.3], axis=axis, count=2)
    assert times.tolist() == [np.inf, np.inf]


# Times of tilts


@EVERY_SIDE
def test_the_tilt_is_the_limit_when_it_is_said_to_be(axis: int, side: float) -> None:
    scene = top(axis, side)
    omega = turned([0.2, 0.3, 3.0], axis)
    attitude = start(0.8, axis, side)
    motion = exact.lagrange_top(scene, omega, attitude)
    low, high = float(motion.tilt_min), float(motion.tilt_max)
    for share in (0.02, 0.3, 0.7, 0.98):
        limit = low + share * (high - low)
        time = exact.tilt_time(scene, omega, attitude, limit=limit)
        assert 0.0 <= time < motion.period
        t = np.linspace(0.0, float(time), 501)
        seen = tilts(scene, state(scene, omega, attitude, t)[1])
        # The slope of the tilt is below 3 rad/s.
        assert seen[-1] == pytest.approx(limit, abs=PHASE * (1.0 + 3.0 * float(time)))
        assert (np.sign(seen[1:-1] - limit) == np.sign(seen[0] - limit)).all()
    for beyond in (0.99 * low, min(1.01 * high, np.pi), np.pi):
        assert exact.tilt_time(scene, omega, attitude, limit=beyond) == np.inf


def test_tilt_times_of_many_tops() -> None:
    omega = np.array([[0.0, 0.0, spin] for spin in (2.0, 3.0, 10.0)])
    times = exact.tilt_time(TOP, omega, tilted(0.1), limit=0.5)
    assert np.isfinite(times).tolist() == [True, True, False]


# Pendulum


def test_the_period_of_a_pendulum() -> None:
    amplitude = np.array([0.0, 1e-6, 0.5, 2.0, 3.1])
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=2.0, com=(0.6, 0.0, 0.8))
    periods = exact.pendulum_period(scene, amplitude, axis=2)
    # Four quarter periods of sin² (amplitude / 2).
    expected = 4.0 * ellipk(np.sin(amplitude / 2.0) ** 2) * np.sqrt(1.4 / 2.0)
    np.testing.assert_allclose(periods, expected, rtol=1e-14)
    assert exact.pendulum_period(scene, np.pi, axis=2) == np.inf
    # Released at rest it is back after a period. The bottom is where com points to -e3.
    lowest = np.arctan2(0.6, 0.8) + np.pi
    for angle, period in zip(amplitude[2:4], periods[2:4], strict=True):
        turn = angle - lowest
        attitude = np.array([np.cos(turn / 2), 0.0, np.sin(turn / 2), 0.0])
        assert tilts(scene, attitude) == pytest.approx(np.pi - angle, rel=1e-14)
        rates, after = state(scene, [0.0, 0.0, 0.0], attitude, [period])
        np.testing.assert_allclose(rates, 0.0, atol=PHASE * 2.0 * period)
        np.testing.assert_allclose(after[0], attitude, atol=PHASE * period)


def test_the_slowest_rate_that_is_taken_has_its_period() -> None:
    """The period is as one over the rate; below, it would leave the range of doubles."""
    omega = np.array([0.3, 1.0, 0.2])
    period = float(exact.free_body(STANDARD, omega).period)
    slow = exact.free_body(STANDARD, 1e-300 * omega)
    assert float(slow.period) == pytest.approx(1e300 * period, rel=1e-14)
    with pytest.raises(ValueError, match=r"omega = .*: must be zero or reach 1e-300 rad/s"):
        exact.free_body(STANDARD, np.nextafter(1e-300, 0.0) * omega)


# Perturbations, limits and rates whose squares are outside the range of doubles


BODY = rigid.Body((1.0, 2.0, 3.0))
#: Rate at which a rotation about axis 2 at 1 rad/s is left: sqrt((I3 - I2)(I2 - I1) / (I1 I3)).
GROWTH = 3.0**-0.5
SMALL = [1e-149, 1e-150, 1e-160, 1e-200, 1e-300]


@pytest.mark.parametrize("rate", SMALL)
def test_a_flip_comes_later_by_the_logarithm_of_the_perturbation(rate: float) -> None:
    """Linear growth: a perturbation 10^n times smaller takes n ln(10) / GROWTH longer."""
    first = exact.flip_times(BODY, [1e-10, 1.0, 0.0])[0]
    later = exact.flip_times(BODY, [rate, 1.0, 0.0])[0]
    # Of the first time the terms of second order, 1e-20, are below rounding.
    delay = math.log(1e-10 / rate) / GROWTH
    assert later - first == pytest.approx(delay, rel=16 * ROUNDOFF)
    motion = exact.free_body(BODY, [rate, 1.0, 0.0])
    assert motion.axis == 1
    assert motion.flip_time == pytest.approx(2.0 * later, rel=8 * ROUNDOFF)


def test_flips_of_a_thousandth_of_a_googol_to_the_last_digit() -> None:
    """Jacobi functions with 1400 digits, by mpmath."""
    golden = {1e-150: 600.6302877401652, 1e-160: 640.5122314383292, 1e-300: 1198.8594432126245}
    for rate, time in golden.items():
        found = exact.flip_times(BODY, [rate, 1.0, 0.0])[0]
        assert found == pytest.approx(time, rel=4 * ROUNDOFF)
    # Both perturbations, either sense, and a ratio of rates below the range of doubles.
    both = exact.flip_times(BODY, [1e-310, -1.0, 2e-310], axis=2)[0]
    assert both == pytest.approx(1236.1501211438779, rel=4 * ROUNDOFF)
    apart = exact.flip_times(BODY, [1e-200, 1e200, 0.0])[0]
    assert apart == pytest.approx(1.597678880194264e-197, rel=4 * ROUNDOFF)


@pytest.mark.parametrize("rate", SMALL)
def test_states_turn_over_at_the_time_of_the_flip(rate: float) -> None:
    time = float(exact.flip_times(BODY, [rate, 1.0, 0.0])[0])
    run = rigid.simulate(BODY, [rate, 1.0, 0.0], t=[0.0, 1.0, time, 2.0 * time])
    # cosh and sinh of the linear motion, where it is still small; the time is rounded.
    assert run.omega[1, 0] == pytest.approx(rate * math.cosh(GROWTH), rel=64 * ROUNDOFF)
    np.testing.assert_allclose(run.omega[2:, 1], [0.0, -1.0], atol=1e-12)
    assert run.status == 0
    assert run.error < 1e-11


def test_small_transverse_rates_still_change_their_sign() -> None:
    """Near a steady rotation: a half turn of the polhode in pi / its rate."""
    times = exact.flip_times(BODY, [1e-200, 3e-200, 1.0], axis=1, count=2)
    rate = math.sqrt((3.0 - 1.0) * (3.0 - 2.0) / (1.0 * 2.0))
    assert times[1] - times[0] == pytest.approx(math.pi / rate, rel=8 * ROUNDOFF)


def test_a_map_sees_flips_of_tiny_perturbations() -> None:
    start, axes = rigid.Start(omega=(1e-150, 1.0, 0.0)), {"t_end": [600.0, 601.0]}
    result = rigid.stability_map(
        BODY, axes=axes, samples=2, stable=rigid.no_flip(2), start=start, rng=1
    )
    assert result.share.tolist() == [1.0, 0.0]


def falling(size: float, kind: str) -> tuple[list[float], list[float]]:
    """Rates and attitude of an upright top that a tilt or a push of this size disturbs."""
    if kind == "tilt":
        return [0.0, 0.0, 2.0], [1.0, 0.5 * size, size / 3.0, 0.0]
    if kind == "push":
        return [size, 0.3 * size, 2.0], [1.0, 0.0, 0.0, 0.0]
    return [-size, 1.1 * size, 2.0], [0.8, 0.5 * size, size / 3.0, 0.6]


@pytest.mark.parametrize("kind", ["tilt", "push", "both"])
@pytest.mark.parametrize("size", [1e-80, 1e-101, *SMALL])
def test_a_top_falls_later_by_the_logarithm_of_its_tilt(size: float, kind: str) -> None:
    growth = math.sqrt(4.0 - 1.0) / 2.0  # sqrt(4 I1 mgl - (I3 spin)²) / (2 I1)
    first = exact.tilt_time(TOP, *falling(1e-9, kind), limit=1.0)
    omega, attitude = falling(size, kind)
    later = exact.tilt_time(TOP, omega, attitude, limit=1.0)
    # The terms of second order of the first time are 1e-18.
    assert later - first == pytest.approx(math.log(1e-9 / size) / growth, rel=16 * ROUNDOFF)
    run = rigid.simulate(TOP, omega, attitude, t=[0.0, float(later)])
    last = present(run.attitude)[-1]
    tilt = 2.0 * np.arctan2(*(np.hypot(*last[part]) for part in ([1, 2], [0, 3])))
    # The phase has the rounding of the time, some hundred units.
    assert tilt == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("tilt", [1e-101, 1e-120, 1e-149])
def test_hanging_tops_of_tiny_tilt_stay_finite(tilt: float) -> None:
    run = rigid.simulate(TOP, [0.0, 0.0, 0.2], [tilt, 1.0, 0.0, 0.0], t=[3.0, 50.0])
    attitude = present(run.attitude)
    assert np.isfinite(attitude).all()
    assert np.hypot(attitude[:, 0], attitude[:, 3]).max() < 4.0 * tilt


def test_a_weight_that_is_tiny_topples_an_asymmetric_body() -> None:
    """Exactly on the unstable axis, so that only the weight disturbs it; the scene is stepped."""
    scene = rigid.HeavyTop(BODY, mgl=1e-160, com=(0.6, 0.64, 0.48))
    assert rigid.plan(scene, "rates", omega=[0.0, 1.0, 0.0], t_end=10.0).method != "exact"


def test_elliptic_functions_of_the_smallest_complements() -> None:
    """`tanh` and `sech` about the nearest of the quarter periods, of mpmath with 400 digits."""
    sn, cn, dn = exact.jacobi(1e4, 1e-310)
    # The argument is rounded to 1e-12.
    assert sn == -1.0
    assert cn == pytest.approx(2.4443830919547563e-14, rel=4e-12)
    assert dn == pytest.approx(cn, rel=4 * ROUNDOFF)
    sn, cn, dn = exact.jacobi(700.0, 1e-310)
    assert (cn, dn) == pytest.approx((-1.2677900684187467e-7, 1.2677900684187467e-7), rel=4e-13)
    assert exact.jacobi(357.0, 5e-324)[2] == pytest.approx(1.8109228815394782e-155, rel=4e-13)
    assert exact.jacobi(600.0, 0.0)[1] == pytest.approx(1.0 / math.cosh(600.0), rel=8 * ROUNDOFF)
    assert [float(x) for x in exact.jacobi(1e4, 0.0)] == [1.0, 0.0, 0.0]


def test_slow_bodies_have_quantities_of_their_rates() -> None:
    motion = exact.free_body(BODY, [3e-300, 0.0, 0.0])
    assert motion.precession == 3e-300
    symmetric = exact.free_body(rigid.Body((1.0, 1.0, 2.0)), [3e-200, 4e-200, 1e-200])
    assert symmetric.amplitude[0] == pytest.approx(5e-200, rel=4 * ROUNDOFF)


def map_from_rest(tilts: list[float], limit: float, **options: Any) -> rigid.StabilityMap:
    """Of tops that begin at rest at these tilts, one each."""
    start, stable = rigid.Start(omega=(0.0, 0.0, 0.0)), rigid.tilt_below(limit)
    options |= {"axes": {"tilt": tilts}, "samples": 1, "t_end": 100.0, "rng": 1}
    return rigid.stability_map(TOP, start=start, stable=stable, **options)


@pytest.mark.parametrize("distance", [2e-8, 1e-10, 1e-14])
def test_a_pendulum_passes_limits_beside_the_lowest_point(distance: float) -> None:
    """From rest at any tilt a pendulum swings through the lowest point: no limit below pi holds."""
    tilts = [0.5, 1.0, 1.7, 2.4, 3.0]
    angle = math.pi - distance
    result = map_from_rest(tilts, angle, measure=rigid.time_to_leave())
    assert result.stable.tolist() == [0] * len(tilts)
    times = result.measures["time_to_leave"].mean
    for tilt, time in zip(tilts, times, strict=True):
        attitude = [math.cos(0.5 * tilt), math.sin(0.5 * tilt), 0.0, 0.0]
        still = [0.0, 0.0, 0.0]
        assert time == exact.tilt_time(TOP, still, attitude, limit=angle)
        # A quarter of the period, less the last bit of the way at the rate of the lowest point.
        quarter = 0.25 * float(exact.pendulum_period(TOP, math.pi - tilt, axis=1))
        fastest = 2.0 * math.cos(0.5 * tilt)
        # pi is rounded by 1.2e-16.
        rest = (math.pi - angle + 1.2246e-16) / fastest
        assert quarter - time == pytest.approx(rest, rel=1e-12, abs=8 * ROUNDOFF * quarter)


def test_no_tilt_passes_pi() -> None:
    assert map_from_rest([0.5, 2.0], math.pi).share.tolist() == [1.0, 1.0]


# Refusals

HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0, com=(0.6, 0.0, 0.8))
FREE: Any = STANDARD
SIDES = [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)]
NO_LAGRANGE = "a Lagrange top has two exactly equal moments and its centre of mass exactly"


test_what_has_no_answer_is_refused = refuses(
    [
        (lambda: exact.free_body(STANDARD, [1, 2]), "omega: expected shape (..., 3)"),
        (
            lambda: exact.free_body(BODY, [1e-305, 0.0, 0.0]),
            "omega = 1e-305: must be zero or reach 1e-300 rad/s",
        ),
        (
            lambda: exact.tilt_time(TOP, [0.0, 0.0, 1.0], limit=1e-160),
            ["limit = 1e-160: must lie in ", " and reach 1e-150"],
        ),
        (lambda: exact.free_body(STANDARD, [1, 2, np.inf]), "omega[2] = inf: must be"),
        (lambda: exact.flip_times("box", [1, 2, 3]), TypeError, "must be a rigid.Free"),  # type: ignore[arg-type]
        (lambda: exact.flip_times(STANDARD, [1, 2, 3], axis=0), "axis = 0: must be"),
        (lambda: exact.flip_times(STANDARD, [1, 2, 3], count=0), "count = 0: must be"),
        (lambda: exact.flip_times(STANDARD, [1, -1, 0]), "omega[0] = [1.0, -1.0, 0.0]"),
        (lambda: exact.flip_times(HEAVY, [1, 2, 3]), "axis = 3: no closed form"),
        (lambda: exact.flip_times(TOP, [1, 2, 3], axis=1), "axis = 1: no closed form"),
        (
            lambda: exact.flip_times(rigid.HeavyTop(TOP.body, mgl=1.0, com=SIDES), [1, 2, 3]),
            "axis = 3: no closed form",
        ),
        (lambda: exact.lagrange_top(FREE, [1, 2, 3]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: exact.lagrange_top(HEAVY, [1, 2, 3]), NO_LAGRANGE),
        (lambda: exact.tilt_time(HEAVY, [1, 2, 3], limit=1.0), NO_LAGRANGE),
        (lambda: exact.tilt_time(TOP, [1, 2, 3], limit=0.0), "limit = 0.0: must be"),
        (lambda: exact.tilt_time(TOP, [1, 2, 3], limit=4.0), "limit = 4.0: must lie"),
        (lambda: exact.sleeping_spin(HEAVY), NO_LAGRANGE),
        (
            lambda: exact.sleeping_spin(rigid.HeavyTop(TOP.body, mgl=0.0)),
            "mgl = 0: a top without weight is a free body",
        ),
        (lambda: exact.steady_precession(TOP, -0.1, 1.0), "tilt = -0.1: must lie in"),
        (lambda: exact.steady_precession(TOP, [0.1, 4.0], 1.0), "tilt[1] = 4.0: must"),
        (lambda: exact.steady_precession(TOP, 0.1, np.nan), "spin = nan: must be"),
        (lambda: exact.pendulum_period(FREE, 1.0, axis=1), TypeError, "must be a rigid.Heavy"),
        (lambda: exact.pendulum_period(HEAVY, 1.0, axis=1), "exactly across that"),
        (lambda: exact.pendulum_period(HEAVY, 4.0, axis=2), "amplitude = 4.0: must"),
        (lambda: exact.carlson_rf(-1.0, 1.0, 1.0), "x = -1.0: must not be negative"),
        (lambda: exact.carlson_rf(0.0, 0.0, 1.0), "number of zeros among x, y, z = 2"),
        (lambda: exact.carlson_rf(np.inf, 1.0, 1.0), "x = inf: must be finite"),
        (lambda: exact.carlson_rf("a", 1.0, 1.0), TypeError, "x = 'a': must be real numbers"),
        (lambda: exact.carlson_rc(1.0, 0.0), "y = 0.0: must not be zero"),
        (lambda: exact.carlson_rc(0.0, -1.0), "x = 0.0: must be positive where y is"),
        (lambda: exact.carlson_rd(1.0, 1.0, 0.0), "z = 0.0: must be positive"),
        (lambda: exact.carlson_rj(1.0, 1.0, 1.0, [1.0, -2.0]), "p[1] = -2.0: must be"),
        (lambda: exact.carlson_rd(1.0, 2.0, 1e308), "z = 1e+308: must be at most"),
        (lambda: exact.carlson_rj(1.0, 1e206, 2.0, 1.0), "y = 1e+206: must be at most"),
        (lambda: exact.agm(-1.0, 1.0), "a = -1.0: must not be negative"),
        (lambda: exact.jacobi(1.0, 1.5), "mc = 1.5: must lie in [0, 1]"),
        (lambda: exact.jacobi(1e16, 0.5), "u = 1e+16: must lie below 2**50 in size"),
    ],
    literal=True,
)
