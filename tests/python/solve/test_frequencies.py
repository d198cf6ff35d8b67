"""Frequencies of signals and of motions, against sums of lines and closed forms."""

import numpy as np
import pytest

import rigid
from rigid.rotations import quaternion_to_matrix


def test_a_single_line_is_found_to_rounding() -> None:
    t = np.linspace(3.0, 103.0, 1001)
    for frequency in (0.0, 1e-3, 0.7, -5.0, 20.0):
        amplitude = 0.3 - 2.0j
        lines = rigid.frequencies(t, amplitude * np.exp(1j * frequency * t))
        assert lines.frequency[0] == pytest.approx(frequency, rel=1e-14, abs=1e-15)
        assert lines.amplitude[0] == pytest.approx(amplitude, rel=1e-11)


def test_the_error_falls_with_the_fourth_power_of_the_length() -> None:
    # One line is asked for, another is there: the order of the Hann window.
    errors = []
    lengths = np.array([100.0, 200.0, 400.0, 800.0])
    for length in lengths:
        worst = 0.0
        for phase in np.linspace(0.0, 6.0, 13):
            t = np.linspace(0.0, length, 4001)
            z = np.exp(1j * t) + 0.5 * np.exp(1j * (1.5 * t + phase))
            lines = rigid.frequencies(t, z)
            worst = max(worst, abs(lines.frequency[0] - 1.0))
        errors.append(worst)
    order = -np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    assert 3.5 < order < 4.5


def test_the_error_is_covered() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 300.0, 3001)
    covered, sharp = 0, 0
    for _ in range(50):
        frequency = rng.uniform(-5.0, 5.0, 4)
        while np.diff(np.sort(frequency)).min() < 0.3:
            frequency = rng.uniform(-5.0, 5.0, 4)
        amplitude = np.array([1.0, 0.5, 0.2, 0.1]) * np.exp(2j * np.pi * rng.random(4))
        z = np.exp(1j * t[:, np.newaxis] * frequency) @ amplitude
        lines = rigid.frequencies(t, z)
        off = abs(lines.frequency[0] - frequency[0])
        covered += off <= lines.error[0]
        sharp += lines.error[0] < 1e-3 * 2.0 * np.pi / 300.0
    assert covered == 50
    assert sharp == 50


