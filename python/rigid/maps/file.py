"""A stability map as one data-only file.

The file is an ``.npz`` archive of arrays with the specification as JSON inside. Nothing is pickled,
nothing is compressed, and dates are fixed: equal maps are equal bytes.
"""

from __future__ import annotations

import json
import math
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._files import published
from .data import STORED, MapData
from .spec import MapSpec

if TYPE_CHECKING:
    import zipfile
    from pathlib import Path

__all__ = ["file_size", "read_map", "write_map"]

FORMAT = "rigid stability map"
FORMAT_VERSION = 3
_EPOCH = (1980, 1, 1, 0, 0, 0)
_SPEC = "spec.json"

_DERIVED = ("share", "lower", "upper")
"""Arrays of floats for other programs; they follow from the others and are not read."""

_ENTRY = 1024
"""More bytes than the headers and the entry of an array in the directory take."""


def write_map(data: MapData, path: str | os.PathLike[str]) -> Path:
    """Write a map; see :meth:`rigid.StabilityMap.save`."""
    import zipfile  # here and below: takes longer to import than all of rigid
    from pathlib import Path

    target = Path(path)
    arrays: dict[str, NDArray[Any]] = {_SPEC: np.frombuffer(_header(data.spec), dtype=np.uint8)}
    for name, axis in zip(("x", "y"), data.spec.axes, strict=False):
        arrays[name] = np.array(axis.values)
    for name in (*STORED, *_DERIVED):
        arrays[name] = getattr(data, name)
    with (
        published(target) as whole,
        zipfile.ZipFile(whole, "w", zipfile.ZIP_STORED) as archive,
    ):
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
            entry.create_system = 3  # Unix on all systems, so that the bytes are equal
            with archive.open(entry, "w", force_zip64=True) as file:
                little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
                np.lib.format.write_array(file, little, version=(1, 0), allow_pickle=False)
    return target


def file_size(spec: MapSpec) -> int:
    """An upper bound of the size of the file of a map, bytes; close for maps of many pixels."""
    axes = [len(axis.values) for axis in spec.axes]
    pixel = sum(dtype.itemsize for dtype in STORED.values()) + 8 * len(_DERIVED)
    arrays = pixel * math.prod(axes) + 8 * sum(axes)
    return len(_header(spec)) + arrays + _ENTRY * (1 + len(axes) + len(STORED) + len(_DERIVED))


def _header(spec: MapSpec) -> bytes:
    header = {"format": FORMAT, "format_version": FORMAT_VERSION, "spec": spec.to_dict()}
    return json.dumps(header, indent=1, allow_nan=False).encode()


def read_map(path: str | os.PathLike[str]) -> tuple[MapSpec, dict[str, NDArray[Any]]]:
    """Specification and :data:`STORED` arrays of a saved map; see :func:`rigid.load_map`."""
    import zipfile
    from io import BytesIO
    from pathlib import Path

    source = Path(path)
    content = BytesIO(source.read_bytes())
    try:
        with zipfile.ZipFile(content) as archive:
            header = json.loads(_read_array(archive, _SPEC).tobytes().decode())
            ours = isinstance(header, dict) and header.get("format_version") == FORMAT_VERSION
            arrays = {name: _read_array(archive, name) for name in STORED if ours}
    except Exception as error:  # a damaged archive may raise any exception
        raise ValueError(f"{source} is not a stability map: {_one_line(error)}") from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise ValueError(f"{source} is not a stability map: its header is not that of one")
    if header.get("format_version") != FORMAT_VERSION:
        raise ValueError(
            f"{source} has format version {header.get('format_version')}, "
            f"this version of rigid reads {FORMAT_VERSION}"
        )
    try:
        spec = MapSpec.from_dict(header["spec"])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{source} holds a broken specification: {_one_line(error)}") from None
    for name, array in arrays.items():
        if array.shape != spec.shape:
            raise ValueError(
                f"{source} is damaged: {name} has shape {array.shape}, expected {spec.shape}"
            )
        try:
            arrays[name] = array.astype(STORED[name], casting="same_kind")
        except TypeError:
            raise ValueError(f"{source} is damaged: {name} has type {array.dtype}") from None
    return spec, arrays


def _read_array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    with archive.open(f"{name}.npy") as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
