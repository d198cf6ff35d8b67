"""A body, a scene or principal moments, whichever is given."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief
from .._checks.arrays import vectors
from .._moments import possible
from .body import Body
from .scene import FreeBody, Scene

__all__ = ["BodyLike", "body_of", "moments_of"]

Floats = NDArray[np.float64]

BodyLike: TypeAlias = Body | FreeBody | ArrayLike
"""A body, or principal moments of shape (..., 3)."""


def body_of(body: object) -> Body:
    """The body of a body or of the scene of a free body."""
    if isinstance(body, FreeBody):
        return body.body
    if not isinstance(body, Body):
        raise TypeError(f"body = {brief(body)}: must be a rigid.Body or a rigid.FreeBody")
    return body


def moments_of(body: object, *, rod: bool = False) -> Floats:
    """Principal moments, shape (..., 3), of bodies that can exist.

    A thin rod, with no moment about its own axis, has no equation of motion; ``rod`` lets it pass
    where none is needed.
    """
    if isinstance(body, Scene):
        if body.forces:
            raise ValueError(
                f"scene = {body.words()}: here nothing may act on the body; give the body alone, "
                "scene.body"
            )
        body = body.body
    if isinstance(body, Body):
        return np.array(body.moments)
    moments = vectors("moments", body)  # type: ignore[arg-type]  # ValueError if it is no array
    flat = moments.reshape(-1, 3)
    good = possible(flat)
    if rod:
        low, middle, high = np.sort(flat, axis=1).T
        good |= (low == 0.0) & (middle == high) & (high > 0.0)
    for impossible in flat[~good][:1]:
        Body(impossible)  # raises the rule that the moments break
    return moments
