"""Functions that worker processes import: they judge bodies, and make scenes."""

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid

SIGNATURE: Any = ctypes.CFUNCTYPE(None, ctypes.c_double, *4 * [ctypes.POINTER(ctypes.c_double)])


def keeps_its_sign(states: rigid.States) -> NDArray[np.bool_]:
    """As ``no_flip(2)``, as far as the looks tell."""
    kept: NDArray[np.bool_] = np.all(states.omega[..., 1] > 0.0, axis=1)
    return kept


def bodies(length: NDArray[np.float64]) -> rigid.FreeBody:
    """Rods of these lengths with a fin."""
    return rigid.FreeBody(rigid.Body(np.stack([length, 1.3 * length, 2.0 + 0.1 * length], axis=-1)))


@SIGNATURE  # type: ignore[untyped-decorator]
def _slows(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -data[0] * omega[k]


def damped_by_machine_code(gain: NDArray[np.float64]) -> rigid.FreeBody:
    """Bodies that a function of ctypes damps."""
    torque = rigid.Torque.call(_slows, gain[:, np.newaxis], fastest=4.0)
    return rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=torque)
