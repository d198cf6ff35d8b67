"""What *stable* means: the criteria of a map, each with its horizon stated elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi
from typing import Any, TypeAlias

import numpy as np

from ._check import finite_float, one_of
from .scenes import HeavyTop, Scene
from .starts import Start, body_axis

__all__ = ["Criterion", "NoFlip", "TiltBelow", "no_flip", "tilt_below"]

REFERENCES = ("start", "vertical")


@dataclass(frozen=True, slots=True)
class NoFlip:
    """Stable while the rate about one body axis keeps its sign; made by :func:`no_flip`."""

    axis: int | None = None

    def __post_init__(self) -> None:
        if self.axis is not None:
            object.__setattr__(self, "axis", body_axis(self.axis))

    def resolved(self, scene: Scene, start: Start) -> NoFlip:
        """The criterion with the axis that ``None`` stands for."""
        return replace(self, axis=_axis_of(start)) if self.axis is None else self

    def core(self) -> tuple[str, int, float]:
        """Name, axis and limit as the core takes them."""
        if self.axis is None:
            raise ValueError("no_flip() without an axis needs a start: call resolved() first")
        return "no_flip", self.axis, 0.0

    def to_dict(self) -> dict[str, Any]:
        """The criterion as a JSON-able dictionary."""
        return {"criterion": "no_flip", "axis": self.axis}

    def __str__(self) -> str:
        return "no flip" if self.axis is None else f"no flip about axis {self.axis}"


@dataclass(frozen=True, slots=True)
class TiltBelow:
    """Stable while a body axis stays within an angle of a direction; made by :func:`tilt_below`."""

    angle: float
    axis: int = 3
    reference: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "angle", finite_float("angle", self.angle, positive=True))
        if self.angle > pi:
            raise ValueError(f"angle = {self.angle}: must lie in (0, pi] (rad)")
        object.__setattr__(self, "axis", body_axis(self.axis, signed=True))
        if self.reference is not None:
            one_of("reference", self.reference, REFERENCES)

    def resolved(self, scene: Scene, start: Start) -> TiltBelow:
        """The criterion with the reference that ``None`` stands for."""
        if isinstance(scene, HeavyTop):
            return self if self.reference else replace(self, reference="vertical")
        if self.reference == "vertical":
            raise ValueError(
                "reference = 'vertical': a free body knows no vertical; use 'start' or a HeavyTop"
            )
        return replace(self, reference="start")

    def core(self) -> tuple[str, int, float]:
        """Name, axis and limit (rad) as the core takes them."""
        if self.reference is None:
            raise ValueError(
                "tilt_below() without a reference needs a scene: call resolved() first"
            )
        return f"tilt_from_{self.reference}", self.axis, self.angle

    def to_dict(self) -> dict[str, Any]:
        """The criterion as a JSON-able dictionary."""
        return {
            "criterion": "tilt_below",
            "angle": self.angle,
            "axis": self.axis,
            "reference": self.reference,
        }

    def __str__(self) -> str:
        origin = {"start": " from its start", "vertical": " from the vertical", None: ""}
        return f"tilt of axis {self.axis}{origin[self.reference]} below {self.angle:g} rad"


Criterion: TypeAlias = NoFlip | TiltBelow


def no_flip(axis: int | None = None) -> NoFlip:
    """Stable: the rate about a body axis never changes its sign.

    Parameters
    ----------
    axis : {1, 2, 3}, optional
        The body axis. By default the axis of the start: ``Start.axis`` if the start is given by its
        spin, else the axis of the largest component of ``Start.omega``.

    Returns
    -------
    NoFlip

    Raises
    ------
    ValueError
        If the axis is not 1, 2 or 3.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.no_flip(2))
    'no flip about axis 2'
    """
    return NoFlip(axis)


def tilt_below(angle: float, *, axis: int = 3, reference: str | None = None) -> TiltBelow:
    """Stable: a body axis stays within an angle of a fixed direction of space.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    axis : {1, 2, 3, -1, -2, -3}
        The body axis; negative for its opposite direction.
    reference : {"start", "vertical"}, optional
        The direction: that of the axis at the start, or the upward vertical. By default the
        vertical for a heavy top and the start for a free body, which knows no vertical.

    Returns
    -------
    TiltBelow

    Raises
    ------
    ValueError
        If a value is out of range or the reference is unknown.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.tilt_below(0.5, reference="vertical"))
    'tilt of axis 3 from the vertical below 0.5 rad'
    """
    return TiltBelow(angle, axis, reference)


def criterion_from_dict(data: Mapping[str, Any]) -> Criterion:
    """The criterion that :meth:`to_dict` described."""
    values = dict(data)
    kind = values.pop("criterion")
    return NoFlip(**values) if kind == "no_flip" else TiltBelow(**values)


def _axis_of(start: Start) -> int:
    if start.omega is None:
        return start.axis
    size = np.abs(start.omega)
    if np.count_nonzero(size == size.max()) > 1:
        raise ValueError(
            f"no_flip() cannot tell the axis: omega {start.omega} has no single largest component; "
            "say no_flip(axis=...)"
        )
    return int(size.argmax()) + 1
