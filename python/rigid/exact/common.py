"""Common functions of the closed forms of free bodies and of tops."""

from __future__ import annotations

from typing import Any

from ..model.forces import forces_in_words
from ..model.leading import Shape
from ..model.scene import Scene

__all__ = ["in_shape", "require_unforced"]


def require_unforced(scene: Scene) -> None:
    """Raise ValueError if torque or damping acts on the scene."""
    if scene.forces:
        acting = forces_in_words(scene.forces)
        raise ValueError(
            f"scene = {scene.words()}: no closed form under {acting}; rigid.simulate integrates"
        )


def in_shape(values: dict[str, Any], shape: Shape) -> dict[str, Any]:
    """Arrays with a row for each body, reshaped to the axes of the bodies."""
    if not shape:
        return {name: array[0] for name, array in values.items()}
    return {name: array.reshape((*shape, *array.shape[1:])) for name, array in values.items()}
