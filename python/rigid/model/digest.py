"""The digest of a function of the user: its source, and the values that it takes from outside.

These values are its default arguments, its closure, what a ``functools.partial`` or an object holds
for it, and the globals that its code names. Numbers, texts, containers and arrays count by their
content. Functions and classes of the user count by their source and by what they take in turn,
other objects by what a copy of them is made from. What is installed counts by its name, and machine
code, behind a function of ctypes or cffi, not at all.
"""

from __future__ import annotations

import copyreg
import ctypes
import dis
import functools
import inspect
import os
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, FunctionType, MappingProxyType, MethodType, ModuleType
from typing import Any

import numpy as np

from .._checks.arguments import one_line

MOST = 256
"""Most values of a function; further ones share a digest, so that a file stays small."""

DIGITS = 16
"""Hexadecimal digits of the digest of a value."""

_SHOWN = 32
"""Most characters of a value that is shown as it is."""

_SCALARS = frozenset({type(None), bool, int, float, complex, str, bytes, type(...)})
"""Types whose ``repr`` shows the whole value."""

_GLOBALS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
_ATTRIBUTES = ("LOAD_ATTR", "LOAD_METHOD")
"""Instructions that take a global, and an attribute."""

_LIBRARY = Path(os.__file__).parent
"""The folder of the modules of Python."""

_MACHINE_CODE: Any = ctypes.CFUNCTYPE(None).__base__
"""The class of functions of ctypes."""

_INTERNAL = ("__repr__", "__str__", "_abc_impl", "_is_protocol")
"""Members of a class that no verdict depends on."""


def digest(text: str) -> str:
    """SHA-256 of a text, hexadecimal."""
    return sha256(text.encode(errors="surrogatepass")).hexdigest()


def source_of(function: FunctionType | type) -> str | None:
    """The source of a class, or of a function without its wrapped function; None if unknown.

    It is read once: its file may change later, what runs does not.
    """
    return _source(function if isinstance(function, type) else function.__code__)


@functools.cache
def _source(owner: type | CodeType) -> str | None:
    try:
        return inspect.getsource(owner)
    except (OSError, TypeError):
        return None


def code_of(function: FunctionType | type) -> str:
    """The source without the common indentation, or what stands for it."""
    source = source_of(function)
    if source is not None:
        return textwrap.dedent(source)
    return function.__qualname__ if isinstance(function, type) else _byte_code(function.__code__)


def _byte_code(code: CodeType) -> str:
    """The instructions of a function without a source, which depend on the version of Python."""
    constants = [
        _byte_code(one)
        if isinstance(one, CodeType)
        else sorted(map(repr, one))
        if isinstance(one, frozenset)
        else repr(one)
        for one in code.co_consts
    ]
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_flags
    counts = code.co_argcount, code.co_kwonlyargcount, code.co_posonlyargcount
    return repr((code.co_code, code.co_exceptiontable, constants, names, counts))


def taken(function: Callable[..., Any]) -> tuple[FunctionType | type, dict[str, str]]:
    """The function or class whose code runs, and what it takes from outside, by name.

    Short values are shown as they are, all others by digests.

    Raises
    ------
    TypeError
        If there is no code of Python; or naming the first variable without a digest, and its type.

    Examples
    --------
    >>> from rigid.model.digest import taken
    >>> taken(lambda states, limit=0.1, *, share=0.5: share * limit)[1]
    {'limit': '0.1', 'share': '0.5'}
    """
    walk = _Walk()
    try:
        known = walk.root(function)
    except RecursionError:
        raise TypeError("what it takes from outside is nested too deeply for a digest") from None
    found = sorted(walk.found.items(), key=lambda item: (item[0].count("."), item))
    if rest := found[MOST:]:
        found[MOST:] = [(f"and {len(rest)} more", _short("digest", repr(rest)))]
    return known, dict(sorted(found))


