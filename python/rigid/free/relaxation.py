"""Relaxation of a tumbling body by internal dissipation, averaged over its fast motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, sorted_times
from .._checks.arrays import Floats, vectors
from .._checks.overflow import refuses_overflow
from .._checks.shown import short_repr
from .._energy_loss import mean_loss
from ..model.body_like import BodyLike, moments_of
from ..model.forces import EnergySink
from .tumbling import SpinState, momentum_near, spin_periods

SEPARATRIX, END = 36.0, -80.0
"""Values of ``ln(x / (1 - x))`` that mean, to rounding, the separatrix and rotation about an axis.
Here ``x`` is the share of the way from the energy of the axis to the separatrix."""

PANEL = 0.5
"""Width of the panels of the quadrature over ``ln(x / (1 - x))``."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)

NEWTON = 8
"""Steps of Newton's method for the place at a time; the time is nearly linear in a panel."""


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Relaxation:
    """The averaged motion of a body that loses energy and keeps its angular momentum.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    states : SpinState
        Mode, both periods, energy and one angular velocity at each time; arrays of leading axis m.
    separatrix : float
        Time (s) at which the body passes from the long-axis mode to the short-axis mode; 0 if the
        body begins in the short-axis mode, inf for a prolate body, which has no short-axis mode.
    """

    t: Floats
    states: SpinState
    separatrix: float


@refuses_overflow
def relaxation(body: BodyLike, omega: ArrayLike, t: ArrayLike, sink: EnergySink) -> Relaxation:
    """Spin states of a free body with an energy sink at any times, averaged over its fast motion.

    The energy falls by ``dE/dt = -omega'·P omega'`` at constant L. The mean over a period of the
    rates is a closed form of elliptic integrals, and the time is an integral over the energy. So a
    thousand million years cost as much as a minute. :func:`rigid.simulate` with ``dissipation=``
    follows each nutation; the two differ by the loss of energy in a period.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        One body, or its principal moments (kg m²) in any order.
    omega : array_like, shape (3,)
        Angular velocity in the body at ``t = 0`` (rad/s).
    t : array_like, shape (m,)
        Times (s), ascending, not negative.
    sink : EnergySink
        The dissipation; :func:`sink_of_damping` makes one from a time of damping.

    Returns
    -------
    Relaxation

    Raises
    ------
    TypeError
        If ``sink`` is no :class:`rigid.EnergySink`.
    ValueError
        If the body is a sphere or rotates about a principal axis, which the mean does not move; if
        nothing is dissipated, a time is negative, or a value is not finite.

    Examples
    --------
    A body like Explorer 1, with the time at which it passes the separatrix:

    >>> import rigid
    >>> sink = rigid.EnergySink(0.01)
    >>> found = rigid.free.relaxation((1.0, 4.0, 4.2), [2.0, 0.01, 0.0], [0.0, 1e4, 1e6], sink)
    >>> found.states.mode.tolist(), found.states.energy.round(4).tolist()
    (['LAM', 'SAM', 'SAM'], [4.1987, 1.0, 1.0])
    >>> round(found.separatrix)
    3546
    """
    moments, rates = moments_of(body), vectors("omega", omega)
    if moments.shape != (3,) or rates.shape != (3,):
        raise ValueError(
            f"body, omega of shape {moments.shape}, {rates.shape}: one body at a time; loop over "
            "bodies"
        )
    if not isinstance(sink, EnergySink):
        raise TypeError(f"sink = {brief(sink)}: must be a rigid.EnergySink")
    coefficient = np.array(sink.coefficient)
    if coefficient.shape != (3,):
        raise ValueError(f"sink = {brief(sink)}: must be the sink of one body; loop over bodies")
    times = sorted_times("t", t)
    if times.size and times[0] < 0.0:
        raise ValueError(f"t[0] = {times[0]}: must not be negative")
    order = np.argsort(moments, kind="stable")
    square = float((moments * rates) @ (moments * rates))
    start = _start(moments[order], rates[order])
    if start is None:
        raise ValueError(
            f"omega = {rates.tolist()}: does not nutate, or is on the separatrix; turn it a "
            "little, because the mean motion stays there"
        )
    encircled, place = start

    def leg(encircled: int, first: float, last: float) -> _Leg:
        axes = order[[encircled, 1, 2 - encircled]]
        made = _Leg(moments[axes], coefficient[axes], square, first, last)
        if not np.isfinite(made.end):
            raise ValueError(f"sink = {brief(sink)}: drains nothing; give each axis a coefficient")
        return made

    def momenta(encircled: int, places: Floats) -> Floats:
        return momentum_near(order, encircled, 0.5 * places)

    if encircled == 2:
        separatrix = 0.0
        unit = momenta(2, leg(2, place, END).places(times))
    elif moments[order[1]] == moments[order[2]]:
        separatrix = np.inf
        unit = momenta(0, leg(0, place, -END).places(times))
    else:
        first = leg(0, place, SEPARATRIX)
        separatrix = first.end
        since = np.maximum(times - separatrix, 0.0)
        unit = np.where(
            (times > separatrix)[:, np.newaxis],
            momenta(2, leg(2, SEPARATRIX, END).places(since)),
            momenta(0, first.places(times)),
        )
    states = spin_periods(moments, np.sqrt(square) * unit / moments)
    return Relaxation(t=times, states=states, separatrix=separatrix)


