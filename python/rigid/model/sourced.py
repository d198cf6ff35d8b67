"""Functions of the user that numbers depend on: named, and told apart by their source."""

from __future__ import annotations

import hashlib
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from .._checks.arguments import brief

__all__ = ["Sourced"]


@dataclass(frozen=True, slots=True)
class Sourced:
    """A function with the digest of its source; files keep its name and digest alone.

    Attributes
    ----------
    name : str
        Name of the function.
    sha256 : str
        Digest of its source without the common indentation; of its byte code if it has no source,
        as a function that was typed at a prompt.
    function : callable or None
        None if it was read from a file and not given again.
    """

    name: str
    sha256: str
    function: Callable[..., Any] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(cls, argument: str, function: object) -> Self:
        """The function of an argument."""
        if not callable(function):
            raise TypeError(f"{argument} = {brief(function)}: must be a function")
        name = getattr(function, "__name__", type(function).__name__)
        return cls(name, _digest(argument, function), function)

    def given(self, argument: str, function: object, *, carried: bool = False) -> Self:
        """The same function, given again; ValueError if it has another source.

        A function that was carried to another process may have left its source behind.
        """
        other = type(self).of(argument, function)
        if carried and not _has_source(function):
            return replace(self, function=other.function)
        if other.sha256 != self.sha256:
            raise ValueError(
                f"{argument} = {other.name}: its source is not that of {self.name!r}, which made "
                f"the map (sha256 {other.sha256[:12]}..., not {self.sha256[:12]}...)"
            )
        return replace(self, function=other.function)

    def call(self, argument: str) -> Callable[..., Any]:
        """The function; ValueError if it must be given again."""
        if self.function is None:
            raise ValueError(
                f"{argument}: a file has no functions; give {self.name!r} again, as in "
                f"rigid.load_map(path, {argument}={self.name}), or in rigid.open_store"
            )
        return self.function

    def to_dict(self) -> dict[str, str]:
        """Name and digest."""
        return {"name": self.name, "sha256": self.sha256}

    @classmethod
    def from_dict(cls, data: Mapping[str, str]) -> Self:
        """The function that :meth:`to_dict` described, which must be given again."""
        return cls(str(data["name"]), str(data["sha256"]))


def _has_source(function: Any) -> bool:
    try:
        return bool(inspect.getsource(function))
    except (OSError, TypeError):
        return False


def _digest(argument: str, function: Callable[..., Any]) -> str:
    try:
        content = textwrap.dedent(inspect.getsource(function)).encode()
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        if code is None:
            raise TypeError(
                f"{argument} = {brief(function)}: must be a function with a source; "
                "write one with def"
            ) from None
        content = code.co_code + repr((code.co_consts, code.co_names)).encode()
    return hashlib.sha256(content).hexdigest()
