"""A tutorial runs as a notebook and shows pictures; the build of the site runs all of them.

Their numbers are checked where they stand.
"""

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from processes import environment

TUTORIALS = Path(__file__).parents[3] / "docs" / "tutorials"


def test_a_tutorial_runs_as_a_notebook_and_shows_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = TUTORIALS / "plot_1_free_rotation.py"
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    new: Any = nbformat.v4
    cells = [new.new_code_cell(cell) for cell in path.read_text(encoding="utf-8").split("# %%\n")]
    notebook = new.new_notebook(
        cells=cells, metadata={"kernelspec": {"name": "python3", "display_name": "Python"}}
    )
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