def test_several_lines_are_found_without_each_other() -> None:
    t = np.linspace(0.0, 200.0, 2001)
    frequency = np.array([0.31, 1.7, -0.9, 4.2])
    amplitude = np.array([1.0, 0.5j, -0.25, 0.125])
    z = np.exp(1j * t[:, np.newaxis] * frequency) @ amplitude
    lines = rigid.frequencies(t, z, count=4)
    np.testing.assert_allclose(lines.frequency, frequency, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(lines.amplitude, amplitude, rtol=0.0, atol=1e-10)
    assert (lines.error < 1e-11).all()


def test_a_real_signal_has_positive_lines() -> None:
    t = np.linspace(0.0, 150.0, 3001)
    z = 2.0 * np.cos(0.4 * t + 0.3) + 0.7 * np.sin(2.3 * t)
    lines = rigid.frequencies(t, z, count=2)
    np.testing.assert_allclose(lines.frequency, [0.4, 2.3], rtol=0.0, atol=1e-11)
    expected = [2.0 * np.exp(0.3j), -0.7j]
    np.testing.assert_allclose(lines.amplitude, expected, rtol=0.0, atol=1e-9)


def test_signals_keep_their_axes() -> None:
    t = np.linspace(0.0, 50.0, 501)
    rates = np.array([[0.5, 1.0, 2.0], [3.0, 4.0, 5.0]])
    lines = rigid.frequencies(t, np.exp(1j * rates[..., np.newaxis] * t))
    assert lines.frequency.shape == lines.error.shape == (2, 3, 1)
    np.testing.assert_allclose(lines.frequency[..., 0], rates, rtol=1e-13)


def test_a_free_body_has_the_frequencies_of_its_polhode_and_precession() -> None:
    box, omega = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), np.array([0.3, 0.2, 1.5])
    known = rigid.exact.free_body(box, omega)
    polhode = 2.0 * np.pi / float(known.period)
    t = np.linspace(0.0, 60.0 * float(known.period), 6001)
    run = rigid.simulate(box, omega, t=t, method="exact")
    lines = rigid.frequencies(t, run.omega[:, 0])
    assert lines.frequency[0] == pytest.approx(polhode, rel=1e-9)
    # Axis 3 precesses about the angular momentum; its projection across has this mean rate.
    matrix = quaternion_to_matrix(np.asarray(run.attitude))
    momentum = matrix[0] @ (np.array([1.0, 2.0, 3.0]) * omega)
    up = momentum / np.linalg.norm(momentum)
    across = np.cross(up, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    axis = matrix[:, :, 2]
    turning = axis @ np.cross(across, up) + 1j * (axis @ across)
    found = rigid.frequencies(t, turning, count=3).frequency
    precession = float(known.precession)
    # The lines of the projection are the precession and sums with multiples of the polhode's.
    shifts = (found - precession) / polhode
    np.testing.assert_allclose(shifts, np.round(shifts), atol=1e-8)


def test_a_lagrange_top_has_the_frequencies_of_its_nutation_and_precession() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    omega, attitude = [0.5, 0.25, 3.0], [0.9, 0.3, 0.2, 0.1]
    known = rigid.top.heavy_constants(top, omega, attitude)
    constants = {name: getattr(known, name) for name in ("a", "b", "alpha", "beta")}
    period = float(rigid.top.nutation_period(**constants))
    nutation = 2.0 * np.pi / period
    t = np.linspace(0.0, 80.0 * period, 8001)
    run = rigid.simulate(top, omega, attitude, t=t, method="exact")
    axis = quaternion_to_matrix(np.asarray(run.attitude))[:, :, 2]
    # The mean height is a line too, and so are multiples of the nutation.
    heights = np.sort(rigid.frequencies(t, axis[:, 2], count=4).frequency)
    np.testing.assert_allclose(heights, nutation * np.arange(4), rtol=1e-9, atol=1e-12)
    # The mean rate of the azimuth over whole nutations.
    azimuth = np.unwrap(np.angle(axis[:, 0] + 1j * axis[:, 1]))
    precession = (azimuth[8000] - azimuth[0]) / t[8000]
    lines = rigid.frequencies(t, axis[:, 0] + 1j * axis[:, 1], count=3)
    shifts = (lines.frequency - precession) / nutation
    np.testing.assert_allclose(shifts, np.round(shifts), atol=1e-8)
    assert np.round(shifts[0]) == 0.0


def test_a_regular_motion_keeps_its_frequency_and_a_chaotic_one_does_not() -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    starts = [[0.3, 0.4, 1.0], [0.1, 0.0, 20.0]]
    t = np.linspace(0.0, 400.0, 8001)
    run = rigid.simulate(top, starts, [0.9, 0.3, 0.2, 0.1], t=t, check=False)
    drift = rigid.frequency_drift(run)
    assert drift.drift.shape == (2,)
    assert drift.drift[0] > 1e-2
    assert drift.drift[1] <= max(drift.error[1], 1e-7)
    of_vertical = rigid.frequency_drift(run, of="gamma")
    assert of_vertical.drift[1] < 1e-6


def test_a_free_body_keeps_its_frequency_where_lines_are_as_strong_as_each_other() -> None:
    """About axis 1 the second rate swings, and is two lines: at plus and minus the polhode's rate.

    Rounding chose one of them in each half of the run: the drift was twice the frequency.
    """
    body, rng = rigid.Body((1.0, 2.0, 3.0)), np.random.default_rng(7)
    for _ in range(10):
        along = rng.uniform(0.01, 0.2)
        omega = [along, 1.0, rng.uniform(0.0, 0.4) * along]  # w1² > 3 w3²: about axis 1
        period = float(rigid.exact.free_body(body, omega).period)
        t = np.linspace(0.0, rng.uniform(35.0, 85.0) * period, 4001)
        drift = rigid.frequency_drift(rigid.simulate(body, omega, t=t, check=False))
        assert abs(drift.first.frequency[0]) == pytest.approx(2.0 * np.pi / period, rel=1e-5)
        assert drift.drift <= drift.error < 1e-4 * 2.0 * np.pi / period


def test_halves_of_31_times_share_the_one_in_the_middle() -> None:
    """Each half has the 16 times that a line needs at least; those of 30 have 15."""
    disc, rate = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.5))), 0.5 * 2.0
    for count in (31, 30):
        t = np.linspace(0.0, 40.0, count)
        run = rigid.simulate(disc, [0.3, 0.0, 2.0], t=t, method="exact")
        if count == 30:
            with pytest.raises(ValueError, match="t: 15 times, but lines need at least 16"):
                rigid.frequency_drift(run)
        else:
            drift = rigid.frequency_drift(run)
            for line in (drift.first, drift.second):
                assert line.frequency == pytest.approx([rate], rel=1e-12)


