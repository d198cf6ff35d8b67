"""One name to install and one version, wherever they are written."""

import ast
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

import rigid
from processes import python_process
from rigid._checks.extras import DISTRIBUTION, install_extra
from rigid.literature.validation import entries

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
    named = {call.args[1].value for call in calls if isinstance(call.args[1], ast.Constant)}
    named |= {entry.needs for entry in entries() if entry.needs}
    assert {"maps", "mesh", "notebook", "store", "dask"} <= named <= EXTRAS


@pytest.mark.parametrize("file", [*PAGES, *SOURCES], ids=lambda file: str(file.relative_to(ROOT)))
def test_commands_install_this_distribution(file: Path) -> None:
    """The name ``rigid`` alone would fetch another project from the package index."""
    text = file.read_text(encoding="utf-8")
    named = re.findall(r"pip install [^\n`&]*?\b(rigid(?:-\w+)*)\b(?!_)(?:\[([\w,]+)\])?", text)
    assert {name for name, _ in named} <= {DISTRIBUTION}
    assert {extra for _, extras in named for extra in extras.split(",") if extra} <= EXTRAS


def test_the_readme_says_whether_the_package_is_on_an_index() -> None:
    """The pages of the site ask the same of ``pyproject.toml`` when they are built."""
    released = "Repository" in PROJECT.get("urls", {})
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert ("not on an index yet" in readme) is not released


READ_IN_THE_REPOSITORY = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    ROOT / "benches" / "README.md",
    *(ROOT / "docs" / f"{name}.md" for name in ("capabilities", "errata", "how_it_works")),
    *sorted((ROOT / "docs" / "decisions").glob("*.md")),
]


def anchors(page: Path) -> set[str]:
    """The anchors of the headings of a page, as GitHub makes them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head) for head in heads)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in plain}


@pytest.mark.parametrize("page", READ_IN_THE_REPOSITORY, ids=lambda page: page.name)
def test_links_of_pages_that_are_not_on_the_site_lead_somewhere(page: Path) -> None:
    """Sphinx checks the links of the others."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_changelog_and_citation_have_the_version_and_its_date() -> None:
    heading: Any = re.search(
        r"^## (\S+) \((\S+)\)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE
    )
    citation = (ROOT / "CITATION.cff").read_text()
    facts = dict(re.findall(r"^(version|date-released): (\S+)$", citation, re.MULTILINE))
    assert heading[1] == facts["version"] == rigid.__version__
    assert heading[2] == facts["date-released"]


# `import rigid` needs NumPy and nothing else; what is rarely needed is loaded later


OPTIONAL = ["anywidget", "scipy", "matplotlib", "xarray", "pandas", "tqdm", "numba"]

BLOCKED = f"""
import sys
for name in {OPTIONAL}:
    sys.modules[name] = None  # makes `import name` raise ImportError
import rigid
run = rigid.simulate(rigid.FreeBody(rigid.Body((1, 2, 3))), [1, 2, 3], t=[0.0, 1.0])
assert run.status == rigid.Status.FINISHED
try:
    run.rotation()
except ImportError as error:
    print(error)
"""

LOADED = """
import sys, numpy
before = set(sys.modules)
import rigid
loaded = {name.partition(".")[0] for name in set(sys.modules) - before}
print(*sorted(loaded - sys.stdlib_module_names))
"""

LATER = """
import sys
import rigid
from importlib import import_module
later = [name for name in rigid.__all__ if name not in vars(rigid)]
print(*later)
assert not [name for name in later if f"rigid.{name}" in sys.modules]
assert rigid.free.gammas([1.0, 2.0, 2.5]).shape == (3,)
for name in later:
    if name in ("Store", "diff", "merge", "open_store"):
        assert getattr(rigid, name) is getattr(import_module("rigid.store.store"), name), name
    elif name in ("Validation", "validation"):
        found = getattr(import_module("rigid.literature.validation"), name)
        assert getattr(rigid, name) is found, name
    else:
        assert getattr(rigid, name) is import_module(f"rigid.{name}"), name
"""


def output(code: str) -> str:
    return python_process(code).stdout.strip()


def test_everything_else_is_optional() -> None:
    assert "scipy" in output(BLOCKED)


def test_only_numpy_is_imported() -> None:
    assert output(LOADED) in ("rigid", "numpy rigid")  # parts of NumPy may load late


def test_modules_of_the_textbook_load_when_they_are_named() -> None:
    later = set(output(LATER).split())
    assert {"particles", "springs", "frames", "statics", "fixed_axis", "free"} <= later
    assert {"top", "earth", "figures", "animation"} <= later


def test_dir_shows_what_users_need_and_nothing_else() -> None:
    assert dir(rigid) == sorted(rigid.__all__)


def test_a_misspelt_module_is_a_mistake() -> None:
    """To a type checker too: it would report an ignored error that is none."""
    with pytest.raises(AttributeError, match="module 'rigid' has no attribute 'particle'"):
        _ = rigid.particle  # type: ignore[attr-defined]
    assert rigid.free.gammas([1.0, 2.0, 2.5]).shape == (3,)


def test_modules_take_only_the_core_and_modules_from_the_package() -> None:
    """`lint-imports` cannot see `_core`, so it lets every module import the package itself."""
    root = Path(rigid.__file__).parent
    # Tutorials are scripts of a user, not modules.
    tutorials = set((root / "builtin" / "tutorials").glob("*.py"))
    for file in sorted(set(root.rglob("*.py")) - tutorials):
        depth = len(file.relative_to(root).parts)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert not [name.name for name in node.names if name.name.startswith("rigid")]
            if not isinstance(node, ast.ImportFrom):
                continue
            assert node.level or not str(node.module).startswith("rigid"), (file, node.module)
            if node.level == depth and node.module is None:
                taken = {name.name for name in node.names}
                found = {name for name in taken if (root / name).is_dir()}
                found |= {name for name in taken if (root / f"{name}.py").is_file()}
                assert taken - found <= {"_core"}, (file, taken)
