"""Which rotations of a free body last: principal axes, a local indicator, the separatrix, throws.

The box is that of a lab report, 0.25 m x 0.08 m x 0.01 m, its first axis normal to the largest
face; that report's numbers are compared where they are right, and shown to be wrong where not.
"""

from fractions import Fraction
from itertools import permutations
from typing import Any

import mpmath
import numpy as np
import pytest

import rigid
from physics import ROUNDOFF, Floats, golden_number
from refusals import refuses
from rigid import free

BOX = rigid.Body.box(0.01, 0.08, 0.25)
GAMMAS = (Fraction(561, 689), Fraction(-312, 313), Fraction(63, 65))
PRINTED = np.array([0.81778, -0.99681, 0.96923])
RANDOM = np.random.default_rng(45)


def rates(body: rigid.Body, omega: Any, t: Any) -> Floats:
    return rigid.simulate(rigid.FreeBody(body), omega, t=t, method="exact", record="rates").omega


# Permanent rotation


def test_the_middle_axis_is_unstable_in_all_orders() -> None:
    for order in permutations((1.0, 2.0, 2.5)):
        for axis in (1, 2, 3):
            found = free.permanent_rotation(order, axis, 1.7)
            i1 = order[axis - 1]
            middle = i1 == 2.0
            assert found.kind == ("unstable" if middle else "stable")
            assert found.K + found.squared == 0.0
            # The linear equations of the two other rates: their matrix and its eigenvalues.
            j, k = axis % 3, (axis + 1) % 3
            g = free.gammas(order)
            matrix = np.zeros((2, 2))
            matrix[0, 1], matrix[1, 0] = g[j] * 1.7, g[k] * 1.7
            values = np.linalg.eigvals(matrix)
            np.testing.assert_allclose(np.real(values**2), found.squared, rtol=1e-14)
            assert found.growth == pytest.approx(np.real(values).max(), abs=1e-14)
            assert found.frequency == pytest.approx(np.imag(values).max(), abs=1e-14)


def test_the_numbers_of_the_box() -> None:
    found = [free.permanent_rotation(BOX, axis) for axis in (1, 2, 3)]
    # (Ij - Ii)(Ik - Ii)/(Ij Ik) of each axis i: the square of its frequency, or of its growth rate.
    i = np.asarray(BOX.moments)
    expected = [
        (i[j] - i[k]) * (i[n] - i[k]) / (i[j] * i[n])
        for k, j, n in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    ]
    assert [float(one.K) for one in found] == pytest.approx(expected, rel=1e-14)
    assert found[1].growth == pytest.approx(np.sqrt(-expected[1]), rel=1e-14)
    assert found[0].frequency == pytest.approx(np.sqrt(expected[0]), rel=1e-14)
    assert found[2].frequency == pytest.approx(np.sqrt(expected[2]), rel=1e-14)
    # With the printed factor of the first axis the growth is another.
    assert np.sqrt(PRINTED[0] * PRINTED[2]) == pytest.approx(0.890290351, rel=1e-9)


def test_growth_and_wobble_are_those_of_the_motion() -> None:
    # Along the growing direction w1 / w3 of the linear equations, from 1e-9 on.
    g = free.gammas(BOX)
    ratio = np.sqrt(g[0] / g[2])
    start = np.array([1e-9 * ratio, 1.0, 1e-9])
    t = np.linspace(0.0, 10.0, 11)
    growth = np.diff(np.log(np.abs(rates(BOX, start, t)[:, 0])))
    # At the end the disturbance is 1e-9 exp(8.9): its square is 1e-10.
    np.testing.assert_allclose(growth, 0.888352678, atol=1e-8)
    for axis in (1, 3):
        omega = np.full(3, 1e-5)
        omega[axis - 1] = 1.0
        times = free.crossings(BOX, omega, count=2)[1]
        assert np.pi / np.diff(times)[0] == pytest.approx(
            free.permanent_rotation(BOX, axis).frequency, rel=1e-8
        )


def test_equal_moments_are_neutral() -> None:
    body = (1.0, 1.0, 1.5)
    kinds = [str(free.permanent_rotation(body, axis).kind) for axis in (1, 2, 3)]
    assert kinds == ["neutral", "neutral", "stable"]
    # About axis 1 it drifts away linearly: w2 = sin(k t), k = 1e-3 / 2.
    omega = rates(rigid.Body(body), [1.0, 0.0, 1e-3], [1.0, 300.0])
    np.testing.assert_allclose(omega[:, 1], np.sin(5e-4 * np.array([1.0, 300.0])), rtol=1e-12)
    assert str(free.permanent_rotation((2.0, 2.0, 2.0), 1).kind) == "neutral"
    assert str(free.permanent_rotation(BOX, 1, 0.0).kind) == "neutral"
    # Many bodies and rates at once.
    many = free.permanent_rotation([[1.0, 2.0, 2.5], [1.0, 1.0, 1.5]], 2, [[1.0], [2.0], [0.0]])
    assert np.array(many.kind).tolist() == [["unstable", "neutral"]] * 2 + [["neutral"] * 2]


