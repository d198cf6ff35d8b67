"""The one colour table of all pictures; public as :mod:`rigid.figures.colours`."""

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
"""Colour of text, outlines of bodies, and other lines that show no axis."""

FAINT = "#b5b5b5"
"""Help lines, circles of reference and hidden edges."""


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
BODY = Ink(HUES["sky"], "body")
NODE = Ink(HUES["purple"], "line of nodes")
ANGLE = Ink(HUES["black"], "angle")
