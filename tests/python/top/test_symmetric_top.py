"""The heavy symmetric top as the textbook tells it, against its path and the worked cases."""

from typing import Any

import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, golden_number, present, rotation_matrix, slope, tilted
from refusals import refuses
from rigid import exact, free, top
from trial_tops import I1, I3, MGL, NOD, OTHER, PUSH, SIXTY, SPIN, TILT, TOP, euler, four, state

RANDOM = np.random.default_rng(51)

#: Name, spin, precession at 60 degrees, kind of locus, a, b.
LOCI = [
    ("cusp", 5.0, 0.0, "cusp", 1.25, 2.5),
    ("loop", 5.0, -0.3, "loop", 1.025, 2.5),
    ("mono_upper", 5.0, 0.2, "monotone", 1.4, 2.5),
    ("mono_lower", 5.0, 0.6, "monotone", 1.7, 2.5),
    ("loop_lower", 5.0, 1.5, "loop", 2.375, 2.5),
    ("retro", 1.0, -4.0, "monotone", -2.75, 0.5),
]
EVERY_LOCUS = pytest.mark.parametrize(("name", "spin", "push", "kind", "a", "b"), LOCI)


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
    retrograde = bool(exact.lagrange_top(TOP, *start).retrograde)
    assert retrograde == (name == "retro")
    assert (forward, backward) == (not retrograde, retrograde or kind == "loop")


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
    around = theta + step * np.arange(-2, 3)[:, np.newaxis]
    values = top.effective_potential(OTHER, around, a=a, b=b).value
    np.testing.assert_allclose(potential.slope, slope(values, step), atol=1e-9)
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
    left = top.effective_potential(OTHER, lowest, a=a[:, 0], b=b[:, 0]).slope
    # In units of the terms that cancel: I1 b² and mgl.
    assert (np.abs(left[inside]) < 1e-12 * (I1 * b[inside, 0] ** 2 + MGL + 20.0)).all()


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
    # A conical pendulum at (a + b)^(1/2) / (mgl/I1 + b²/4)^(1/4) = 8e-7 from the lowest point, up
    # to the square of this angle and the spacing of doubles at pi.
    low = np.pi - top.effective_minimum(TOP, a=-2.0 + 2.0**-40, b=2.0)
    assert low == pytest.approx(2.0**-20.25, rel=2e-9)
    assert top.effective_minimum(OTHER, a=0.0, b=0.0) == np.pi
    assert top.effective_minimum(OTHER, a=np.empty(0), b=2.0).shape == (0,)


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e-100, 1e-20, 1e-8, 1e160])
def test_the_minimum_of_slow_and_fast_tops(size: float) -> None:
    """Slow: mgl sin⁴ = I1 (a + b)² near pi; fast or without weight: cos = a / b or b / a."""
    a, b = size * np.array([1.0, 0.0, 1.0, 1.0]), size * np.array([0.0, 1.0, 2.0, 3.0])
    weightless = rigid.HeavyTop(OTHER.body, mgl=0.0)
    ratio = np.arccos([0.0, 0.0, 0.5, 1.0 / 3.0])
    assert top.effective_minimum(weightless, a=a, b=b) == pytest.approx(ratio, rel=4 * ROUNDOFF)
    lowest = top.effective_minimum(OTHER, a=a, b=b)
    if size > 1.0:
        assert lowest == pytest.approx(ratio, rel=4 * ROUNDOFF)
    else:
        # The next term is smaller by the square of the distance from pi.
        apart = np.sqrt((a + b) / np.sqrt(MGL / I1))
        np.testing.assert_allclose(np.pi - lowest, apart, rtol=2 * apart.max() ** 2, atol=5e-16)


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
        left = top.effective_potential(OTHER, tilt, a=a, b=b).slope
        assert abs(left) < 1e-13 * I1 * rate**2 + 1e-13 * MGL
        assert top.effective_minimum(OTHER, a=a, b=b) == pytest.approx(tilt, rel=1e-13)
        path = top.locus(OTHER, *start, t=np.linspace(0.0, 1000.0, 1001))
        # A double root to the square root of rounding.
        np.testing.assert_allclose(path.theta, tilt, atol=1e-6)
        # D-33: of B = phi' sin² the quadratic has + mgl sin⁴, printed - mgl sin⁴.
        big, s, c = rate * np.sin(tilt) ** 2, np.sin(tilt), np.cos(tilt)
        terms = [I1 * c * big**2, -I1 * b * s**2 * big, MGL * s**4]
        assert abs(sum(terms)) < 1e-14 * max(map(abs, terms))
        assert abs(terms[0] + terms[1] - terms[2]) > 0.1 * abs(terms[2])


def test_steady_precession_is_one_function() -> None:
    """The rates unpack as a pair and have names; both modules export the function."""
    assert top.steady_precession is exact.steady_precession
    assert top.SteadyPrecession is exact.SteadyPrecession
    found = top.steady_precession(TOP, [SIXTY, 1.0], 5.0)
    slow, fast = found
    assert len(found) == 2
    assert found[0] is slow is found.slow
    assert found[1] is fast is found.fast


def test_numbers_of_steady_precession() -> None:
    found = top.steady_precession(TOP, SIXTY, 5.0)
    # D-34: the slow one is the root with the minus sign.
    assert found.slow == pytest.approx(golden_number("heavy.steady60.w3=5.slow"), rel=1e-14)
    assert found.fast == pytest.approx(golden_number("heavy.steady60.w3=5.fast"), rel=1e-14)
    assert (found.slow_approx, found.fast_approx) == pytest.approx((0.4, 5.0))
    assert found.spin_min == pytest.approx(np.sqrt(8.0), rel=1e-15)  # 2 sqrt(mgl I1 cos 60°)/I3
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


