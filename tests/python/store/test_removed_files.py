"""Files of a running map that somebody removes while it is computed: nothing is claimed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import rigid
from stores import SPEC, go_on, request


def newest_log(path: Path) -> Path:
    return max((path / "logs").iterdir(), key=lambda log: log.stat().st_mtime)


def rename(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))


REMOVALS: dict[str, Callable[[Path], object]] = {
    "folder": shutil.rmtree,
    "renamed": rename,
    "logs": lambda path: shutil.rmtree(path / "logs"),
    "log": lambda path: newest_log(path).unlink(),
    "head": lambda path: (path / "head.json").unlink(),
    "log of another part": lambda path: sorted((path / "logs").iterdir())[0].unlink(),
}


@pytest.mark.parametrize("what", REMOVALS)
def test_a_map_whose_rows_are_gone_is_not_complete(what: str, tmp_path: Path) -> None:
    path = tmp_path / "run"
    rigid.stability_map(**request(store=path, part=(1, 2)))
    removals = iter([REMOVALS[what]])

    def remove(_: object) -> None:
        for removal in removals:
            removal(path)

    with pytest.raises(FileNotFoundError, match="removed or renamed while the map was computed"):
        rigid.stability_map(**request(store=path, progress=remove))


def test_a_store_is_read_again_before_it_goes_on(tmp_path: Path) -> None:
    """It was opened while there were rows."""
    go_on(tmp_path / "run")
    store = rigid.open_store(tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "logs")
    assert store.resume(progress=False).computed == SPEC.samples * 144
