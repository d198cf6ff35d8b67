"""Bodies, vectors and attitudes as they are given: checked arrays with any leading axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import first_place, numbers, shaped
from .bodies import Body, possible
from .scenes import FreeBody, HeavyTop, scene_words

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "BodyLike",
    "attitudes",
    "finite_array",
    "moments_of",
    "require",
    "to_body",
    "to_space",
    "vectors",
]

Floats = NDArray[np.float64]

BodyLike: TypeAlias = Body | FreeBody | ArrayLike
"""A body, or principal moments of shape (..., 3)."""


def finite_array(name: str, value: ArrayLike) -> Floats:
    """``value`` as finite floats of any shape."""
    return shaped(name, value)


def require(name: str, array: NDArray[Any], good: NDArray[np.bool_], rule: str) -> None:
    """Raise for the first element that breaks the rule."""
    if not good.all():
        index, place = first_place(~good)
        raise ValueError(f"{name}{place} = {array[index]}: {rule}")


def vectors(name: str, value: ArrayLike, width: int = 3) -> Floats:
    """``value`` as finite floats of shape (..., width)."""
    array = numbers(name, value)
    return np.empty((0, width)) if array.shape == (0,) else shaped(name, array, width)


def moments_of(body: object, *, rod: bool = False) -> Floats:
    """Principal moments, shape (..., 3), of bodies that can exist.

    A thin rod, with no moment about its own axis, has no equation of motion; ``rod`` lets it pass
    where none is needed.
    """
    if isinstance(body, (FreeBody, HeavyTop)):
        if body.outside is not None:
            raise ValueError(
                f"scene = {scene_words(body)}: torque and damping are not taken into account here"
            )
        body = body.body
    if isinstance(body, Body):
        return np.array(body.moments)
    moments = vectors("moments", body)  # type: ignore[arg-type]  # refused if it is no array
    flat = moments.reshape(-1, 3)
    good = possible(flat)
    if rod:
        low, middle, high = np.sort(flat, axis=1).T
        good |= (low == 0.0) & (middle == high) & (high > 0.0)
    for impossible in flat[~good][:1]:
        Body(impossible)  # says which rule it breaks
    return moments


def attitudes(attitude: ArrayLike | Rotation) -> Floats:
    """Unit quaternions, scalar first, shape (..., 4)."""
    if hasattr(attitude, "as_quat"):
        attitude = attitude.as_quat(scalar_first=True)
    quaternions = vectors("attitude", attitude, 4)
    largest = np.abs(quaternions).max(axis=-1, keepdims=True)
    require("largest component of attitude", largest, largest > 0.0, "must not be zero")
    scaled = quaternions / largest
    unit: Floats = scaled / np.sqrt((scaled * scaled).sum(axis=-1, keepdims=True))
    return unit


def to_space(attitude: Floats, vector: Floats) -> Floats:
    """``R v`` of unit quaternions ``(w, u)``: ``v + 2 w u × v + 2 u × (u × v)``."""
    scalar, axis = attitude[..., :1], attitude[..., 1:]
    across = 2.0 * np.cross(axis, vector)
    turned: Floats = vector + scalar * across + np.cross(axis, across)
    return turned


def to_body(attitude: Floats, vector: Floats) -> Floats:
    """``R.T v``."""
    return to_space(attitude * np.array([1.0, -1.0, -1.0, -1.0]), vector)
