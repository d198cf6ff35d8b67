"""The folder where commands are run."""

from pathlib import Path

import pytest

from map_texts import SMALL


@pytest.fixture(autouse=True)
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with the specification of the tests in ``small.toml``."""
    (tmp_path / "small.toml").write_text(getattr(request.module, "SPEC", SMALL))
    monkeypatch.chdir(tmp_path)
    return tmp_path
