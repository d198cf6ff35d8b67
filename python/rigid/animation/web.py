"""Pages of films: the templates of the folder ``page``, put together to one file."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from typing import Any, ClassVar

from ..drawing import colours
from ..drawing.shapes import across
from .film import Film
from .raster import AZIMUTH, ELEVATION

SHADERS = ("surface.vert", "surface.frag", "line.vert", "line.frag")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Page:
    """A page that a notebook shows.

    Attributes
    ----------
    page : str
        The page as HTML; it needs no network.
    """

    title: ClassVar[str]
    height: ClassVar[int]
    page: str

    def __repr__(self) -> str:
        """Size of the page."""
        return f"{type(self).__name__}(page of {len(self.page) / 1000:.0f} kB)"

    def _repr_html_(self) -> str:
        """The page in a frame, for notebooks."""
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{self.height}" '
            f'style="border: 0" allow="fullscreen; clipboard-write" title="{self.title}"></iframe>'
        )


def film_page(films: Sequence[Film]) -> str:
    """A page with the films side by side and the player that draws them."""
    parts = [plain(film) for film in films]
    content = {"title": films[0].title, "story": films[0].story, "films": parts}
    scripts = ("vectors.js", "stage.js", "charts.js", "save.js", "player.js", "film.js")
    return assembled("film.html", ("film.css",), scripts, film=content)


def assembled(
    page: str, styles: Sequence[str], scripts: Sequence[str], **data: dict[str, Any] | None
) -> str:
    """The template of a page with its styles, shaders, scripts and data."""
    shaders = json.dumps({name: template(name) for name in SHADERS})
    pieces = {
        "style": "".join(map(template, styles)),
        "script": "".join([f"const SHADERS = {shaders};\n", *map(template, scripts)]),
    }
    for name, content in data.items():
        # HTML ends a script at the first "</", even inside a string.
        pieces[name] = as_json(content).replace("<", "\\u003c")
    filled = template(page)
    for name, piece in pieces.items():
        filled = filled.replace(f"{{{{{name}}}}}", piece)
    return filled


def as_json(content: dict[str, Any] | None) -> str:
    """Plain data as the scripts of pages read them."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False)


def template(name: str) -> str:
    """The text of a template."""
    return resources.files(__package__).joinpath("page", name).read_text(encoding="utf-8")


def plain(film: Film) -> dict[str, Any]:
    """The film as plain data: exact attitudes, other numbers rounded to visible digits."""
    chart, polhode = film.chart, film.polhode
    kept = ("view", "title", "name", "digits", "reach", "grounded")
    return {name: getattr(film, name) for name in kept} | {
        "t": film.t.round(film.digits + 5).tolist(),
        "shown": [float(f"{value:.7g}") for value in film.shown],
        "trail": film.trail if math.isfinite(film.trail) else None,
        "attitude": film.attitude.tolist(),
        "frame": [axis.tolist() for axis in across(film.up)],
        "centre": film.centre.tolist(),
        "camera": [AZIMUTH, ELEVATION],
        "parts": [asdict(part) | {"points": part.points.round(5).tolist()} for part in film.parts],
        "chart": asdict(chart)
        | {
            "axes": [ink.colour for ink in colours.AXES],
            "values": [[float(f"{value:.6g}") for value in row] for row in chart.values],
        },
        "polhode": None
        if polhode is None
        else {
            "points": polhode.points.round(4).tolist(),
            "separatrix": [circle.round(4).tolist() for circle in polhode.separatrix],
        },
    }
