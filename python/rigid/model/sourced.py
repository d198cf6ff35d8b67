"""Functions of the user, compared by their source and by the values that they take from outside."""

from __future__ import annotations

import hashlib
import inspect
import textwrap
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from .._checks.arguments import brief
from .captured import captured
from .code import byte_code, plain, source_of

__all__ = ["Sourced"]


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
    captured : tuple of (str, str), or None
        What it takes from outside, by name: default arguments, closures, globals, attributes of
        ``self``, and likewise of the functions of the user that it calls. None if it was read from
        a file of a version that knew the source alone.
    function : callable or None
        None if it was read from a file and not given again.
    """

    name: str
    sha256: str
    captured: tuple[tuple[str, str], ...] | None = None
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
        known = plain(function)
        if known is None:
            raise TypeError(
                f"{argument} = {brief(function)}: must be a function with a source; "
                "write one with def"
            )
        name = getattr(function, "__name__", None) or known.__name__
        if name == "__call__":
            name = type(function).__name__
        try:
            taken = tuple(captured(function).items())
        except TypeError as error:
            raise TypeError(f"{argument} = {name}: {error}") from None
        return cls(name, _digest(known), taken, function)

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
        known = plain(function)
        whole = replace(self, function=function)
        if carried and known is not None and source_of(known) is None:
            return whole
        if self.captured is None:
            self._compare_source(argument, function)
            doubt = whole.doubt(argument)
            if doubt:
                warnings.warn(doubt, stacklevel=2)
            return whole
        other = type(self).of(argument, function)
        changes = self._changes(other)
        if changes:
            raise ValueError(f"{argument} = {other.name}: {changes}")
        return whole

    def _compare_source(self, argument: str, function: Callable[..., Any]) -> None:
        """Refuse another source, as versions did that compared the source alone."""
        try:
            source = textwrap.dedent(inspect.getsource(function)).encode()
        except (OSError, TypeError):
            return  # byte code, which differs between versions of Python
        digest = hashlib.sha256(source).hexdigest()
        if digest != self.sha256:
            name = getattr(function, "__name__", type(function).__name__)
            raise ValueError(f"{argument} = {name}: {self._other_source(digest)}")

    def renewed(self, argument: str) -> Self:
        """The function as it is now; unchanged if a file had none."""
        return self if self.function is None else type(self).of(argument, self.function)

    def doubt(self, argument: str) -> str:
        """Why the function may give other numbers than before, in words; empty without a reason."""
        if self.function is None:
            return ""
        try:
            now = type(self).of(argument, self.function)
        except TypeError as error:
            return str(error)
        if self.captured is None:
            names = ", ".join(name for name, _ in now.captured or ())
            words = f"the map has no digests of what {self.name!r} takes from outside: {names}"
            return f"{argument} = {now.name}: {words}" if names else ""
        changes = self._changes(now)
        return f"{argument} = {now.name}: {changes}" if changes else ""

    def _other_source(self, sha256: str) -> str:
        return (
            f"its source differs from {self.name!r}, which made the map "
            f"(sha256 {sha256[:12]}..., not {self.sha256[:12]}...)"
        )

    def _changes(self, other: Sourced) -> str:
        """The differences of another function, in words; empty if there are none."""
        if other.sha256 != self.sha256:
            return self._other_source(other.sha256)
        old, new = dict(self.captured or ()), dict(other.captured or ())
        told = [
            f"{name} is {new.get(name, 'not taken')}, and was {old.get(name, 'not taken')}"
            for name in sorted({*old, *new})
            if old.get(name) != new.get(name)
        ]
        more = f"; and {len(told) - 5} more" if told[5:] else ""
        made = f" in {self.name!r}, which made the map"
        return f"{'; '.join(told[:5])}{more}{made}" if told else ""

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
        taken = {} if self.captured is None else {"captured": dict(self.captured)}
        return {"name": self.name, "sha256": self.sha256, **taken}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The function that :meth:`to_dict` described; it must be given again."""
        taken = data.get("captured")
        pairs = None if taken is None else sorted((str(k), str(v)) for k, v in taken.items())
        return cls(str(data["name"]), str(data["sha256"]), None if pairs is None else tuple(pairs))


def _digest(function: Any) -> str:
    source = source_of(function)
    if source is not None:
        content = textwrap.dedent(source).encode()
    elif inspect.isclass(function):
        content = function.__qualname__.encode()
    else:
        content = byte_code(function.__code__)
    return hashlib.sha256(content).hexdigest()
