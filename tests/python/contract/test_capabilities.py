"""What documents and lists say is there: public names, tests, examples that run, all forces."""

import ast
import doctest
import importlib
import inspect
import pkgutil
import re
import runpy
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import map_kinds
import rigid
from adversarial import KINDS
from rigid.drawing import colours
from rigid.maps import page
from rigid.model.criterion import CRITERIA, Criterion
from rigid.model.forces import FORCES
from rigid.model.parameters import PARAMETERS, PLACES

ROOT = Path(__file__).parents[3]
TESTS = ROOT / "tests" / "python"
DOCS = ROOT / "docs"


def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


Row = tuple[str, list[str], list[str]]


def row(line: str) -> Row:
    """The subject of a row, its public names, and the last column in backticks."""
    subject, _, names, tests = (cell.strip() for cell in line.strip("| \n").split(" | "))
    return subject, re.findall(r"`([^`]+)`", names), re.findall(r"`([^`]+)`", tests)


ROWS = [
    row(line)
    for line in text(DOCS / "capabilities.md").splitlines()
    if re.match(r"\| (?!subject \||figure \|)\w", line)
]


@cache
def functions(file: str) -> set[str]:
    (path,) = TESTS.rglob(file)
    tree = ast.parse(text(path))
    made = (target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets)
    named = {target.id for target in made if isinstance(target, ast.Name)}
    return named | {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def resolve(name: str) -> object:
    """What a user gets who writes this after ``import rigid``; of modules only public names."""
    found: object = rigid
    for part in name.split(".")[1:]:
        if isinstance(found, ModuleType):
            assert part in found.__all__, name
        found = getattr(found, part)
    return found


def test_every_capability_and_every_figure_has_one_row() -> None:
    assert len(ROWS) == len({(subject, *names) for subject, names, _ in ROWS}) > 90


@pytest.mark.parametrize(("subject", "names", "tests"), ROWS, ids=[row[0] for row in ROWS])
def test_names_resolve_and_tests_exist(subject: str, names: list[str], tests: list[str]) -> None:
    assert names
    assert len(set(names)) == len(names)
    for name in names:
        assert name.startswith("rigid.")
        assert not re.search(r"\b_", name), name
        resolve(name)  # raises if it is not there
    proofs, file = 0, ""
    for test in tests:
        if test.startswith("test_") and test.endswith(".py"):
            file = test
        elif "/" in test:
            assert (ROOT / test).is_file(), test
        else:
            assert test.partition("[")[0] in functions(file), f"{file}::{test}"
            proofs += 1
    assert proofs > 0


def test_every_public_module_has_its_page() -> None:
    modules = {name for name in rigid.__all__ if isinstance(getattr(rigid, name), ModuleType)}
    # The page of each module is made from its `__all__` when the site is built.
    page = runpy.run_path(str(ROOT / "docs" / "generated_pages.py"))["package_page"]()
    names = re.findall(r"^   ([A-Za-z_]\w*)$", page, re.M)
    assert sorted(names) == sorted(set(rigid.__all__) - modules - {"__version__"})
    listed = re.findall(r"^api/(\w+)$", text(DOCS / "reference.md"), re.M)
    assert sorted(listed) == sorted({"rigid"} | modules)


def test_a_symbol_has_one_meaning_and_pictures_use_it() -> None:
    symbols = [
        symbol
        for cell in re.findall(r"^\| (\$.*?) \|", text(DOCS / "notation.md"), re.MULTILINE)
        for symbol in re.findall(r"\$(.*?)\$", cell)
    ]
    assert len(set(symbols)) == len(symbols)
    inks = [ink for ink in vars(colours).values() if isinstance(ink, colours.Ink)]
    labels = {ink.label[1:-1] for ink in inks if ink.label.startswith("$")}
    assert len(labels) >= 8
    assert labels <= set(symbols)


# Errata: docstrings and tests cite them by number

ERRATA = re.findall(
    r"^\| ([DGS]-\d\d) \| .* \| ([PNMXW]) \| .* \| `(\w+\.py)::(\w+)` \|$",
    text(DOCS / "errata.md"),
    re.MULTILINE,
)


def test_every_erratum_that_is_cited_has_its_line_and_its_test() -> None:
    lines = [number for number, *_ in ERRATA]
    assert lines == sorted(set(lines))
    places = [*(ROOT / "python").rglob("*.py"), *TESTS.rglob("*.py")]
    cited = {one for place in places for one in re.findall(r"\b[DGS]-\d\d\b", text(place))}
    assert cited == set(lines)
    for number, _, file, test in ERRATA:
        assert test in functions(file), number


# What must be named in several lists is named in all: forces, criteria and methods.


@pytest.mark.parametrize("name", FORCES)
def test_a_force_is_a_force_everywhere(name: str) -> None:
    """A list that does not know a force would leave it out of a motion, in silence."""
    assert name in inspect.signature(rigid.FreeBody).parameters
    assert f"\n    {name} : " in (rigid.FreeBody.__doc__ or "")
    assert any(name in method.forces for method in rigid.methods())
    assert PLACES[name].first == FORCES[name].first
    assert [row for row in PARAMETERS.values() if row.place == name]
    assert f"{name}=" in text(DOCS / "forces.md")


def test_films_of_maps_move_under_every_force() -> None:
    """A row of numbers is read as it is written: the lists of both languages agree."""
    further = ", ".join(f"{name}: {force.width}" for name, force in FORCES.items())
    assert f", {further}}};" in text(Path(page.__file__).parents[1] / "animation/page/motion.js")


def test_hard_runs_are_made_under_every_force() -> None:
    rng = np.random.default_rng(1)
    met = {name for _, make in KINDS.values() for name in make(rng).scene.forces}
    assert met >= FORCES.keys()


@pytest.mark.parametrize("name", CRITERIA)
def test_a_criterion_is_a_criterion_everywhere(name: str) -> None:
    assert getattr(rigid, name).__doc__.startswith("Stable: ")  # for the table of the guide
    asked = (request.get("stable") for request, _ in map_kinds.KINDS.values())
    leaves = [leaf for one in asked if isinstance(one, Criterion) for leaf in one.leaves]
    assert any(type(leaf) is CRITERIA[name] for leaf in leaves)


def test_every_method_has_a_line_in_the_guide() -> None:
    known = [method.name for method in rigid.methods()]
    described = text(DOCS / "methods.md")
    assert [name for name in known if name not in described] == []


# The examples of the documentation run and print what they say.


MODULES = ["rigid"] + [
    module.name
    for module in pkgutil.walk_packages(rigid.__path__, "rigid.")
    if module.name not in ("rigid._core", "rigid.__main__")
]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an example writes goes to a place of its own, and no window opens."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    module = importlib.import_module(name)
    assert doctest.testmod(module).failed == 0


def test_the_public_names_with_arguments_have_examples() -> None:
    finder = doctest.DocTestFinder()
    scenes, calls = ("Body", "FreeBody", "HeavyTop"), ("simulate", "plan", "report")
    for name in (*scenes, *calls, "methods", "build_info"):
        found = finder.find(getattr(rigid, name), name)
        assert any(test.examples for test in found), name


PAGES = [
    page.relative_to(ROOT).as_posix()
    for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md")))
    if "```python\n" in text(page)
]


@pytest.mark.parametrize("page", PAGES)
def test_pages(page: str) -> None:
    """All Python blocks, one after the other as a reader would run them."""
    blocks = re.findall(r"^```python\n(.*?)^```", text(ROOT / page), re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {"__name__": "readme"}
    for number, block in enumerate(blocks):
        if ">>>" in block:
            test = doctest.DocTestParser().get_doctest(block, names, f"block {number}", page, 0)
            assert doctest.DocTestRunner().run(test, clear_globs=False).failed == 0
            names.update(test.globs)
        else:
            exec(compile(block, f"{page}, block {number}", "exec"), names)
