"""The one colour table of all pictures, and the labels that go with it.

Colour-blind readers can distinguish the hues, which are so dark that lines and texts are legible on
white; ``on_ground`` gives the brighter ones for dark axes. The components and axes x, y, z are
blue, green and vermilion. Every vector and frame has one colour and one name in all figures; a
figure with other quantities has a key.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

HUES = {
    "black": "#000000",
    "blue": "#0062a3",
    "green": "#00825e",
    "vermilion": "#c25200",
    "orange": "#946800",
    "purple": "#ae3f86",
    "sky": "#1b7bb5",
    "violet": "#6b4fbb",
}
"""The hues of lines and texts on white. Their contrast is at least 4.5, as a text needs.

The hues come from Okabe and Ito, without yellow and with violet; they are darker than in the
original, whose orange and sky are lost on white.
"""

NEUTRAL = "#555555"
"""Colour of text, outlines of bodies, and other lines that show no axis."""

FAINT = "#949494"
"""Help lines, circles of reference and hidden edges: the contrast of lines, 3, but no text."""

AMBER = "#b87200"
"""Yellow as dark as lines need on white; texts have :data:`HUES`."""

FACE = "#56b4e9"
"""Faces of bodies, which no line and no text has."""

FACE_STRIPE, ON_FACE = "#a5d5f2", "#0b5a86"
"""Paler faces beside the others, and lines on them, on light and on dark ground."""

SURFACE, BODY_FACE = "#f2f2f2", "#c9e5f7"
"""Faces below curves: of surfaces of reference, and of bodies."""

IMPOSSIBLE, ABSENT = ("#e0e0e0", "#9e9e9e"), ("#fdfdfd", "#bfbfbf")
"""Face and strokes of pixels of impossible bodies, and of pixels that are not computed."""

PALE = "#d6d6d6"
"""What is only background to the lines that matter."""

BAND = "#b7b7b7"
"""A broad line behind others."""

GRID = "#efefef"
"""Lines of a grid."""

_ON_DARK = {
    HUES["black"]: "#ffffff",
    HUES["blue"]: "#4fa3e0",
    HUES["green"]: "#1fbf8f",
    HUES["vermilion"]: "#f0803c",
    HUES["orange"]: "#e6a817",
    HUES["purple"]: "#de8cbb",
    HUES["sky"]: "#7cc8f5",
    HUES["violet"]: "#a794e8",
    AMBER: "#f0b429",
    NEUTRAL: "#b0b0b0",
    FAINT: "#707070",
    PALE: "#3f4246",
    BAND: "#585d63",
    GRID: "#26292d",
    IMPOSSIBLE[0]: "#33373c",
    IMPOSSIBLE[1]: "#707478",
    ABSENT[0]: "#17191b",
    ABSENT[1]: "#55595e",
    SURFACE: "#2a2e33",
    BODY_FACE: "#1d4b66",
}
"""The same colours on dark ground."""

DARK = "#131416"
"""The ground of dark pictures, as of the dark pages of the documentation."""

DARK_STYLE: dict[Any, Any] = {
    "figure.facecolor": DARK,
    "axes.facecolor": DARK,
    "savefig.facecolor": DARK,
    "legend.facecolor": DARK,
    **dict.fromkeys(
        (
            *("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"),
            *("patch.edgecolor", "lines.color"),
        ),
        "#e4e4e4",
    ),
}
"""Settings of Matplotlib for dark pictures: ``matplotlib.rc_context(DARK_STYLE)``."""

CLASSES = {
    "chaotic": HUES["blue"],
    "undecided": NEUTRAL,
    "failed": HUES["black"],
    "regular": AMBER,
}
"""Colours of points and lines of classes: as in maps, blue is chaotic and yellow is regular."""

OUTCOMES = {
    "stable": "#e1cc55",
    "unstable": "#5d7fb8",
    "undecided": "#b04a00",
    "failed": "#444444",
}
"""Faces of bodies by outcome in the map explorer; colour-blind readers can tell them apart."""

SHARE_MAP = "cividis"
"""Colour map of shares of stable or regular bodies: its bright end, yellow, is stable."""

NUMBER_MAP = "magma"
"""Colour map of other numbers, with other hues: its bright end is large, not stable."""

CHAOS_MAP = "cividis_r"
"""Colour map of exponents and of MEGNO: its bright end, yellow, is regular too."""

STABLE, UNSTABLE = "#fee838", "#00224e"
"""The ends of the colour map of shares, where a map has two classes and no shares."""

FAILED, UNDECIDED = "#cc3311", "#d55e00"
"""Strokes over the colours of shares; both contrast with both ends of the colour map."""


def on_ground(ax: Any, colour: str) -> str:
    """A colour as it is drawn on these axes, or on this figure: brighter on dark ground.

    ``plt.style.context("dark_background")`` makes dark axes, and so do :data:`DARK_STYLE` and
    ``ax.set_facecolor``.
    """
    return _ON_DARK.get(colour, colour) if is_dark(ax) else colour


def ground(ax: Any) -> Any:
    """The colour behind axes, or behind a figure: the figure's, where the axes have none."""
    own = ax.get_facecolor()
    figure = getattr(ax, "figure", None)
    return ground(figure) if own[3] < 0.5 and figure not in (None, ax) else own


def is_dark(ax: Any) -> bool:
    """Whether the ground of axes or of a figure is dark."""
    red, green, blue, opacity = ground(ax)
    return bool(opacity >= 0.5 and 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.5)


@dataclass(frozen=True, slots=True)
class Ink:
    """Colour and label of a quantity."""

    colour: str
    label: str


X = Ink(HUES["blue"], "$x$")
Y = Ink(HUES["green"], "$y$")
Z = Ink(HUES["vermilion"], "$z$")
AXES = (X, Y, Z)
"""The inks of the components or axes 1, 2, 3."""

L = Ink(HUES["orange"], r"$\mathbf{L}$")
OMEGA = Ink(HUES["purple"], r"$\boldsymbol{\omega}$")
TORQUE = Ink(HUES["orange"], r"$\boldsymbol{\tau}$")  # the colour of L, because dL/dt = tau
VELOCITY = Ink(HUES["green"], r"$\mathbf{v}$")
POSITION = Ink(HUES["black"], r"$\mathbf{r}$")
VERTICAL = Ink(HUES["black"], r"$\mathbf{e}_3$")

SPACE = Ink(NEUTRAL, "space")
PLANET = Ink(HUES["violet"], "planet")
BODY = Ink(HUES["sky"], "body")
NODE = Ink(HUES["purple"], "line of nodes")
ANGLE = Ink(HUES["black"], "angle")
