"""A stability map as one data-only file.

The file is an archive of arrays with the specification as JSON inside. A reader knows the size of
everything from the size of the file and the specification before it reads: see ``_read``.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._archive import Archive, DamageError, FileError, ForeignError, write_archive
from .._checks.arguments import one_line
from .._checks.inputs import described
from .axes import MOST_AXES, axis_letter
from .data import CLASSES, STORED, MapData, check_counts
from .measured import BIN
from .spec import MapSpec

FORMAT = "rigid stability map"
FORMAT_VERSION = 1

_SPEC = "spec.json"
_BINS = "measure"

_DERIVED = ("share", "lower", "upper")
"""Arrays of floats for other programs; they follow from the others and are not read."""

MOST_DIRECTORY = 2**16
"""Most bytes of the directory of a file."""

MOST_TEXT = 2**16
"""Most bytes of a specification without the values of its axes; the arrays are longer."""

_ENTRY = 1024
"""More bytes than the headers and the entry of an array in the directory take."""

MOST_BINS = 2**18
"""Most bins of a pixel: the number of bins of all numbers."""

Bins: TypeAlias = NDArray[np.int64]


def write_map(data: MapData, path: str | os.PathLike[str]) -> Path:
    """Write a map; see :meth:`rigid.StabilityMap.save`."""
    arrays: dict[str, NDArray[Any]] = {_SPEC: np.frombuffer(_header(data.spec), dtype=np.uint8)}
    for place, axis in enumerate(data.spec.axes):
        arrays[axis_letter(place)] = np.array(axis.values)
    for name in (*STORED, *_DERIVED):
        arrays[name] = getattr(data, name)
    for number, measured in enumerate(data.measures.values()):
        arrays[f"{_BINS}{number}"] = measured.bins
    write_archive(path, arrays)
    return Path(path)


def file_size(spec: MapSpec) -> int:
    """An upper bound of the size of the file of a map, bytes; close for maps of many pixels."""
    axes = [len(axis.values) for axis in spec.axes]
    pixel = sum(dtype.itemsize for dtype in STORED.values()) + 8 * len(_DERIVED)
    arrays = pixel * math.prod(axes) + 8 * sum(axes)
    # As many bins as values, at most: the values of one pixel mostly share some.
    bins = len(spec.measure) * math.prod(axes) * min(spec.samples, MOST_BINS) * 8 * BIN
    entries = 1 + len(axes) + len(STORED) + len(_DERIVED) + len(spec.measure)
    return len(_header(spec)) + arrays + bins + _ENTRY * entries


def _header(spec: MapSpec) -> bytes:
    header = {"format": FORMAT, "format_version": FORMAT_VERSION, "spec": spec.to_dict()}
    return json.dumps(header, indent=1, allow_nan=False).encode()


def read_map(path: str | os.PathLike[str]) -> tuple[MapSpec, dict[str, NDArray[Any]], list[Bins]]:
    """Specification, :data:`STORED` arrays and bins of measures; see :func:`rigid.load_map`."""
    source = Path(path)
    source.stat()
    if not source.is_file():
        raise ValueError(f"{source} is not a stability map: it is {described(source)}")
    try:
        with source.open("rb") as file:
            return _read(Archive(file, MOST_DIRECTORY))
    except DamageError as error:
        why = f"is damaged: {one_line(error)}"
    except ForeignError as error:
        why = f"is not a stability map: {one_line(error)}"
    except FileError as error:
        why = one_line(error)
    except Exception as error:  # a damaged archive may raise any exception
        what = described(source)
        why = f"it is damaged: {one_line(error)}" if "load_map" in what else f"it is {what}"
        why = f"is not a stability map: {why}"
    raise ValueError(f"{source} {why}")


def _read(archive: Archive) -> tuple[MapSpec, dict[str, NDArray[Any]], list[Bins]]:
    """Read a map with no more memory than a small multiple of the size of its file."""
    if archive.size(_SPEC) > MOST_TEXT + archive.length // 4:
        raise ForeignError("its specification is longer than its arrays")
    header = json.loads(archive.read(_SPEC, np.dtype(np.uint8)).tobytes().decode())
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise ForeignError("its header is another one")
    version = header.get("format_version")
    if version != FORMAT_VERSION:
        raise FileError(
            f"has format version {version}, this version of rigid reads {FORMAT_VERSION}: read it "
            "with the version that wrote it, or compute the map again"
        )
    spec = _specification(header.get("spec"), archive.size("status"))
    arrays = {name: archive.read(name, dtype, spec.shape) for name, dtype in STORED.items()}
    bins = [
        archive.read(f"{_BINS}{number}", np.dtype(np.int64), (None, BIN))
        for number in range(len(spec.measure))
    ]

    def refuse(message: str) -> None:
        raise DamageError(message)

    check_counts(spec, arrays, refuse)
    done = np.sum([arrays[name] for name in CLASSES], axis=0).ravel()
    for number, rows in enumerate(bins):
        _check_bins(f"{_BINS}{number}", rows, done)
    return spec, arrays, bins


def _specification(data: Any, most: int) -> MapSpec:
    """The specification of a file whose arrays have at most so many pixels."""
    try:
        axes = [len(axis["values"]) for axis in data["axes"]]
        if len(axes) > MOST_AXES or math.prod(axes) > most:
            raise ValueError(f"axes: {len(axes)} of lengths {axes}, the arrays are smaller")
        return MapSpec.from_dict(data)
    except Exception as error:  # the text may hold anything
        raise FileError(f"holds a broken specification: {one_line(error)}") from None


def _check_bins(name: str, rows: Bins, done: NDArray[np.int64]) -> None:
    """Refuse a histogram that no computation can give for pixels with so many bodies."""
    pixel, key, count, least, largest, low, high, _, square_high, error = rows.T
    steps = np.diff(pixel), np.diff(key)
    magnitude = np.where(key < 0, -1 - key, key)
    finite = 0x7FF << 6
    sums = low.view(np.uint64).astype(np.float64) + np.ldexp(high.astype(np.float64), 64)
    slack = 1e-12 * sums
    rules = (
        ((pixel < 0) | (pixel >= len(done)), "is no pixel"),
        ((magnitude < 0) | (magnitude >= finite), "is no number"),
        (count < 1, "must count values"),
        ((least < 0) | (least > largest) | (largest >= 2**46), "offsets out of their bin"),
        ((high < 0) | (square_high < 0), "must not be negative"),
        ((error < -1) | (error >= 0x7FF << 52), "has an error that is no number"),
        ((sums + slack < count * least.astype(np.float64)), "sum below its least values"),
        ((sums - slack > count * largest.astype(np.float64)), "sum above its largest values"),
        (
            np.append((steps[0] < 0) | ((steps[0] == 0) & (steps[1] <= 0)), False)[: len(rows)],
            "must be sorted",
        ),
    )
    for bad, rule in rules:
        if bad.any():
            raise DamageError(f"{name}[{int(np.argmax(bad))}]: {rule}")
    values = np.zeros(len(done), dtype=np.int64)
    np.add.at(values, pixel, count)
    if (values > done).any():
        at = int(np.argmax(values > done))
        raise DamageError(f"{name}: more values than bodies in pixel {at}")
