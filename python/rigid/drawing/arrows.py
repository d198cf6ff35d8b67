"""Arrows with their vectors as attributes. The module imports Matplotlib."""

from __future__ import annotations

from math import hypot
from typing import Any

import numpy as np
from matplotlib.patches import FancyArrowPatch
from mpl_toolkits.mplot3d.proj3d import proj_transform
from numpy.typing import NDArray

_STYLE: dict[str, Any] = {
    "arrowstyle": "-|>",
    "mutation_scale": 13.0,
    "shrinkA": 0.0,
    "shrinkB": 0.0,
    "joinstyle": "miter",
    "capstyle": "butt",
}

GAP = 5.0
"""Distance between the tip of an arrow and its name (points)."""


class Arrow(FancyArrowPatch):
    """An arrow from ``start`` along ``vector``, (2,) in a plane or (3,) in space."""

    def __init__(
        self, start: NDArray[np.float64], vector: NDArray[np.float64], **style: Any
    ) -> None:
        self.start, self.vector = start, vector
        self._name: Any = None
        super().__init__(tuple(start[:2]), tuple((start + vector)[:2]), **(_STYLE | style))

    def write(self, ax: Any, text: str, **style: Any) -> None:
        """Name the arrow, beyond its tip, which in space is placed when the arrow is drawn."""
        style |= {"textcoords": "offset points"}
        if len(self.vector) == 3:
            self._name = ax.annotate(text, (0.0, 0.0), (0.0, 0.0), annotation_clip=False, **style)
            self._name.set_in_layout(False)
        else:
            self._name = ax.annotate(text, (0.0, 0.0), (0.0, 0.0), **style)
            self._place(self.start, self.start + self.vector)

    def _place(self, start: Any, tip: Any) -> None:
        if self._name is None:
            return
        tail, head = self._name.axes.transData.transform([start, tip])
        length = hypot(*(head - tail))
        x, y = (head - tail) / length if length > 0.0 else (0.0, 1.0)
        self._name.xy = tuple(tip)
        self._name.set_position((GAP * x, GAP * y))
        self._name.set(
            ha="left" if x > 0.4 else "right" if x < -0.4 else "center",
            va="bottom" if y > 0.4 else "top" if y < -0.4 else "center",
        )

    def do_3d_projection(self, renderer: Any = None) -> float:
        """Project the arrow and its name to the page; returns the depth of the arrow."""
        ends = np.stack([self.start, self.start + self.vector], axis=1)
        x, y, depth = proj_transform(*ends, self.axes.M)  # type: ignore[union-attr]
        self.set_positions((x[0], y[0]), (x[1], y[1]))
        self._place((x[0], y[0]), (x[1], y[1]))
        return float(np.min(depth))
