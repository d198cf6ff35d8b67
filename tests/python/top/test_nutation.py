"""The nutation of a symmetric top: its cubic, its period, the kinds of loci, the fast top."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

import rigid
from physics import Floats, present, rotation_matrix, slope, tilted
from rigid import exact, top
from trial_tops import (
    I1,
    I3,
    MGL,
    NOD,
    OTHER,
    PUSH,
    SIXTY,
    SPIN,
    TILT,
    TOP,
    euler,
    four,
    random_tops,
    state,
)

RANDOM = np.random.default_rng(56)


def test_the_cubic_is_the_square_of_the_rate_of_height() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    theta, _, nodding, _ = euler(OTHER, start, np.linspace(0.0, 12.0, 601))
    constants = four(OTHER, *start)
    found = top.f_u(np.cos(theta), **constants)
    np.testing.assert_allclose(found, (nodding * np.sin(theta)) ** 2, atol=1e-13)
    a, b = constants["a"], constants["b"]
    assert top.f_u(1.0, **constants) == pytest.approx(-((a - b) ** 2), rel=1e-15)
    assert top.f_u(-1.0, **constants) == pytest.approx(-((a + b) ** 2), rel=1e-15)


def test_roots_of_many_tops() -> None:
    omega, attitude = random_tops(5000, RANDOM)
    constants = four(OTHER, omega, attitude)
    roots = top.f_roots(**constants)
    motion = exact.lagrange_top(OTHER, omega, attitude)
    for angle, expected in (
        (roots.theta_upper, motion.tilt_min),
        (roots.theta_lower, motion.tilt_max),
    ):
        # arccos of a height with a rounding of some 1e-15.
        np.testing.assert_allclose(np.cos(angle), np.cos(expected), atol=2e-13)
    assert (roots.u1 >= -1.0).all()
    assert (roots.u2 <= 1.0).all()
    assert (roots.u3 >= 1.0).all()
    # f vanishes, in units of its largest term.
    size = 1.0 + constants["alpha"] + constants["beta"] + constants["a"] ** 2 + constants["b"] ** 2
    for root in (roots.u1, roots.u2, roots.u3):
        scale = size * np.maximum(np.abs(root), 1.0) ** 3
        assert (np.abs(top.f_u(root, **constants)) < 1e-14 * scale).all()
    np.testing.assert_allclose(top.nutation_period(**constants), motion.period, rtol=1e-11)


def test_roots_that_lie_close_together_keep_their_digits() -> None:
    # A top of 1e4 rad/s released at 60 degrees: Goldstein, eq. (5.69), for its fall by x.
    b, beta = 2.0**14, 2.0
    p = b * b / beta - 1.0
    fall = 1.5 / (p + np.sqrt(p * p + 3.0))
    fast = top.f_roots(a=0.5 * b, b=b, alpha=0.5 * beta, beta=beta)
    # A few roundings of numbers of size one; half² less the product errs by their square root.
    assert abs(fast.u2 - 0.5) < 1e-15
    assert abs(fast.u1 - (0.5 - fall)) < 1e-15
    # A pendulum that swings on an ellipse of some 1e-4 rad: of its roots without spin,
    # u1 u2 + u1 u3 + u2 u3 = -1. The rounding of alpha moves them by one of size one.
    u1, u2 = Fraction(1, 2**27) - 1, Fraction(1, 2**25) - 1
    u3 = -(1 + u1 * u2) / (u1 + u2)
    alpha = 2 * (u1 + u2 + u3)
    constants = {"a": np.sqrt(float(alpha + 2 * u1 * u2 * u3)), "b": 0.0, "alpha": float(alpha)}
    slow = top.f_roots(**constants, beta=2.0)
    assert abs(slow.u1 - float(u1)) < 1e-15
    assert abs(slow.u2 - float(u2)) < 1e-15
    plane = top.f_roots(a=0.0, b=0.0, alpha=2.0 * float(u2), beta=2.0)
    assert abs(plane.u1 + 1.0) < 1e-15
    assert abs(plane.u2 - float(u2)) < 1e-15


def test_states_near_the_vertical_have_roots() -> None:
    # Where the constants hold few digits of the motion, they still must not deny it.
    size = 10.0 ** RANDOM.uniform(-14.0, 0.0, 2000)
    tilt = np.where(np.arange(2000) % 2 == 0, size, np.pi - size)
    rates = RANDOM.normal(size=(2000, 3)) * 10.0 ** RANDOM.uniform(-6.0, 2.0, (2000, 3))
    rates[RANDOM.random((2000, 3)) < 0.3] = 0.0
    zero = np.zeros(2000)
    attitude = np.stack([np.cos(tilt / 2), np.sin(tilt / 2), zero, zero], axis=-1)
    roots = top.f_roots(**four(OTHER, rates, attitude))
    motion = exact.lagrange_top(OTHER, rates, attitude)
    # Double roots: to the square root of their rounding.
    np.testing.assert_allclose(roots.u1, np.cos(motion.tilt_max), atol=1e-6)
    np.testing.assert_allclose(roots.u2, np.cos(motion.tilt_min), atol=1e-6)


def test_roots_of_special_tops() -> None:
    # Steady precession: a double root, to the square root of the rounding of the constants.
    rate = float(top.steady_precession(OTHER, 0.8, 9.0).slow)
    steady = four(OTHER, *state(0.8, rate, 0.0, 9.0))
    roots = top.f_roots(**steady)
    assert roots.u1 == pytest.approx(np.cos(0.8), abs=1e-7)
    assert roots.u2 == pytest.approx(np.cos(0.8), abs=1e-7)
    # Small oscillations about it: the curvature of the potential.
    c, b = np.cos(0.8), steady["b"]
    curvature = (b - rate * c) ** 2 - rate * c * (b - rate * c) + rate**2 - MGL / I1 * c
    assert top.nutation_period(**steady) == pytest.approx(2 * np.pi / np.sqrt(curvature), rel=1e-7)
    # The upright top: u2 = 1; below the bound u1 by f = (1-u)² (alpha (1+u) - a²).
    for spin, u1, period in ((3.0, 0.125, np.inf), (5.0, 1.0, 2 * np.pi / np.sqrt(6.25 - 4.0))):
        upright = {"a": 0.5 * spin, "b": 0.5 * spin, "alpha": 2.0, "beta": 2.0}
        found = top.f_roots(**upright)
        assert (float(found.u1), float(found.u2)) == pytest.approx((u1, 1.0), rel=1e-15)
        assert top.nutation_period(**upright) == pytest.approx(period, rel=1e-15)
    bound = {"a": 2.0, "b": 2.0, "alpha": 2.0, "beta": 2.0}
    assert top.f_roots(**bound).u1 == 1.0
    assert top.nutation_period(**bound) == np.inf
    assert top.u_of(1.0, **bound) == 1.0
    # Hanging: u1 = u2 = -1.
    hanging = four(TOP, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0])
    assert float(top.f_roots(**hanging).u2) == pytest.approx(-1.0, abs=1e-12)
    # Without weight: a free top about L, u3 at infinity, period 2 pi I1 / |L|.
    light = rigid.HeavyTop(OTHER.body, mgl=0.0)
    start = state(TILT, PUSH, NOD, SPIN)
    constants = four(light, *start)
    size = np.linalg.norm(np.array([I1, I1, I3]) * start[0])
    assert top.f_roots(**constants).u3 == np.inf
    assert top.nutation_period(**constants) == pytest.approx(2 * np.pi * I1 / size, rel=1e-14)
    theta = euler_free(light, start, np.array([0.1, 0.5]))
    phase = float(top.time_of(np.cos(TILT), **constants))  # NOD > 0: it goes down
    assert top.u_of(np.array([0.1, 0.5]) - phase, **constants) == pytest.approx(
        np.cos(theta), abs=1e-13
    )


def euler_free(scene: rigid.HeavyTop, start: Any, t: Floats) -> Floats:
    run = rigid.simulate(scene, *start, t=t)
    height: Floats = rotation_matrix(present(run.attitude))[:, 2, 2]
    return np.arccos(height)


def test_the_period_three_ways() -> None:
    constants = four(OTHER, *state(TILT, PUSH, NOD, SPIN))
    roots = top.f_roots(**constants)
    u1, u2, u3 = float(roots.u1), float(roots.u2), float(roots.u3)
    beta = float(constants["beta"])
    period = float(top.nutation_period(**constants))
    # u = u1 + (u2 - u1) sin²: du / sqrt(f).
    half, _ = quad(
        lambda q: 2.0 / np.sqrt(beta * (u3 - u1 - (u2 - u1) * np.sin(q) ** 2)), 0, np.pi / 2,
        epsabs=1e-13,
    )  # fmt: skip
    assert period == pytest.approx(2.0 * half, rel=1e-12)
    modulus = (u2 - u1) / (u3 - u1)
    assert period == pytest.approx(4 * ellipk(modulus) / np.sqrt(beta * (u3 - u1)), rel=1e-13)
    theta = euler(OTHER, state(TILT, PUSH, NOD, SPIN), [0.0, period, 7.0 * period])[0]
    np.testing.assert_allclose(theta, TILT, atol=1e-13)


def test_time_and_height_are_inverse() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    constants = four(OTHER, *start)
    roots = top.f_roots(**constants)
    period = float(top.nutation_period(**constants))
    u = np.linspace(float(roots.u1), float(roots.u2), 41)
    times = top.time_of(u, **constants)
    assert times[0] == pytest.approx(0.0, abs=1e-7)
    assert times[-1] == pytest.approx(0.5 * period, abs=1e-7)
    np.testing.assert_allclose(top.u_of(times, **constants), u, atol=1e-14)
    np.testing.assert_allclose(top.u_of(-times, **constants), u, atol=1e-14)
    # On the path: it starts going down, so it was at the top before.
    t = np.linspace(0.0, 5.0, 51)
    before = float(top.time_of(np.cos(TILT), **constants))
    theta = euler(OTHER, start, t)[0]
    np.testing.assert_allclose(top.u_of(t - before, **constants), np.cos(theta), atol=1e-13)
    # The homoclinic orbit takes for ever to the top.
    falling = {"a": 1.5, "b": 1.5, "alpha": 2.0, "beta": 2.0}
    assert top.time_of(1.0, **falling) == np.inf
    rate = 0.5 * np.sqrt(2.0 * 0.875)
    height = 1.0 - 0.875 / np.cosh(rate * 2.0) ** 2
    assert top.u_of(2.0, **falling) == pytest.approx(height, rel=1e-14)
    assert top.time_of(height, **falling) == pytest.approx(2.0, rel=1e-14)


def test_pendulums() -> None:
    # Without spin and momentum about the vertical: a plane pendulum.
    amplitude = np.array([0.3, 1.5, 3.0])
    flat = {"a": 0.0, "b": 0.0, "alpha": -2.0 * np.cos(amplitude), "beta": 2.0}
    expected = exact.pendulum_period(TOP, amplitude, axis=1)
    # The height has two minima in a swing of the pendulum.
    np.testing.assert_allclose(2.0 * top.nutation_period(**flat), expected, rtol=1e-13)
    # With it: the spherical pendulum, which nearly at the bottom swings twice as its height.
    start = state(2.9, 0.7, 0.1, 0.0)
    constants = four(TOP, *start)
    assert constants["b"] == 0.0
    assert top.classify_locus(TOP, *start) == "spherical pendulum"
    motion = exact.lagrange_top(TOP, *start)
    assert top.nutation_period(**constants) == pytest.approx(float(motion.period), rel=1e-12)
    assert top.classify_locus(TOP, [0.1, 0.0, 0.0], tilted(2.0)) == "planar"


# The kinds of loci


def test_kinds_by_the_ratio_of_the_constants() -> None:
    omega, attitude = random_tops(5000, RANDOM)
    constants = four(OTHER, omega, attitude)
    roots = top.f_roots(**constants)
    still = constants["a"] / constants["b"]
    kinds = np.array(top.classify_locus(OTHER, omega, attitude))
    expected = np.where((roots.u1 < still) & (still <= roots.u2), "loop", "monotone")
    assert (kinds == expected).all()
    # G-18: monotone precession against the spin exists, always with a/b < -1.
    fourth = (kinds == "monotone") & exact.lagrange_top(OTHER, omega, attitude).retrograde
    assert (fourth == (still <= roots.u1)).all()
    assert 0.2 < fourth.mean() < 0.3
    assert still[fourth].max() < -1.0
    # A loop advances with the spin on the whole, if the upper circle is its own.
    mean = top.advance(OTHER, omega, attitude).mean_precession
    assert (mean[kinds == "loop"] > 0.0).all()
    assert (mean[fourth] < 0.0).all()


def test_cusps_are_on_the_upper_circle() -> None:
    tilt = RANDOM.uniform(0.05, 3.0, 500)
    zero = np.zeros(500)
    attitude = np.stack([np.cos(tilt / 2), np.sin(tilt / 2), zero, zero], axis=-1)
    omega = np.stack([zero, zero, RANDOM.uniform(0.5, 9.0, 500)], axis=-1)
    assert (np.array(top.classify_locus(OTHER, omega, attitude)) == "cusp").all()
    motion = exact.lagrange_top(OTHER, omega, attitude)
    np.testing.assert_allclose(motion.tilt_min, tilt, rtol=1e-13)
    assert (motion.tilt_max > tilt).all()


def test_steady_sleeping_and_upright() -> None:
    rate = float(top.steady_precession(TOP, SIXTY, 5.0).slow)
    steady = top.f_roots(**four(TOP, *state(SIXTY, rate, 0.0, 5.0)))
    assert steady.u2 - steady.u1 < 1e-6
    upright = [1.0, 0.0, 0.0, 0.0]
    assert top.classify_locus(TOP, [0.0, 0.0, 5.0], upright) == "sleeping"
    assert top.classify_locus(TOP, [0.0, 0.0, 3.0], upright) == "upright"
    assert isinstance(top.classify_locus(TOP, [0.0, 0.0, 3.0], upright), str)
    assert np.shape(top.classify_locus(TOP, np.empty((0, 3)))) == (0,)
    assert top.locus(TOP, np.empty((0, 3)), t=[1.0]).point.shape == (0, 1, 3)
    asleep = top.locus(TOP, [0.0, 0.0, 5.0], t=[0.0, 1.0])
    assert asleep.phi.tolist() == asleep.theta.tolist() == [0.0, 0.0]


def test_the_locus_of_a_cusp() -> None:
    start = state(SIXTY, 0.0, 0.0, 5.0)
    period = float(top.advance(TOP, *start).period)
    path = top.locus(TOP, *start, t=period * np.arange(4))
    # D-39: cusps share theta, not phi.
    np.testing.assert_allclose(path.theta, SIXTY, atol=1e-14)
    np.testing.assert_allclose(path.phi[1:], [1.142, 2.285, 3.427], atol=5e-4)
    # There the path is vertical: phi rises as theta to the power 3/2.
    near = top.locus(TOP, *start, t=[1e-3, 2e-3])
    rise = np.log2(np.diff(near.phi)[0] / near.phi[0] + 1.0)
    fall = np.log2((near.theta[1] - SIXTY) / (near.theta[0] - SIXTY))
    assert rise / fall == pytest.approx(1.5, abs=1e-3)
    # Theta and phi say the same as the point.
    s, c = np.sin(near.theta), np.cos(near.theta)
    again = np.stack([s * np.sin(near.phi), -s * np.cos(near.phi), c], axis=-1)
    np.testing.assert_allclose(near.point, again, atol=1e-15)


# The fast top


def test_the_fast_top_gets_better_as_the_square_of_its_spin() -> None:
    errors = []
    for spin in (20.0, 40.0, 80.0, 160.0):
        approximate = top.fast_top_approx(OTHER, 1.2, spin)
        t = np.linspace(0.0, 6.0 * np.pi / float(approximate.nutation), 901)
        found = top.fast_top_approx(OTHER, 1.2, spin, t=t)
        path = top.locus(OTHER, *state(1.2, 0.0, 0.0, spin), t=t)
        band = abs(float(found.theta_other) - 1.2)
        missed = np.abs(path.theta - present(found.theta)) / band
        errors.append(missed.max())
        # The estimate is one: above the error, and not by much where that is largest.
        estimate = present(found.error)
        assert (missed <= estimate).all()
        assert missed.max() > 0.5 * estimate[missed.argmax()]
        assert path.theta.max() == pytest.approx(float(found.theta_other), abs=0.1 * band)
        advance = np.abs(path.phi - present(found.phi)).max() / path.phi[-1]
        assert advance < 3.0 * estimate[-1]
    np.testing.assert_allclose(errors, [9.3e-2, 2.4e-2, 6.0e-3, 1.5e-3], rtol=0.04)
    # D-38: at a tilt of 1.2 rad, so not for small angles only.
    assert errors[2] / errors[3] == pytest.approx(3.99, abs=0.02)


def test_the_fast_top_of_either_kind() -> None:
    found = top.fast_top_approx(TOP, 1.0, 5.0)
    assert (float(found.mean_precession), float(found.nutation)) == (0.4, 2.5)
    pushes = [0.2, 0.6, 0.0, 0.8, -0.2, 1.0, 0.4]
    kinds = ["monotone", "monotone", "cusp", "cusp", "loop", "loop", "steady"]
    found = top.fast_top_approx(TOP, 1.0, 5.0, precession=pushes, t=np.linspace(0, 5, 501))
    assert np.array(found.kind).tolist() == kinds
    np.testing.assert_allclose(present(found.phi_rate)[:, 0], pushes, atol=1e-15)
    change = np.gradient(present(found.phi), 0.01, axis=1)[:, 1:-1]
    # Differences of second order: (2.5 * 0.01)² / 6 of 0.6 rad/s.
    np.testing.assert_allclose(change, present(found.phi_rate)[:, 1:-1], atol=1e-4)
    least = present(found.phi_rate).min(axis=1)
    # phi' changes its sign in loops only; a start with twice the mean touches zero on the lower.
    assert (least[[0, 1, 6]] > 0.0).all()
    assert (least[[4, 5]] < 0.0).all()
    np.testing.assert_allclose(least[[2, 3]], 0.0, atol=1e-4)
    # Faster than the mean precession it rises first.
    rising = found.theta_other < found.theta_start
    assert rising.tolist() == [push > 0.4 for push in pushes]
    # The same kinds by the exact motion, of a top that is fast.
    quick = 400.0
    mean = float(top.fast_top_approx(TOP, 1.0, quick).mean_precession)
    omega = [[0.0, share * mean * np.sin(1.0), quick] for share in (0.5, -0.5, 0.0, 1.5, 2.5)]
    exactly = np.array(top.classify_locus(TOP, omega, tilted(1.0))).tolist()
    assert exactly == ["monotone", "loop", "cusp", "monotone", "loop"]


def test_the_equation_of_precession() -> None:
    # D-37: I sin phi'' = I3 omega3 theta' - 2 I cos theta' phi'; printed, sin(2 theta) for 2 cos.
    start = state(TILT, PUSH, NOD, SPIN)
    step = 1e-3
    t = np.arange(0.5, 12.0, 0.5)[:, None] + step * np.arange(-2, 3)
    theta, precession, nodding, _ = (row.reshape(-1, 5) for row in euler(OTHER, start, t.ravel()))
    change = slope(precession.T, step)
    th, ph, no = theta[:, 2], precession[:, 2], nodding[:, 2]
    left = I1 * np.sin(th) * change
    np.testing.assert_allclose(left, I3 * SPIN * no - 2 * I1 * np.cos(th) * no * ph, atol=1e-9)
    printed = I3 * SPIN * no - I1 * np.sin(2 * th) * no * ph
    assert np.abs(printed - left).max() > 0.02 * np.abs(left).max()


@pytest.mark.parametrize("com", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
def test_a_measured_precession_tells_the_spin(com: tuple[float, float, float]) -> None:
    scene = rigid.HeavyTop(rigid.Body((1.3, 1.3, 0.5)), mgl=0.9, com=com)
    for tilt in (0.4, 1.4, 2.5):
        for spin in (9.0, -7.0):
            found = rigid.exact.steady_precession(scene, tilt, spin)
            for rate in (found.slow, found.fast):
                assert np.isclose(
                    rigid.top.spin_from_precession(scene, tilt, rate), spin, rtol=1e-13
                )
    with pytest.raises(ValueError, match=r"precession = 0\.0: must not be zero"):
        rigid.top.spin_from_precession(scene, 1.0, 0.0)
