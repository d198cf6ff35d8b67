"""Perturbations, limits and rates whose squares are outside the range of doubles."""

import math

import numpy as np
import pytest

import rigid
from physics import present
from rigid import exact

ROUNDOFF = 2.0**-53

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
    result = rigid.stability_map(
        BODY,
        axes={"t_end": [600.0, 601.0]},
        samples=2,
        stable=rigid.no_flip(2),
        start=rigid.Start(omega=(1e-150, 1.0, 0.0)),
        rng=1,
    )
    assert result.share.tolist() == [1.0, 0.0]


#: Lagrange tops that fall: spin, and the rate of the fall sqrt(4 I1 mgl - (I3 spin)^2) / (2 I1).
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)


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
    growth = math.sqrt(4.0 - 1.0) / 2.0
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
    with pytest.raises(ValueError, match=r"omega = 1e-305: must be zero or reach 1e-300 rad/s"):
        exact.free_body(BODY, [1e-305, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"limit = 1e-160: must lie in .* and reach 1e-150"):
        exact.tilt_time(TOP, [0.0, 0.0, 1.0], limit=1e-160)


@pytest.mark.parametrize("distance", [2e-8, 1e-10, 1e-14])
def test_a_pendulum_passes_limits_beside_the_lowest_point(distance: float) -> None:
    """From rest at any tilt a pendulum swings through the lowest point: no limit below pi holds."""
    tilts = [0.5, 1.0, 1.7, 2.4, 3.0]
    angle = math.pi - distance
    result = rigid.stability_map(
        TOP,
        axes={"tilt": tilts},
        samples=1,
        t_end=100.0,
        stable=rigid.tilt_below(angle),
        start=rigid.Start(omega=(0.0, 0.0, 0.0)),
        measure=rigid.time_to_leave(),
        rng=1,
    )
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
    result = rigid.stability_map(
        TOP,
        axes={"tilt": [0.5, 2.0]},
        samples=1,
        t_end=100.0,
        stable=rigid.tilt_below(math.pi),
        start=rigid.Start(omega=(0.0, 0.0, 0.0)),
        rng=1,
    )
    assert result.share.tolist() == [1.0, 1.0]
