"""Every operation on files fails in turn: what was stored stays, and the map goes on from there."""

from pathlib import Path

import pytest

from rigid.store import drive as driving
from rigid.store import log as logging
from rigid.store.running import Folder
from stores import FailingDisk, Gone, go_on, numbers


@pytest.fixture(autouse=True)
def many_records(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving, "GROWTH", 4)
    monkeypatch.setattr(driving, "SHORTEST", 1e-4)
    monkeypatch.setattr(logging, "SYNC_SECONDS", 0.0)


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("quiet") / "run"
    go_on(path)
    return numbers(path)


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
