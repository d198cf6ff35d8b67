"""Files and folders that are read: one wording where they are missing, unreadable or foreign."""

from __future__ import annotations

import os
import stat
import zipfile

from .arguments import nearest


def unreadable(path: str | os.PathLike[str], error: OSError) -> str:
    """Why a file cannot be read, with the name that was meant if the file is missing."""
    name = os.fspath(path)
    if not isinstance(error, FileNotFoundError):
        return f"{name}: cannot be read: {error.strerror}"
    folder, last = os.path.split(name)
    try:
        beside = os.listdir(folder or ".")
    except OSError:
        beside = []
    return f"{name}: there is no such file or folder{nearest(last, beside)}"


def described(path: str | os.PathLike[str]) -> str:
    """What is at a path, as words after "it is"; a file of rigid names the function for it."""
    if os.path.isdir(path):
        for name, what in _FOLDERS.items():
            if os.path.isfile(os.path.join(path, name)):
                return f"a folder of {what}"
        return "a folder"
    if not os.path.isfile(path):
        return "no regular file"
    with open(path, "rb") as file:
        begin = file.read(512)
        if not begin:
            return "empty"
        if begin.startswith(b"\x93NUMPY"):
            return "a single array of NumPy"
        if not begin.startswith(b"PK"):
            return "a text" if min(begin) > 8 else "no archive of arrays"
        try:
            with zipfile.ZipFile(file) as archive:
                names = archive.namelist()
        except Exception:  # a damaged archive may raise any exception
            return "cut or damaged"
    known = (what for name, what in _ARCHIVES.items() if name in names)
    return next(known, "an archive of other arrays")


_FOLDERS = {
    "head.json": "a running map, which rigid.open_store reads",
    "zarr.json": "Zarr, which xarray.open_zarr reads",
}
_ARCHIVES = {
    "spec.json.npy": "a map, which rigid.load_map reads",
    "header.npy": "a run, which rigid.load_run reads",
    "spec.npy": "a section or indicators of chaos, which numpy.load reads",
}


def require_readable(path: str | os.PathLike[str]) -> None:
    """Raise ValueError, saying why, if there is nothing at ``path`` that can be read."""
    try:
        if not stat.S_ISDIR(os.stat(path).st_mode):
            os.close(os.open(path, os.O_RDONLY))
    except OSError as error:
        raise ValueError(unreadable(path, error)) from None
