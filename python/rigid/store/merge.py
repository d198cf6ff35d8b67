"""Many running maps of one specification into one folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence

import numpy as np

from .._files import published
from .running import Folder


def merge_into(sources: Sequence[str | os.PathLike[str]], into: str | os.PathLike[str]) -> Folder:
    """Copy the logs of running maps into one; all rows are compared before anything is written."""
    folders = [Folder(path) for path in sources]
    if not folders:
        raise ValueError("paths: must name at least one running map")
    first = folders[0]
    if Folder.is_at(into):
        folders.append(Folder(into))
    for folder in folders[1:]:
        folder.head.require_spec(first.head.spec, folder.path)
        rows, _, bins = folder.table.block(np.flatnonzero(folder.table.known))
        first.table.add(rows, None, bins, folder.path)
    target = Folder.at(into, first.head.spec)
    for folder in folders:
        for log in folder.logs:
            source, copy = folder.path / "logs" / log.name, target.path / "logs" / log.name
            if not (copy.exists() and copy.stat().st_size >= source.stat().st_size):
                with source.open("rb") as file, published(copy) as whole:
                    shutil.copyfileobj(file, whole)
    target.read()
    return target
