"""`import rigid` needs NumPy and nothing else; what is rarely needed is loaded later."""

from __future__ import annotations

import ast
from pathlib import Path
from types import ModuleType

import pytest

import rigid
from processes import python_process

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
    """The names of the reference, whose pages of modules are named in `docs/api`."""
    pages = Path(__file__).parents[3] / "docs" / "api"
    modules = {name for name in rigid.__all__ if isinstance(getattr(rigid, name), ModuleType)}
    assert modules == {page.stem for page in pages.glob("*.rst")} - {"rigid"} | {"units"}
    assert dir(rigid) == sorted(rigid.__all__)


def test_a_misspelt_module_is_a_mistake() -> None:
    """To a type checker too: it would report an ignored error that is none."""
    with pytest.raises(AttributeError, match="module 'rigid' has no attribute 'particle'"):
        _ = rigid.particle  # type: ignore[attr-defined]
    assert rigid.free.gammas([1.0, 2.0, 2.5]).shape == (3,)


def test_modules_take_only_the_core_and_modules_from_the_package() -> None:
    """`lint-imports` cannot see `_core`, so it lets every module import the package itself."""
    root = Path(rigid.__file__).parent
    for file in sorted(root.rglob("*.py")):
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
