"""How results print themselves: small arrays in full, large ones by their shape, tables aligned."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from .arguments import brief

Class = TypeVar("Class", bound=type)

MOST = 8
"""Most elements of an array that are printed."""


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
