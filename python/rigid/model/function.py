"""A callback: a compiled function that returns a torque, known by its address."""

from __future__ import annotations

import ctypes
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, shaped, whole
from .._checks.arrays import Floats
from .._core import MOST_STATES
from .batch import ByValue, Index, Shape, axes_of, batch_shape, frozen, taken
from .compiling import UNKNOWN, Callback, of_python

NO_STATES = "states: the scene has none; give Torque.call(..., states=k)"


def require_orbit(name: str, orbit: object) -> None:
    """Raise ValueError if there is no orbit whose place a function can be told."""
    if orbit is None:
        raise ValueError(f"orbit_position: {name} takes it, but the scene has no orbit")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TorqueFunction(ByValue):
    """A callback that returns a torque; made by :meth:`Torque.call`.

    Attributes
    ----------
    callback : Callback
        What the core calls.
    data : ndarray of shape (..., k), or None
        The numbers that it is given, of all bodies or of each.
    fastest : float or None
        A bound of the rates under this torque (rad/s).
    start : ndarray of shape (..., k), or None
        The states at the start, of all bodies or of each; None without states.
    """

    callback: Callback
    data: Floats | None = None
    fastest: float | None = None
    start: Floats | None = None

    @classmethod
    def of_input(
        cls, function: object, data: ArrayLike | None, fastest: float | None, states: int
    ) -> Self:
        """A function of Python or that at an address, with its data and so many states.

        Raises
        ------
        TypeError, ValueError
            If it is neither, data or bound are not finite, or the states are too many.
        """
        count = whole("states", states)
        if not 0 <= count <= MOST_STATES:
            raise ValueError(f"states = {states}: must lie in 0 to {MOST_STATES} for each body")
        numbers = None
        if data is not None:
            numbers = shaped("data", data)
            if not numbers.ndim or not numbers.size:
                raise ValueError(f"data: expected shape (..., k) with numbers, got {numbers.shape}")
            numbers = frozen(np.ascontiguousarray(numbers))
        bound = None
        if fastest is not None:
            bound = finite_float("fastest", fastest, positive=True, unit="rad/s")
        width = 0 if numbers is None else numbers.shape[-1]
        start = frozen(np.zeros(count)) if count else None
        return cls(_callback(function, width, count), numbers, bound, start)

    @property
    def states(self) -> int:
        """How many states each body has."""
        return 0 if self.start is None else self.start.shape[-1]

    def started(self, states: ArrayLike) -> Self:
        """The function with these states at the start, shape (k,) or (..., k).

        Raises
        ------
        ValueError
            If there are none, or not as many.
        """
        start = shaped("states", states)
        if self.start is None:
            raise ValueError(NO_STATES)
        if start.shape[-1:] != (self.states,):
            raise ValueError(f"states: expected shape (..., {self.states}), got {start.shape}")
        return dataclasses.replace(self, start=frozen(np.ascontiguousarray(start)))

    @property
    def is_known(self) -> bool:
        """Whether it can be called: one that was read from a file cannot."""
        return self.callback.address != 0

    @property
    def reasons(self) -> tuple[str, ...]:
        """What a plan says of the function: nothing if it is compiled."""
        why = self.callback.why_slow
        if why is None:
            return ()
        return (f"Python calls the torque, some 5 µs for each body and stage: {why}",)

    def check_place(self, orbit: object) -> None:
        """Raise ValueError if it asks for a place, but there is no orbit."""
        if self.callback.asks_place:
            require_orbit("the function", orbit)

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` if all have the same data and start."""
        return batch_shape({"data": axes_of(self.data, 1), "states": axes_of(self.start, 1)})

    def of(self, shape: Shape, index: Index) -> TorqueFunction:
        """The function with the data of some of the bodies of this shape."""
        if not self.shape:
            return self
        data, start = (
            frozen(taken(part, 1, shape, index)) if axes_of(part, 1) else part
            for part in (self.data, self.start)
        )
        return dataclasses.replace(self, data=data, start=start)

    def for_core(
        self, shape: Shape, exponents: NDArray[np.intc]
    ) -> tuple[int, bool, bool, Floats, Floats, float, Floats]:
        """Address, whether it is told eight and more, data, units, the bound, and the start."""

        def rows(values: Floats | None) -> Floats:
            if values is None:
                return np.empty((0, 0))
            lead = shape if axes_of(values, 1) else ()
            each = np.broadcast_to(values, (*lead, values.shape[-1]))
            return np.ascontiguousarray(each).reshape(-1, values.shape[-1])

        how, units = self.callback, np.ldexp(1.0, -exponents)
        known = rows(self.data), units, self.fastest or 0.0, rows(self.start)
        return how.address, how.of_eight, how.is_long, *known

    def to_dict(self) -> dict[str, Any]:
        """The parts of the callback that a file may hold: all but its address."""
        data = None if self.data is None else self.data.tolist()
        entries = {"data": data, "fastest": self.fastest}
        return entries if self.start is None else {**entries, "states": self.start.tolist()}

    @classmethod
    def from_dict(cls, entries: Mapping[str, Any]) -> Self:
        """The callback that :meth:`to_dict` described; it cannot be called."""
        data, start = (
            None if given is None else frozen(np.array(given))
            for given in (entries["data"], entries.get("states"))
        )
        return cls(UNKNOWN, data, entries["fastest"], start)

    def __reduce__(self) -> tuple[Any, ...]:
        """The callback for another process, with other addresses: it cannot be called there."""
        return type(self), (UNKNOWN, self.data, self.fastest, self.start)

    def __deepcopy__(self, memo: object) -> Self:
        return self  # nothing of it changes

    def __repr__(self) -> str:
        data = "" if self.data is None else f", data of shape {self.data.shape}"
        states = f", {self.states} states" if self.states else ""
        return f"function at {self.callback.address:#x}{data}{states}"


_ARGUMENTS = ("double", *4 * ("double *",))
"""The arguments of a callback in C."""

_LONG_ARGUMENTS = (*_ARGUMENTS, *3 * ("double *",))
"""The arguments of one that is told states and the place on the orbit."""

_IN_C = {
    **{"float64": "double", "float64*": "double *", "void*": "double *"},
    **{"c_double": "double", "LP_c_double": "double *", "c_void_p": "double *"},
}
"""Types of C by their names in numba and ctypes."""


def _is_long(function: Any, kinds: Iterable[str], result: str, states: int) -> bool:
    """Whether a function of C is told states and the place on the orbit.

    TypeError for a function of other arguments: it would read memory of others.
    """
    given = tuple(_IN_C.get(kind, kind) for kind in kinds)
    wanted = _LONG_ARGUMENTS if states or len(given) == len(_LONG_ARGUMENTS) else _ARGUMENTS
    if given != wanted or result not in ("none", "None", "void"):
        raise TypeError(
            f"address = {brief(function)}: must take ({', '.join(wanted)}) and return nothing; "
            f"it takes ({', '.join(given)}) and returns {result}"
        )
    return wanted is _LONG_ARGUMENTS


def _callback(function: Any, width: int, states: int) -> Callback:
    """The callback of a function of Python, numba, ctypes or cffi, or at an address."""
    kinds, result = None, "None"
    found = getattr(function, "address", function)
    if type(found).__module__ == "_cffi_backend":
        import cffi

        kind = cffi.FFI().typeof(found)
        if kind.kind == "function":
            kinds, result = [one.cname for one in kind.args], kind.result.cname
        found = int(cffi.FFI().cast("intptr_t", found))
    elif hasattr(function, "_sig"):
        kinds, result = [*map(str, function._sig.args)], str(function._sig.return_type)
    elif getattr(function, "argtypes", None) is not None:  # a library tells none
        kinds = [kind.__name__ for kind in function.argtypes]
        result = getattr(function.restype, "__name__", "None")
    is_long = states > 0 if kinds is None else _is_long(function, kinds, result, states)
    if callable(found):
        try:
            found = ctypes.cast(found, ctypes.c_void_p).value
        except ctypes.ArgumentError:
            return of_python(function, width, states)
    if isinstance(found, bool) or not isinstance(found, (int, np.integer)):
        raise TypeError(
            f"address = {brief(function)}: must be a function or the address of one, an int"
        )
    if not 0 < found < 2**63:
        raise ValueError(f"address = {found}: must be the address of a function")
    return Callback(int(found), False, function, is_long=is_long)
