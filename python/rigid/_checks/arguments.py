"""Checks of arguments: every error message names the argument, its value and the rule."""

from __future__ import annotations

import difflib
import math
import operator
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from numbers import Real
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .quantities import instead_of_a_text, plain, without_unit

_DOUBLE = np.dtype(np.float64)

MOST_THREADS = 1024

LONG_LIST = 120
"""Characters of a list of names from which on a hint precedes the list."""

LONGEST_LIST = 500
"""Characters of a list of names from which on names 1, 2 and 3 are listed as one."""

MESSAGE = 800
"""Most characters of a message that quotes the content of a file."""


def nearest(name: object, known: Iterable[str]) -> str:
    """A hint such as ``"; did you mean 'spin'?"``, or an empty text if no known name is close."""
    if not isinstance(name, str):
        return ""
    spelt = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(name.lower(), spelt, n=1)
    return f"; did you mean {spelt[close[0]]!r}?" if close else ""


def of_known(name: object, known: Iterable[str]) -> str:
    """What follows a name that is not known: the hint, and then the names."""
    names = list(known)
    return f"{nearest(name, names)} (known: {_listed(names)})"


def _listed(names: Iterable[str]) -> str:
    """The names, with commas; in a long list ``x1``, ``x2`` and ``x3`` are ``x1 to x3``."""
    text = ", ".join(names)
    if len(text) < LONGEST_LIST:
        return text
    return _NUMBERED.sub(r"\g<q>\g<name>1\g<q> to \g<q>\g<name>3\g<q>", text)


_NUMBERED = re.compile(
    r"(?P<q>'?)(?P<name>[^\s,']+)1(?P=q), (?P=q)(?P=name)2(?P=q), (?P=q)(?P=name)3(?P=q)(?=,|$)"
)


