"""The box of a lab report: 0.25 m x 0.08 m x 0.01 m, thrown about each of its axes at 1 rad/s.

Axis 1 (the report's x) is normal to the largest face, axis 2 (y) is the middle one, axis 3 (z) is
along the longest side. The reference numbers come from a Taylor series in 40-digit arithmetic.
"""

from fractions import Fraction
from itertools import pairwise, permutations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import rigid
from physics import METHODS, ROUNDOFF, Floats, golden_number, present, rotation_matrix

BOX = rigid.Body.box(0.01, 0.08, 0.25)
SCENE = rigid.FreeBody(BOX)
EXACT_MOMENTS = (Fraction(689, 120000), Fraction(626, 120000), Fraction(65, 120000))
EXACT_GAMMAS = (Fraction(561, 689), Fraction(-312, 313), Fraction(63, 65))

#: The error of 30 s, and a step at which each method stays below its tolerance.
STEP = 2.5e-3

#: Error after a throw with that step, by the order.
ERRORS = {2: 3e-5}
SMALL = 2e-11


def rates(
    start: list[float], t: list[float] | Floats, method: str = "rk4", step: float = 0.01
) -> Floats:
    return rigid.simulate(SCENE, start, t=t, method=method, step=step, record="rates").omega


def test_moments_are_689_626_65() -> None:
    # A side in binary is half a roundoff off, its square one; squares, sums, mass/12: three more.
    assert [12e4 * moment for moment in BOX.moments] == pytest.approx(
        [689, 626, 65], rel=5 * ROUNDOFF
    )


def test_gammas_are_exact_fractions() -> None:
    for k, (gamma, exact) in enumerate(zip(BOX.gammas, EXACT_GAMMAS, strict=True)):
        a, b = EXACT_MOMENTS[(k + 1) % 3], EXACT_MOMENTS[(k + 2) % 3]
        # Five roundoffs of each moment, enlarged where nearly equal ones are subtracted.
        relative = 5 * ROUNDOFF * float((a + b) / abs(a - b) + 1) + 2 * ROUNDOFF
        assert gamma == pytest.approx(float(exact), rel=relative)


def test_sum_and_product_of_the_gammas_cancel() -> None:
    g1, g2, g3 = EXACT_GAMMAS
    assert g1 + g2 + g3 + g1 * g2 * g3 == 0
    for moments in permutations((1.0, 2.0, 2.5)):
        g = rigid.Body(moments).gammas
        assert sum(g) + np.prod(g) == pytest.approx(0.0, abs=4 * ROUNDOFF)
    # The factor 0.81778 printed in the report belongs to no body.
    assert abs(0.81778 - 0.99681 + 0.96923 - 0.81778 * 0.99681 * 0.96923) > 1e-5


def test_sides_belong_to_the_axes() -> None:
    for sides in permutations((0.25, 0.08, 0.01)):
        body = rigid.Body.box(*sides, mass=0.3)
        a, b, c = sides
        expected = [0.3 / 12 * (x * x + y * y) for x, y in ((b, c), (a, c), (a, b))]
        assert body.moments == pytest.approx(expected, rel=5 * ROUNDOFF)
        assert body.sides == sides
        assert body.mass == 0.3
    assert rigid.Body.box(1.0, 2.0, 2.0).symmetry_axis == 1
    assert rigid.Body.box(2.0, 1.0, 2.0).symmetry_axis == 2
    assert rigid.Body.box(2.0, 2.0, 1.0).symmetry_axis == 3
    assert rigid.Body.box(1.0, 2.0, 3.0).symmetry_axis is None


def crossing(start: list[float], component: int, low: float, high: float, method: str) -> float:
    """When that component vanishes between two times, by bisection of the run itself."""
    sign = np.sign(rates(start, [low], method)[0, component])
    for _ in range(40):
        middle = 0.5 * (low + high)
        if np.sign(rates(start, [middle], method)[0, component]) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def crossings(start: list[float], method: str, until: float) -> list[tuple[float, int]]:
    t = np.linspace(0.0, until, 401)
    omega = rates(start, t, method)
    found = [
        (crossing(start, k, t[i], t[i + 1], method), k)
        for k in range(3)
        for i in np.flatnonzero(np.diff(np.sign(omega[:, k])))
    ]
    return sorted(found)


def quarter_period(start: list[float]) -> float:
    """``K(m)/p`` of a motion that circulates about axis 1 (Landau & Lifshitz §37)."""
    i1, i2, i3 = (float(moment) for moment in EXACT_MOMENTS)
    w1, w2, w3 = start
    above = i1 * (i1 - i3) * w1**2 + i2 * (i2 - i3) * w2**2  # L^2 - 2 E I3
    below = i2 * (i1 - i2) * w2**2 + i3 * (i1 - i3) * w3**2  # 2 E I1 - L^2
    m = (i2 - i3) * below / ((i1 - i2) * above)
    return float(ellipk(m) / np.sqrt((i1 - i2) * above / (i1 * i2 * i3)))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_signs_and_slopes_of_one_cycle(method: rigid.Method) -> None:
    """Between its four zeros a cycle about axis 1 has these signs of omega and its derivative."""
    start = [1.0, 0.3, 0.2]
    found = crossings(start, method.name, 12.0)[:4]
    assert [component for _, component in found] == [1, 2, 1, 2]
    times = [0.0, *(time for time, _ in found)]
    cycle = []
    for before, after in pairwise(times):
        middle = 0.5 * (before + after)
        omega = rates(start, [middle - 1e-3, middle, middle + 1e-3], method.name)
        cycle.append((np.sign(omega[1]).tolist(), np.sign(omega[2] - omega[0]).tolist()))
    assert cycle == [
        ([1, 1, 1], [1, -1, 1]),
        ([1, -1, 1], [-1, -1, -1]),
        ([1, -1, -1], [1, 1, -1]),
        ([1, 1, -1], [-1, 1, 1]),
    ]
    # sn and cn vanish in turn, a quarter of a period apart. Steps of 0.01 err by 1e-9 and 1e-4.
    tolerance = 3e-4 if method.order == 2 else 1e-8
    assert np.diff(times[1:]) == pytest.approx(quarter_period(start), rel=tolerance)


