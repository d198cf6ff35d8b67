"""What is read from a damaged log is right, and loss is told. Long: tests/long/damaged_logs.py."""

import io
import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.store.log import Found, read_log
from rigid.store.rows import Table
from rigid.store.running import Folder
from small_maps import small_map
from stores import SPEC, go_on, numbers

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
