"""Names along lines: beside a straight stretch that no other line or name is near."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._checks.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes


SIZE = 9.0
"""Size of the font (points)."""

LETTER, LINE = 0.56, 1.25
"""Mean width of a letter, and height of a line, over the size of the font."""

MOST_LINES = 3
"""Most lines of a name: where a line is not straight for long, the name is broken."""


def write_along(
    ax: Axes, words: str, paths: Sequence[Floats], others: Sequence[Floats]
) -> Floats | None:
    """Write a name along one of the paths, rotated as the path is.

    Parameters
    ----------
    ax : matplotlib Axes
    words : str
        The name; formulas in dollars are not broken.
    paths : sequence of ndarray, shape (n, 2)
        The line, in data coordinates.
    others : sequence of ndarray, shape (n, 2)
        Other lines, which the name must not cover.

    Returns
    -------
    ndarray, shape (2, 2), or None
        The ends of the name's middle line, in data coordinates; None if there was no room.
    """
    from matplotlib.patheffects import Normal, Stroke

    figure = ax.get_figure(root=True)
    assert figure is not None
    em = SIZE / 72.0 * figure.dpi
    taken = [ax.transData.transform(_dense(path)) for path in others]
    avoided = np.concatenate([np.zeros((0, 2)), *taken])
    frame = ax.get_window_extent()
    low, high = np.array([frame.x0, frame.y0]), np.array([frame.x1, frame.y1])
    for text in _broken(words):
        width = max(len(_plain(line)) for line in text.split("\n"))
        half, height = 0.5 * LETTER * em * width, LINE * em * (1 + text.count("\n"))
        best, found = 0.6 * em, None
        for path in paths:
            for line, up, bulge, above in _stretches(ax.transData.transform(path), half, em):
                base = 0.5 * (line[0] + line[-1]) + (bulge.max() if above else bulge.min()) * up
                far = base + (height if above else -height) * up
                right = np.array([up[1], -up[0]])
                corners = np.array([one + s * half * right for one in (base, far) for s in (-1, 1)])
                if not ((corners > low + 0.3 * em) & (corners < high - 0.3 * em)).all():
                    continue
                offset = avoided - 0.5 * (base + far)
                covered = (np.abs(offset @ right) < half + 0.3 * em) & (
                    np.abs(offset @ up) < 0.5 * height + 0.3 * em
                )
                if not covered.any() and np.ptp(bulge) < best:
                    best, found = float(np.ptp(bulge)) - 0.02 * em, (base, up, above)
        if found is not None:
            base, up, above = found
            right = half * np.array([up[1], -up[0]])
            centre = base + (0.5 if above else -0.5) * height * up
            (x, y), *ends = ax.transData.inverted().transform(
                [base, centre - right, centre + right]
            )
            written = ax.text(
                x,
                y,
                text,
                color="white",
                fontsize=SIZE,
                linespacing=1.05,
                rotation=math.degrees(math.atan2(-up[0], up[1])),
                rotation_mode="anchor",
                ha="center",
                va="bottom" if above else "top",
                in_layout=False,
            )
            written.set_path_effects([Stroke(linewidth=2.2, foreground="black"), Normal()])
            return np.array(ends)
    return None


def _dense(path: Floats) -> Floats:
    """More points on a line."""
    share, k = np.linspace(0.0, len(path) - 1.0, 8 * len(path)), np.arange(len(path))
    return np.stack([np.interp(share, k, part) for part in path.T], axis=1)


def _stretches(
    points: Floats, half: float, em: float
) -> Iterator[tuple[Floats, Floats, Floats, bool]]:
    """Stretches of a line: their points, the normal of the chord, the distances from the chord.

    The last value says whether the hollow side is the upper one.
    """
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    for middle in np.arange(half, along[-1] - half, 0.5 * em):
        stretch = middle + np.linspace(-half, half, 21)
        line = np.stack([np.interp(stretch, along, part) for part in points.T], axis=1)
        chord = line[-1] - line[0]
        if chord[0] < 0.0 or (chord[0] == 0.0 and chord[1] < 0.0):
            line, chord = line[::-1], -chord
        up = np.array([-chord[1], chord[0]]) / max(float(np.hypot(*chord)), 1e-9)
        bulge = (line - line[0]) @ up
        yield line, up, bulge, bool(abs(bulge.max()) <= abs(bulge.min()))
        if np.ptp(bulge) < 0.1 * em:
            yield line, up, bulge, bool(abs(bulge.max()) > abs(bulge.min()))


def _plain(words: str) -> str:
    """About as many letters as are drawn."""
    return re.sub(r"\\[a-z]+|[${}_,\\]", "", words)


def _broken(words: str) -> Iterator[str]:
    """The name in one line, and in more; formulas and times stay whole."""
    yield words
    whole = re.sub(r"\$.*?\$|t = \S+ \S+", lambda found: found[0].replace(" ", "\0"), words)
    letters = len(_plain(words))
    for count in range(2, MOST_LINES + 1):
        lines = [""]
        for word in whole.split(" "):
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and len(_plain(longer)) > letters / count + 3:
                lines.append(word)
            else:
                lines[-1] = longer
        if len(lines) > 1:
            yield "\n".join(lines).replace("\0", " ")
