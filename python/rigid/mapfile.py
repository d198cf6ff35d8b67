"""A stability map for other programs: one data-only file, or an xarray Dataset.

The file is an ``.npz`` archive of arrays with the specification as JSON inside. Nothing is pickled,
nothing is compressed, and dates are fixed: equal maps are equal bytes.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .mapresult import COUNTS, FAILURES, STATUS, STORED, StabilityMap
from .mapspec import MapSpec

if TYPE_CHECKING:
    import zipfile
    from pathlib import Path

    import xarray

__all__ = ["load_map", "map_dataset", "write_map"]

FORMAT = "rigid stability map"
FORMAT_VERSION = 3
_EPOCH = (1980, 1, 1, 0, 0, 0)
_SPEC = "spec.json"


def write_map(result: StabilityMap, path: str | os.PathLike[str]) -> Path:
    """Write a map; see :meth:`StabilityMap.save`."""
    import zipfile  # here and below: takes longer to import than all of rigid
    from pathlib import Path

    target = Path(path)
    header = {"format": FORMAT, "format_version": FORMAT_VERSION, "spec": result.spec.to_dict()}
    text = json.dumps(header, indent=1, allow_nan=False)
    arrays: dict[str, NDArray[Any]] = {_SPEC: np.frombuffer(text.encode(), dtype=np.uint8)}
    for name, axis in zip(("x", "y"), result.spec.axes, strict=False):
        arrays[name] = np.array(axis.values)
    for name in (*STORED, "share", "lower", "upper"):
        arrays[name] = getattr(result, name)
    # Written beside the target and renamed, so that no half file carries the name.
    scratch = target.with_name(f"{target.name}.part")
    try:
        with zipfile.ZipFile(scratch, "w", zipfile.ZIP_STORED) as archive:
            for name, array in arrays.items():
                entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
                entry.create_system = 3  # else it would tell Windows from the rest
                with archive.open(entry, "w", force_zip64=True) as file:
                    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
                    np.lib.format.write_array(file, little, version=(1, 0), allow_pickle=False)
        os.replace(scratch, target)
    finally:
        scratch.unlink(missing_ok=True)
    return target


def load_map(path: str | os.PathLike[str]) -> StabilityMap:
    """Read a map that :meth:`StabilityMap.save` wrote.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    StabilityMap
        Equal to the saved one, except for what was measured on the machine: ``nanoseconds`` and
        ``elapsed`` are NaN, ``threads`` is 0.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is not a stability map, or one of a newer format.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...     stable=rigid.no_flip(), rng=2026,
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = result.save(pathlib.Path(folder, "map.npz"))
    ...     rigid.load_map(path).spec == result.spec
    True
    """
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
    except Exception as error:  # there is no end to what a damaged archive raises
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
    return StabilityMap.from_arrays(spec, arrays)


def _read_array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    with archive.open(f"{name}.npy") as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def map_dataset(result: StabilityMap) -> xarray.Dataset:
    """The map as an xarray Dataset; see :meth:`StabilityMap.to_xarray`."""
    try:
        import xarray
    except ImportError:
        raise ImportError("to_xarray() needs xarray: pip install 'rigid[maps]'") from None
    spec = result.spec
    axes = [(axis.name.replace("/", "_over_"), axis) for axis in spec.axes]
    dimensions = [name for name, _ in reversed(axes)]
    data = {
        name: (dimensions, getattr(result, name), attributes)
        for name, attributes in _array_attributes(spec).items()
    }
    coordinates = {
        name: (name, list(axis.values), {"long_name": axis.name, "units": axis.unit})
        for name, axis in axes
    }
    attributes = {
        "title": spec.title or "",
        "criterion": spec.criterion,
        "complete": int(result.complete),
        "rigid_version": spec.version,
        "spec": spec.to_json(),
    }
    return xarray.Dataset(data, coordinates, attributes)


def _array_attributes(spec: MapSpec) -> dict[str, dict[str, Any]]:
    share = f"share {spec.criterion}"
    attributes: dict[str, dict[str, Any]] = {
        "share": {"long_name": share, "units": "1"},
        "lower": {"long_name": f"lower end of the 95 % interval of the {share}", "units": "1"},
        "upper": {"long_name": f"upper end of the 95 % interval of the {share}", "units": "1"},
    }
    for name in (*COUNTS, *FAILURES, "samples"):
        words = "bodies done" if name == "samples" else f"{name.replace('_', ' ')} bodies"
        attributes[name] = {"long_name": words, "units": "1"}
    return attributes | {
        "energy_drift": {"long_name": "worst relative drift of the energy", "units": "1"},
        "momentum_drift": {"long_name": "worst relative drift of the momentum", "units": "1"},
        "earliest": {"long_name": "first time of leaving stability", "units": "s"},
        "steps": {"long_name": "time steps", "units": "1"},
        "exact": {"long_name": "bodies classified in closed form", "units": "1"},
        "nanoseconds": {"long_name": "processor time", "units": "ns"},
        "status": {
            "long_name": "status of the body",
            "units": "1",
            "flag_values": list(range(len(STATUS))),
            "flag_meanings": " ".join(text.replace(" ", "_") for text in STATUS),
        },
    }


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
