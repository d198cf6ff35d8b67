"""What all figures have in common: axes that are prepared, and names of artists."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any, ClassVar, Literal

import numpy as np

from ..drawing.figure import check_axes, shown_figure

Kind = Literal["space", "plane"]


class Picture:
    """The data of a figure, as attributes, which :meth:`plot` draws.

    Every artist that shows an attribute has the name of this attribute as its ``gid``, and several
    artists of one name are in the order of the data. What lies behind a surface has the name with
    ``_hidden``; an artist that shows no attribute has the name of what it is, such as ``sphere``.
    ``ax.findobj(lambda one: one.get_gid() == "omega")`` finds artists, to test, restyle or animate
    them. An arrow has the attributes ``start`` and ``vector``.
    """

    __slots__ = ()

    _columns: ClassVar[int | None] = None
    _panel_size: ClassVar[tuple[float, float] | None] = None
    """Width and height (inches) of a panel of a new figure."""

    def _kinds(self) -> list[Kind]:
        """What axes each panel has."""
        return ["space"]

    def _draw(self, *axes: Any, **_: Any) -> None:
        """Draw on prepared axes, one for each panel."""
        raise NotImplementedError

    def plot(self, ax: Any | None = None) -> Any:
        """Draw the figure.

        Parameters
        ----------
        ax : matplotlib Axes or Axes3D, or a sequence of one for each panel, optional
            Where to draw; a new figure if not given.

        Returns
        -------
        Axes, or tuple of Axes
            The axes of the only panel, or of all panels.

        Raises
        ------
        ValueError
            If the number of axes is wrong, or one is not two- or three-dimensional, as its panel.
        ImportError
            If Matplotlib is not installed.
        """
        kinds = self._kinds()
        axes = tuple(map(check_axes, self._new_axes(kinds) if ax is None else _flat(ax)))
        if len(axes) != len(kinds):
            raise ValueError(f"ax: this figure has {len(kinds)} panels, got {len(axes)} axes")
        for one, kind in zip(axes, kinds, strict=True):
            if (one.name == "3d") is not (kind == "space"):
                wanted = "3-D axes (projection='3d')" if kind == "space" else "2-D axes"
                raise ValueError(f"ax: this figure needs {wanted}, got projection {one.name!r}")
            if kind == "space":
                one.set_axis_off()
                one.set_proj_type("ortho")
                # Draw surfaces, lines, arrows and text in this order, whatever their depth.
                one.computed_zorder = False
        self._draw(*axes)
        return axes[0] if len(axes) == 1 else axes

    def _new_axes(self, kinds: Sequence[Kind]) -> list[Any]:
        figure = shown_figure()
        across = min(len(kinds), self._columns or len(kinds))
        down = ceil(len(kinds) / max(across, 1))
        if len(kinds) > 1 or self._panel_size:
            wide, high = self._panel_size or (4.2, 4.0)
            figure.set_size_inches(wide * across, high * down)
        return [
            figure.add_subplot(down, across, place, projection="3d" if kind == "space" else None)
            for place, kind in enumerate(kinds, start=1)
        ]


def _flat(ax: Any) -> list[Any]:
    return list(np.ravel(np.asarray(ax, dtype=object)))
