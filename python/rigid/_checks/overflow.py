"""Numbers that leave the range of doubles on the way to a result."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, ParamSpec, TypeVar

import numpy as np

from .arguments import brief

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(slots=True)
class _User:
    """NumPy's error state where the user called, and what a function of the user raised."""

    state: dict[str, Any]
    raised: BaseException | None = None


_user: ContextVar[_User | None] = ContextVar("user", default=None)


@contextmanager
def numbers_of_user() -> Iterator[None]:
    """While a function of the user runs: its numbers are under the user's own error state."""
    user = _user.get()
    if user is None:
        yield
        return
    try:
        with np.errstate(**user.state):
            yield
    except ArithmeticError as error:
        user.raised = error
        raise


def refuses_overflow(function: Callable[P, R]) -> Callable[P, R]:
    """The function, which raises ValueError where one of its numbers overflows.

    The message names the argument with the number farthest from one. A function of the user runs in
    :func:`numbers_of_user`, and its errors stay.
    """

    @functools.wraps(function)
    def refusing(*args: P.args, **kwargs: P.kwargs) -> R:
        user = _user.get() or _User(dict(np.geterr()))
        token = _user.set(user)
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                return function(*args, **kwargs)
        except (FloatingPointError, OverflowError) as error:
            if error is user.raised:
                raise
            arguments = inspect.signature(function).bind(*args, **kwargs).arguments
        finally:
            _user.reset(token)
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
