"""Lines of theory for maps of moons: where the rotation is in resonance with the orbit.

Both predict no shares: a resonance says where motions change, and a map says what they become.

Moon that keeps one side to its planet, on an eccentric orbit
    Axis 1 points along the line to the planet, axis 3 along the normal of the orbit. Its small
    oscillations are a libration in longitude and two modes of roll and yaw, with the frequencies
    of :func:`rigid.free.libration`. The eccentricity swings the moon with the mean motion ``n``.
    This swing pumps the other oscillations where twice their frequency is a multiple of ``n``
    (Agrusa et al., *Icarus* 370 (2021) 114624; Tan, Wang, Hou, *Icarus* (2022) 115289). Drawn are
    the lines of libration at ``n/2`` and ``n``, of the slow mode at ``n/2`` and of the fast mode at
    ``3n/2``.

Moon that spins about the normal of its orbit, with axis 1 along the line of apsides
    The angle ``theta - p M``, with the mean anomaly ``M`` and ``p = 1``, ``3/2`` or ``2``, moves
    like a pendulum if the torque is averaged over the orbit. It librates while
    ``|omega/n - p| < sqrt(3 (I2 - I1)/I3 H(p, e))`` at the start, where ``H`` is the mean of
    ``(a/r)³ cos 2(f - p M)``, with the true anomaly ``f`` (Goldreich, Peale, *Astron. J.* 71 (1966)
    425; Murray, Dermott, *Solar System Dynamics*, § 5.4).
"""

from __future__ import annotations

import numpy as np

from .._checks.arrays import Floats
from .._libration import frequencies
from ..model.orbit import Orbit
from ..rotations import quaternion_to_matrix
from .satellites import Predicted, orbit_alone
from .spec import MapSpec

PLACES = 256
"""Eccentric anomalies of a mean over the orbit: the rule is exact to rounding up to e = 0.95."""


def attitude_resonances(spec: MapSpec) -> Predicted | None:
    """Where the oscillations of a moon that keeps one side to its planet are pumped."""
    orbit, grid = orbit_alone(spec), spec.grid
    if orbit is None or orbit.eccentricity == 0.0 or not _faces_planet(spec, orbit):
        return None
    known = grid.possible & np.all(grid.omega[:, :2] == 0.0, axis=1)
    yaw, roll, pitch = np.where(known[:, np.newaxis], grid.moments, np.nan).T
    swing, fast, slow = frequencies(roll, pitch, yaw)
    curves = {
        "libration at n/2": swing - 0.5,
        "libration at n": swing - 1.0,
        "slow mode of roll and yaw at n/2": slow - 0.5,
        "fast mode of roll and yaw at 3n/2": fast - 1.5,
    }
    return "frequencies about rest, in resonance with the orbit", _nothing(spec), curves


def spin_orbit_resonances(spec: MapSpec) -> Predicted | None:
    """Where a moon that spins about the normal of its orbit begins to librate."""
    orbit, grid = orbit_alone(spec), spec.grid
    if orbit is None or orbit.anomaly != 0.0 or not _faces_planet(spec, orbit):
        return None
    first, second, third = grid.moments.T
    about = np.all(grid.omega[:, :2] == 0.0, axis=1) & grid.possible & (first < second)
    strength = 3.0 * (second - first) / third
    numbers = np.broadcast_to(grid.scene.further_numbers()["orbit"], (len(first), 9))
    e, of = np.unique(numbers[:, 1], return_inverse=True)
    ratio = grid.omega[:, 2] / orbit.rate
    curves = {}
    for name, p in (("1:1", 1.0), ("3:2", 1.5), ("2:1", 2.0)):
        inside = strength * averaged_torque(p, e)[of] - (ratio - p) ** 2
        curves[f"edges of {name}"] = np.where(about, inside, np.nan)
    return "pendulum of the averaged torque", _nothing(spec), curves


def averaged_torque(p: float, eccentricity: Floats) -> Floats:
    """``H(p, e)``: the mean of ``(a/r)³ cos 2(f - p M)`` over the orbit, shape of ``e``.

    ``7e/2 - 123e³/16 + ...`` for ``p = 3/2``.
    """
    e = np.asarray(eccentricity)[..., np.newaxis]
    anomaly = 2.0 * np.pi * np.arange(PLACES) / PLACES  # eccentric
    near = 1.0 - e * np.cos(anomaly)  # r/a, and dM/dE
    true = np.arctan2(np.sqrt(1.0 - e * e) * np.sin(anomaly), np.cos(anomaly) - e)
    mean = anomaly - e * np.sin(anomaly)
    found: Floats = np.mean(np.cos(2.0 * (true - p * mean)) / near**2, axis=-1)
    return found


def _faces_planet(spec: MapSpec, orbit: Orbit) -> bool:
    """Whether axis 1 lies along the line to the planet at the start, and axis 3 along the normal.

    But for normal noise.
    """
    start = spec.start.starts[0]
    noises = [noise for noise in (start.noise, start.attitude_noise) if noise is not None]
    if (
        not {"tilt", "anomaly"}.isdisjoint(spec.varied)
        or start.tilt != 0.0
        or not all(noise.is_plain_normal for noise in noises)
    ):
        return False
    given = (1.0, 0.0, 0.0, 0.0) if start.attitude is None else start.attitude
    turned = orbit.frame(0.0).T @ quaternion_to_matrix(np.array(given))
    return bool(abs(turned[0, 0]) > 1.0 - 1e-9 and turned[2, 2] > 1.0 - 1e-9)


def _nothing(spec: MapSpec) -> Floats:
    return np.full(len(spec.grid.moments), np.nan)
