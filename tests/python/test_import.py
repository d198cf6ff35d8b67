"""`import rigid` needs NumPy and nothing else, and hardly any time."""

from __future__ import annotations

import subprocess
import sys

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
