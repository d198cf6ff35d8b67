"""Animations of runs, as a page with a player or as a moving picture (GIF, WebP, MP4).

The package knows arrays and words, neither scenes nor results: :meth:`rigid.Run.animate` and
:meth:`rigid.StabilityMap.explore` hand over what it shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, finite_float, positive_int
from .._checks.progress import ProgressOption
from .._checks.warned import warn_caller
from .._files import published
from .film import Film, film_of, side_by_side
from .picture import SUFFIXES, moving_picture
from .story import Recording, story_of_two
from .web import Page, film_page

if TYPE_CHECKING:
    from os import PathLike

__all__ = ["Animation"]

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


def animate(
    recordings: Sequence[Recording],
    path: str | PathLike[str] | None,
    *,
    caption: str | None,
    fps: float,
    size: int,
    progress: ProgressOption,
    **shown: Any,
) -> Path | Animation:
    """Show one motion or two as a film, or write the film; :meth:`rigid.Run.animate` calls this.

    Parameters
    ----------
    recordings : sequence of Recording
        The motion, or two of one length.
    path, caption, fps, size, progress
        As in :meth:`rigid.Run.animate`.
    **shown
        The other arguments of :meth:`rigid.Run.animate`, for :func:`~rigid.animation.film.film_of`.

    Returns
    -------
    pathlib.Path or Animation
        Path of the new file; without a path, the film.
    """
    target = None if path is None else Path(path)
    suffix = ".html" if target is None else target.suffix.lower()
    if suffix != ".html" and suffix not in SUFFIXES:
        raise ValueError(f"path = {str(target)!r}: must end in .html, .gif, .webp or .mp4")
    fps = finite_float("fps", fps, positive=True)
    if fps > 50.0:
        raise ValueError(f"fps = {fps:g}: must be at most 50")
    size = positive_int("size", size, minimum=64)
    films = [film_of(one, **shown) for one in recordings]
    rate = np.max([np.linalg.norm(one.omega, axis=1) for one in recordings], axis=0)
    _warn_of_aliases(films[0], rate, fps if suffix != ".html" else REFRESH)
    story, speed = films[0].story, films[0].speed
    if len(films) == 2:
        story, films = story_of_two(*recordings), side_by_side(films)
    if caption is not None:
        if not isinstance(caption, str):
            raise TypeError(f"caption = {brief(caption)}: must be a text")
        story = caption
    elif speed != 1.0:
        story = f"{story} The film plays {speed:.3g} times as fast as the motion."
    films = [replace(film, story=story) for film in films]
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


def _warn_of_aliases(film: Film, rate: NDArray[np.float64], fps: float) -> None:
    """Warn if a body turns by more than half a turn between frames that are seen."""
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
