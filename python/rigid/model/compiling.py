"""A function of Python as a callback: compiled by numba, or called for each body.

numba compiles the function into a loop over eight bodies, which the core calls once for all of
them. Without numba ctypes makes a callback of one body, which takes the lock of the interpreter.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from .._checks.arguments import brief
from .._checks.extras import install_extra
from .._checks.warned import warn_caller
from .._core import BODIES_OF_A_FUNCTION, BODIES_OF_A_ROW

DOUBLES = ctypes.POINTER(ctypes.c_double)

_ARGUMENTS = "t, omega, attitude, data, torque"

_OF_STATES = "states, rates"
"""Further arguments of a function that has states."""

_PLACE = "orbit_position"
"""The name of a last argument by which a function asks for the place of the body on its orbit."""


@dataclass(frozen=True, slots=True)
class Callback:
    """A function that the core can call, known by its address.

    Attributes
    ----------
    address : int
        Where it is; 0 if it was read from a file, which has none.
    of_eight : bool
        Whether it is told eight bodies at once.
    kept : object
        What must live as long as it is called.
    why_slow : str or None
        Why Python calls it for each body, if it does.
    is_long : bool
        Whether it is told states and the place on the orbit.
    asks_place : bool
        Whether it needs an orbit.
    """

    address: int
    of_eight: bool = field(default=False, compare=False)
    kept: object = field(default=None, compare=False)
    why_slow: str | None = field(default=None, compare=False)
    is_long: bool = field(default=False, compare=False)
    asks_place: bool = field(default=False, compare=False)


UNKNOWN = Callback(0)
"""The callback of a file, which cannot be called."""


def of_python(function: Callable[..., object], width: int, states: int) -> Callback:
    """The callback of a function ``f(t, omega, attitude, data, torque)`` with so many data.

    Parameters
    ----------
    function : callable
        A function of Python, or one that numba compiles when it is called.
    width : int
        How many numbers each body has.
    states : int
        How many states each body has: a function of some takes ``states, rates`` too.

    Raises
    ------
    TypeError
        If the function takes other arguments.

    Warns
    -----
    UserWarning
        If numba is installed, but cannot compile the function.
    """
    wanted = f"{_ARGUMENTS}, {_OF_STATES}" if states else _ARGUMENTS
    try:
        signature = inspect.signature(getattr(function, "py_func", function))
        asks_place = list(signature.parameters)[-1:] == [_PLACE]
        signature.bind(*(f"{wanted}, {_PLACE}" if asks_place else wanted).split(", "))
    except (TypeError, ValueError):
        raise TypeError(
            f"address = {brief(function)}: must take ({wanted}), or be the address of a compiled "
            f"function; {_PLACE} may come last"
        ) from None
    return _made(function, width, states, asks_place)


@lru_cache(maxsize=64)
def _made(function: Callable[..., object], width: int, states: int, asks_place: bool) -> Callback:
    """The callback of a function, made once: to compile takes a second."""
    try:
        import numba
    except ImportError:
        why = install_extra("to compile it needs numba", "numba")
        return _called(function, width, states, asks_place, why)
    config: Any = numba.config
    if config.DISABLE_JIT:
        why = "numba does not compile: NUMBA_DISABLE_JIT is set"
        return _called(function, width, states, asks_place, why)
    try:
        made = _compiled(numba, function, width, states, asks_place)
    except Exception as error:  # numba raises its own, and what its parts raise
        reason = next(iter(str(error).strip().splitlines()), type(error).__name__)
        why = f"numba cannot compile it: {reason}"
        warn_caller(f"torque = {brief(function)}: Python calls it, because {why}")
        return _called(function, width, states, asks_place, why)
    is_long = states > 0 or asks_place
    return Callback(made.address, True, made, is_long=is_long, asks_place=asks_place)


def _told(one: Callable[..., object], states: int, asks_place: bool) -> Callable[..., object]:
    """A function of all arguments that calls one of those that it takes."""

    def all_of_them(
        t: Any, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rates: Any, place: Any
    ) -> None:
        one(t, omega, attitude, data, torque, own, rates, place)

    def with_states(
        t: Any, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rates: Any, place: Any
    ) -> None:
        one(t, omega, attitude, data, torque, own, rates)

    def with_place(
        t: Any, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rates: Any, place: Any
    ) -> None:
        one(t, omega, attitude, data, torque, place)

    if not asks_place:
        return with_states
    return all_of_them if states else with_place


def _compiled(
    numba: Any, function: Callable[..., object], width: int, states: int, asks_place: bool
) -> Any:
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
    if not states and not asks_place:
        return numba.cfunc(numba.void(*[doubles] * 5), error_model="numpy")(each)
    every = numba.njit(error_model="numpy")(_told(one, states, asks_place))

    def each_long(
        t: Any, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rate: Any, place: Any
    ) -> None:
        times, rates = carray(t, eight), carray(omega, (3, eight))
        attitudes, torques = carray(attitude, (4, eight)), carray(torque, (3, eight))
        numbers, places = carray(data, (width, row)), carray(place, (3, eight))
        owns, changes = carray(own, (states, eight)), carray(rate, (states, eight))
        for i in range(eight):
            every(
                times[i],
                rates[:, i],
                attitudes[:, i],
                numbers[:, i],
                torques[:, i],
                owns[:, i],
                changes[:, i],
                places[:, i],
            )

    return numba.cfunc(numba.void(*[doubles] * 8), error_model="numpy")(each_long)


def _called(
    function: Callable[..., object],
    width: int,
    states: int,
    asks_place: bool,
    why: str,
) -> Callback:
    """The function as it is, told new arrays."""
    is_long = states > 0 or asks_place

    def copied(numbers: Any, length: int) -> Any:
        # A pointer without numbers is null.
        return np.array(numbers[:length]) if length else np.empty(0)

    def one(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        returned = np.full(3, np.nan)
        function(t, copied(omega, 3), copied(attitude, 4), copied(data, width), returned)
        torque[0], torque[1], torque[2] = returned

    every = _told(function, states, asks_place)

    def one_long(
        t: float, omega: Any, attitude: Any, data: Any, torque: Any, own: Any, rate: Any, place: Any
    ) -> None:
        returned, rates = np.full(3, np.nan), np.full(states, np.nan)
        known = copied(omega, 3), copied(attitude, 4), copied(data, width)
        every(t, *known, returned, copied(own, states), rates, copied(place, 3))
        torque[0], torque[1], torque[2] = returned
        for k in range(states):
            rate[k] = rates[k]

    pointers = [DOUBLES] * (7 if is_long else 4)
    kept = ctypes.CFUNCTYPE(None, ctypes.c_double, *pointers)(one_long if is_long else one)
    address = ctypes.cast(kept, ctypes.c_void_p).value
    assert address is not None
    return Callback(address, False, kept, why, is_long, asks_place)