@pytest.mark.parametrize("power", [-1060, -600, 600, 1020])
def test_the_size_of_a_signal_changes_no_digit_of_its_frequency(power: int) -> None:
    t = np.linspace(0.0, 200.0, 2001)
    z = np.exp(0.7j * t) + 0.25 * np.exp(-1.9j * t)
    lines = rigid.frequencies(t, z, count=2)
    # Powers of two change no digit, but near the least numbers, which have fewer digits.
    scaled = np.ldexp(z.real, power) + 1j * np.ldexp(z.imag, power)
    found = rigid.frequencies(t, scaled, count=2)
    if power == -1060:
        np.testing.assert_allclose(found.frequency, [0.7, -1.9], atol=1e-5)
    else:
        np.testing.assert_array_equal(found.frequency, lines.frequency)
        np.testing.assert_array_equal(found.amplitude.real, np.ldexp(lines.amplitude.real, power))


@pytest.mark.parametrize("power", [-1000, 1000])
def test_the_unit_of_time_changes_no_digit_of_a_frequency(power: int) -> None:
    t = np.linspace(0.0, 200.0, 2001)
    z = np.exp(0.7j * t)
    known = rigid.frequencies(t, z)
    found = rigid.frequencies(np.ldexp(t, power), z)
    np.testing.assert_array_equal(found.frequency, np.ldexp(known.frequency, -power))
    np.testing.assert_array_equal(found.error, np.ldexp(known.error, -power))
    with pytest.raises(ValueError, match=r"t: from -1e\+308 to 1e\+308: their span must be"):
        rigid.frequencies(1e308 * np.linspace(-1.0, 1.0, 32), np.ones(32))


@pytest.mark.parametrize("real", [False, True])
def test_a_signal_has_no_more_lines_than_it_has(real: bool) -> None:
    t = np.linspace(0.0, 200.0, 2001)
    z = 2.0 * np.exp(1.0j * t)
    lines = rigid.frequencies(t, z.real if real else z, count=3)
    # A line too many would share the only one: its frequency was off by 1e-8.
    assert lines.frequency[0] == pytest.approx(1.0, abs=1e-14)
    assert abs(lines.amplitude[0]) == pytest.approx(2.0, abs=1e-12)
    assert lines.error[0] < 1e-13
    assert np.isnan(lines.frequency[1:]).all()
    assert np.isnan(lines.error[1:]).all()
    assert (lines.amplitude[1:] == 0.0).all()


def test_rates_that_are_zero_have_no_line() -> None:
    t = np.linspace(0.0, 50.0, 501)
    for signal in (np.zeros(501), np.zeros(501, dtype=complex)):
        lines = rigid.frequencies(t, signal, count=2)
        assert np.isnan(lines.frequency).all()
        assert (lines.amplitude == 0.0).all()


