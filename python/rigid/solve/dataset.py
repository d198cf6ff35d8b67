"""A run as an xarray Dataset: its arrays, and the numbers of the scene that vary with the body."""

from __future__ import annotations

import json
from collections.abc import Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks.extras import install_extra
from ..model.forces import FORCES
from ..model.leading import Shape

if TYPE_CHECKING:
    import xarray

__all__ = ["ARRAYS", "as_dataset", "run_dataset"]

_STATES, _BODIES = ("t",), ()
ARRAYS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "t": ("s", _STATES),
    "omega": ("rad/s", (*_STATES, "axis")),
    "gamma": ("1", (*_STATES, "axis")),
    "attitude": ("1", (*_STATES, "part")),
    "work": ("J", _STATES),
    "tangent": ("", (*_STATES, "row", "column")),
    "sensitivity": ("", (*_STATES, "row", "parameter")),
    "end": ("s", _BODIES),
    "start_omega": ("rad/s", ("axis",)),
    "start_attitude": ("1", ("part",)),
    "energy_drift": ("1", _BODIES),
    "momentum_drift": ("1", _BODIES),
    "unit_drift": ("1", _BODIES),
    "status": ("", _BODIES),
    "steps": ("", _BODIES),
    "error": ("", _BODIES),
    "lost_from": ("s", _BODIES),
}
"""Unit, and axes after the axes of the bodies, of each array of a run."""

_TORQUE = ("torque_time", "axis")
_OF_SCENE: Mapping[str, tuple[tuple[str, ...], str, tuple[str, ...], str]] = {
    "moments": (("body", "moments"), "kg m²", ("axis",), "principal moments of inertia"),
    "mass": (("body", "mass"), "kg", _BODIES, "mass"),
    "mgl": (("mgl",), "J", _BODIES, "mass times gravity times distance to the centre of mass"),
    "com": (("com",), "1", ("axis",), "direction to the centre of mass"),
    "torque": (("torque", "in_body"), "N m", _TORQUE, "applied torque in the body"),
    "torque_in_space": (("torque", "in_space"), "N m", _TORQUE, "applied torque in space"),
    "torque_data": (("torque", "function", "data"), "", ("number",), "data of the torque"),
    "damping": (("damping",), "N m s", ("axis", "axis_of_rate"), "damping"),
    **{name: ((name,), force.unit, ("axis",), force.title) for name, force in FORCES.items()},
}
"""Place in the scene, unit, axes after the axes of the bodies, and meaning of numbers along
principal axes."""


def as_dataset(
    arrays: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> xarray.Dataset:
    """Arrays with their axes and units as an xarray Dataset.

    Raises
    ------
    ImportError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise ImportError(install_extra("to_xarray() needs xarray", "maps")) from None
    return xarray.Dataset(arrays, coordinates, attributes)


def run_dataset(run: Any) -> xarray.Dataset:
    """The run as an xarray Dataset; see :meth:`rigid.Run.to_xarray`."""
    bodies = tuple(f"body{k or ''}" for k in range(run.status.ndim))
    arrays: dict[str, Any] = {}
    for name, (unit, dimensions) in ARRAYS.items():
        array = getattr(run, name)
        if array is not None and name != "t":
            arrays[name] = ((*bodies, *dimensions), array, {"units": unit})
    coordinates: dict[str, Any] = {"axis": [1, 2, 3]}
    # Texts as objects: Zarr has no specification of texts of a fixed length, and warns of them.
    coordinates["part"] = np.array(list("wxyz"), dtype=object)
    if run.sensitivity is not None:
        coordinates["parameter"] = np.array(run.parameters, dtype=object)
    if run.t.ndim == 1:
        coordinates["t"] = ("t", run.t, {"units": "s"})
    else:
        # Each body has its times: these are no common coordinate.
        arrays["time"] = ((*bodies, "t"), np.broadcast_to(run.t, run.omega.shape[:-1]))
    spec = deepcopy(run.spec)
    times = (spec["scene"].get("torque") or {}).get("times")
    for name, values in _take_numbers(spec["scene"], run.status.shape).items():
        _, unit, dimensions, words = _OF_SCENE[name]
        if dimensions == _TORQUE:
            if times:
                coordinates["torque_time"] = ("torque_time", times, {"units": "s"})
            else:
                values, dimensions = values[..., 0, :], ("axis",)
        arrays[name] = ((*bodies, *dimensions), values, {"units": unit, "long_name": words})
    attributes = {"spec": json.dumps(spec), "plan": run.plan.to_json()}
    return as_dataset(arrays, coordinates, attributes)


def _take_numbers(scene: dict[str, Any], shape: Shape) -> dict[str, NDArray[np.float64]]:
    """The numbers of each body, in the axes of the bodies; the name of the variable replaces these.

    What all bodies have in common stays in the scene.
    """
    found = {}
    for name, (place, _, dimensions, _) in _OF_SCENE.items():
        holder: Any = scene
        for part in place[:-1]:
            holder = holder.get(part) or {}
        values = holder.get(place[-1])
        if values is None or np.ndim(values) <= len(dimensions):
            continue
        array = np.asarray(values, dtype=np.float64)
        tail = array.shape[array.ndim - len(dimensions) :]
        found[name] = np.broadcast_to(array, (*shape, *tail))
        holder[place[-1]] = f"variable {name}"
    return found
