"""The values that a function of the user takes from outside, as digests that compare these values.

That are its default arguments, closures, what a ``functools.partial`` or an object holds, and the
globals that its code names; of functions and classes of the user that it uses likewise. Modules,
functions and classes of installed packages are recorded by their names. Of machine code, behind a
function of ctypes or cffi, nothing is recorded.
"""

from __future__ import annotations

import builtins
import copyreg
import enum
import functools
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from types import FunctionType, MappingProxyType, MemberDescriptorType, MethodType, ModuleType
from typing import Any

import numpy as np

from .._checks.arguments import one_line
from .code import (
    byte_code,
    digest,
    imports,
    is_installed,
    is_machine_code,
    is_special,
    is_wrapper,
    name_of,
    named_globals,
    package_of,
    plain,
    qualified,
    source_of,
)

__all__ = ["captured"]

MOST_TEXT = 2**13
"""Most characters of all names and digests. Further values share one digest, so that a file stays
small."""

DIGITS = 16
"""Hexadecimal digits of a digest of a value."""

_SCALARS = frozenset({type(None), bool, int, float, complex, str, bytes, type(...)})
"""Types whose ``repr`` shows the whole value; tuples of such values are shown at once."""

_SHOWN = frozenset({type(None), bool, int, float})
_MOST_SHOWN = 32
"""Most characters of a value that is stored as text, for the types listed before."""

_FOR_PEOPLE = ("__repr__", "__str__")
"""Methods that no verdict depends on; generated ones hold objects that are no values."""

_MISSING = "nothing"
"""The mark of a name that is not bound yet."""


def captured(function: Callable[..., Any]) -> dict[str, str]:
    """The values that a function takes from outside, by the names in its code.

    Small numbers are recorded as they are, all other values by digests.

    Raises
    ------
    TypeError
        Naming the first variable that has no digest, and its type.

    Examples
    --------
    >>> from rigid.model.captured import captured
    >>> captured(lambda states, limit=0.1, *, share=0.5: share * limit)
    {'limit': '0.1', 'share': '0.5'}
    """
    walk = _Walk(package_of(getattr(plain(function), "__module__", None)))
    try:
        walk.root(function)
    except RecursionError:
        raise TypeError("what it takes from outside is nested too deeply for a digest") from None
    found = sorted(walk.found.items(), key=lambda item: (item[0].count("."), item))
    sizes = np.cumsum([len(name) + len(text) for name, text in found])
    kept = int(np.searchsorted(sizes, MOST_TEXT, side="right"))
    if rest := found[kept:]:
        found[kept:] = [(f"and {len(rest)} more", _short(digest("more", repr(rest).encode())))]
    return dict(sorted(found))


def _short(token: bytes) -> str:
    return token.hex()[:DIGITS]


