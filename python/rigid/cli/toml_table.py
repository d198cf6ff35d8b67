"""Tables of TOML files whose mistakes are reported with their location.

Every mistake is one line that names the file, the table and key, and the nearest valid name.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, of_known, one_line, one_of, vector
from .._checks.inputs import unreadable

__all__ = [
    "BUILTIN",
    "SpecError",
    "Table",
    "as_is",
    "names_in",
    "parsed",
    "positive",
    "read_source",
    "text",
    "three",
]

_T = TypeVar("_T")

BUILTIN = resources.files("rigid") / "builtin"
"""The folder of the specifications that come with the package."""

MOST_TEXT = 2**23
"""Most bytes of a specification: two axes of 100 000 values with all their digits need less."""

MOST_PARTS = 16
"""Most parts of a dotted key. The time that the parser needs grows with their square."""

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_PARTS}}}")

_REQUIRED: Any = object()

_REMEDIES: tuple[tuple[str, str], ...] = (
    (r"\bStart\((\w+)=\.\.\.\)", r"\1 in [start]"),
    (r"\bStart\((\w+)=rigid\.(\w+)\(0\)\)", r"\1 = { kind = '\2' } in [start]"),
    (r"\b(\w+)=rigid\.(von_mises_fisher)\(0\)", r"\1 = { kind = '\2' }"),
    (r"\ba HeavyTop\b", "kind = 'heavy-top'"),
    (r"make it with Body\.box\(a, b, c\)", "give box instead of moments"),
    (r"\borbit=rigid\.Orbit\(rate\)", "orbit = { rate = ... }"),
    (r"; HeavyTop\.from_mass takes com in m", "; mgl has the distance in it"),
    (
        r"body = Body.*: a top needs the moments .*",
        "box: a top needs moments about its fixed point",
    ),
    (r"\bphysical=False\b", "physical = false"),
)
"""What messages say in the words of Python, and the same in the words of a file."""


class SpecError(ValueError):
    """A specification cannot be used; the message is one line that names the table and the key."""


def names_in(folder: Traversable) -> list[str]:
    """Names of the specifications in a folder, sorted."""
    names = (entry.name for entry in folder.iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def read_source(source: str, what: str, folder: Traversable) -> tuple[str, str, str]:
    """Name, text and file name of a specification: a built-in one by its name, else a path."""
    path = Path(source)
    if path.suffix != ".toml" and path.name == source:
        names = names_in(folder)
        if source not in names:
            raise SpecError(
                f"no built-in {what} is called {source!r}{of_known(source, names)}; the name of "
                "a file ends in .toml"
            )
        return source, (folder / f"{source}.toml").read_text(encoding="utf-8"), f"{source}.toml"
    try:
        with path.open("rb") as file:
            content = file.read(MOST_TEXT + 1)
        if len(content) > MOST_TEXT:
            raise SpecError(f"{source}: is longer than {MOST_TEXT} bytes")
        return path.stem, content.decode(), path.name
    except OSError as error:
        raise SpecError(unreadable(source, error)) from None
    except UnicodeDecodeError:
        raise SpecError(f"{source}: is not UTF-8 text") from None


def parsed(content: str, file: str, changes: Iterable[str] = ()) -> Table:
    """The outermost table of a TOML text; ``file`` names it in messages.

    ``changes`` are texts such as ``"run.t_end=10"`` that replace keys of the text.
    """
    if _DEEP_KEY.search(content):
        raise SpecError(f"{file}: a key has more than {MOST_PARTS} parts")
    try:
        document = tomllib.loads(content)
    except RecursionError:
        raise SpecError(f"{file}: arrays or tables are nested too deeply") from None
    except ValueError as error:  # also of a number of thousands of digits
        raise SpecError(f"{file}: is not valid TOML: {one_line(error)}") from None
    for change in changes:
        _change(document, change)
    return Table(file, "", document)


def _change(document: dict[str, Any], change: str) -> None:
    """Replace a key; a value that is not valid TOML is a word, such as ``run.method=rk4``."""
    key, equals, value = change.partition("=")
    *tables, last = parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts) or len(parts) > MOST_PARTS:
        raise SpecError(f"--set {brief(change)}: must be KEY=VALUE, such as run.t_end=10")
    for part in tables:
        document = document.setdefault(part, {})
        if not isinstance(document, dict):
            raise SpecError(f"--set {brief(change)}: {part!r} is not a table")
    try:
        (document[last],) = tomllib.loads(f"value = {value.strip()}").values()
    except (RecursionError, ValueError):
        document[last] = value.strip()


class Table:
    """A table of a file; errors name the file, the table and the key."""

    __slots__ = ("_file", "_name", "_values")

    def __init__(self, file: str, name: str, values: Mapping[str, Any]) -> None:
        self._file, self._name, self._values = file, name, values

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def error(self, message: str) -> SpecError:
        """The error with the location of the table before its message."""
        place = f"{self._file}: [{self._name}]" if self._name else f"{self._file}:"
        for of_python, of_file in _REMEDIES:
            message = re.sub(of_python, of_file, message)
        return SpecError(f"{place} {one_line(message)}")

    def only(self, *known: str) -> None:
        """Raise for a key that is not known."""
        for key in self._values:
            if key not in known:
                tables = self._values.items()
                below = [name for name, one in tables if isinstance(one, Mapping) and key in one]
                hint = f"; did you mean '{below[0]}.{key}'?" if below else of_known(key, known)
                raise self.error(f"unknown key {key!r}{hint}")

    def take(self, key: str, convert: Callable[[str, Any], _T], *, default: Any = _REQUIRED) -> Any:
        """The value of a key as ``convert(key, value)``."""
        if key not in self._values:
            if default is _REQUIRED:
                raise self.error(f"needs the key {key!r}")
            return default
        return self.build(lambda: convert(key, self._values[key]))

    def choice(self, key: str, known: Iterable[str], *, default: Any = _REQUIRED) -> str:
        """One of the known words."""
        word: str = self.take(key, lambda name, value: one_of(name, value, known), default=default)
        return word

    def table(self, key: str) -> Table:
        """The table under a key."""
        values: Mapping[str, Any] = self.take(key, _mapping)
        return Table(self._file, f"{self._name}.{key}" if self._name else key, values)

    def is_list(self, key: str) -> bool:
        """Whether the value of a key is a list."""
        return isinstance(self._values.get(key), list)

    def tables(self, key: str) -> list[Table]:
        """The tables in the list under a key."""
        values: list[Mapping[str, Any]] = self.take(key, _mappings)
        name = f"{self._name}.{key}" if self._name else key
        return [Table(self._file, f"{name}[{i}]", part) for i, part in enumerate(values)]

    def build(self, make: Callable[[], _T]) -> _T:
        """The result of ``make()``; an error of this call gets the location of the table."""
        try:
            return make()
        except SpecError:
            raise
        except (OverflowError, TypeError, ValueError) as error:
            raise self.error(str(error)) from None


def as_is(_key: str, value: object) -> Any:
    """A value that is passed on unchanged, because the constructor that receives it checks it."""
    return value


def text(key: str, value: object) -> str:
    """A string."""
    if not isinstance(value, str):
        raise TypeError(f"{key} = {brief(value)}: must be a string")
    return value


def _mapping(key: str, value: object) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"{key} = {brief(value)}: must be a table")
    return value


def _mappings(key: str, value: object) -> list[Mapping[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(part, dict) for part in value):
        raise TypeError(f"{key} = {brief(value)}: must be a list of tables")
    return value


def positive(key: str, value: object) -> float:
    """A positive number."""
    return finite_float(key, value, positive=True)


def three(key: str, value: ArrayLike) -> tuple[float, float, float]:
    """Three numbers."""
    first, second, third = vector(key, value, 3).tolist()
    return first, second, third
