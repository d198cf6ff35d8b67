"""The player in a browser: what it draws, its keys, and small screens."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import rigid

pytestmark = pytest.mark.browser

BOX = rigid.simulate(
    rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.04, mass=0.3)),
    [0.05, 5.0, 0.05],
    t=np.linspace(0.0, 4.0, 201),
)
BOXES = rigid.simulate(
    rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.04, mass=0.3)),
    [[0.05, 5.0, 0.05], [0.001, 5.0, 0.05]],
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
    run: Any, options: dict[str, Any], scheme: str, opens: Any, tmp_path: Path
) -> None:
    opened = opens(run.animate(tmp_path / "film.html", **options), width=900, scheme=scheme)
    stages = "player.stages.map(stage => stage.painter.name)"
    assert set(opened.evaluate(stages)) == {"WebGL2"}
    pixels = opened.pixels(".holder")
    paper = pixels[2, 2]
    assert (paper.mean() > 200) == (scheme == "light")
    drawn = np.abs(pixels - paper).max(axis=-1) > 40
    assert 0.02 < drawn.mean() < 0.7
    opened.press("End")
    assert (np.abs(opened.pixels(".holder") - pixels).max(axis=-1) > 40).mean() > 0.002


def test_the_clock_shows_the_frame_that_is_due(opens: Any, tmp_path: Path) -> None:
    opened = opens(BOX.animate(tmp_path / "film.html"), width=900, scheme="light")
    # Two ticks of a clock of our own, 1.05 s apart: frames are 0.02 s apart.
    frame = opened.evaluate(
        "() => { player.play(true); player.last = 0; player.tick(1050); return player.frame; }"
    )
    assert frame == 52
    part = opened.evaluate("placed(player.films[0], player.films[0].parts[0], 52)")
    points = opened.evaluate("player.films[0].parts[0].points")
    meant = BOX.rotation()[52].apply(np.reshape(points, (-1, 3)))
    np.testing.assert_allclose(np.reshape(part, (-1, 3)), meant, atol=1e-12)


def test_keys_move_the_film(opens: Any, tmp_path: Path) -> None:
    opened = opens(BOX.animate(tmp_path / "film.html"), width=900, scheme="light")
    state = opened.evaluate
    assert state("player.playing") is False  # the reader wants less motion
    opened.press("Space")
    assert state("player.playing") is True
    opened.press("Space")
    assert state("player.playing") is False
    opened.press("Home")
    for key, frame in [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 200)]:
        opened.press(key)
        assert state("player.frame") == frame
    clock = opened.locator("output")
    assert clock.inner_text() == "t = 4.00 s"
    for key, speed in [("+", 2), ("-", 1), ("-", 0.5)]:
        opened.press(key)
        assert state("player.speed") == speed
        assert float(opened.locator("select").input_value()) == speed
    for _ in range(2):
        hidden = state("document.querySelector('.keys').hidden")
        opened.press("h")
        assert state("document.querySelector('.keys').hidden") is not hidden
    first = state("[player.camera.azimuth, player.camera.elevation]")
    stage = opened.locator(".stage").bounding_box()
    x, y = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2
    opened.mouse.move(x, y)
    opened.mouse.down()
    opened.mouse.move(x + 60, y + 20)
    opened.mouse.up()
    assert state("[player.camera.azimuth, player.camera.elevation]") != first
    opened.press("r")
    assert state("[player.camera.azimuth, player.camera.elevation]") == first


@pytest.mark.parametrize("width", [320, 375])
@pytest.mark.parametrize(("run", "body"), [(BOX, None), (TOPS, [0, 1])])
def test_nothing_is_cut_off_on_a_small_screen(
    run: Any, body: Any, width: int, opens: Any, tmp_path: Path
) -> None:
    opened = opens(run.animate(tmp_path / "film.html", body=body), width=width, scheme="light")
    assert opened.evaluate("document.documentElement.scrollWidth") <= width
    for one in opened.locator("h1, canvas, footer *:not(option)").all():
        if one.is_visible():
            place = one.bounding_box()
            assert place["x"] >= 0
            assert place["x"] + place["width"] <= width
            assert place["y"] + place["height"] <= 720


FRAME = """<!doctype html><meta name="viewport" content="width=device-width">
<style>body { margin: 0 } iframe { width: 100%; aspect-ratio: 16 / 10; min-height: 22rem }
iframe { border: 0 }</style><iframe src="film.html"></iframe>"""
"""A page of the site, as it shows a film."""


@pytest.mark.parametrize("width", [320, 375, 480, 768])
@pytest.mark.parametrize("run", [BOX, BOXES, TOPS])
def test_the_motion_is_seen_in_a_page_of_the_site(
    run: Any, width: int, opens: Any, tmp_path: Path
) -> None:
    run.animate(tmp_path / "film.html")
    (tmp_path / "page.html").write_text(FRAME, encoding="utf-8")
    opened = opens(tmp_path / "page.html", width=width, height=700)
    frame = opened.frames[1]
    frame.wait_for_function("player.stages.length > 0 && player.shown")
    least = 150 if len(run.omega.shape) == 3 else 200
    for stage in frame.locator("canvas.stage").all():
        place = stage.bounding_box()
        assert place["height"] >= 200
        assert place["width"] >= least
    whole = opened.locator("iframe").bounding_box()
    controls = frame.locator("footer").bounding_box()
    assert controls["y"] + controls["height"] <= whole["y"] + whole["height"]
    assert frame.locator(".play").is_visible()
    assert frame.evaluate("document.documentElement.scrollWidth") <= width
    assert frame.locator(".strip").first.is_visible() == (width == 768)
    # Every line of the story is above the motion, and the motion is not one colour.
    story, stages = (frame.locator(name).bounding_box() for name in ("h1", ".stages"))
    assert story["y"] + story["height"] <= stages["y"]
    picture = opened.screenshot(clip=frame.locator(".stages").bounding_box())
    pixels = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=int)
    assert (np.abs(pixels - pixels[2, 2]).max(axis=-1) > 40).mean() > 0.01


def test_the_film_follows_the_theme_of_its_page(opens: Any, tmp_path: Path) -> None:
    BOX.animate(tmp_path / "film.html")
    (tmp_path / "page.html").write_text(FRAME, encoding="utf-8")
    opened = opens(tmp_path / "page.html", width=768, scheme="light")
    frame = opened.frames[1]
    frame.wait_for_function("player.stages.length > 0 && player.shown")

    def light() -> tuple[bool, bool]:
        """Whether the paper of the page is light, and the text of the chart dark."""
        opened.settle()
        opened.settle()
        png = frame.locator(".strip").screenshot()
        text = np.asarray(Image.open(io.BytesIO(png)).convert("L"), dtype=int)[4:16, 6:46]
        paper = opened.pixels("iframe")[60, 5].mean()
        return bool(paper > 200), bool(paper - text.min() > text.max() - paper)

    def send(message: str) -> tuple[bool, bool]:
        opened.evaluate(f"frames[0].postMessage({message}, '*')")
        return light()

    assert light() == (True, True)
    assert send("{rigidTheme: 'dark'}") == (False, False)
    for other in ("{rigidTheme: 'blue'}", "'light'", "null", "{theme: 'light'}", "{rigidTheme: 1}"):
        assert send(other) == (False, False)
    assert send("{rigidTheme: 'light'}") == (True, True)
    # The page decides, once it has spoken.
    opened.emulate_media(color_scheme="dark")
    assert light() == (True, True)


def test_a_film_alone_follows_the_system(opens: Any, tmp_path: Path) -> None:
    opened = opens(BOX.animate(tmp_path / "film.html"), width=900, scheme="light")
    assert opened.pixels(".holder")[2, 2].mean() > 200
    opened.emulate_media(color_scheme="dark")
    opened.settle()
    assert opened.pixels(".holder")[2, 2].mean() < 60


@pytest.mark.parametrize(("run", "view"), [(BOX, None), (BOX, "poinsot"), (BOXES, None)])
def test_labels_do_not_lie_on_one_another(
    run: Any, view: str | None, opens: Any, tmp_path: Path
) -> None:
    opened = opens(run.animate(tmp_path / "film.html", view=view), width=900)
    overlaps = opened.evaluate(
        """() => {
          let found = 0;
          for (let frame = 0; frame <= 200; frame += 2) for (const stage of player.stages) {
            stage.draw(frame);
            const near = (a, b, at, size, share) =>
              Math.abs(a[at] - b[at]) < share * (a[size] + b[size]);
            // A letter has about 0.7 of the height of its line.
            stage.names.forEach((a, i) => stage.names.slice(i + 1).forEach(b => {
              if (near(a, b, "left", "wide", 0.9) && near(a, b, "top", "high", 0.7)) found++;
            }));
          }
          return found;
        }"""
    )
    assert overlaps == 0


def test_the_shadow_of_a_top_lies_under_it(opens: Any, tmp_path: Path) -> None:
    opened = opens(TOPS.animate(tmp_path / "film.html", body=0), width=900)

    def seen(grounded: str) -> Any:
        opened.evaluate(f"player.films[0].grounded = {grounded}; player.stale = true")
        opened.settle()
        return opened.pixels(".holder").mean(axis=-1)

    drawn = "player.films[0].grounded"
    assert opened.evaluate(drawn) is True
    darker = seen("false") - seen("true")
    # The ground darkens white by at most a fifth, its middle most; the shadow by up to a half more.
    assert 40.0 < darker.max() < 180.0
    assert (darker > 60.0).mean() < 0.1
    rows = np.flatnonzero((darker > 60.0).any(axis=1))
    at = opened.evaluate("player.stages[0].names[0].top")
    assert rows.min() > at  # all below the label of the vertical


def test_the_legend_says_what_is_drawn(opens: Any, tmp_path: Path) -> None:
    opened = opens(BOX.animate(tmp_path / "film.html"), width=900)
    words = opened.locator(".meanings").text_content()
    assert "1, 2, 3 principal axes" in words
    for one in ("— path of ω", "ω angular velocity", "L angular momentum"):
        assert one in words
    assert opened.locator("h1").text_content() == (
        "A box spins at 5 rad/s about its middle axis, and turns over once in 4 s."
    )


def test_a_picture_and_a_video_are_saved(opens: Any, tmp_path: Path) -> None:
    opened = opens(BOXES.animate(tmp_path / "film.html", speed=2.0), width=900)
    opened.evaluate("player.seek(100)")
    opened.settle()
    with opened.expect_download() as download:
        opened.locator(".picture").click()
    assert download.value.suggested_filename == "film.png"
    download.value.save_as(tmp_path / "film.png")
    with Image.open(tmp_path / "film.png") as image:
        pixels = np.asarray(image.convert("RGB"), dtype=int)
    footer = opened.locator("footer").bounding_box()
    assert abs(len(pixels) - footer["y"]) <= 2
    # It is what the page shows, but for the clock and the edges of letters.
    page = np.asarray(Image.open(io.BytesIO(opened.screenshot())).convert("RGB"), dtype=int)
    rows = min(len(pixels), int(footer["y"]))
    differ = np.abs(pixels[:rows] - page[:rows]).max(axis=-1) > 60
    assert differ.mean() < 0.02
    story = slice(4, int(opened.locator("h1").bounding_box()["height"]) + 4)
    assert ((pixels[story] < 120).all(axis=-1)).sum() > 0.7 * (page[story] < 120).all(axis=-1).sum()
    with opened.expect_download(timeout=60_000) as download:
        opened.locator(".video").click()
    assert download.value.suggested_filename in ("film.webm", "film.mp4")
    download.value.save_as(tmp_path / "film.video")
    assert (tmp_path / "film.video").stat().st_size > 1000  # more than the header
    assert opened.locator(".video").get_attribute("aria-pressed") == "false"
