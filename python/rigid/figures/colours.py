"""The one colour table of all figures, and the labels that go with it.

The hues are those of Okabe and Ito, which colour-blind readers can distinguish. The components and
axes x, y, z are blue, green and vermilion. Every vector and frame has one colour and one name in
all figures; a figure with other quantities has a key.
"""

from __future__ import annotations

from ..drawing.colours import (
    ANGLE,
    AXES,
    BODY,
    FAINT,
    HUES,
    NEUTRAL,
    NODE,
    OMEGA,
    POSITION,
    SPACE,
    TORQUE,
    VELOCITY,
    VERTICAL,
    Ink,
    L,
    X,
    Y,
    Z,
)

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
