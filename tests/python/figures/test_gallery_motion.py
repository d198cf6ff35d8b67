"""The pages of the gallery that show motions."""

from __future__ import annotations

import runpy
from io import BytesIO
from pathlib import Path

import pytest

GALLERY = Path(__file__).parents[3] / "docs" / "gallery"


# The gallery


@pytest.mark.parametrize(
    "name",
    [
        "chaotic_com",
        "chaotic_top",
        "cubic",
        "cycloids",
        "effective_potential",
        "invariants",
        "locus",
        "poinsot",
        "polhodes",
        "sections",
        "separatrix_web",
        "stability_map",
        "throw",
        "upright_cubic",
        "work_precision",
    ],
)
def test_gallery(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page draws its figure, says what it shows, and leaves nothing open."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    shown: list[int] = []
    monkeypatch.setattr(plt, "show", lambda: shown.extend(plt.get_fignums()))
    (page,) = GALLERY.rglob(f"plot_{name}.py")
    names = runpy.run_path(str(page))
    for number in set(shown):
        plt.figure(number).savefig(BytesIO(), format="png", dpi=40)
    plt.close("all")
    assert len(shown) >= 1
    title, line = str(names["__doc__"]).splitlines()[:2]
    assert line == "=" * len(title)
