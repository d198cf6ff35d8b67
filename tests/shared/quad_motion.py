"""Motions in numbers of 128 or 80 bits: the truth of scenes that have no reference trajectory.

``quad_motion.c`` shares no line with the library; ``test_stated_errors.py`` compares it with the
reference trajectories. The C compiler must know ``__float128``, as GCC does on x86-64.
"""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from physics import Floats
from rigid.model.forces import FORCES
from rigid.model.scene import Scene

SOURCE = Path(__file__).with_suffix(".c")

#: Last terms of the series, relative to the state.
TOLERANCE = 1e-32

#: Arguments of :func:`motion` for numbers of 80 bits: 30 times faster, and their rounding is a
#: two-thousandth of that of a run.
FAST: Mapping[str, Any] = {"tolerance": 1e-22, "number": "long double"}

#: Numbers of a record: rates, quaternion, vertical in the body, work.
RECORD = 11


class NoQuadNumbersError(Exception):
    """The compiler of this machine has no 128-bit numbers, or there is no compiler."""


@dataclass(frozen=True)
class Motion:
    """States of a body, each number as the sum of two doubles, ``high`` and ``low``."""

    high: Floats
    low: Floats

    @property
    def omega(self) -> Floats:
        return self.high[:, :3]

    def state(self, row: int) -> tuple[list[float], list[float]]:
        """The high and the low parts of rates and attitude at one time."""
        return self.high[row, :7].tolist(), self.low[row, :7].tolist()

    def rates_off(self, omega: Floats) -> Floats:
        """``|omega - true|``, shape (m,); infinite where rates that diverged overflow."""
        with np.errstate(over="ignore"):
            distance: Floats = np.linalg.norm(omega - self.high[:, :3] - self.low[:, :3], axis=-1)
        return distance

    def gamma_off(self, gamma: Floats) -> Floats:
        """Distance of the vertical in the body from the true one, shape (m,)."""
        distance: Floats = np.linalg.norm(gamma - self.high[:, 7:10] - self.low[:, 7:10], axis=-1)
        return distance

    def attitude_off(self, attitude: Floats) -> Floats:
        """Angle to the true attitude (rad), small ones without cancellation, shape (m,)."""
        true, low = self.high[:, 3:7], self.low[:, 3:7]
        sign = np.where((attitude * true).sum(axis=-1) < 0.0, -1.0, 1.0)
        off = sign[:, None] * attitude - true - low
        w, v = true[:, :1], true[:, 1:]
        turn = w * off[:, 1:] - off[:, :1] * v - np.cross(v, off[:, 1:])
        cosine = 1.0 + (true * off).sum(axis=-1)
        angle: Floats = 2.0 * np.arctan2(np.linalg.norm(turn, axis=-1), np.abs(cosine))
        return angle

    def work_off(self, work: Floats) -> Floats:
        """``|work - true|`` (J), shape (m,)."""
        distance: Floats = np.abs(work - self.high[:, 10] - self.low[:, 10])
        return distance


def compiled(source: Path, number: str = "__float128") -> ctypes.CDLL:
    """The library of a C file whose numbers have this type."""
    compiler = shutil.which("cc")
    if compiler is None:
        raise NoQuadNumbersError("there is no C compiler")
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "made.so")
        command = [compiler, "-O1", "-shared", "-fPIC", f"-DNUMBER={number}"]
        command += [str(source), "-o", str(made), "-lm"]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            raise NoQuadNumbersError(done.stderr)
        return ctypes.CDLL(str(made))


@cache
def _library(number: str = "__float128") -> ctypes.CDLL:
    library = compiled(SOURCE, number)
    numbers, size = np.ctypeslib.ndpointer(np.float64, flags="C"), ctypes.c_ssize_t
    library.motion.restype = ctypes.c_long
    library.motion.argtypes = [
        *(numbers, numbers, numbers, size),
        *(numbers, numbers, numbers, numbers, numbers, numbers, numbers),
        *(size, numbers, ctypes.c_double, ctypes.c_long, numbers, numbers),
    ]
    return library


def called() -> int:
    """The address of a function for :meth:`rigid.Torque.call` whose torque is known here too.

    Of its 13 numbers the first 4 are a push and its rate, then 3 each a cubic damping along the
    axes, a dipole in the body and a field in space.
    """
    address = ctypes.cast(_library().called, ctypes.c_void_p).value
    assert address is not None
    return address


def is_available() -> bool:
    """Whether there is a C compiler that knows 128-bit numbers."""
    try:
        _library()
    except NoQuadNumbersError:
        return False
    return True


def applied(scene: Scene) -> tuple[Floats, Floats, Floats, Floats]:
    """Damping, shape (9,), and times and torques in the body and in space of a table."""
    torque, damping = scene.torque, np.zeros(9)
    if scene.damping is not None:
        damping = np.array(scene.damping).ravel()
    knots = np.array(torque.times if torque else (), dtype=np.float64)
    body, space = (
        np.array(values, dtype=np.float64).reshape(-1, 3)
        for values in ((torque.in_body, torque.in_space) if torque else (np.zeros(3), np.zeros(3)))
    )
    return damping, knots, body, space


def motion(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike,
    times: ArrayLike,
    *,
    moments: ArrayLike | None = None,
    weight: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    limit: int = 10**5,
    number: str = "__float128",
) -> Motion | None:
    """The states at ascending times; None beyond a limit of steps.

    All numbers are read as the doubles they are; the quaternion is normalised exactly. ``moments``
    and ``weight`` stand for those of the scene, ``number`` is the type of all numbers in C.
    """
    torque = scene.torque
    damping, knots, body, space = applied(scene)
    further = np.zeros(18)
    for place, name in enumerate(("rotor", "dissipation", "drag")):
        value = getattr(scene, name)
        if value is not None:
            further[3 * place : 3 * place + 3] = FORCES[name].numbers(value)
    orbit = getattr(scene, "orbit", None)
    if orbit is not None:
        further[9:] = orbit.numbers
    function = np.zeros(13)
    if torque is not None and torque.function is not None:
        assert torque.function.callback.address == called(), "no other function is known here"
        function = np.array(torque.function.data)
    output = np.array(times, dtype=np.float64)
    high, low = np.empty((2, len(output), RECORD))
    for side, outward in ((output < 0.0, slice(None, None, -1)), (output >= 0.0, slice(None))):
        if not side.any():
            continue
        there = np.ascontiguousarray(output[side][outward])
        records = np.empty((2, len(there), RECORD))
        steps = _library(number).motion(
            *(np.ascontiguousarray(scene.body.moments if moments is None else moments),),
            *(np.ascontiguousarray(scene.weight if weight is None else weight), damping),
            *(len(knots), knots, body, space, further, function),
            *(np.array(omega, dtype=np.float64), np.array(attitude, dtype=np.float64)),
            *(len(there), there, tolerance, limit, records[0], records[1]),
        )
        if steps < 0:
            return None
        high[side], low[side] = records[:, outward]
    return Motion(high, low)
