"""A function of Python as a callback: compiled by numba, or called for each body.

numba compiles the function into a loop over eight bodies, which the core calls once for all of
them. Without numba ctypes makes a callback of one body, which takes the lock of the interpreter.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .._checks.arguments import brief
from .._checks.extras import install_extra
from .._checks.warned import warn_caller
from .._core import BODIES_OF_A_FUNCTION, BODIES_OF_A_ROW

DOUBLES = ctypes.POINTER(ctypes.c_double)

_ARGUMENTS = "t, omega, attitude, data, torque"


@dataclass(frozen=True, slots=True)
class Callback:
    """A function that the core can call.

    Attributes
    ----------
    address : int
        Where it is.
    of_eight : bool
        Whether it is told eight bodies at once.
    kept : object
        What must live as long as it is called.
    why_slow : str or None
        Why Python calls it for each body, if it does.
    """

    address: int
    of_eight: bool
    kept: object
    why_slow: str | None = None


def of_python(function: Callable[..., object], width: int) -> Callback:
    """The callback of a function ``f(t, omega, attitude, data, torque)`` with so many data.

    Parameters
    ----------
    function : callable
        A function of Python, or one that numba compiles when it is called.
    width : int
        How many numbers each body has.

    Raises
    ------
    TypeError
        If the function takes other arguments.

    Warns
    -----
    UserWarning
        If numba is installed, but cannot compile the function.
    """
    try:
        inspect.signature(getattr(function, "py_func", function)).bind(*_ARGUMENTS.split(", "))
    except (TypeError, ValueError):
        raise TypeError(
            f"address = {brief(function)}: must take ({_ARGUMENTS}), or be the address of a "
            "compiled function"
        ) from None
    return _made(function, width)


@lru_cache(maxsize=64)
def _made(function: Callable[..., object], width: int) -> Callback:
    """The callback of a function, made once: to compile takes a second."""
    try:
        import numba
    except ImportError:
        why = install_extra("to compile it needs numba", "numba")
        return _called(function, width, why)
    config: Any = numba.config
    if config.DISABLE_JIT:
        return _called(function, width, "numba does not compile: NUMBA_DISABLE_JIT is set")
    try:
        made = _compiled(numba, function, width)
    except Exception as error:  # numba raises its own, and what its parts raise
        reason = next(iter(str(error).strip().splitlines()), type(error).__name__)
        why = f"numba cannot compile it: {reason}"
        warn_caller(f"torque = {brief(function)}: Python calls it, because {why}")
        return _called(function, width, why)
    return Callback(made.address, True, made)


def _compiled(numba: Any, function: Callable[..., object], width: int) -> Any:
    """A loop over eight bodies whose numbers stand side by side, row by row."""
    one = function if hasattr(function, "py_func") else numba.njit(error_model="numpy")(function)
    carray, eight, row = numba.carray, BODIES_OF_A_FUNCTION, BODIES_OF_A_ROW

    def each(t: Any, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        times, rates = carray(t, eight), carray(omega, (3, eight))
        attitudes, torques = carray(attitude, (4, eight)), carray(torque, (3, eight))
        numbers = carray(data, (width, row))
        for i in range(eight):
            one(times[i], rates[:, i], attitudes[:, i], numbers[:, i], torques[:, i])

    doubles = numba.types.CPointer(numba.float64)
    return numba.cfunc(numba.void(*[doubles] * 5), error_model="numpy")(each)


def _called(function: Callable[..., object], width: int, why: str) -> Callback:
    """The function as it is, told new arrays."""

    def one(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        numbers = np.array(data[:width]) if width else np.empty(0)
        returned = np.full(3, np.nan)
        function(t, np.array(omega[:3]), np.array(attitude[:4]), numbers, returned)
        torque[0], torque[1], torque[2] = returned

    kept = ctypes.CFUNCTYPE(None, ctypes.c_double, *[DOUBLES] * 4)(one)
    address = ctypes.cast(kept, ctypes.c_void_p).value
    assert address is not None
    return Callback(address, False, kept, why)
