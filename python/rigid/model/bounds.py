"""Criteria that keep one number of a motion within a limit: a tilt, a turn or a rate.

Messages list them in this order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import pi
from typing import ClassVar, Self

import numpy as np

from .._checks.arguments import finite_float, one_of, truth
from .._checks.shown import angle_words
from .criterion import Condition, Criterion, checked
from .forces import forces_in_words
from .orbit_axes import DIRECTIONS, Axes, checked_axes, extreme_axis, require_orbit, rest_axes
from .scene import Scene
from .start import Start, body_axis

VECTORS = {"omega": "omega", "L": "momentum"}
FRAMES = ("space", "body")
REFERENCES = ("start", "vertical")


NOT_NEGATIVE = partial(finite_float, nonnegative=True)


def signed_axis(_name: str, axis: object) -> int:
    """A body axis, or its opposite direction."""
    return body_axis(axis, signed=True)


def checked_angle(name: str, value: float) -> float:
    """An angle in (0, pi]."""
    angle = finite_float(name, value, positive=True)
    if angle > pi:
        raise ValueError(f"{name} = {angle}: must lie in (0, pi] (rad)")
    return angle


@dataclass(frozen=True, slots=True)
class WithinAngle(Criterion):
    """A criterion with one angle (rad), which the axis ``limit`` of a map sets."""

    limited: ClassVar[str | None] = "angle"

    angle: float = checked(checked_angle)


@dataclass(frozen=True, slots=True)
class NoFlip(Criterion):
    """Stable while the rate about one body axis keeps its sign; made by :func:`no_flip`."""

    name: ClassVar[str] = "no_flip"
    record: ClassVar[str] = "rates"

    axis: int | None = checked(lambda _, axis: body_axis(axis), None)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with the default axis in place of ``None``."""
        return self if self.axis is not None else replace(self, axis=_axis_of(start))

    def conditions(self) -> tuple[Condition, ...]:
        """Name, axis and no limits as the core takes them."""
        if self.axis is None:
            raise ValueError("no_flip() without an axis needs a start: call resolved() first")
        return (("no_flip", self.axis, ()),)

    def closed_form_question(self) -> tuple[str, int | None]:
        """Free bodies have closed forms, and Lagrange tops about their symmetry axis."""
        return "no_flip", self.axis

    def __str__(self) -> str:
        return "no flip" if self.axis is None else f"no flip about axis {self.axis}"


@dataclass(frozen=True, slots=True)
class TiltBelow(WithinAngle):
    """Stable while a body axis stays within an angle of a direction; made by :func:`tilt_below`."""

    name: ClassVar[str] = "tilt_below"
    record: ClassVar[str] = "axis"

    axis: int = checked(signed_axis, 3)
    reference: str | None = checked(partial(one_of, known=REFERENCES), None)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with the default reference in place of ``None``."""
        if scene.directions:
            return self if self.reference else replace(self, reference="vertical")
        if self.reference == "vertical":
            # Where a torque acts in space, its third axis, and with it the vertical, is integrated.
            if scene.rates_need_attitude:
                return self
            raise ValueError(
                "reference = 'vertical': a free body knows no vertical; use 'start' or a HeavyTop"
            )
        return replace(self, reference="start")

    def conditions(self) -> tuple[Condition, ...]:
        """Name, axis and limit (rad) as the core takes them."""
        if self.reference is None:
            raise ValueError(
                "tilt_below() without a reference needs a scene: call resolved() first"
            )
        return ((f"tilt_from_{self.reference}", self.axis, (self.angle,)),)

    def closed_form_question(self) -> tuple[str, int] | None:
        """Lagrange tops have closed forms, for the tilt of their axis from the vertical."""
        return ("tilt_from_vertical", abs(self.axis)) if self.reference == "vertical" else None

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:
        """Raise ValueError unless the tilt is one from the vertical."""
        if self.reference != "vertical":
            remedy = "give reference='vertical'"
            if not (scene.directions or scene.rates_need_attitude):
                remedy = "take no_flip(), or judged() with a function of the attitudes"
            raise ValueError(
                f"reference = {self.reference!r}: under {forces_in_words(forces)} a map watches "
                f"tilts from the vertical only; {remedy}"
            )

    def __str__(self) -> str:
        origin = {"start": " from its start", "vertical": " from the vertical", None: ""}
        return f"tilt of axis {self.axis}{origin[self.reference]} below {angle_words(self.angle)}"


@dataclass(frozen=True, slots=True)
class TiltBetween(Criterion):
    """Stable while the tilt from the vertical is within two limits; see :func:`tilt_between`."""

    name: ClassVar[str] = "tilt_between"
    record: ClassVar[str] = "axis"

    low: float = checked(NOT_NEGATIVE)
    high: float = checked(checked_angle)
    axis: int = checked(signed_axis, 3)

    def __post_init__(self) -> None:
        Criterion.__post_init__(self)  # super() does not know a class with slots
        if self.low >= self.high:
            raise ValueError(f"low = {self.low}: must be below high = {self.high}")

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion, if the scene has a vertical."""
        if not scene.directions:
            raise ValueError(
                "tilt_between() measures from the vertical, which a free body does not know; use "
                "tilt_below() or a HeavyTop"
            )
        return self

    def conditions(self) -> tuple[Condition, ...]:
        """The axis stays below the upper limit, its opposite below the rest of the lower one."""
        name = "tilt_from_vertical"
        return (name, self.axis, (self.high,)), (name, -self.axis, (pi - self.low,))

    def logic(self) -> tuple[int | str, ...]:
        """Both limits are kept."""
        return 0, 1, "&"

    def closed_form_question(self) -> tuple[str, int]:
        """Lagrange tops have closed forms for the tilt of their axis."""
        return "tilt_from_vertical", abs(self.axis)

    def __str__(self) -> str:
        low, high = angle_words(self.low), angle_words(self.high)
        if not (low.endswith("°") and high.endswith("°")):
            low, high = f"{self.low:g}", f"{self.high:g} rad"
        return f"tilt of axis {self.axis} from the vertical between {low} and {high}"


