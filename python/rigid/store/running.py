"""The rows of a running map, in a folder with the log of this process, or in memory."""

from __future__ import annotations

import os
import platform
import socket
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..maps.spec import MapSpec
from ..model.scene import Scene
from .disk import DISK, Disk
from .head import Head, StoreError, canonical, divided_in_memory, moment_status
from .log import LOG_NAME, Found, Log, gone, read_log, utc
from .rows import Block, Table


def receipt(**facts: Any) -> dict[str, Any]:
    """The identity of a writer: build, machine and process."""
    build = _core.build_info()
    return {
        "version": build["version"],
        "commit": build.get("commit"),
        "isa": build.get("isa"),
        "profile": build.get("profile"),
        "host": socket.gethostname(),
        "pid": os.getpid(),
        "system": platform.platform(),
        "python": sys.version.split()[0],
        "numpy": np.__version__,
        "begin": utc(),
        **facts,
    }


def claims_result(path: str | os.PathLike[str]) -> bool:
    """Whether this process is the first to ask: of parts that end together one writes the map."""
    try:
        Path(path, "claimed").touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


class Memory:
    """A running map in memory alone.

    Attributes
    ----------
    head : Head
    table : Table
        The known rows.
    computed : int
        Bodies that this process computed in its last sitting.
    """

    def __init__(self, spec: MapSpec, segment: int | None = None) -> None:
        self.computed = 0
        self.head = Head(spec, divided_in_memory(spec) if segment is None else segment)
        self.table = Table(self.head)

    @cached_property
    def status(self) -> NDArray[np.uint8]:
        """The status of the moments of each pixel in C order."""
        return moment_status(self.head.spec)

    def read(self) -> None:
        """Do nothing: no other process computes rows."""

    def begin(self, **facts: Any) -> None:
        """Do nothing: there is no log."""

    def append(self, block: Block) -> None:
        """Keep rows."""
        self.table.add(block, "this process")

    def end(self, reason: str) -> None:
        """Do nothing: there is no log."""

    def writers(self) -> list[dict[str, Any]]:
        """No writers: there is no log."""
        return []


class Folder(Memory):
    """A folder of a running map, whose rows are in memory too.

    Attributes
    ----------
    path : Path
    head : Head
    table : Table
        The rows of all logs, as last read.
    logs : list of Found
        What else they hold.
    """

    def __init__(self, path: str | os.PathLike[str], disk: Disk = DISK) -> None:
        self.path, self._disk = Path(path), disk
        self._log: Log | None = None
        self.computed = 0
        self.head = self._read_head()
        self.read()

    @classmethod
    def at(
        cls,
        path: str | os.PathLike[str],
        spec: MapSpec,
        disk: Disk = DISK,
        segment: int | None = None,
    ) -> Folder:
        """The folder of that map; a new one if there is none, with so many samples in a unit.

        The title and the unit of times are those asked for, whatever the folder has.

        Raises
        ------
        StoreError
            If the folder holds another map, or other files.
        """
        folder = Path(path)
        if not cls.is_at(folder):
            cls.require_empty(folder, disk)
            disk.make_folder(folder / "logs")
            head = Head.of(spec) if segment is None else Head(spec, segment)
            disk.publish(folder / "head.json", canonical(head.content))
            disk.synchronise_folder(folder.absolute().parent)
        found = cls(folder, disk)
        found.head.require_spec(spec, folder)
        found.give(**spec.functions)
        words = {name: getattr(spec, name) for name in ("title", "time_unit")}
        if any(getattr(found.head.spec, name) != word for name, word in words.items()):
            found.head = replace(found.head, spec=replace(found.head.spec, **words))
        return found

    @classmethod
    def seeded(cls, spec: MapSpec, path: str | os.PathLike[str]) -> MapSpec:
        """The specification with the seed of the first call, if there is one: its own was drawn."""
        return replace(spec, seed=cls(path).head.spec.seed) if cls.is_at(path) else spec

    @staticmethod
    def require_empty(path: str | os.PathLike[str], disk: Disk = DISK) -> None:
        """Refuse a folder with other files for a new running map."""
        # A process may have ended before it wrote the head.
        if [name for name in disk.names(Path(path)) if name != "logs" and name[:1] != "."]:
            raise StoreError(f"{path} is no running map, and is not empty")

    def give(
        self,
        *,
        scene: Callable[..., Any] | Scene | None = None,
        stable: Callable[..., Any] | None = None,
    ) -> None:
        """Take the functions of the map, of which a folder has only digests."""
        spec = self.head.spec.with_functions(scene=scene, stable=stable)
        self.head = replace(self.head, spec=spec)

    @staticmethod
    def is_at(path: str | os.PathLike[str]) -> bool:
        """Whether a folder holds a running map."""
        return Path(path, "head.json").is_file()

    def _read_head(self) -> Head:
        try:
            return Head.read(self._disk.read(self.path / "head.json"), self.path)
        except (FileNotFoundError, NotADirectoryError):
            raise StoreError(f"{self.path} is no running map: there is no head.json") from None

    def read(self) -> None:
        """Read the rows of all logs.

        Raises
        ------
        StoreError
            If two logs have other results for a unit.
        """
        if self._read_head().seal != self.head.seal:
            raise StoreError(f"{self.path}: head.json was replaced and belongs to another map")
        self.table, self.logs = Table(self.head), []
        folder = self.path / "logs"
        for name in self._disk.names(folder):
            if not LOG_NAME.fullmatch(name) or not (folder / name).is_file():
                continue
            found = Found(name, written=(folder / name).stat().st_mtime)
            with (folder / name).open("rb") as file:
                measured = bool(self.head.spec.measure)
                for block in read_log(file, self.head.seal, found, measured=measured):
                    self.table.add(block, folder / name)
            self.logs.append(found)

    @property
    def damage(self) -> list[str]:
        """What could not be read in the logs, and where."""
        return [f"{log.name}: {text}" for log in self.logs for text in log.damage]

    def writers(self) -> list[dict[str, Any]]:
        """The receipt of each log, with its units, its processor time, and why it ended."""
        return [
            {
                **(log.writer or {}),
                **(log.end or {}),
                "log": log.name,
                "units": log.units,
                "seconds": log.seconds,
            }
            for log in self.logs
        ]

    def begin(self, **facts: Any) -> None:
        """Open the log of this process, unless it is open."""
        if self._log is None:
            self._disk.make_folder(self.path / "logs")
            own = {"key": self.head.key.hex(), **receipt(**facts)}
            self._log = Log(self.path / "logs", self.head.seal, own, self._disk)

    def append(self, block: Block) -> None:
        """Append rows to the log of this process."""
        assert self._log is not None
        self._log.append(block, measured=bool(self.head.spec.measure))
        self.table.add(block, self._log.path)

    def end(self, reason: str) -> None:
        """Close the log of this process, if there is one."""
        log, self._log = self._log, None
        if log is not None:
            log.close(None if reason == "error" else reason)
            self.logs = [one for one in self.logs if one.name != log.path.name] + [log.found]
            if reason != "error":
                self._require_whole()

    def _require_whole(self) -> None:
        """Raise FileNotFoundError if a file whose rows are counted is not there any more."""
        if "head.json" not in self._disk.names(self.path):
            raise gone(self.path / "head.json")
        logs = self._disk.names(self.path / "logs")
        for log in self.logs:
            if log.name not in logs:
                raise gone(self.path / "logs" / log.name)
