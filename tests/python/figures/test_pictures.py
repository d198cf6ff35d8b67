"""The scripts that draw the pictures of the guides."""

import ast
import runpy
import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rigid import figures
from rigid.cli.toml_map import read_spec
from rigid.cli.toml_table import names_of
from rigid.drawing.colours import DARK_STYLE
from rigid.store.call import run_map

IMAGES = Path(__file__).parents[3] / "docs" / "images"


NAMES = (
    *("maps-steps", "reliability", "satellites", "torque-and-damping", "events"),
    *("results", "measurements", "own-bodies", "chaos", "running-maps"),
)


def script(name: str) -> dict[str, Any]:
    """The names that a script defines."""
    sys.path.insert(0, str(IMAGES))
    try:
        return runpy.run_path(str(IMAGES / f"{name}.py"))
    finally:
        sys.path.remove(str(IMAGES))


@pytest.fixture(scope="module")
def pictures() -> dict[str, Callable[[], Figure]]:
    found: dict[str, Callable[[], Figure]] = script("guides")["PICTURES"]
    return found


def test_every_picture_has_its_two_files(pictures: dict[str, Any]) -> None:
    maps = script("maps")
    assert set(maps["MAPS"]) <= set(names_of("map"))
    assert set(NAMES) == set(pictures)
    for name in (*pictures, *maps["MAPS"]):
        for suffix in ("", "-dark"):
            assert (IMAGES / f"{name}{suffix}.png").stat().st_size < 150_000, name


def grey(picture: Any) -> NDArray[np.float64]:
    """Brightness from 0 to 255, in squares of 20 pixels."""
    small = picture.convert("L").resize((picture.width // 20, picture.height // 20), 4)  # box
    return np.asarray(small, np.float64)


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_of_a_guide_is_what_the_code_of_its_page_draws(
    pictures: dict[str, Callable[[], Figure]], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The dark one: both are written at once, as the test below shows.

    Also by another Matplotlib, which may move texts and lines by a pixel. Pictures shifted by a
    pixel differ from themselves by at most 1.7.
    """
    image = pytest.importorskip("PIL.Image")
    draw: Any = pictures[name]
    if name == "running-maps":
        # An eighth of the bodies: the stored map has 256 in each pixel.
        spec = draw.__globals__["computed"]("large_maps.md", f"](images/{name}.png)")["result"].spec
        few = {"result": SimpleNamespace(spec=spec.replace(samples=32))}
        monkeypatch.setitem(draw.__globals__, "computed", lambda *_: few)
    content = BytesIO()
    with rc_context(DARK_STYLE):
        draw().savefig(content, format="png", dpi=150)
    drawn, stored = (grey(image.open(file)) for file in (content, IMAGES / f"{name}-dark.png"))
    assert drawn.shape == stored.shape
    # The stops of a stored map come when the machine is ready: only the last panel is the same.
    begin = 2 * drawn.shape[1] // 3 if name == "running-maps" else 0
    assert np.abs(drawn - stored)[:, begin:].mean() < 1.7


def test_twins_are_a_light_and_a_dark_picture(tmp_path: Path) -> None:
    def draw() -> Figure:
        return Figure(figsize=(1.0, 1.0))

    script("twins")["save_twins"]("square", draw, tmp_path)
    image = pytest.importorskip("PIL.Image")
    light, dark = (
        image.open(tmp_path / f"square{suffix}.png").convert("L").getpixel((10, 10))
        for suffix in ("", "-dark")
    )
    assert light == 255
    assert dark < 30


def test_named_regions_of_satellites_are_what_they_are_named() -> None:
    spec = read_spec("gravity-gradient").spec
    regions = script("maps")["REGIONS"]["gravity-gradient"]
    for words, x, y, _ in regions:
        share = float(run_map(spec.replace(axes={"I3/I2": [x], "I1/I2": [y]})).share.item())
        assert share == (0.0 if "unstable" in words else 1.0), words
        largest, smallest = x < 1.0 and y < 1.0, x > 1.0 and y > 1.0
        # Lagrange: pitch has the largest moment; DeBra and Delp: the least.
        assert {"Lagrange": largest, "DeBra and Delp": smallest}.get(words, True), words


GALLERY = Path(__file__).parents[3] / "docs" / "gallery"


@pytest.mark.parametrize("page", sorted(GALLERY.rglob("plot_*.py")), ids=lambda page: page.stem[5:])
def test_gallery(page: Path) -> None:
    """The page says what it shows; the build of the site draws its figure."""
    text = page.read_text(encoding="utf-8")
    title, line = str(ast.get_docstring(ast.parse(text))).splitlines()[:2]
    assert line == "=" * len(title)
    assert "plt.show()" in text
    if (name := page.stem[5:]) in figures.__all__:
        assert f"figures.{name}(" in text