class _Walk:
    """One walk through all values that a function takes.

    Attributes
    ----------
    found : dict of str to str
        What was found, by its path from the function.
    """

    def __init__(self) -> None:
        self.found: dict[str, str] = {}
        self._package = ""
        self._known: dict[int, tuple[object, str]] = {}
        self._depth = 0

    def root(self, function: Any) -> FunctionType | type:
        """The function whose code runs; its source is compared elsewhere."""
        self._known[id(function)] = function, "itself"
        if isinstance(function, FunctionType | type):
            self._package = _package(function.__module__)
            if isinstance(function, type):
                self._class(function)
            else:
                self._variables(function, "")
            return function
        if isinstance(function, functools.partial):
            known = self.root(function.func)
            for place, value in enumerate(function.args):
                self._variable(f"args[{place}]", value)
            for name, value in function.keywords.items():
                self._variable(name, value)
            return known
        if _is_wrapper(function):
            return self.root(function.__wrapped__)
        if isinstance(function, MethodType):
            known, owner = self.root(function.__func__), function.__self__
        elif _is_installed(type(function).__module__):
            raise TypeError("must be a function with a source; write one with def")
        else:
            known, owner = self.root(inspect.getattr_static(type(function), "__call__")), function
        if isinstance(owner, type):
            self._variable("self", owner)
        else:
            self._known[id(owner)] = owner, "self"
            self._object(owner, "self")
        return known

    def _variable(self, path: str, value: Any) -> str:
        """The text of a variable, with an entry under its path."""
        text = self._text(value, path)
        is_read = isinstance(value, FunctionType | type) and self._named(value) is None
        # There are entries for what a function takes.
        self.found[path] = _short("", code_of(value)) if is_read else text
        return text

    def _alone(self, value: Any, path: str) -> str:
        """The text of a value that has no name: nothing in it has an entry."""
        found, self.found = self.found, {}
        text = self._text(value, path)
        self.found = found
        return text

    def _text(self, value: Any, path: str) -> str:
        """A text that tells a value from others; a value inside itself is told by its depth."""
        if type(value) in _SCALARS:
            return _short(type(value).__name__, repr(value))
        if id(value) not in self._known:
            self._depth += 1
            self._known[id(value)] = value, f"inside {self._depth}"
            text = self._described(value, path)
            self._known[id(value)] = value, text  # a value that is kept keeps its id
            self._depth -= 1
        return self._known[id(value)][1]

    def _described(self, value: Any, path: str) -> str:
        kind = type(value)
        if kind in (list, tuple):
            if set(map(type, value)) <= _SCALARS:
                return _short(kind.__name__, repr(value))
            parts = [self._text(one, f"{path}[{place}]") for place, one in enumerate(value)]
            return _hashed(kind.__name__, *parts)
        if kind in (dict, MappingProxyType):
            told = [(self._alone(key, path), key) for key in value]
            told.sort(key=lambda pair: pair[0])
            parts = [f"{text}: {self._text(value[key], f'{path}[{text}]')}" for text, key in told]
            return _hashed("dict", *parts)
        if kind in (set, frozenset):
            return _hashed("set", *sorted(self._alone(one, path) for one in value))
        if isinstance(value, np.generic) and value.dtype.kind in "biuf" and value.itemsize <= 8:
            return f"{value.dtype} {value.item()!r}"
        if kind is np.ndarray and not value.dtype.hasobject:
            layout = np.lib.format.dtype_to_descr(value.dtype), value.shape
            return _hashed("ndarray", repr(layout), sha256(value.tobytes()).hexdigest())
        if isinstance(value, ModuleType):
            if self._is_own(value.__name__):
                raise TypeError(
                    f"{path}: the module {value.__name__} as a whole has no digest; write which of "
                    f"its names are taken, as {path}.name"
                )
            return f"module {value.__name__}"
        if (name := self._named(value)) is not None:
            return name
        if isinstance(value, FunctionType):
            return _hashed("function", code_of(value), *self._variables(value, f"{path}."))
        if isinstance(value, type):
            return self._class(value)
        if _is_wrapper(value):
            return _hashed(_name(kind), self._text(value.__wrapped__, path))
        if isinstance(value, _MACHINE_CODE) or kind.__module__ == "_cffi_backend":
            return "machine code"
        # The state of np.random.rand, which distributions of SciPy hold, is no value.
        if value is getattr(sys.modules.get("numpy.random.mtrand"), "_rand", None):
            return "numpy.random"
        return self._object(value, path)

    def _object(self, value: Any, path: str) -> str:
        """The text of an object; the attributes of ``self`` have entries."""
        state, rest = self._parts(value, path)
        parts = [self._text(type(value), path)]
        for name, one in sorted(state.items(), key=lambda pair: str(pair[0])):
            at = f"{path}.{name}"
            parts += [name, self._variable(at, one) if path == "self" else self._text(one, at)]
        if rest:
            parts.append(self._variable(path, rest) if path == "self" else self._text(rest, path))
        return _hashed(type(value).__name__, *parts)

    def _is_own(self, module: str | None) -> bool:
        """Whether the functions of a module are read, not only named."""
        same = self._package not in ("", "rigid") and _package(module) == self._package
        return same or not _is_installed(module)

    def _named(self, value: Any) -> str | None:
        """The name of a function or class of an installed package, None for others."""
        module = getattr(value, "__module__", None)
        if not callable(value) or self._is_own(module):
            return None
        found: Any = sys.modules.get(str(module))
        for part in str(getattr(value, "__qualname__", "?")).split("."):
            found = getattr(found, part, None)
        return _name(value) if found is value else None

    def _variables(self, function: FunctionType, prefix: str) -> list[str]:
        """Texts of all that a function takes from outside."""
        code = function.__code__
        names, given = code.co_varnames[: code.co_argcount], function.__defaults__ or ()
        values: dict[str, Any] = dict(zip(names[len(names) - len(given) :], given, strict=True))
        values |= function.__kwdefaults__ or {}
        for name, value in vars(function).items():
            if not _is_special(name):
                values[f"{function.__name__}.{name}"] = value
        for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
            try:
                values[name] = cell.cell_contents
            except ValueError:  # bound later
                continue
        # Not the globals of an installed decorator.
        if self._is_own(function.__globals__.get("__name__")):
            values |= self._globals(code, function.__globals__, prefix)
        return [f"{name}={self._variable(prefix + name, values[name])}" for name in sorted(values)]

    def _globals(self, code: CodeType, space: dict[str, Any], prefix: str) -> dict[str, Any]:
        """The globals that a code names; of a module of the user the names that it has there."""
        steps = [(step.opname, step.argval) for step in _steps(code)]
        for operation, name in steps:
            if operation == "IMPORT_NAME" and (not name or self._is_own(name)):
                raise TypeError(
                    f"{prefix}{name or '.'}: a module that is imported while the function runs has "
                    "no digest; import it outside"
                )
        names = {name for operation, name in steps if operation in _GLOBALS}
        known = {name: space[name] for name in names if name in space and not _is_special(name)}
        return self._opened(known, {name for operation, name in steps if operation in _ATTRIBUTES})

    def _opened(self, values: Mapping[str, Any], attributes: set[str]) -> dict[str, Any]:
        """Values, with the attributes that a code names in place of a module of the user."""
        found: dict[str, Any] = {}
        for name, value in values.items():
            inside = {}
            if isinstance(value, ModuleType) and self._is_own(value.__name__):
                held = [one for one in attributes if hasattr(value, one)]
                inside = {f"{name}.{one}": getattr(value, one) for one in held}
            found |= self._opened(inside, attributes) if inside else {name: value}
        return found

    def _class(self, kind: type) -> str:
        """The text of the source and of the values of a class, and of its base classes."""
        path = kind.__qualname__
        parts = [self._text(base, f"{path}.{base.__name__}") for base in kind.__bases__]
        values = getattr(kind, "__members__", vars(kind))  # members of an enumeration
        for name, member in sorted({**vars(kind), **values}.items()):
            if name in _INTERNAL:
                continue
            functions = _functions(member)
            for function in functions:
                # Those that a decorator or a base class made have no source, or another module.
                known = source_of(kind) is None or source_of(function) is not None
                if known and function.__module__ == kind.__module__:
                    parts.append(self._text(function, f"{path}.{name}"))
            is_other = functions or _is_special(name) or hasattr(type(member), "__get__")
            if name in values and not is_other:
                parts.append(self._variable(f"{path}.{name}", member))
        return _hashed("class", code_of(kind), *parts)

    def _parts(self, value: Any, path: str) -> tuple[dict[str, Any], list[Any]]:
        """The attributes of an object, and what else Python would copy it from."""
        kind = type(value)
        try:
            reduce = copyreg.dispatch_table.get(kind)
            made = reduce(value) if reduce else value.__reduce_ex__(4)
        except Exception as error:  # a method of a class that may be anyone's
            raise TypeError(
                f"{path}: a {_name(kind)} has no digest ({one_line(error)}); take numbers, "
                "texts, tuples, dicts, arrays, dataclasses or functions of them"
            ) from None
        if isinstance(made, str):
            return {}, [made]
        make, arguments, state, listed, paired = (*made, *(None,) * 5)[:5]
        if not isinstance(state, dict):
            state = {} if state is None else {"state": state}
        kept = {
            name: one
            for name, one in state.items()
            if not isinstance(getattr(kind, str(name), None), functools.cached_property)
        }
        is_plain = make is copyreg.__newobj__ and len(arguments) == 1  # type: ignore[attr-defined]
        rest = [] if is_plain else [make, arguments]
        return kept, rest + [one for one in (list(listed or ()), dict(paired or ())) if one]