def _start(moments: Floats, rates: Floats) -> tuple[int, float] | None:
    """The place of the encircled axis among ascending moments, and ``ln(x / (1 - x))``.

    None for a rotation about a principal axis, and on the separatrix.
    """
    i1, i2, i3 = moments
    w1, w2, w3 = rates * rates
    # Their difference is the distance in energy from the separatrix.
    small, large = i1 * (i2 - i1) * w1, i3 * (i3 - i2) * w3
    if small > large:
        encircled, rest = 0, i1 * (small - large)
        share = i2 * (i2 * (i2 - i1) * w2 + i3 * (i3 - i1) * w3)
    else:
        encircled, rest = 2, i3 * (large - small)
        share = i2 * (i2 * (i3 - i2) * w2 + i1 * (i3 - i1) * w1)
    if not (rest > 0.0 and share > 0.0):
        return None
    return encircled, float(np.log(share / rest))


class _Leg:
    """The motion in one mode: time as an integral over the place ``ln(x / (1 - x))``.

    ``moments`` and ``sink`` belong to the encircled axis, the middle one and the third.
    """

    def __init__(
        self, moments: Floats, sink: Floats, square: float, first: float, last: float
    ) -> None:
        self.moments, self.sink, self.square = moments, sink, square
        # A start beyond the last place, which rounding does not tell from it, stays where it is.
        is_ahead = (last > first) == (last > END)
        count = int(np.ceil(abs(last - first) / PANEL)) if is_ahead else 0
        self.borders = np.linspace(first, last if is_ahead else first, count + 1)
        passed = self.time(self.borders[:-1], self.borders[1:])
        self.times = np.concatenate([[0.0], np.cumsum(passed)])
        self.end = float(self.times[-1])

    def places(self, since: Floats) -> Floats:
        """Places at times since the start of the leg; the last place lies after its end."""
        panel = np.clip(np.searchsorted(self.times, since, side="right") - 1, 0, None)
        panel = np.minimum(panel, max(len(self.times) - 2, 0))
        begin, after = self.borders[panel], np.minimum(since, self.end) - self.times[panel]
        end = self.borders[np.minimum(panel + 1, len(self.borders) - 1)]
        low, high = np.minimum(begin, end), np.maximum(begin, end)
        sign = np.sign(self.borders[-1] - self.borders[0])
        place = begin
        for _ in range(NEWTON):
            missing = after - self.time(begin, place)
            place = np.clip(place + sign * missing / self.slowness(place), low, high)
        return place

    def time(self, begin: Floats, end: Floats) -> Floats:
        """Time between places of one panel each."""
        half = 0.5 * (end - begin)[:, np.newaxis]
        values = self.slowness(begin[:, np.newaxis] + half * (1.0 + NODES))
        passed: Floats = (np.abs(half) * WEIGHTS * values).sum(axis=1)
        return passed

    def slowness(self, place: Floats) -> Floats:
        """The derivative of the time, without its sign."""
        i1, i2, _ = self.moments
        x, rest = 1.0 / (1.0 + np.exp(-place)), 1.0 / (1.0 + np.exp(place))
        power = mean_loss(self.moments, self.sink, self.square, x, rest)
        whole = 0.5 * self.square * abs(i2 - i1) / (i1 * i2)
        with np.errstate(divide="ignore"):
            slow: Floats = whole * x * rest / power
        return slow


