"""`import rigid` needs NumPy and nothing else, and hardly any time."""

from __future__ import annotations

import subprocess
import sys

import pytest

import rigid

OPTIONAL = ["scipy", "matplotlib", "xarray", "pandas", "tqdm", "numba"]

BLOCKED = f"""
import sys
for name in {OPTIONAL}:
    sys.modules[name] = None  # makes `import name` raise ImportError
import rigid
run = rigid.simulate(rigid.FreeBody(rigid.Body((1, 2, 3))), [1, 2, 3], t=[0.0, 1.0])
assert run.status == rigid.Status.FINISHED
assert set(rigid.__all__) <= set(dir(rigid))
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
assert set(later) <= set(dir(rigid)), later
assert not [name for name in later if f"rigid.{name}" in sys.modules]
assert rigid.free.gammas([1.0, 2.0, 2.5]).shape == (3,)
for name in later:
    assert getattr(rigid, name) is import_module(f"rigid.{name}"), name
"""

TIMED = """
import time, numpy
start = time.thread_time()
import rigid
print(time.thread_time() - start)
"""


def output(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_everything_else_is_optional() -> None:
    assert "scipy" in output(BLOCKED)


def test_only_numpy_is_imported() -> None:
    assert output(LOADED) in ("rigid", "numpy rigid")  # parts of NumPy may load late


def test_modules_of_the_textbook_load_when_they_are_named() -> None:
    later = set(output(LATER).split())
    assert {"particles", "springs", "frames", "statics", "fixed_axis", "free"} <= later
    assert {"top", "earth", "figures", "animation"} <= later


def test_a_misspelt_module_is_a_mistake() -> None:
    """To a type checker too: it would report an ignored error that is none."""
    with pytest.raises(AttributeError, match="module 'rigid' has no attribute 'particle'"):
        _ = rigid.particle  # type: ignore[attr-defined]
    assert rigid.free.gammas([1.0, 2.0, 2.5]).shape == (3,)
