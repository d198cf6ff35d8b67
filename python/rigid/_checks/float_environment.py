"""Arithmetic of NumPy in the standard floating-point environment, whatever another library left."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from .. import _core

P = ParamSpec("P")
T = TypeVar("T")


def in_standard_floats(function: Callable[P, T]) -> Callable[P, T]:
    """The function, called while its thread rounds to nearest and keeps subnormal numbers."""

    @wraps(function)
    def standard(*args: P.args, **kwargs: P.kwargs) -> T:
        result: T = _core.in_standard_floats(function, args, kwargs)
        return result

    return standard
