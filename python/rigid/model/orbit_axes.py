"""Directions of the frame of an orbit, and the body axes that lie along them at rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._checks.arrays import Floats
from .batch import three
from .sampled import Sampled
from .scene import Scene
from .start import body_axis

DIRECTIONS: Mapping[str, str] = {
    "radial": "the radial direction",
    "along": "the direction along the orbit",
    "normal": "the normal of the orbit",
}
"""The axes of :meth:`rigid.Orbit.frame`, in their order, in words."""

ANGLES = ("roll", "pitch", "yaw")
"""The angles of :func:`rigid.free.roll_pitch_yaw`, in their order."""

Axes: TypeAlias = tuple[int, int]
"""The body axes at rest along the line from the planet and along the normal; negative: against."""

_RULE = "give the body axes along the line from the planet and along the normal, such as (1, 3)"


def require_orbit(name: str, scene: Scene) -> None:
    """Raise ValueError if a scene has no orbit, whose frame a question is about."""
    if scene.orbit is None:
        raise ValueError(
            f"{name}() measures in the frame of an orbit, which the scene does not have; give it "
            "orbit=rigid.Orbit(rate)"
        )
    if isinstance(scene.orbit, Sampled):
        raise ValueError(
            f"{name}() measures in the frame of an orbit, which is not watched along the table of "
            "rigid.Orbit.table; give rigid.Orbit, or look at the states of run.in_orbit_frame()"
        )


def extreme_axis(scene: Scene, *, long: bool) -> int:
    """The axis of the smallest moment of the body of a scene (the long one), or of the largest."""
    moments = np.asarray(scene.body.moments).reshape(-1, 3)
    extreme = moments.min(axis=1) if long else moments.max(axis=1)
    share = moments / extreme[:, np.newaxis]
    of_all = np.all(np.abs(share - 1.0) <= 1e-12, axis=0)
    if not of_all.any():
        which = "long axis" if long else "axis of the largest moment"
        raise ValueError(f"axis: is needed, because the {which} of the bodies is not the same")
    return int(np.argmax(of_all)) + 1


def checked_axes(axes: object) -> Axes:
    """Two different body axes."""
    if not isinstance(axes, (tuple, list)) or len(axes) != 2:
        raise ValueError(
            f"axes = {brief(axes)}: must be two body axes, such as (1, 3), along the line from the "
            "planet and along the normal of the orbit"
        )
    radial, normal = (body_axis(one, signed=True) for one in axes)
    if abs(radial) == abs(normal):
        raise ValueError(f"axes = {brief(axes)}: must be two different axes")
    return radial, normal


def rest_axes(scene: Scene | None) -> Axes:
    """The long axis and the axis of the largest moment of all bodies of a scene; None has none.

    Raises
    ------
    ValueError
        If there is no scene, two moments of a body are equal, or the axes of bodies differ.
    """
    if scene is None:
        raise ValueError(f"axes: an orbit alone has no body; {_RULE}")
    moments = np.asarray(scene.body.moments).reshape(-1, 3)
    order = np.argsort(moments, axis=1)
    low, middle, high = np.take_along_axis(moments, order, axis=1).T
    equal = (low == middle) | (middle == high)
    if equal.any():
        given = three(moments[int(np.argmax(equal))])
        raise ValueError(f"axes: two of the moments {given} are equal; {_RULE}")
    if (order != order[0]).any():
        raise ValueError(f"axes: the long and short axes of the bodies are not the same; {_RULE}")
    return int(order[0, 0]) + 1, int(order[0, 2]) + 1


def at_rest(axes: Axes) -> NDArray[np.float64]:
    """The body axes of roll, pitch and yaw, as rows: at rest along, normal and radial."""
    yaw, pitch = (unit_axis(one) for one in axes)
    return np.stack([np.cross(pitch, yaw), pitch, yaw])


def unit_axis(axis: int) -> Floats:
    """The vector of a signed body axis."""
    vector: Floats = np.sign(axis) * np.eye(3)[abs(axis) - 1]
    return vector
