"""The axes of a map: parameters with their values, and which of them go together."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, numbers, of_known
from ..model.parameters import ATTITUDE_UNFELT, PARAMETERS, Parameter
from ..model.scene import Scene
from ..model.start import Start

MOST_AXES = 32
"""Most axes of a map: all versions of NumPy allow as many."""

EXCLUSIVE = (
    ("box", "moments", "the moments of a box follow from its sides"),
    ("semi-axes", "moments", "the moments of an ellipsoid follow from its semi-axes"),
    ("semi-axes", "box", "both say which shape the body has"),
    ("com angles", "com", "both say where the centre of mass is"),
)
"""Places whose parameters exclude each other, and why."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a map: a parameter name and its values, increasing or decreasing."""

    name: str
    values: tuple[float, ...]
    own: bool
    """Whether the axis is an argument of the function that makes the scene."""

    @property
    def parameter(self) -> Parameter:
        """The row of :data:`PARAMETERS` that the axis varies, or the argument of the function."""
        if not self.own:
            return PARAMETERS[self.name]
        return Parameter(self.name, "1", "argument of the function of the scene", "function")

    @property
    def unit(self) -> str:
        """Unit of the values (SI, or any consistent set)."""
        return self.parameter.unit

    @property
    def label(self) -> str:
        """Symbol and unit for a plot."""
        symbol = self.parameter.symbol
        return symbol if self.unit == "1" else f"{symbol} ({self.unit})"

    @property
    def geometric(self) -> bool:
        """Whether the values form a geometric progression, which is drawn on a logarithmic axis."""
        values = np.array(self.values)
        if values.size < 3 or values.min() <= 0.0:
            return False
        steps = np.diff(np.log(values))
        return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))

    def __str__(self) -> str:
        return self.words(self.unit)

    def words(self, unit: str) -> str:
        """Name, range and number of values, in this unit."""
        space = "" if unit == "1" else f" {unit}"
        count = f"{len(self.values)} values{', geometric' if self.geometric else ''}"
        return f"{self.name} from {self.values[0]:g} to {self.values[-1]:g}{space} ({count})"


def make_axes(axes: Mapping[str, ArrayLike], own: Container[str] = ()) -> tuple[Axis, ...]:
    """The axes of a map from names and values; x first, then y.

    The names in ``own`` are arguments of the function that makes the scene.

    Raises
    ------
    ValueError
        For an unknown name, no axes or more than 32, or values that are not finite, not
        one-dimensional, not strictly increasing or decreasing, or out of range.
    """
    if not isinstance(axes, Mapping):
        raise TypeError(f"axes = {brief(axes)}: must be a dict of names and values")
    if not 1 <= len(axes) <= MOST_AXES:
        raise ValueError(
            f"axes: expected 1 to {MOST_AXES} parameters (x, then y, ...), got {len(axes)}"
        )
    return tuple(_axis(name, values, name in own) for name, values in axes.items())


def check_axis_name(name: str) -> None:
    """Raise ValueError if no parameter of a map has this name."""
    if name not in PARAMETERS:
        raise ValueError(
            f"axes: unknown parameter {brief(name)}{of_known(name, PARAMETERS)}; for a parameter "
            "of yours give a function of it that returns the scene, instead of the scene"
        )


def _axis(name: str, values: ArrayLike, own: bool) -> Axis:
    if not own:
        check_axis_name(name)
    array = numbers(f"axes[{name!r}]", values, None if own else PARAMETERS[name].unit)
    if array.ndim != 1 or array.size == 0:
        raise ValueError(f"axes[{name!r}]: expected shape (n,) with n >= 1, got {array.shape}")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array))[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]}: must be finite")
    steps = np.diff(array)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError(f"axes[{name!r}]: must increase or decrease strictly")
    axis = Axis(name, tuple(array.tolist()), own)
    rejected = np.flatnonzero(axis.parameter.rejects(array))
    if rejected.size:
        bad = int(rejected[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]:g}: {axis.parameter.rule}")
    return axis


