"""The map explorer: what its page holds, its motions under Node, and its controls in a browser."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import zlib
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from browsers import Opened
from rigid import cli

NODE = shutil.which("node")

BOX = rigid.stability_map(
    rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)),
    axes={"b": np.linspace(0.02, 0.24, 7), "noise": [1e-3, 1e-2, 1e-1, 1.0]},
    start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)),
    samples=6,
    t_end=1.0,
    stable=rigid.no_flip(2),
    rng=2026,
)


def tops(**changes: Any) -> rigid.StabilityMap:
    asked: dict[str, Any] = {
        "axes": {"spin": np.linspace(3.0, 6.0, 5), "mgl": [0.6, 1.0, 1.4]},
        "samples": 4,
        "t_end": 20.0,
        "stable": rigid.tilt_below(0.5),
        "start": rigid.Start(spin=1.0, axis=3, attitude_noise=rigid.normal(1e-2)),
    } | changes
    return rigid.stability_map(
        asked.pop("scene", rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)), rng=7, **asked
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return BOX.explore(tmp_path_factory.mktemp("explorer") / "box.html")


def content(page: Path) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="map">(.*?)</script>', page.read_text())
    assert found is not None
    held: dict[str, Any] = json.loads(found[1])
    return held


def unpacked(packed: dict[str, str]) -> NDArray[Any]:
    dtype = np.dtype(packed["type"])
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), dtype=np.uint8)
    mixed = np.ascontiguousarray(planes.reshape(dtype.itemsize, -1).T)
    return mixed.reshape(-1).view(dtype)


# What the page holds


def test_a_page_holds_the_starts_and_outcomes_of_the_map_to_the_bit(page: Path) -> None:
    held = content(page)
    count = held["samples"]
    assert (count, held["of"], held["shape"]) == (6, 6, [4, 7])
    starts, outcomes = BOX.starts(range(count)), BOX.outcomes(range(count))
    assert (unpacked(held["omega"]) == starts.omega.ravel()).all()
    assert (unpacked(held["attitude"]) == starts.attitude.ravel()).all()
    words = np.array([*held["classes"], ""])[unpacked(held["outcome"])]
    assert (words == outcomes.outcome.ravel()).all()
    np.testing.assert_array_equal(unpacked(held["left"]), outcomes.left.ravel())
    layers = {layer["name"]: unpacked(layer["data"]) for layer in held["layers"]}
    np.testing.assert_array_equal(layers["share"], BOX.share.ravel().astype(np.float32))
    assert {"lower", "upper", "undecided", "failed", "earliest"} <= set(layers)


def test_a_page_needs_nothing_from_elsewhere(page: Path) -> None:
    assert not re.search(r"https?:|//[a-z]+\.|\bsrc=|\bhref=|@import|\bfetch\(", page.read_text())
    assert page.stat().st_size < 150_000


def test_a_page_has_as_many_bodies_as_are_asked_for(tmp_path: Path) -> None:
    held = content(BOX.explore(tmp_path / "a.html", samples=2))
    assert (held["samples"], len(unpacked(held["omega"]))) == (2, 28 * 2 * 3)


def test_motions_under_torques_in_space_are_not_in_the_page(tmp_path: Path) -> None:
    body = rigid.Body((1.0, 2.0, 2.5))
    pushed = rigid.FreeBody(body, torque=rigid.Torque.space((0.0, 0.0, 0.1)))
    held = content(
        tops(
            scene=pushed,
            axes={"spin": [1.0, 2.0]},
            stable=rigid.no_flip(3),
            start=rigid.Start(spin=1.0),
        ).explore(tmp_path / "a.html")
    )
    assert held["motion"] is None


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("map.png", {}, r"path = '.*map\.png': must end in \.html"),
        ("map.html", {"samples": 0}, r"samples = 0: must lie in 1 \.\. 6, as in the map"),
        ("map.html", {"samples": 7}, r"samples = 7: must lie in 1 \.\. 6, as in the map"),
    ],
)
def test_bad_input_is_refused(
    name: str, options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=message):
        BOX.explore(tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_the_command_writes_a_page_and_replaces_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = BOX.save(tmp_path / "box.npz")
    assert cli.main(["explore", str(data), "--samples", "1"]) == 0
    written = tmp_path / "box.html"
    assert content(written)["samples"] == 1
    assert cli.main(["explore", str(data)]) == 2
    assert "exists; take another name, or replace it with --force" in capsys.readouterr().err
    assert content(written)["samples"] == 1
    assert cli.main(["explore", str(data), "--force"]) == 0
    assert content(written)["samples"] == 6
    assert cli.main(["explore", str(data), "--out", str(tmp_path)]) == 2
    assert "--out: path = " in capsys.readouterr().err


# The motions of the page


def moved(*arguments: Any) -> dict[str, NDArray[np.float64]]:
    """The function ``motionOf`` of the page under Node."""
    script = resources.files("rigid.animation").joinpath("page", "motion.js").read_text()
    script += "const given = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
    script += "console.log(JSON.stringify(motionOf(...given)));"
    asked = json.dumps([np.asarray(argument).tolist() for argument in arguments])
    assert NODE is not None
    done = subprocess.run(
        [NODE, "-e", script], input=asked, capture_output=True, check=True, text=True
    )
    return {name: np.array(values) for name, values in json.loads(done.stdout).items()}


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize("kind", ["box", "top", "damped", "pushed"])
def test_motions_of_the_page_are_those_of_replay(kind: str, tmp_path: Path) -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0, damping=np.diag([0.01, 0.02, 0.03]))
    if kind == "box":
        result = BOX
    elif kind == "pushed":
        result = tops(axes={"torque3": [0.01, 0.1], "spin": [3.0, 5.0]})
    else:
        result = tops(scene=top) if kind == "damped" else tops()
    held = content(result.explore(tmp_path / "a.html"))
    numbers = unpacked(held["motion"]["numbers"]).reshape(-1, 18)
    for pixel, sample in ((0, 1), (3, 2)):
        seen = result.replay(pixel, sample)
        again = rigid.simulate(
            result.spec.grid.scene_of(pixel),
            seen.omega,
            seen.attitude,
            t=seen.run.t,
            method="taylor26",
        )
        run: Any = seen.run if seen.method == "exact" else again
        found = moved(numbers[pixel], seen.omega, seen.attitude, run.t)
        assert np.abs(found["omega"] - run.omega).max() < 1e-9
        assert np.abs(found["attitude"] - run.attitude).max() < 1e-9


# In a browser


@pytest.mark.browser
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (375, "dark")])
def test_the_explorer_works_in_a_browser(browser: Any, page: Path, width: int, scheme: str) -> None:
    opened = Opened(browser, page, width=width, height=800, scheme=scheme)
    shown = opened.page
    shown.wait_for_selector(".map[data-ready]")
    inks = "new Set(new Uint32Array(document.querySelector('.map').getContext('2d')"
    inks += ".getImageData(0, 0, 300, 200).data.buffer)).size"
    assert shown.evaluate(inks) > 10
    place = shown.locator(".map").bounding_box()
    shown.locator(".map").click(
        position={"x": 25.0 + 0.5 * place["width"], "y": 0.4 * place["height"]}
    )
    shown.wait_for_selector("canvas.stage")
    first = shown.evaluate("location.hash")
    assert re.fullmatch(r"#layer=share&pixel=2,3&sample=\d", first)
    line = shown.locator(".python").text_content()
    assert re.fullmatch(r"result\.replay\(pixel=\(2, 3\), sample=\d\)", line)
    assert shown.locator(".dots button").count() == 6
    opened.press("n")
    assert shown.evaluate("location.hash") != first
    opened.press("p")
    assert shown.evaluate("location.hash") == first
    # The film runs, and its canvas is not blank.
    frame = "explorer.player.frame"
    shown.evaluate("explorer.player.play(true)")
    shown.wait_for_function(f"{frame} > 3")
    shown.evaluate("explorer.player.play(false)")
    stage = opened.pixels("canvas.stage")
    assert len(np.unique(stage.reshape(-1, 3), axis=0)) > 200
    assert len(stage) > 100
    assert shown.evaluate("document.documentElement.scrollWidth") <= width
    opened.close()


@pytest.mark.browser
def test_the_address_restores_the_view(browser: Any, page: Path) -> None:
    opened = Opened(browser, page, address="#layer=upper&pixel=1,2&sample=3")
    opened.page.wait_for_selector("canvas.stage")
    assert opened.page.locator(".python").text_content() == "result.replay(pixel=(1, 2), sample=3)"
    assert opened.page.locator("select.layer").input_value() == "upper"
    opened.close()
