"""Motions of bodies with any tensor of inertia, and their deviation vectors, in 128-bit numbers.

``quad_tangent.c`` shares no line with the library, nor a method with ``quad_motion.c``: that sums
Taylor series along principal axes, this extrapolates along any axes.
"""

import ctypes
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path

import mpmath
import numpy as np
from numpy.typing import ArrayLike

from physics import Floats
from quad_motion import Motion, compiled

#: Largest error of a step, relative to the rates, the quaternion and each deviation vector.
TOLERANCE = 1e-24


@dataclass(frozen=True)
class Acting:
    """A body and what acts on it, all along the same axes of the body."""

    inertia: Floats
    weight: Floats = field(default_factory=lambda: np.zeros(3))
    damping: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    rotor: Floats = field(default_factory=lambda: np.zeros(3))
    body: Floats = field(default_factory=lambda: np.zeros(3))
    space: Floats = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Deviating:
    """States at some times: sums of two doubles, ``high`` and ``low``."""

    t: Floats
    high: Floats
    low: Floats

    @property
    def omega(self) -> Floats:
        return self.high[:, :3]

    @property
    def motion(self) -> Motion:
        """Rates and unit quaternions."""
        long = self.high[:, :7].astype(np.longdouble) + self.low[:, :7]
        long[:, 3:] /= np.sqrt((long[:, 3:] ** 2).sum(axis=1))[:, None]
        high = np.pad(long.astype(np.float64), [(0, 0), (0, 4)])
        return Motion(high, np.pad(long, [(0, 0), (0, 4)]) - high)

    @property
    def mean_megno(self) -> Floats:
        return 2.0 * (self.high[:, 7] - self.high[:, 8]) / self.t

    @property
    def deviations(self) -> Floats:
        """Shape (m, count, 6)."""
        return self.high[:, 9:].reshape(len(self.t), -1, 6)


def moved(
    acting: Acting,
    omega: ArrayLike,
    attitude: ArrayLike,
    t: ArrayLike,
    *,
    deviations: ArrayLike = (),
    scale: float = 0.0,
    of_attitude: bool = False,
    since: tuple[float, Deviating] | None = None,
    tolerance: float = TOLERANCE,
    limit: int = 3000,
) -> Deviating | None:
    """States at times in order; None beyond a limit of steps.

    Deviation vectors of shape (count, 6). With a unit ``scale`` of their rates the means of the
    growth of the first are integrated. ``since`` goes on at a time with the last state of another
    motion.
    """
    times, rows = np.array(t, dtype=np.float64), np.reshape(np.array(deviations), (-1, 6))
    start = np.concatenate([np.ravel(omega), np.ravel(attitude), [0.0, 0.0], rows.ravel()])
    begin, low = 0.0, np.zeros_like(start)
    if since is not None:
        begin, start, low = since[0], since[1].high[-1].copy(), since[1].low[-1].copy()
    high_of_inverse, low_of_inverse = _inverse(acting.inertia)
    records = np.empty((2, len(times), len(start)))
    steps = _library().deviating(
        *(np.ascontiguousarray(acting.inertia), high_of_inverse, low_of_inverse),
        *(acting.weight, acting.damping, acting.rotor, acting.body, acting.space),
        *(scale, of_attitude, len(rows), begin, start, low),
        *(len(times), times, tolerance, limit, records[0], records[1]),
    )
    return None if steps < 0 else Deviating(times, records[0], records[1])


def _inverse(matrix: Floats) -> tuple[Floats, Floats]:
    """The inverse of a symmetric matrix by exact cofactors, as sums of two doubles."""
    a = [[Fraction(float(x)) for x in row] for row in matrix]
    cofactors = [
        [
            a[(i + 1) % 3][(k + 1) % 3] * a[(i + 2) % 3][(k + 2) % 3]
            - a[(i + 1) % 3][(k + 2) % 3] * a[(i + 2) % 3][(k + 1) % 3]
            for i in range(3)
        ]
        for k in range(3)
    ]
    determinant = sum((a[0][k] * cofactors[k][0] for k in range(3)), Fraction(0))
    exact = [[x / determinant for x in row] for row in cofactors]
    high = np.array([[float(x) for x in row] for row in exact])
    low = [
        [float(x - Fraction(float(y))) for x, y in zip(*rows, strict=True)]
        for rows in zip(exact, high, strict=True)
    ]
    return high, np.array(low)


def gram_schmidt(vectors: Floats) -> Floats:
    """``ln`` of what each vector (count, 6) keeps across those before it, in 60 digits."""
    with mpmath.workdps(60):
        kept: list[mpmath.matrix] = []
        logs = []
        for vector in vectors:
            v = mpmath.matrix([_exact(x) for x in vector])
            for other in kept:
                v -= (other.T * v)[0] / (other.T * other)[0] * other
            kept.append(v)
            logs.append(float(mpmath.log(mpmath.norm(v))))
        return np.array(logs)


def _exact(x: np.floating) -> mpmath.mpf:
    """A number of 64 bits or 53."""
    high = float(x)
    return mpmath.mpf(high) + float(x - high)


@cache
def _library() -> ctypes.CDLL:
    library = compiled(Path(__file__).with_suffix(".c"))
    numbers, size = np.ctypeslib.ndpointer(np.float64, flags="C"), ctypes.c_ssize_t
    library.deviating.restype = ctypes.c_long
    library.deviating.argtypes = [
        *([numbers] * 8),
        *(ctypes.c_double, ctypes.c_int, ctypes.c_int, ctypes.c_double, numbers, numbers),
        *(size, numbers, ctypes.c_double, ctypes.c_long, numbers, numbers),
    ]
    return library