def check_applicable(scene: Scene, start: Start, axes: Iterable[Axis]) -> None:
    """Raise ValueError, with the reason, if an axis or a part of the start has no meaning here."""
    if not scene.rates_need_attitude and start.attitude_noise is not None:
        raise ValueError(f"attitude_noise = {start.attitude_noise.describe()}: {ATTITUDE_UNFELT}")
    if not scene.rates_need_attitude and start.noise is not None and start.joint:
        raise ValueError(f"noise = {start.noise.describe()}: {ATTITUDE_UNFELT}")
    if not scene.directions and start.omega is not None and start.tilt != 0.0:
        raise ValueError("tilt: has no effect on a free body started by omega; use Start(spin=...)")
    check_meanings("axes", tuple(axes), scene, start)


class Named(Protocol):
    """An axis, or a parameter that varies from body to body."""

    @property
    def name(self) -> str:
        """The name of the parameter."""

    @property
    def parameter(self) -> Parameter:
        """The row of the parameter."""


def check_meanings(
    argument: str, named: Sequence[Named], scene: Scene, start: Start, beside: Sequence[Named] = ()
) -> None:
    """Raise ValueError, with the reason, if parameters do not apply or exclude each other.

    Those ``beside`` them, of another argument, may be in places that exclude theirs.
    """
    for one in named:
        reason = one.parameter.why_not(scene, start)
        if reason:
            raise ValueError(f"{argument}: {one.name!r} does not apply: {reason}")
    every = (*beside, *named)
    for first, second, reason in EXCLUSIVE:
        _check_exclusive(argument, _at(every, first), _at(every, second), reason)
    check_once(argument, named)


def check_once(argument: str, named: Sequence[Named]) -> None:
    """Raise ValueError if two parameters set one number."""
    for place in dict.fromkeys(one.parameter.place for one in named):
        mine = _at(named, place)
        # A parameter without an index sets all numbers of a place.
        whole, parts = (
            [a for a in mine if bool(a.parameter.index) is part] for part in (False, True)
        )
        _check_exclusive(argument, whole, parts, f"both set the {place}")
        setters: dict[tuple[int, ...], Named] = {}
        for one in parts:
            first = setters.setdefault(one.parameter.index, one)
            if first is not one:
                number = first.parameter.sets(first.name)[0]
                raise ValueError(f"{argument}: {first.name!r} and {one.name!r} both set {number}")
    _check_ratios(argument, _at(named, "moments"))


def _at(named: Iterable[Named], place: str) -> list[Named]:
    """The parameters whose numbers are in this place."""
    return [one for one in named if one.parameter.place == place]


def _check_exclusive(
    argument: str, first: Sequence[Named], second: Sequence[Named], reason: str
) -> None:
    """Raise ValueError if there are parameters of both kinds."""
    if first and second:
        raise ValueError(
            f"{argument}: {second[0].name!r} and {first[0].name!r} exclude each other: {reason}"
        )


def _check_ratios(argument: str, named: Sequence[Named]) -> None:
    """Raise ValueError if a ratio of moments is given twice."""
    setters: dict[int | None, Named] = {one.parameter.index[0]: one for one in named}
    for one in named:
        seen, at = [one.name], one.parameter.times
        while at in setters:
            if setters[at] is one:
                both = " and ".join(map(repr, seen))
                what = "the same ratio" if len(seen) == 2 else "ratios that depend on each other"
                raise ValueError(f"{argument}: {both} set {what}")
            seen.append(setters[at].name)
            at = setters[at].parameter.times


def in_order(named: Sequence[Named]) -> list[int]:
    """Positions of parameters in an order in which each moment is set before it is read."""
    setters = {one.parameter.index: one for one in _at(named, "moments")}

    def depth(one: Named) -> int:
        read = one.parameter.times
        before = None if read is None else setters.get((read,))
        return 0 if before is None else 1 + depth(before)

    return sorted(range(len(named)), key=lambda place: depth(named[place]))


def axis_letter(place: int) -> str:
    """The name of an axis by its place, for tables, files and pictures: x, y, z, axis4, ..."""
    return "xyz"[place] if place < 3 else f"axis{place + 1}"