def test_the_error_of_a_real_line_slower_than_the_signal_is_covered() -> None:
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 200.0, 2001)
    for frequency in (1e-4, 1e-3, 0.005, 0.01, 0.03, 0.05, 0.06):
        for phase in 2.0 * np.pi * rng.random(8):
            lines = rigid.frequencies(t, np.cos(frequency * t + phase))
            off = abs(lines.frequency[0] - frequency)
            assert off <= lines.error[0] <= 4.0 * np.pi / 100.0
    # A constant is known to be one: its error is that of rounding, under a square root.
    constant = rigid.frequencies(t, np.full(2001, 3.0))
    assert constant.frequency[0] == 0.0
    assert constant.error[0] < 1e-8


def test_the_error_of_a_real_line_near_the_frequency_of_nyquist_is_covered() -> None:
    """Beside its mirror image a line is not told apart: one at Nyquist's was stated to 1e-13."""
    rng = np.random.default_rng(5)
    for count in (16, 33, 64, 201):
        t = np.linspace(0.0, 10.0, count)
        nyquist = np.pi * (count - 1) / 10.0
        for distance in (0.0, 1e-3, 0.1, 0.5, 1.0, 1.5, 1.9):  # in units of 2 pi / T
            frequency = nyquist - distance * 2.0 * np.pi / 10.0
            for phase in 2.0 * np.pi * rng.random(6):
                lines = rigid.frequencies(t, np.cos(frequency * t + phase))
                assert abs(lines.frequency[0] - frequency) <= lines.error[0]
                assert lines.error[0] < 12.0 * np.pi / 10.0


def test_frequencies_are_at_most_that_of_nyquist() -> None:
    """The samples of a frequency and of one ``2 pi / h`` higher are the same; the lower is told."""
    t = np.linspace(0.0, 10.0, 65)
    nyquist = np.pi * 6.4
    for share in (-1.0, -0.9999, -0.99, 0.99, 0.9999):
        found = rigid.frequencies(t, np.exp(1j * share * nyquist * t)).frequency[0]
        # Nyquist's and its negative are the same line.
        assert abs(found) <= nyquist * (1.0 + 1e-15)
        assert abs(found) == pytest.approx(abs(share) * nyquist, rel=1e-14)
        assert share == -1.0 or found * share > 0.0


@pytest.mark.parametrize("real", [False, True])
@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.1])
def test_the_error_of_lines_in_white_noise_is_covered(size: float, real: bool) -> None:
    """By three standard deviations: 99.7 % of them, and the error is no more than ten."""
    rng = np.random.default_rng(6)
    t, ratios = np.linspace(0.0, 100.0, 501), []
    for _ in range(75):
        frequency, phase = rng.uniform(0.5, 12.0), rng.uniform(0.0, 6.3)
        z = np.exp(1j * (frequency * t + phase))
        z += size * (rng.normal(size=501) + 1j * rng.normal(size=501))
        lines = rigid.frequencies(t, z.real if real else z)
        ratios.append(abs(lines.frequency[0] - frequency) / lines.error[0])
    # Of 75 a quarter of a case: two are four standard deviations of its distribution above.
    assert np.sum(np.array(ratios) > 1.0) <= 2
    # The median of a normal error is 0.67 standard deviations.
    assert np.median(ratios) > 0.067


def test_a_line_of_noise_at_the_frequency_of_nyquist_is_as_small_as_the_noise() -> None:
    """Sine or cosine is zero in all samples there: its amplitude was 1e9, and it came first."""
    rng = np.random.default_rng(8)
    for count in (32, 101):
        t = np.linspace(0.0, 100.0, count)
        for _ in range(20):
            z = np.cos(0.31 * t + rng.uniform(0.0, 6.3)) + 1e-2 * rng.normal(size=count)
            sizes = np.abs(rigid.frequencies(t, z, count=2).amplitude)
            assert sizes[0] == pytest.approx(1.0, abs=0.03)
            assert sizes[1] < 0.03


