"""The tables of capabilities and of errata name what is there: public names, and tests."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from types import ModuleType

import pytest

import rigid

TESTS = Path(__file__).parent
ROOT = TESTS.parents[1]
PAGE = ROOT / "docs" / "capabilities.md"

Row = tuple[str, list[str], list[str]]


def row(line: str) -> Row:
    """The key of a row, its public names, and the last column in backticks."""
    key, _, names, tests = (cell.strip() for cell in line.strip("| \n").split(" | "))
    return key, re.findall(r"`([^`]+)`", names), re.findall(r"`([^`]+)`", tests)


LINES = PAGE.read_text(encoding="utf-8").splitlines()
ROWS = [row(line) for line in LINES if re.match(r"\| [KP]\d", line)]


def functions(file: str) -> set[str]:
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def resolve(name: str) -> object:
    """What a user gets who writes this after ``import rigid``; of modules only public names."""
    found: object = rigid
    for part in name.split(".")[1:]:
        if isinstance(found, ModuleType):
            assert part in found.__all__, name
        found = getattr(found, part)
    return found


def test_every_capability_and_every_figure_has_one_row() -> None:
    expected = [f"K{k:02d}" for k in range(1, 71)] + [f"P{k:02d}" for k in range(1, 24)]
    assert [key for key, _, _ in ROWS] == expected


@pytest.mark.parametrize(("key", "names", "tests"), ROWS, ids=[key for key, _, _ in ROWS])
def test_names_resolve_and_tests_exist(key: str, names: list[str], tests: list[str]) -> None:
    assert names
    assert len(set(names)) == len(names)
    for name in names:
        assert name.startswith("rigid.")
        assert not re.search(r"\b_", name), name
        assert resolve(name) is not None
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
    assert {page.stem for page in (ROOT / "docs" / "api").glob("*.rst")} == {"rigid"} | modules
    listed = re.findall(r"^api/(\w+)$", (ROOT / "docs/reference.md").read_text("utf-8"), re.M)
    assert sorted(listed) == sorted({"rigid"} | modules)


# Errata: docstrings and tests cite them by number

ERRATA = re.findall(
    r"^\| ([DGS]-\d\d) \| .* \| ([PNMXW]) \| .* \| `(\w+\.py)::(\w+)` \|$",
    (ROOT / "docs" / "errata.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_every_erratum_that_is_cited_has_its_line_and_its_test() -> None:
    lines = [number for number, *_ in ERRATA]
    assert lines == sorted(set(lines))
    places = [*(ROOT / "python").rglob("*.py"), *TESTS.glob("*.py")]
    cited = {
        number
        for place in places
        for number in re.findall(r"\b[DGS]-\d\d\b", place.read_text(encoding="utf-8"))
    }
    assert cited == set(lines)
    for number, _, file, test in ERRATA:
        assert test in functions(file), number
