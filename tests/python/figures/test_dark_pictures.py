"""Pictures without a dark twin are darkened by the build of the site: legible, and true."""

import runpy
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image

from rigid.drawing.colours import DARK, FAINT, HUES, SHARE_MAP

SCRIPT = Path(__file__).parents[3] / "docs" / "dark_pictures.py"


def darkened(colours: list[str]) -> Any:
    """What becomes of stripes of these colours, as rows of red, green and blue."""
    stripes = np.array([list(bytes.fromhex(colour[1:])) for colour in colours], dtype=np.uint8)
    picture = Image.fromarray(stripes[:, np.newaxis])
    return np.asarray(runpy.run_path(str(SCRIPT))["darkened"](picture))[:, 0]


def brightness(rgb: Any) -> Any:
    """Relative luminance of sRGB (WCAG 2.2)."""
    share = np.asarray(rgb) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def test_lines_keep_their_hues_and_are_legible_on_the_ground_of_dark_pages() -> None:
    inks = [*HUES.values(), FAINT]
    ground, *lines = darkened(["#ffffff"] * 50 + inks)[49:]
    assert f"#{bytes(ground.tolist()).hex()}" == DARK
    for name, ink, line in zip((*HUES, "faint"), inks, lines, strict=True):
        contrast = (brightness(line) + 0.05) / (brightness(ground) + 0.05)
        assert contrast >= 3.0, name  # of lines and large texts, WCAG 1.4.11
        given = np.array(list(bytes.fromhex(ink[1:])))
        if np.ptp(given) > 26:
            np.testing.assert_array_equal(np.argsort(line), np.argsort(given), err_msg=name)


def test_the_colours_of_a_map_stay() -> None:
    every = matplotlib.colormaps[SHARE_MAP](np.arange(256), bytes=True)[:, :3]
    shares = [f"#{bytes(colour.tolist()).hex()}" for colour in every]
    ground, *shown, ink = darkened(["#ffffff", *shares, "#000000"])
    assert brightness(ground) < 0.02
    assert brightness(ink) > 0.5
    np.testing.assert_array_equal(shown, every)
