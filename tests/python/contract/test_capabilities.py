"""The tables of capabilities and of errata name what is there: public names, and tests."""

import ast
import re
import runpy
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest

import rigid
from rigid.drawing import colours

ROOT = Path(__file__).parents[3]
TESTS = ROOT / "tests" / "python"
PAGE = ROOT / "docs" / "capabilities.md"

Row = tuple[str, list[str], list[str]]


def row(line: str) -> Row:
    """The subject of a row, its public names, and the last column in backticks."""
    subject, _, names, tests = (cell.strip() for cell in line.strip("| \n").split(" | "))
    return subject, re.findall(r"`([^`]+)`", names), re.findall(r"`([^`]+)`", tests)


LINES = PAGE.read_text(encoding="utf-8").splitlines()
ROWS = [row(line) for line in LINES if re.match(r"\| (?!subject \||figure \|)\w", line)]


@cache
def functions(file: str) -> set[str]:
    (path,) = TESTS.rglob(file)
    tree = ast.parse(path.read_text(encoding="utf-8"))
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
    listed = re.findall(r"^api/(\w+)$", (ROOT / "docs/reference.md").read_text("utf-8"), re.M)
    assert sorted(listed) == sorted({"rigid"} | modules)


def test_a_symbol_has_one_meaning_and_pictures_use_it() -> None:
    page = (ROOT / "docs" / "notation.md").read_text(encoding="utf-8")
    symbols = [
        symbol
        for cell in re.findall(r"^\| (\$.*?) \|", page, re.MULTILINE)
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
    (ROOT / "docs" / "errata.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_every_erratum_that_is_cited_has_its_line_and_its_test() -> None:
    lines = [number for number, *_ in ERRATA]
    assert lines == sorted(set(lines))
    places = [*(ROOT / "python").rglob("*.py"), *TESTS.rglob("*.py")]
    cited = {
        number
        for place in places
        for number in re.findall(r"\b[DGS]-\d\d\b", place.read_text(encoding="utf-8"))
    }
    assert cited == set(lines)
    for number, _, file, test in ERRATA:
        assert test in functions(file), number
