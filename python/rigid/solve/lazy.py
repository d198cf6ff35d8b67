"""Objects that are made when they are first read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Self, TypeVar

Made = TypeVar("Made")


class Lazy(Generic[Made]):
    """An object made when it is first read: many runs are made, few of their parts are read.

    What it is made of must not change meanwhile. Two threads that read it first make the same.
    """

    __slots__ = ("_made", "_making")

    def __init__(self, make: Callable[..., Made], *given: Any) -> None:
        self._making: tuple[Callable[..., Made], tuple[Any, ...]] | None = make, given
        self._made: Made | None = None

    @classmethod
    def of(cls, made: Made) -> Self:
        """A wrapper of an object that is made already."""
        return cls(lambda: made)

    def __call__(self) -> Made:
        """The object."""
        making = self._making
        if making is not None:
            make, given = making
            self._made = make(*given)
            self._making = None  # and what it holds: this comes last, for other threads
        assert self._made is not None
        return self._made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).of, (self(),)
