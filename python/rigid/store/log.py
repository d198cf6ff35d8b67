"""Logs: POSIX tar files of tables of rows, one a writer, which only appends.

A record is a table in the npy format whose name holds its digest. The digest is keyed by the map,
so that a record of another map is never taken for one of this. If the map measures something, the
table of its bins follows; its digest includes the digest of the rows, which count for nothing
without it.

A reader accepts a header only if it is to the byte the one that a writer makes, and searches on
where one is damaged: the rows that are read are right, whatever happened to the rest of the file.
"""

from __future__ import annotations

import errno
import io
import json
import os
import re
import tarfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from .disk import Buffer, Disk
from .head import canonical
from .rows import BIN_ROW, NO_BINS, ROW, Block

BLOCK = 512
"""Bytes of a header, and what the length of content is rounded up to."""

SYNC_SECONDS = 0.5
"""Rows are on the disk after this time at most."""

MOST_MEMBER = 2**30
"""Most bytes of a member that is read."""

COST = np.dtype("<f4")
"""The type of a processor time."""

UTC = "%Y-%m-%dT%H:%M:%SZ"
"""How receipts write times."""

LOG_NAME = re.compile(r"\d{8}T\d{6}Z-[0-9a-f]{12}\.tar")
WRITER, END = "writer.json", "end.json"
_RECORD = re.compile(r"(\d{8})-([0-9a-f]{32})\.npy")
_BINS = re.compile(r"\d{8}-([0-9a-f]{32})\.bins\.npy")
_COSTS = re.compile(r"\d{8}\.ns\.npy")
_NAME = re.compile(rb"[0-9a-z.\-]{1,60}")
_SIZE = re.compile(rb"[0-7]{11}")


def _header(name: str, size: int) -> bytes:
    info = tarfile.TarInfo(name)
    info.size = size
    return info.tobuf(tarfile.USTAR_FORMAT)


def _padding(size: int) -> bytes:
    return bytes(-size % BLOCK)


def _npy_header(dtype: np.dtype[Any], count: int) -> bytes:
    out = io.BytesIO()
    fields = {
        "descr": np.lib.format.dtype_to_descr(dtype),
        "fortran_order": False,
        "shape": (count,),
    }
    np.lib.format.write_array_header_1_0(out, fields)
    return out.getvalue()


def _digest(key: bytes, *content: Buffer) -> str:
    digest = blake2b(digest_size=16, key=key)
    for part in content:
        digest.update(part)
    return digest.hexdigest()


def utc() -> str:
    """The time now, to the second."""
    return time.strftime(UTC, time.gmtime())


def gone(path: Path) -> FileNotFoundError:
    """The error of a file of a running map that somebody has removed or renamed."""
    words = "removed or renamed while the map was computed"
    return FileNotFoundError(errno.ENOENT, words, str(path))


@dataclass(slots=True)
class Found:
    """The content of a log besides its rows.

    Attributes
    ----------
    name : str
        The name of the file.
    writer, end : dict or None
        The receipt of the writer; why it ended.
    written : float
        When the log was last written, in seconds of :func:`time.time`.
    damage : list of str
        What could not be read, and where.
    records, units : int
        Records that were read, and their rows.
    seconds : float
        The processor time of the rows.
    """

    name: str = ""
    writer: dict[str, Any] | None = None
    end: dict[str, Any] | None = None
    written: float = np.nan
    damage: list[str] = field(default_factory=list)
    records: int = 0
    units: int = 0
    seconds: float = 0.0

    def count(self, block: Block) -> None:
        """Count a record."""
        self.records += 1
        self.units += len(block.rows)
        self.seconds += 1e-9 * float(np.nansum(block.nanoseconds, dtype=np.float64))


