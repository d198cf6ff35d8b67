"""Functions of the user, compared by their source and by the values that they take from outside."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from .._checks.arguments import brief
from .digest import code_of, digest, source_of, taken


@dataclass(frozen=True, slots=True)
class Sourced:
    """A function with digests of its source and of its captured values, which files hold.

    Attributes
    ----------
    name : str
        Name of the function.
    sha256 : str
        Digest of its source without the common indentation; of its byte code if it has no source,
        as a function that was typed at a prompt.
    captured : tuple of (str, str)
        What it takes from outside, by name: default arguments, closures, globals, attributes of
        ``self``, and likewise of the functions of the user that it calls.
    function : callable or None
        None if it was read from a file and not given again.
    """

    name: str
    sha256: str
    captured: tuple[tuple[str, str], ...] = ()
    function: Callable[..., Any] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(cls, argument: str, function: object) -> Self:
        """The function of an argument, as it is now.

        Raises
        ------
        TypeError
            If it is none, has no code of Python, or takes something that has no digest.
        """
        if not callable(function):
            raise TypeError(f"{argument} = {brief(function)}: must be a function")
        name = _name(function)
        try:
            known, values = taken(function)
        except TypeError as error:
            raise TypeError(f"{argument} = {name}: {error}") from None
        return cls(name, digest(code_of(known)), tuple(values.items()), function)

    def given(self, argument: str, function: object, *, carried: bool = False) -> Self:
        """The same function, given again after a file was read.

        A function that was carried to another process may have left its source behind.

        Raises
        ------
        ValueError
            If it has another source, or takes other values from outside: which.
        """
        if not callable(function):
            raise TypeError(f"{argument} = {brief(function)}: must be a function")
        whole = replace(self, function=function)
        if carried and source_of(taken(function)[0]) is None:
            return whole
        other = type(self).of(argument, function)
        if other.sha256 != self.sha256:
            raise ValueError(
                f"{argument} = {other.name}: its source differs from {self.name!r}, which made the "
                f"map (sha256 {other.sha256[:12]}..., not {self.sha256[:12]}...)"
            )
        old, new = dict(self.captured), dict(other.captured)
        told = [
            f"{name} is {new.get(name, 'not taken')}, and was {old.get(name, 'not taken')}"
            for name in sorted({*old, *new})
            if old.get(name) != new.get(name)
        ]
        if told:
            more = f"; and {len(told) - 5} more" if told[5:] else ""
            raise ValueError(
                f"{argument} = {other.name}: {'; '.join(told[:5])}{more} in {self.name!r}, which "
                "made the map"
            )
        return whole

    def renewed(self, argument: str) -> Self:
        """The function as it is now; unchanged if a file had none."""
        return self if self.function is None else type(self).of(argument, self.function)

    def doubt(self, argument: str) -> str:
        """Why the function may give other numbers than before, in words; empty without a reason."""
        if self.function is None:
            return ""
        try:
            self.given(argument, self.function)
        except (TypeError, ValueError) as error:
            return str(error)
        return ""

    def call(self, argument: str) -> Callable[..., Any]:
        """The function; ValueError if it must be given again."""
        if self.function is None:
            raise ValueError(
                f"{argument}: a file has no functions; give {self.name!r} again, as in "
                f"rigid.load_map(path, {argument}={self.name}), or in rigid.open_store"
            )
        return self.function

    def to_dict(self) -> dict[str, Any]:
        """Name and digests."""
        return {"name": self.name, "sha256": self.sha256, "captured": dict(self.captured)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The function that :meth:`to_dict` described; it must be given again."""
        captured = sorted((str(name), str(text)) for name, text in data["captured"].items())
        return cls(str(data["name"]), str(data["sha256"]), tuple(captured))


def _name(function: Callable[..., Any]) -> str:
    """The name of a function, of the one that a partial binds, or of the class of an object."""
    while isinstance(function, functools.partial):
        function = function.func
    return getattr(function, "__name__", type(function).__name__)
