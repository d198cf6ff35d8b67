"""The arrays in which a run is returned: their precision, and arrays from the user."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from math import prod
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .._checks.arguments import brief, one_of, two_digits_above
from .arrays import Range
from .bodies import Bodies

Floats = NDArray[np.float64]

COLUMNS: Mapping[str, int] = {"omega": 3, "gamma": 3, "attitude": 4, "work": 1}
"""The numbers in a row of the arrays of a run with an axis of times."""

SINGLE = 2.0**-23
"""Angle (rad) by which single precision rounds an attitude: twice as much as for a vector."""

SLOWEST, FASTEST = 1e-30, 1e30
"""Rates between these are rounded to single precision relative to their size (rad/s)."""


@dataclass(frozen=True, slots=True)
class Target:
    """The arrays for the states of a run.

    Attributes
    ----------
    single : bool
        Whether new arrays have single precision.
    given : dict of str to ndarray
        Arrays of shape (n, m, k) by their names.
    """

    single: bool
    given: dict[str, NDArray[Any]]

    @classmethod
    def of(
        cls,
        dtype: DTypeLike,
        out: Mapping[str, NDArray[Any]] | None,
        shape: tuple[int, ...],
        recorded: tuple[str, ...],
    ) -> Self:
        """The target of a call.

        Parameters
        ----------
        dtype : dtype
            ``float64`` or ``float32``.
        out : mapping or None
            Arrays by the names of their attributes of a run.
        shape : tuple of int
            ``(..., m)``, or ``(m,)`` of a single body.
        recorded : tuple of str
            Names of the recorded arrays.

        Raises
        ------
        TypeError
            If an array is none.
        ValueError
            If the type is another one, a name is not recorded, or an array cannot be filled.
        """
        if np.dtype(dtype) not in (np.float64, np.float32):
            raise ValueError(f"dtype = {np.dtype(dtype)}: must be float64 or float32")
        count = prod(shape[:-1])
        given = {}
        for name, array in (out or {}).items():
            width = COLUMNS[one_of("out", name, recorded)]
            wanted = shape if width == 1 else (*shape, width)
            given[name] = _fillable(name, array, wanted).reshape(count, shape[-1], width)
        return cls(np.dtype(dtype) == np.float32, given)

    def check(self, bodies: Bodies, reached: Range, accuracy: float | None) -> None:
        """Raise ValueError for numbers that single precision cannot hold."""
        if not self._rounds:
            return
        if accuracy is not None and accuracy <= SINGLE:
            least = two_digits_above(SINGLE)
            raise ValueError(f"accuracy = {accuracy:g}: must be at least {least} in float32")
        rates = bodies.fastest_rates(reached)
        outside = np.flatnonzero((rates > 0.0) & ~((rates > SLOWEST) & (rates < FASTEST)))
        if len(outside):
            raise ValueError(
                f"dtype = float32: the rates of body {outside[0]} reach "
                f"{rates[outside[0]]:.3g} rad/s; they must be zero or between {SLOWEST:g} and "
                f"{FASTEST:g}: count the time in another unit"
            )

    @property
    def _rounds(self) -> bool:
        return self.single or any(array.dtype == np.float32 for array in self.given.values())

    @property
    def exact(self) -> dict[str, NDArray[Any]]:
        """The given arrays of double precision, in which steps are compared before rounding."""
        return {name: array for name, array in self.given.items() if array.dtype == np.float64}

    def finish(self, states: MutableMapping[str, Any], error: Floats) -> Floats:
        """Store all states; return their errors with the rounding included."""
        for name, width in COLUMNS.items():
            array, given = states[name], self.given.get(name)
            if given is not None:
                given = given if width > 1 else given[..., 0]
                if not np.may_share_memory(given, array):
                    given[:] = array
                states[name] = given
            elif self.single and array is not None and width > 1:
                states[name] = array.astype(np.float32, copy=False)
        return error + SINGLE if self._rounds else error


PLAIN = Target(single=False, given={})
"""All arrays are new and of double precision."""


def _fillable(name: str, array: object, shape: tuple[int, ...]) -> NDArray[Any]:
    """The array of ``out``, if states can be written into it."""
    if not isinstance(array, np.ndarray):
        raise TypeError(f"out[{name!r}] = {brief(array)}: must be an array")
    flags = array.flags
    if (
        array.shape != shape
        or array.dtype not in (np.float64, np.float32)
        or not (flags.c_contiguous and flags.writeable and flags.aligned)
    ):
        raise ValueError(
            f"out[{name!r}]: must be writeable and C-contiguous, of shape {shape} and float64 or "
            f"float32; got {array.shape} of {array.dtype}"
        )
    return array


def end_records(
    states: MutableMapping[str, Any], times: NDArray[np.float64], last: NDArray[np.float64]
) -> None:
    """Write NaN over the states at times (m,) or (n, m) after the last of each body, (n, 1)."""
    after = times > last
    if not after.any():
        return
    for name in (*COLUMNS, "tangent", "sensitivity"):
        if states.get(name) is not None:
            states[name][after] = np.nan
