"""Tables of TOML files, read as the arguments of functions.

The signature of a function says which keys its table has. Every mistake is one line that names the
file, the table and key, and the nearest valid name.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from importlib import resources
from inspect import Parameter, signature
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from .._checks.arguments import brief, of_known, one_line, one_of
from .._checks.inputs import unreadable

_T = TypeVar("_T")

_BUILTIN = resources.files("rigid") / "builtin"

FOLDERS = {"map": _BUILTIN, "section": _BUILTIN / "sections", "report": _BUILTIN / "reports"}
"""The folders of the specifications that come with the package, by their kinds."""

MOST_TEXT = 2**23
"""Most bytes of a specification: two axes of 100 000 values with all their digits need less."""

MOST_PARTS = 16
"""Most parts of a dotted key. The time that the parser needs grows with their square."""

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_PARTS}}}")

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
    (r"\(\.\.\., 3\)", "(3,)"),
    (r"scene: (expected one body, got bodies of shape .*); take .*", r"\1"),
)
"""What messages say in the words of Python, and the same in the words of a file."""


class SpecError(ValueError):
    """A specification cannot be used; the message is one line that names the table and the key."""


def names_of(kind: str) -> list[str]:
    """Names of the built-in specifications of a kind, sorted."""
    names = (entry.name for entry in FOLDERS[kind].iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def read_source(source: str, kind: str) -> tuple[str, str, str]:
    """Name, text and file name of a specification: a built-in one by its name, else a path."""
    path = Path(source)
    if path.suffix != ".toml" and path.name == source:
        names = names_of(kind)
        if source not in names:
            raise SpecError(
                f"no built-in {kind} is called {source!r}{of_known(source, names)}; the name of "
                "a file ends in .toml"
            )
        own = f"{source}.toml"
        return source, (FOLDERS[kind] / own).read_text(encoding="utf-8"), own
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


class Table(dict[str, Any]):
    """A table of a file; errors name the file, the table and the key."""

    __slots__ = ("_file", "_name")

    def __init__(self, file: str, name: str, values: Mapping[str, Any]) -> None:
        super().__init__(values)
        self._file, self._name = file, name

    def __missing__(self, key: str) -> Any:
        raise self.error(f"needs the key {key!r}")

    def error(self, message: str) -> SpecError:
        """The error with the location of the table before its message."""
        place = f"{self._file}: [{self._name}]" if self._name else f"{self._file}:"
        for of_python, of_file in _REMEDIES:
            message = re.sub(of_python, of_file, message)
        return SpecError(f"{place} {one_line(message)}")

    def only(self, *known: str) -> None:
        """Raise for a key that is not known."""
        for key in self:
            if key not in known:
                tables = self.items()
                below = [name for name, one in tables if isinstance(one, Mapping) and key in one]
                hint = f"; did you mean '{below[0]}.{key}'?" if below else of_known(key, known)
                raise self.error(f"unknown key {key!r}{hint}")

    def text(self, key: str) -> str | None:
        """The string under a key that may be left out."""
        value = self.get(key, "")
        if not isinstance(value, str):
            raise self.error(f"{key} = {brief(value)}: must be a string")
        return value if key in self else None

    def table(self, key: str) -> Table:
        """The table under a key."""
        if not isinstance(self[key], dict):
            raise self.error(f"{key} = {brief(self[key])}: must be a table")
        return Table(self._file, self._below(key), self[key])

    def tables(self, key: str, word: str | None = None) -> list[Table]:
        """The tables in the list under a key; with a word, a string is a table of it alone."""
        given, what = self[key], "tables" if word is None else "names or of tables"
        listed = given if isinstance(given, list) else [given]
        if word is not None:
            listed = [{word: one} if isinstance(one, str) else one for one in listed]
        if not isinstance(given, list) or not all(isinstance(one, dict) for one in listed):
            raise self.error(f"{key} = {brief(given)}: must be a list of {what}")
        return [
            Table(self._file, f"{self._below(key)}[{place}]", one)
            for place, one in enumerate(listed)
        ]

    def _below(self, key: str) -> str:
        return f"{self._name}.{key}" if self._name else key

    def build(self, make: Callable[[], _T]) -> _T:
        """The result of ``make()``; an error of this call gets the location of the table."""
        try:
            return make()
        except SpecError:
            raise
        except (OverflowError, TypeError, ValueError) as error:
            raise self.error(str(error)) from None

    def call(
        self,
        make: Callable[..., _T],
        *beside: str,
        read: Mapping[str, Callable[[Table, str], Any]] = MappingProxyType({}),
        defaults: Mapping[str, Any] = MappingProxyType({}),
        needed: Collection[str] = (),
        **given: Any,
    ) -> _T:
        """The result of a function whose arguments are the keys of this table.

        Parameters
        ----------
        make : callable
            The function; its signature says which keys there are, and which are needed.
        *beside : str
            Further keys of the table, which the function does not take.
        read : mapping
            How the values of some keys become arguments: functions of the table and the key.
        defaults : mapping
            Arguments in place of keys that are omitted, as far as the function has them.
        needed : collection of str
            Keys that may not be omitted, although the function has a default.
        **given
            Arguments that are no keys.
        """
        known = {key: one for key, one in keys(make).items() if key not in given}
        self.only(*beside, *known)
        arguments = dict(given)
        for key, parameter in known.items():
            if key in self:
                value = read.get(key, Table.__getitem__)
                arguments[parameter.name] = self.build(partial(value, self, key))
            elif key in defaults:
                arguments[parameter.name] = defaults[key]
            elif parameter.default is Parameter.empty or key in needed:
                raise self.error(f"needs the key {key!r}")
        return self.build(lambda: make(**arguments))

    def choose(
        self, word: str, makes: Mapping[str, Callable[..., _T]], *instead: str, **how: Any
    ) -> _T:
        """As :meth:`call`, with the function that the key ``word`` names, or others ``instead``."""
        if word not in self:
            every = (key for make in makes.values() for key in keys(make))
            self.only(*dict.fromkeys((word, *instead, *every)))
        name = self[word]
        make = makes[self.build(lambda: one_of(word, name, makes))]
        return self.call(make, word, **how)


def keys(make: Callable[..., object]) -> dict[str, Parameter]:
    """The keys of a table that holds the arguments of a function; ``from_`` is the key ``from``."""
    return {name.removesuffix("_"): one for name, one in signature(make).parameters.items()}
