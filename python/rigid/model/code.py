"""The code of a function of the user: its source, the names in it, and its package."""

from __future__ import annotations

import ctypes
import dis
import functools
import inspect
import os
import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, MethodType
from typing import Any

__all__ = [
    "byte_code",
    "digest",
    "imports",
    "is_installed",
    "is_machine_code",
    "is_special",
    "is_wrapper",
    "name_of",
    "named_globals",
    "package_of",
    "plain",
    "qualified",
    "source_of",
]

_LOADS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
"""Instructions that take a global."""

_OF_CTYPES: Any = ctypes.CFUNCTYPE(None).__base__
"""The class of functions of ctypes."""

_LIBRARY = Path(os.__file__).parent
"""The folders of the modules of Python."""


def digest(kind: str, *parts: bytes) -> bytes:
    """A digest of parts of any length."""
    whole = sha256(kind.encode())
    for part in parts:
        whole.update(len(part).to_bytes(8, "little"))
        whole.update(part)
    return whole.digest()


def plain(function: Any) -> FunctionType | type | None:
    """The function whose code runs, or the class; None for objects without Python code."""
    while not isinstance(function, FunctionType | type):
        if isinstance(function, functools.partial):
            function = function.func
        elif isinstance(function, MethodType):
            function = function.__func__
        elif is_wrapper(function):
            function = function.__wrapped__
        elif is_installed(type(function).__module__):
            return None
        else:
            function = inspect.getattr_static(type(function), "__call__")
    return function


def source_of(function: FunctionType | type) -> str | None:
    """The source of a class, or of a function without its wrapped function; None if unknown.

    It is read once: its file may change later, what runs does not.
    """
    owner = function if isinstance(function, type) else function.__code__
    known = _sources.get(id(owner))
    if known is None:
        try:
            known = owner, inspect.getsource(owner)
        except (OSError, TypeError):
            known = owner, None
        _sources[id(owner)] = known  # the owner is kept, and with it its id
    return known[1]


_sources: dict[int, tuple[object, str | None]] = {}


def byte_code(code: CodeType) -> bytes:
    """The instructions of a function without a source, which depend on the version of Python."""
    constants = [
        byte_code(one).hex()
        if isinstance(one, CodeType)
        else sorted(map(repr, one))
        if isinstance(one, frozenset)
        else one
        for one in code.co_consts
    ]
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_flags
    counts = code.co_argcount, code.co_kwonlyargcount, code.co_posonlyargcount
    parts = (constants, names, counts)
    return digest("code", code.co_code, code.co_exceptiontable, repr(parts).encode())


def qualified(value: Any) -> str:
    """Module and name of a function or class."""
    owner = getattr(value, "__module__", None) or type(value).__module__
    return f"{owner}.{getattr(value, '__qualname__', getattr(value, '__name__', '?'))}"


def package_of(module: str | None) -> str:
    """The package of a module; empty if there is none."""
    return (module or "").partition(".")[0]


def is_installed(module: str | None) -> bool:
    """Whether a module belongs to Python, to rigid or to an installed package."""
    package = package_of(module)
    if package in ("", "rigid", "__main__"):
        return package != "__main__"
    loaded = sys.modules.get(module or "") or sys.modules.get(package)
    place = getattr(loaded, "__file__", None)
    if loaded is None:
        from importlib.util import find_spec  # takes longer to import than this module

        try:
            place = getattr(find_spec(package), "origin", None)
        except (ImportError, ValueError):
            place = None
    if place is None or not Path(place).is_absolute():  # in the interpreter, or nowhere
        return package in sys.stdlib_module_names
    found = Path(place)
    kept = not {"site-packages", "dist-packages"}.isdisjoint(found.parts)
    return kept or found.is_relative_to(_LIBRARY)


def name_of(value: Any) -> str | None:
    """The name by which a function or class can be imported; None if there is none."""
    found: Any = sys.modules.get(str(getattr(value, "__module__", None)))
    for part in str(getattr(value, "__qualname__", "?")).split("."):
        found = getattr(found, part, None)
    return qualified(value) if found is value else None


def is_wrapper(value: Any) -> bool:
    """Whether an installed package wrapped a function in an object, as ``lru_cache`` does."""
    kind = type(value)
    wrapped = not isinstance(value, FunctionType | type) and is_installed(kind.__module__)
    return wrapped and isinstance(getattr(value, "__wrapped__", None), FunctionType)


def is_machine_code(value: Any) -> bool:
    """Whether the function is one of ctypes or cffi and calls machine code."""
    return isinstance(value, _OF_CTYPES) or type(value).__module__ == "_cffi_backend"


def is_special(name: str) -> bool:
    """Whether Python gives a name its meaning, as to ``__name__``."""
    return name.startswith("__") and name.endswith("__")


def named_globals(code: CodeType) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Globals that a code and its inner codes name, with the attributes that follow each."""
    chain: list[str] = []
    for step in dis.get_instructions(code):
        if chain and step.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            chain.append(step.argval)
            continue
        if chain:
            yield chain[0], tuple(chain[1:])
        named = step.opname in _LOADS and not is_special(step.argval)
        chain = [step.argval] if named else []
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from named_globals(one)


def imports(code: CodeType) -> Iterator[str]:
    """Modules that a code imports when it runs; the name of a relative one begins with a dot."""
    level = 0
    for step in dis.get_instructions(code):
        if step.opname == "IMPORT_NAME":
            yield "." * level + step.argval
        if step.opname in ("LOAD_CONST", "LOAD_SMALL_INT") and isinstance(step.argval, int):
            level = step.argval
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from imports(one)
