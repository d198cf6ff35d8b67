"""Delfi-PQ, a satellite of 0.6 kg: how long three coils need to stop its tumbling."""

from __future__ import annotations

from functools import cache
from math import copysign, cos, pi, radians, sin, sqrt
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats
from ..inertia import compose
from ..model.body import Body
from ..model.scene import FreeBody
from ..model.torque import Torque
from ..solids import box
from ..solve.run import Run
from ..solve.simulate import simulate

RADIUS = 6378.137e3 + 350e3
"""Of the circular orbit (m)."""

RATE = sqrt(3.9860044181e14 / RADIUS**3)
"""Of the motion on the orbit (rad/s)."""

INCLINATION, NODE, BEGIN = radians(96.84895), radians(210.0), radians(60.0)
"""Inclination of the orbit, place of its ascending node, and first angle from the node."""

TO_NODE = cos(NODE), sin(NODE), 0.0
"""Direction of the ascending node, in space."""

PAST_NODE = -sin(NODE) * cos(INCLINATION), cos(NODE) * cos(INCLINATION), sin(INCLINATION)
"""Direction a quarter of the orbit later."""

TURN = 2.0 * pi / (86400.0 * 365.24 / 366.24)
"""Rate of the rotation of the Earth (rad/s); at first its axes are the axes of space."""

DIPOLE = tuple(
    1e-9 * (6371.2e3 / RADIUS) ** 3 * (of_2015 + change * (212.0 / 365.0 + 3.0))
    for of_2015, change in ((-1501.0, 18.1), (4797.1, -26.6), (-29442.0, 10.3))
)
"""Dipole of the Earth on the orbit (T), on 1 August 2018: ``g11``, ``h11``, ``g10`` of IGRF-12."""

CYCLE, STEP = 0.25, 0.125
"""Time between two readings of the magnetometer, and step of the source's integration (s).

At first the error of these steps slows the body, and hardly the coils. In steps of 0.02 s none of
three satellites stops within 183 h: coils held while it turns by 1.4 rad drive it about axis 3.
"""

DUTY, RISE = 0.6, 0.04
"""Largest share of a cycle in which a coil is on, and the share that its rise takes."""

SLOW = radians(5.0)
"""The tumbling has stopped when no rate is larger (rad/s)."""

GAIN = 2.0 * RATE * (1.0 + sin(INCLINATION - radians(11.44)))
"""Of the law of Avanzini and Giulietti, over the least moment (1/s)."""

MASS = 0.6
"""Of the satellite (kg)."""


