"""What is read from a damaged log is right, and loss is told. Long: tests/long/damaged_logs.py."""

import io
import json
import os
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from map_texts import map_text
from processes import Capture
from rigid.cli import main
from rigid.store import drive as driving
from rigid.store import log as logging
from rigid.store.log import Found, read_log
from rigid.store.rows import ROW, Table
from rigid.store.running import Folder
from small_maps import small_map
from stores import SPEC, FailingDisk, Gone, go_on, numbers

RECORDS = 12
MEASURED = small_map(
    measure=(rigid.time_to_leave(), rigid.flips(1), rigid.mean_rate(-2), rigid.drift())
).spec


@pytest.fixture(scope="module", params=[SPEC, MEASURED], ids=["rows", "rows and bins"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Folder:
    """A complete map in one log of many records."""
    quiet = tmp_path_factory.mktemp("quiet") / "run"
    go_on(quiet, spec=request.param)
    table = Folder(quiet).table
    folder = Folder.at(tmp_path_factory.mktemp("map") / "run", request.param)
    folder.begin()
    for units in np.array_split(np.flatnonzero(table.known), RECORDS):
        folder.append(table.block(units))
    folder.end("complete")
    return Folder(folder.path)


@pytest.fixture(scope="module")
def log(run: Folder) -> bytes:
    (name,) = (run.path / "logs").iterdir()
    return name.read_bytes()


def read(content: bytes, run: Folder) -> tuple[Table, Found]:
    """What is in the bytes of a log; each row must be one of the map, with its bins."""
    found, table = Found(), Table(run.head)
    measured = bool(run.head.spec.measure)
    for block in read_log(io.BytesIO(content), run.head.seal, found, measured=measured):
        table.add(block, "log")
    known = np.flatnonzero(table.known)
    for one, other in zip(table.block(known)[::2], run.table.block(known)[::2], strict=True):
        assert one.tobytes() == other.tobytes()
    return table, found


def whole(run: Folder) -> int:
    return int(run.table.known.sum())


def test_a_log_is_a_tar_file_of_numpy_tables(log: bytes, run: Folder) -> None:
    units: dict[str, list[Any]] = {"": [], ".bins": []}
    with tarfile.open(fileobj=io.BytesIO(log)) as archive:
        names = archive.getnames()
        last = archive.getmembers()[-1]
        for name in names:
            if name.endswith(".npy") and ".ns." not in name:
                member: Any = archive.extractfile(name)
                rows = np.load(io.BytesIO(member.read()), allow_pickle=False)
                units[".bins" * name.endswith(".bins.npy")].append(np.unique(rows["unit"]))
    assert (names[0], names[-1]) == ("writer.json", "end.json")
    # POSIX: the last member is filled up to 512 bytes, and two such blocks of zeros follow.
    assert len(log) == last.offset_data + -(-last.size // 512) * 512 + 2 * 512
    head = json.loads((run.path / "head.json").read_text())
    assert head["format_version"] == 1
    for kind, tables in units.items():
        if kind == "" or run.head.spec.measure:
            assert len(tables) == RECORDS
            assert np.concatenate(tables).tolist() == np.flatnonzero(run.table.known).tolist()


def test_truncated_logs_have_their_whole_records(log: bytes, run: Folder) -> None:
    known, torn = [], 0
    for length in [*range(0, len(log), 197), len(log)]:
        table, found = read(log[:length], run)
        known.append(int(table.known.sum()))
        # A log without an end is one of a process that runs or was killed.
        assert found.end is None or known[-1] == whole(run)
        torn += bool(found.damage)
    assert known == sorted(known)
    assert torn > 0.5 * len(known)
    assert known[-1] == whole(run)


def test_flipped_bits_lose_rows_and_never_change_them(log: bytes, run: Folder) -> None:
    random, lost = np.random.default_rng(1), 0
    for place in random.integers(0, len(log), 300):
        content = bytearray(log)
        content[place] ^= 1 << int(random.integers(0, 8))
        table, found = read(bytes(content), run)
        if table.known.sum() < whole(run):
            lost += 1
            assert found.damage
    assert lost > 100


@pytest.mark.parametrize("kind", ["zeros", "garbage", "cut out", "twice"])
def test_damaged_pages_lose_rows_and_never_change_them(log: bytes, run: Folder, kind: str) -> None:
    random = np.random.default_rng(2)
    for _ in range(80):
        begin = int(random.integers(0, len(log)))
        length = int(random.integers(1, 4097))
        length = min(length, len(log) - begin)
        page = {
            "zeros": bytes(length),
            "garbage": random.bytes(length),
            "cut out": b"",
            "twice": log[begin : begin + length] * 2,
        }[kind]
        table, found = read(log[:begin] + page + log[begin + length :], run)
        assert found.damage or table.known.sum() == whole(run)


def test_bins_of_another_record_are_not_taken(log: bytes, run: Folder) -> None:
    """The tables of bins of two records, exchanged: each one is whole, but not of its rows."""
    if not run.head.spec.measure:
        return
    with tarfile.open(fileobj=io.BytesIO(log)) as archive:
        members = archive.getmembers()
    ends = [member.offset_data + -(-member.size // 512) * 512 for member in members]
    pieces = [log[member.offset : end] for member, end in zip(members, ends, strict=True)]
    bins = [k for k, member in enumerate(members) if member.name.endswith(".bins.npy")]
    pieces[bins[1]], pieces[bins[4]] = pieces[bins[4]], pieces[bins[1]]
    table, found = read(b"".join(pieces), run)
    lost = 2 * -(-whole(run) // RECORDS)
    assert 0 < whole(run) - int(table.known.sum()) <= lost
    assert "a record without its values" in found.damage[0]


def test_a_damaged_log_is_left_alone_and_its_rows_are_computed_again(
    log: bytes, run: Folder, tmp_path: Path
) -> None:
    path = tmp_path / "run"
    (path / "logs").mkdir(parents=True)
    (path / "head.json").write_bytes((run.path / "head.json").read_bytes())
    damaged = path / "logs" / "20260101T000000Z-000000000000.tar"
    content = bytearray(log)
    content[len(log) // 2] ^= 1
    content[len(log) // 3] ^= 1
    damaged.write_bytes(content)
    assert len(Folder(path).logs[0].damage) >= 1
    go_on(path, spec=run.head.spec)
    assert numbers(path) == run.table.rows.tobytes()
    assert damaged.read_bytes() == content


def test_records_of_another_map_are_not_accepted(log: bytes, run: Folder) -> None:
    found = Found()
    assert not list(read_log(io.BytesIO(log), bytes(16), found))
    assert found.damage


def test_rows_of_another_kind_are_not_accepted(
    log: bytes, run: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging, "ROW", ROW[["unit"]])
    table, found = read(log, run)
    assert not table.known.any()
    assert len(found.damage) == RECORDS
    assert all(said.startswith("a record of another kind of rows at byte") for said in found.damage)


def test_a_member_that_claims_a_terabyte_takes_no_memory(run: Folder) -> None:
    info = tarfile.TarInfo("00000000-" + 32 * "0" + ".npy")
    info.size = 8**11 - 1
    table, found = read(info.tobuf(tarfile.USTAR_FORMAT) + bytes(512), run)
    assert not table.known.any()
    assert found.damage == ["a torn record at byte 0"]


def test_strange_files_among_the_logs_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "run"
    go_on(path)
    before = numbers(path)
    (path / "logs" / "notes.txt").write_text("mine")
    (path / "logs" / "20260101T000000Z-000000000000.tar").mkdir()
    outside = tmp_path / "outside"
    outside.write_bytes(b"x" * 4096)
    assert numbers(path) == before


# A disk that is really full: a file system of 600 kB, which is enlarged later.


SMALL, LARGE = "600k", "20M"

#: 6400 units of about 160 bytes: they need 1 MB.
MAP = map_text(
    scene="kind = 'free-body'\nmoments = [1, 1.5, 2]",
    x="name = 'I2/I1'\nfrom = 1.01\nto = 1.99\ncount = 80",
    y="name = 'noise'\nfrom = 0.001\nto = 0.1\ncount = 80\nscale = 'log'",
    start="spin = 1\naxis = 2\nnoise = { kind = 'uniform' }",
    stable="criterion = 'no_flip'",
    run="samples = 4\nt_end = 50\nseed = 7",
)


def command(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """The folder of a file system of 600 kB."""
    if not sys.platform.startswith("linux"):
        pytest.skip("only Linux mounts a tmpfs")
    place = tmp_path / "disk"
    place.mkdir()
    mounted = command("mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(place))
    if mounted.returncode:
        pytest.skip(f"a file system of {SMALL} cannot be mounted: {mounted.stderr.strip()}")
    try:
        yield place
    finally:
        command("umount", str(place)).check_returncode()


def test_a_system_without_some_calls_stores_the_same_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    go_on(tmp_path / "quiet")
    for name in ("writev", "fdatasync"):
        monkeypatch.delattr(os, name)
    go_on(tmp_path / "run")
    assert numbers(tmp_path / "run") == numbers(tmp_path / "quiet")


def test_a_map_on_a_full_disk_goes_on_when_there_is_room(
    disk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def rigid_command(*arguments: str) -> int:
        return main([*arguments, "--no-progress"])

    monkeypatch.chdir(tmp_path)
    Path("map.toml").write_text(MAP)
    assert rigid_command("map", "map.toml", "--store", "disk/run", "--out", "a") == 74
    told = capsys.readouterr().err
    assert "[Errno 28]" in told
    assert "pixels are stored; rigid resume disk/run goes on" in told
    stored = Folder(disk / "run").table
    assert 0 < stored.known.sum() < 6400
    assert rigid_command("resume", "disk/run", "--out", "b") == 74

    command("mount", "-o", f"remount,size={LARGE}", str(disk)).check_returncode()
    assert rigid_command("resume", "disk/run", "--out", "c") == 0
    table = Folder(disk / "run").table
    assert table.known.all()
    assert table.twice == 0
    known = stored.known
    assert table.rows[known].tobytes() == stored.rows[known].tobytes()

    assert rigid_command("map", "map.toml", "--out", "quiet") == 0
    assert Path("c.npz").read_bytes() == Path("quiet.npz").read_bytes()
    assert np.array_equal(rigid.load_map("c.npz").samples, np.full((80, 80), 4))


# Every operation on files fails in turn: what was stored stays, and the map goes on from there


@pytest.fixture
def many_records(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving, "GROWTH", 4)
    monkeypatch.setattr(driving, "SHORTEST", 1e-4)
    monkeypatch.setattr(logging, "SYNC_SECONDS", 0.0)


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("quiet") / "run"
    go_on(path)
    return numbers(path)


@pytest.mark.usefixtures("many_records")
@pytest.mark.parametrize("how", ["once", "full", "short", "torn"])
def test_an_operation_that_fails_loses_no_stored_row(
    tmp_path: Path, quiet: bytes, how: str
) -> None:
    failed = 0
    for number in range(1, 1000):
        path, disk = tmp_path / f"{number}", FailingDisk(number, how)
        try:
            go_on(path, disk)
            succeeded = disk.done < number
        except (OSError, Gone):
            failed += 1
            succeeded = False
        # The next sitting, on a disk that works.
        stored = int(Folder(path).table.known.sum()) if Folder.is_at(path) else 0
        go_on(path)
        folder = Folder(path)
        assert folder.table.rows.tobytes() == quiet
        assert folder.table.twice == 0
        assert sum(log.units for log in folder.logs) >= stored
        if succeeded:
            break
    else:
        raise AssertionError("the number of operations has no end")
    assert (failed == 0) == (how == "short")
    assert number > 10
