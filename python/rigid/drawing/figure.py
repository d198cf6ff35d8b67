"""A new figure that needs no display."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["new_figure"]


def new_figure() -> Figure:
    """A figure that pyplot does not manage; ImportError if Matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError("plotting needs matplotlib: pip install 'rigid[maps]'") from None
    return Figure(figsize=(8.0, 6.0), dpi=150, layout="constrained")
