"""What notebooks, scripts and terminals show of results: pictures, tables, a short line."""

import base64
import html
import json
import re
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

import rigid
from processes import Capture, environment, python_process
from rigid.cli import main
from rigid.cli.tutorials import markdown, notebook
from rigid.drawing.figure import html_table, html_text, html_with_picture

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))


def small_map() -> rigid.StabilityMap:
    return rigid.stability_map(
        BOX,
        axes={"spin": [5.0, 10.0], "noise": [1e-3, 1e-2, 0.1]},
        start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-2)),
        stable=rigid.no_flip(2),
        t_end=1.0,
        samples=10,
        rng=1,
    )


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    """One result of each kind."""
    mapped = small_map()
    return {
        "map": mapped,
        "replay": mapped.replay(pixel=(2, 0), sample=3),
        "run": rigid.simulate(BOX, [1e-3, 10.0, 1e-3], t=np.linspace(0.0, 2.0, 50)),
        "plan": rigid.plan(BOX, "attitude", omega=[1e-3, 10.0, 1e-3], t_end=3600.0),
        "methods": rigid.methods(),
        "points": rigid.poincare(TOP, [0.3, 0.4, 1.0], [0.9, 0.3, 0.2, 0.1], t_end=30.0),
        "growth": rigid.lyapunov(TOP, [0.3, 0.4, 1.0], t=np.linspace(5.0, 100.0, 20)),
        "growth at one time": rigid.lyapunov(TOP, [[0.3, 0.4, 1.0]], t=[100.0]),
        "report": rigid.report(
            TOP, [0.3, 0.4, 1.0], t_end=1.0, methods=["rk4"], seconds=0.1, progress=False
        ),
        "long": rigid.report(
            TOP, [0.3, 0.4, 1.0], revolutions=[3], methods=["rk4"], progress=False
        ),
        "extremes": rigid.extremes("spin", method="exact", progress=False),
        "validation": rigid.validation("earth-chandler", progress=False),
    }


LINES = {
    "map": r"<StabilityMap: free body, spin x noise, 2 x 3 pixels; 60 bodies: .*% stable, .*>",
    "replay": r"<Replay: pixel \(2, 0\) \(spin 5, noise 0.1\), sample 3; \w+.*; exact>",
    "run": r"Run\(one body at 50 times; exact; error .*; ok\)",
    "plan": r"<Plan: free body, box .*; exact, closed form: free asymmetric; error about .* rad>",
    "points": r"<Crossings: .*>",
    "growth": r"<Growth: one body at 20 times; 1 \w+>",
    "growth at one time": r"<Growth: 1 body at 1 time; 1 \w+>",
    "report": r"<Report: heavy top, .*; \d+ runs by 1 method>",
    "long": r"<Report: heavy top, .*; \d+ runs by 1 method over 3 revolutions>",
    "extremes": r"<Extremes: no undetected error in \d+ runs: \d+ right.*>",
    "validation": r"<Validation: 1 number: 0 agree, 1 of models that differ, 0 unexplained>",
}


@pytest.mark.parametrize("name", LINES)
def test_a_result_is_named_in_one_short_line(name: str, results: dict[str, Any]) -> None:
    line = repr(results[name])
    assert re.fullmatch(LINES[name], line), line
    assert len(line) < 250


def test_arrays_of_many_numbers_print_their_shapes() -> None:
    t = np.linspace(0.0, 50.0, 501)
    omega = np.full((300, 3), 0.3)
    sink = rigid.EnergySink(0.01)
    for many in (
        rigid.exact.free_body(rigid.Body((1.0, 2.0, 3.0)), omega),
        rigid.free.spin_periods((1.0, 2.0, 3.0), omega),
        rigid.free.relaxation((1.0, 2.0, 2.5), [0.1, 0.2, 1.0], t, sink),
        rigid.frequencies(t, np.cos(np.outer(np.arange(1.0, 20.0), t))),
        small_map().outcomes(range(10)),
    ):
        assert len(repr(many)) < 700
        assert "of shape (" in repr(many)
    body = rigid.Body((1.0, 2.0, 3.0))
    eight, nine = (repr(rigid.exact.free_body(body, omega[:count])) for count in (8, 9))
    assert " m=[0." in eight
    assert " m=<float64 of shape (9,)>" in nine
    one = rigid.exact.free_body(body, [0.3, 0.2, 1.2])
    assert repr(one).startswith("FreeMotion(axis=3, m=0.0")
    drift = repr(rigid.frequency_drift(rigid.simulate(TOP, [0.3, 0.4, 1.0], t=t)))
    assert drift.startswith("FrequencyDrift(first=Lines(frequency=")


