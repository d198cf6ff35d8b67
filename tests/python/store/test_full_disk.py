"""A disk that is really full: a file system of 600 kB, which is enlarged later."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import rigid
from map_texts import map_text
from processes import Capture
from rigid.cli import main
from rigid.store import drive as driving
from rigid.store import log as logging
from rigid.store.running import Folder
from stores import FailingDisk, Gone, go_on, numbers

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


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """The folder of a file system of 600 kB."""
    if not sys.platform.startswith("linux"):
        pytest.skip("only Linux mounts a tmpfs")
    place = tmp_path / "disk"
    place.mkdir()
    mounted = run("mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(place))
    if mounted.returncode:
        pytest.skip(f"a file system of {SMALL} cannot be mounted: {mounted.stderr.strip()}")
    try:
        yield place
    finally:
        run("umount", str(place)).check_returncode()


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

    run("mount", "-o", f"remount,size={LARGE}", str(disk)).check_returncode()
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
