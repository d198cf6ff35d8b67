"""How results print themselves: small arrays in full, tables aligned, long lines wrapped."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from dataclasses import fields, is_dataclass
from math import degrees
from textwrap import fill
from typing import Any, TypeVar

import numpy as np

from .arguments import brief

Class = TypeVar("Class", bound=type)

MOST = 8
"""Most elements of an array that are printed."""

WIDTH = 80
"""Columns of a terminal, which no line of a command exceeds."""

LABEL = 12
"""Columns of the name of a fact, before its text."""


def short_repr(result: Class) -> Class:
    """The dataclass, with a ``repr`` in which an array of many elements is its shape and type."""

    def words(self: Any) -> str:
        parts = (f"{field.name}={_short(getattr(self, field.name))}" for field in fields(self))
        return f"{type(self).__name__}({', '.join(parts)})"

    result.__repr__ = words  # type: ignore[assignment]
    return result


def _short(value: Any) -> str:
    if isinstance(value, np.generic):
        return repr(value.item())
    if not isinstance(value, np.ndarray):
        return repr(value) if is_dataclass(value) else brief(value)
    if value.size > MOST:
        return f"<{value.dtype.name} of shape {value.shape}>"
    return repr(value.tolist())


def counted(count: int, noun: str, plural: str = "") -> str:
    """A count and its noun: ``1 time``, ``2,000 times``."""
    return f"{count:,} {noun if count == 1 else plural or f'{noun}s'}"


def aligned(rows: Sequence[Sequence[str]], right: Container[int] = ()) -> list[str]:
    """Lines of the cells side by side, to the left, but in some columns to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if k in right else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ).rstrip()
        for cells in rows
    ]


def labelled(facts: Iterable[tuple[str, str]]) -> str:
    """A line for each fact: its name, then its text."""
    return "\n".join(f"{name:<{LABEL}}{text}" for name, text in facts)


def wrapped(text: str, indent: int = LABEL) -> str:
    """The text with long lines broken at spaces, and their further lines indented."""
    return "\n".join(
        fill(
            line,
            WIDTH,
            subsequent_indent=" " * indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
        for line in text.split("\n")
    )


def angle_words(angle: float) -> str:
    """An angle (rad) in words: in degrees if these are a whole number, but for rounding.

    >>> from math import pi
    >>> angle_words(pi / 2), angle_words(0.5)
    ('90°', '0.5 rad')
    """
    turned = degrees(angle)
    whole = round(turned)
    return f"{whole}°" if whole and abs(turned - whole) <= 1e-9 * whole else f"{angle:g} rad"
