"""The pages of the gallery."""

from __future__ import annotations

import runpy
from io import BytesIO
from pathlib import Path

import pytest

from rigid import figures

GALLERY = Path(__file__).parents[3] / "docs" / "gallery"


@pytest.mark.parametrize("page", sorted(GALLERY.rglob("plot_*.py")), ids=lambda page: page.stem[5:])
def test_gallery(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page draws its figure, says what it shows, and leaves nothing open."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    shown: list[int] = []
    monkeypatch.setattr(plt, "show", lambda: shown.extend(plt.get_fignums()))
    names = runpy.run_path(str(page))
    for number in set(shown):
        plt.figure(number).savefig(BytesIO(), format="png", dpi=40)
    plt.close("all")
    assert len(shown) >= 1
    title, line = str(names["__doc__"]).splitlines()[:2]
    assert line == "=" * len(title)
    if (name := page.stem[5:]) in figures.__all__:
        assert f"figures.{name}(" in page.read_text(encoding="utf-8")