class _Walk:
    """One walk through all values that a function takes.

    Attributes
    ----------
    found : dict of str to str
        What was found, by its path from the function.
    """

    def __init__(self, package: str) -> None:
        self.found: dict[str, str] = {}
        self._package, self._depth, self._silent = package, 0, False
        self._known: dict[int, tuple[object, bytes]] = {}

    def root(self, function: Any) -> None:
        """Take the function itself; its source is compared elsewhere."""
        if isinstance(function, functools.partial):
            self.root(function.func)
            for place, value in enumerate(function.args):
                self._variable(f"args[{place}]", value)
            for name, value in function.keywords.items():
                self._variable(name, value)
        elif isinstance(function, MethodType):
            self.root(function.__func__)
            self._own_state(function.__self__)
        elif isinstance(function, FunctionType):
            self._known[id(function)] = (function, digest("itself"))
            self._variables(function, "")
        elif isinstance(function, type):
            self._class(function, function.__qualname__)
        elif is_wrapper(function):
            self.root(function.__wrapped__)
        else:
            call = plain(function)
            assert isinstance(call, FunctionType)
            self.root(call)
            self._own_state(function)

    def _own_state(self, value: Any) -> None:
        """The value of ``self``: each attribute of an object."""
        if isinstance(value, type | ModuleType):
            self._variable("self", value)
            return
        self._known[id(value)] = (value, digest("self"))
        if self._is_own(type(value).__module__):
            self._class(type(value), type(value).__qualname__)
        head, state, items = self._reduced(value, "self")
        for name, part in state.items():
            self._variable(f"self.{name}", part)
        plainly = (copyreg.__newobj__, type(value))  # type: ignore[attr-defined]
        rest = [part for part in (*head, *items) if not any(part is one for one in plainly)]
        if rest:
            self._variable("self", rest)

    def _is_own(self, module: str | None) -> bool:
        """Whether the functions of a module are read, not only named."""
        same = self._package not in ("", "rigid") and package_of(module) == self._package
        return same or not is_installed(module)

    def _variable(self, path: str, value: Any) -> bytes:
        """The digest of a variable, with an entry under its path."""
        token = self._value(value, path)
        if isinstance(value, ModuleType):
            text = f"module {value.__name__}"
        elif (name := self._named(value)) is not None:
            text = name
        elif isinstance(value, FunctionType | type):
            text = _short(_source(value))  # what it takes has its own entries
        elif type(value) in _SHOWN and len(shown := repr(value)) <= _MOST_SHOWN:
            text = shown
        elif isinstance(value, np.generic) and value.dtype.kind in "bif" and value.itemsize <= 8:
            text = f"{value.dtype} {value.item()!r}"
        else:
            text = f"{type(value).__name__} {_short(token)}"
        self._tell(path, text)
        return token

    def _tell(self, path: str, text: str) -> None:
        if not self._silent:
            self.found[path] = text

    def _named(self, value: Any) -> str | None:
        """The name of a function or class of an installed package, None for others."""
        if not callable(value) or self._is_own(getattr(value, "__module__", None)):
            return None
        return name_of(value)

    def _variables(self, function: FunctionType, prefix: str) -> list[bytes]:
        """Digests of all that a function takes from outside."""
        code = function.__code__
        own = self._is_own(function.__globals__.get("__name__"))
        space = function.__globals__ if own else {}  # not the globals of an installed decorator
        given = function.__defaults__ or ()
        names = code.co_varnames[: code.co_argcount]
        values: dict[str, Any] = dict(zip(names[len(names) - len(given) :], given, strict=True))
        values.update(function.__kwdefaults__ or {})
        for name, value in vars(function).items():
            if not is_special(name):
                values[f"{function.__name__}.{name}"] = value
        for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
            try:
                values[name] = cell.cell_contents
            except ValueError:  # bound later
                self._tell(prefix + name, _MISSING)
        for name, attributes in sorted(set(named_globals(code))) if own else ():
            if name in space:
                self._attribute(values, name, space[name], attributes, prefix)
            elif not hasattr(builtins, name):
                self._tell(prefix + name, _MISSING)
        for module in sorted(set(imports(code))) if own else ():
            if module.startswith(".") or self._is_own(module):
                raise TypeError(
                    f"{prefix}{module}: a module that is imported while the function runs has no "
                    "digest; import it outside"
                )
        return [
            digest(name, self._variable(prefix + name, value))
            for name, value in sorted(values.items())
        ]

    def _attribute(
        self,
        values: dict[str, Any],
        name: str,
        value: Any,
        attributes: tuple[str, ...],
        prefix: str,
    ) -> None:
        """Add a global; of a module of the user the attribute that is named."""
        for attribute in attributes:
            if not (isinstance(value, ModuleType) and self._is_own(value.__name__)):
                break
            name = f"{name}.{attribute}"
            if not hasattr(value, attribute):
                self._tell(prefix + name, _MISSING)
                return
            value = getattr(value, attribute)
        values[name] = value

    def _value(self, value: Any, path: str) -> bytes:
        """The digest of a value; a value that contains itself is replaced by its depth."""
        if type(value) in _SCALARS:
            return digest(type(value).__name__, repr(value).encode())
        known = self._known.get(id(value))
        if known is not None:
            return known[1]
        self._depth += 1
        self._known[id(value)] = (value, digest("inside", self._depth.to_bytes(8, "little")))
        token = self._token_of(value, path)
        self._known[id(value)] = (value, token)  # a value that is kept keeps its id
        self._depth -= 1
        return token

    def _token_of(self, value: Any, path: str) -> bytes:
        kind = type(value)
        if kind in (list, tuple):
            if set(map(type, value)) <= _SCALARS:
                return digest(kind.__name__, repr(value).encode())
            parts = [self._value(one, f"{path}[{k}]") for k, one in enumerate(value)]
            return digest(kind.__name__, *parts)
        if kind in (dict, MappingProxyType):
            return digest("dict", *self._items(value, path))
        if kind in (set, frozenset):
            return digest("set", *sorted(self._untold(one, path) for one in value))
        if kind is np.ndarray and value.dtype.hasobject:
            return digest("array", repr(value.shape).encode(), self._value(value.tolist(), path))
        if isinstance(value, np.generic) or kind is np.ndarray:
            layout = repr((np.lib.format.dtype_to_descr(value.dtype), value.shape))
            return digest("array", layout.encode(), value.tobytes())
        if isinstance(value, ModuleType):
            if self._is_own(value.__name__):
                raise TypeError(
                    f"{path}: the module {value.__name__} as a whole has no digest; write which of "
                    f"its names are taken, as {path}.name"
                )
            return digest("module", value.__name__.encode())
        if (name := self._named(value)) is not None:
            return digest("name", name.encode())
        if isinstance(value, FunctionType):
            return self._function(value, path)
        if isinstance(value, type):
            return self._class(value, path)
        if is_wrapper(value):
            return digest("wrapper", qualified(kind).encode(), self._value(value.__wrapped__, path))
        # The state of np.random.rand, which distributions of SciPy hold, is no value.
        if value is getattr(sys.modules.get("numpy.random.mtrand"), "_rand", None):
            return digest("random")
        if is_machine_code(value):
            return digest("machine code")
        if isinstance(value, enum.Enum):
            return digest("enum", self._value(kind, path), value.name.encode())
        head, state, items = self._reduced(value, path)
        own = self._items(state, path, ".{}")
        rest = [self._value(one, path) for one in (*head, *items)]
        return digest("object", b"".join(own), *rest)

    def _items(self, values: Mapping[Any, Any], path: str, place: str = "[{!r}]") -> list[bytes]:
        """Digests of pairs, in an order that does not depend on the order of the pairs."""
        keys = sorted(((self._untold(key, path), key) for key in values), key=lambda pair: pair[0])
        return [
            token + self._value(values[key], path + place.format(key))
            if type(key) in _SCALARS
            else token + self._untold(values[key], path)
            for token, key in keys
        ]

    def _untold(self, value: Any, path: str) -> bytes:
        """The digest of a value that has no entry under a name."""
        before, self._silent = self._silent, True
        token = self._value(value, path)
        self._silent = before
        return token

    def _reduced(self, value: Any, path: str) -> tuple[list[Any], dict[str, Any], list[Any]]:
        """The parts from which Python would copy an object: function, attributes and content."""
        kind = type(value)
        try:
            reduce = copyreg.dispatch_table.get(kind)
            found = reduce(value) if reduce else value.__reduce_ex__(4)
        except Exception as error:  # a method of a class that may be anyone's
            raise TypeError(
                f"{path}: a {qualified(kind)} has no digest ({one_line(error)}); take numbers, "
                "texts, tuples, dicts, arrays, dataclasses or functions of them"
            ) from None
        if isinstance(found, str):
            return [qualified(kind), found], {}, []
        make, arguments, state, listed, paired = (*found, *(None,) * 5)[:5]
        attributes: dict[str, Any] = {}
        if is_dataclass(value) and isinstance(state, list):  # one with slots
            attributes = dict(zip((one.name for one in fields(value)), state, strict=True))
        else:
            both = state if isinstance(state, tuple) and len(state) == 2 else (state,)
            if all(part is None or isinstance(part, dict) for part in both):  # those with slots too
                attributes = {name: one for part in both for name, one in (part or {}).items()}
            else:
                attributes = {"state": state}
        kept = {
            name: one
            for name, one in attributes.items()
            if not isinstance(getattr(kind, str(name), None), functools.cached_property)
        }
        items = [list(listed or ()), dict(paired or ())]
        return [make, *arguments], kept, [one for one in items if one]

    def _function(self, function: FunctionType, path: str) -> bytes:
        """The digest of a function; the values that it takes have entries under its path."""
        return digest("function", _source(function), *self._variables(function, f"{path}."))

    def _class(self, kind: type, path: str) -> bytes:
        """The digest of the source and of the values of a class, and of its base classes."""
        if not self._is_own(kind.__module__):  # made by a function of an installed package
            return digest("class", qualified(kind).encode())
        parts = [self._value(base, f"{path}.{base.__name__}") for base in kind.__bases__]
        parts.append(_source(kind))
        members: dict[str, Any] = dict(vars(kind))
        if issubclass(kind, enum.Enum):
            members = {name: one for name, one in members.items() if isinstance(one, FunctionType)}
            parts += self._items({name: one.value for name, one in kind.__members__.items()}, path)
        for name, member in sorted(members.items()):
            for function in () if name in _FOR_PEOPLE else _functions(member):
                # Those that a decorator or a base class made have no source, or another module.
                known = source_of(kind) is None or source_of(function) is not None
                if known and function.__module__ == kind.__module__:
                    parts.append(self._value(function, f"{path}.{name}"))
            if _is_value(name, member):
                parts.append(digest(name, self._variable(f"{path}.{name}", member)))
        return digest("class", *parts)


def _source(value: FunctionType | type) -> bytes:
    """The digest of a source, or of its substitute."""
    source = source_of(value)
    if source is not None:
        return digest("source", source.encode())
    if isinstance(value, type):
        return digest("class", value.__qualname__.encode())
    return byte_code(value.__code__)


def _functions(member: Any) -> list[FunctionType]:
    """The functions in a member of a class."""
    candidates = [member, getattr(member, "__func__", None), getattr(member, "func", None)]
    if isinstance(member, property):
        candidates = [member.fget, member.fset, member.fdel]
    return [one for one in candidates if isinstance(one, FunctionType)]


def _is_value(name: str, member: Any) -> bool:
    """Whether a member of a class is neither a function nor an internal of Python."""
    if is_special(name) or name in ("_abc_impl", "_is_protocol"):
        return False
    described = isinstance(member, MemberDescriptorType) or hasattr(type(member), "__get__")
    return not (described or _functions(member))