def test_a_push_of_1e_minus_10_turns_the_box_over_in_26_634_s() -> None:
    start = [1e-10, 1.0, 1e-10]
    # The printed time is right to half its last digit, and so is the time of leaving.
    before, after = rates(start, [26.6335, 26.6345])[:, 1]
    assert before > 0.0 > after
    before, after = rates(start, [24.9765, 24.9775])[:, 1]
    assert before > 0.9 > after
    omega = rates(start, np.linspace(0.0, 24.0, 241))
    assert np.all(omega[:, 1] > 0.98)
    # Later times are not asked for: the next pass of the axis is decided by differences of 1e-20.


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_fixed_noise_of_one_twentieth(method: rigid.Method, axis: str) -> None:
    """All components 0.05 rad/s off a turn about one axis: where the box is after 30 s."""
    start = [0.05, 0.05, 0.05]
    start["xyz".index(axis)] = 1.05
    step, tolerance = STEP, ERRORS.get(method.order, SMALL)
    run = rigid.simulate(SCENE, start, t=30.0, method=method.name, step=step)
    # The middle axis enlarges an error some 20 times more than the others.
    assert run.omega[0] == pytest.approx(golden_number(f"box.run_{axis}.w(30)"), abs=tolerance)
    if axis == "y":
        matrix = rotation_matrix(present(run.attitude)[0]).ravel()
        assert matrix == pytest.approx(golden_number("box.run_y.R(30)"), abs=tolerance)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_rk4_agrees_with_the_solver_of_the_report(axis: str) -> None:
    """The pair of order 4(5) that ode45 is, on Euler's equations: what is left is its tolerance."""
    start = [0.05, 0.05, 0.05]
    start["xyz".index(axis)] = 1.05
    t = np.linspace(0.0, 60.0, 61)
    stepped = rates(start, t, step=5e-3)  # 1e-10 from the closed form
    off = []
    for tolerance in (1e-6, 1e-9):
        found = solve_ivp(
            lambda _, omega: rigid.free.euler_rhs(BOX, omega),
            (0.0, 60.0),
            start,
            method="RK45",
            t_eval=t,
            rtol=tolerance,
            atol=tolerance,
        )
        off.append(np.abs(found.y.T - stepped).max())
    # A tolerance a step, 600 steps; about the middle axis errors grow several times.
    assert off[1] < 5e-6
    assert off[0] > 300.0 * off[1]


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_fixed_noise_returns_after_a_period(axis: str) -> None:
    start = [0.05, 0.05, 0.05]
    start["xyz".index(axis)] = 1.05
    period, modulus = golden_number(f"box.run_{axis}.period,m")
    assert 0.0 < modulus < 1.0
    (end,) = rates(start, [period], step=2e-3)
    assert end == pytest.approx(start, abs=1e-11)
    (half,) = rates(start, [0.5 * period], step=2e-3)
    assert np.abs(half - start).max() > 0.09


def changes_sign(start: list[float]) -> list[bool]:
    omega = rates(start, np.linspace(0.0, 200.0, 4001), step=0.01)
    return [
        bool(low < 0.0 < high)
        for low, high in zip(omega.min(axis=0), omega.max(axis=0), strict=True)
    ]


def test_separatrix_parts_the_starts_that_keep_a_sign() -> None:
    i1, i2, i3 = EXACT_MOMENTS
    ratio = float(np.sqrt(float(i1 * (i1 - i2) / (i3 * (i2 - i3)))))
    assert ratio == pytest.approx(golden_number("box.separatrix_wz_over_wx"), rel=4 * ROUNDOFF)
    assert changes_sign([1.0, 0.1, ratio * (1 - 1e-9)]) == [False, True, True]
    assert changes_sign([1.0, 0.1, ratio * (1 + 1e-9)]) == [True, True, False]
    # The report's rule, |omega_z| > |omega_x|, is not enough; and omega_y has no say.
    assert changes_sign([1.0, 0.1, 1.05]) == [False, True, True]
    assert changes_sign([1.0, 5.0, 0.9]) == [False, True, True]
    assert changes_sign([1.0, 50.0, 0.9]) == [False, True, True]


def test_turns_about_the_largest_and_smallest_moment_stay() -> None:
    for start, kept in (([1.05, 0.05, 0.05], 0), ([0.05, 0.05, 1.05], 2)):
        omega = rates(start, np.linspace(0.0, 300.0, 3001))
        assert np.ptp(omega[:, kept]) < 0.02
    assert changes_sign([0.05, 1.05, 0.05])[1]