def damping_time(
    radius: float,
    rate: float,
    *,
    density: float,
    rigidity: float,
    quality: float,
    shape: float = 0.03,
) -> float:
    """Time in which inelastic dissipation damps the nutation of an asteroid.

    ``mu Q / (rho K3² r² omega³)``: J. A. Burns and V. S. Safronov, *Mon. Not. R. Astron. Soc.* 165
    (1973) 403. A. W. Harris, *Icarus* 107 (1994) 209, takes ``mu Q = 5e11 Pa``, 2000 kg/m³ and
    0.03, so that a period of 17 h of a body of 1 km is damped in 1e9 years. The product ``mu Q`` is
    known to a factor of ten or a hundred only: M. Efroimsky, *Planet. Space Sci.* 49 (2001) 937.

    Parameters
    ----------
    radius : float
        Mean radius r (m), positive.
    rate : float
        Rate of rotation omega (rad/s), positive.
    density, rigidity, quality : float
        Density rho (kg/m³), rigidity mu (Pa) and quality factor Q, positive.
    shape : float, optional
        ``K3²``, from about 0.01 of a body nearly a sphere to 0.1 of a long one.

    Returns
    -------
    float
        The time (s).

    Raises
    ------
    ValueError
        If an argument is not positive and finite.

    Examples
    --------
    >>> import math
    >>> from rigid import free
    >>> time = free.damping_time(
    ...     500.0, 2.0 * math.pi / (17.0 * 3600.0), density=2000.0, rigidity=5e9, quality=100.0
    ... )
    >>> round(time / (1e9 * 365.25 * 86400.0), 2)
    0.98
    """
    size, turning, rho, mu, q, k = (
        finite_float(name, value, positive=True, unit=unit)
        for name, value, unit in (
            ("radius", radius, "m"),
            ("rate", rate, "rad/s"),
            ("density", density, "kg/m³"),
            ("rigidity", rigidity, "Pa"),
            ("quality", quality, "1"),
            ("shape", shape, "1"),
        )
    )
    with np.errstate(all="ignore"):
        time = float(
            np.float64(mu) * q / (rho * k * np.float64(size) ** 2 * np.float64(turning) ** 3)
        )
    if not 0.0 < time < np.inf:
        raise ValueError(
            f"radius = {size:g}, rate = {turning:g}: the time, {time:g} s, leaves the range of "
            "doubles; count in other units"
        )
    return time


def sink_of_damping(body: BodyLike, rate: float, time: float) -> EnergySink:
    """The energy sink with which a small nutation about the short axis decays in a time.

    The angle of the nutation falls to 1/e. At constant L the sink damps large nutations at rates of
    the same order; the dissipation of a material with a constant quality factor depends in another
    way on the frequency.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        One body, or its principal moments (kg m²); the largest differs from the middle one.
    rate : float
        Rate about the short axis (rad/s), positive.
    time : float
        The time (s), positive; :func:`damping_time` is an estimate.

    Returns
    -------
    EnergySink
        With equal coefficients of all axes.

    Raises
    ------
    ValueError
        If the two largest moments are equal, or an argument is not positive and finite.

    Examples
    --------
    >>> import math
    >>> from rigid import free
    >>> moments, rate = (1.0, 2.0, 2.5), 1e-4
    >>> sink = free.sink_of_damping(moments, rate, time=1e15)
    >>> found = free.relaxation(moments, [1e-7, 0.0, rate], [0.0, 1e15], sink)
    >>> start, end = found.states.energy - 1.0
    >>> round(math.sqrt(end / start), 6)
    0.367879
    """
    moments = np.sort(moments_of(body))
    if moments.shape != (3,):
        raise ValueError(f"body of shape {moments.shape}: one body at a time; loop over bodies")
    turning = finite_float("rate", rate, positive=True, unit="rad/s")
    decay = finite_float("time", time, positive=True, unit="s")
    i1, i2, i3 = (float(moment) for moment in moments)
    if i3 == i2:
        raise ValueError(
            f"moments = {[i1, i2, i3]}: the two largest are equal, so no axis is the short one; "
            "give an EnergySink of your own"
        )
    # The energy of the nutation falls by P nu² I3 (1/(I1 (I3 - I1)) + 1/(I2 (I3 - I2))), with
    # nu² = (I3 - I1)(I3 - I2) omega² / (I1 I2), and the angle half as fast.
    with np.errstate(all="ignore"):
        # In units of the largest moment.
        a, b = np.float64(i1) / i3, np.float64(i2) / i3
        fall = np.float64(turning) ** 2 * (b * (1.0 - b) + a * (1.0 - a)) / (a * b) ** 2
        coefficient = float(2.0 / (fall * decay) * i3)
    if not 0.0 < coefficient < np.inf:
        raise ValueError(
            f"rate = {turning:g}, time = {decay:g}: the coefficient, {coefficient:g}, leaves the "
            "range of doubles; count in other units"
        )
    return EnergySink(coefficient)