def _short(kind: str, text: str) -> str:
    """A text as it is, if it is short; else its digest."""
    return text if len(text) <= _SHOWN else _hashed(kind, text)


def _hashed(kind: str, *parts: str) -> str:
    return f"{kind} {digest(repr(parts))[:DIGITS]}".lstrip()


def _steps(code: CodeType) -> Iterator[dis.Instruction]:
    """The instructions of a code and of those inside it."""
    yield from dis.get_instructions(code)
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _steps(one)


def _functions(member: Any) -> list[FunctionType]:
    """The functions in a member of a class."""
    candidates = [member, getattr(member, "__func__", None), getattr(member, "func", None)]
    if isinstance(member, property):
        candidates = [member.fget, member.fset, member.fdel]
    return [one for one in candidates if isinstance(one, FunctionType)]


def _is_special(name: str) -> bool:
    """Whether Python gives a name its meaning, as to ``__name__``."""
    return name.startswith("__") and name.endswith("__")


def _is_wrapper(value: Any) -> bool:
    """Whether an installed package wrapped a function in an object, as ``lru_cache`` does."""
    kind = type(value)
    wrapped = not isinstance(value, FunctionType | type) and _is_installed(kind.__module__)
    return wrapped and isinstance(getattr(value, "__wrapped__", None), FunctionType)


def _name(value: Any) -> str:
    """Module and name of a function or class."""
    owner = getattr(value, "__module__", None) or type(value).__module__
    return f"{owner}.{getattr(value, '__qualname__', getattr(value, '__name__', '?'))}"


def _package(module: str | None) -> str:
    return (module or "").partition(".")[0]


def _is_installed(module: str | None) -> bool:
    """Whether a module belongs to Python, to rigid or to an installed package."""
    package = _package(module)
    if package in ("", "rigid", "__main__"):
        return package != "__main__"
    known = module if module in sys.modules else package
    try:
        place = getattr(find_spec(str(known)), "origin", None)
    except (ImportError, ValueError):
        place = None
    if place is None or not Path(place).is_absolute():  # in the interpreter, or nowhere
        return package in sys.stdlib_module_names
    kept = not {"site-packages", "dist-packages"}.isdisjoint(Path(place).parts)
    return kept or Path(place).is_relative_to(_LIBRARY)
