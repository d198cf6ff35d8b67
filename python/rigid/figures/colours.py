"""The one colour table of all figures, and the labels that go with it.

The hues come from Okabe and Ito; colour-blind readers can distinguish them. They are so dark that
lines and texts are legible on white; ``on_ground`` gives the brighter ones for dark axes. The
components and axes x, y, z are blue, green and vermilion. Every vector and frame has one colour and
one name in all figures; a figure with other quantities has a key.
"""

from __future__ import annotations

from ..drawing.colours import (
    ANGLE,
    AXES,
    BODY,
    CHAOS_MAP,
    CLASSES,
    DARK_STYLE,
    FAINT,
    HUES,
    NEUTRAL,
    NODE,
    OMEGA,
    POSITION,
    SHARE_MAP,
    SPACE,
    TORQUE,
    VELOCITY,
    VERTICAL,
    Ink,
    L,
    X,
    Y,
    Z,
    on_ground,
)

__all__ = [
    "ANGLE",
    "AXES",
    "BODY",
    "CHAOS_MAP",
    "CLASSES",
    "DARK_STYLE",
    "FAINT",
    "HUES",
    "NEUTRAL",
    "NODE",
    "OMEGA",
    "POSITION",
    "SHARE_MAP",
    "SPACE",
    "TORQUE",
    "VELOCITY",
    "VERTICAL",
    "Ink",
    "L",
    "X",
    "Y",
    "Z",
    "on_ground",
]
