"""A body, a scene or principal moments, whichever is given."""

from __future__ import annotations

from typing import Any, TypeAlias

from numpy.typing import ArrayLike

from .._checks.arguments import brief
from .._checks.arrays import Floats, vectors
from .._checks.moments import checked_moments, refuse_rods
from .body import Body, pair_hint
from .scene import FreeBody, Scene, require_unforced

BodyLike: TypeAlias = Body | FreeBody | ArrayLike
"""A body, or principal moments of shape (..., 3)."""


def body_of(body: object) -> Body:
    """The body of a body, or of the scene of a free body on which nothing acts."""
    if isinstance(body, FreeBody):
        require_unforced(body, "the free motion of scene.body")
        return body.body
    if not isinstance(body, Body):
        raise TypeError(
            f"body = {brief(body)}: must be a rigid.Body or a rigid.FreeBody{pair_hint(body)}"
        )
    return body


def moments_of(body: object, *, rod: bool = False) -> Floats:
    """Principal moments, shape (..., 3), of bodies that can exist.

    A thin rod has no moment about its own axis; ``rod`` lets it pass where none is needed.
    """
    is_body = isinstance(body, (Body, Scene)) or pair_hint(body)
    given: Any = body_of(body).moments if is_body else body
    moments = vectors("moments", given)  # ValueError if it is no array
    if not is_body:
        moments = checked_moments(moments)
    if not rod:
        refuse_rods(moments)
    return moments.copy()
