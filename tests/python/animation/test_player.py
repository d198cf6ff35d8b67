"""The player in a browser: what it draws, its keys, and small screens."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from browsers import Opened

pytestmark = pytest.mark.browser

BOX = rigid.simulate(
    rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.04, mass=0.3)),
    [0.05, 5.0, 0.05],
    t=np.linspace(0.0, 4.0, 201),
)
TOPS = rigid.simulate(
    rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
    [[0.0, 0.0, 5.0], [0.0, 0.1, 5.0]],
    [np.cos(0.3), np.sin(0.3), 0.0, 0.0],
    t=np.linspace(0.0, 10.0, 201),
)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(
    ("run", "options"),
    [
        (BOX, {}),
        (BOX, {"view": "poinsot"}),
        (TOPS, {"body": 0}),
        (TOPS, {"body": [0, 1]}),
    ],
)
def test_a_film_is_drawn(
    run: Any, options: dict[str, Any], scheme: str, browser: Any, tmp_path: Path
) -> None:
    opened = Opened(
        browser, run.animate(tmp_path / "film.html", **options), width=900, scheme=scheme
    )
    stages = "player.stages.map(stage => stage.painter.name)"
    assert set(opened.page.evaluate(stages)) == {"WebGL2"}
    pixels = opened.pixels(".holder")
    paper = pixels[2, 2]
    assert (paper.mean() > 200) == (scheme == "light")
    drawn = np.abs(pixels - paper).max(axis=-1) > 40
    assert 0.02 < drawn.mean() < 0.7
    opened.press("End")
    assert (np.abs(opened.pixels(".holder") - pixels).max(axis=-1) > 40).mean() > 0.002
    opened.close()


def test_the_clock_shows_the_frame_that_is_due(browser: Any, tmp_path: Path) -> None:
    opened = Opened(browser, BOX.animate(tmp_path / "film.html"), width=900, scheme="light")
    # Two ticks of a clock of our own, 1.05 s apart: frames are 0.02 s apart.
    frame = opened.page.evaluate(
        "() => { player.play(true); player.last = 0; player.tick(1050); return player.frame; }"
    )
    assert frame == 52
    part = opened.page.evaluate("placed(player.films[0], player.films[0].parts[0], 52)")
    points = opened.page.evaluate("player.films[0].parts[0].points")
    meant = BOX.rotation()[52].apply(np.reshape(points, (-1, 3)))
    np.testing.assert_allclose(np.reshape(part, (-1, 3)), meant, atol=1e-12)
    opened.close()


def test_keys_move_the_film(browser: Any, tmp_path: Path) -> None:
    opened = Opened(browser, BOX.animate(tmp_path / "film.html"), width=900, scheme="light")
    state = opened.page.evaluate
    assert state("player.playing") is False  # the reader wants less motion
    opened.press("Space")
    assert state("player.playing") is True
    opened.press("Space")
    assert state("player.playing") is False
    opened.press("Home")
    for key, frame in [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 200)]:
        opened.press(key)
        assert state("player.frame") == frame
    clock = opened.page.locator("output")
    assert clock.inner_text() == "t = 4.00 s"
    for key, speed in [("+", 2), ("-", 1), ("-", 0.5)]:
        opened.press(key)
        assert state("player.speed") == speed
        assert float(opened.page.locator("select").input_value()) == speed
    for _ in range(2):
        hidden = state("document.querySelector('.keys').hidden")
        opened.press("h")
        assert state("document.querySelector('.keys').hidden") is not hidden
    first = state("[player.camera.azimuth, player.camera.elevation]")
    stage = opened.page.locator(".stage").bounding_box()
    x, y = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2
    opened.page.mouse.move(x, y)
    opened.page.mouse.down()
    opened.page.mouse.move(x + 60, y + 20)
    opened.page.mouse.up()
    assert state("[player.camera.azimuth, player.camera.elevation]") != first
    opened.press("r")
    assert state("[player.camera.azimuth, player.camera.elevation]") == first
    opened.close()


@pytest.mark.parametrize("width", [320, 375])
@pytest.mark.parametrize(("run", "body"), [(BOX, None), (TOPS, [0, 1])])
def test_nothing_is_cut_off_on_a_small_screen(
    run: Any, body: Any, width: int, browser: Any, tmp_path: Path
) -> None:
    opened = Opened(
        browser, run.animate(tmp_path / "film.html", body=body), width=width, scheme="light"
    )
    assert opened.page.evaluate("document.documentElement.scrollWidth") <= width
    for one in opened.page.locator("h1, canvas, footer *:not(option)").all():
        if one.is_visible():
            place = one.bounding_box()
            assert place["x"] >= 0
            assert place["x"] + place["width"] <= width
            assert place["y"] + place["height"] <= 720
    opened.close()
