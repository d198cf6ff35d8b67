"""How results with arrays print themselves: small numbers in full, large arrays by their shape."""

from __future__ import annotations

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
