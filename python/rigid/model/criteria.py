"""What *stable* means: the criteria of a map, each with its horizon stated elsewhere.

A new criterion is one more class in this file and its entry in :data:`CRITERIA`; the core selects
the observable by the name that :meth:`Criterion.core` gives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, fields, replace
from math import pi
from typing import Any, ClassVar, Self

import numpy as np

from .._checks.arguments import brief, finite_float, one_of
from .scene import Scene
from .start import Start, body_axis

__all__ = [
    "CRITERIA",
    "Criterion",
    "NoFlip",
    "TiltBelow",
    "check_criterion",
    "criterion_from_dict",
    "known_criteria",
    "no_flip",
    "tilt_below",
]

REFERENCES = ("start", "vertical")


class Criterion(ABC):
    """A definition of *stable*: the interface of all criteria. ``str`` describes the criterion.

    Attributes
    ----------
    name : str
        Name in :data:`CRITERIA`, in map files and saved maps; a function of this name in
        :mod:`rigid` makes the criterion.
    record : {"rates", "axis"}
        The state that must be integrated to observe the criterion.
    watch_work : float
        Work that the observation adds to a step of 32 bodies, in the unit of plans.
    """

    __slots__ = ()

    name: ClassVar[str]
    record: ClassVar[str]
    watch_work: ClassVar[float]

    @abstractmethod
    def resolved(self, scene: Scene, start: Start | None) -> Self:
        """The criterion with all defaults filled in.

        Without a start, what follows from a start may stay open if the scene allows it.
        """

    @abstractmethod
    def core(self) -> tuple[str, int, float]:
        """Name, axis and limit as the core takes them."""

    @abstractmethod
    def closed_form_question(self) -> tuple[str, int | None] | None:
        """Name and axis in the core's list of closed forms, None if the criterion has none."""

    @abstractmethod
    def check_forced(self) -> None:
        """Raise ValueError if a map cannot observe the criterion under torque and damping."""

    def to_dict(self) -> dict[str, Any]:
        """The criterion as a JSON-able dictionary."""
        return {"criterion": self.name, **asdict(self)}  # type: ignore[call-overload]


@dataclass(frozen=True, slots=True)
class NoFlip(Criterion):
    """Stable while the rate about one body axis keeps its sign; made by :func:`no_flip`."""

    name: ClassVar[str] = "no_flip"
    record: ClassVar[str] = "rates"
    watch_work: ClassVar[float] = 0.06

    axis: int | None = None

    def __post_init__(self) -> None:
        if self.axis is not None:
            object.__setattr__(self, "axis", body_axis(self.axis))

    def resolved(self, scene: Scene, start: Start | None) -> Self:
        """The criterion with the default axis in place of ``None``."""
        if self.axis is not None:
            return self
        if start is not None:
            return replace(self, axis=_axis_of(start))
        if scene.directions:
            raise ValueError("no_flip() without an axis: say no_flip(axis) to plan for a top")
        return self

    def core(self) -> tuple[str, int, float]:
        """Name, axis and limit as the core takes them."""
        if self.axis is None:
            raise ValueError("no_flip() without an axis needs a start: call resolved() first")
        return "no_flip", self.axis, 0.0

    def closed_form_question(self) -> tuple[str, int | None]:
        """Free bodies have closed forms, and Lagrange tops about their symmetry axis."""
        return "no_flip", self.axis

    def check_forced(self) -> None:
        """Do nothing: maps observe flips under torque and damping too."""

    def __str__(self) -> str:
        return "no flip" if self.axis is None else f"no flip about axis {self.axis}"


@dataclass(frozen=True, slots=True)
class TiltBelow(Criterion):
    """Stable while a body axis stays within an angle of a direction; made by :func:`tilt_below`."""

    name: ClassVar[str] = "tilt_below"
    record: ClassVar[str] = "axis"
    watch_work: ClassVar[float] = 0.09

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

    def resolved(self, scene: Scene, start: Start | None) -> Self:
        """The criterion with the default reference in place of ``None``."""
        if scene.directions:
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

    def closed_form_question(self) -> tuple[str, int] | None:
        """Lagrange tops have closed forms, for the tilt of their axis from the vertical."""
        return ("tilt_from_vertical", abs(self.axis)) if self.reference == "vertical" else None

    def check_forced(self) -> None:
        """Raise ValueError unless the tilt is one from the vertical."""
        if self.reference != "vertical":
            raise ValueError(
                f"reference = {self.reference!r}: under torque and damping a map watches "
                "tilts from the vertical only"
            )

    def __str__(self) -> str:
        origin = {"start": " from its start", "vertical": " from the vertical", None: ""}
        return f"tilt of axis {self.axis}{origin[self.reference]} below {self.angle:g} rad"


CRITERIA: Mapping[str, type[Criterion]] = {known.name: known for known in (NoFlip, TiltBelow)}
"""All criteria by their name."""


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
        vertical for a heavy top and the start for a free body, whose equations contain no vertical.

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


def check_criterion(name: str, criterion: object) -> Criterion:
    """``criterion`` if it is one."""
    if isinstance(criterion, Criterion):
        return criterion
    raise TypeError(f"{name} = {brief(criterion)}: must be a criterion, {known_criteria()}")


def known_criteria() -> str:
    """The functions that make criteria, with what each must be given, in words."""
    calls = []
    for known in CRITERIA.values():
        needed = [own.name for own in fields(known) if own.default is MISSING]  # type: ignore[arg-type]
        calls.append(f"rigid.{known.name}({', '.join(needed)})")
    return " or ".join(calls)


def criterion_from_dict(data: Mapping[str, Any]) -> Criterion:
    """The criterion of :meth:`Criterion.to_dict`."""
    values = dict(data)
    return CRITERIA[values.pop("criterion")](**values)


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