# Factors of Euler's equations


def test_factors_are_fractions_of_the_box() -> None:
    for found in (free.gammas(BOX), BOX.gammas):
        np.testing.assert_allclose(found, [float(g) for g in GAMMAS], rtol=8 * ROUNDOFF)
    assert sum(GAMMAS) + GAMMAS[0] * GAMMAS[1] * GAMMAS[2] == 0
    assert abs(free.gamma_residual(free.gammas(BOX))) < 8 * ROUNDOFF
    # S-11: the printed first factor, 561/686 for 561/689, belongs to no body.
    assert PRINTED[0] == pytest.approx(561 / 686, abs=5e-6)
    assert free.gamma_residual(PRINTED) == pytest.approx(1.1e-4, rel=0.05)
    np.testing.assert_allclose(free.gammas(BOX)[1:], PRINTED[1:], atol=5e-6)
    # With it the energy of the box changes: at the end of a second, by the power of a wrong law.
    moments, omega = np.array(BOX.moments), np.array([0.5, 0.6, 0.7])
    product = np.array([omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]])
    power = [float((moments * omega * g * product).sum()) for g in (PRINTED, free.gammas(BOX))]
    assert abs(power[0]) > 1e-3 * (moments * omega**2).sum()
    assert abs(power[1]) < 1e-15 * (moments * omega**2).sum()


def test_factors_of_real_bodies_lie_within_one() -> None:
    squares = RANDOM.exponential(size=(100_000, 3)) ** 4
    moments = squares.sum(axis=1, keepdims=True) - squares
    found = free.gammas(moments)
    # A difference of moments is as exact as the largest, a factor as that over the least.
    scale = moments.max(axis=1) / moments.min(axis=1)
    assert (np.abs(found).max(axis=1) <= 1.0 + 4 * ROUNDOFF * scale).all()
    assert (np.abs(free.gamma_residual(found)) / scale).max() < 16 * ROUNDOFF


# The local indicator


def test_the_jacobian_is_the_derivative() -> None:
    omega, factors = np.array([0.3, -0.7, 1.1]), free.gammas(BOX)
    step = 1e-3 * np.eye(3)
    change = [free.euler_rhs(BOX, omega + h) - free.euler_rhs(BOX, omega - h) for h in step]
    found = free.jacobian(factors, omega)
    # The law is of second degree: central differences are exact but for rounding.
    np.testing.assert_allclose(found, np.transpose(change) / 2e-3, atol=1e-12)
    assert np.trace(found) == 0.0
    assert np.linalg.det(found) == pytest.approx(2 * factors.prod() * omega.prod(), rel=1e-13)
    values = np.sort(np.linalg.eigvals(free.jacobian(factors, [0.0, 1.0, 0.0])).real)
    np.testing.assert_allclose(values, [-0.888352678, 0.0, 0.888352678], atol=5e-10)


def test_the_indicator_is_never_negative() -> None:
    # S-14: values "below 0" do not exist, because the trace is zero.
    factors = free.gammas(BOX)
    omega = RANDOM.normal(size=(20_000, 3))
    plain = np.linalg.eigvals(free.jacobian(factors, omega)).real.max(axis=-1)
    found = free.local_stability(factors, omega)
    assert plain.min() > 0.0
    # LAPACK rounds the matrix: a double root then errs by the square root of rounding.
    size = np.linalg.norm(omega, axis=1)
    assert (np.abs(found - plain) <= np.sqrt(16 * ROUNDOFF) * size).all()
    assert (np.abs(found - plain) <= 16 * ROUNDOFF * size).mean() > 0.99
    assert (free.local_stability(factors, np.eye(3)[[0, 2]]) == 0.0).all()
    assert free.local_stability(factors, np.empty((0, 3))).shape == (0,)


