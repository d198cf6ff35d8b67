"""A stability map as an xarray Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..solve.dataset import as_dataset
from .counts import GROWTH
from .data import COLUMNS, STATUS, MapData
from .measured import NUMBERS
from .refine import refined
from .spec import MapSpec

if TYPE_CHECKING:
    import xarray

__all__ = ["map_dataset", "map_table"]


def map_dataset(data: MapData) -> xarray.Dataset:
    """The map as an xarray Dataset; see :meth:`rigid.StabilityMap.to_xarray`."""
    spec = data.spec
    axes = [(axis.name.replace("/", "_over_"), axis) for axis in spec.axes]
    dimensions = [name for name, _ in reversed(axes)]
    arrays = {
        name: (dimensions, getattr(data, name), attributes)
        for name, attributes in _array_attributes(spec).items()
    }
    if refined(spec):
        stage = {"long_name": "stage of refinement, 255: omitted", "units": "1"}
        arrays["stage"] = (dimensions, data.stage, stage)
        long_name = f"share {spec.criterion}, interpolated where it is omitted"
        arrays["share_filled"] = (dimensions, data.filled, {"long_name": long_name, "units": "1"})
    coordinates = {
        name: (name, list(axis.values), {"long_name": axis.name, "units": axis.unit})
        for name, axis in axes
    }
    for name, measured in data.measures.items():
        plain = name.replace("(", "_").replace(")", "").replace("-", "minus")
        for number in NUMBERS:
            unit = "1" if number == "count" else measured.measure.unit
            about = {"long_name": f"{number} of the {measured.measure.words}", "units": unit}
            arrays[f"{plain}_{number}"] = (dimensions, getattr(measured, number), about)
    attributes = {
        "title": spec.title or "",
        "criterion": spec.criterion,
        "complete": int(data.complete),
        "rigid_version": spec.version,
        "spec": spec.to_json(),
    }
    return as_dataset(arrays, coordinates, attributes)


def map_table(data: MapData) -> dict[str, NDArray[Any]]:
    """The columns of a tidy table of the map, which broadcast to the grid."""
    axes = data.spec.axes
    columns: dict[str, NDArray[Any]] = {
        axis.name: np.reshape(axis.values, (-1,) + (1,) * place) for place, axis in enumerate(axes)
    }
    columns |= {name: getattr(data, name) for name in _array_attributes(data.spec)}
    for name, measured in data.measures.items():
        for number in NUMBERS:
            columns[f"{number} of {name}"] = getattr(measured, number)
    return columns


def _array_attributes(spec: MapSpec) -> dict[str, dict[str, Any]]:
    share = f"share {spec.criterion}"
    growth = {
        "exponent": {"long_name": "mean exponent", "units": "1/s"},
        "mean_megno": {"long_name": "mean of the mean MEGNO", "units": "1"},
    }
    known = [column for column in COLUMNS if spec.stable.has_deviation or column.name not in GROWTH]
    return {
        "share": {"long_name": share, "units": "1"},
        "lower": {"long_name": f"lower end of the 95 % interval of the {share}", "units": "1"},
        "upper": {"long_name": f"upper end of the 95 % interval of the {share}", "units": "1"},
        "samples": {"long_name": "bodies done", "units": "1"},
        **(growth if spec.stable.has_deviation else {}),
        **{column.name: {"long_name": column.words, "units": column.unit} for column in known},
        "status": {
            "long_name": "status of the body",
            "units": "1",
            "flag_values": list(range(len(STATUS))),
            "flag_meanings": " ".join(text.replace(" ", "_") for text in STATUS),
        },
    }