def coils(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    """The torque of coils that hold their dipole against the change between the last readings.

    ``data``: time at the start of the run (s), moments (kg m²), largest dipoles and dipole that
    stays (A m²), gain (A m² s T).

    A reading is the field of now, turned back by the motion of a free body with two equal moments:
    within half a second the torque changes no rate by more than 2e-4 rad/s. At the end of a cycle
    half of the old and half of the new dipole acts: there steps end.
    """
    now = data[0] + t
    node, past = cos(BEGIN + RATE * now), sin(BEGIN + RATE * now)
    c, s = cos(TURN * now), sin(TURN * now)
    r1 = node * TO_NODE[0] + past * PAST_NODE[0]
    r2 = node * TO_NODE[1] + past * PAST_NODE[1]
    r3 = past * PAST_NODE[2]
    g1, g2, g3 = c * DIPOLE[0] - s * DIPOLE[1], s * DIPOLE[0] + c * DIPOLE[1], DIPOLE[2]
    along = 3.0 * (g1 * r1 + g2 * r2 + g3 * r3)
    x, y, z = along * r1 - g1, along * r2 - g2, along * r3 - g3
    w, i, j, k = attitude[0], attitude[1], attitude[2], attitude[3]
    b1 = (1 - 2 * (j * j + k * k)) * x + 2 * (i * j + w * k) * y + 2 * (i * k - w * j) * z
    b2 = 2 * (i * j - w * k) * x + (1 - 2 * (i * i + k * k)) * y + 2 * (j * k + w * i) * z
    b3 = 2 * (i * k + w * j) * x + 2 * (j * k - w * i) * y + (1 - 2 * (i * i + j * j)) * z
    # The body turns about L, and about axis 3 beside: both undone give the field of before.
    equal = 0.5 * (data[1] + data[2])
    l1, l2, l3 = data[1] * omega[0] / equal, data[2] * omega[1] / equal, data[3] * omega[2] / equal
    rate = sqrt(l1 * l1 + l2 * l2 + l3 * l3)
    l1, l2, l3, spin = l1 / rate, l2 / rate, l3 / rate, omega[2] - l3
    part = l1 * b1 + l2 * b2 + l3 * b3
    a1, a2, a3 = l2 * b3 - l3 * b2, l3 * b1 - l1 * b3, l1 * b2 - l2 * b1
    since = now % CYCLE
    cycles = 2 if since == 0.0 else 1
    torque[0], torque[1], torque[2] = data[7], data[8], data[9]
    for cycle in range(cycles):
        change1 = change2 = change3 = 0.0
        for sign, before in ((1.0, cycle), (-1.0, cycle + 1)):
            time = since + before * CYCLE
            c, s = cos(rate * time), sin(rate * time)
            e1 = c * b1 + (1.0 - c) * part * l1 + s * a1
            e2 = c * b2 + (1.0 - c) * part * l2 + s * a2
            e3 = c * b3 + (1.0 - c) * part * l3 + s * a3
            c, s = cos(spin * time), sin(spin * time)
            change1 += sign * (c * e1 - s * e2)
            change2 += sign * (s * e1 + c * e2)
            change3 += sign * e3
        gain = data[10] / (CYCLE * (x * x + y * y + z * z))
        for axis, change in enumerate((change1, change2, change3)):
            most = data[4 + axis]
            on = DUTY * min(1.0, gain * abs(change) / most) - RISE
            torque[axis] -= copysign(1.0, change) * on * most / cycles
    m1, m2, m3 = torque[0], torque[1], torque[2]
    torque[0], torque[1], torque[2] = m2 * b3 - m3 * b2, m3 * b1 - m1 * b3, m1 * b2 - m2 * b1


def moments(mass: float = MASS) -> Floats:
    """Moments of a box with a plate on its second face, of one density (kg m²)."""
    sizes = (0.05, 0.05, 0.178), (0.064, 0.0016, 0.192)
    volumes = np.prod(sizes, axis=1)
    masses = mass * volumes / volumes.sum()
    parts = [box(*size, mass=part) for size, part in zip(sizes, masses, strict=True)]
    parts[1] = parts[1].placed((0.0, 0.5 * (sizes[0][1] + sizes[1][1]), 0.0))
    return np.diag(compose(parts).tensor)


def satellites(count: int, seed: int) -> Floats:
    """The numbers of random satellites for :func:`coils`.

    Each has one of as many equally likely values of each number: their means scatter less than
    the means of independent draws (Latin hypercube).
    """
    random = np.random.default_rng(seed)
    values = np.array([NormalDist().inv_cdf((i + 0.5) / count) for i in range(count)])

    def drawn(mean: float, sigma: float) -> Floats:
        return mean + sigma * random.permutation(values)

    nominal = moments(1.0) * drawn(MASS, 0.1)[:, np.newaxis]
    # The source says 15 %, and takes a fifteenth.
    largest = [drawn(0.002, 0.002 / 15.0) for _ in range(3)]
    off, about = random.uniform(0.0, 2.0 * pi, (2, count))
    direction = np.array([np.sin(off) * np.cos(about), np.sin(off) * np.sin(about), np.cos(off)])
    errors = np.transpose([drawn(1.0, 0.05) for _ in range(3)])
    return np.column_stack(
        [
            np.zeros(count),
            nominal * errors,
            *largest,
            *(drawn(1e-4, 1e-5) * direction),
            GAIN * nominal.min(axis=1),
        ]
    )


def moved(data: Floats, omega: Floats, attitude: Floats, t: Floats, step: float) -> Run:
    """Motions under the coils by the method of the source."""
    torque = Torque.call(coils, data)
    # Of the source's bodies with an error of 5 % in each moment 3 % are impossible.
    scene = FreeBody(Body(data[..., 1:4], physical=False), torque=torque)
    return simulate(
        scene, omega, attitude, t=t, method="rk4", step=step, check=False, progress=False
    )


@cache
def hours_of_tumbling(count: int = 16, seed: int = 1) -> Floats:
    """How long (h) each of so many satellites tumbles, to a minute; NaN beyond two days."""
    data = satellites(count, seed)
    omega, attitude = np.full((count, 3), pi), np.tile([0.0, 1.0, 0.0, 0.0], (count, 1))
    ends, still = np.full(count, np.nan), np.arange(count)
    minutes = np.arange(1.0, 61.0)
    for hour in range(48):
        data[:, 0] = 3600.0 * hour
        run = moved(data[still], omega, attitude, 60.0 * minutes, STEP)
        assert run.attitude is not None
        slow: NDArray[np.bool_] = np.asarray((np.abs(run.omega) <= SLOW).all(axis=-1))
        stops = slow.any(axis=1)
        ends[still[stops]] = hour + minutes[slow[stops].argmax(axis=1)] / 60.0
        still = still[~stops]
        omega, attitude = run.omega[~stops, -1], run.attitude[~stops, -1]
        if not still.size:
            break
    return ends


def mean_hours() -> float:
    """Their mean (h)."""
    return float(hours_of_tumbling().mean())


def median_orbits() -> float:
    """Their median, in orbits."""
    return float(np.median(hours_of_tumbling())) * 3600.0 * RATE / (2.0 * pi)
