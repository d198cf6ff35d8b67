"""Files that are written whole or not at all: every writer of rigid uses :func:`published`."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # on Windows nothing tells whether a writer lives
    fcntl = None  # type: ignore[assignment]


SCRATCH = ".rigid-"
"""How the names of scratch files begin."""

_SCRATCH_NAME = re.compile(r"\.rigid-[0-9a-f]{32}\.part")

_KINDS = {
    stat.S_IFLNK: "a symbolic link",
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def require_replaceable(path: str | os.PathLike[str]) -> int | None:
    """Mode of the regular file at ``path``, None if there is no file.

    Raises
    ------
    FileExistsError
        If something else has this name.
    """
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "no file")
        raise FileExistsError(
            f"path = {os.fspath(path)!r}: must be new or a regular file, it is {kind}"
        )
    return stat.S_IMODE(mode)


ARRAYS, MAP, TABLE = (".npz",), (".npz", ".zarr"), (".csv", ".txt")
"""Endings of the names of files of arrays, of maps, and of comma-separated texts."""

_OTHERS: Mapping[str, str] = {
    ".csv": "; to_csv of a run, a map or points writes a table",
    ".nc": "; to_xarray().to_netcdf of a run, a map or points writes netCDF",
}
"""What writes other files than archives of arrays, whose names end like this."""


def require_ending(
    path: str | os.PathLike[str], endings: Sequence[str], name: str = "path"
) -> None:
    """Raise ValueError if a name promises another kind of file than the one that is written."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in endings:
        other = _OTHERS.get(ending, "") if ".npz" in endings else ""
        raise ValueError(f"{name} = {os.fspath(path)!r}: must end in {' or '.join(endings)}{other}")


@contextmanager
def published(path: str | os.PathLike[str], endings: Sequence[str] = ()) -> Iterator[BinaryIO]:
    """A new file, open to write bytes; it gets its name when it is whole and on the disk.

    The bytes go to a scratch file with another name in the same folder. At the end the scratch file
    is synchronised and renamed. After any failure the scratch file is removed, and an older file at
    ``path`` is as it was. A new file obeys the umask; an older one hands on its mode. A process
    that is killed leaves its scratch file; the next writer in the folder removes it.

    Parameters
    ----------
    path : path-like
        The file: a new name, or the name of a regular file.
    endings : sequence of str
        With which of these the name must end; by default any.

    Raises
    ------
    ValueError
        If the name ends otherwise.
    FileExistsError
        If something else has this name: a directory, a symbolic link, a pipe or a device.
    OSError
        Naming ``path``, if the file cannot be written.
    """
    if endings:
        require_ending(path, endings)
    target = os.fspath(path)
    with _naming(target), _scratch(target) as (scratch, file):
        yield file
        file.flush()
        os.fsync(file.fileno())
        file.close()
        os.replace(scratch, target)
        synchronise(_folder(target))


def require_room(path: str | os.PathLike[str], size: int) -> None:
    """Raise what :func:`published` would raise for a file of ``size`` bytes, as far as it shows.

    The folder must be writable, and the disk must have room; the room is not kept.

    Raises
    ------
    OSError
        As of :func:`published`.
    """
    target = os.fspath(path)
    with _naming(target), _scratch(target) as (_, file):
        if hasattr(os, "posix_fallocate"):
            with _where_possible():
                os.posix_fallocate(file.fileno(), 0, size)


@contextmanager
def _scratch(target: str) -> Iterator[tuple[str, BinaryIO]]:
    """A new file beside ``target`` with the mode of the file there; it is removed at the end."""
    mode = require_replaceable(target)
    with suppress(OSError):
        _sweep(_folder(target))
    scratch, file, lock = _locked_file(target, 0o666 if mode is None else 0o600)
    try:
        with file:
            if mode is not None:
                os.chmod(file.fileno() if os.chmod in os.supports_fd else scratch, mode)
            yield scratch, file
    finally:
        # The lock outlives the file, which is closed before it is renamed.
        os.close(lock)
        with suppress(OSError):
            os.unlink(scratch)


def _locked_file(target: str, mode: int) -> tuple[str, BinaryIO, int]:
    """Name of a new file beside ``target``, the file, and a descriptor that holds its lock.

    The system takes the lock from a process that dies: see :func:`_sweep`.
    """
    while True:
        scratch = os.path.join(os.path.dirname(target), f"{SCRATCH}{os.urandom(16).hex()}.part")
        # The flags of mode "x" follow no link. A private file is private from the start.
        file = open(scratch, "x+b", opener=lambda path, flags: os.open(path, flags, mode))  # noqa: SIM115
        lock = os.dup(file.fileno())
        if fcntl is not None:
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_EX)
        if os.fstat(lock).st_nlink:
            return scratch, file, lock
        # Another writer took it for one without a writer, before it was locked.
        file.close()
        os.close(lock)


def _sweep(folder: str) -> None:
    """Remove the scratch files whose writers have died: nobody holds their locks."""
    if fcntl is None:
        return
    with os.scandir(folder) as entries:
        left = [entry.path for entry in entries if _SCRATCH_NAME.fullmatch(entry.name)]
    for path in left:
        with suppress(OSError):
            descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                if stat.S_ISREG(os.fstat(descriptor).st_mode):
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(path)
            finally:
                os.close(descriptor)


def _folder(target: str) -> str:
    return os.path.dirname(target) or os.curdir


def synchronise(path: str | os.PathLike[str]) -> None:
    """Write a file, or the names in a folder, to the disk, where the system can."""
    if os.name != "posix":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        with _where_possible():
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _where_possible() -> Iterator[None]:
    """Go on where the file system does not know the call."""
    try:
        yield
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP):
            raise


@contextmanager
def _naming(target: str) -> Iterator[None]:
    """Errors of the system name the file that is written, not its scratch file."""
    try:
        yield
    except OSError as error:
        of_scratch = os.path.basename(error.filename or "").startswith(SCRATCH)
        if error.errno is None or not (error.filename is None or of_scratch):
            raise
        raise OSError(error.errno, error.strerror, target) from None
