"""Scenes: a body and what acts on it."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import finite_float, one_of, unit_vector
from .bodies import Body

__all__ = ["FreeBody", "HeavyTop", "Scene", "scene_from_dict", "scene_words"]


def _check_body(body: object) -> None:
    if not isinstance(body, Body):
        raise TypeError(f"body = {body!r}: must be a rigid.Body")


@dataclass(frozen=True, slots=True)
class FreeBody:
    """A body under no torque, turning about its centre of mass.

    Euler's equations ``I omega' = (I omega) × omega`` in the principal axes of the body.

    Parameters
    ----------
    body : Body
        The body.

    Examples
    --------
    >>> import rigid
    >>> rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))).body.moments
    (1.0, 2.0, 3.0)
    """

    kind: ClassVar[str] = "free"
    body: Body

    def __post_init__(self) -> None:
        _check_body(self.body)

    @property
    def weight(self) -> NDArray[np.float64]:
        """``mgl com``, here zero; shape (3,)."""
        return np.zeros(3)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain data."""
        return {"kind": self.kind, "body": self.body.to_dict()}


@dataclass(frozen=True, slots=True, init=False)
class HeavyTop:
    """A body turning about a fixed point under its weight.

    ``I omega' = (I omega) × omega - mgl com × gamma`` and ``gamma' = gamma × omega`` in the
    principal axes at the fixed point; ``gamma`` is the upward vertical seen from the body.

    Parameters
    ----------
    body : Body
        Moments about the fixed point (not the centre of mass).
    mgl : float
        Mass times gravity times the distance from the fixed point to the centre of mass (J), >= 0.
    com : array_like, shape (3,), optional
        Unit vector from the fixed point to the centre of mass in the body. Default ``(0, 0, 1)``.

    Raises
    ------
    ValueError
        If ``mgl`` is negative or not finite, or ``com`` is not a unit vector.

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> top.com
    (0.0, 0.0, 1.0)
    """

    kind: ClassVar[str] = "top"
    body: Body
    mgl: float
    com: tuple[float, float, float]

    def __init__(self, body: Body, *, mgl: float, com: ArrayLike = (0.0, 0.0, 1.0)) -> None:
        _check_body(body)
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "body", body)
        set_field(self, "mgl", finite_float("mgl", mgl, nonnegative=True))
        set_field(self, "com", tuple(unit_vector("com", com, 3).tolist()))

    @property
    def weight(self) -> NDArray[np.float64]:
        """``mgl com`` (J), shape (3,)."""
        return self.mgl * np.array(self.com)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain data."""
        return {
            "kind": self.kind,
            "body": self.body.to_dict(),
            "mgl": self.mgl,
            "com": list(self.com),
        }


Scene = FreeBody | HeavyTop


def scene_from_dict(data: Mapping[str, Any]) -> Scene:
    """The scene of ``to_dict``."""
    kind = one_of("kind", data.get("kind"), (FreeBody.kind, HeavyTop.kind))
    body = Body.from_dict(data["body"])
    if kind == FreeBody.kind:
        return FreeBody(body)
    return HeavyTop(body, mgl=data["mgl"], com=data["com"])


def scene_words(scene: Scene, varied: Container[str] = ()) -> str:
    """The scene in words; ``varied`` names the numbers that the axes of a map set."""

    def numbers(values: Iterable[tuple[str, float]]) -> str:
        pairs = list(values)
        # Numbers that differ must not look equal.
        short = len({f"{value:g}" for _, value in pairs}) == len({value for _, value in pairs})
        return ", ".join(
            "varied" if name in varied else f"{value:g}" if short else repr(value)
            for name, value in pairs
        )

    body = scene.body
    moments = list(zip(("I1", "I2", "I3"), body.moments, strict=True))
    if body.sides is not None and not any(name in varied for name, _ in moments):
        sides, mass = numbers(zip("abc", body.sides, strict=True)), [("mass", body.mass or 0.0)]
        words = f"box with sides ({sides}) m and mass {numbers(mass)} kg"
    else:
        words = f"moments ({numbers(moments)})"
    if isinstance(scene, HeavyTop):
        com = ", ".join(f"{part:g}" for part in scene.com)
        return f"heavy top, {words}, mgl {numbers([('mgl', scene.mgl)])}, com ({com})"
    return f"free body, {words}"
