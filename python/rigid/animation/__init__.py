"""Animations of runs: a page with a player in it, or a GIF, of the frames of a film.

The package uses :mod:`rigid.free`, ``drawing`` and runs. :meth:`rigid.Run.animate` calls it.
"""

from __future__ import annotations

import json
from importlib import resources
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._files import published
from ..drawing.figure import new_figure
from ..drawing.shapes import across
from .film import Film, Part, film_of

if TYPE_CHECKING:
    from os import PathLike

    from ..solve.run import Run

__all__ = ["animate"]

Floats = NDArray[np.float64]

AZIMUTH, ELEVATION = np.deg2rad(35.0), np.deg2rad(26.0)
"""View of a GIF, and initial view of a page."""

SHOWN = (0.02, 655.0)
"""Shortest and longest time of a GIF frame (s), limits of browsers and of the format."""

INCHES, DOTS = 4.8, 100
"""Size of a GIF: 480 pixels."""


def animate(
    run: Run,
    path: str | PathLike[str],
    *,
    view: str | None = None,
    speed: float = 1.0,
    body: int | None = None,
) -> Path:
    """Write an animation of a run; see :meth:`rigid.Run.animate`, which calls this.

    Parameters
    ----------
    run : Run
        Run with attitudes at two times or more. Each time becomes a frame; there is no
        interpolation between the times.
    path : path
        ``.html`` for a page that a browser plays without a network, and whose view you turn with
        the pointer; ``.gif`` for an animated picture, which needs Matplotlib and Pillow.
    view : str, optional
        For a free body ``"box"``, the box (or the box with equal moments) with omega and L;
        ``"cones"``, the body cone of a symmetric top rolling on the space cone; or ``"poinsot"``,
        the inertia ellipsoid rolling on the invariable plane. For a heavy top ``"top"``, with the
        path of its axis. Default for a free body: the box for a :meth:`rigid.Body.box` and for a
        body under torque or damping, else the cones if two moments are equal, else the ellipsoid.
    speed : float
        Factor by which the animation is faster than the motion.
    body : int, optional
        Index of the body to show, if the run has many bodies.

    Returns
    -------
    pathlib.Path
        Path of the new file.

    Raises
    ------
    ImportError
        If the animation is a GIF and Matplotlib is not installed.
    OSError
        If the file cannot be written, or its name is that of something else than a file. An older
        file stays as it was.
    TypeError, ValueError
        Naming the argument, its value and the rule: an unknown suffix or view, a run without
        attitudes, of one time or not finite, a body at rest, cones of an asymmetric body or one
        under torque, frames too short for a GIF.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid.animation import animate
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> run = rigid.simulate(top, [0.0, 0.0, 5.0], tilted, t=np.linspace(0.0, 10.0, 301))
    >>> animate(run, "top.html").name
    'top.html'
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in (".html", ".gif"):
        raise ValueError(f"path = {str(target)!r}: must end in .html or .gif")
    film = film_of(run, view=view, speed=speed, body=body)
    content = _page(film).encode() if suffix == ".html" else _gif(film)
    with published(target) as file:
        file.write(content)
    return target


def _page(film: Film) -> str:
    """A page with the film and the player that draws it."""
    text = json.dumps(_plain(film), separators=(",", ":"), allow_nan=False)
    page = resources.files("rigid").joinpath("player.html").read_text(encoding="utf-8")
    # HTML ends a script at the first "</", even inside a string.
    return page.replace("{{film}}", text.replace("<", "\\u003c"))


def _plain(film: Film) -> dict[str, Any]:
    """The film as plain data: exact attitudes and times, coordinates rounded to visible digits."""
    return {
        "view": film.view,
        "title": film.title,
        "t": film.t.tolist(),
        "digits": film.digits,
        "shown": film.shown.tolist(),
        "attitude": film.attitude.tolist(),
        "frame": np.stack(across(film.up)).tolist(),
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
    }


def _gif(film: Film) -> bytes:
    """The frames, drawn; times are rounded to a hundredth of a second."""
    shortest, longest = SHOWN
    outside = (film.shown < shortest * (1.0 - 1e-9)) | (film.shown > longest)
    if outside.any():
        k = int(outside.argmax())
        raise ValueError(
            f"t: frame {k} of a GIF would be shown for {film.shown[k]:g} s: must be between "
            f"{shortest} and {longest:g} s; choose other times or another speed"
        )
    due = np.rint(100.0 * np.append(0.0, np.cumsum(film.shown)))
    hundredths = np.diff(due).astype(np.int64)
    figure = new_figure()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from PIL import Image

    figure.set(size_inches=(INCHES, INCHES), dpi=DOTS, layout_engine="none")
    canvas = FigureCanvasAgg(figure)
    reach = 1.08 * film.reach
    ax = figure.add_axes((0.03, 0.03, 0.94, 0.94), xlim=(-reach, reach), ylim=(-reach, reach))
    ax.set_axis_off()
    figure.text(0.02, 0.985, film.title, fontsize=8, color="#555555", va="top", wrap=True)
    clock = figure.text(0.02, 0.02, "", fontsize=9, color="#333333", family="monospace")
    drawn = PolyCollection([], closed=True, capstyle="round")
    ax.add_collection(drawn)
    named = [part for part in film.parts if part.label]
    names = [ax.text(0, 0, part.label, fontsize=11, ha="center", va="center") for part in named]
    camera = _camera(film.up)
    images = []
    for k, time in enumerate(film.t):
        pieces = [piece for part in film.parts for piece in _pieces(part, film, k, camera)]
        pieces.sort(key=lambda piece: piece[0])
        drawn.set_verts([piece[1] for piece in pieces])
        drawn.set_facecolor([piece[2] for piece in pieces])
        drawn.set_edgecolor([piece[3] for piece in pieces])
        drawn.set_linewidth([piece[4] for piece in pieces])
        for name, part in zip(names, named, strict=True):
            tip = (part.placed(film.attitude[k], k)[0] - film.centre) @ camera.T
            outward = _unit((tip + film.centre @ camera.T)[:2])
            name.set_position(tip[:2] + 0.08 * reach * outward)
            name.set_color(part.colours[0])
        clock.set_text(f"t = {time:.{film.digits}f} s")
        canvas.draw()  # type: ignore[no-untyped-call]
        pixels = np.asarray(canvas.buffer_rgba())[..., :3]  # type: ignore[no-untyped-call]
        image = Image.fromarray(np.ascontiguousarray(pixels))
        images.append(image.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE))
    content = BytesIO()
    duration = (10 * hundredths).tolist()
    images[0].save(
        content, "GIF", save_all=True, append_images=images[1:], duration=duration, loop=0
    )
    return content.getvalue()


def _camera(up: Floats) -> Floats:
    """Directions to the right, upward and towards the viewer, as rows of components in space."""
    first, second, along = across(up)
    level = np.cos(AZIMUTH) * first + np.sin(AZIMUTH) * second
    eye = np.cos(ELEVATION) * level + np.sin(ELEVATION) * along
    right = np.cross(along, level)
    return np.stack([right, np.cross(eye, right), eye])


Colour = tuple[float, float, float, float]
Piece = tuple[float, Floats, Colour, Colour, float]
"""Depth, corners in the picture, colours of the inside and of the edge, width of the edge."""


def _pieces(part: Part, film: Film, k: int, camera: Floats) -> list[Piece]:
    """The polygons of a part to paint; the script of player.html computes the same polygons."""
    from matplotlib.colors import to_rgb

    points = (part.placed(film.attitude[k], k) - film.centre) @ camera.T
    rgb = np.array([to_rgb(colour) for colour in part.colours])
    reach, clear = film.reach, (0.0, 0.0, 0.0, 0.0)
    if part.kind == "faces":
        normal = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
        size = np.linalg.norm(normal, axis=1)
        light = 0.7 + 0.3 * np.abs(normal[:, 2]) / np.where(size > 0.0, size, 1.0)
        colours = np.resize(rgb, (len(points), 3)) * light[:, np.newaxis]
        depths = points[..., 2].mean(axis=1)
        return [
            (float(depth), face[:, :2], (r, g, b, part.opacity), (1.0, 1.0, 1.0, 0.3), 0.4)
            for depth, face, (r, g, b) in zip(depths, points, colours, strict=True)
        ]
    r, g, b = rgb[0]
    ink = (r, g, b, 1.0)
    if part.kind == "dot":
        turn = np.linspace(0.0, 2.0 * np.pi, 13)
        ring = points[0, :2] + 0.022 * reach * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return [(float(points[0, 2]) + 0.1 * reach, ring, ink, (1.0, 1.0, 1.0, 1.0), 0.8)]
    tip, start = points[0], -film.centre @ camera.T
    if part.kind == "arrow":
        points = start + np.linspace(0.0, 1.0, 9)[:, np.newaxis] * (tip - start)
    # Paint curves on surfaces after the surfaces.
    depths = 0.5 * (points[1:, 2] + points[:-1, 2]) + 0.03 * reach
    width = 1.8 if part.kind == "arrow" else 1.2
    pieces: list[Piece] = [
        (float(depth), np.stack(ends), clear, ink, width)
        for depth, *ends in zip(depths, points[:-1, :2], points[1:, :2], strict=True)
    ]
    if part.kind == "arrow":
        ahead = 0.07 * reach * _unit((tip - start)[:2])
        aside = 0.35 * np.array([-ahead[1], ahead[0]])
        head = np.stack([tip[:2], tip[:2] - ahead + aside, tip[:2] - ahead - aside])
        pieces.append((float(tip[2]) + 0.03 * reach, head, ink, clear, 0.0))
    return pieces


def _unit(vector: Floats) -> Floats:
    size = np.linalg.norm(vector)
    unit: Floats = vector / size if size > 0.0 else np.zeros_like(vector)
    return unit
