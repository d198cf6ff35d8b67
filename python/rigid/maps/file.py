"""A stability map as one data-only file.

The file is an ``.npz`` archive of arrays with the specification as JSON inside. Nothing is pickled,
nothing is compressed, and dates are fixed: equal maps are equal bytes. The comment of the archive
is a digest of all bytes before it: damage of any bit is found. A reader knows the size of
everything from the size of the file and the specification before it reads: see ``_read``.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_line
from .._checks.inputs import described
from .._files import ARRAYS, published
from .counts import GROWTH, check_counts
from .data import CLASSES, STORED, MapData
from .measured import BIN
from .parameters import MOST_AXES, axis_letter
from .spec import MapSpec

if TYPE_CHECKING:
    import zipfile
    from pathlib import Path

__all__ = ["file_size", "read_map", "write_map"]

FORMAT = "rigid stability map"
FORMAT_VERSION = 6
MEASURED_VERSION = 7
"""The format of a map with measures; a map without measures is written in version 6."""
CAPTURED_VERSION = 8
"""The format of a map with a function, with digests of the values that the function uses."""
_AUDIT = frozenset({"audited", "audited_undecided"})
MISSING_IN: Mapping[int, frozenset[str]] = {
    3: _AUDIT | GROWTH | {"unit_drift"},
    4: _AUDIT | GROWTH,
    5: GROWTH,
    6: frozenset(),
    7: frozenset(),
    8: frozenset(),
}
"""The formats that can be read, and the arrays of :data:`STORED` that their files lack."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
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

_SEAL = b"sha256 "
"""How the digest at the end of a file begins; its hexadecimal digits follow. Archives that other
programs write have none."""

_SEAL_SIZE = len(_SEAL) + 64


def write_map(data: MapData, path: str | os.PathLike[str]) -> Path:
    """Write a map; see :meth:`rigid.StabilityMap.save`."""
    import zipfile  # here and below: takes longer to import than all of rigid
    from pathlib import Path

    target = Path(path)
    arrays: dict[str, NDArray[Any]] = {_SPEC: np.frombuffer(_header(data.spec), dtype=np.uint8)}
    for place, axis in enumerate(data.spec.axes):
        arrays[axis_letter(place)] = np.array(axis.values)
    for name in (*STORED, *_DERIVED):
        arrays[name] = getattr(data, name)
    for number, measured in enumerate(data.measures.values()):
        arrays[f"{_BINS}{number}"] = measured.bins
    with published(target, ARRAYS) as whole:
        with zipfile.ZipFile(whole, "w", zipfile.ZIP_STORED) as archive:
            for name, array in arrays.items():
                entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
                entry.create_system = 3  # Unix on all systems, so that the bytes are equal
                with archive.open(entry, "w", force_zip64=True) as file:
                    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
                    np.lib.format.write_array(file, little, version=(1, 0), allow_pickle=False)
        _write_seal(whole)
    return target


def _write_seal(file: BinaryIO) -> None:
    """Append the digest of an archive that has no comment, as its comment."""
    length = file.seek(0, os.SEEK_END)
    file.seek(length - 2)
    file.write(_SEAL_SIZE.to_bytes(2, "little"))
    seal = _seal(file, length)
    file.seek(length)
    file.write(seal)


def _seal(file: BinaryIO, length: int) -> bytes:
    """The digest of the first bytes of a file."""
    import hashlib  # here: takes longer to import than the rest of this module

    digest = hashlib.sha256()
    file.seek(0)
    while length > 0:
        block = file.read(min(length, 2**20))
        if not block:
            break
        digest.update(block)
        length -= len(block)
    return _SEAL + digest.hexdigest().encode()


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
    version = MEASURED_VERSION if spec.measure else FORMAT_VERSION
    if spec.tells_captured:
        version = CAPTURED_VERSION
    header = {"format": FORMAT, "format_version": version, "spec": spec.to_dict()}
    return json.dumps(header, indent=1, allow_nan=False).encode()


def read_map(path: str | os.PathLike[str]) -> tuple[MapSpec, dict[str, NDArray[Any]], list[Bins]]:
    """Specification, :data:`STORED` arrays and bins of measures; see :func:`rigid.load_map`.

    Arrays that the format of the file does not have are omitted.
    """
    from pathlib import Path

    source = Path(path)
    source.stat()
    if not source.is_file():
        raise ValueError(f"{source} is not a stability map: it is {described(source)}")
    with source.open("rb") as file:
        try:
            return _read(file)
        except _FileError as error:
            raise ValueError(f"{source} {one_line(error)}") from None
        except Exception as error:  # a damaged archive may raise any exception
            what = described(source)
            why = f"it is damaged: {one_line(error)}" if "load_map" in what else f"it is {what}"
            raise ValueError(f"{source} is not a stability map: {why}") from None


class _FileError(Exception):
    """The reason why a file is refused; the name of the file precedes the message."""


