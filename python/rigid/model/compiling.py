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
from typing import Any, NamedTuple

import numpy as np

from .._checks.arguments import brief
from .._checks.extras import install_extra
from .._checks.warned import warn_caller
from .._core import BODIES_OF_A_FUNCTION, BODIES_OF_A_ROW

DOUBLES = ctypes.POINTER(ctypes.c_double)

_ARGUMENTS = "t, omega, attitude, data, torque"

_OF_VALUE = "t, omega, attitude"
"""Arguments of a function of the state."""

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
    rule = f"must take ({wanted}), or be the address of a compiled function; {_PLACE} may come last"
    _, asks_place = _known("address", function, (wanted,), rule)
    return _made(function, Taken(width, states, asks_place, False))


def of_state(function: Callable[..., object], states: int) -> Callback:
    """The callback of a function ``f(t, omega, attitude)`` of a body with so many states.

    Warns
    -----
    UserWarning
        As :func:`of_python`.
    """
    takes_states, asks_place = taken_by(function)
    return _made(function, Taken(0, states if takes_states else 0, asks_place, True))


def taken_by(function: Callable[..., object]) -> tuple[bool, bool]:
    """Whether a function of the state takes states, and the place on the orbit.

    Raises
    ------
    TypeError
        If it takes other arguments.
    """
    known = _OF_VALUE, f"{_OF_VALUE}, states"
    rule = f"must take ({_OF_VALUE}), or also states; {_PLACE} may come last"
    place, asks_place = _known("name", function, known, rule)
    return place == 1, asks_place


def _known(
    name: str, function: Callable[..., object], known: tuple[str, ...], rule: str
) -> tuple[int, bool]:
    """Which of these arguments a function takes, and whether its place comes last."""
    try:
        signature = inspect.signature(getattr(function, "py_func", function))
    except (TypeError, ValueError):
        signature = inspect.Signature()
    asks_place = list(signature.parameters)[-1:] == [_PLACE]
    for index, taken in enumerate(known):
        try:
            signature.bind(*(f"{taken}, {_PLACE}" if asks_place else taken).split(", "))
        except TypeError:
            continue
        return index, asks_place
    raise TypeError(f"{name} = {brief(function)}: {rule}")


class Taken(NamedTuple):
    """What a function takes: numbers, states, the place; and whether it returns a number.

    The number is written as the first of a torque.
    """

    width: int
    states: int
    asks_place: bool
    is_value: bool

    @property
    def is_long(self) -> bool:
        """Whether the core tells states and place."""
        return self.states > 0 or self.asks_place or self.is_value

    @property
    def others(self) -> tuple[int, int]:
        """From where to where it takes states, their rates and the place."""
        return 0 if self.states else 2, 3 if self.asks_place else 2


@lru_cache(maxsize=64)
def _made(function: Callable[..., object], taken: Taken) -> Callback:
    """The callback of a function, made once: to compile takes a second."""
    try:
        import numba
    except ImportError:
        why = install_extra("to compile it needs numba", "numba")
        return _called(function, taken, why)
    config: Any = numba.config
    if config.DISABLE_JIT:
        why = "numba does not compile: NUMBA_DISABLE_JIT is set"
        return _called(function, taken, why)
    try:
        made = _compiled(numba, function, taken)
    except Exception as error:  # numba raises its own, and what its parts raise
        reason = next(iter(str(error).strip().splitlines()), type(error).__name__)
        why = f"numba cannot compile it: {reason}"
        what = "event" if taken.is_value else "torque"
        warn_caller(f"{what} = {brief(function)}: Python calls it, because {why}")
        return _called(function, taken, why)
    return Callback(made.address, True, made, is_long=taken.is_long, asks_place=taken.asks_place)


def _told(one: Callable[..., Any], taken: Taken) -> Callable[..., object]:
    """A function of all arguments that calls one of those that it takes."""
    first, last = taken.others

    def every(t: Any, omega: Any, attitude: Any, data: Any, torque: Any, *others: Any) -> None:
        one(t, omega, attitude, data, torque, *others[first:last])

    def value(t: Any, omega: Any, attitude: Any, data: Any, torque: Any, *others: Any) -> None:
        torque[0] = one(t, omega, attitude, *others[first:last:2])

    return value if taken.is_value else every


def _compiled(numba: Any, function: Callable[..., object], taken: Taken) -> Any:
    """A loop over eight bodies whose numbers stand side by side, row by row."""
    one = function if hasattr(function, "py_func") else numba.njit(error_model="numpy")(function)
    width, states = taken.width, taken.states
    carray, eight, row = numba.carray, BODIES_OF_A_FUNCTION, BODIES_OF_A_ROW

    def each(t: Any, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
        times, rates = carray(t, eight), carray(omega, (3, eight))
        attitudes, torques = carray(attitude, (4, eight)), carray(torque, (3, eight))
        numbers = carray(data, (width, row))
        for i in range(eight):
            one(times[i], rates[:, i], attitudes[:, i], numbers[:, i], torques[:, i])

    doubles = numba.types.CPointer(numba.float64)
    if not taken.is_long:
        return numba.cfunc(numba.void(*[doubles] * 5), error_model="numpy")(each)
    every = numba.njit(error_model="numpy")(_told(one, taken))

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


def _called(function: Callable[..., object], taken: Taken, why: str) -> Callback:
    """The function as it is, told new arrays."""
    width, states = taken.width, taken.states

    def copied(numbers: Any, length: int) -> Any:
        # A pointer without numbers is null.
        return np.array(numbers[:length]) if length else np.empty(0)

    every = _told(function, taken)

    def one(t: float, omega: Any, attitude: Any, data: Any, torque: Any, *others: Any) -> None:
        returned, rates = np.full(3, np.nan), np.full(states, np.nan)
        known = copied(omega, 3), copied(attitude, 4), copied(data, width)
        own = [copied(others[0], states), rates, copied(others[2], 3)] if others else []
        every(t, *known, returned, *own)
        torque[0], torque[1], torque[2] = returned
        for k in range(states):
            others[1][k] = rates[k]

    pointers = [DOUBLES] * (7 if taken.is_long else 4)
    kept = ctypes.CFUNCTYPE(None, ctypes.c_double, *pointers)(one)
    address = ctypes.cast(kept, ctypes.c_void_p).value
    assert address is not None
    return Callback(address, False, kept, why, taken.is_long, taken.asks_place)
