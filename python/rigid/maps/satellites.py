"""Predictions of maps of satellites, by theory.

Free body with an energy sink, spinning about its axis of the smallest moment, *no flip* about it
    The energy falls slowly against the nutation, at constant L. By the mean over a nutation of
    ``dE/dt = -omega'·P omega'`` it reaches the separatrix at a time after which the rate about the
    axis changes its sign within about half a nutation. The prediction is 1 before that time less a
    tenth, and 0 after it and a tenth, for the largest and the smallest noise that is likely. A
    period of small nutations is kept free, too: before it of those about the axis, after it of
    those about the axis of the largest moment. The time grows as the smallest moment comes near to
    the middle one, until the separatrix is so near to the axis that the noise begins beside it;
    then it falls.

Satellite at rest on a circular orbit, criterion *tilt of the pitch axis from the normal*
    Axis 1 (roll) lies along the motion, axis 2 (pitch) along the normal, axis 3 (yaw) along the
    line from the planet. Roll and yaw are linear for small noise, with the equations of
    :func:`rigid.free.libration`. Where they are stable no motion exceeds the noise times the
    condition of the eigenvectors; where they are not, nearly every motion grows at the largest
    exponent. No prediction is made between, and where rest is unstable in pitch.

Hughes, *Spacecraft Attitude Dynamics*, §§ 5.5, 9.2; DeBra and Delp, *J. Astronaut. Sci.* 8 (1961)
14-17.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from .._checks.arrays import Floats
from .._energy_loss import mean_loss
from .._libration import squares
from ..model.bounds import NoFlip, TiltBelow
from ..model.orbit import Orbit
from ..rotations import quaternion_to_matrix
from .spec import MapSpec

Predicted: TypeAlias = tuple[str, Floats, dict[str, Floats]]
"""Label, share of each pixel, and the lines where a number of each pixel is zero."""

NORMAL_REACH = 4.0
"""Largest deviation of normal noise that is considered, in standard deviations (all but 6e-5)."""

BLOCK = 8192
"""Most pixels whose times are computed together: each needs a kilobyte in each of some arrays."""

CHI_SQUARED_HALF = 0.4549364231195727
"""Median of the square of a normal number, in squares of its standard deviation."""

RAYLEIGH_HALF = math.sqrt(2.0 * math.log(2.0))
"""Median of the length of two normal components, in standard deviations."""


def flat_spin(spec: MapSpec) -> Predicted | None:
    """The prediction for a spin about the long axis that loses energy; None for other maps."""
    scene, stable, start, grid = spec.scene, spec.stable, spec.start.starts[0], spec.grid
    sink, noise = scene.dissipation, start.noise
    if (
        not isinstance(stable, NoFlip)
        or sink is None
        or {*spec.forces} != {"dissipation"}
        or noise is None
        or not noise.is_plain_normal
    ):
        return None
    tested = stable.conditions()[0][1] - 1
    moments, omega, size = grid.moments, grid.omega, grid.omega_size
    across = [(tested + 1) % 3, (tested + 2) % 3]
    spin = np.abs(omega[:, tested])
    known = grid.possible & (np.abs(omega).sum(axis=1) == spin)  # at rest the times are NaN
    known &= (moments[:, across] > moments[:, [tested]]).all(axis=1)
    order = [tested, *across]
    sinks = np.array(sink.coefficient)[order]
    reach = NORMAL_REACH * size[:, tested]
    slow, fast = np.maximum(spin - reach, 0.0), spin + reach
    latest, first, half = np.full((3, len(moments)), np.nan)
    places = np.flatnonzero(known)
    for rows in np.array_split(places, len(places) // BLOCK + 1):
        body, largest = moments[rows][:, order], size[rows].max(axis=1)
        for time, rates, rate, bound in (
            (latest, (slow, fast), 1e-3 * largest, np.maximum),
            (first, (slow, fast), NORMAL_REACH * largest, np.minimum),
            (half, (spin,), median_across(body, size[rows][:, across]), np.minimum),
        ):
            time[rows] = bound.reduce(
                [time_to_separatrix(body, sinks, one[rows], rate) for one in rates]
            )
    i1, (i2, i3) = moments[:, tested], np.sort(moments[:, across], axis=1).T
    before = math.tau / slow * np.sqrt(i2 * i3 / ((i2 - i1) * (i3 - i1)))
    after = math.tau * i3 / (i1 * slow) * np.sqrt(i1 * i2 / ((i3 - i1) * (i3 - i2)))
    share = np.where(spec.t_end < 0.9 * first - before, 1.0, np.nan)
    share = np.where(spec.t_end > 1.1 * latest + after, 0.0, share)
    middle = moments[:, across].min(axis=1) / moments[:, tested] - 1.0
    curves = {f"axis {tested + 1} becomes the middle one": middle}
    curves |= {f"half pass the separatrix by {spec.horizon}": half / spec.t_end - 1.0}
    return f"mean loss of energy until {spec.horizon}", share, curves


def median_across(moments: Floats, size: Floats) -> Floats:
    """Median of the nutation of normal rates, as a rate about the axis of the largest moment.

    Near axis 1 the energy of the nutation depends on ``I2 (I2 - I1) w2² + I3 (I3 - I1) w3²``. With
    the rates in polar form its distribution is a mean over their angle (Hoyt, *Bell Syst. Tech. J.*
    26 (1947) 318), whose median Newton's method finds.

    Parameters
    ----------
    moments : ndarray, shape (n, 3)
        Moments (kg m²); the moment of axis 1 is the smallest.
    size : ndarray, shape (n, 2)
        Standard deviations of the rates about axes 2 and 3 (rad/s).

    Returns
    -------
    ndarray, shape (n,)
        The median (rad/s).
    """
    energy = moments[:, 1:] * (moments[:, 1:] - moments[:, :1])
    parts = energy * size**2
    whole = parts.max(axis=1)
    ratio = np.divide(parts.min(axis=1), whole, out=np.ones_like(whole), where=whole > 0.0)
    angle = (np.arange(64) + 0.5) * np.pi / 128.0
    rate = 0.5 / (np.cos(angle) ** 2 + ratio[:, np.newaxis] * np.sin(angle) ** 2)
    median = np.full(len(moments), CHI_SQUARED_HALF)
    for _ in range(5):  # from below: the chance of more is convex
        more = np.exp(-rate * median[:, np.newaxis])
        median += (more.mean(axis=1) - 0.5) / (rate * more).mean(axis=1)
    return np.asarray(np.sqrt(median * whole / energy.max(axis=1)))


def time_to_separatrix(moments: Floats, sink: Floats, spin: Floats, across: Floats) -> Floats:
    """Time until a spin about axis 1, of the smallest moment, has fallen to the separatrix.

    ``I3`` is the largest moment. Here ``x`` is the share of the way from the energy of the axis to
    the energy of the separatrix, from ``x0`` by the rates ``across`` at the start to 1.

    Parameters
    ----------
    moments : ndarray, shape (n, 3)
        Moments (kg m²); the moment of axis 1 is the smallest.
    sink : ndarray, shape (3,)
        Coefficients of the energy sink (kg m² s).
    spin : ndarray, shape (n,)
        Rate about axis 1 (rad/s).
    across : ndarray, shape (n,)
        Rate about the axis of the largest moment at the start (rad/s).

    Returns
    -------
    ndarray, shape (n,)
        The time (s).
    """
    swap = (moments[:, 1] > moments[:, 2])[:, np.newaxis]
    i1, i2, i3 = np.where(swap, moments[:, [0, 2, 1]], moments).T[:, :, np.newaxis]
    p1, p2, p3 = np.where(swap, sink[[0, 2, 1]], sink).T[:, :, np.newaxis]
    square = (i1 * spin[:, np.newaxis]) ** 2  # L²
    # The energy falls from L²/2 I1 by x of (1/I1 - 1/I2) L²/2.
    whole = square * (i2 - i1) / (i1 * i2)
    begun = i3 * across[:, np.newaxis] ** 2 * (i3 - i1) / (i1 * whole)
    # Points in the logarithms of x and 1 - x: both ends are approached like exponentials.
    nodes, weights = np.polynomial.legendre.leggauss(48)
    begun, high = np.minimum(begun, 1.0), 30.0  # beyond the separatrix there is no way left
    low = np.minimum(np.log(begun) - np.log1p(-begun), high)
    place = low + (high - low) * 0.5 * (1.0 + nodes)
    x, rest = 1.0 / (1.0 + np.exp(-place)), 1.0 / (1.0 + np.exp(place))
    measure = 0.5 * (high - low) * weights * x * rest
    power = mean_loss((i1, i2, i3), (p1, p2, p3), square, x, rest)
    time: Floats = (0.5 * whole * measure / power).sum(axis=-1)
    return time


def at_rest_on(orbit: Orbit) -> Floats:
    """The attitude at ``t = 0`` of a body whose roll, pitch and yaw are zero, as a matrix."""
    return orbit.frame(0.0)[:, [1, 2, 0]]


def orbit_alone(spec: MapSpec) -> Orbit | None:
    """The orbit of a free body, an ellipse, on which nothing else acts."""
    orbit = spec.scene.orbit
    if {*spec.forces} != {"orbit"} or not isinstance(orbit, Orbit) or orbit.eccentricity > 1.0:
        return None
    return orbit


def on_orbit(spec: MapSpec) -> Predicted | None:
    """The prediction for roll and yaw of a satellite at rest on its orbit, or None."""
    orbit, stable, start, grid = orbit_alone(spec), spec.stable, spec.start.starts[0], spec.grid
    noise = start.noise
    if (
        orbit is None
        or orbit.eccentricity != 0.0
        or not isinstance(stable, TiltBelow)
        or stable.reference != "vertical"
        or stable.axis != 2
        or start.attitude is None
        or not np.allclose(quaternion_to_matrix(start.attitude), at_rest_on(orbit), atol=1e-12)
        or start.attitude_noise is not None
        or noise is None
        or not noise.is_plain_normal
    ):
        return None
    at_rest = np.all(grid.omega == (0.0, orbit.rate, 0.0), axis=1) & grid.possible
    roll, pitch, yaw = grid.moments.T
    k1, k3 = (pitch - yaw) / roll, (pitch - roll) / yaw
    # Roll a and yaw c, the time in units of the orbit: a'' = -4 k1 a + (1 - k1) c' and
    # c'' = -k3 c - (1 - k3) a'.
    zero, one = np.zeros_like(k1), np.ones_like(k1)
    rows = [
        [zero, zero, one, zero],
        [zero, zero, zero, one],
        [-4.0 * k1, zero, zero, 1.0 - k1],
        [zero, -k3, k3 - 1.0, zero],
    ]
    matrix = np.moveaxis(np.array(rows), -1, 0)
    matrix[~at_rest] = np.eye(4)
    values, vectors = np.linalg.eig(matrix)
    spread = np.linalg.cond(vectors)
    growth = values.real.max(axis=1) * orbit.rate * spec.t_end
    size = grid.omega_size.max(axis=1) / orbit.rate
    still = NORMAL_REACH * size * spread < 0.5 * stable.angle
    left = np.exp(growth) * 1e-3 * size / spread > 4.0 * stable.angle
    _, half, product = squares(roll, pitch, yaw)
    swings = np.minimum(product, np.where(half > 0.0, half * half - product, -1.0))
    share = np.select([(swings > 0.0) & still, (swings < 0.0) & left], [1.0, 0.0], np.nan)
    share = np.where(at_rest & (roll > yaw), share, np.nan)
    curves = {
        "DeBra-Delp: roll and yaw stable": np.where(at_rest, swings, np.nan),
        "pitch stable": np.where(at_rest, (roll - yaw) / pitch, np.nan),
    }
    label = "linear roll and yaw on a circular orbit (DeBra and Delp 1961)"
    return label, share, curves
