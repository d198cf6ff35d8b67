"""Colours of pictures: legible on light and on dark ground, and in one table."""

import re
import runpy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from PIL import Image

from rigid.drawing.colours import DARK, FAINT, HUES, SHARE_MAP

pytest.importorskip("matplotlib")

import matplotlib.style
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

import rigid
from rigid.drawing import colours
from rigid.drawing.colours import DARK_STYLE, on_ground
from rigid.reports.plot import COLOURS, OTHERS

SOURCES = Path(rigid.__file__).parent

LINE, TEXT = 3.0, 4.5
"""Least contrasts of lines and of texts: WCAG 2.2, 1.4.11 and 1.4.3 (AA)."""

LINES = [*colours.HUES.values(), colours.NEUTRAL, colours.AMBER, colours.FAINT]
TEXTS = [*colours.HUES.values(), colours.NEUTRAL]
BACKGROUND = (colours.PALE, colours.GRID, colours.BAND)
"""What only stands behind the lines that matter."""


def luminance(colour: Any) -> float:
    """The relative luminance of WCAG."""
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: Any, other: Any) -> float:
    """The contrast of WCAG, from 1 to 21."""
    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


def papers() -> list[str]:
    """The grounds of the pages of films, light and dark."""
    css = (SOURCES / "animation" / "page" / "film.css").read_text(encoding="utf-8")
    found = re.findall(r"--paper:\s*(#[0-9a-fA-F]{3,6})\b", css)
    assert len(found) >= 2
    return found


def test_contrast_of_known_greys() -> None:
    assert contrast("black", "white") == pytest.approx(21.0)
    # The lightest grey that is legible on white, by every checker of contrasts.
    assert contrast("#767676", "white") == pytest.approx(4.54, abs=0.005)


@pytest.mark.parametrize(("least", "inks"), [(LINE, LINES), (TEXT, TEXTS)], ids=["lines", "texts"])
def test_contrast_on_light_and_on_dark_ground(least: float, inks: list[str]) -> None:
    figure = Figure()
    ax = figure.add_subplot()
    for ground in ("#ffffff", "#000000", colours.DARK, *papers()):
        ax.set_facecolor(ground)
        for ink in inks:
            assert contrast(on_ground(ax, ink), ground) >= least, (ink, ground)


def test_every_ink_and_every_family_has_a_colour_of_the_table() -> None:
    inks = [one.colour for one in vars(colours).values() if isinstance(one, colours.Ink)]
    families = [*COLOURS.values(), OTHERS]
    assert len(set(families)) == len(families)
    for colour in [*inks, *families]:
        assert colour in TEXTS
    assert set(colours.CLASSES.values()) <= set(LINES)


def test_no_module_has_a_colour_of_its_own() -> None:
    table = SOURCES / "drawing" / "colours.py"
    for source in SOURCES.rglob("*.py"):
        if source != table:
            assert not re.findall(r"[\"']#[0-9a-fA-F]{6}[\"']", source.read_text("utf-8")), source


def test_the_page_of_maps_has_the_colour_map_of_pictures() -> None:
    script = (SOURCES / "animation" / "page" / "map.js").read_text(encoding="utf-8")
    listed: Any = re.search(r"CIVIDIS = \[(.*?)\]", script)
    stops = re.findall(r"#[0-9a-f]{6}", listed.group(1))
    shades = matplotlib.colormaps[colours.SHARE_MAP](np.linspace(0.0, 1.0, len(stops)))
    for stop, shade in zip(stops, shades, strict=True):
        # Both round to 1/255, and the colour map has only 256 colours: two units.
        np.testing.assert_allclose(matplotlib.colors.to_rgb(stop), shade[:3], atol=2.01 / 255.0)
    assert stops[0] == colours.UNSTABLE
    assert stops[-1] == colours.STABLE


def test_the_pages_of_films_have_the_colours_of_dark_pictures() -> None:
    script = (SOURCES / "animation" / "page" / "vectors.js").read_text(encoding="utf-8")
    table: Any = re.search(r"ON_DARK = \{(.*?)\}", script, re.DOTALL)
    found = dict(re.findall(r'"(#[0-9a-f]{6})": "(#[0-9a-f]{6})"', table.group(1)))
    ax = Figure(facecolor=colours.DARK).add_subplot(facecolor=colours.DARK)
    listed = [*colours.HUES.values(), colours.NEUTRAL, colours.FAINT]
    assert found == {ink: on_ground(ax, ink) for ink in listed}


TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
LEANING = [0.9, 0.3, 0.2, 0.1]


def drawn_run() -> Any:
    return rigid.simulate(TOP, [0.3, 0.4, 1.0], LEANING, t=np.linspace(0.0, 5.0, 51)).plot()


def drawn_growth() -> Any:
    t = np.linspace(1.0, 20.0, 20)
    return rigid.lyapunov(TOP, [0.3, 0.4, 1.0], LEANING, t=t).plot("mean_megno")


@cache
def report() -> rigid.Report:
    box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    methods = ["exact", "rk4", "taylor12", "splitting4"]
    return rigid.report(
        box, omega=[1.0, 1.0, 1.0], t_end=2.0, methods=methods, bodies=4, seconds=0.3
    )


def drawn_report() -> Any:
    return report().plot()


def drawn_map() -> Any:
    return rigid.stability_map(
        TOP,
        axes={"spin": np.linspace(0.5, 6.0, 8), "tilt": np.linspace(0.1, 3.0, 8)},
        start=rigid.Start(spin=0.0),
        stable=rigid.regular(),
        t_end=50.0,
        samples=1,
        rng=2026,
    ).plot()


def drawn_frame() -> Any:
    return rigid.figures.node_frame([0.9, 0.7, 0.8]).plot()


def drawn_cubic() -> Any:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    return rigid.figures.upright_cubic(top, [1.0, 2.0, 3.0]).plot()[0]


@contextmanager
def ground_of_pictures(name: str) -> Iterator[None]:
    if name == "light":
        with matplotlib.rc_context():
            yield
    elif name == "dark pictures":
        with matplotlib.rc_context(DARK_STYLE):
            yield
    else:
        with matplotlib.style.context(name):
            yield


@pytest.mark.parametrize("name", ["light", "dark pictures", "dark_background"])
@pytest.mark.parametrize(
    "draw", [drawn_run, drawn_growth, drawn_report, drawn_map, drawn_frame, drawn_cubic]
)
def test_texts_and_lines_are_legible_in_every_style(draw: Callable[[], Any], name: str) -> None:
    with ground_of_pictures(name):
        ax = draw()
        figure = ax.figure
        ground = colours.ground(figure)
        assert colours.is_dark(figure) is (name != "light")
        figure.draw_without_rendering()
        behind = {to_hex(on_ground(ax, colour)) for colour in BACKGROUND}
    seen = 0
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text():
            seen += 1
            assert contrast(text.get_color(), ground) >= TEXT, text
    for line in figure.findobj(Line2D):
        if line.get_visible() and to_hex(line.get_color()) not in behind:
            assert contrast(line.get_color(), ground) >= LINE, line
    assert seen > 3


def to_hex(colour: Any) -> str:
    found: str = matplotlib.colors.to_hex(colour)
    return found


# Pictures without a dark twin are darkened by the build of the site: legible, and true


SCRIPT = Path(__file__).parents[3] / "docs" / "dark_pictures.py"


def darkened(colours: list[str]) -> Any:
    """What becomes of stripes of these colours, as rows of red, green and blue."""
    stripes = np.array([list(bytes.fromhex(colour[1:])) for colour in colours], dtype=np.uint8)
    picture = Image.fromarray(stripes[:, np.newaxis])
    return np.asarray(runpy.run_path(str(SCRIPT))["darkened"](picture))[:, 0]


def test_lines_keep_their_hues_and_are_legible_on_the_ground_of_dark_pages() -> None:
    inks = [*HUES.values(), FAINT]
    ground, *lines = darkened(["#ffffff"] * 50 + inks)[49:]
    assert f"#{bytes(ground.tolist()).hex()}" == DARK
    for name, ink, line in zip((*HUES, "faint"), inks, lines, strict=True):
        assert contrast(line / 255.0, ground / 255.0) >= LINE, name
        given = np.array(list(bytes.fromhex(ink[1:])))
        if np.ptp(given) > 26:
            np.testing.assert_array_equal(np.argsort(line), np.argsort(given), err_msg=name)


def test_the_colours_of_a_map_stay() -> None:
    every = matplotlib.colormaps[SHARE_MAP](np.arange(256), bytes=True)[:, :3]
    shares = [f"#{bytes(colour.tolist()).hex()}" for colour in every]
    ground, *shown, ink = darkened(["#ffffff", *shares, "#000000"])
    assert luminance(ground / 255.0) < 0.02
    assert luminance(ink / 255.0) > 0.5
    np.testing.assert_array_equal(shown, every)