def test_the_indicator_is_the_root_of_the_cubic() -> None:
    """By 60 digits; a triple zero is zero, and no square leaves the range of doubles."""
    factors = RANDOM.normal(size=(60, 3)) * 10.0 ** RANDOM.uniform(-3, 0, (60, 3))
    omega = RANDOM.normal(size=(60, 3)) * 10.0 ** RANDOM.uniform(-3, 0, (60, 3))
    found = free.local_stability(factors, omega)
    with mpmath.workdps(60):
        for value, g, w in zip(found, factors.tolist(), omega.tolist(), strict=True):
            (g1, g2, g3), (w1, w2, w3) = map(mpmath.mpf, g), map(mpmath.mpf, w)
            s = g1 * g2 * w3**2 + g2 * g3 * w1**2 + g3 * g1 * w2**2
            cubic = [-2 * g1 * g2 * g3 * w1 * w2 * w3, -s, 0, 1]
            roots = mpmath.polyroots(cubic, 500, 300, asc=True)
            assert value == pytest.approx(float(max(map(mpmath.re, roots))), rel=20 * ROUNDOFF)
    for scale in (1.0, 1e-170, 1e170):
        rows = scale * np.array([[0.0, 1, 1], [1, 1, 0], [0, 0, 0], [0, 1, 0]])
        expected = [0.0, 0.0, 0.0, scale * 0.5**0.5]
        assert free.local_stability([0.5, -1.0, 1.0], rows) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("axis", [1, 3])
def test_the_indicator_is_positive_on_stable_motions(axis: int) -> None:
    # S-15: the rotation lasts for ever, and yet the indicator is positive all along.
    omega = np.full(3, 0.05)
    omega[axis - 1] = 1.0
    assert abs(int(free.circulation(BOX, omega).axis)) == axis
    seen = rates(BOX, omega, np.linspace(0.0, 300.0, 3001))
    assert np.ptp(seen[:, axis - 1]) < 0.02
    assert (free.local_stability(free.gammas(BOX), seen) > 1e-9).mean() > 0.99


# Circulation


def test_the_separatrix_of_the_box() -> None:
    found = free.circulation(BOX, [1.0, 0.1, 0.9])
    assert found.separatrix == pytest.approx(
        golden_number("box.separatrix_wz_over_wx"), rel=8 * ROUNDOFF
    )
    ratio = float(found.separatrix)
    starts = [[1.0, 0.1, ratio * (1 - 1e-9)], [1.0, 0.1, ratio * (1 + 1e-9)]]
    assert free.circulation(BOX, starts).axis.tolist() == [1, 3]
    # S-12: the larger of the two is not the one encircled, and the middle rate has no say.
    assert free.circulation(BOX, [[1.0, 0.1, 1.05], [-1.0, 50.0, 0.9]]).axis.tolist() == [1, -1]
    seen = rates(BOX, [1.0, 0.1, 1.05], np.linspace(0.0, 200.0, 4001))
    assert seen[:, 0].min() > 0.0 > seen[:, 2].min()
    seen = rates(BOX, [1.0, 50.0, 0.9], np.linspace(0.0, 20.0, 4001))
    assert seen[:, 0].min() > 0.0


def test_the_margin_tells_the_axis() -> None:
    squares = RANDOM.uniform(0.1, 2.0, (500, 3))
    moments = squares.sum(axis=1, keepdims=True) - squares
    omega = RANDOM.normal(size=(500, 3))
    found = free.circulation(moments, omega)
    smallest = np.abs(found.axis) - 1 == moments.argmin(axis=1)
    assert ((found.margin > 0.0) == smallest).all()
    # 2 E I2 - L², which has its digits where nothing cancels.
    twice = (moments * omega**2).sum(axis=1)
    naive = twice * np.sort(moments, axis=1)[:, 1] - ((moments * omega) ** 2).sum(axis=1)
    np.testing.assert_allclose(found.margin, naive, atol=1e-13 * np.abs(naive).max())
    assert free.circulation((1.0, 1.0, 1.5), [1.0, 0.0, 0.1]).separatrix == np.inf
    assert free.circulation((1.0, 1.5, 1.5), [1.0, 0.0, 0.1]).separatrix == 0.0
    sphere = free.circulation((1.0, 1.0, 1.0), [1.0, 2.0, 3.0])
    assert sphere.axis == sphere.margin == 0
    assert sphere.separatrix == np.inf


def test_twelve_signs_of_a_cycle() -> None:
    omega = [1.0, 0.3, 0.2]
    times = free.crossings(BOX, omega, count=2)
    assert (times[0] == np.inf).all()
    cycle = np.array([0.0, times[1, 0], times[2, 0], times[1, 1], times[2, 1]])
    # sn and cn vanish in turn, a quarter of a period apart.
    quarter = free.asymmetric_free_top(BOX, omega).period / 4.0
    np.testing.assert_allclose(np.diff(cycle[1:]), quarter, rtol=1e-13)
    middle = rates(BOX, omega, 0.5 * (cycle[:-1] + cycle[1:]))
    signs = [(np.sign(at).tolist(), np.sign(free.euler_rhs(BOX, at)).tolist()) for at in middle]
    assert signs == [
        ([1, 1, 1], [1, -1, 1]),
        ([1, -1, 1], [-1, -1, -1]),
        ([1, -1, -1], [1, 1, -1]),
        ([1, 1, -1], [-1, 1, 1]),
    ]


