"""Common functions of the closed forms of free bodies and of tops."""

from __future__ import annotations

from typing import Any

from ..model.scene import Scene

__all__ = ["first_rows", "require_unforced"]


def require_unforced(scene: Scene) -> None:
    """Raise ValueError if torque or damping acts on the scene."""
    if scene.is_driven:
        raise ValueError(f"scene = {scene.words()}: no closed form under torque and damping")


def first_rows(values: dict[str, Any]) -> dict[str, Any]:
    """The first row of each array: the values of a single body."""
    return {name: array[0] for name, array in values.items()}
