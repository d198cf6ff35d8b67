"""Legends of classes of bodies. The module imports Matplotlib inside its function."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def name_classes(ax: Axes, of_word: Mapping[str, str]) -> None:
    """Draw a legend with a dot in the colour of each class."""
    from matplotlib.lines import Line2D

    dots = [
        Line2D([], [], color=colour, marker="o", linestyle="", markersize=5.0, label=word)
        for word, colour in of_word.items()
    ]
    ax.legend(handles=dots, loc="best", framealpha=0.9)
