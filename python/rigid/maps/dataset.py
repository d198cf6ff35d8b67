"""A stability map as an xarray Dataset, as a Zarr store of version 3, and as a table."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks.extras import install_extra
from .._files import synchronise
from ..solve.columns import as_dataset
from .data import COLUMNS, GROWTH, STATUS, MapData
from .measured import NUMBERS
from .refine import refined

if TYPE_CHECKING:
    import xarray


def map_dataset(data: MapData) -> xarray.Dataset:
    """The map as an xarray Dataset; see :meth:`rigid.StabilityMap.to_xarray`."""
    spec = data.spec
    columns = _columns(data)
    if refined(spec):
        words = f"share {spec.criterion}, interpolated where it is omitted"
        columns += [
            ("stage", "", data.stage, _about("stage of refinement, 255: omitted")),
            ("share_filled", "", data.filled, _about(words)),
        ]
    taken = [name for name, *_ in columns]
    coordinates: dict[str, Any] = {}
    for axis in spec.axes:
        name = _free_name(axis.name.replace("/", "_over_"), taken)
        coordinates[name] = (name, list(axis.values), _about(axis.name, axis.unit))
    dimensions = list(coordinates)[::-1]
    attributes = {
        "title": spec.title or "",
        "criterion": spec.criterion,
        "complete": int(data.complete),
        "rigid_version": spec.version,
        "spec": spec.to_json(),
    }
    return as_dataset(
        {name: (dimensions, array, about) for name, _, array, about in columns},
        coordinates,
        attributes,
    )


def map_table(data: MapData) -> dict[str, NDArray[Any]]:
    """The columns of a tidy table of the map, which broadcast to the grid."""
    columns = {title: array for _, title, array, _ in _columns(data)}
    axes = {
        _free_name(axis.name, columns): np.reshape(axis.values, (-1,) + (1,) * place)
        for place, axis in enumerate(data.spec.axes)
    }
    return {**axes, **columns}


def _free_name(name: str, taken: Collection[str]) -> str:
    """The name of an axis, also where an argument of the user's function is called as a column."""
    return f"axis_{name}" if name in taken else name


def _columns(data: MapData) -> list[tuple[str, str, NDArray[Any], dict[str, Any]]]:
    """Name in a Dataset and in a table, numbers and attributes of each column."""
    spec = data.spec
    deviation = spec.stable.has_deviation
    share = f"share {spec.criterion}"
    known = {
        "share": _about(share),
        "lower": _about(f"lower end of the 95 % interval of the {share}"),
        "upper": _about(f"upper end of the 95 % interval of the {share}"),
        "samples": _about("bodies done"),
    }
    if deviation:
        known["exponent"] = _about("mean exponent", "1/s")
        known["mean_megno"] = _about("mean of the mean MEGNO")
    for column in COLUMNS:
        if deviation or column.name not in GROWTH:
            known[column.name] = _about(column.words, column.unit)
    known["status"] = {
        **_about("status of the body"),
        "flag_values": list(range(len(STATUS))),
        "flag_meanings": " ".join(text.replace(" ", "_") for text in STATUS),
    }
    columns = [(name, name, getattr(data, name), about) for name, about in known.items()]
    for name, measured in data.measures.items():
        plain = name.replace("(", "_").replace(")", "").replace("-", "minus")
        for number in NUMBERS:
            unit = "1" if number == "count" else measured.measure.unit
            about = _about(f"{number} of the {measured.measure.words}", unit)
            title = f"{number} of {name}"
            columns.append((f"{plain}_{number}", title, getattr(measured, number), about))
    return columns


def _about(words: str, unit: str = "1") -> dict[str, Any]:
    return {"long_name": words, "units": unit}


def write_zarr(data: MapData, path: str | os.PathLike[str]) -> Path:
    """Write a map as a folder that appears whole or not at all; see :func:`write_zarr_url`."""
    target = Path(path)
    if os.path.lexists(target):
        raise FileExistsError(f"path = {os.fspath(target)!r}: must be new")
    scratch = target.with_name(f".rigid-{os.urandom(16).hex()}.part")
    try:
        write_zarr_url(data, os.fspath(scratch))
        for folder, _, names in os.walk(scratch):
            for name in names:
                synchronise(os.path.join(folder, name))
            synchronise(folder)
        scratch.rename(target)
        synchronise(target.absolute().parent)
    except BaseException:
        shutil.rmtree(scratch, ignore_errors=True)
        raise
    return target


def write_zarr_url(data: MapData, url: str) -> None:
    """Write a map as Zarr to a new place that zarr knows: a folder, or the URL of a bucket.

    Each array, coordinates too, is one chunk with a CRC-32C: damage is found.
    """
    try:
        from zarr.codecs import Crc32cCodec
    except ImportError:
        raise ImportError(install_extra("a .zarr needs zarr", "store")) from None
    dataset = map_dataset(data).drop_vars("nanoseconds")  # a measurement of the machine
    encoding: dict[Any, Any] = {
        name: {
            "chunks": variable.shape,
            "compressors": [Crc32cCodec()],
            "write_empty_chunks": True,
        }
        for name, variable in dataset.variables.items()
    }
    dataset.to_zarr(url, mode="w-", zarr_format=3, consolidated=False, encoding=encoding)
