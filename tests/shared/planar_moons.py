"""A moon whose long axis turns in the plane of its orbit, by SciPy."""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import rigid

Floats = NDArray[np.float64]

MOMENTS = (1.0, 1.3, 1.6)


@cache
def planar(
    theta: float, rate: float, e: float, t_end: float, anomaly: float = 0.0, count: int = 40_001
) -> tuple[Floats, Floats, Floats]:
    """Times, angle of axis 1 from the line of apsides and from the planet, for a mean motion of 1.

    ``theta'' = -1.5 (I2 - I1)/I3 (a/r)³ sin 2 (theta - f)`` (Goldreich and Peale, Astron. J. 71
    (1966) 425), with Kepler's equation as ``E' = a/r``. By SciPy to 1e-12.
    """
    strength = 1.5 * (MOMENTS[1] - MOMENTS[0]) / MOMENTS[2]
    eccentric = anomaly
    for _ in range(60):
        eccentric -= (eccentric - e * math.sin(eccentric) - anomaly) / (1 - e * math.cos(eccentric))

    def true(anomaly: Floats) -> Floats:
        return np.arctan2(math.sqrt(1.0 - e * e) * np.sin(anomaly), np.cos(anomaly) - e)

    def change(_t: float, y: Floats) -> list[float]:
        near = 1.0 / (1.0 - e * math.cos(y[2]))
        torque = -strength * near**3 * math.sin(2.0 * (y[0] - float(true(y[2]))))
        return [y[1], torque, near]

    t = np.linspace(0.0, t_end, count)
    found = solve_ivp(
        change, (0.0, t_end), [theta, rate, eccentric], "DOP853", t, rtol=1e-12, atol=1e-12
    )
    return t, found.y[0], found.y[0] - true(found.y[2])


def beginning_so(starts: Sequence[tuple[float, float]]) -> rigid.Start:
    """The start of a map whose bodies have these angles of axis 1 and rates, in order."""
    angles, rates = np.array(starts).T
    given = rigid.samples(
        omega=np.stack([0.0 * rates, 0.0 * rates, rates], axis=-1),
        attitude=Rotation.from_euler("z", angles[:, np.newaxis]).as_quat(scalar_first=True),
        in_order=True,
    )
    return rigid.Start(omega=(0.0, 0.0, 0.0), noise=given)
