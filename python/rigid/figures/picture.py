"""What all figures have in common: data, axes that are prepared, and names of artists."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..drawing.figure import check_axes, shown_figure

Kind = Literal["space", "plane"]


class Picture:
    """The data of a figure, as attributes, which :meth:`plot` draws.

    The function that computes a figure says what its attributes are. Every artist that shows an
    attribute has the name of this attribute as its ``gid``, and several artists of one name are in
    the order of the data. What lies behind a surface has the name with ``_hidden``; an artist that
    shows no attribute has the name of what it is, such as ``sphere``.
    ``ax.findobj(lambda one: one.get_gid() == "omega")`` finds artists, to test, restyle or animate
    them. An arrow has the attributes ``start`` and ``vector``.
    """

    def __init__(
        self,
        draw: Callable[..., None],
        panels: Sequence[Kind] = ("space",),
        *,
        columns: int | None = None,
        panel_size: tuple[float, float] | None = None,
        **data: Any,
    ) -> None:
        # ``draw`` gets the picture, and axes for each panel, whose size is in inches.
        own = {"_draw": draw, "_panels": panels, "_columns": columns, "_panel_size": panel_size}
        vars(self).update(own | data)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name}: the data of a figure do not change")

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def __repr__(self) -> str:
        """The names of the data."""
        return f"Picture({', '.join(name for name in vars(self) if not name.startswith('_'))})"

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
        given = self._new_axes() if ax is None else np.ravel(np.asarray(ax, dtype=object))
        axes = tuple(map(check_axes, given))
        count = len(self._panels)
        if len(axes) != count:
            raise ValueError(f"ax: this figure has {count} panels, got {len(axes)} axes")
        for one, kind in zip(axes, self._panels, strict=True):
            if (one.name == "3d") is not (kind == "space"):
                wanted = "3-D axes (projection='3d')" if kind == "space" else "2-D axes"
                raise ValueError(f"ax: this figure needs {wanted}, got projection {one.name!r}")
            if kind == "space":
                one.set_axis_off()
                one.set_proj_type("ortho")
                # Draw surfaces, lines, arrows and text in this order, whatever their depth.
                one.computed_zorder = False
        self._draw(self, *axes)
        return axes[0] if len(axes) == 1 else axes

    def _new_axes(self) -> list[Any]:
        figure = shown_figure()
        count = len(self._panels)
        across = min(count, self._columns or count)
        down = ceil(count / max(across, 1))
        if count > 1 or self._panel_size:
            wide, high = self._panel_size or (4.2, 4.0)
            figure.set_size_inches(wide * across, high * down)
        return [
            figure.add_subplot(down, across, place, projection="3d" if kind == "space" else None)
            for place, kind in enumerate(self._panels, start=1)
        ]