def test_a_ten_billionth_takes_half_a_minute() -> None:
    # S-17: not "at least a minute".
    start = [1e-10, 1.0, 1e-10]
    times = free.crossings(BOX, start)
    assert times[1, 0] == pytest.approx(26.634, abs=5e-4)
    assert rates(BOX, start, [24.9765, 24.9775])[:, 1] == pytest.approx(0.9, abs=1e-3)
    # By steps too, which a push of a ten-billionth survives.
    run = rigid.simulate(rigid.FreeBody(BOX), start, t=[26.6335, 26.6345], method="rk4", step=0.01)
    assert run.omega[0, 1] > 0.0 > run.omega[1, 1]
    many = free.crossings(rigid.FreeBody(BOX), np.ones((2, 5, 3)), count=3)
    assert many.shape == (2, 5, 3, 3)


# Throws


def test_six_throws() -> None:
    thrown = free.throw_experiment(BOX, [0.05, 0.05, 0.05])
    assert thrown.omega.shape == (6, 601, 3)
    assert thrown.t[-1] == 30.0
    # Clean throws stay for ever, also about the middle axis, with the dots of the report.
    for axis in range(3):
        np.testing.assert_array_equal(thrown.omega[axis], np.tile(np.eye(3)[axis], (601, 1)))
    assert thrown.dots_t.tolist() == list(range(31))
    np.testing.assert_allclose(
        thrown.dots[:3], np.outer([0.0, 0.888352678, 0.0], np.ones(31)), atol=5e-10
    )
    printed = free.local_stability(PRINTED, np.eye(3))
    np.testing.assert_allclose(printed, [0.0, 0.8903, 0.0], atol=5e-5)
    # With noise: the fixed-noise runs of the worked cases.
    for axis, name in enumerate("xyz"):
        end = thrown.omega[3 + axis, -1]
        assert end == pytest.approx(golden_number(f"box.run_{name}.w(30)"), abs=2e-13)
        period, m = golden_number(f"box.run_{name}.period,m")
        found = free.asymmetric_free_top(BOX, thrown.omega[3 + axis, 0])
        assert found.period == pytest.approx(period, rel=1e-13)
        assert found.m == pytest.approx(m, rel=1e-12)
    assert (thrown.dots >= 0.0).all()


def test_noise_comes_from_a_generator() -> None:
    first = free.throw_experiment(BOX, np.random.default_rng(2011), t_end=3.5, samples=8)
    again = free.throw_experiment(BOX, np.random.default_rng(2011), t_end=3.5, samples=8)
    assert first.omega.tobytes() == again.omega.tobytes()
    assert ((first.noise > 0.0) & (first.noise < 0.1)).all()
    assert len(np.unique(first.noise)) == 9
    assert first.dots_t.tolist() == [0.0, 1.0, 2.0, 3.0]
    same = free.throw_experiment(BOX, first.noise, t_end=3.5, samples=8)
    assert same.omega.tobytes() == first.omega.tobytes()


NO_BODY: Any = (1.0, 2.0, 3.0)


test_what_has_no_answer_is_refused = refuses(
    [
        (lambda: free.permanent_rotation((1, 1, 3), 1), "triangle inequality"),
        (lambda: free.permanent_rotation(BOX, 4), "axis = 4: must be one of 1, 2, 3"),
        (lambda: free.permanent_rotation(BOX, 1, np.nan), "rate = nan: must be finite"),
        (lambda: free.gammas((1, 1, 0)), "moments = (1, 1, 0)"),
        (lambda: free.gamma_residual([1.0, np.inf, 0.0]), "factors[1] = inf: must be"),
        (lambda: free.jacobian([1.0, 0.0], [1, 2, 3]), "factors: expected shape (...,"),
        (lambda: free.local_stability(PRINTED, [1, 2]), "omega: expected shape (..., "),
        (lambda: free.circulation(BOX, [1, 2, np.nan]), "omega[2] = nan: must be fini"),
        (lambda: free.crossings(NO_BODY, [1, 2, 3]), TypeError, "must be a rigid.Body"),
        (lambda: free.crossings(BOX, [1, 2, 3], count=0), "count = 0: must be"),
        (lambda: free.throw_experiment(BOX, [1, 2]), "noise: expected shape (3,) or"),
        (lambda: free.throw_experiment(NO_BODY, [1, 2, 3]), TypeError, "must be a rigid.Body"),
        (lambda: free.throw_experiment(BOX, [1, 2, 3], t_end=0.0), "t_end = 0.0: must"),
        (lambda: free.throw_experiment(BOX, [1, 2, 3], samples=1), "samples = 1: must"),
    ],
    literal=True,
)
