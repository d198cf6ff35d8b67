"""Predictions of maps of satellites, by theory.

Free body with an energy sink, spinning about its axis of the smallest moment, *no flip* about it
    The energy falls slowly against the nutation, at constant L. By the mean over a nutation of
    ``dE/dt = -omega'·P omega'`` it reaches the separatrix at a time after which the rate about the
    axis changes its sign within about half a nutation. The prediction is 1 before that time less a
    tenth, and 0 after it and a tenth, for the largest and the smallest noise that is likely.

Satellite at rest on a circular orbit, criterion *tilt of the pitch axis from the normal*
    Roll and yaw are linear for small noise, with the equations of :func:`rigid.free.libration`.
    Where they are stable no motion exceeds the noise times the condition of the eigenvectors;
    where they are not, nearly every motion grows at the largest exponent. No prediction is made
    between, and where rest is unstable in pitch.

Hughes, *Spacecraft Attitude Dynamics*, §§ 5.5, 9.2; DeBra and Delp, *J. Astronaut. Sci.* 8 (1961)
14-17.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._moments import possible
from ..model.criteria import NoFlip, TiltBelow
from ..model.scene import FreeBody
from ..model.torque import Torque
from .spec import MapSpec

__all__ = ["flat_spin", "on_orbit", "time_to_separatrix"]

Floats = NDArray[np.float64]
Predicted: TypeAlias = tuple[str, Floats, dict[str, Floats]]
"""Label, share of each pixel, and the lines where a number of each pixel is zero."""

NORMAL_REACH = 4.0
"""Largest deviation of normal noise that is considered, in standard deviations (all but 6e-5)."""

RAYLEIGH_HALF = math.sqrt(2.0 * math.log(2.0))
"""Median of the length of two normal components, in standard deviations."""


def flat_spin(spec: MapSpec) -> Predicted | None:
    """The loss of energy of a spin about the axis of the smallest moment, None if it is none."""
    scene, stable, start, grid = spec.scene, spec.stable, spec.start.starts[0], spec.grid
    sink, noise = scene.dissipation, start.noise
    if (
        not isinstance(scene, FreeBody)
        or not isinstance(stable, NoFlip)
        or sink is None
        or scene.torque is not None
        or scene.rotor is not None
        or grid.damping is not None
        or noise is None
        or not noise.is_plain_normal
    ):
        return None
    tested = stable.core()[1] - 1
    moments, omega, size = grid.moments, grid.omega, grid.omega_size
    across = [(tested + 1) % 3, (tested + 2) % 3]
    spin = np.abs(omega[:, tested])
    known = possible(moments) & (np.abs(omega).sum(axis=1) == spin) & (spin > 0.0)
    known &= (moments[:, across] > moments[:, [tested]]).all(axis=1)
    order = [tested, *across]
    columns = (moments[:, order], np.array(sink.coefficient)[order], spin)
    least, most, half = (
        time_to_separatrix(*columns, reach * size.max(axis=1))
        for reach in (1e-3, NORMAL_REACH, RAYLEIGH_HALF)
    )
    share = np.where(spec.t_end < 0.9 * most, 1.0, np.nan)
    share = np.where(spec.t_end > 1.1 * least, 0.0, share)
    border = np.where(known, half / spec.t_end - 1.0, np.nan)
    curves = {f"half pass the separatrix by t = {spec.t_end:g} s": border}
    label = f"mean loss of energy until t = {spec.t_end:g} s"
    return label, np.where(known, share, np.nan), curves


def time_to_separatrix(moments: Floats, sink: Floats, spin: Floats, across: Floats) -> Floats:
    """Time until a spin about axis 1, of the smallest moment, has fallen to the separatrix.

    With ``I3`` the largest moment, the polhode about axis 1 is ``w2 = a2 sin f``, ``w3 = a3 cos f``
    with ``f' = p sqrt(1 - m sin² f)``. Here ``x`` is the share of the energy between that of the
    axis and that of the separatrix, from ``x0`` by the rates ``across`` at the start to 1.
    """
    swap = moments[:, 1] > moments[:, 2]
    moments = np.where(swap[:, np.newaxis], moments[:, [0, 2, 1]], moments)
    i1, i2, i3 = (moments[:, k, np.newaxis, np.newaxis] for k in range(3))
    p1, p2, p3 = np.where(swap[:, np.newaxis], sink[[0, 2, 1]], sink).T[:, :, None, None]
    square = (i1 * spin[:, np.newaxis, np.newaxis]) ** 2  # L²
    # The energy falls from L²/2 I1 by x of (1/I1 - 1/I2) L²/2.
    whole = square * (1.0 / i1 - 1.0 / i2)
    begun = i3 * across[:, np.newaxis, np.newaxis] ** 2 * (i3 / i1 - 1.0) / whole
    # Points in the logarithms of x and 1 - x: both ends are approached like exponentials.
    nodes, weights = np.polynomial.legendre.leggauss(48)
    low, high = np.log(begun), 30.0
    place = low + (high - low) * 0.5 * (1.0 + nodes[:, np.newaxis])
    x, rest = 1.0 / (1.0 + np.exp(-place)), 1.0 / (1.0 + np.exp(place))
    measure = 0.5 * (high - low) * weights[:, np.newaxis] * x * rest
    lost = x * whole  # L²/I1 - 2E
    a2 = np.sqrt(lost * i1 / (i2 * (i2 - i1)))
    a3 = np.sqrt(lost * i1 / (i3 * (i3 - i1)))
    # On the polhode the rate about axis 1 follows from L.
    phase = (np.arange(64) + 0.5) * np.pi / 64.0
    w2, w3 = a2 * np.sin(phase), a3 * np.cos(phase)
    w1 = np.sqrt(np.maximum(square - (i2 * w2) ** 2 - (i3 * w3) ** 2, 0.0)) / i1
    power = p1 * ((i2 - i3) / i1 * w2 * w3) ** 2 + p2 * ((i3 - i1) / i2 * w3 * w1) ** 2
    power = power + p3 * ((i1 - i2) / i3 * w1 * w2) ** 2
    # df = p w1 dt up to a constant: the time on a part of the polhode is df / w1.
    mean = (power / w1).sum(axis=-1) / (1.0 / w1).sum(axis=-1)
    time: Floats = (0.5 * whole[..., 0] * measure[..., 0] / mean).sum(axis=-1)
    return time


def on_orbit(spec: MapSpec) -> Predicted | None:
    """Roll and yaw of a satellite at rest on its orbit, None if it is none."""
    scene, stable, start, grid = spec.scene, spec.stable, spec.start.starts[0], spec.grid
    orbit = None if scene.torque is None else scene.torque.orbit
    noise = start.noise
    if (
        orbit is None
        or not isinstance(stable, TiltBelow)
        or not isinstance(scene, FreeBody)
        or scene.rotor is not None
        or scene.dissipation is not None
        or grid.damping is not None
        or scene.torque != Torque.gravity_gradient(rate=orbit.rate)
        or stable.reference != "vertical"
        or stable.axis != 3
        or start.attitude_noise is not None
        or noise is None
        or not noise.is_plain_normal
    ):
        return None
    at_rest = np.all(grid.omega == (0.0, 0.0, orbit.rate), axis=1) & possible(grid.moments)
    yaw, roll, pitch = grid.moments.T
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
    half, product = 0.5 * (1.0 + 3.0 * k1 + k1 * k3), 4.0 * k1 * k3
    swings = np.minimum(product, np.where(half > 0.0, half * half - product, -1.0))
    share = np.select([(swings > 0.0) & still, (swings < 0.0) & left], [1.0, 0.0], np.nan)
    share = np.where(at_rest & (roll > yaw), share, np.nan)
    curves = {
        "DeBra-Delp: roll and yaw stable": np.where(at_rest, swings, np.nan),
        "pitch stable": np.where(at_rest, (roll - yaw) / pitch, np.nan),
    }
    label = "linear roll and yaw on a circular orbit (DeBra and Delp 1961)"
    return label, share, curves
