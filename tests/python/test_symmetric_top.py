"""The heavy symmetric top as the textbook tells it, against its path and the worked cases."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.special import ellipk

import rigid
from physics import ROUNDOFF, Floats, golden_number, present, rotation_matrix, tilted
from rigid import exact, free, top

SIXTY = np.pi / 3
#: The top of the worked cases.
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
#: Body and start on which the printed formulas were tried: tilt, precession, nutation and spin.
I1, I3, MGL = 1.3, 0.7, 2.1
OTHER = rigid.HeavyTop(rigid.Body((I1, I1, I3)), mgl=MGL)
TILT, PUSH, NOD, SPIN = 0.9, 0.25, 0.35, 5.0
RANDOM = np.random.default_rng(51)

#: Name, spin, precession at 60 degrees, kind, a, b, mean precession as printed.
LOCI = [
    ("cusp", 5.0, 0.0, "cusp", 1.25, 2.5),
    ("loop", 5.0, -0.3, "prolate", 1.025, 2.5),
    ("mono_upper", 5.0, 0.2, "curtate", 1.4, 2.5),
    ("mono_lower", 5.0, 0.6, "curtate", 1.7, 2.5),
    ("loop_lower", 5.0, 1.5, "prolate", 2.375, 2.5),
    ("retro", 1.0, -4.0, "retrograde", -2.75, 0.5),
]
EVERY_LOCUS = pytest.mark.parametrize(("name", "spin", "push", "kind", "a", "b"), LOCI)


def state(tilt: float, push: float, nod: float, spin: float) -> tuple[list[float], Floats]:
    """Rates and attitude with phi = psi = 0."""
    return [nod, push * np.sin(tilt), spin], tilted(tilt)


def four(scene: rigid.HeavyTop, omega: ArrayLike, attitude: ArrayLike) -> dict[str, Any]:
    found = top.heavy_constants(scene, omega, attitude)
    return {name: getattr(found, name) for name in ("a", "b", "alpha", "beta")}


def euler(scene: rigid.HeavyTop, start: Any, t: ArrayLike) -> tuple[Floats, ...]:
    """Tilt and the three Euler rates along the path, from the rates and the attitude."""
    run = rigid.simulate(scene, *start, t=t)
    matrix = rotation_matrix(present(run.attitude))
    theta = np.arccos(matrix[:, 2, 2])
    psi = np.arctan2(matrix[:, 2, 0], matrix[:, 2, 1])
    w1, w2, w3 = run.omega.T
    precession = (w1 * np.sin(psi) + w2 * np.cos(psi)) / np.sin(theta)
    return theta, precession, w1 * np.cos(psi) - w2 * np.sin(psi), w3 - precession * np.cos(theta)


# The six loci of the table, by the textbook and by the motion


@EVERY_LOCUS
def test_six_loci(name: str, spin: float, push: float, kind: str, a: float, b: float) -> None:
    start = state(SIXTY, push, 0.0, spin)
    constants = four(TOP, *start)
    assert constants["a"] == pytest.approx(a, rel=4 * ROUNDOFF)
    assert constants["b"] == b
    assert constants["beta"] == 2.0
    roots = top.f_roots(**constants)
    expected = golden_number(f"heavy.{name}.u1,u2,u3")
    assert [float(roots.u1), float(roots.u2), float(roots.u3)] == pytest.approx(
        expected, rel=4e-15, abs=4e-15
    )
    period, phi, psi, mean = golden_number(f"heavy.{name}.T,dphi,dpsi,mean_phidot")
    assert top.nutation_period(**constants) == pytest.approx(period, rel=2e-14)
    turned = top.advance(TOP, *start)
    assert turned.period == pytest.approx(period, rel=2e-14)
    assert turned.precession == pytest.approx(phi, rel=2e-14)
    assert turned.spin == pytest.approx(psi, rel=2e-14, abs=2e-14)
    assert turned.mean_precession == pytest.approx(mean, rel=2e-14)
    assert top.classify_locus(TOP, *start) == kind
    # By the motion: after ten seconds, and between the roots; phi advances as said.
    run = rigid.simulate(TOP, *start, t=[10.0])
    assert run.omega[0] == pytest.approx(golden_number(f"heavy.{name}.t10.w_body"), abs=4e-14)
    t = np.linspace(0.0, period, 1025)
    path = top.locus(TOP, *start, t=np.append(t, 10.0))
    assert path.point[-1] == pytest.approx(
        golden_number(f"heavy.{name}.t10.axis(x,y,z)"), abs=4e-14
    )
    height = np.cos(path.theta[:-1])
    # A period on from a turning point: 512 steps are half of it, and the extremes are met.
    assert height.min() == pytest.approx(expected[0], abs=1e-14)
    assert height.max() == pytest.approx(expected[1], abs=1e-14)
    assert path.phi[-2] - path.phi[0] == pytest.approx(phi, abs=2e-14 * abs(phi) + 2e-14)
    # The sign of phi' by which the kind is named.
    rates = np.diff(path.phi[:-1])
    forward, backward = bool((rates > 0.0).any()), bool((rates < 0.0).any())
    assert (forward, backward) == {
        "cusp": (True, False),
        "curtate": (True, False),
        "prolate": (True, True),
        "retrograde": (False, True),
    }[kind]


def test_the_asymmetric_top_of_the_table() -> None:
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.5, 0.5)), mgl=1.0)
    start = [0.2, 0.1, 5.0], tilted(SIXTY)
    run = rigid.simulate(scene, *start, t=[0.0, 5.0], method="dop853", step=2.5e-3)
    assert run.omega[1] == pytest.approx(golden_number("heavy.asym.t5.w"), abs=1e-12)
    path = rotation_matrix(present(run.attitude)[1])[:, 2]
    assert path == pytest.approx(golden_number("heavy.asym.t5.axis"), abs=1e-12)
    automatic = top.locus(scene, *start, t=[0.0, 5.0])
    # By the fallback of a body without a closed form, in steps of its own choice.
    assert automatic.point[1] == pytest.approx(golden_number("heavy.asym.t5.axis"), abs=1e-5)
    found = top.heavy_constants(scene, run.omega, present(run.attitude))
    assert np.ptp(found.energy) < 1e-12
    assert np.ptp(found.p_phi) < 1e-12
    # A general body has no third constant.
    assert found.p_psi is found.a is found.E_prime is None
    assert 0.5 * np.diff(run.omega[:, 2])[0] == pytest.approx(-0.00728107, abs=5e-9)


# Constants and rates


def test_constants_are_constant() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    t = np.linspace(0.0, 12.0, 601)
    run = rigid.simulate(OTHER, *start, t=t)
    found = top.heavy_constants(OTHER, run.omega, present(run.attitude))
    for name in ("energy", "p_phi", "p_psi", "E_prime", "a", "b", "alpha", "beta"):
        values = present(getattr(found, name))
        np.testing.assert_allclose(values, values[0], rtol=1e-13)
    assert np.ptp(found.kinetic) > 0.1
    # By Euler's angles: e_phi is the vertical, e_psi the axis.
    theta, precession, nodding, spinning = euler(OTHER, start, t)
    sine, cosine = np.sin(theta), np.cos(theta)
    p_psi = I3 * (spinning + precession * cosine)
    p_phi = I1 * sine**2 * precession + p_psi * cosine
    np.testing.assert_allclose(present(found.p_psi), p_psi, rtol=1e-13)
    np.testing.assert_allclose(found.p_phi, p_phi, rtol=1e-13)
    energy = 0.5 * I1 * (nodding**2 + precession**2 * sine**2) + p_psi**2 / (2 * I3) + MGL * cosine
    np.testing.assert_allclose(found.energy, energy, rtol=1e-13)
    # D-32: the printed energy has no I before phi'².
    printed = 0.5 * (I1 * nodding**2 + precession**2 * sine**2) + p_psi**2 / (2 * I3) + MGL * cosine
    assert np.ptp(printed) > 0.15
    # D-31: I phi' sin² + I b cos = I a, printed = I b.
    left = I1 * precession * sine**2 + I1 * present(found.b) * cosine
    np.testing.assert_allclose(left, I1 * present(found.a), rtol=1e-13)
    assert np.abs(left - I1 * present(found.b)).min() > 0.5


@pytest.mark.parametrize("axis", [1, 2, 3])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_any_axis_and_either_side(axis: int, side: float) -> None:
    scene = rigid.HeavyTop(
        rigid.Body(np.roll((I1, I1, I3), axis)), mgl=MGL, com=np.roll((0.0, 0.0, side), axis)
    )
    omega = np.roll((0.3, 0.4, side * 5.0), axis)
    attitude = RANDOM.normal(size=4)
    run = rigid.simulate(scene, omega, attitude, t=np.linspace(0.0, 5.0, 51))
    found = top.heavy_constants(scene, run.omega, present(run.attitude))
    for name in ("energy", "p_phi", "p_psi", "E_prime"):
        values = present(getattr(found, name))
        np.testing.assert_allclose(values, values[0], rtol=1e-12)
    assert present(found.b)[0] == pytest.approx(I3 * 5.0 / I1, rel=1e-15)
    # The turning points from the constants are those of the state.
    motion = exact.lagrange_top(scene, omega, attitude)
    E_prime = float(present(found.E_prime)[0])
    upper, lower = top.turning_angles(
        scene, a=present(found.a)[0], b=present(found.b)[0], E_prime=E_prime
    )
    assert upper == pytest.approx(float(motion.tilt_min), abs=1e-13)
    assert lower == pytest.approx(float(motion.tilt_max), abs=1e-13)


def test_precession_and_spin_at_a_tilt() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    t = np.linspace(0.0, 12.0, 601)
    theta, precession, _, spinning = euler(OTHER, start, t)
    constants = four(OTHER, *start)
    a, b = constants["a"], constants["b"]
    found = top.precession_spin_rates(OTHER, theta, a=a, b=b)
    np.testing.assert_allclose(found[0], precession, atol=1e-12)
    np.testing.assert_allclose(found[1], spinning, atol=1e-12)
    # At the poles: the limits of tops that get there.
    for end, sign in ((0.0, 1.0), (np.pi, -1.0)):
        near = abs(end - 1e-5)
        at = top.precession_spin_rates(OTHER, end, a=sign * 2.5, b=2.5)
        beside = top.precession_spin_rates(OTHER, near, a=sign * 2.5, b=2.5)
        assert at[0] == sign * 1.25
        # phi' = b / (2 cos²(tilt/2)): second order in the tilt; a - b keeps its digits.
        np.testing.assert_allclose(at, beside, rtol=1e-9)
        assert at[1] + sign * at[0] == pytest.approx(I1 * 2.5 / I3, rel=4 * ROUNDOFF)


# The effective potential


def test_the_effective_potential() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    theta, _, nodding, _ = euler(OTHER, start, np.linspace(0.0, 12.0, 601))
    found = top.heavy_constants(OTHER, *start)
    a, b = present(found.a), present(found.b)
    potential = top.effective_potential(OTHER, theta, a=a, b=b)
    level = present(found.E_prime)
    np.testing.assert_allclose(0.5 * I1 * nodding**2 + potential.value, level, rtol=1e-13)
    # The slope is the derivative, and the force of the nutation.
    step = 1e-3
    around = [
        top.effective_potential(OTHER, theta + n * step, a=a, b=b).value for n in (-2, -1, 1, 2)
    ]
    slope = (around[0] - 8 * around[1] + 8 * around[2] - around[3]) / (12 * step)
    np.testing.assert_allclose(potential.slope, slope, atol=1e-9)
    turning = top.turning_angles(OTHER, a=a, b=b, E_prime=level)
    at = top.effective_potential(OTHER, np.array(turning), a=a, b=b).value
    np.testing.assert_allclose(at, level, rtol=1e-14)
    assert turning[0] <= theta.min()
    assert turning[1] >= theta.max()


def test_the_potential_has_one_minimum_between_two_walls() -> None:
    a, b = 3.0 * RANDOM.normal(size=(2, 300, 1))
    theta = np.linspace(0.01, np.pi - 0.01, 3000)
    value = top.effective_potential(OTHER, theta, a=a, b=b).value
    turns = np.diff(np.sign(np.diff(value, axis=1)), axis=1)
    assert ((turns > 0).sum(axis=1) <= 1).all()
    assert ((turns < 0).sum(axis=1) == 0).all()
    lowest = top.effective_minimum(OTHER, a=a[:, 0], b=b[:, 0])
    inside = (lowest > 0.011) & (lowest < np.pi - 0.011)
    assert inside.mean() > 0.9
    np.testing.assert_allclose(lowest[inside], theta[value.argmin(axis=1)][inside], atol=2e-3)
    slope = top.effective_potential(OTHER, lowest, a=a[:, 0], b=b[:, 0]).slope
    # In units of the terms that cancel: I1 b² and mgl.
    assert (np.abs(slope[inside]) < 1e-12 * (I1 * b[inside, 0] ** 2 + MGL + 20.0)).all()


def test_ends_of_the_potential() -> None:
    # D-40: infinite at both ends, but for a = b at 0 and a = -b at pi.
    ends = [0.0, np.pi]
    walls = top.effective_potential(OTHER, ends, a=1.0, b=2.0)
    assert walls.value.tolist() == [np.inf, np.inf]
    assert walls.slope.tolist() == [-np.inf, np.inf]
    assert top.effective_potential(OTHER, 0.0, a=2.0, b=2.0).value == MGL
    assert top.effective_potential(OTHER, 0.0, a=2.0, b=2.0).slope == 0.0
    assert top.effective_potential(OTHER, np.pi, a=2.0, b=2.0).value == np.inf
    assert top.effective_potential(OTHER, np.pi, a=-2.0, b=2.0).value == -MGL
    assert top.effective_potential(OTHER, 1e-4, a=2.0, b=2.0).value == pytest.approx(MGL, rel=1e-8)
    # A sleeping top is in its minimum; below the bound the minimum has left the vertical.
    bound = 2.0 * np.sqrt(MGL / I1)
    lowest = top.effective_minimum(
        OTHER, a=[1.01 * bound, bound, 0.99 * bound, -2.0], b=[1.01 * bound, bound, 0.99 * bound, 2]
    )
    assert lowest[0] == 0.0
    assert lowest[1] == pytest.approx(0.0, abs=1e-7)
    assert lowest[2] == pytest.approx(2 * np.arccos(np.sqrt(0.99)), rel=1e-12)
    assert lowest[3] == np.pi
    assert top.effective_minimum(OTHER, a=0.0, b=0.0) == np.pi
    assert top.effective_minimum(OTHER, a=np.empty(0), b=2.0).shape == (0,)


# Steady precession


@pytest.mark.parametrize("tilt", [0.8, 0.5 * np.pi, 2.0])
def test_steady_precession_is_the_minimum_and_lasts(tilt: float) -> None:
    found = top.steady_precession(OTHER, tilt, 9.0)
    for rate in (found.slow, found.fast):
        if np.isnan(rate):
            assert tilt == 0.5 * np.pi
            assert found.fast_approx == np.inf
            continue
        start = state(tilt, float(rate), 0.0, 9.0)
        constants = four(OTHER, *start)
        a, b = constants["a"], constants["b"]
        slope = top.effective_potential(OTHER, tilt, a=a, b=b).slope
        assert abs(slope) < 1e-13 * I1 * rate**2 + 1e-13 * MGL
        assert top.effective_minimum(OTHER, a=a, b=b) == pytest.approx(tilt, rel=1e-13)
        path = top.locus(OTHER, *start, t=np.linspace(0.0, 1000.0, 1001))
        # A double root to the square root of rounding.
        np.testing.assert_allclose(path.theta, tilt, atol=1e-6)
        # D-33: of B = phi' sin² the quadratic has + mgl sin⁴, printed - mgl sin⁴.
        big, s, c = rate * np.sin(tilt) ** 2, np.sin(tilt), np.cos(tilt)
        terms = [I1 * c * big**2, -I1 * b * s**2 * big, MGL * s**4]
        assert abs(sum(terms)) < 1e-14 * max(map(abs, terms))
        assert abs(terms[0] + terms[1] - terms[2]) > 0.1 * abs(terms[2])


def test_numbers_of_steady_precession() -> None:
    found = top.steady_precession(TOP, SIXTY, 5.0)
    # D-34: the slow one is the root with the minus sign.
    assert found.slow == pytest.approx(golden_number("heavy.steady60.w3=5.slow"), rel=1e-14)
    assert found.fast == pytest.approx(golden_number("heavy.steady60.w3=5.fast"), rel=1e-14)
    assert found.slow == pytest.approx(0.438447187191, abs=5e-13)
    assert found.fast == pytest.approx(4.56155281281, abs=5e-12)
    assert (found.slow_approx, found.fast_approx) == pytest.approx((0.4, 5.0))
    assert found.spin_min == pytest.approx(2.82842712475, abs=5e-12)
    slow, fast = 0.351050, 6.604751  # of the trial top at 0.8 rad and 9 rad/s
    trial = top.steady_precession(OTHER, 0.8, 9.0)
    assert (trial.slow, trial.fast) == pytest.approx((slow, fast), abs=5e-7)
    # D-35: at the bound itself there is one, a double root; below it there is none.
    bound = top.steady_precession(TOP, SIXTY, found.spin_min)
    assert bound.slow == bound.fast == pytest.approx(np.sqrt(2.0), rel=1e-15)
    below = top.steady_precession(TOP, SIXTY, 0.999 * found.spin_min)
    assert np.isnan([below.slow, below.fast]).all()
    # Below the horizontal always, also without spin.
    low = top.steady_precession(TOP, 2.0, [0.3, 0.0])
    assert np.isfinite([low.slow, low.fast]).all()
    assert low.spin_min.tolist() == [0.0, 0.0]
    assert low.slow_approx[1] == np.inf
    # The approximations become exact.
    quick = top.steady_precession(OTHER, 0.8, 9000.0)
    assert quick.slow / quick.slow_approx == pytest.approx(1.0, abs=1e-6)
    assert quick.fast / quick.fast_approx == pytest.approx(1.0, abs=1e-6)


# The sleeping top


def test_the_sleeping_top() -> None:
    bound = golden_number("heavy.w3sleep")
    spins = bound * np.array([0.98, 1.0, 1.02, -1.02])
    found = top.sleeping_top(TOP, spins)
    assert found.spin_min == bound == 4.0
    assert found.stable.tolist() == [False, True, True, True]
    np.testing.assert_allclose(found.margin, [-0.02, 0.0, 0.02, 0.02], atol=1e-15)
    # Disturbed by a tilt of 1e-6, let go.
    omega = np.outer(spins, [0.0, 0.0, 1.0])
    reached = exact.lagrange_top(TOP, omega, tilted(1e-6)).tilt_max
    assert reached[0] > 0.1
    # Small motions z'' = i b z' + z mgl / I1 grow to 1 / sqrt(1 - (bound/spin)²) times the start.
    assert reached[2] == pytest.approx(1e-6 / np.sqrt(1.0 - 1.02**-2), rel=1e-6)
    # At the bound w = 1 - cos goes to sqrt(2 w0): it wanders, but vanishes with its disturbance.
    assert reached[1] == pytest.approx(np.sqrt(2.0 * np.sqrt(2.0 * 0.5e-12)), rel=1e-3)
    asleep = exact.lagrange_top(TOP, omega[:3], [1.0, 0.0, 0.0, 0.0]).kind
    assert asleep == ("upright", "sleeping", "sleeping")
    hanging = [0.0, 1.0, 0.0, 0.0]
    assert exact.lagrange_top(TOP, [0.0, 0.0, 0.1], hanging).kind == "hanging"
    assert top.classify_locus(TOP, [0.0, 0.0, 0.1], hanging) == "hanging"


def test_the_cubic_of_the_upright_top() -> None:
    u = np.array([0.9, 0.5, -0.3, 1.0])
    for factor in (0.98, 1.0, 1.02):
        spin = 4.0 * factor
        found, approximate = top.upright_f(TOP, spin, u)
        a = 0.5 * spin
        np.testing.assert_allclose(found, top.f_u(u, a=a, b=a, alpha=2.0, beta=2.0), atol=1e-14)
        near, near_approximate = top.upright_f(TOP, spin, 1.0 - 1e-6)
        if factor != 1.0:
            assert near == pytest.approx(near_approximate, rel=1e-4)
            assert (near > 0.0) == (factor < 1.0)
        else:
            # G-19: the approximation says nothing, f = -alpha (1 - u)³ does.
            assert (approximate == 0.0).all()
            np.testing.assert_allclose(found, -2.0 * (1.0 - u) ** 3, atol=1e-15)


def test_friction_wakes_the_sleeping_top() -> None:
    found = top.spin_down(OTHER, [30.0, 2.0, -30.0], damping=0.05)
    bound = 2.0 * np.sqrt(I1 * MGL) / I3
    assert found.spin_min == pytest.approx(bound, rel=1e-15)
    assert found.onset[1] == 0.0
    assert found.onset[0] == found.onset[2]
    at_onset = 30.0 * np.exp(-found.decay * found.onset[0])
    # M² = 4 I1 mgl.
    assert (I3 * at_onset) ** 2 == pytest.approx(4 * I1 * MGL, rel=1e-14)
    assert top.sleeping_top(OTHER, at_onset * (1 + 1e-12)).stable
    assert not top.sleeping_top(OTHER, at_onset * (1 - 1e-12)).stable
    # The torque -c omega3 takes the power c omega3².
    t = np.linspace(0.0, 1.0, 2001)
    omega = np.outer(30.0 * np.exp(-0.05 / I3 * t), [0.0, 0.0, 1.0])
    balance = free.power_balance(
        OTHER, omega, np.tile([1.0, 0.0, 0.0, 0.0], (2001, 1)), t=t, torque=-0.05 * omega
    )
    np.testing.assert_allclose(balance.power, -0.05 * omega[:, 2] ** 2, rtol=1e-15)
    # Differences of second order: (2 c / I3 step)² / 3 of it at the ends.
    assert np.abs(balance.residual / balance.power).max() < 1e-8
    never = top.spin_down(OTHER, [30.0, 1.0], damping=0.0)
    assert never.onset.tolist() == [np.inf, 0.0]


# The cubic and the nutation


def test_the_cubic_is_the_square_of_the_rate_of_height() -> None:
    start = state(TILT, PUSH, NOD, SPIN)
    theta, _, nodding, _ = euler(OTHER, start, np.linspace(0.0, 12.0, 601))
    constants = four(OTHER, *start)
    found = top.f_u(np.cos(theta), **constants)
    np.testing.assert_allclose(found, (nodding * np.sin(theta)) ** 2, atol=1e-13)
    a, b = constants["a"], constants["b"]
    assert top.f_u(1.0, **constants) == pytest.approx(-((a - b) ** 2), rel=1e-15)
    assert top.f_u(-1.0, **constants) == pytest.approx(-((a + b) ** 2), rel=1e-15)


def random_tops(count: int) -> tuple[Floats, Floats]:
    tilt = RANDOM.uniform(0.05, 3.09, count)
    push, nod = 3.0 * RANDOM.normal(size=count), 2.0 * RANDOM.normal(size=count)
    spin = np.abs(4.0 * RANDOM.normal(size=count)) + 0.01
    omega = np.stack([nod, push * np.sin(tilt), spin], axis=-1)
    zero = np.zeros(count)
    return omega, np.stack([np.cos(tilt / 2), np.sin(tilt / 2), zero, zero], axis=-1)


def test_roots_of_many_tops() -> None:
    omega, attitude = random_tops(5000)
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
    omega, attitude = random_tops(5000)
    constants = four(OTHER, omega, attitude)
    roots = top.f_roots(**constants)
    still = constants["a"] / constants["b"]
    kinds = np.array(top.classify_locus(OTHER, omega, attitude))
    expected = np.select([still > roots.u2, still > roots.u1], ["curtate", "prolate"], "retrograde")
    assert (kinds == expected).all()
    # G-18: the fourth kind exists, always with a/b < -1.
    fourth = kinds == "retrograde"
    assert 0.2 < fourth.mean() < 0.3
    assert still[fourth].max() < -1.0
    # A loop advances with the spin on the whole, if the upper circle is its own.
    mean = top.advance(OTHER, omega, attitude).mean_precession
    assert (mean[kinds == "prolate"] > 0.0).all()
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


def test_steady_and_leading_axes() -> None:
    rate = float(top.steady_precession(TOP, SIXTY, 5.0).slow)
    steady = top.f_roots(**four(TOP, *state(SIXTY, rate, 0.0, 5.0)))
    assert steady.u2 - steady.u1 < 1e-6
    upright = [1.0, 0.0, 0.0, 0.0]
    assert top.classify_locus(TOP, [0.0, 0.0, 5.0], upright) == "sleeping"
    assert top.classify_locus(TOP, [0.0, 0.0, 3.0], upright) == "upright"
    assert isinstance(top.classify_locus(TOP, [0.0, 0.0, 3.0], upright), str)
    omega = np.broadcast_to([0.1, 0.2, 3.0], (2, 4, 3))
    assert np.shape(top.classify_locus(TOP, omega, tilted(1.0))) == (2, 4)
    assert top.advance(TOP, omega, tilted(1.0)).period.shape == (2, 4)
    path = top.locus(TOP, omega, tilted(1.0), t=[0.0, 1.0, 2.0])
    assert path.theta.shape == path.phi.shape == (2, 4, 3)
    assert path.point.shape == (2, 4, 3, 3)
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
    kinds = ["curtate", "curtate", "cusp", "cusp", "prolate", "prolate", "steady"]
    found = top.fast_top_approx(TOP, 1.0, 5.0, precession=pushes, t=np.linspace(0, 5, 501))
    assert np.array(found.kind).tolist() == kinds
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
    assert exactly == ["curtate", "prolate", "cusp", "curtate", "prolate"]


def test_the_equation_of_precession() -> None:
    # D-37: I sin phi'' = I3 omega3 theta' - 2 I cos theta' phi'; printed, sin(2 theta) for 2 cos.
    start = state(TILT, PUSH, NOD, SPIN)
    step = 1e-3
    t = np.arange(0.5, 12.0, 0.5)[:, None] + step * np.arange(-2, 3)
    theta, precession, nodding, _ = (row.reshape(-1, 5) for row in euler(OTHER, start, t.ravel()))
    change = (precession[:, 0] - 8 * precession[:, 1] + 8 * precession[:, 3] - precession[:, 4]) / (
        12 * step
    )
    th, ph, no = theta[:, 2], precession[:, 2], nodding[:, 2]
    left = I1 * np.sin(th) * change
    np.testing.assert_allclose(left, I3 * SPIN * no - 2 * I1 * np.cos(th) * no * ph, atol=1e-9)
    printed = I3 * SPIN * no - I1 * np.sin(2 * th) * no * ph
    assert np.abs(printed - left).max() > 0.02 * np.abs(left).max()


# The torque of the weight


def test_the_torque_of_the_weight() -> None:
    attitude = RANDOM.normal(size=(200, 4))
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=2.1, com=(0.6, 0.0, 0.8))
    turn = rotation_matrix(attitude)
    arm = turn @ np.array(scene.com)
    in_space = top.gravity_torque(scene, attitude, frame="space")
    np.testing.assert_allclose(in_space, np.cross(arm, [0.0, 0.0, -2.1]), atol=1e-14)
    in_body = top.gravity_torque(scene, attitude)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", turn, in_body), in_space, atol=1e-14)
    # Along the node line: nothing about the vertical, nothing about the axis.
    np.testing.assert_allclose(in_space[:, 2], 0.0, atol=1e-15)
    np.testing.assert_allclose(in_body @ np.array(scene.com), 0.0, atol=1e-15)
    theta = np.arccos(arm[:, 2])
    np.testing.assert_allclose(np.linalg.norm(in_space, axis=1), 2.1 * np.sin(theta), rtol=1e-12)
    # -dV/dtheta about the node line, and what moves the rates.
    angle = np.array([0.4, 1.0, 2.5])
    leaning = np.stack([tilted(one) for one in angle])
    pulled = top.gravity_torque(TOP, leaning)
    np.testing.assert_allclose(pulled[:, 0], TOP.mgl * np.sin(angle), atol=1e-15)
    step = 1e-3
    times = step * np.arange(-2, 3)
    run = rigid.simulate(OTHER, *state(TILT, PUSH, NOD, SPIN), t=times)
    change = (run.omega[0] - 8 * run.omega[1] + 8 * run.omega[3] - run.omega[4]) / (12 * step)
    torque = top.gravity_torque(OTHER, present(run.attitude)[2])
    np.testing.assert_allclose(free.euler_rhs(OTHER.body, run.omega[2], torque), change, atol=1e-9)


# Refusals

NO_TOP: Any = rigid.FreeBody(TOP.body)
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0)
NOT_SYMMETRIC = "a symmetric top has two moments equal to the bit"


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda: top.heavy_constants(NO_TOP, [1, 2, 3], tilted(1)), TypeError, "must be a rigid.H"),
        (lambda: top.heavy_constants(TOP, [1, 2], tilted(1)), ValueError, "omega: expected shape"),
        (lambda: top.heavy_constants(TOP, [1, 2, 3], [0, 0, 0, 0]), ValueError, "must not be zero"),
        (lambda: top.precession_spin_rates(HEAVY, 1.0, a=1, b=1), ValueError, NOT_SYMMETRIC),
        (
            lambda: top.precession_spin_rates(TOP, [1.0, 0.0], a=1.0, b=2.0),
            ValueError,
            "tilt[1] = 0.0: is reached only if a = b",
        ),
        (lambda: top.precession_spin_rates(TOP, -1.0, a=1, b=1), ValueError, "tilt = -1.0: must"),
        (lambda: top.gravity_torque(NO_TOP, tilted(1)), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.gravity_torque(TOP, tilted(1), frame="lab"), ValueError, "frame = 'lab'"),
        (lambda: top.effective_potential(TOP, 4.0, a=1, b=1), ValueError, "tilt = 4.0: must lie"),
        (lambda: top.effective_potential(TOP, 1.0, a=np.nan, b=1), ValueError, "a = nan: must be"),
        (lambda: top.effective_minimum(HEAVY, a=1, b=1), ValueError, NOT_SYMMETRIC),
        (
            lambda: top.effective_minimum(rigid.HeavyTop(TOP.body, mgl=0.0), a=0.0, b=0.0),
            ValueError,
            "the effective potential is constant",
        ),
        (
            lambda: top.turning_angles(TOP, a=1.25, b=2.5, E_prime=-0.9),
            ValueError,
            "alpha = -1.8: no motion has this energy and these momenta",
        ),
        (lambda: top.steady_precession(HEAVY, 1.0, 5.0), ValueError, "a Lagrange top has two"),
        (lambda: top.steady_precession(TOP, 4.0, 5.0), ValueError, "tilt = 4.0: must lie in"),
        (lambda: top.sleeping_top(TOP, np.inf), ValueError, "spin = inf: must be finite"),
        (
            lambda: top.sleeping_top(rigid.HeavyTop(TOP.body, mgl=0.0), 1.0),
            ValueError,
            "mgl = 0: a top without weight",
        ),
        (lambda: top.upright_f(HEAVY, 1.0, 0.5), ValueError, "a Lagrange top has two"),
        (lambda: top.spin_down(TOP, 5.0, damping=-1.0), ValueError, "damping = -1.0: must not be"),
        (lambda: top.f_u(np.nan, a=1, b=1, alpha=1, beta=1), ValueError, "u = nan: must be finite"),
        (lambda: top.f_roots(a=1, b=1, alpha=1, beta=-1), ValueError, "beta = -1.0: must not be"),
        (lambda: top.f_roots(a=5, b=0, alpha=1, beta=1), ValueError, "alpha = 1.0: no motion has"),
        (lambda: top.f_roots(a=1, b=1, alpha=0.5, beta=2), ValueError, "alpha = 0.5: no motion"),
        (lambda: top.f_roots(a=0, b=0, alpha=0, beta=0), ValueError, "alpha = 0.0: must be positi"),
        (
            lambda: top.time_of([0.3, 0.6], a=1.25, b=2.5, alpha=1.0, beta=2.0),
            ValueError,
            "u[1] = 0.6: must lie between the roots u1 and u2",
        ),
        (lambda: top.u_of(np.inf, a=1.25, b=2.5, alpha=1, beta=2), ValueError, "t = inf: must be"),
        (lambda: top.classify_locus(HEAVY, [1, 2, 3]), ValueError, "a Lagrange top has two"),
        (lambda: top.advance(NO_TOP, [1, 2, 3]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.locus(NO_TOP, [1, 2, 3], t=[0.0]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.fast_top_approx(TOP, 1.0, 0.0), ValueError, "spin = 0.0: a fast top needs a"),
        (lambda: top.fast_top_approx(HEAVY, 1.0, 5.0), ValueError, NOT_SYMMETRIC),
        (lambda: top.fast_top_approx(TOP, 1.0, 5.0, t=1.0), ValueError, "t: expected shape (m,)"),
    ],
)  # fmt: skip
def test_what_has_no_answer_is_refused(
    call: Callable[[], object], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind) as error:
        call()
    assert message in str(error.value)
