"""The examples of the documentation run and print what they say."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import rigid

ROOT = Path(__file__).parents[3]

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
    for name in (
        "Body",
        "FreeBody",
        "HeavyTop",
        "simulate",
        "plan",
        "report",
        "methods",
        "build_info",
    ):
        found = finder.find(getattr(rigid, name), name)
        assert any(test.examples for test in found), name


PAGES = [
    page.relative_to(ROOT).as_posix()
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    if "```python\n" in page.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("page", PAGES)
def test_pages(page: str) -> None:
    """All Python blocks, one after the other as a reader would run them."""
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {"__name__": "readme"}
    for number, block in enumerate(blocks):
        if ">>>" in block:
            test = doctest.DocTestParser().get_doctest(block, names, f"block {number}", page, 0)
            assert doctest.DocTestRunner().run(test, clear_globs=False).failed == 0
            names.update(test.globs)
        else:
            exec(compile(block, f"{page}, block {number}", "exec"), names)