def test_at_the_least_spin_the_two_precessions_are_one() -> None:
    """Of random tops, whose least spin is rounded: not sqrt(eps) apart, and never without any."""
    rng = np.random.default_rng(3)
    for _ in range(100):
        across, mgl, tilt = rng.uniform((0.5, 0.1, 0.05), (2.0, 5.0, 1.5))
        body = rigid.Body((across, across, rng.uniform(0.2, 1.9) * across))
        heavy = rigid.HeavyTop(body, mgl=mgl)
        least = top.steady_precession(heavy, tilt, 100.0).spin_min
        bound = top.steady_precession(heavy, tilt, least)
        # Four roundings of the bound and four of the two quotients.
        assert bound.slow == pytest.approx(bound.fast, rel=8.0 * np.finfo(np.float64).eps)


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
    change = slope(run.omega, step)
    torque = top.gravity_torque(OTHER, present(run.attitude)[2])
    np.testing.assert_allclose(free.euler_rhs(OTHER.body, run.omega[2], torque), change, atol=1e-9)


# Refusals

NO_TOP: Any = rigid.FreeBody(TOP.body)
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0)
NOT_SYMMETRIC = "a symmetric top has two exactly equal moments"


test_what_has_no_answer_is_refused = refuses(
    [
        (lambda: top.heavy_constants(NO_TOP, [1, 2, 3], tilted(1)), TypeError, "must be a rigid.H"),
        (lambda: top.heavy_constants(TOP, [1, 2], tilted(1)), "omega: expected shape"),
        (lambda: top.heavy_constants(TOP, [1, 2, 3], [0] * 4), "a zero quaternion is"),
        (lambda: top.precession_spin_rates(HEAVY, 1.0, a=1, b=1), NOT_SYMMETRIC),
        (
            lambda: top.precession_spin_rates(TOP, [1.0, 0.0], a=1.0, b=2.0),
            "tilt[1] = 0.0: is reached only if a = b",
        ),
        (lambda: top.precession_spin_rates(TOP, -1.0, a=1, b=1), "tilt = -1.0: must"),
        (lambda: top.gravity_torque(NO_TOP, tilted(1)), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.gravity_torque(TOP, tilted(1), frame="lab"), "frame = 'lab'"),
        (lambda: top.effective_potential(TOP, 4.0, a=1, b=1), "tilt = 4.0: must lie"),
        (lambda: top.effective_potential(TOP, 1.0, a=np.nan, b=1), "a = nan: must be"),
        (lambda: top.effective_minimum(HEAVY, a=1, b=1), NOT_SYMMETRIC),
        (
            lambda: top.effective_minimum(rigid.HeavyTop(TOP.body, mgl=0.0), a=0.0, b=0.0),
            "the effective potential is constant",
        ),
        (
            lambda: top.turning_angles(TOP, a=1.25, b=2.5, E_prime=-0.9),
            "alpha = -1.8: no motion has this energy and these momenta",
        ),
        (lambda: top.steady_precession(HEAVY, 1.0, 5.0), "a Lagrange top has two"),
        (lambda: top.sleeping_top(TOP, np.inf), "spin = inf: must be finite"),
        (
            lambda: top.sleeping_top(rigid.HeavyTop(TOP.body, mgl=0.0), 1.0),
            "mgl = 0: a top without weight",
        ),
        (lambda: top.upright_f(HEAVY, 1.0, 0.5), "a Lagrange top has two"),
        (lambda: top.spin_down(TOP, 5.0, damping=-1.0), "damping = -1.0: must not be"),
        (lambda: top.f_u(np.nan, a=1, b=1, alpha=1, beta=1), "u = nan: must be finite"),
        (lambda: top.f_roots(a=1, b=1, alpha=1, beta=-1), "beta = -1.0: must not be"),
        (lambda: top.f_roots(a=5, b=0, alpha=1, beta=1), "alpha = 1.0: no motion has"),
        (lambda: top.f_roots(a=1, b=1, alpha=0.5, beta=2), "alpha = 0.5: no motion"),
        (lambda: top.f_roots(a=0, b=0, alpha=0, beta=0), "alpha = 0.0: must be positi"),
        (
            lambda: top.time_of([0.3, 0.6], a=1.25, b=2.5, alpha=1.0, beta=2.0),
            "u[1] = 0.6: must lie between the roots u1 and u2",
        ),
        (lambda: top.u_of(np.inf, a=1.25, b=2.5, alpha=1, beta=2), "t = inf: must be"),
        (lambda: top.classify_locus(HEAVY, [1, 2, 3]), "a Lagrange top has two"),
        (lambda: top.advance(NO_TOP, [1, 2, 3]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.locus(NO_TOP, [1, 2, 3], t=[0.0]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: top.fast_top_approx(TOP, 1.0, 0.0), "spin = 0.0: a fast top needs a"),
        (lambda: top.fast_top_approx(HEAVY, 1.0, 5.0), NOT_SYMMETRIC),
        (lambda: top.fast_top_approx(TOP, 1.0, 5.0, t=1.0), "t: expected shape (m,)"),
    ],
    literal=True,
)
