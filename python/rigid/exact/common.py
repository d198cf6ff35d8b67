"""Common functions of the closed forms of free bodies and of tops."""

from __future__ import annotations

from typing import Any

from ..model.batch import Shape


def in_shape(values: dict[str, Any], shape: Shape) -> dict[str, Any]:
    """Arrays with a row for each body, reshaped to the axes of the bodies."""
    if not shape:
        return {name: array[0] for name, array in values.items()}
    return {name: array.reshape((*shape, *array.shape[1:])) for name, array in values.items()}
