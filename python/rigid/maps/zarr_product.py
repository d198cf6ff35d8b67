"""A stability map as a Zarr store of version 3, which ``xarray.open_zarr`` reads."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from .._checks.extras import install_extra
from .data import MapData
from .dataset import map_dataset

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["write_zarr", "write_zarr_url"]


def write_zarr(data: MapData, path: str | os.PathLike[str]) -> Path:
    """Write a map as a folder that appears whole or not at all; see :func:`write_zarr_url`."""
    import shutil
    from pathlib import Path

    target = Path(path)
    if os.path.lexists(target):
        raise FileExistsError(f"path = {os.fspath(target)!r}: must be new")
    scratch = target.with_name(f".rigid-{os.urandom(16).hex()}.part")
    try:
        write_zarr_url(data, os.fspath(scratch))
        for folder, _, names in os.walk(scratch, topdown=False):
            for name in names:
                _synchronise(os.path.join(folder, name))
            _synchronise(folder)
        scratch.rename(target)
        _synchronise(target.absolute().parent)
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


def _synchronise(path: str | os.PathLike[str]) -> None:
    if os.name != "posix":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
