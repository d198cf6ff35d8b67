"""The one colour table of all figures, and the labels that go with it.

The hues are those of Okabe and Ito, told apart by colour-blind eyes too. The components and axes x,
y, z are blue, green and vermilion everywhere; every vector and frame keeps its colour and its name
from figure to figure, so that no legend is needed.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "ANGLE",
    "AXES",
    "BODY",
    "FAINT",
    "HUES",
    "NEUTRAL",
    "NODE",
    "OMEGA",
    "POSITION",
    "SPACE",
    "TORQUE",
    "VELOCITY",
    "VERTICAL",
    "Ink",
    "L",
    "X",
    "Y",
    "Z",
]

HUES = {
    "black": "#000000",
    "blue": "#0072b2",
    "green": "#009e73",
    "vermilion": "#d55e00",
    "orange": "#e69f00",
    "purple": "#cc79a7",
    "sky": "#56b4e9",
}
"""Okabe and Ito's hues without yellow, which is lost on white."""

NEUTRAL = "#555555"
"""Text, the outlines of bodies, and what belongs to no axis."""

FAINT = "#b5b5b5"
"""Help lines, circles of reference and hidden edges."""


@dataclass(frozen=True, slots=True)
class Ink:
    """What a quantity is drawn with and how it is called."""

    colour: str
    label: str


X = Ink(HUES["blue"], "$x$")
Y = Ink(HUES["green"], "$y$")
Z = Ink(HUES["vermilion"], "$z$")
AXES = (X, Y, Z)
"""The inks of the components or axes 1, 2, 3."""

L = Ink(HUES["orange"], r"$\mathbf{L}$")
OMEGA = Ink(HUES["purple"], r"$\boldsymbol{\omega}$")
TORQUE = Ink(HUES["orange"], r"$\mathbf{N}$")  # it is what changes L
VELOCITY = Ink(HUES["green"], r"$\mathbf{v}$")
POSITION = Ink(HUES["black"], r"$\mathbf{r}$")
VERTICAL = Ink(HUES["black"], r"$\mathbf{e}_3$")

SPACE = Ink(NEUTRAL, "space")
BODY = Ink(HUES["sky"], "body")
NODE = Ink(HUES["purple"], "line of nodes")
ANGLE = Ink(HUES["black"], "angle")
