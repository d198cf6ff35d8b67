"""Numbers that leave the range of doubles on the way to a result."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np

from .arguments import brief

P = ParamSpec("P")
R = TypeVar("R")


def refuses_overflow(function: Callable[P, R]) -> Callable[P, R]:
    """The function, which raises ValueError where one of its numbers overflows.

    The message names the argument with the number farthest from one.
    """

    @functools.wraps(function)
    def refusing(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                return function(*args, **kwargs)
        except (FloatingPointError, OverflowError):
            arguments = inspect.signature(function).bind(*args, **kwargs).arguments
        name = max(arguments, key=lambda name: _extent(arguments[name]))
        raise ValueError(
            f"{name} = {brief(arguments[name])}: a result would leave the range of doubles; "
            "count in other units"
        )

    return refusing


def _extent(value: object) -> float:
    """The largest distance of a number from one, in powers of two; -1 if there is none."""
    try:
        sizes = np.abs(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        return -1.0
    sizes = sizes[(sizes > 0.0) & np.isfinite(sizes)]
    return float(np.abs(np.log2(sizes)).max(initial=-1.0))
