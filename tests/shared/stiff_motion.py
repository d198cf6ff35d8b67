"""Motions under damping of any strength: a truth whose steps do not follow the damping.

``stiff_motion.c`` is a collocation in 80-bit numbers. It shares no line with the library, nor with
:mod:`quad_motion`, with which a test compares it.
"""

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import mpmath as mp
import numpy as np
from numpy.typing import ArrayLike

from physics import Floats
from quad_motion import RECORD, Motion, applied
from rigid.model.scene import Scene

SOURCE = Path(__file__).with_suffix(".c")

#: Stages of the method; its order is 13.
STAGES = 7

#: The seventh Legendre coefficient of a step, relative to the state. Its square is about the error.
TOLERANCE = 1e-12

#: Rates below this share of what the body can reach are known to this share.
REST = 1e-16


@cache
def _table() -> tuple[Floats, Floats]:
    """Nodes, matrix and Legendre weights, each number as the sum of two doubles."""
    with mp.workdps(50):
        # The nodes of Radau are the zeros of the derivative of order s - 1 of x^(s-1) (x-1)^s.
        powers = [mp.mpf(0)] * (STAGES - 1)
        powers += [(-1) ** (STAGES - j) * mp.binomial(STAGES, j) for j in range(STAGES + 1)]
        for _ in range(STAGES - 1):
            powers = [n * one for n, one in enumerate(powers)][1:]
        near = np.sort(np.polynomial.Polynomial([float(power) for power in powers]).roots().real)

        def radau(x: mp.mpf) -> mp.mpf:
            return mp.fsum(power * x**n for n, power in enumerate(powers))

        nodes = [*(mp.findroot(radau, mp.mpf(float(zero))) for zero in near[:-1]), mp.mpf(1)]
        size = range(STAGES)
        values = mp.matrix([[nodes[i] ** j for j in size] for i in size])
        integrals = mp.matrix([[nodes[i] ** (j + 1) / (j + 1) for j in size] for i in size])
        stages = integrals * values**-1
        leading = mp.binomial(2 * STAGES, STAGES)  # of the Legendre polynomial on 0 .. 1
        last = [
            1 / (leading * nodes[i] * mp.fprod(nodes[i] - nodes[j] for j in size if j != i))
            for i in size
        ]
        numbers = [*nodes, *(stages[i, j] for i in size for j in size), *last]
        high = [float(number) for number in numbers]
        low = [float(number - one) for number, one in zip(numbers, high, strict=True)]
    return np.array(high), np.array(low)


@cache
def _library() -> ctypes.CDLL:
    compiler = shutil.which("cc")
    assert compiler is not None, "there is no C compiler"
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, "stiff_motion.so")
        command = [compiler, "-O2", "-shared", "-fPIC", str(SOURCE), "-o", str(made), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        library = ctypes.CDLL(str(made))
    numbers, size = np.ctypeslib.ndpointer(np.float64, flags="C"), ctypes.c_ssize_t
    library.stiff_motion.restype = ctypes.c_long
    library.stiff_motion.argtypes = [
        *(numbers, numbers, numbers, size, numbers, numbers, numbers, numbers, numbers),
        *(size, numbers, ctypes.c_double, ctypes.c_double, ctypes.c_long),
        *(numbers, numbers, numbers, numbers),
    ]
    return library


def motion(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike,
    times: ArrayLike,
    *,
    tolerance: float = TOLERANCE,
    limit: int = 3000,
) -> Motion | None:
    """The states at ascending times, none below 0; None beyond a limit of steps."""
    assert not scene.further(), "the reference has no rotor, sink, drag and orbit"
    damping, knots, body, space = applied(scene)
    start, output = np.array(omega, dtype=np.float64), np.array(times, dtype=np.float64)
    largest = np.linalg.norm(scene.weight) + np.abs([body, space]).max()
    rest = REST * (np.linalg.norm(start) + np.sqrt(largest / min(scene.body.moments)))
    records = np.empty((2, len(output), RECORD))
    steps = _library().stiff_motion(
        *(np.array(scene.body.moments), np.ascontiguousarray(scene.weight), damping),
        *(len(knots), knots, body, space, start, np.array(attitude, dtype=np.float64)),
        *(len(output), output, rest, tolerance, limit, *_table(), records[0], records[1]),
    )
    return None if steps < 0 else Motion(*records)
