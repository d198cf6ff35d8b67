"""The numbers of a scene that vary with the body, as variables of a Dataset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..model.forces import FORCES
from ..model.leading import Shape

_TORQUE = ("torque_time", "axis")
_OF_SCENE: Mapping[str, tuple[tuple[str, ...], str, tuple[str, ...], str]] = {
    "moments": (("body", "moments"), "kg m²", ("axis",), "principal moments of inertia"),
    "mass": (("body", "mass"), "kg", (), "mass"),
    "mgl": (("mgl",), "J", (), "mass times gravity times distance to the centre of mass"),
    "com": (("com",), "1", ("axis",), "direction to the centre of mass"),
    "torque": (("torque", "in_body"), "N m", _TORQUE, "applied torque in the body"),
    "torque_in_space": (("torque", "in_space"), "N m", _TORQUE, "applied torque in space"),
    "torque_data": (("torque", "function", "data"), "", ("number",), "data of the torque"),
    "damping": (("damping",), "N m s", ("axis", "axis_of_rate"), "damping"),
    **{name: ((name,), force.unit, ("axis",), force.title) for name, force in FORCES.items()},
}
"""Place in the scene, unit, axes after the axes of the bodies, and meaning of numbers along
principal axes."""


def take_numbers(scene: dict[str, Any], shape: Shape) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables of the numbers of each body, and the coordinates that they need.

    In the scene the name of the variable replaces them. What all bodies have in common stays.
    """
    bodies = tuple(f"body{k or ''}" for k in range(len(shape)))
    times = (scene.get("torque") or {}).get("times")
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, (place, unit, axes, words) in _OF_SCENE.items():
        holder: Any = scene
        for part in place[:-1]:
            holder = holder.get(part) or {}
        values = holder.get(place[-1])
        if values is None or np.ndim(values) <= len(axes):
            continue
        holder[place[-1]] = f"variable {name}"
        array = np.asarray(values, dtype=np.float64)
        array = np.broadcast_to(array, (*shape, *array.shape[array.ndim - len(axes) :]))
        if axes == _TORQUE and times:
            coordinates["torque_time"] = ("torque_time", times, {"units": "s"})
        elif axes == _TORQUE:
            array, axes = array[..., 0, :], ("axis",)
        variables[name] = ((*bodies, *axes), array, {"units": unit, "long_name": words})
    return variables, coordinates
