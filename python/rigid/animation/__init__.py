"""Animations of runs, as a page with a player or as a moving picture (GIF, WebP, MP4).

The package uses :mod:`rigid.free`, ``drawing`` and runs. :meth:`rigid.Run.animate` calls it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, positive_int
from .._checks.progress import ProgressOption
from .._checks.warned import warn_caller
from .._files import published
from .film import Film, film_of, side_by_side
from .picture import SUFFIXES, moving_picture
from .states import pair_of, scene_of, states_of
from .story import story_of_two
from .web import Page, film_page

if TYPE_CHECKING:
    from os import PathLike

    from ..solve.run import Run

__all__ = ["Animation", "animate"]

REFRESH = 60.0
"""Frames in a second that a page shows, the rate of most displays."""


class Animation(Page):
    """A film of a run as a page with a player; a notebook shows the page.

    Attributes
    ----------
    page : str
        The page as HTML; it needs no network.
    """

    __slots__ = ()

    title = "film of a motion"
    height = 560


@overload
def animate(
    run: Run,
    path: None = None,
    *,
    view: str | None = None,
    speed: float | None = None,
    body: int | Sequence[int] | None = None,
    trail: float | None = None,
    shape: tuple[ArrayLike, ArrayLike] | None = None,
    caption: str | None = None,
) -> Animation: ...


@overload
def animate(
    run: Run,
    path: str | PathLike[str],
    *,
    view: str | None = None,
    speed: float | None = None,
    body: int | Sequence[int] | None = None,
    trail: float | None = None,
    shape: tuple[ArrayLike, ArrayLike] | None = None,
    caption: str | None = None,
    fps: float = 25.0,
    size: int = 480,
    progress: ProgressOption = None,
) -> Path: ...


def animate(
    run: Run,
    path: str | PathLike[str] | None = None,
    *,
    view: str | None = None,
    speed: float | None = None,
    body: int | Sequence[int] | None = None,
    trail: float | None = None,
    shape: tuple[ArrayLike, ArrayLike] | None = None,
    caption: str | None = None,
    fps: float = 25.0,
    size: int = 480,
    progress: ProgressOption = None,
) -> Path | Animation:
    """Show a run as a film, or write the film; see :meth:`rigid.Run.animate`, which calls this.

    Parameters
    ----------
    run : Run
        Run with attitudes at two times or more. Each time becomes a frame; there is no
        interpolation between the times.
    path : path, optional
        ``.html`` for a page that a browser plays without a network, and whose view you turn with
        the pointer; ``.gif``, ``.webp`` or ``.mp4`` for a moving picture, which needs Matplotlib
        and Pillow, and ffmpeg or imageio-ffmpeg for ``.mp4``. Without a path the film is returned
        and a notebook shows it.
    view : str, optional
        For a free body ``"box"``, the box (or the box with equal moments) with omega and L;
        ``"cones"``, the body cone of a symmetric top rolling on the space cone; or ``"poinsot"``,
        the inertia ellipsoid rolling on the invariable plane. For a heavy top ``"top"``, with the
        path of its axis. Default for a free body: the box for a :meth:`rigid.Body.box` and for a
        body under torque or damping, else the cones if two moments are equal, else the ellipsoid.
    speed : float, optional
        Factor by which the film is faster than the motion. Default: 1, and for a motion of more
        than 20 s so that the film lasts 20 s.
    body : int or two int, optional
        Index of the body to show, if the run has many bodies; two indices show two bodies side by
        side, with one scale. Default: both bodies of a run of two.
    trail : float, optional
        Length of trails in seconds of the run, ``math.inf`` for trails without end. Default: a
        quarter of the run, and without end in the view ``"poinsot"``.
    shape : tuple (vertices, faces), optional
        The surface of the body, to be shown instead of a box or a top: corners of shape (v, 3), and
        for each polygon the indices of its corners, shape (f, n) with n >= 3;
        :func:`rigid.meshes.read_mesh` returns both. The origin of the corners is the centre of
        mass, or the fixed point of a heavy top. The corners have the axes of the run: the principal
        axes, or ``frame``, if the run has one.
    caption : str, optional
        The sentence above the film. Default: what happens in the motion.
    fps : float
        Most frames in a second of a moving picture: closer frames are omitted. At most 50, which
        is what browsers show of a GIF.
    size : int
        Height of a moving picture in pixels, 64 or more.
    progress : None, bool or callable
        Progress of a moving picture, as in :func:`rigid.stability_map`.

    Returns
    -------
    pathlib.Path or Animation
        Path of the new file; without a path, the film.

    Raises
    ------
    ImportError
        If what a moving picture needs is not installed.
    OSError
        If the file cannot be written, or the path names something other than a file, or
        ffmpeg fails. An older file stays as it was.
    TypeError, ValueError
        Naming the argument, its value and the rule: an unknown suffix or view, a run without
        attitudes, of one time or not finite, a body at rest, cones of an asymmetric body or one
        under torque, a shape that is no mesh, frames too long for a picture.

    Warns
    -----
    UserWarning
        If the body turns by more than half a turn from one frame to the next, as frames are seen:
        the film shows another motion.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid.animation import animate
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
    >>> run = rigid.simulate(top, [0.0, 0.0, 5.0], tilted, t=np.linspace(0.0, 10.0, 301))
    >>> animate(run, "top.html").name
    'top.html'

    A body from a mesh: the corners move to the centre of mass.

    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.5]])
    >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> solid = rigid.meshes.mesh_properties(corners, faces, mass=1.0)
    >>> body, axes = rigid.Body.from_properties(solid)
    >>> run = rigid.simulate(body, [0.1, 5.0, 0.1], t=np.linspace(0.0, 4.0, 201), frame=axes)
    >>> animate(run, "mesh.html", shape=(corners - solid.centre, faces)).name
    'mesh.html'
    """
    target = None if path is None else Path(path)
    suffix = ".html" if target is None else target.suffix.lower()
    if suffix != ".html" and suffix not in SUFFIXES:
        raise ValueError(f"path = {str(target)!r}: must end in .html, .gif, .webp or .mp4")
    fps = finite_float("fps", fps, positive=True)
    if fps > 50.0:
        raise ValueError(f"fps = {fps:g}: must be at most 50")
    size = positive_int("size", size)
    if size < 64:
        raise ValueError(f"size = {size}: must be at least 64")
    indices: Sequence[int | None]
    if isinstance(body, Sequence):
        if not 1 <= len(body) <= 2:
            raise ValueError(f"body = {brief(body)}: must be one index or two")
        indices = body
    else:
        indices = pair_of(run) if body is None else (body,)
    films = [
        film_of(run, view=view, speed=speed, body=one, trail=trail, shape=shape) for one in indices
    ]
    if len({len(film.t) for film in films}) > 1:
        raise ValueError(f"body = {brief(indices)}: their records end at different times")
    states = [states_of(run, one) for one in indices]
    rates = [np.linalg.norm(omega, axis=1) for omega, _ in states]
    _warn_of_aliases(films[0], rates, fps if suffix != ".html" else REFRESH)
    if len(films) == 2:
        films = side_by_side(films)
        omega, attitude = (np.stack(arrays) for arrays in zip(*states, strict=True))
        left, right = (scene_of(run, one) for one in indices)
        story = story_of_two((left, right), films[0].t, omega, attitude)
        films = [replace(film, story=story) for film in films]
    speed = films[0].speed
    if caption is None and speed != 1.0:
        faster = f"The film plays {speed:.3g} times as fast as the motion."
        films = [replace(film, story=f"{film.story} {faster}") for film in films]
    if caption is not None:
        if not isinstance(caption, str):
            raise TypeError(f"caption = {brief(caption)}: must be a text")
        films = [replace(film, story=caption) for film in films]
    if suffix == ".html":
        page = film_page(films)
        if target is None:
            return Animation(page)
        content = page.encode()
    else:
        content = moving_picture(films, suffix, fps=fps, size=size, progress=progress)
    assert target is not None
    with published(target) as file:
        file.write(content)
    return target


def _warn_of_aliases(film: Film, rates: Sequence[NDArray[np.float64]], fps: float) -> None:
    """Warn if a body turns by more than half a turn between frames that are seen."""
    rate = np.maximum.reduce(rates)
    steps = np.abs(np.diff(film.t))
    turns = np.maximum(rate[1:], rate[:-1]) * np.maximum(steps, film.speed / fps)
    k = int(turns.argmax())
    if turns[k] <= np.pi:
        return
    fastest = max(rate[k], rate[k + 1])
    if steps[k] * fps > film.speed:
        advice = f"give times at most {np.pi / fastest:.2g} s apart"
    else:
        advice = f"give speed={np.pi * fps / fastest:.2g} or less"
    warn_caller(
        f"t, speed = {film.speed:.3g}: the body turns by up to {turns[k]:.3g} rad between frames, "
        f"and the film shows another motion; {advice}"
    )
