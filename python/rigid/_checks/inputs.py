"""Files and folders that a command reads: one wording where they are missing or unreadable."""

from __future__ import annotations

import os
import stat

from .arguments import nearest

__all__ = ["require_readable", "unreadable"]


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


def require_readable(path: str | os.PathLike[str]) -> None:
    """Raise ValueError, saying why, if there is nothing at ``path`` that can be read."""
    try:
        if not stat.S_ISDIR(os.stat(path).st_mode):
            os.close(os.open(path, os.O_RDONLY))
    except OSError as error:
        raise ValueError(unreadable(path, error)) from None