def test_methods_are_a_table_of_a_line_each(results: dict[str, Any]) -> None:
    lines = repr(results["methods"]).splitlines()
    assert [line.split()[0] for line in lines[1:]] == [method.name for method in rigid.methods()]
    assert max(map(len, lines)) < 160


@pytest.mark.parametrize("name", ["map", "points", "growth", "report", "long", "run", "replay"])
def test_a_notebook_shows_a_picture_and_its_words(name: str, results: dict[str, Any]) -> None:
    shown = results[name]._repr_html_()
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]*)"', shown)
    content = base64.b64decode(picture)
    assert content.startswith(b"\x89PNG")
    assert len(content) > 10_000
    width, height = np.frombuffer(content[16:24], ">u4")
    # The curve of one body is a strip, of which a screen has room for many.
    assert name not in ("replay", "run") or width / height == pytest.approx(8 / 3, rel=0.01)
    words = {
        "map": results["map"].summary(),
        "points": repr(results["points"]),
        "growth": repr(results["growth"]),
        "report": str(results["report"]),
        "long": str(results["long"]),
        "run": repr(results["run"]),
        "replay": repr(results["replay"]),
    }[name]
    assert html.escape(words.split()[-1]) in shown


def test_a_run_shows_the_first_body_and_what_has_no_picture_its_words(
    results: dict[str, Any],
) -> None:
    starts, times = [[1e-3, 10.0, 1e-3]] * 3, [0.0, 1.0, 2.0]
    assert "body 0" in rigid.simulate(BOX, starts, t=times)._repr_html_()
    for run in (
        rigid.simulate(BOX, starts[0], t=[1.0]),
        rigid.simulate(BOX, np.empty((0, 3)), t=times),
        rigid.simulate(BOX, np.ones((2, 2, 3)), t=times),
    ):
        assert run._repr_html_() == html_text(repr(run))
    extremes = results["extremes"]
    assert extremes._repr_html_() == html_text(str(extremes))


@pytest.mark.parametrize(("name", "rows"), [("plan", 8), ("methods", len(rigid.methods()) + 1)])
def test_a_notebook_shows_a_table(name: str, rows: int, results: dict[str, Any]) -> None:
    assert results[name]._repr_html_().count("<tr>") == rows


def test_words_are_no_markup() -> None:
    for shown in (html_text("a<b&c"), html_table([["a<b&c"]], header=["d"])):
        assert "a&lt;b&amp;c" in shown
    alt = html_with_picture(lambda ax: ax.plot([0, 1]), 'a "b"\nc')
    assert 'alt="a &quot;b&quot;"' in alt


def test_without_matplotlib_a_notebook_shows_the_words(
    results: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    shown = results["map"]._repr_html_()
    assert "<img" not in shown
    assert "classes" in shown


CODE = """
import numpy as np, rigid, sys
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
points = rigid.poincare(TOP, [0.3, 0.4, 1.0], [0.9, 0.3, 0.2, 0.1], t_end=30.0)
"""
RUN = "run = rigid.simulate(TOP, [0.3, 0.4, 1.0], t=np.linspace(0.0, 3.0, 31))"


def test_a_picture_needs_no_display_and_pyplot_shows_those_of_a_script_that_imports_it() -> None:
    python_process(
        CODE + "points.plot().figure.canvas.draw(); assert 'matplotlib.pyplot' not in sys.modules\n"
        "import matplotlib; matplotlib.use('agg'); import matplotlib.pyplot as plt\n"
        "ax = points.plot(); assert [ax.figure.number] == plt.get_fignums()\n"
        "rigid.figures.box(rigid.Body.box(0.25, 0.08, 0.01)).plot()\n"
        "assert len(plt.get_fignums()) == 2\n"
        "points._repr_html_(); assert len(plt.get_fignums()) == 2\n"
    )


# Tutorials as notebooks: valid, without tests, and they run and show pictures.


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


def test_a_tutorial_runs_as_a_notebook_that_shows_what_is_plotted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what cells after it plot and show."""
    for name, value in environment().items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    assert main(["tutorials", str(tmp_path)]) == 0
    path = tmp_path / "1_free_rotation.ipynb"
    read: Any = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    own = [CODE, "ax = points.plot()", "points", "rigid.methods()", RUN, "run", "ax = run.plot()"]
    new: Any = nbformat.v4
    tutorial, read.cells = read.cells, [*read.cells, *map(new.new_code_cell, own)]
    NotebookClient(read, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    shown = [
        [set(output["data"]) for output in cell.get("outputs", []) if "data" in output]
        for cell in read.cells
    ]
    assert any("image/png" in data for cell in shown[: len(tutorial)] for data in cell)
    _, plotted, points, table, _, strip, rates = shown[len(tutorial) :]
    assert any("image/png" in data for data in plotted)
    assert points == table == strip == [{"text/html", "text/plain"}]
    assert any("image/png" in data for data in rates)