class Log:
    """The log of this process.

    Parameters
    ----------
    folder : Path
        The folder of logs.
    key : bytes
        The key of the map.
    receipt : dict
        Who writes.

    Attributes
    ----------
    path : Path
    found : Found
        What the log holds.
    """

    def __init__(self, folder: Path, key: bytes, receipt: dict[str, Any], disk: Disk) -> None:
        self._disk, self._key, self._size = disk, key, 0
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
        self.path = folder / f"{stamp}-{os.urandom(6).hex()}.tar"
        self.found = Found(self.path.name, receipt)
        self._file = disk.create(self.path)
        try:
            self._append(self._member(WRITER, canonical(receipt)))
            disk.synchronise(self._file)
            disk.synchronise_folder(folder)
        except BaseException:
            os.close(self._file)
            raise
        self._synchronised = time.monotonic()

    @staticmethod
    def _member(name: str, *content: Buffer) -> list[Buffer]:
        size = sum(len(part) for part in content)
        return [_header(name, size), *content, _padding(size)]

    def _append(self, buffers: list[Buffer]) -> None:
        """Append all bytes or none."""
        views = [memoryview(part) for part in buffers if len(part)]
        try:
            while views:
                written = self._disk.write(self._file, views)
                while views and written >= len(views[0]):
                    written -= len(views.pop(0))
                if written:
                    views[0] = views[0][written:]
        except BaseException:
            # A reader would skip the torn record; without it later ones are found at once.
            self._disk.cut(self._file, self._size)
            raise
        self._size += sum(len(part) for part in buffers)

    def append(self, block: Block, *, measured: bool = False) -> None:
        """Append a record; its bins if the map measures something."""
        rows, nanoseconds, bins = block
        table: list[Buffer] = [_npy_header(ROW, len(rows)), rows.view(np.uint8).data]
        costs: list[Buffer] = [_npy_header(COST, len(rows)), nanoseconds.view(np.uint8).data]
        digest, number = _digest(self._key, *table), f"{self.found.records:08d}"
        members = self._member(f"{number}-{digest}.npy", *table)
        if measured:
            little = np.ascontiguousarray(bins, "<i8").ravel()
            values: list[Buffer] = [_npy_header(BIN_ROW, len(bins)), little.view(np.uint8).data]
            name = _digest(self._key, digest.encode(), *values)
            members += self._member(f"{number}-{name}.bins.npy", *values)
        self._append([*members, *self._member(f"{number}.ns.npy", *costs)])
        self.found.count(block)
        if time.monotonic() - self._synchronised >= SYNC_SECONDS:
            self.synchronise()

    def synchronise(self) -> None:
        """Write all records through to the disk.

        Raises
        ------
        FileNotFoundError
            If the log has been removed: the records are nowhere.
        """
        self._disk.synchronise(self._file)
        try:
            is_here = os.path.samestat(os.fstat(self._file), os.stat(self.path))
        except FileNotFoundError:
            is_here = False
        if not is_here:
            raise gone(self.path)
        self._synchronised = time.monotonic()

    def close(self, reason: str | None) -> None:
        """End the log with a reason; without a reason if it could not be written."""
        found = self.found
        found.written = time.time()
        try:
            if reason is not None:
                found.end = {"blocks": found.records, "units": found.units}
                found.end |= {"reason": reason, "end": utc()}
                self._append([*self._member(END, canonical(found.end)), bytes(2 * BLOCK)])
                self.synchronise()
        finally:
            os.close(self._file)


def read_log(
    file: BinaryIO, key: bytes, found: Found, *, measured: bool = False
) -> Iterator[Block]:
    """The whole records of a log, whatever happened to the rest."""
    length = file.seek(0, os.SEEK_END)
    at, number, searching = 0, 0, False

    def note(what: str) -> None:
        nonlocal searching
        if not searching:
            found.damage.append(f"{what} at byte {at}")
        searching = True

    def member(at: int) -> tuple[str, bytes | None, int]:
        """Name, content and end of a member; no name for other bytes, no content if it is torn."""
        file.seek(at)
        block = file.read(BLOCK)
        name, size = _name_and_size(block)
        if not name:
            return "", block, at + BLOCK
        whole = at + BLOCK + size <= length and size <= MOST_MEMBER
        end = at + BLOCK + size + len(_padding(size))
        return name, file.read(size) if whole else None, end

    while at < length:
        name, content, end = member(at)
        record = _RECORD.fullmatch(name)
        if content is None or (record and _digest(key, content) != record[2]):
            kind = "torn" if content is None else "damaged"
            note(f"a {kind} {'record' if record else name}")
            at += BLOCK
            continue
        if not name:
            if any(content) or found.end is None:  # zeros end a log, and follow nothing else
                note("no header")
            at = end
            continue
        searching = False
        if record:
            if int(record[1]) > number:
                note(f"no record {number}")
            number = int(record[1]) + 1
            rows, bins, costs = _vector(content, ROW), None, None
            name, content, after = member(end)
            digest = _BINS.fullmatch(name)
            if digest and measured and content is not None:
                if digest[1] == _digest(key, record[2].encode(), content):
                    bins = _vector(content, BIN_ROW)
                end = after
                name, content, after = member(end)
            if rows is None:
                note("a record of another kind of rows")
            elif measured and bins is None:
                note("a record without its values")
            else:
                if content is not None and _COSTS.fullmatch(name):
                    costs = _vector(content, COST, len(rows))
                    end = after
                if costs is None:
                    costs = np.full(len(rows), np.nan, COST)
                values = NO_BINS
                if bins is not None:
                    values = bins.view("<i8").reshape(-1, NO_BINS.shape[1])
                block = Block(rows, costs, values)
                found.count(block)
                yield block
        elif name == WRITER:
            found.writer = _json(content)
        elif name == END:
            found.end = _json(content)
        elif not _COSTS.fullmatch(name):
            note(f"an unknown member {name}")
        searching, at = False, end


def _name_and_size(block: bytes) -> tuple[str, int]:
    """Name and size of the member that begins with these bytes; no name if they are no header."""
    name, size = block[:100].rstrip(b"\0"), block[124:135]
    if not (_NAME.fullmatch(name) and _SIZE.fullmatch(size)):
        return "", 0
    same = _header(name.decode(), int(size, 8)) == block
    return (name.decode(), int(size, 8)) if same else ("", 0)


def _vector(content: bytes, dtype: np.dtype[Any], count: int | None = None) -> NDArray[Any] | None:
    """The array in the bytes of an npy file as a log has it, None if it is another one.

    Its header is compared, not interpreted: costs have no digest, and may be anything.
    """
    begin = 10 + int.from_bytes(content[8:10], "little")
    found = (len(content) - begin) // dtype.itemsize
    if found < 0 or (count is not None and found != count):
        return None
    if (
        content[:begin] != _npy_header(dtype, found)
        or len(content) != begin + found * dtype.itemsize
    ):
        return None
    return np.frombuffer(content, dtype, offset=begin)


def _json(content: bytes) -> dict[str, Any] | None:
    try:
        value = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None
