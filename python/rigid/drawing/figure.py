"""New figures, shown where a display or a notebook shows them, legends, and HTML for notebooks."""

from __future__ import annotations

import base64
import html
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any

from .._checks.arguments import brief
from .._checks.extras import install_extra
from .._checks.notebook import in_notebook

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_SIZE: Mapping[str, Any] = {"figsize": (8.0, 6.0), "dpi": 150, "layout": "constrained"}


def new_figure(height: float = 6.0) -> Figure:
    """A figure of this height (inches) that pyplot does not manage.

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError(install_extra("plotting needs matplotlib", "maps")) from None
    return Figure(**{**_SIZE, "figsize": (8.0, height)})


def shown_figure() -> Figure:
    """A figure that a notebook or ``plt.show()`` shows.

    pyplot manages it if the program has imported pyplot, or if this is a notebook. Otherwise
    :func:`new_figure` makes the figure, which needs no display and is deleted with its last name.
    """
    plain = new_figure()
    if in_notebook():
        import matplotlib.pyplot  # noqa: F401
    pyplot: Any = sys.modules.get("matplotlib.pyplot")
    return plain if pyplot is None else pyplot.figure(**_SIZE)


SMALL = 6.4, 5.2
"""Width and height of a picture (inches) whose words are legible on a page of 375 pixels."""


def axes_to_draw_on(ax: Any | None, size: tuple[float, float] | None = None) -> Any:
    """The given axes, or the axes of a new figure of this size (inches)."""
    if ax is not None:
        return check_axes(ax)
    figure = shown_figure()
    if size is not None:
        figure.set_size_inches(*size)
    return figure.add_subplot()


def check_axes(ax: Any) -> Any:
    """``ax`` if it is axes of Matplotlib."""
    if not hasattr(ax, "add_line"):
        raise TypeError(f"ax = {brief(ax)}: must be axes of Matplotlib, or left out")
    return ax


def name_classes(ax: Axes, of_word: Mapping[str, str]) -> None:
    """Draw a legend with a dot in the colour of each class."""
    from matplotlib.lines import Line2D

    dots = [
        Line2D([], [], color=colour, marker="o", linestyle="", markersize=5.0, label=word)
        for word, colour in of_word.items()
    ]
    ax.legend(handles=dots, loc="best", framealpha=0.9)


def html_with_picture(draw: Callable[[Any], object], text: str, *, height: float = 6.0) -> str:
    """A picture and a text below it, or the text alone if Matplotlib is not installed.

    ``draw`` gets the axes to draw on, of a figure 8 inches wide and of this height.
    """
    try:
        figure = new_figure(height)
        draw(figure.add_subplot())
    except ImportError:
        return html_text(text)
    content = BytesIO()
    figure.savefig(content, format="png")
    data = base64.b64encode(content.getvalue()).decode()
    first = html.escape(text.partition("\n")[0], quote=True)
    return f'<img width="640" alt="{first}" src="data:image/png;base64,{data}">{html_text(text)}'


def html_text(text: str) -> str:
    """A text as HTML that keeps its lines."""
    return f'<pre style="white-space: pre-wrap">{html.escape(text)}</pre>'


def html_table(rows: Iterable[Sequence[object]], header: Sequence[str] = ()) -> str:
    """An HTML table with cells aligned to the left."""

    def line(cells: Iterable[object], tag: str) -> str:
        content = "".join(
            f'<{tag} style="text-align: left">{html.escape(str(cell))}</{tag}>' for cell in cells
        )
        return f"<tr>{content}</tr>"

    head = f"<thead>{line(header, 'th')}</thead>" if header else ""
    return f"<table>{head}<tbody>{''.join(line(row, 'td') for row in rows)}</tbody></table>"
