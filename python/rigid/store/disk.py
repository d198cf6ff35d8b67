"""What a running map does with files and may fail, in one place: a test can let it fail."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from .._files import published, synchronise

Buffer: TypeAlias = bytes | memoryview


class Disk:
    """The operations; a subclass may fail."""

    def make_folder(self, path: Path) -> None:
        """Make a folder, if there is none, and its parents."""
        path.mkdir(parents=True, exist_ok=True)

    def publish(self, path: Path, content: bytes) -> None:
        """Write a file that appears whole or not at all."""
        with published(path) as file:
            file.write(content)

    def create(self, path: Path) -> int:
        """Descriptor of a new file; one that exists is refused."""
        binary = getattr(os, "O_BINARY", 0)
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | binary, 0o644)

    def write(self, descriptor: int, buffers: Sequence[Buffer]) -> int:
        """Append the begin of these bytes, or all; returns how many."""
        if hasattr(os, "writev"):
            return os.writev(descriptor, buffers)
        return os.write(descriptor, b"".join(buffers))

    def cut(self, descriptor: int, size: int) -> None:
        """Shorten a file."""
        os.ftruncate(descriptor, size)
        os.lseek(descriptor, size, os.SEEK_SET)

    def synchronise(self, descriptor: int) -> None:
        """Write a file through to the disk."""
        if hasattr(os, "fdatasync"):
            os.fdatasync(descriptor)
        else:
            _full_synchronise(descriptor)

    def synchronise_folder(self, path: Path) -> None:
        """Write the names in a folder through to the disk, where the system can."""
        synchronise(path)

    def names(self, path: Path) -> list[str]:
        """The names in a folder, sorted; none if there is no folder."""
        try:
            return sorted(os.listdir(path))
        except FileNotFoundError:
            return []

    def read(self, path: Path) -> bytes:
        """The content of a small file."""
        return path.read_bytes()


def _full_synchronise(descriptor: int) -> None:
    try:
        import fcntl

        # On macOS fsync leaves the data in the memory of the drive.
        fcntl.fcntl(descriptor, fcntl.F_FULLFSYNC)  # type: ignore[attr-defined]
    except (ImportError, AttributeError, OSError):
        os.fsync(descriptor)


DISK = Disk()
