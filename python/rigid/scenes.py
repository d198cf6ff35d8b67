"""Scenes: a body and what acts on it."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, one_of, unit_vector
from .bodies import Body
from .forces import (
    Damping,
    Torque,
    checked_damping,
    checked_torque,
    damping_words,
    outside_of,
)

__all__ = ["FreeBody", "HeavyTop", "Scene", "scene_from_dict", "scene_words"]


def _check_body(body: object) -> None:
    if not isinstance(body, Body):
        raise TypeError(f"body = {body!r}: must be a rigid.Body")


@dataclass(frozen=True, slots=True, init=False)
class FreeBody:
    """A body without weight, turning about its centre of mass.

    Euler's equations ``I omega' = (I omega) × omega + torque - D omega`` in the principal axes of
    the body.

    Parameters
    ----------
    body : Body
        The body.
    torque : Torque, optional
        What turns it from outside: :meth:`Torque.body`, :meth:`Torque.space`, or a sum of them.
    damping : float or array_like, shape (3,) or (3, 3), optional
        Linear damping ``D`` (N m s): one coefficient, one for each body axis, or a symmetric
        positive semi-definite matrix in body axes. The damping of the spin alone is ``(0, 0, c)``.

    Attributes
    ----------
    damping : 3 tuples of 3 floats, or None
        The matrix.

    Raises
    ------
    ValueError
        If the damping is not symmetric, not finite, or would feed a motion.

    Examples
    --------
    >>> import rigid
    >>> rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))).body.moments
    (1.0, 2.0, 3.0)
    >>> wheel = rigid.Body((1.0, 1.0, 1.8))
    >>> driven = rigid.FreeBody(wheel, torque=rigid.Torque.body((0, 0, 0.3)), damping=(0, 0, 0.1))
    >>> run = rigid.simulate(driven, [0.0, 0.0, 0.0], t=[200.0])  # N / c, to e^(-11)
    >>> round(float(run.omega[-1, 2]), 3)
    3.0
    """

    kind: ClassVar[str] = "free"
    body: Body
    torque: Torque | None = field(default=None, kw_only=True)
    damping: Damping | None = field(default=None, kw_only=True)

    def __init__(
        self, body: Body, *, torque: Torque | None = None, damping: ArrayLike | None = None
    ) -> None:
        _check_body(body)
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "body", body)
        set_field(self, "torque", checked_torque(torque))
        set_field(self, "damping", checked_damping(damping))

    def __repr__(self) -> str:
        return f"FreeBody(body={self.body!r}{_driven_repr(self)})"

    @property
    def weight(self) -> NDArray[np.float64]:
        """``mgl com``, here zero; shape (3,)."""
        return np.zeros(3)

    @property
    def outside(self) -> _core.Outside | None:
        """Torque and damping as the core reads them, None if nothing acts."""
        return outside_of(self.torque, self.damping)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain data."""
        return {"kind": self.kind, "body": self.body.to_dict(), **_driven_dict(self)}


@dataclass(frozen=True, slots=True, init=False)
class HeavyTop:
    """A body turning about a fixed point under its weight.

    ``I omega' = (I omega) × omega - mgl com × gamma + torque - D omega`` and
    ``gamma' = gamma × omega`` in the principal axes at the fixed point; ``gamma`` is the upward
    vertical seen from the body.

    Parameters
    ----------
    body : Body
        Moments about the fixed point (not the centre of mass).
    mgl : float
        Mass times gravity times the distance from the fixed point to the centre of mass (J), >= 0.
    com : array_like, shape (3,), optional
        Unit vector from the fixed point to the centre of mass in the body. Default ``(0, 0, 1)``.
    torque, damping : optional
        As in :class:`FreeBody`.

    Raises
    ------
    ValueError
        If ``mgl`` is negative or not finite, ``com`` is not a unit vector, or the damping is not
        symmetric, not finite, or would feed a motion.

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
    torque: Torque | None
    damping: Damping | None

    def __init__(
        self,
        body: Body,
        *,
        mgl: float,
        com: ArrayLike = (0.0, 0.0, 1.0),
        torque: Torque | None = None,
        damping: ArrayLike | None = None,
    ) -> None:
        _check_body(body)
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "body", body)
        set_field(self, "mgl", finite_float("mgl", mgl, nonnegative=True))
        set_field(self, "com", tuple(unit_vector("com", com, 3).tolist()))
        set_field(self, "torque", checked_torque(torque))
        set_field(self, "damping", checked_damping(damping))

    def __repr__(self) -> str:
        own = f"body={self.body!r}, mgl={self.mgl!r}, com={self.com!r}"
        return f"HeavyTop({own}{_driven_repr(self)})"

    @property
    def outside(self) -> _core.Outside | None:
        """Torque and damping as the core reads them, None if nothing acts."""
        return outside_of(self.torque, self.damping)

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
            **_driven_dict(self),
        }


Scene = FreeBody | HeavyTop


def _driven_dict(scene: Scene) -> dict[str, Any]:
    """Torque and damping as plain data, as far as there are any."""
    data: dict[str, Any] = {}
    if scene.torque is not None:
        data["torque"] = scene.torque.to_dict()
    if scene.damping is not None:
        data["damping"] = [list(row) for row in scene.damping]
    return data


def _driven_repr(scene: Scene) -> str:
    parts = [("torque", scene.torque), ("damping", scene.damping)]
    return "".join(f", {name}={value!r}" for name, value in parts if value is not None)


def scene_from_dict(data: Mapping[str, Any]) -> Scene:
    """The scene of ``to_dict``."""
    kind = one_of("kind", data.get("kind"), (FreeBody.kind, HeavyTop.kind))
    body = Body.from_dict(data["body"])
    torque, damping = data.get("torque"), data.get("damping")
    torque = None if torque is None else Torque.from_dict(torque)
    if kind == FreeBody.kind:
        return FreeBody(body, torque=torque, damping=damping)
    return HeavyTop(body, mgl=data["mgl"], com=data["com"], torque=torque, damping=damping)


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
    acting = "" if scene.torque is None else f", {scene.torque.words()}"
    if scene.damping is not None:
        acting = f"{acting}, {damping_words(scene.damping)}"
    if isinstance(scene, HeavyTop):
        com = ", ".join(f"{part:g}" for part in scene.com)
        return f"heavy top, {words}, mgl {numbers([('mgl', scene.mgl)])}, com ({com}){acting}"
    return f"free body, {words}{acting}"
