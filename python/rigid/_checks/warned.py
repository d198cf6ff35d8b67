"""Warnings that point at the line of the user."""

from __future__ import annotations

import sys
import warnings

_PACKAGE = __name__.split(".")[0]


def warn_caller(message: str, category: type[Warning] = UserWarning) -> None:
    """Warn of the line outside this package that called into it."""
    level = 1
    frame = sys._getframe()
    while (
        frame.f_globals.get("__name__", "").split(".")[0] == _PACKAGE and frame.f_back is not None
    ):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)
