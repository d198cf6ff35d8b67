"""What is read from a damaged log is right, and loss is told. Long: tests/long/damaged_logs.py."""

import io
import tarfile
from pathlib import Path

import numpy as np
import pytest

from rigid.store.log import Found, read_log
from rigid.store.rows import Block, Table
from rigid.store.running import Folder
from stores import SPEC, go_on, numbers


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Folder:
    """A complete map in one log of many records."""
    quiet = tmp_path_factory.mktemp("quiet") / "run"
    go_on(quiet)
    rows = Folder(quiet).table.rows[Folder(quiet).table.known]
    folder = Folder.at(tmp_path_factory.mktemp("map") / "run", SPEC)
    folder.begin()
    for block in np.array_split(rows, 12):
        folder.append(Block(block.copy(), np.ones(len(block), "<f4")))
    folder.end("complete")
    return Folder(folder.path)


@pytest.fixture(scope="module")
def log(run: Folder) -> bytes:
    (name,) = (run.path / "logs").iterdir()
    return name.read_bytes()


def read(content: bytes, run: Folder) -> tuple[Table, Found]:
    """The rows in the bytes of a log; each must be a row of the map."""
    found, table = Found(), Table(run.head)
    for block in read_log(io.BytesIO(content), run.head.seal, found):
        table.add(block, "log")
    assert table.rows[table.known].tobytes() == run.table.rows[table.known].tobytes()
    return table, found


def whole(run: Folder) -> int:
    return int(run.table.known.sum())


def test_a_log_is_a_tar_file_of_numpy_tables(log: bytes, run: Folder) -> None:
    units = []
    with tarfile.open(fileobj=io.BytesIO(log)) as archive:
        names = archive.getnames()
        for name in names:
            if name.endswith(".npy") and ".ns." not in name:
                member = archive.extractfile(name)
                assert member is not None
                units.append(np.load(io.BytesIO(member.read()), allow_pickle=False)["unit"])
    assert (names[0], names[-1]) == ("writer.json", "end.json")
    assert len(units) == 12
    assert sorted(np.concatenate(units)) == np.flatnonzero(run.table.known).tolist()


def test_truncated_logs_have_their_whole_records(log: bytes, run: Folder) -> None:
    known, torn = [], 0
    for length in [*range(0, len(log), 97), len(log)]:
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
    for place in random.integers(0, len(log), 600):
        content = bytearray(log)
        content[place] ^= 1 << int(random.integers(0, 8))
        table, found = read(bytes(content), run)
        if table.known.sum() < whole(run):
            lost += 1
            assert found.damage
    assert lost > 200


@pytest.mark.parametrize("kind", ["zeros", "garbage", "cut out", "twice"])
def test_damaged_pages_lose_rows_and_never_change_them(log: bytes, run: Folder, kind: str) -> None:
    random = np.random.default_rng(2)
    for _ in range(150):
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
    go_on(path)
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


def test_strange_files_among_the_logs_are_not_read(run: Folder, tmp_path: Path) -> None:
    path = tmp_path / "run"
    go_on(path)
    before = numbers(path)
    (path / "logs" / "notes.txt").write_text("mine")
    (path / "logs" / "20260101T000000Z-000000000000.tar").mkdir()
    outside = tmp_path / "outside"
    outside.write_bytes(b"x" * 4096)
    assert numbers(path) == before
    assert run.head.spec == SPEC