def test_weak_lines_beside_strong_ones_are_covered() -> None:
    rng = np.random.default_rng(4)
    t = np.linspace(0.0, 200.0, 2001)
    for _ in range(10):
        frequency = rng.uniform(-8.0, 8.0, 4)
        while np.diff(np.sort(frequency)).min() < 8.2 * np.pi / 200.0:
            frequency = rng.uniform(-8.0, 8.0, 4)
        amplitude = 10.0 ** np.array([0.0, -1.0, -2.0, -3.0]) * np.exp(2j * np.pi * rng.random(4))
        lines = rigid.frequencies(t, np.exp(1j * t[:, np.newaxis] * frequency) @ amplitude, count=4)
        off = np.abs(lines.frequency - frequency)
        assert (off <= lines.error).all()
        assert (lines.error < 1e-10).all()
    # The phases of a strong line, up to 2000 rad, round by 5e-13: a line of 1e-11 is more.
    lines = rigid.frequencies(t, np.exp(20j * t) + 1e-11 * np.exp(3j * t), count=3)
    np.testing.assert_allclose(np.abs(lines.amplitude), [1.0, 1e-11, 0.0], rtol=1e-3)


def test_a_body_that_fails_or_rests_leaves_the_others_their_drift() -> None:
    box, t = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), np.linspace(0.0, 100.0, 1001)
    starts = [[0.3, 0.2, 1.5], [1e200, 1e200, 1e200], [0.0, 0.0, 0.0]]
    run = rigid.simulate(box, starts, t=t, method="dop853", check=False, max_steps=10**6)
    assert not np.isfinite(run.omega[1]).all()
    drift = rigid.frequency_drift(run)
    alone = rigid.frequency_drift(rigid.simulate(box, starts[0], t=t, method="dop853", check=False))
    assert drift.drift[0] == alone.drift
    assert np.isnan(drift.drift[1:]).all()
    assert np.isnan(drift.first.frequency[1:]).all()
    apart = rigid.simulate(box, starts[0], t=[t, 2.0 * t], check=False)
    with pytest.raises(ValueError, match="run: all bodies must share their times"):
        rigid.frequency_drift(apart)


def test_a_signal_takes_no_unit() -> None:
    pint = pytest.importorskip("pint")
    t = np.linspace(0.0, 50.0, 501)
    with pytest.raises(ValueError, match="z in revolutions_per_minute: takes numbers without"):
        rigid.frequencies(t, pint.UnitRegistry().Quantity(np.cos(t), "rpm"))


def test_what_an_unresolved_line_leaves_is_not_a_line_of_its_own() -> None:
    """A swing slower than the signal is taken for several lines just above ``4 pi / T``.

    The errors are estimates: of 1600 such lines 3 were off by more, 1.9 times at most; 243 were, by
    up to 30 times, while each part of the swing counted as a line.
    """
    rng, t, of_fast = np.random.default_rng(7), np.linspace(0.0, 1.0, 32), []
    for _ in range(30):
        slow, fast = 4.0 * np.pi * rng.uniform([0.55, 3.2], [0.98, 6.0])
        phases = rng.uniform(0.0, 2.0 * np.pi, 2)
        z = np.cos(slow * t + phases[0]) + 0.1 * np.cos(fast * t + phases[1])
        found = rigid.frequencies(t, z, count=4)
        off = np.abs(found.frequency - np.array([[slow], [fast]])).min(axis=0)
        assert (off <= 2.0 * found.error).all(), (slow, fast, found)
        of_fast.append(found.error[np.abs(found.frequency - fast).argmin()])
    # A line apart from the others keeps a small one.
    assert np.median(of_fast) < 0.01 * 2.0 * np.pi
