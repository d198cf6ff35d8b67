"""What holds for every test."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture(autouse=True)
def _pyplot_keeps_no_figure() -> Iterator[None]:
    """Where a test has imported pyplot, it keeps the figures of all later tests too."""
    yield
    pyplot: Any = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")
