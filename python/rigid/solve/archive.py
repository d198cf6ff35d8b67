"""Runs as files: arrays and a JSON text in one archive, without pickles."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_line
from .._checks.inputs import described
from .._files import ARRAYS, published

__all__ = ["read_archive", "write_archive", "write_arrays"]

_FORMAT = "rigid run 1"


def write_archive(
    path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], header: Mapping[str, Any]
) -> Path:
    """Write arrays and JSON data into one file, which appears whole or not at all."""
    text = json.dumps({"format": _FORMAT, **header})
    return write_arrays(path, {"header": np.array(text), **arrays})


def write_arrays(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]]) -> Path:
    """Write arrays by their names into one file, which appears whole or not at all."""
    content = BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    with published(path, ARRAYS) as file:
        file.write(content.getbuffer())
    return Path(path)


def read_archive(
    path: str | os.PathLike[str],
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """The arrays and the JSON data of a file of :func:`write_archive`.

    Raises
    ------
    ValueError
        Naming the path, if the file is damaged or no run.
    OSError
        If the file cannot be read.
    """
    name = os.fspath(path)
    os.stat(name)
    what = described(name)
    if "load_run" not in what:
        raise ValueError(f"path = {name!r}: is no run that rigid has saved, it is {what}")
    try:
        with open(name, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
        header = json.loads(str(arrays.pop("header")))
        known = header.pop("format")
        if strange := [key for key, array in arrays.items() if array.dtype.kind not in "bfiu"]:
            raise ValueError(f"{strange[0]} has no numbers")
    except Exception as error:  # a damaged archive may raise any exception
        raise ValueError(f"path = {name!r}: is a damaged run ({one_line(error)})") from None
    if known != _FORMAT:
        raise ValueError(f"path = {name!r}: has the format {known!r}, known is {_FORMAT!r}")
    return arrays, header
