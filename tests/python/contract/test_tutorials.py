"""Tutorials as notebooks: valid, without tests, and they run and show pictures.

The build of the site runs all of them. Their numbers are checked where they stand.
"""

import json
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from processes import Capture, environment
from rigid.cli import main
from rigid.cli.tutorials import markdown, notebook

SCRIPTS = Path(__file__).parents[3] / "python" / "rigid" / "builtin" / "tutorials"


def test_a_notebook_of_each_tutorial_is_written(tmp_path: Path, capfd: Capture) -> None:
    folder = tmp_path / "new" / "notebooks"
    assert main(["tutorials", str(folder)]) == 0
    names = sorted(path.name for path in folder.iterdir())
    scripts = sorted(path.stem for path in SCRIPTS.glob("*.py"))
    assert names == [f"{name.removeprefix('plot_')}.ipynb" for name in scripts]
    assert capfd.readouterr().out == f"wrote {len(names)} notebooks into {folder}\n"
    for name in names:
        read: Any = nbformat.read(folder / name, as_version=4)  # type: ignore[no-untyped-call]
        nbformat.validate(read)
        # As Jupyter writes it: what a reader saves there differs in what the reader changed.
        assert (read.nbformat, read.nbformat_minor) == (4, 5)
        text = (folder / name).read_text(encoding="utf-8")
        assert json.dumps(json.loads(text), indent=1, ensure_ascii=False) + "\n" == text
        title, *_ = read.cells
        assert title.cell_type == "markdown"
        assert title.source.startswith("# ")
        text = "".join(cell.source for cell in read.cells)
        for left in (
            "sphinx_gallery",
            ":doc:",
            ":func:",
            ":math:",
            ".. ",
            "``",
            "# %%",
            "assert ",
            "----",
        ):
            assert left not in text, (name, left)
    assert main(["tutorials", str(folder)]) == 2
    assert "exists; take another name" in capfd.readouterr().err
    assert main(["tutorials", str(folder), "--force"]) == 0


def test_text_code_and_formulas_are_cells() -> None:
    script = (
        'r"""\nTitle\n=====\n\nWords :math:`a\nb`.\n"""\n\nimport rigid\n\n# %%\n# Of ``x``:\n#\n'
    )
    script += "# .. math:: x^2\nx = 1\n# sphinx_gallery_start_ignore\nassert x\n"
    script += "# sphinx_gallery_end_ignore\n# a remark\nprint(x)\n"
    cells = json.loads(notebook(script))["cells"]
    assert ["".join(cell["source"]) for cell in cells] == [
        "# Title\n\nWords $a b$.",
        "import rigid",
        "Of `x`:\n\n$$x^2$$",
        "x = 1\n# a remark\nprint(x)",
    ]
    assert [cell["cell_type"] for cell in cells] == ["markdown", "code", "markdown", "code"]
    assert markdown("One\n===\n\nTwo\n---\n") == "# One\n\n## Two\n"
    assert markdown("See :doc:`maps </maps>`, :func:`rigid.fit`.") == "See maps, `rigid.fit`."


def test_a_tutorial_runs_as_a_notebook_and_shows_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    assert main(["tutorials", str(tmp_path)]) == 0
    path = tmp_path / "1_free_rotation.ipynb"
    read: Any = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    NotebookClient(read, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in read.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
