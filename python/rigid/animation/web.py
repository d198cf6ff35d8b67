"""Pages of films: the templates of the folder ``page``, put together to one file."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from importlib import resources
from typing import Any

from ..drawing import colours
from ..drawing.shapes import across
from .film import Film
from .raster import AZIMUTH, ELEVATION

__all__ = ["as_json", "assembled", "film_page", "plain", "template"]

SHADERS = ("surface.vert", "surface.frag", "line.vert", "line.frag")


def film_page(films: Sequence[Film]) -> str:
    """A page with the films side by side and the player that draws them."""
    content = {"title": films[0].title, "films": [plain(film) for film in films]}
    scripts = ("vectors.js", "stage.js", "charts.js", "player.js", "film.js")
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
    """The film as plain data: exact attitudes and times, coordinates rounded to visible digits."""
    chart, polhode = film.chart, film.polhode
    return {
        "view": film.view,
        "title": film.title,
        "t": film.t.tolist(),
        "digits": film.digits,
        "shown": film.shown.tolist(),
        "trail": film.trail if math.isfinite(film.trail) else None,
        "attitude": film.attitude.tolist(),
        "frame": [axis.tolist() for axis in across(film.up)],
        "centre": film.centre.tolist(),
        "reach": film.reach,
        "camera": [AZIMUTH, ELEVATION],
        "parts": [
            {
                "kind": part.kind,
                "points": part.points.round(5).tolist(),
                "colours": part.colours,
                "opacity": part.opacity,
                "carried": part.carried,
                "label": part.label,
            }
            for part in film.parts
        ],
        "chart": {
            "label": chart.label,
            "names": chart.names,
            "colours": chart.colours,
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