@dataclass(frozen=True, slots=True)
class RateWithin(WithinAngle):
    """Stable while a vector stays near its direction at the start; see :func:`rate_within`."""

    name: ClassVar[str] = "rate_within"

    of: str = checked(partial(one_of, known=VECTORS), "omega")
    frame: str = checked(partial(one_of, known=FRAMES), "space")

    @property
    def record(self) -> str:  # type: ignore[override]
        """A direction in space needs the attitude."""
        return "attitude" if self.frame == "space" else "rates"

    def conditions(self) -> tuple[Condition, ...]:
        """Name, no axis, and the limit (rad) as the core takes them."""
        return ((f"{VECTORS[self.of]}_within_{self.frame}", 0, (self.angle,)),)

    def closed_form_question(self) -> tuple[str, int | None] | None:
        """The angular momentum of a free body is constant in space."""
        # No top has a closed form of no_flip about an axis that is not named.
        return ("no_flip", None) if self.of == "L" and self.frame == "space" else None

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:
        """Raise ValueError if a rotor has a part of the momentum."""
        if self.of == "L" and "rotor" in forces:
            raise ValueError("of = 'L': the momentum of the rotor is not watched; use 'omega'")

    def __str__(self) -> str:
        where = "in space" if self.frame == "space" else "in the body"
        return f"{self.of} within {angle_words(self.angle)} of its direction at the start {where}"


@dataclass(frozen=True, slots=True)
class NearStart(WithinAngle):
    """Stable while the attitude stays near the start; made by :func:`near_start`."""

    name: ClassVar[str] = "near_start"
    record: ClassVar[str] = "attitude"

    def conditions(self) -> tuple[Condition, ...]:
        """Name, no axis, and the limit (rad) as the core takes them."""
        return ((self.name, 0, (self.angle,)),)

    def __str__(self) -> str:
        return f"attitude within {angle_words(self.angle)} of the start"


@dataclass(frozen=True, slots=True)
class ReturnsNear(WithinAngle):
    """Stable if the attitude comes back near the start; made by :func:`returns`."""

    name: ClassVar[str] = "returns"
    record: ClassVar[str] = "attitude"

    after: float = checked(NOT_NEGATIVE)

    def conditions(self) -> tuple[Condition, ...]:
        """Condition that the attitude stays away: name, limit (rad), time from which it counts."""
        return (("away_from_start", 0, (self.angle, self.after)),)

    def logic(self) -> tuple[int | str, ...]:
        """Stable is the opposite: the body does not stay away."""
        return 0, "~"

    def __str__(self) -> str:
        return f"attitude back within {angle_words(self.angle)} of the start after {self.after:g} s"


