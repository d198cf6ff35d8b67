"""Odd arguments and damaged files: refused in words, or a result that is one. Some of many.

``tests/long/fuzz.py`` takes 20 000 of each kind.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz_targets import TARGETS
from processes import run_python

SCRIPT = Path(__file__).parents[2] / "long" / "fuzz.py"


@pytest.mark.parametrize("target", TARGETS)
def test_whatever_comes_in_is_refused_or_understood(target: str) -> None:
    done = run_python(str(SCRIPT), "--target", target, "--cases", "150", check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    _, _, accepted, refused, _, _ = done.stdout.splitlines()[1].split()
    assert int(accepted) > int(refused) > 0  # most cases get past the door