def _read(file: BinaryIO) -> tuple[MapSpec, dict[str, NDArray[Any]], list[Bins]]:
    """Read a map with no more memory than a small multiple of the size of its file."""
    import zipfile

    length = _archive_length(file)
    if _directory_size(file, length) > MOST_DIRECTORY:
        raise _FileError(f"is not a stability map: its directory is larger than {MOST_DIRECTORY} B")
    with zipfile.ZipFile(file) as archive:
        for entry in archive.infolist():
            if entry.compress_type != zipfile.ZIP_STORED or entry.file_size > length:
                raise _FileError(f"is not a stability map: {entry.filename} is compressed")
        if archive.getinfo(f"{_SPEC}.npy").file_size > MOST_TEXT + length // 4:
            raise _FileError("is not a stability map: its specification is longer than its arrays")
        header = json.loads(_read_array(archive, _SPEC, np.dtype(np.uint8)).tobytes().decode())
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise _FileError("is not a stability map: its header is another one")
        version: Any = header.get("format_version")
        if version not in MISSING_IN:
            known = " and ".join(map(str, MISSING_IN))
            raise _FileError(f"has format version {version}, this version of rigid reads {known}")
        spec = _specification(header.get("spec"), archive.getinfo("status.npy").file_size)
        arrays = {
            name: _read_array(archive, name, dtype, spec.shape)
            for name, dtype in STORED.items()
            if name not in MISSING_IN[version]
        }
        bins = [
            _read_array(archive, f"{_BINS}{number}", np.dtype(np.int64), (None, BIN))
            for number in range(len(spec.measure))
        ]
    if "audited" in MISSING_IN[version]:
        # Checks did not depend on outcomes then: all were audits.
        arrays["audited"] = arrays["checked"]
        arrays["audited_undecided"] = np.minimum(arrays["checked"], arrays["undecided"])
    for name in MISSING_IN[version] & GROWTH:
        # No deviation vector was integrated then.
        unknown = 0 if STORED[name] == np.int64 else np.nan
        arrays[name] = np.full(spec.shape, unknown, dtype=STORED[name])

    def refuse(message: str) -> None:
        raise _FileError(f"is damaged: {message}")

    check_counts(spec, arrays, refuse)
    done = np.sum([arrays[name] for name in CLASSES], axis=0).ravel()
    for number, rows in enumerate(bins):
        _check_bins(f"{_BINS}{number}", rows, done)
    return spec, arrays, bins


def _archive_length(file: BinaryIO) -> int:
    """Bytes of a file before its digest, which must be right; files without one are all archive."""
    length = file.seek(0, os.SEEK_END)
    archive = max(0, length - _SEAL_SIZE)
    file.seek(archive)
    found = file.read()
    if not found.startswith(_SEAL):
        return length
    if found != _seal(file, archive):
        raise _FileError("is damaged: digest and content differ")
    return archive


def _directory_size(file: BinaryIO, length: int) -> int:
    """Bytes of the directory of a ZIP archive, from its end records.

    The archive ends at ``length``, and has no comment but a digest.
    """
    comment = file.seek(0, os.SEEK_END) - length
    file.seek(max(0, length - 98))
    end = file.read(98)
    if end[-22:-18] != b"PK\5\6" or end[-2:] != comment.to_bytes(2, "little"):
        raise ValueError("File is not a zip file")
    if end[-42:-38] == b"PK\6\7":  # beyond 4 GB the numbers are in another record
        return int.from_bytes(end[-58:-50], "little")
    return int.from_bytes(end[-10:-6], "little")


def _specification(data: Any, most: int) -> MapSpec:
    """The specification of a file whose arrays have at most so many pixels."""
    try:
        axes = [len(axis["values"]) for axis in data["axes"]]
        if len(axes) > MOST_AXES or math.prod(axes) > most:
            raise ValueError(f"axes: {len(axes)} of lengths {axes}, the arrays are smaller")
        return MapSpec.from_dict(data)
    except Exception as error:  # the text may hold anything
        raise _FileError(f"holds a broken specification: {one_line(error)}") from None


def _read_array(
    archive: zipfile.ZipFile,
    name: str,
    dtype: np.dtype[Any],
    shape: tuple[int | None, ...] | None = None,
) -> NDArray[Any]:
    """An array, read after its type, its shape and its size have been compared.

    A length of None is any.
    """
    entry = archive.getinfo(f"{name}.npy")
    with archive.open(entry) as file:
        if np.lib.format.read_magic(file) != (1, 0):
            raise _FileError(f"is damaged: {name} is not of version 1.0 of the npy format")
        found, fortran, kind = np.lib.format.read_array_header_1_0(file)
        if kind.newbyteorder("=") != dtype:
            raise _FileError(f"is damaged: {name} has type {kind}, expected {dtype}")
        if shape is not None and (
            len(found) != len(shape)
            or any(length not in (None, own) for length, own in zip(shape, found, strict=True))
        ):
            raise _FileError(f"is damaged: {name} has shape {found}, expected {shape}")
        if entry.file_size - file.tell() != kind.itemsize * math.prod(found):
            raise _FileError(f"is damaged: {name} has not the size of its shape {found}")
        content = np.frombuffer(file.read(), dtype=kind)
    return content.reshape(found, order="F" if fortran else "C").astype(dtype)


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
            raise _FileError(f"is damaged: {name}[{int(np.argmax(bad))}]: {rule}")
    values = np.zeros(len(done), dtype=np.int64)
    np.add.at(values, pixel, count)
    if (values > done).any():
        at = int(np.argmax(values > done))
        raise _FileError(f"is damaged: {name}: more values than bodies in pixel {at}")
