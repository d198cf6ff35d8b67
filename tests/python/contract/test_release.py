"""One name to install and one version, wherever they are written."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

import pytest

import rigid
from rigid._checks.extras import DISTRIBUTION, install_extra

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = set(PROJECT["optional-dependencies"])
SOURCES = sorted((ROOT / "python" / "rigid").rglob("*.py"))
PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / ".github").rglob("*.yml")),
]


def test_the_distribution_is_that_of_messages_and_of_the_build() -> None:
    assert PROJECT["name"] == DISTRIBUTION == rigid.build_info()["distribution"]
    assert rigid.build_info()["import"] == rigid.__name__


def test_extras_of_extras_are_of_this_distribution() -> None:
    needs = [need for extra in PROJECT["optional-dependencies"].values() for need in extra]
    own = [re.fullmatch(r"([\w-]*rigid[\w-]*)\[([\w,]+)\]", need) for need in needs]
    found = [match for match in own if match is not None]
    assert {match[1] for match in found} == {DISTRIBUTION}
    assert {name for match in found for name in match[2].split(",")} <= EXTRAS


def test_every_message_names_an_extra_that_exists() -> None:
    calls = [
        node
        for source in SOURCES
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == install_extra.__name__
    ]
    named = {str(ast.literal_eval(call.args[1])) for call in calls}
    assert {"maps", "mesh", "notebook", "store", "dask"} <= named <= EXTRAS


@pytest.mark.parametrize("file", [*PAGES, *SOURCES], ids=lambda file: str(file.relative_to(ROOT)))
def test_commands_install_this_distribution(file: Path) -> None:
    """The name ``rigid`` alone would fetch another project from the package index."""
    text = file.read_text(encoding="utf-8")
    named = re.findall(r"pip install [^\n`&]*?\b(rigid(?:-\w+)*)\b(?!_)(?:\[([\w,]+)\])?", text)
    assert {name for name, _ in named} <= {DISTRIBUTION}
    assert {extra for _, extras in named for extra in extras.split(",") if extra} <= EXTRAS


def test_changelog_and_citation_have_the_version_and_its_date() -> None:
    heading = re.search(r"^## (\S+) \((\S+)\)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert heading is not None
    citation = (ROOT / "CITATION.cff").read_text()
    facts = dict(re.findall(r"^(version|date-released): (\S+)$", citation, re.MULTILINE))
    assert heading[1] == facts["version"] == rigid.__version__
    assert heading[2] == facts["date-released"]
