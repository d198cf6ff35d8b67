"""Words for a map that its picture and its page share."""

from __future__ import annotations

from ..model.criteria import Regular
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