@dataclass(frozen=True, slots=True)
class SpinAbove(Criterion):
    """Stable while a rate stays above a limit; made by :func:`spin_above`."""

    name: ClassVar[str] = "spin_above"
    record: ClassVar[str] = "rates"

    rate: float = checked(NOT_NEGATIVE)
    axis: int | None = checked(signed_axis, None)

    def conditions(self) -> tuple[Condition, ...]:
        """Name, axis and limit (rad/s) as the core takes them."""
        if self.axis is None:
            return (("speed_above", 0, (self.rate,)),)
        return (("rate_above", self.axis, (self.rate,)),)

    def __str__(self) -> str:
        what = "|omega|" if self.axis is None else f"rate about axis {self.axis}"
        return f"{what} above {self.rate:g} rad/s"


@dataclass(frozen=True, slots=True)
class PointingWithin(WithinAngle):
    """Stable while an axis points along the orbit; see :func:`pointing_within`."""

    name: ClassVar[str] = "pointing_within"
    record: ClassVar[str] = "attitude"

    axis: int | None = checked(signed_axis, None)
    of: str = checked(partial(one_of, known=DIRECTIONS), "radial")
    either: bool = checked(truth, False)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with an axis, if there is an orbit."""
        require_orbit(self.name, scene)
        return replace(
            self, axis=extreme_axis(scene, long=True) if self.axis is None else self.axis
        )

    def conditions(self) -> tuple[Condition, ...]:
        """Name, axis, the limit (rad) and whether the opposite counts, as the core takes them."""
        assert self.axis is not None
        return ((f"pointing_{self.of}", self.axis, (self.angle, float(self.either))),)

    def __str__(self) -> str:
        axis = "long axis" if self.axis is None else f"axis {self.axis}"
        either = ", or of its opposite" if self.either else ""
        return f"{axis} within {angle_words(self.angle)} of {DIRECTIONS[self.of]}{either}"


@dataclass(frozen=True, slots=True)
class AngleWithin(WithinAngle):
    """Stable while an angle in the frame of the orbit stays within a limit, from either side."""

    record: ClassVar[str] = "attitude"

    axes: tuple[int, int] | None = checked(lambda _, axes: checked_axes(axes), None)

    def resolved(self, scene: Scene, start: Start) -> Self:
        """The criterion with its axes, if there is an orbit."""
        require_orbit(self.name, scene)
        return self if self.axes is not None else replace(self, axes=rest_axes(scene))

    def conditions(self) -> tuple[Condition, ...]:
        """Name, the axis of yaw, the limit (rad) and the axis of pitch, as the core takes them."""
        assert self.axes is not None
        return ((self.name, self.axes[0], (self.angle, float(self.axes[1]))),)

    def __str__(self) -> str:
        return f"{self.name.removesuffix('_within')} within {self.angle:g} rad"


class RollWithin(AngleWithin):
    """Stable while the roll stays within a limit; made by :func:`roll_within`."""

    __slots__ = ()
    name: ClassVar[str] = "roll_within"


class PitchWithin(AngleWithin):
    """Stable while the pitch stays within a limit; made by :func:`pitch_within`."""

    __slots__ = ()
    name: ClassVar[str] = "pitch_within"


class YawWithin(AngleWithin):
    """Stable while the yaw stays within a limit; made by :func:`yaw_within`."""

    __slots__ = ()
    name: ClassVar[str] = "yaw_within"


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
        The direction: the direction of the axis at the start, or the upward vertical. By default
        the vertical for a heavy top and the start for a free body, whose equations contain no
        vertical. On an :class:`Orbit` the vertical of a map is the normal of the orbit; on an
        :meth:`Orbit.table` and in events it is axis 3 of space.

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


def tilt_between(low: float, high: float, *, axis: int = 3) -> TiltBetween:
    """Stable: the angle of a body axis from the vertical stays between two limits.

    Parameters
    ----------
    low, high : float
        Limits in rad, ``0 <= low < high <= pi``.
    axis : {1, 2, 3, -1, -2, -3}
        The body axis; negative for its opposite direction.

    Returns
    -------
    TiltBetween

    Raises
    ------
    ValueError
        If the limits or the axis are out of range. A map of a free body refuses the criterion: its
        equations contain no vertical.

    Notes
    -----
    The upper limit is the limit of ``tilt_below(high, axis=axis)``, the lower one the limit of
    ``tilt_below(pi - low, axis=-axis)``: the tilts of opposite directions add up to pi. Lagrange
    tops are classified in closed form.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.tilt_between(0.3, 0.7))
    'tilt of axis 3 from the vertical between 0.3 and 0.7 rad'
    """
    return TiltBetween(low, high, axis)


def rate_within(angle: float, of: str = "omega", frame: str = "space") -> RateWithin:
    """Stable: angular velocity or angular momentum stays near its direction at the start.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    of : {"omega", "L"}
        The vector: angular velocity, or angular momentum about the fixed point.
    frame : {"space", "body"}
        Where the direction at the start is kept: fixed in space, or in the body.

    Returns
    -------
    RateWithin

    Raises
    ------
    ValueError
        If the angle is out of range, or the vector or frame is unknown.

    Notes
    -----
    The angle is observed as ``4 sin²(angle / 2)``, the square of the distance between two unit
    vectors, which is accurate for small angles. A body is undecided if the vector is zero at
    the start, or almost vanishes on its way: within a quarter of a step its direction turns by more
    than 1 rad, and the limit may be passed unseen. The angular momentum of a free body is
    constant in space: no free body leaves ``rate_within(angle, of="L")``, and none is integrated.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.rate_within(0.1, of="L", frame="body"))
    'L within 0.1 rad of its direction at the start in the body'
    """
    return RateWithin(angle, of, frame)


def near_start(angle: float) -> NearStart:
    """Stable: the attitude stays within a rotation angle of its start.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi]: the angle of the one rotation from the start to the attitude.

    Returns
    -------
    NearStart

    Raises
    ------
    ValueError
        If the angle is out of range.

    Notes
    -----
    The angle is observed as ``|R - R0|² = 8 sin²(angle / 2)`` (Frobenius norm), which is accurate
    for small angles. Near pi an error e of the attitude is one of ``sqrt(e)`` of the angle.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.near_start(0.2))
    'attitude within 0.2 rad of the start'
    """
    return NearStart(angle)


def pointing_within(
    angle: float, axis: int | None = None, of: str = "radial", *, either: bool = False
) -> PointingWithin:
    """Stable: a body axis stays within an angle of a direction that moves with the orbit.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    axis : {1, 2, 3, -1, -2, -3}, optional
        The body axis; negative for its opposite direction. By default the long axis, about which
        the moment is smallest, if this axis is the same in all pixels.
    of : {"radial", "along", "normal"}
        The direction: away from the planet; across it in the plane of the orbit, towards the
        motion; or the normal of the orbit.
    either : bool
        Whether the opposite of the axis counts too: watched is the end that is nearer to the
        direction at the start.

    Returns
    -------
    PointingWithin

    Raises
    ------
    ValueError
        If the angle, the axis or the direction is unknown or out of range. A map of a scene without
        an orbit refuses the criterion.

    Notes
    -----
    The angle is observed as ``4 sin²(angle / 2)``, as in :func:`rate_within`.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.pointing_within(0.5, axis=3, of="normal"))
    'axis 3 within 0.5 rad of the normal of the orbit'
    """
    return PointingWithin(angle, axis, of, either)


def librates(axis: int | None = None) -> PointingWithin:
    """Stable: the long axis never turns away from the planet, so that one side keeps facing it.

    The end of the axis that is nearer to the line from the planet at the start stays within 90
    degrees of it: ``pointing_within(pi/2, axis, either=True)``. In the plane of the orbit this is
    a libration of less than 90 degrees.

    Parameters
    ----------
    axis : {1, 2, 3}, optional
        The body axis; by default the axis of the smallest moment, if it is the same in all pixels.

    Returns
    -------
    PointingWithin

    Raises
    ------
    ValueError
        As :func:`pointing_within`.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.librates(1))
    'axis 1 within 90° of the radial direction, or of its opposite'
    """
    return PointingWithin(0.5 * pi, axis, either=True)


def roll_within(angle: float, axes: Axes | None = None) -> RollWithin:
    """Stable: the roll of a body on its orbit stays within an angle, from either side.

    Roll is about the axis that lies along the orbit at rest.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    axes : (int, int), optional
        The body axes at rest along the line from the planet and along the normal, as in
        :func:`rigid.free.roll_pitch_yaw`, which states the sequence. By default the long axis and
        the axis of the largest moment, if they are the same in all pixels, as a moon rests, and a
        satellite with the least energy.

    Returns
    -------
    RollWithin

    Raises
    ------
    ValueError
        If the angle or the axes are out of range. A map of a scene without an orbit, or with two
        equal moments, refuses the criterion.

    Notes
    -----
    Near gimbal lock, a pitch of 90 degrees, the roll swings fast. A body is undecided if within a
    quarter of a step its roll changes by more than 1 rad, and the limit may be passed unseen.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.roll_within(0.5, axes=(3, 2)))
    'roll within 0.5 rad'
    """
    return RollWithin(angle, axes)


def pitch_within(angle: float, axes: Axes | None = None) -> PitchWithin:
    """Stable: the pitch of a body on its orbit stays within an angle, from either side.

    Pitch is about the axis along the normal at rest: of a motion in the plane of the orbit it is
    the libration.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    axes : (int, int), optional
        The body axes at rest along the line from the planet and along the normal, as in
        :func:`rigid.free.roll_pitch_yaw`, which states the sequence. By default the long axis and
        the axis of the largest moment, if they are the same in all pixels, as a moon rests, and a
        satellite with the least energy.

    Returns
    -------
    PitchWithin

    Raises
    ------
    ValueError
        If the angle or the axes are out of range. A map of a scene without an orbit, or with two
        equal moments, refuses the criterion.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.pitch_within(0.5, axes=(3, 2)))
    'pitch within 0.5 rad'
    """
    return PitchWithin(angle, axes)


def yaw_within(angle: float, axes: Axes | None = None) -> YawWithin:
    """Stable: the yaw of a body on its orbit stays within an angle, from either side.

    Yaw is about the axis along the line from the planet at rest.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    axes : (int, int), optional
        The body axes at rest along the line from the planet and along the normal, as in
        :func:`rigid.free.roll_pitch_yaw`, which states the sequence. By default the long axis and
        the axis of the largest moment, if they are the same in all pixels, as a moon rests, and a
        satellite with the least energy.

    Returns
    -------
    YawWithin

    Raises
    ------
    ValueError
        If the angle or the axes are out of range. A map of a scene without an orbit, or with two
        equal moments, refuses the criterion.

    Notes
    -----
    Near gimbal lock, a pitch of 90 degrees, the yaw swings fast. A body is undecided if within a
    quarter of a step its yaw changes by more than 1 rad, and the limit may be passed unseen.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.yaw_within(0.5, axes=(3, 2)))
    'yaw within 0.5 rad'
    """
    return YawWithin(angle, axes)


def returns(angle: float, after: float) -> ReturnsNear:
    """Stable: the attitude comes back to within a rotation angle of its start.

    Parameters
    ----------
    angle : float
        Limit in rad, in (0, pi].
    after : float
        Time in s from which a return counts: later than the body first leaves, usually.

    Returns
    -------
    ReturnsNear

    Raises
    ------
    ValueError
        If the angle is out of range, or the time is negative.

    Notes
    -----
    This is ``~`` of *stays away from time* ``after`` *on*. A body that does not return until the
    horizon is unstable, and there is no time at which it left.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.returns(0.1, after=5.0))
    'attitude back within 0.1 rad of the start after 5 s'
    """
    return ReturnsNear(angle, after)


def spin_above(rate: float, axis: int | None = None) -> SpinAbove:
    """Stable: the rate about a body axis, or the length of ``omega``, stays above a limit.

    Parameters
    ----------
    rate : float
        Limit in rad/s, not negative.
    axis : {1, 2, 3, -1, -2, -3}, optional
        The body axis; negative for the rate about its opposite direction. By default the length of
        the rates.

    Returns
    -------
    SpinAbove

    Raises
    ------
    ValueError
        If the rate is negative or the axis unknown.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.spin_above(2.0, axis=-3))
    'rate about axis -3 above 2 rad/s'
    """
    return SpinAbove(rate, axis)


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
