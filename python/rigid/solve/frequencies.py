"""The frequencies of a motion as spectral lines, sharper than by a Fourier transform."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, one_of, positive_int, sorted_times
from .._checks.arrays import Floats
from .._checks.quantities import plain
from .._checks.shown import short_repr
from .run import Run

Complex = NDArray[np.complex128]

FEWEST = 16
"""Least number of samples of a signal."""

UNEVEN = 1e-9
"""Largest deviation of a time from even spacing, in steps."""

AS_STRONG = 0.9
"""A line is as strong as another one if its amplitude is at least this share of the other."""

SLIGHTEST = 1e-4
"""Waves with a smaller share than this beside the others have no amplitude."""

LEFT = 4.0
"""Share of a line that remains if its frequency is wrong by the width of the window."""

PASSES = 12
"""Most rounds in which each line is found again without the others."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Lines of the spectrum of a signal, the strongest first; made by :func:`frequencies`.

    Attributes
    ----------
    frequency : ndarray, shape (..., count)
        Angular frequencies (rad/s) up to Nyquist's frequency, ``pi`` over the time between samples;
        of real signals not negative. NaN where the signal has fewer lines than requested: what is
        left of it is rounding.
    amplitude : ndarray of complex, shape (..., count)
        The signal is about the sum of ``amplitude * exp(i frequency t)``; a real signal is its real
        part. Zero where there is no line.
    error : ndarray, shape (..., count)
        Estimated errors of the frequencies (rad/s); NaN where there is no line.
    """

    frequency: Floats
    amplitude: Complex
    error: Floats


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class FrequencyDrift:
    """The main frequency in both halves of a run; made by :func:`frequency_drift`.

    Attributes
    ----------
    first, second : Lines
        The strongest line of each half. Of lines that are about equally strong, as for a swing in a
        plane at plus and minus its frequency, the second half has the line nearest to the line of
        the first half.
    drift : ndarray, shape (...)
        Change of the frequency between the halves (rad/s), in absolute value.
    error : ndarray, shape (...)
        Estimated error of the drift (rad/s).
    """

    first: Lines
    second: Lines
    drift: Floats
    error: Floats


def frequencies(t: ArrayLike, z: ArrayLike, count: int = 1) -> Lines:
    """Find the strongest lines of a signal, by Laskar's analysis of fundamental frequencies.

    The frequency at which the product of the signal with ``exp(-i w t)``, under a Hann window, is
    largest is found by Newton's method from the highest point of a Fourier transform. Its error
    falls like ``1 / T⁴`` with the length of the signal, the error of a transform like ``1 / T``.
    Several lines are found one after another, then each again without the others.

    Parameters
    ----------
    t : array_like, shape (m,)
        Times (s), ascending at equal distances; at least 16.
    z : array_like, shape (..., m)
        Signals, real or complex. ``omega1 + i omega2`` and ``gamma1 + i gamma2`` tell the senses
        of rotation apart.
    count : int
        Number of lines.

    Returns
    -------
    Lines

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: times that are not evenly spaced, a signal of
        another length or with numbers that are not finite, more lines than samples allow.

    Notes
    -----
    ``error`` is the sum of three parts: three times the difference from the frequencies under the
    square of the window, whose error falls like ``1 / T⁶``; three standard deviations from noise;
    and rounding. The noise is taken to be white, of the median power in the transform of what the
    lines leave. Two lines closer than ``8 pi / T`` are not separated, nor is a real line within
    ``4 pi / T`` of zero or of the frequency of Nyquist from its mirror image: its error is as large
    as the rest of the signal makes it, or as that distance. What an error of such a line leaves of
    it may be found as weak lines closer than ``8 pi / T``: their errors reach to it. Of a chaotic
    signal, which has no lines, error and drift are large.

    References
    ----------
    J. Laskar, Icarus 88 (1990) 266 (the method); Physica D 67 (1993) 257
    (doi 10.1016/0167-2789(93)90210-R; drift and diffusion).

    Examples
    --------
    >>> import numpy as np, rigid
    >>> t = np.linspace(0.0, 200.0, 2001)
    >>> lines = rigid.frequencies(t, 2.0 * np.exp(0.7j * t) + 0.5 * np.exp(-1.9j * t), count=2)
    >>> lines.frequency.round(9).tolist()
    [0.7, -1.9]
    >>> np.abs(lines.amplitude).round(6).tolist()
    [2.0, 0.5]
    """
    times = sorted_times("t", t)
    return _strongest(times, _signals(z, len(times)), positive_int("count", count))


def _strongest(
    times: Floats, signals: NDArray[np.inexact], count: int, near: Floats | None = None
) -> Lines:
    """The strongest lines; among equally strong ones the nearest to a given frequency."""
    if len(times) < FEWEST:
        raise ValueError(f"t: {len(times)} times, but lines need at least {FEWEST}")
    if 8 * count > len(times):
        raise ValueError(f"count = {count}: must be at most an eighth of the {len(times)} times")
    with np.errstate(over="ignore"):
        span = times[-1] - times[0]
    if not 0.0 < span < np.inf:
        raise ValueError(f"t: from {times[0]} to {times[-1]}: their span must be positive, finite")
    # By a power of two, which changes no digit, to times of the size of one.
    unit = int(np.frexp(span)[1])
    times = np.ldexp(times, -unit)
    step = (times[-1] - times[0]) / (len(times) - 1)
    uneven = np.abs(times - (times[0] + step * np.arange(len(times)))) > UNEVEN * step
    if uneven.any():
        place = int(np.flatnonzero(uneven)[0])
        value = np.ldexp(times[place], unit)
        raise ValueError(f"t[{place}] = {value}: must be evenly spaced")
    middle = 0.5 * (times[0] + times[-1])
    rows = signals.reshape(-1, len(times))
    wanted = np.full(len(rows), np.nan) if near is None else np.ldexp(near, unit).ravel()
    found = [
        _lines(times - middle, signal, count, one)
        for signal, one in zip(rows, wanted.tolist(), strict=True)
    ]
    shape = (*signals.shape[:-1], count)
    frequency = np.array([line[0] for line in found]).reshape(shape)
    amplitude = np.array([line[1] for line in found], dtype=np.complex128).reshape(shape)
    error = np.array([line[2] for line in found]).reshape(shape)
    turned = np.where(amplitude == 0.0, 0.0, amplitude * np.exp(-1j * frequency * middle))
    with np.errstate(over="ignore"):
        return Lines(np.ldexp(frequency, -unit), turned, np.ldexp(error, -unit))


def frequency_drift(run: Run, of: str = "omega") -> FrequencyDrift:
    """Measure the change of the main frequency between the two halves of a run.

    Regular motions keep their frequencies; in a chaotic motion they wander. The drift is a measure
    of this which, unlike an exponent, also shows slow diffusion.

    Parameters
    ----------
    run : Run
        A run at evenly spaced times, at least 31 of them.
    of : {"omega", "gamma"}
        The signal: ``omega1 + i omega2`` or ``gamma1 + i gamma2``.

    Returns
    -------
    FrequencyDrift
        Of each body, with the axes of the bodies; NaN of one whose signal is zero or not finite.

    Raises
    ------
    ValueError
        As :func:`frequencies`; for ``"gamma"`` of a run without the vertical.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    >>> starts = [[0.3, 0.4, 1.0], [0.1, 0.0, 20.0]]                   # chaotic and regular
    >>> t = np.linspace(0.0, 400.0, 20001)
    >>> run = rigid.simulate(top, starts, [0.9, 0.3, 0.2, 0.1], t=t, check=False)
    >>> slow, fast = rigid.frequency_drift(run).drift
    >>> bool(slow > 1e-2), bool(fast < 1e-6)
    (True, True)
    """
    if not isinstance(run, Run):
        raise TypeError(f"run = {brief(run)}: must be a Run, as rigid.simulate returns")
    one_of("of", of, ("omega", "gamma"))
    states = run.omega if of == "omega" else run.gamma
    if states is None:
        raise ValueError(f"of = {of!r}: the run has no {of}")
    if run.t.ndim != 1:
        raise ValueError("run: all bodies must share their times; give t of shape (m,) to simulate")
    signal = states[..., 0] + 1j * states[..., 1]
    # A body that failed is omitted: as one at rest, it has no line.
    signal = np.where(np.isfinite(signal).all(axis=-1, keepdims=True), signal, 0.0)
    half = (len(run.t) + 1) // 2
    first = frequencies(run.t[:half], signal[..., :half])
    second = _strongest(run.t[-half:], signal[..., -half:], 1, first.frequency[..., 0])
    return FrequencyDrift(
        first=first,
        second=second,
        drift=np.abs(second.frequency - first.frequency)[..., 0],
        error=(first.error + second.error)[..., 0],
    )


def _signals(z: ArrayLike, length: int) -> NDArray[np.inexact]:
    z = plain("z", z)
    try:
        array = np.asarray(z)
    except ValueError:
        raise ValueError(f"z = {brief(z)}: must be an array of numbers") from None
    if array.dtype.kind not in "iufc":
        raise ValueError(f"z = {brief(z)}: must be an array of numbers")
    with np.errstate(over="ignore"):
        array = array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)
    if array.ndim == 0 or array.shape[-1] != length:
        raise ValueError(f"z: expected shape (..., {length}), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("z: must be finite")
    return array


def _lines(
    t: Floats, signal: NDArray[np.inexact], count: int, near: float
) -> tuple[Floats, Complex, Floats]:
    """Frequencies, amplitudes in the middle of the signal, and errors; ``near`` may be NaN."""
    # By a power of two, so that no square leaves the range of doubles.
    largest = max(float(np.abs(signal.real).max()), float(np.abs(signal.imag).max()))
    size = int(np.frexp(largest)[1])
    signal = _times_two_to(signal, -size)
    hann = 1.0 + np.cos(2.0 * np.pi * t / (t[-1] - t[0]))
    analysis = _Analysis(t, signal, hann)
    frequency, amplitude = analysis.lines(count, near)
    sharper = _Analysis(t, signal, hann**2)
    other, _ = sharper.refined(frequency, sharper.amplitudes(frequency))
    error = analysis.errors(frequency, amplitude, 3.0 * np.abs(other - frequency))
    missing = count - len(frequency)
    return (
        np.append(frequency, np.full(missing, np.nan)),
        _times_two_to(np.append(amplitude, np.zeros(missing)), size),
        np.append(error, np.full(missing, np.nan)),
    )


def _times_two_to(signal: NDArray[np.inexact], power: int) -> Any:
    if signal.dtype.kind != "c":
        return np.ldexp(signal, power)
    with np.errstate(over="ignore"):
        return np.ldexp(signal.real, power) + 1j * np.ldexp(signal.imag, power)


class _Analysis:
    """A signal at times around zero, under a window."""

    def __init__(self, t: Floats, signal: NDArray[np.inexact], window: Floats) -> None:
        self.t, self.signal, self.window = t, signal, window / window.sum()
        self.real = signal.dtype.kind != "c"
        self.step, self.width = t[1] - t[0], 2.0 * np.pi / (t[-1] - t[0])
        self.nyquist = np.pi / self.step

    def lines(self, count: int, near: float) -> tuple[Floats, Complex]:
        """The strongest lines, one after another, each again without the others.

        At most ``count``: none is looked for in what rounding has left of the signal.
        """
        frequency, amplitude = np.empty(0), np.empty(0, dtype=np.complex128)
        for _ in range(count):
            rest = self.signal - self._sum(frequency, amplitude)
            if not np.abs(rest).max() > self._rounding(frequency, amplitude):
                break
            frequency = np.append(frequency, self._near(rest, self._highest(rest, near)))
            amplitude = self.amplitudes(frequency)
            frequency, amplitude = self.refined(frequency, amplitude)
        order = np.argsort(-np.abs(amplitude), kind="stable")
        return frequency[order], amplitude[order]

    def errors(self, frequency: Floats, amplitude: Complex, apart: Floats) -> Floats:
        """Errors of lines: the change under another window, and the part it does not show."""
        if not len(frequency):
            return np.empty(0)
        # The phases of a strong line round, and a weak line is found in the rest.
        sizes, epsilon = np.abs(amplitude), np.finfo(float).eps
        span, most = self.t[-1] - self.t[0], np.abs(frequency).max()
        weak = sizes.max() / (sizes * np.sqrt(len(self.t)))
        error: Floats = apart + 8.0 * epsilon * (
            np.abs(frequency) + 1.0 / span + (most + 1.0 / span) * weak
        )
        rest = self.signal - self._sum(frequency, amplitude)
        error += 3.0 * self._noise(rest) / (0.5 * sizes if self.real else sizes)
        if self.real:
            # cos(w t) is 1 - (w t)²/2 near zero: the rest of the signal bounds w.
            share = np.sqrt((np.abs(rest).max() + epsilon * sizes.max()) / sizes)
            share = np.where(frequency < 0.5 * self.nyquist, np.minimum(1.0, share), 1.0)
            near = np.array([not self._has_mirror(one, 2.1) for one in frequency])
            error += np.where(near, 2.0 * self.width * share, 0.0)
        # What an error of a line leaves of it is found again as weak lines close to it.
        for k in range(1, len(frequency)):
            distance = np.abs(frequency[:k] - frequency[k])
            left = LEFT * sizes[:k] * np.minimum(1.0, error[:k] / self.width)
            of_stronger = (distance < 4.0 * self.width) & (sizes[k] < left)
            error[k] += np.where(of_stronger, distance + error[:k], 0.0).max()
        return error

    def _noise(self, rest: NDArray[np.inexact]) -> float:
        """Standard deviation of the frequency of a wave of amplitude one, with the rest as noise.

        White noise n moves the maximum by the imaginary part of ``sum n t`` over ``sum t²``, both
        under the window. Its power in a transform has an exponential distribution, with a median of
        ln 2 of the mean, which lines that are left do not change.
        """
        power = np.median(np.abs(np.fft.fft(rest * self.window)) ** 2) / np.log(2.0)
        spread = ((self.window * self.t) ** 2).sum() / (self.window**2).sum()
        return float(np.sqrt(0.5 * power * spread) / (self.window * self.t**2).sum())

    def _rounding(self, frequency: Floats, amplitude: Complex) -> float:
        """Size of the rounding errors in a signal, most of it from phases."""
        phase = float(np.abs(frequency * self.t[-1]).max(initial=0.0))
        return float(16.0 * np.finfo(float).eps * (1.0 + phase) * np.abs(amplitude).sum())

    def refined(self, frequency: Floats, amplitude: Complex) -> tuple[Floats, Complex]:
        """Lines from nearby values."""
        frequency = frequency.copy()
        for _ in range(PASSES):
            before = frequency.copy()
            for k in range(len(frequency)):
                others = np.arange(len(frequency)) != k
                rest = self.signal - self._sum(frequency[others], amplitude[others])
                if self.real and self._has_mirror(frequency[k]):
                    # A real line is half a complex one and half its mirror image.
                    mirror = 0.5 * np.conj(amplitude[k]) * np.exp(-1j * frequency[k] * self.t)
                    frequency[k] = self._near(rest - mirror, frequency[k])
                else:
                    frequency[k] = self._near(rest, frequency[k])
                amplitude = self.amplitudes(frequency)
            least = 1e-15 * np.abs(frequency).max(initial=0.0)
            if (np.abs(frequency - before) <= least).all():
                break
        return frequency, amplitude

    def amplitudes(self, frequency: Floats) -> Complex:
        """Amplitudes of lines by least squares under the window."""
        root = np.sqrt(self.window)[:, np.newaxis]
        waves = np.exp(1j * frequency * self.t[:, np.newaxis])
        if not self.real:
            found = np.linalg.lstsq(waves * root, self.signal * root[:, 0], rcond=None)[0]
            return np.asarray(found, dtype=np.complex128)
        # Re(a exp(i w t)): a cosine and a sine each.
        both = np.concatenate([waves.real, -waves.imag], axis=1)
        # At zero and at Nyquist's one of the two is zero: its amplitude would be anything.
        found = np.linalg.lstsq(both * root, self.signal * root[:, 0], rcond=SLIGHTEST)[0]
        cosine, sine = np.split(np.asarray(found), 2)
        return np.asarray(cosine + 1j * sine, dtype=np.complex128)

    def _sum(self, frequency: Floats, amplitude: Complex) -> NDArray[np.inexact]:
        waves: Complex = np.exp(1j * frequency * self.t[:, np.newaxis]) @ amplitude
        return waves.real if self.real else waves

    def _has_mirror(self, frequency: float, widths: float = 2.0) -> bool:
        """Whether a real line is separated from its images at zero and at Nyquist's frequency."""
        return bool(widths * self.width < abs(frequency) < self.nyquist - widths * self.width)

    def _highest(self, signal: NDArray[np.inexact], near: float) -> float:
        """The frequency of the highest point of the transform, or of the nearest similar point."""
        size = 4 * len(signal)
        power = np.abs(np.fft.fft(signal * self.window, size))
        grid = 2.0 * np.pi * np.fft.fftfreq(size, self.step)
        if self.real:
            power = np.where(grid < 0.0, 0.0, power)
        if not np.isnan(near):
            as_high = power >= AS_STRONG * power.max()
            return float(grid[np.argmin(np.where(as_high, np.abs(grid - near), np.inf))])
        return float(grid[np.argmax(power)])

    def _near(self, signal: NDArray[np.inexact], frequency: float) -> float:
        """The maximum of the transform near a frequency, by Newton's method."""
        weighted = signal * self.window
        begin = frequency
        for _ in range(50):
            wave = weighted * np.exp(-1j * frequency * self.t)
            value, first, second = wave.sum(), (wave * self.t).sum(), (wave * self.t**2).sum()
            # Half of the derivatives of the squared absolute value.
            slope = (np.conj(value) * (-1j) * first).real
            curvature = abs(first) ** 2 - (np.conj(value) * second).real
            if not curvature < 0.0:
                break
            change = float(np.clip(-slope / curvature, -0.25 * self.width, 0.25 * self.width))
            frequency += change
            if abs(change) <= 1e-16 * abs(frequency) or abs(frequency - begin) > self.width:
                break
        return self._in_band(frequency)

    def _in_band(self, frequency: float) -> float:
        """The frequency up to Nyquist's frequency whose wave has the same samples."""
        if abs(frequency) <= self.nyquist:
            return frequency
        within = frequency - np.copysign(2.0 * self.nyquist, frequency)
        return float(abs(within) if self.real else within)
