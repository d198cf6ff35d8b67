"""Results of reports as JSON texts and files."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .._checks.arguments import brief, one_line
from .._files import published

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Stored", "names_from"]

FORMAT_VERSION = 1


class Stored(ABC):
    """A result that is a JSON text."""

    __slots__ = ()

    FORMAT: ClassVar[str]
    """The name of the format, which a text begins with."""

    @abstractmethod
    def _facts(self) -> dict[str, Any]:
        """The result as a JSON-able dictionary, without its format."""

    @classmethod
    @abstractmethod
    def _from_facts(cls, data: dict[str, Any]) -> Self:
        """The result that :meth:`to_dict` described, from a text with any content."""

    def to_dict(self) -> dict[str, Any]:
        """The result as a JSON-able dictionary; infinite or unknown numbers become None."""
        return {"format": self.FORMAT, "format_version": FORMAT_VERSION, **self._facts()}

    def to_json(self) -> str:
        """The result as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False, indent=1, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """The result that :meth:`to_json` wrote.

        Raises
        ------
        ValueError
            If the text is no such result, or one of another format.
        """
        try:
            data = json.loads(text, parse_constant=_refuse)
            if data["format"] != cls.FORMAT or data["format_version"] != FORMAT_VERSION:
                raise ValueError(f"format is not {cls.FORMAT!r}, version {FORMAT_VERSION}")
            return cls._from_facts(data)
        except Exception as error:  # the text may hold anything
            what = cls.FORMAT.removeprefix("rigid ")
            raise ValueError(
                f"text: is not a {what}: {type(error).__name__}: {one_line(error)}"
            ) from None

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the JSON text to a file and return its path.

        The file appears whole or not at all; see :meth:`rigid.StabilityMap.save`.

        Raises
        ------
        ValueError
            If the name does not end in ``.json``.
        OSError
            If the file cannot be written, or the path names something other than a file.
        """
        from pathlib import Path

        text = self.to_json() + "\n"
        with published(path, [".json"]) as file:
            file.write(text.encode())
        return Path(path)


def names_from(data: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """The other names of each method."""
    for names in data.values():
        for name in names:
            if not isinstance(name, str):
                raise TypeError(f"same: {brief(name)}: must be a name")
    return {method: tuple(names) for method, names in data.items()}


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant}: is not JSON")
