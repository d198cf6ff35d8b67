"""Results as files: arrays in one archive, written by all results and read without trust.

The file is an ``.npz`` archive. Nothing is pickled, nothing is compressed, and dates are fixed:
equal arrays are equal bytes. The comment of the archive is a digest of all bytes before it: damage
of any bit is found. A reader knows the size of an array before it reads it.
"""

from __future__ import annotations

import hashlib
import math
import os
import zipfile
from collections.abc import Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ._files import ARRAYS, published

_EPOCH = (1980, 1, 1, 0, 0, 0)

_SEAL = b"sha256 "
"""How the digest at the end of a file begins; its hexadecimal digits follow. Archives that other
programs write have none."""

_SEAL_SIZE = len(_SEAL) + 64


class FileError(Exception):
    """Why a file is refused, in words that follow its name."""


class ForeignError(FileError):
    """Why a file is none that this module wrote."""


class DamageError(FileError):
    """What is damaged in a file."""


def write_archive(path: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    """Write arrays by their names into one file, which appears whole or not at all."""
    with published(path, ARRAYS) as whole:
        with zipfile.ZipFile(whole, "w", zipfile.ZIP_STORED) as archive:
            for name, values in arrays.items():
                entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
                entry.create_system = 3  # Unix on all systems, so that the bytes are equal
                with archive.open(entry, "w", force_zip64=True) as file:
                    array = np.asarray(values)
                    little = np.asarray(array, dtype=array.dtype.newbyteorder("<"), order="C")
                    np.lib.format.write_array(file, little, version=(1, 0), allow_pickle=False)
        _write_seal(whole)


class Archive:
    """The arrays of a file by their names.

    Raises
    ------
    DamageError
        If the digest of the file is wrong.
    ForeignError
        If an entry is compressed, or the directory of the archive is longer than ``directory``.
    """

    def __init__(self, file: BinaryIO, directory: float = math.inf) -> None:
        self.length = _archive_length(file)
        if _directory_size(file, self.length) > directory:
            raise ForeignError(f"its directory is larger than {directory} B")
        self._entries = zipfile.ZipFile(file)
        for entry in self._entries.infolist():
            if entry.compress_type != zipfile.ZIP_STORED or entry.file_size > self.length:
                raise ForeignError(f"{entry.filename} is compressed")

    @property
    def names(self) -> list[str]:
        """The names of all arrays."""
        return [name.removesuffix(".npy") for name in self._entries.namelist()]

    def size(self, name: str) -> int:
        """Bytes of an array with its header."""
        return self._entries.getinfo(f"{name}.npy").file_size

    def read(
        self,
        name: str,
        dtype: np.dtype[Any] | None = None,
        shape: tuple[int | None, ...] | None = None,
    ) -> NDArray[Any]:
        """An array, read after its type, its shape and its size have been compared.

        Of None any will do, as a type, as a shape and as a length.
        """
        with self._entries.open(f"{name}.npy") as file:
            if np.lib.format.read_magic(file) != (1, 0):
                raise DamageError(f"{name} is not of version 1.0 of the npy format")
            found, fortran, kind = np.lib.format.read_array_header_1_0(file)
            native = kind.newbyteorder("=")
            if dtype is not None and native != dtype:
                raise DamageError(f"{name} has type {kind}, expected {dtype}")
            if shape is not None and (
                len(found) != len(shape)
                or any(length not in (None, own) for length, own in zip(shape, found, strict=True))
            ):
                raise DamageError(f"{name} has shape {found}, expected {shape}")
            if self.size(name) - file.tell() != kind.itemsize * math.prod(found):
                raise DamageError(f"{name} has not the size of its shape {found}")
            content = np.frombuffer(file.read(), dtype=kind)
        return content.reshape(found, order="F" if fortran else "C").astype(native)


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
    digest = hashlib.sha256()
    file.seek(0)
    for begin in range(0, length, 2**20):
        digest.update(file.read(min(2**20, length - begin)))
    return _SEAL + digest.hexdigest().encode()


def _archive_length(file: BinaryIO) -> int:
    """Bytes of a file before its digest, which must be right; files without one are all archive."""
    length = file.seek(0, os.SEEK_END)
    archive = max(0, length - _SEAL_SIZE)
    file.seek(archive)
    found = file.read()
    if not found.startswith(_SEAL):
        return length
    if found != _seal(file, archive):
        raise DamageError("digest and content differ")
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
