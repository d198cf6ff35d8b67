"""The running maps that each release has written are read for ever."""

from __future__ import annotations

import json
import shutil
from hashlib import blake2b
from pathlib import Path

import pytest

import rigid
from rigid.store.running import Folder

STORES = Path(__file__).parents[2] / "golden" / "stores"
NAMES = sorted(path.name for path in STORES.iterdir() if path.is_dir())


def test_there_is_one() -> None:
    assert NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_rows_of_a_release_are_read_and_come_out_again(name: str) -> None:
    kept = json.loads((STORES / f"{name}.json").read_text())
    folder = Folder(STORES / name)
    table = folder.table
    assert folder.head.key.hex() == kept["key"]
    assert int(table.known.sum()) == kept["units"]
    assert blake2b(table.rows.tobytes(), digest_size=16).hexdigest() == kept["rows"]
    status = rigid.open_store(STORES / name).status()
    assert status.complete
    # The end of one log is torn.
    assert sorted(str(writer.get("reason")) for writer in status.writers) == [
        "None",
        "complete",
        "waiting",
    ]
    assert {writer["version"] for writer in status.writers} == {kept["version"]}
    assert len(status.damage) == 1
    assert not rigid.open_store(STORES / name).verify(1.0).wrong


@pytest.mark.parametrize("name", NAMES)
def test_a_map_of_a_release_goes_on(name: str, tmp_path: Path) -> None:
    whole = Folder(STORES / name).table
    shutil.copytree(STORES / name, tmp_path / "run")
    min((tmp_path / "run" / "logs").iterdir()).unlink()
    assert Folder(tmp_path / "run").table.known.sum() < whole.known.sum()
    assert rigid.open_store(tmp_path / "run").resume(progress=False).complete
    assert Folder(tmp_path / "run").table.rows.tobytes() == whole.rows.tobytes()
