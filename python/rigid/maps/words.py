"""Words for a map that its picture and its page share."""

from __future__ import annotations

from ..model.criteria import Regular
from .axes import Axis
from .spec import MapSpec


def class_words(spec: MapSpec) -> dict[str, str]:
    """The word for each class of bodies: by a growth of deviations they are regular or chaotic."""
    stable, unstable = "stable", "unstable"
    if isinstance(spec.stable, Regular):
        stable, unstable = "regular", "chaotic"
    return {
        "stable": stable,
        "unstable": unstable,
        "undecided": "undecided",
        "failed": "failed",
    }


def default_title(spec: MapSpec) -> str:
    """What a map without a title shows: of a satellite, if it has an orbit."""
    what = "Regular motions" if isinstance(spec.stable, Regular) else "Stability"
    return f"{what} of a {'satellite' if 'orbit' in spec.forces else spec.scene.title}"


def axis_label(spec: MapSpec, axis: Axis) -> str:
    """Symbol and unit of an axis; on an orbit of mean motion 1 rates are multiples of it."""
    unit = own_unit(spec, axis.unit)
    if unit == "n":
        return f"{axis.parameter.symbol} over mean motion"
    return axis.label if unit == axis.unit else f"{axis.parameter.symbol} ({unit})"


def own_unit(spec: MapSpec, unit: str) -> str:
    """The unit of the numbers of a map, whose time is counted in orbits or seconds."""
    return {"rad/s": "n", "s": "1/n"}.get(unit, unit) if spec.clock.by_motion else unit
