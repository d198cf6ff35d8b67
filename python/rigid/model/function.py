"""A callback: a compiled function that returns a torque, known by its address."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, shaped
from .leading import Index, Shape, axes_of, frozen, same, taken

__all__ = ["TorqueFunction"]

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
    """

    address: int
    data: Floats | None = None
    fastest: float | None = None
    kept: object = None

    @classmethod
    def of_input(cls, function: object, data: ArrayLike | None, fastest: float | None) -> Self:
        """The function at an address, with its data.

        Raises
        ------
        TypeError, ValueError
            If it has no address, or data or bound are not finite.
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
        return cls(_address(function), numbers, bound, function)

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` if all have the same data."""
        return axes_of(self.data, 1)

    def of(self, shape: Shape, index: Index) -> TorqueFunction:
        """The function with the data of some of the bodies of this shape."""
        if not self.shape:
            return self
        data = frozen(taken(self.data, 1, shape, index))
        return TorqueFunction(self.address, data, self.fastest, self.kept)

    def for_core(
        self, shape: Shape, exponents: NDArray[np.intc]
    ) -> tuple[int, Floats, Floats, float]:
        """Address, rows of data, units of the torque and the bound, as the core reads them."""
        rows = np.empty((0, 0))
        if self.data is not None:
            width = self.data.shape[-1]
            lead = shape if self.shape else ()
            rows = np.ascontiguousarray(np.broadcast_to(self.data, (*lead, width)))
            rows = rows.reshape(-1, width)
        return self.address, rows, np.ldexp(1.0, -exponents), self.fastest or 0.0

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


def _address(function: Any) -> int:
    """The address of a function of numba, ctypes or cffi, or the one given."""
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
            raise TypeError(
                f"address = {brief(function)}: a torque is called by its address; compile the "
                "function with numba.cfunc or wrap it with ctypes.CFUNCTYPE"
            ) from None
    if isinstance(found, bool) or not isinstance(found, (int, np.integer)):
        raise TypeError(f"address = {brief(function)}: must be the address of a function, an int")
    if not 0 < found < 2**63:
        raise ValueError(f"address = {found}: must be the address of a function")
    return int(found)