def brief(value: object) -> str:
    """``value`` as text on one line of moderate length."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python writes no whole numbers of more than 4300 digits
        return "a whole number of more than 4300 digits"
    return text if len(text) <= 80 else f"{text[:77]}..."


def one_line(message: Exception | str) -> str:
    """A message about a file on one line: a file may hold long names and raw bytes."""
    text = " ".join(str(message).split()) or type(message).__name__
    return text if len(text) <= MESSAGE else f"{text[: MESSAGE - 3]}..."


def one_of(argument: str, value: object, known: Iterable[str]) -> str:
    """``value`` if it is one of the known names."""
    names = known if hasattr(known, "__len__") else list(known)
    if isinstance(value, str) and value in names:
        return value
    rule = f"must be one of {_listed(map(repr, names))}"
    hint = nearest(value, names).removeprefix("; ")
    if hint and len(rule) > LONG_LIST:
        rule = f"{hint} {rule}"  # nobody reads to the end of a long list
    elif hint:
        rule = f"{rule}; {hint}"
    raise ValueError(f"{argument} = {brief(value)}: {rule}")


def finite_float(
    name: str,
    value: object,
    *,
    positive: bool = False,
    nonnegative: bool = False,
    unit: str | None = None,
) -> float:
    """``value`` as a finite float; positive or not negative if required.

    A quantity is taken in ``unit``, by default the unit of :data:`.quantities.UNITS`.
    """
    if type(value) is not float:
        value = without_unit(name, value, unit)
        # Also an array of one number of xarray, which has an array of NumPy.
        inner = getattr(value, "values", value)
        if isinstance(inner, np.ndarray) and inner.ndim == 0:
            value = inner[()]
        if isinstance(value, bool) or not isinstance(value, Real):
            raise TypeError(
                f"{name} = {brief(value)}: must be a real number"
                f"{instead_of_a_text(name, value, unit)}"
            )
    try:
        number = float(value)
    except OverflowError:
        raise ValueError(f"{name} = {brief(value)}: must be below 1.8e308 in size") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} = {number}: must be finite")
    if positive and number <= 0.0:
        raise ValueError(f"{name} = {number}: must be positive")
    if nonnegative and number < 0.0:
        raise ValueError(f"{name} = {number}: must not be negative")
    return number


def truth(name: str, value: object) -> bool:
    """True or False."""
    if not isinstance(value, bool):
        raise TypeError(f"{name} = {brief(value)}: must be True or False")
    return value


def whole(name: str, value: object) -> int:
    """``value`` as a whole number, also of an array without axes; True and False are none."""
    if isinstance(value, SupportsIndex) and not isinstance(value, bool):
        with suppress(TypeError):
            return operator.index(value)
    raise TypeError(f"{name} = {brief(value)}: must be a whole number")


def positive_int(name: str, value: object, *, minimum: int = 1) -> int:
    """``value`` as a whole number of at least ``minimum``."""
    if type(value) is int and minimum <= value < 2**63:
        return value
    number = whole(name, value)
    if number < minimum:
        raise ValueError(f"{name} = {brief(value)}: must be at least {minimum}")
    if number >= 2**63:
        raise ValueError(f"{name} = {brief(value)}: must be below 2**63")
    return number


def numbers(name: str, value: ArrayLike, unit: str | None = None) -> NDArray[np.float64]:
    """``value`` as contiguous and aligned floats; those beyond 1.8e308 become infinite.

    A quantity is taken in ``unit``, by default the unit of :data:`.quantities.UNITS`.
    """
    value = plain(name, value, unit)
    try:
        array = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} = {brief(value)}: must be an array of real numbers") from None
    flags = array.flags
    if array.dtype == _DOUBLE and flags.c_contiguous and flags.aligned:
        return array
    if array.dtype.kind not in "iuf":
        rule = instead_of_a_text(name, value, unit) or f", got {array.dtype}"
        raise TypeError(f"{name} = {brief(value)}: must be real numbers{rule}")
    if array.dtype.itemsize > 8:
        with np.errstate(over="ignore"):
            array = array.astype(np.float64)
    floats = np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)
    return floats if floats.flags.aligned else floats.copy()


def _finite(name: str, array: NDArray[np.float64]) -> None:
    first = _core.first_not_finite(array)
    if first is not None:
        index = tuple(int(i) for i in np.unravel_index(first, array.shape))
        place = list(index) if index else ""
        raise ValueError(f"{name}{place} = {array[index]}: must be finite")


def vector(name: str, value: ArrayLike, length: int) -> NDArray[np.float64]:
    """``value`` as a finite array of shape ``(length,)``."""
    array = numbers(name, value)
    if array.shape != (length,):
        raise ValueError(f"{name}: expected shape ({length},), got {array.shape}")
    _finite(name, array)
    return array


def first_place(bad: NDArray[np.bool_]) -> tuple[tuple[int, ...], str]:
    """The index of the first bad element, and its text in a message: empty for a single one."""
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    return index, str(list(index)) if index else ""


def require(name: str, array: NDArray[Any], good: NDArray[np.bool_], rule: str) -> None:
    """Raise for the first element that breaks the rule."""
    if not good.all():
        index, place = first_place(~good)
        raise ValueError(f"{name}{place} = {array[index]}: {rule}")


def shaped(
    name: str,
    value: ArrayLike,
    *shape: int | None,
    positive: bool = False,
    nonnegative: bool = False,
    unit: str | None = None,
) -> NDArray[np.float64]:
    """``value`` as a finite array whose last axes have the given shape; leading axes are free.

    None means any length. A quantity is taken in ``unit``, as :func:`numbers` does.
    """
    return of_shape(
        name, numbers(name, value, unit), *shape, positive=positive, nonnegative=nonnegative
    )


def of_shape(
    name: str,
    array: NDArray[np.float64],
    *shape: int | None,
    positive: bool = False,
    nonnegative: bool = False,
) -> NDArray[np.float64]:
    """The array, if the array is as :func:`shaped` returns it."""
    last = array.shape[max(array.ndim - len(shape), 0) :]
    if last != shape and (
        len(last) < len(shape)
        or any(want not in (None, got) for want, got in zip(shape, last, strict=True))
    ):
        wanted = ", ".join("N" if want is None else str(want) for want in shape)
        raise ValueError(f"{name}: expected shape (..., {wanted}), got {array.shape}")
    _finite(name, array)
    if positive:
        require(name, array, array > 0.0, "must be positive")
    elif nonnegative:
        require(name, array, array >= 0.0, "must not be negative")
    return array


def rows(name: str, value: ArrayLike, width: int) -> NDArray[np.float64]:
    """``value``, one row or many, as a finite contiguous array ``(n, width)``."""
    array = numbers(name, value)
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        if array.size == 0 and array.ndim < 2:
            return np.empty((0, width))
        raise ValueError(f"{name}: expected shape ({width},) or (n, {width}), got {array.shape}")
    _finite(name, array)
    return np.ascontiguousarray(np.atleast_2d(array))


def together(**arrays: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """The arrays, broadcast against each other."""
    try:
        return np.broadcast_arrays(*arrays.values())
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ValueError(f"{shapes}: the shapes do not broadcast") from None


def vectors_together(**arguments: ArrayLike) -> tuple[NDArray[np.float64], ...]:
    """The arguments as finite arrays of shape ``(..., 3)``, broadcast against each other."""
    return together(**{name: shaped(name, value, 3) for name, value in arguments.items()})


def sorted_times(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """``value`` as finite ascending times, shape ``(m,)``; a single time counts as one."""
    array = np.atleast_1d(numbers(name, value))
    if array.ndim != 1:
        raise ValueError(f"{name}: expected shape (m,), got {array.shape}")
    return times_of_each(name, array)


def times_of_each(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """``value`` as finite times that ascend along the last axis, shape ``(..., m)``.

    A copy, which results keep when the caller turns an array of seconds into hours.
    """
    plain: NDArray[np.float64] | None = _core.plain_numbers(value, ascending=True)
    if plain is not None:
        return plain.copy()
    array = numbers(name, value).copy()
    array = array if array.ndim else array.reshape(1)
    _finite(name, array)
    if array.shape[-1] > 1 and (array[..., 1:] < array[..., :-1]).any():
        index, place = first_place(array[..., 1:] < array[..., :-1])
        after = (*index[:-1], index[-1] + 1)
        raise ValueError(
            f"{name}{place} = {array[index]} > {name}{list(after)} = {array[after]}: "
            "times must be ascending"
        )
    return array


def two_digits_above(value: float) -> str:
    """``value`` with two digits, rounded up: the least number to ask for instead."""
    if not 0.0 < value < math.inf:
        return f"{value:g}"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / unit * (1.0 + 1e-9)) * unit:.1e}"


def one_time(what: str, times: NDArray[np.float64]) -> ValueError:
    """The error of what needs more times than a run has."""
    end = float(times[-1]) if len(times) else 10.0
    return ValueError(
        f"t = {brief(times.tolist())}: {what} needs two times or more, such as "
        f"t=np.linspace(0, {end:g}, 201)"
    )


def resolve_threads(threads: int | None, bodies: int | None = None) -> int:
    """Number of threads: the argument, else ``RIGID_NUM_THREADS``, else the usable cores.

    These are the cores that the affinity of the process and its control group allow. One body, if
    the number of ``bodies`` is given, needs no second core.
    """
    if threads is not None:
        threads = positive_int("threads", threads)
        if threads > MOST_THREADS:
            raise ValueError(f"threads = {brief(threads)}: must be at most {MOST_THREADS}")
        return threads
    if _core.is_set("RIGID_NUM_THREADS") and (variable := os.environ.get("RIGID_NUM_THREADS")):
        digits = variable.lstrip("0")
        if not (variable.isascii() and variable.isdecimal() and digits):
            raise ValueError(
                f"RIGID_NUM_THREADS = {brief(variable)}: must be a whole number of at least 1"
            )
        if len(digits) > len(str(MOST_THREADS)) or int(digits) > MOST_THREADS:
            raise ValueError(
                f"RIGID_NUM_THREADS = {brief(variable)}: must be at most {MOST_THREADS}"
            )
        return int(digits)
    if bodies == 1:
        return 1
    threads = min(_core.available_threads(), MOST_THREADS)
    if hasattr(os, "sched_getaffinity"):  # it may have changed since the core looked
        threads = min(threads, len(os.sched_getaffinity(0)))
    return threads
