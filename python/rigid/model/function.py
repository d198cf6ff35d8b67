"""A callback: a compiled function that returns a torque, known by its address."""

from __future__ import annotations

import ctypes
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, shaped
from .compiling import Callback, of_python
from .leading import Index, Shape, axes_of, frozen, same, taken

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TorqueFunction:
    """A callback that returns a torque; made by :meth:`Torque.call`.

    Attributes
    ----------
    address : int
        Address of the function; 0 if it was read from a file, which has none.
    data : ndarray of shape (..., k), or None
        The numbers that it is given, of all bodies or of each.
    fastest : float or None
        A bound of the rates under this torque (rad/s).
    kept : object
        The given function, kept alive as long as this object.
    of_eight : bool
        Whether the function is told eight bodies at once.
    why_slow : str or None
        Why Python calls the function for each body, if it does.
    """

    address: int
    data: Floats | None = None
    fastest: float | None = None
    kept: object = None
    of_eight: bool = False
    why_slow: str | None = None

    @classmethod
    def of_input(cls, function: object, data: ArrayLike | None, fastest: float | None) -> Self:
        """A function of Python or that at an address, with its data.

        Raises
        ------
        TypeError, ValueError
            If it is neither, or data or bound are not finite.
        """
        numbers = None
        if data is not None:
            numbers = shaped("data", data)
            if not numbers.ndim or not numbers.size:
                raise ValueError(f"data: expected shape (..., k) with numbers, got {numbers.shape}")
            numbers = frozen(np.ascontiguousarray(numbers))
        bound = None
        if fastest is not None:
            bound = finite_float("fastest", fastest, positive=True, unit="rad/s")
        made = _callback(function, 0 if numbers is None else numbers.shape[-1])
        return cls(
            made.address, numbers, bound, (function, made.kept), made.of_eight, made.why_slow
        )

    @property
    def reasons(self) -> tuple[str, ...]:
        """What a plan says of the function: nothing if it is compiled."""
        if self.why_slow is None:
            return ()
        return (f"Python calls the torque, some 5 µs for each body and stage: {self.why_slow}",)

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` if all have the same data."""
        return axes_of(self.data, 1)

    def of(self, shape: Shape, index: Index) -> TorqueFunction:
        """The function with the data of some of the bodies of this shape."""
        if not self.shape:
            return self
        data = frozen(taken(self.data, 1, shape, index))
        return dataclasses.replace(self, data=data)

    def for_core(
        self, shape: Shape, exponents: NDArray[np.intc]
    ) -> tuple[int, bool, Floats, Floats, float]:
        """Address, whether it is told eight, rows of data, units of the torque and the bound."""
        rows = np.empty((0, 0))
        if self.data is not None:
            width = self.data.shape[-1]
            lead = shape if self.shape else ()
            rows = np.ascontiguousarray(np.broadcast_to(self.data, (*lead, width)))
            rows = rows.reshape(-1, width)
        return self.address, self.of_eight, rows, np.ldexp(1.0, -exponents), self.fastest or 0.0

    def to_dict(self) -> dict[str, Any]:
        """The parts of the callback that a file may hold: all but its address."""
        data = None if self.data is None else self.data.tolist()
        return {"data": data, "fastest": self.fastest}

    @classmethod
    def from_dict(cls, entries: Mapping[str, Any]) -> Self:
        """The callback that :meth:`to_dict` described; it cannot be called."""
        data = entries["data"]
        return cls(0, None if data is None else frozen(np.array(data)), entries["fastest"])

    def __reduce__(self) -> tuple[Any, ...]:
        """The callback for another process, with other addresses: it cannot be called there."""
        return type(self), (0, self.data, self.fastest)

    def __deepcopy__(self, memo: object) -> Self:
        return self  # nothing of it changes

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TorqueFunction):
            return NotImplemented
        return (self.address, self.fastest) == (other.address, other.fastest) and same(
            self.data, other.data
        )

    def __hash__(self) -> int:
        return hash((self.address, self.fastest, self.shape))

    def __repr__(self) -> str:
        data = "" if self.data is None else f", data of shape {self.data.shape}"
        return f"function at {self.address:#x}{data}"


_ARGUMENTS = ("double", *4 * ("double *",))
"""The arguments of a callback in C."""

_IN_C = {
    **{"float64": "double", "float64*": "double *", "void*": "double *"},
    **{"c_double": "double", "LP_c_double": "double *", "c_void_p": "double *"},
}
"""Types of C by their names in numba and ctypes."""


def _check_signature(function: Any, kinds: Iterable[str], result: str) -> None:
    """Raise TypeError for a function of other arguments: it would read memory of others."""
    given = tuple(_IN_C.get(kind, kind) for kind in kinds)
    if given != _ARGUMENTS or result not in ("none", "None", "void"):
        raise TypeError(
            f"address = {brief(function)}: must take ({', '.join(_ARGUMENTS)}) and return nothing; "
            f"it takes ({', '.join(given)}) and returns {result}"
        )


def _callback(function: Any, width: int) -> Callback:
    """The callback of a function of Python, numba, ctypes or cffi, or at an address."""
    found = getattr(function, "address", function)
    if type(found).__module__ == "_cffi_backend":
        import cffi

        kind = cffi.FFI().typeof(found)
        if kind.kind == "function":
            _check_signature(found, [one.cname for one in kind.args], kind.result.cname)
        found = int(cffi.FFI().cast("intptr_t", found))
    elif hasattr(function, "_sig"):
        _check_signature(function, map(str, function._sig.args), str(function._sig.return_type))
    elif getattr(function, "argtypes", None) is not None:  # a library tells none
        result = getattr(function.restype, "__name__", "None")
        _check_signature(function, [kind.__name__ for kind in function.argtypes], result)
    if callable(found):
        try:
            found = ctypes.cast(found, ctypes.c_void_p).value
        except ctypes.ArgumentError:
            return of_python(function, width)
    if isinstance(found, bool) or not isinstance(found, (int, np.integer)):
        raise TypeError(
            f"address = {brief(function)}: must be a function or the address of one, an int"
        )
    if not 0 < found < 2**63:
        raise ValueError(f"address = {found}: must be the address of a function")
    return Callback(int(found), False, function)
