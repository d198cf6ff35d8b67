"""Animations show the states of a run and nothing else."""

import html
import json
import re
import shutil
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import rigid
from films import ASYMMETRIC, BOX, OBLATE, PROLATE, TILTED, TOP, T, film_of, part, run_of
from processes import PATIENCE, python_process
from refusals import refuses
from rigid import top
from rigid.animation import Animation
from rigid.animation.film import PLANET, Part, side_by_side
from rigid.animation.raster import (
    Buffer,
    Camera,
    _from_segment,
    corner_normals,
    frame_picture,
    label_places,
)
from rigid.animation.web import film_page
from rigid.drawing.shapes import STEM, ellipsoid_faces
from rigid.solve.recording import turns_over


def data_in(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="film">(.*?)</script>', page)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data["films"][0]  # type: ignore[no-any-return]


# The page


@pytest.mark.parametrize(
    ("scene", "view"),
    [(BOX, "box"), (OBLATE, "cones"), (ASYMMETRIC, "poinsot"), (TOP, "top"), (BOX, "poinsot")],
)
def test_a_page_holds_the_states_of_the_run_to_the_bit(
    scene: Any, view: str, tmp_path: Path
) -> None:
    run = run_of(scene)
    path = run.animate(tmp_path / "motion.html", view=view, speed=2.0)
    assert path == tmp_path / "motion.html"
    data = data_in(path.read_text(encoding="utf-8"))
    np.testing.assert_array_equal(data["attitude"], run.attitude)
    # Times with six decimals, and seven digits of what a frame is shown: the picture needs no more.
    np.testing.assert_allclose(data["t"], run.t, atol=5e-7)
    np.testing.assert_allclose(data["shown"], 0.05, rtol=1e-7)
    assert max(len(repr(value)) for value in (*data["t"], *data["shown"])) <= 9
    assert data["view"] == view
    film = film_of(run, view=view)
    assert [one["kind"] for one in data["parts"]] == [one.kind for one in film.parts]
    for drawn, meant in zip(data["parts"], film.parts, strict=True):
        np.testing.assert_allclose(drawn["points"], meant.points, atol=5.1e-6)


def test_a_page_needs_nothing_from_elsewhere(tmp_path: Path) -> None:
    page = run_of(TOP).animate(tmp_path / "top.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    for word in ("http", "src=", "href=", "url(", "@import", "import(", "fetch", "{{"):
        assert word not in page, word
    assert page.count("</script>") == 2


def test_a_page_is_written_without_matplotlib(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = sys.modules['matplotlib.figure'] = None\n"
        "import rigid\n"
        "run = rigid.simulate(rigid.FreeBody(rigid.Body((1, 2, 2.5))), [1, 1, 1], t=[0, 1])\n"
        f"run.animate({str(tmp_path / 'x.html')!r})\n"
        "try:\n"
        f"    run.animate({str(tmp_path / 'x.gif')!r})\n"
        "except ImportError as error:\n"
        "    print(error)\n"
    )
    said = python_process(code).stdout.strip()
    assert said == "plotting needs matplotlib: pip install 'rigid-rotation[maps]'"


TURNED = """
const fs = require("fs"), page = fs.readFileSync(process.argv[1], "utf8");
const json = page.match(/id="film">(.*?)<\\/script>/s)[1];
const code = page.match(/<script>(.*?)<\\/script>/s)[1].split("// The page of a film.")[0];
const {placed} = new Function(code + "; return {placed};")();
const [film] = JSON.parse(json).films;
console.log(JSON.stringify(film.parts.map(part => placed(film, part, 7))));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="a JavaScript engine is needed")
@pytest.mark.parametrize("scene", [BOX, OBLATE, ASYMMETRIC, TOP])
def test_the_page_turns_its_parts_as_the_body_is(scene: Any, tmp_path: Path) -> None:
    run = run_of(scene)
    page = run.animate(tmp_path / "box.html", trail=0.31)
    done = subprocess.run(
        ["node", "-e", TURNED, str(page)],
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE,
    )
    film = film_of(run, trail=0.31)
    for seen, meant in zip(json.loads(done.stdout), film.parts, strict=True):
        points = meant.points
        if meant.kind == "trail":
            points = points[4:8]  # 0.3 s
        elif meant.kind in ("arrow", "dot") and len(points) > 1:
            points = points[7:8]
        if meant.carried:
            turn = Rotation.from_quat(run.attitude[7], scalar_first=True)
            points = turn.apply(points.reshape(-1, 3)).reshape(points.shape)
        np.testing.assert_allclose(seen, points, atol=2e-5)


def test_a_notebook_shows_a_film_without_a_file() -> None:
    film = run_of(TOP).animate()
    assert isinstance(film, Animation)
    assert re.fullmatch(r"Animation\(page of \d+ kB\)", repr(film))
    shown = film._repr_html_()
    inside = re.search(r'<iframe srcdoc="([^"]*)"', shown)
    assert inside
    assert html.unescape(inside[1]) == film.page
    np.testing.assert_array_equal(data_in(film.page)["attitude"], run_of(TOP).attitude)


def test_a_title_cannot_end_the_data_of_a_page() -> None:
    film = replace(film_of(run_of(TOP)), title="</script><b>")
    page = film_page([film])
    assert page.count("</script>") == 2
    assert data_in(page)["title"] == "</script><b>"


def test_two_bodies_are_side_by_side(tmp_path: Path) -> None:
    twins = run_of(TOP, [[0.0, 0.0, 5.0], [0.0, 0.1, 5.0]], TILTED)
    page = twins.animate(body=[0, 1]).page
    found = re.search(r'id="film">(.*?)</script>', page)
    assert found
    films = json.loads(found[1])["films"]
    for k in range(2):
        np.testing.assert_array_equal(films[k]["attitude"], twins.attitude[k])
    assert twins.animate().page == page  # both bodies of two need no asking
    films_of_both = side_by_side([film_of(twins, body=k) for k in (0, 1)])
    left, right = (frame_picture(film, len(T) - 1, 100)[0].astype(int) for film in films_of_both)
    assert np.abs(left - right).max() > 150  # bodies that changed places would be seen
    with Image.open(twins.animate(tmp_path / "both.gif", body=[0, 1], size=100)) as image:
        assert image.size == (200, 100)
        image.seek(image.n_frames - 1)  # type: ignore[attr-defined]
        seen = np.asarray(image.convert("RGB"), dtype=int)
    # Between the names above and the clock below; a palette of 256 colours is near.
    for half, drawn in ((seen[:, :100], left), (seen[:, 100:], right)):
        np.testing.assert_allclose(half[20:85], drawn[20:85], atol=60)


def test_films_side_by_side_have_one_scale() -> None:
    # The second top falls below the horizon: it needs more room, and no ground is under it.
    leaning = [np.cos(0.3), np.sin(0.3), 0.0, 0.0]
    twins = run_of(TOP, [[0.0, 0.0, 9.0], [0.0, 0.1, 0.5]], leaning, t=np.linspace(0.0, 6.0, 61))
    alone = [film_of(twins, body=k) for k in (0, 1)]
    assert [film.grounded for film in alone] == [True, False]
    assert alone[0].reach < 0.9 * alone[1].reach
    films = side_by_side(alone)
    assert films[0].reach == films[1].reach
    np.testing.assert_array_equal(films[0].centre, films[1].centre)
    for film in films:
        assert not film.grounded
        for k in range(0, 61, 3):
            for one in film.parts:
                far = np.linalg.norm(one.placed(film.attitude[k], k) - film.centre, axis=-1)
                assert far.max() < 1.05 * film.reach


# The chart


def test_the_chart_beside_a_top_is_its_tilt() -> None:
    run = run_of(TOP, (0.0, 0.0, 5.0), TILTED)
    axis = run.rotation().apply([0.0, 0.0, 1.0])
    chart = film_of(run).chart
    np.testing.assert_allclose(chart.values[0], np.rad2deg(np.arccos(axis[:, 2])), rtol=1e-12)
    np.testing.assert_array_equal(film_of(run_of(BOX)).chart.values, run_of(BOX).omega.T)


def test_the_separatrix_has_the_energy_of_the_middle_axis() -> None:
    polhode: Any = film_of(run_of(ASYMMETRIC)).polhode
    moments = np.array(ASYMMETRIC.body.moments)
    assert len(polhode.separatrix) == 2
    for circle in polhode.separatrix:
        np.testing.assert_allclose(np.linalg.norm(circle, axis=1), 1.0, rtol=1e-14)
        np.testing.assert_allclose((circle**2 / moments).sum(axis=1), 1.0 / moments[1], rtol=1e-14)
    np.testing.assert_allclose(np.ptp((polhode.points**2 / moments).sum(axis=1)), 0.0, atol=1e-13)
    assert film_of(run_of(OBLATE)).polhode.separatrix == ()  # type: ignore[union-attr]
    assert film_of(run_of(TOP)).polhode is None


# The picture


def test_a_gif_has_the_frames_and_the_durations_of_the_run(tmp_path: Path) -> None:
    t = np.array([0.0, 0.5, 0.625, 0.75, 1.75])
    path = run_of(BOX, t=t).animate(tmp_path / "box.gif", speed=2.5)
    with Image.open(path) as image:
        assert image.format == "GIF"
        assert image.size == (480, 480)
        assert image.info["loop"] == 0
        shown = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert shown == [200, 50, 50, 400, 400]


@pytest.mark.parametrize("suffix", [".gif", ".html"])
def test_a_long_motion_plays_in_twenty_seconds(tmp_path: Path, suffix: str) -> None:
    """Half an hour of a slow body; the film says how much faster it is, unless a caption does."""
    run = run_of(BOX, (1e-3, 2e-3, 1e-2), t=np.linspace(0.0, 1800.0, 61))
    film = film_of(run)
    assert film.speed == 90.0
    assert film.shown[:-1].sum() == pytest.approx(20.0)
    path = run.animate(tmp_path / f"box{suffix}", **({} if suffix == ".html" else {"size": 64}))
    if suffix == ".html":
        assert "The film plays 90 times as fast as the motion." in path.read_text()
        assert "times as fast" not in run.animate(caption="A box.").page
        return
    with Image.open(path) as image:
        shown = sum(frame.info["duration"] for frame in ImageSequence.Iterator(image))
    # The last of 61 frames stays as long as the others; it ends within a hundredth of a second.
    assert shown == pytest.approx(20_000 * 61 / 60, abs=5)


def test_a_film_ends_with_the_event_that_ends_the_run() -> None:
    t = np.linspace(0.0, 40.0, 201)
    scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
    starts = [[1e-3, 1.0, 0.0], [1e-2, 1.0, 0.0]]
    run = rigid.simulate(scene, starts, t=t, until=rigid.crosses("omega2"))
    for k, start in enumerate(starts):
        flip = float(rigid.exact.flip_times(scene, start, axis=2)[0])
        assert film_of(run, body=k).t.tolist() == t[t <= flip].tolist()
    with pytest.raises(ValueError, match=r"body = \(0, 1\): their records end at different times"):
        run.animate()


def test_a_short_motion_plays_at_its_own_speed() -> None:
    film = film_of(run_of(BOX))
    assert film.speed == 1.0
    assert "times as fast" not in run_of(BOX).animate().page


@pytest.mark.parametrize(
    ("end", "count", "options", "turn", "advice"),
    [
        (10.0, 3, {}, 250.0, "give times at most 0.063 s apart"),
        (10.0, 10001, {"speed": 30.0}, 25.0, "give speed=3.8 or less"),
        (120.0, 12001, {}, 5.0, "give speed=3.8 or less"),
    ],
)
def test_a_film_that_shows_another_motion_says_so(
    end: float, count: int, options: dict[str, float], turn: float, advice: str
) -> None:
    """At 50 rad/s, frames half a turn apart show the spokes of a wheel at rest."""
    run = run_of(BOX, (0.0, 0.0, 50.0), t=np.linspace(0.0, end, count))
    words = f"turns by up to {turn:g} rad between frames.*{advice}"
    with pytest.warns(UserWarning, match=words) as warned:
        run.animate(**options)
    assert warned[0].filename == __file__
    run_of(BOX, (0.0, 0.0, 50.0), t=np.linspace(0.0, 1.0, 101)).animate()  # no warning


@pytest.mark.parametrize("call", [rigid.Run.plot, rigid.Run.animate])
def test_one_time_is_no_motion(call: Callable[[rigid.Run], Any]) -> None:
    with pytest.raises(
        ValueError, match=r"two times or more, such as t=np\.linspace\(0, 10, 201\)"
    ):
        call(run_of(BOX, t=np.array(10.0)))


def test_rounding_of_durations_does_not_add_up(tmp_path: Path) -> None:
    # 0.025 s, which a GIF cannot say, are 0.02 s and 0.03 s in turn.
    path = run_of(PROLATE, t=np.arange(9) * 0.025).animate(
        tmp_path / "cones.gif", fps=50.0, size=64
    )
    with Image.open(path) as image:
        shown = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert set(shown) == {20, 30}
    assert sum(shown) == 220  # 0.225 s to the even hundredth


def test_the_frames_of_a_gif_show_the_motion(tmp_path: Path) -> None:
    # A body at a fixed rate about L returns after a turn: the first and the last frame agree but
    # for the clock, and those between do not.
    turn = 2.0 * np.pi
    path = run_of(BOX, (0.0, 0.0, 1.0), t=np.linspace(0.0, turn, 5)).animate(tmp_path / "box.gif")
    frames = []
    with Image.open(path) as image:
        for k in range(5):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB"), dtype=int)[30:440])
    assert np.abs(frames[4] - frames[0]).max() < 60  # another palette, no other place
    assert (np.abs(frames[1] - frames[0]).max(axis=-1) > 100).mean() > 0.02
    assert (frames[0] < 250).any(axis=-1).mean() > 0.05


def test_frames_closer_than_the_rate_are_left_out(tmp_path: Path) -> None:
    run = run_of(BOX, t=np.arange(61) / 60.0)
    for fps in (25.0, 5.0):
        path = run.animate(tmp_path / "box.gif", fps=fps, size=64)
        with Image.open(path) as image:
            assert image.size == (64, 64)
            shown = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
        assert min(shown) >= 1000.0 / fps - 5.0  # to the hundredth of a second
        assert len(shown) >= 0.6 * fps
        assert sum(shown) == 1020  # 61 / 60 s


def test_a_webp_has_the_durations_of_the_run(tmp_path: Path) -> None:
    path = run_of(BOX, t=np.arange(5) * 0.2).animate(tmp_path / "box.webp", size=64)
    with Image.open(path) as image:
        assert (image.format, image.size, image.n_frames) == ("WEBP", (64, 64), 5)  # type: ignore[attr-defined]
        for k in range(5):
            image.seek(k)
            image.load()
            assert image.info["duration"] == 200


def test_a_video_is_an_mp4(tmp_path: Path) -> None:
    if shutil.which("ffmpeg") is None:
        pytest.importorskip("imageio_ffmpeg", reason="ffmpeg is needed")
    run = run_of(BOX)
    path = run.animate(tmp_path / "box.mp4", size=65)
    assert path.read_bytes()[4:12] == b"ftypisom"


def test_a_video_needs_an_encoder_that_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "box.mp4"
    run = run_of(BOX)
    monkeypatch.setattr(shutil, "which", lambda name: "false")
    with pytest.raises(OSError, match="false failed"):
        run.animate(path, size=64)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ImportError, match="a video needs ffmpeg"):
        run.animate(path, size=64)
    assert not path.exists()


def test_the_progress_of_a_picture_counts_its_frames(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    run_of(BOX).animate(
        tmp_path / "box.gif", size=64, progress=lambda p: told.append((p.done, p.total))
    )
    assert told[-1] == (len(T), len(T))


# What is shown


def test_the_ellipsoid_touches_the_plane_in_omega_and_does_not_slip() -> None:
    run = run_of(ASYMMETRIC, t=np.linspace(0.0, 8.0, 801))
    film = film_of(run, view="poinsot")
    contact = part(film, "dot").points
    ellipsoid, plane = part(film, "faces", carried=True), part(film, "faces")
    # Moments from the picture alone: the semi axes are as 1 / sqrt(I).
    semi = np.abs(ellipsoid.points).max(axis=(0, 1))
    np.testing.assert_allclose(semi * np.sqrt(ASYMMETRIC.body.moments), 1.0, rtol=1e-12)
    heights = plane.points @ film.up
    np.testing.assert_allclose(heights, heights[0, 0], rtol=1e-13)
    np.testing.assert_allclose(contact @ film.up, heights[0, 0], rtol=1e-12)
    turned = run.rotation()
    own = turned.inv().apply(contact)
    np.testing.assert_allclose(((own / semi) ** 2).sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(own, part(film, "line", carried=True).points, atol=1e-13)
    # The particle in contact is at rest: omega × contact = 0, because both are along omega.
    space = turned.apply(run.omega)
    np.testing.assert_allclose(np.cross(space, contact), 0.0, atol=1e-13)
    np.testing.assert_array_equal(part(film, "trail").points, contact)


@pytest.mark.parametrize("scene", [OBLATE, PROLATE])
@pytest.mark.parametrize("omega", [(0.9, 0.0, 1.3), (0.5, 0.2, -1.3)])
def test_cones_touch_along_omega(scene: Any, omega: Any) -> None:
    film = film_of(run_of(scene, omega))
    assert film.view == "cones"
    rates, body = part(film, "arrow", label="ω").points, part(film, "faces", carried=True)
    space = part(film, "faces")
    axis = part(film, "arrow", label="axis", carried=True)
    for k in range(len(T)):
        unit = rates[k] / np.linalg.norm(rates[k])
        for one, along in (
            (space.points, film.up),
            (body.placed(film.attitude[k], k), axis.placed(film.attitude[k], k)[0]),
        ):
            along = along / np.linalg.norm(along)
            rim = one.reshape(-1, 3)
            rim = rim[np.linalg.norm(rim, axis=1) > 0.99]
            np.testing.assert_allclose(rim @ along, unit @ along, atol=1e-9)


def test_the_stem_of_a_top_draws_its_locus() -> None:
    run = run_of(TOP, (0.0, 0.0, 5.0), TILTED, t=np.linspace(0.0, 10.0, 101))
    film = film_of(run)
    assert film.view == "top"
    path = top.locus(TOP, [0.0, 0.0, 5.0], TILTED, t=run.t)
    np.testing.assert_allclose(part(film, "trail").points, STEM * path.point, atol=1e-12)
    body = part(film, "faces", carried=True)
    tips = body.placed(film.attitude[50], 50)[-1, -2:]
    np.testing.assert_allclose(tips, STEM * path.point[[50, 50]], atol=1e-12)
    np.testing.assert_array_equal(film.up, [0.0, 0.0, 1.0])
    assert len(part(film, "trail").placed(film.attitude[50], 50)) == 51


def test_a_flat_top_looks_flat_across_the_axis_of_the_larger_moment() -> None:
    # ∫ x1² dm = 0.5, ∫ x2² dm = 0.02: the extents are as their roots.
    scene = rigid.HeavyTop(rigid.Body((0.62, 1.1, 0.52)), mgl=1.0)
    corners = part(film_of(run_of(scene)), "faces", carried=True).points.reshape(-1, 3)
    width = np.abs(corners).max(axis=0)
    assert width[1] / width[0] == pytest.approx(0.2, rel=1e-9)


def test_boxes_have_the_sides_of_the_body_or_those_of_its_moments() -> None:
    named = part(film_of(run_of(BOX)), "faces", carried=True).points
    np.testing.assert_allclose(np.abs(named).max(axis=(0, 1)) * 0.25, [0.25, 0.08, 0.04])
    nameless = rigid.FreeBody(rigid.Body(BOX.body.moments))
    made = part(film_of(run_of(nameless), view="box"), "faces", carried=True).points
    np.testing.assert_allclose(made, named, rtol=1e-12)


@pytest.mark.parametrize("scene", [BOX, OBLATE, PROLATE, ASYMMETRIC, TOP])
def test_nothing_leaves_the_picture(scene: Any) -> None:
    film = film_of(run_of(scene, t=np.linspace(0.0, 30.0, 301)))
    for k in range(0, 301, 7):
        for one in film.parts:
            far = np.linalg.norm(one.placed(film.attitude[k], k) - film.centre, axis=-1)
            assert far.max() < 1.05 * film.reach


def test_under_a_torque_the_angular_momentum_moves_along() -> None:
    driven = rigid.FreeBody(OBLATE.body, torque=rigid.Torque.space((0.0, 0.3, 0.0)), damping=0.05)
    run = run_of(driven, (0.0, 0.0, 0.0), method="dop853", step=0.01)
    film = film_of(run)
    assert film.view == "box"
    np.testing.assert_array_equal(film.up, [0.0, 0.0, 1.0])
    arrow = part(film, "arrow", label="L").points
    assert arrow.shape == (len(T), 3)
    momentum = run.rotation().apply(np.array(OBLATE.body.moments) * run.omega)
    longest = np.linalg.norm(momentum, axis=1).max()
    np.testing.assert_allclose(arrow / np.linalg.norm(arrow, axis=1).max(), momentum / longest)
    for view in ("cones", "poinsot"):
        with pytest.raises(
            ValueError, match=f"view = '{view}' needs a scene without torque and damping;"
        ):
            film_of(run, view=view)


ROD = rigid.Body((1.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("scene", "omega"),
    [
        (rigid.FreeBody(ASYMMETRIC.body, damping=0.1), (0.0, 0.0, 0.0)),
        (rigid.FreeBody(ROD), (0.0, 1.0, 0.0)),
        (rigid.HeavyTop(ROD, mgl=1.0), (0.0, 1.0, 0.0)),
    ],
    ids=["at rest", "rod", "pendulum"],
)
def test_a_body_without_rates_or_without_width_has_a_film(scene: Any, omega: Any) -> None:
    film = film_of(run_of(scene, omega))
    for one in film.parts:
        assert np.isfinite(one.points).all()
    pixels, _ = frame_picture(film, 0, 64)
    assert len(np.unique(pixels)) > 20
    if scene.body is ROD and film.view == "box":  # L of a rod is along its rate
        arrow, rate = (part(film, "arrow", label=name).points[0] for name in ("L", "ω"))
        np.testing.assert_allclose(arrow, [0.0, 1.5, 0.0])
        np.testing.assert_allclose(rate, [0.0, 1.2, 0.0])
        with pytest.raises(ValueError, match=r"^moments = \(1, 1, 0\): a rod has no moment"):
            film_of(run_of(scene, omega), view="poinsot")


def test_one_body_of_many() -> None:
    many = run_of(BOX, [[1.0, 0.1, 0.2], [0.1, 1.0, 0.2]])
    np.testing.assert_array_equal(film_of(many, body=1).attitude, many.attitude[1])
    np.testing.assert_array_equal(film_of(many, body=-1).attitude, many.attitude[1])
    one = run_of(BOX, [[1.0, 0.1, 0.2]])
    np.testing.assert_array_equal(film_of(one).attitude, one.attitude[0])


# Refusals


test_what_cannot_be_shown_is_refused = refuses(
    [
        ({"path": "x.png"}, r"path = 'x.png': must end in .html, .gif, .webp or .mp4"),
        ({"fps": 0.0}, r"fps = 0.0: must be positive"),
        ({"fps": 60.0}, r"fps = 60: must be at most 50"),
        ({"size": 63}, r"size = 63: must be at least 64"),
        ({"trail": 0.0}, r"trail = 0.0: must be positive"),
        ({"trail": np.nan}, r"trail = nan: must be finite"),
        ({"body": [0, 1, 2]}, r"body = \[0, 1, 2\]: must be one index or two"),
        ({"body": []}, r"body = \[\]: must be one index or two"),
        ({"view": "top"}, r"view = 'top': must be one of 'box', 'cones', 'poinsot'"),
        ({"view": "Poinsot"}, r"did you mean 'poinsot'"),
        ({"speed": 0.0}, r"speed = 0.0: must be positive"),
        ({"speed": np.nan}, r"speed = nan: must be finite"),
        ({"body": 0}, r"body = 0: the run has a single body"),
        ({"view": "cones"}, r"moments"),
        (
            {"path": "x.gif", "speed": 1e-4},
            r"frame 0 of a picture would be shown for 1000 s: must be",
        ),
    ],
    by=lambda given: run_of(ASYMMETRIC).animate(**({"path": "x.html"} | given)),
)


test_runs_that_cannot_be_shown_are_refused = refuses(
    [
        (
            {"scene": ASYMMETRIC, "record": "rates"},
            r"record = 'rates': record = 'attitude' is needed",
        ),
        ({"scene": ASYMMETRIC, "t": [1.0]}, r"t = \[1.0\]: an animation needs two times"),
        ({"scene": ASYMMETRIC, "omega": [0, 0, 0]}, r"omega = \[0, 0, 0\]: a free body at rest"),
        ({"scene": TOP, "omega": [[1, 0, 0]] * 3}, r"body = None: the run has 3 bodies"),
        (
            {"scene": TOP, "method": "rk4", "step": 1e-9, "max_steps": 5},
            r"states that are not finite",
        ),
    ],
    by=lambda run: run_of(**run).animate("x.html"),
)


def test_an_index_is_a_whole_number_of_a_body_there_is() -> None:
    run = run_of(TOP, [[1, 0, 0], [1, 2, 3]])
    with pytest.raises(ValueError, match="body = 2: the run has 2 bodies"):
        run.animate("x.html", body=2)
    with pytest.raises(TypeError, match=r"body = 0\.5: must be a whole number"):
        run.animate("x.html", body=0.5)


# Films show the surface of a body that the user gives


def test_a_mesh_is_shown_where_the_body_is() -> None:
    # An L of two boxes, whose principal axes are not those in which it is described.
    corners, faces = l_shape()
    solid = rigid.meshes.mesh_properties(corners, faces, mass=2.0)
    body, axes = rigid.Body.from_properties(solid)
    own = corners - solid.centre
    run = run_of(rigid.FreeBody(body), (0.1, 0.2, 3.0)).in_frame(axes)
    film = film_of(run, shape=(own, faces))
    assert film.view == "box"
    shown = part(film, "faces", carried=True)
    space = shown.placed(film.attitude[13], 13)
    # In space the corners are where the attitude of the axes of the mesh brings them.
    meant = run.rotation()[13].apply(own)[np.array(faces)]
    np.testing.assert_allclose(space, meant / np.linalg.norm(own, axis=1).max(), atol=1e-12)
    # The same in principal axes.
    plain = film_of(run.in_frame(None), shape=(own @ axes, faces))
    np.testing.assert_allclose(part(plain, "faces", carried=True).points, shown.points, atol=1e-12)
    # Their second moments are those of the body, up to the square of the scale.
    again = rigid.meshes.mesh_properties(*welded(shown.points), mass=2.0)
    scale = np.linalg.norm(own, axis=1).max()
    np.testing.assert_allclose(again.tensor * scale**2, np.diag(body.moments), atol=1e-12)
    top_film = film_of(run_of(TOP, (0.0, 0.0, 5.0), TILTED), shape=(own, faces))
    assert top_film.view == "top"
    assert part(top_film, "faces", carried=True).points.shape == (len(faces), 3, 3)


def l_shape() -> tuple[Any, list[list[int]]]:
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    low, high = np.insert(outline, 2, 0.0, axis=1), np.insert(outline, 2, 0.5, axis=1)
    cap = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6] for k in range(6)]
    sides += [[k, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    faces = [[a, c, b] for a, b, c in cap] + [[a + 6, b + 6, c + 6] for a, b, c in cap] + sides
    return np.concatenate([low, high]), faces


def welded(polygons: Any) -> tuple[Any, Any]:
    corners, index = np.unique(polygons.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return corners, index.reshape(-1, 3)


def test_faces_of_a_mesh_may_have_four_corners() -> None:
    square = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    film = film_of(run_of(BOX), shape=(square, [[0, 1, 2, 3]]))
    np.testing.assert_array_equal(part(film, "faces", carried=True).points, [square])


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (([[[0, 0, 0]]], [[0, 0, 0]]), r"shape\[0\]: the corners need the shape \(v, 3\)"),
        (([[0, 0, 1]], [[0.0, 0.0, 0.0]]), r"shape\[1\]: the faces need whole numbers of shape"),
        (([[0, 0, 1]], [[0, 0]]), r"\(f, n\) with n >= 3, not int64 of shape \(1, 2\)"),
        (([[0, 0, 1]], [[0, 0, 1]]), r"shape\[1\]: no corner 1 among 1 corners"),
        (([[0, 0, 1]], [[0, 0, -1]]), r"shape\[1\]: no corner -1 among 1 corners"),
        (([[0, 0, 0]], [[0, 0, 0]]), r"shape\[0\]: all corners of the faces are at the origin"),
    ],
)
def test_a_surface_that_is_none_is_refused(shape: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run_of(BOX).animate(shape=shape)
    with pytest.raises(ValueError, match="view = 'poinsot': does not show the shape; omit one"):
        run_of(BOX).animate(view="poinsot", shape=shape)


def test_what_is_no_pair_and_no_text_is_refused() -> None:
    for shape in (5, [[0, 0, 1], [0, 1, 0], [1, 0, 0]]):
        with pytest.raises(TypeError, match=r"shape = .*: must be a pair, \(vertices, faces\)"):
            run_of(BOX).animate(shape=shape)
    with pytest.raises(TypeError, match="caption = 5: must be a text"):
        run_of(BOX).animate(caption=5)


# Orbits

ORBITS = {
    "ellipse": rigid.Orbit(3.0, 0.4, 1.0, normal=(0.0, -0.6, 0.8)),
    "flyby": rigid.Orbit(3.0, 1.5, -3.0, normal=(0.0, -0.6, 0.8)),
}


def kepler(anomaly: float, e: float, mean: float) -> float:
    """Zero at the eccentric anomaly of a mean anomaly."""
    if e < 1.0:
        return float(anomaly - e * np.sin(anomaly) - mean)
    return float(e * np.sinh(anomaly) - anomaly - mean)


def kepler_directions(orbit: rigid.Orbit, t: Any) -> Any:
    """Unit vectors from the body to the planet, by SciPy's root of Kepler's equation."""
    e, normal = orbit.eccentricity, np.asarray(orbit.normal)
    across = np.cross(normal, orbit.periapsis)
    found = []
    for mean in orbit.anomaly + orbit.rate * np.asarray(t):
        at = brentq(kepler, mean - 9.0, mean + 9.0, args=(e, mean), xtol=1e-14)
        if e < 1.0:
            place = np.array([np.cos(at) - e, np.sqrt(1.0 - e * e) * np.sin(at)])
        else:
            place = np.array([e - np.cosh(at), np.sqrt(e * e - 1.0) * np.sinh(at)])
        found.append(-(place[0] * np.asarray(orbit.periapsis) + place[1] * across))
    return np.array([one / np.linalg.norm(one) for one in found])


@pytest.mark.parametrize("name", ORBITS)
def test_a_film_on_an_orbit_shows_the_direction_to_the_planet(name: str) -> None:
    orbit = ORBITS[name]
    film = film_of(run_of(rigid.FreeBody(ASYMMETRIC.body, orbit=orbit)))
    planet = part(film, "planet", label="planet")
    assert planet.meaning == "direction to the planet"
    # Kepler's equation in doubles: an anomaly of up to 7 rad, over a slope of 0.5 or more.
    np.testing.assert_allclose(planet.points / PLANET, kepler_directions(orbit, film.t), atol=1e-14)
    np.testing.assert_allclose(film.up, orbit.normal, atol=1e-15)
    (ring,) = (one for one in film.parts if one.meaning == "plane of the orbit")
    assert np.abs(ring.points @ np.asarray(orbit.normal)).max() < 1e-15


def test_a_picture_has_the_planet_where_it_is() -> None:
    orbit = ORBITS["ellipse"]
    film = film_of(run_of(rigid.FreeBody(ASYMMETRIC.body, orbit=orbit)))
    camera = Camera(film, 300)
    frames = [k for k, point in enumerate(part(film, "planet", label="planet").points)
              if point @ camera.eye > 0.3]  # fmt: skip
    assert len(frames) > 3  # in front of the body
    for k in frames:
        pixels, names = frame_picture(film, k, 300)
        column, row, _ = camera.project(PLANET * kepler_directions(orbit, film.t[k : k + 1])[0])
        ink = pixels[int(row), int(column)] / 255.0
        violet = np.array([0x6B, 0x4F, 0xBB]) / 255.0
        # The light changes the size of a colour, not its direction; bytes round by 1/510.
        assert np.linalg.norm(np.cross(ink, violet)) < 0.01
        assert [one.label for one, _ in names][-1] == "planet"


def test_the_momentum_of_a_film_is_that_of_the_body_with_its_rotor() -> None:
    run = run_of(rigid.FreeBody(ASYMMETRIC.body, rotor=(0.3, -0.2, 1.0)))
    film = film_of(run)
    meant = run.momentum("space")
    shown = part(film, "arrow", label="L").points
    np.testing.assert_allclose(
        shown / 1.5, meant / np.linalg.norm(meant, axis=-1).max(), rtol=1e-13, atol=1e-13
    )
    np.testing.assert_allclose(film.up, meant[0] / np.linalg.norm(meant[0]), atol=1e-13)


# Moving pictures draw light, depth, shadows and labels


def test_near_surfaces_hide_far_ones() -> None:
    film = film_of(run_of(BOX, (0.0, 0.0, 1.0)))
    camera = Camera(film, 100)
    right, upward, eye = film.reach * camera.axes
    square = [-right - upward, right - upward, right + upward, upward - right]
    corners = film.centre + 0.5 * np.array(square)
    red, blue = np.array([[0.9, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.9]])
    for order in (1, -1):
        buffer = Buffer(camera)
        for shift, ink in [(0.3, red), (-0.3, blue)][::order]:
            buffer.faces((corners + shift * eye)[np.newaxis], ink)
        middle = buffer.colour[50, 50]
        assert middle[0] > 0.4
        assert middle[2] == 0.0


def test_a_ball_of_polygons_is_lit_as_a_ball() -> None:
    # The picture of a ball by corners with averaged normals, and the light on the true ball.
    film = film_of(run_of(BOX, (0.0, 0.0, 1.0)))
    radius = 0.6 * film.reach
    polygons = ellipsoid_faces([radius] * 3, rings=14, sectors=28)
    ball = Part(kind="faces", points=polygons, colours=("#ffffff",))
    camera = Camera(film, 240)
    worst = {}
    for name, normals in [("smooth", corner_normals(ball)), ("flat", None)]:
        buffer = Buffer(camera)
        buffer.faces(polygons, np.ones((len(polygons), 3)), normals=normals)
        light = buffer.colour[..., 0]
        # Rays through the dots, and where they meet the ball round the origin.
        column, row = np.meshgrid(np.arange(240) + 0.5, np.arange(240) + 0.5)
        ray = np.stack(
            [(column - 120) / camera.scale, (120 - row) / camera.scale, -np.ones_like(row)], axis=-1
        )
        ray = ray @ camera.axes / np.linalg.norm(ray, axis=-1, keepdims=True)
        along = ray @ camera.at
        under = along**2 - (camera.at @ camera.at - radius**2)
        normal = (camera.at + (-along - np.sqrt(np.maximum(under, 0.0)))[..., None] * ray) / radius
        meant = 0.52 + 0.12 * normal @ camera.up + 0.48 * np.maximum(normal @ camera.lamp, 0.0)
        inside = under > 0.1 * under.max()  # polygons end before the edge of the ball
        worst[name] = np.abs(light - meant)[inside].max()
    # Faces are h = 12.9 degrees wide. Between corners linear light errs by slope h / 4 where the
    # lamp sets (slope 0.48), and by 0.6 h² / 8 elsewhere. Faces lie by h² / 8 inside the ball,
    # which moves the place that is seen by up to three times as much near the edge.
    h = np.radians(12.9)
    assert worst["smooth"] < 0.48 * h / 4 + 0.6 * h**2 / 8 + 0.6 * 3 * h**2 / 8
    assert worst["flat"] > 0.05


def test_boxes_keep_their_edges() -> None:
    box = part(film_of(run_of(BOX)), "faces", carried=True)
    normals = corner_normals(box)
    for axis in range(3):
        for face in (2 * axis, 2 * axis + 1):
            np.testing.assert_allclose(np.abs(normals[face]), np.eye(3)[[axis] * 4], atol=1e-15)


def test_a_tip_of_thousands_of_faces_is_lit_in_memory_that_grows_with_them() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 3001)[:, np.newaxis]
    rim = np.cos(turn) * [1.0, 0.0, 0.0] + np.sin(turn) * [0.0, 1.0, 0.0]
    tip = np.tile([0.0, 0.0, 0.3], (3000, 1))
    fan = Part(kind="faces", points=np.stack([tip, rim[:-1], rim[1:]], axis=1), colours=("#fff",))
    tracemalloc.start()
    normals = corner_normals(fan)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 3000 * 2000  # a number for each pair of faces would be 72 MB
    # Faces of a flat cone are less than 45 degrees apart: at the tip their mean is the axis.
    np.testing.assert_allclose(normals[:, 0], [[0.0, 0.0, 1.0]] * 3000, atol=1e-2)


def test_the_shadow_in_a_picture_lies_where_light_from_above_brings_it() -> None:
    leaning = [np.cos(0.3), np.sin(0.3), 0.0, 0.0]
    film = film_of(run_of(TOP, (0.0, 0.0, 9.0), leaning))
    assert film.grounded
    camera = Camera(film, 200)
    corners = part(film, "faces", carried=True).placed(film.attitude[0], 0)
    lit, bare = Buffer(camera), Buffer(camera)
    lit.ground(corners)
    bare.ground(np.zeros((0, 4, 3)))
    shadow = 1.0 - lit.colour[..., 0] / bare.colour[..., 0]
    assert 0.3 < shadow.max() < 0.4001
    row, column = (shadow @ np.ones(200)) @ np.arange(200), np.ones(200) @ shadow @ np.arange(200)
    seen = np.array([column, row]) / shadow.sum() + 0.5
    # The axis from 0.3 to 1.25 carries the widths; light falls by (0.25, -0.2) a unit of height.
    x, y, z = Rotation.from_quat(film.attitude[0], scalar_first=True).apply([0.0, 0.0, 1.0])
    ends = [
        camera.project(height * np.array([x + 0.25 * z, y - 0.2 * z, 0.0]))[:2]
        for height in (0.3, 1.25)
    ]
    assert _from_segment(seen, *ends) < 6.0  # of 200: half the width of the shadow is about 40
    # So it lies in the picture: darker by its share than the ground on the other side.
    pixels = frame_picture(film, 0, 200)[0].astype(int)
    dark, light = (pixels[int(seen[1]), int(x)].sum() for x in (seen[0], 200.0 - seen[0]))
    assert dark == pytest.approx((1.0 - shadow.max()) * light, rel=0.02)


def test_labels_of_a_picture_avoid_labels_and_arrows() -> None:
    # L and omega point the same way, one beyond the other: the shorter one's label stands aside.
    origin, far, near = np.array([100.0, 200.0]), np.array([100.0, 40.0]), np.array([100.0, 120.0])
    first, second = label_places(origin, [far, near], [1, 1])
    np.testing.assert_allclose(first[0], 100.0)
    assert first[1] < 40.0
    assert abs(second[0] - 100.0) > 9.0
    together = label_places(origin, [far, far + np.array([1.0, 0.0])], [8, 8])
    assert (np.abs(together[0] - together[1]) > [74.0, 16.0]).any()


# The sentence above a film is true of the motion.


THIN = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))


def said(page: str) -> str:
    found = re.search(r'"story":"(.*?)"', page)
    assert found
    return json.loads(f'"{found[1]}"')  # type: ignore[no-any-return]


def sign_changes(scene: Any, throw: Any, t_end: float) -> Any:
    """Times at which the rate about axis 2 changes sign, by SciPy from Euler's equations."""
    a, b, c = scene.body.moments

    def euler(_: float, rates: Any) -> list[float]:
        x, y, z = rates
        return [(b - c) / a * y * z, (c - a) / b * z * x, (a - b) / c * x * y]

    found = solve_ivp(
        euler, (0.0, t_end), throw, rtol=1e-12, atol=1e-12, events=lambda _, rates: rates[1]
    )
    return found.t_events[0]


@pytest.mark.parametrize("frames", [2, 301])
def test_the_story_of_a_throw_counts_its_flips_even_between_frames(frames: int) -> None:
    throw = [0.01, 10.0, 0.01]
    flips = sign_changes(THIN, throw, 8.0)
    assert len(flips) == 4
    for t_end, words in [
        (0.5 * flips[0], "does not turn over"),
        (0.5 * (flips[0] + flips[1]), "turns over once"),
        (0.5 * (flips[1] + flips[2]), "turns over twice"),
        (0.5 * (flips[2] + flips[3]), "turns over 3 times"),
    ]:
        story = film_of(run_of(THIN, throw, t=np.linspace(0.0, t_end, frames))).story
        assert story.startswith("A box spins at 10 rad/s about its middle axis, and ")
        assert words in story


def test_a_throw_turns_over_as_late_as_its_film_begins() -> None:
    # The film begins 0.4 s after the throw, and the axis turns over as late as in the whole motion.
    throw = [0.01, 10.0, 0.01]
    flips = sign_changes(THIN, throw, 8.0)
    run = run_of(THIN, throw, t=np.linspace(0.4, 6.0, 8))
    first, count = turns_over(THIN, run.t, run.omega)
    # SciPy errs by 1e-12 a step. Each period depends on the logarithm of the distance 0.01 from the
    # unstable axis, so a thousand steps shift a flip by 1e-7 s at most.
    assert first == pytest.approx(flips[0], abs=1e-6)
    assert count == 3


@pytest.mark.parametrize(
    ("scene", "omega", "attitude", "words"),
    [
        (OBLATE, (0.1, 0.0, 5.0), None, "A symmetric body turns freely: its cone rolls"),
        (ASYMMETRIC, (0.9, 0.1, 1.3), None, "its inertia ellipsoid rolls on a plane"),
        (BOX, (0.9, 0.1, 1.3), None, "A box turns freely for 2 s: L is at rest in space"),
        (BOX, (5.0, 0.01, 0.0), None, "about its longest axis, and does not turn over in 2 s."),
        (
            TOP,
            (0.0, 0.0, 5.0),
            [1.0, 0, 0, 0],
            "about the vertical: in all frames of 2 s its tilt is 0°.",
        ),
        (
            TOP,
            (0.0, 0.0, 5.0),
            TILTED,
            "A heavy top starts at a tilt of 60°: in the frames of 2 s its tilt is between 60°",
        ),
        (
            rigid.FreeBody(BOX.body, torque=rigid.Torque.body((0, 0, 1e-3)), damping=1e-4),
            (0.9, 0.1, 1.3),
            None,
            "A box turns for 2 s under torque and damping.",
        ),
        (
            rigid.FreeBody(BOX.body, orbit=rigid.Orbit(np.pi), rotor=(0.0, 0.0, 1e-4)),
            (0.9, 0.1, 1.3),
            None,
            "A box turns for 2 s (a period of its orbit), under the gravity gradient and a rotor.",
        ),
    ],
)
def test_the_story_is_that_of_the_motion(scene: Any, omega: Any, attitude: Any, words: str) -> None:
    assert words in film_of(run_of(scene, omega, attitude)).story


def test_the_story_of_two_throws_tells_them_apart() -> None:
    near, far = [0.01, 10.0, 0.0], [1e-6, 10.0, 0.0]
    first, second = (rigid.exact.flip_times(THIN, one, count=1)[0] for one in (near, far))
    for throws, t_end, words in [
        ([near, far], 1.8, f"the left box turns over at {first:.2g} s, the right box does not."),
        ([far, near], 1.8, f"the right box turns over at {first:.2g} s, the left box does not."),
        ([near, far], 2.2, f"turns over at {first:.2g} s, the right box at {second:.2g} s."),
        ([near, far], 0.8, "neither box turns over in 0.8 s."),
    ]:
        story = said(run_of(THIN, throws, t=np.linspace(0.0, t_end, 101)).animate().page)
        assert story.startswith("Two throws that differ by 0.01 rad/s: ")
        assert story.endswith(words)
    tops = run_of(TOP, [[0.0, 0.0, 5.0], [0.0, 0.1, 0.5]], TILTED, t=np.linspace(0.0, 6.0, 301))
    tilt = np.rad2deg(np.arccos(tops.gamma[..., 2])).max(axis=1)
    story = said(tops.animate().page)
    assert story.startswith("Two starts that differ by 4.5 rad/s: ")
    assert story.endswith(
        f"in the frames the left top tilts up to {tilt[0]:.0f}°, the right top up to "
        f"{tilt[1]:.0f}°."
    )
    equal = run_of(TOP, [[0.0, 0.0, 5.0]] * 2, TILTED)
    assert said(equal.animate().page) == "The same motion on both sides."
    bodies = run_of(rigid.FreeBody(OBLATE.body), [[1.0, 1.0, 1.0], [0.9, 1.0, 1.0]])
    assert said(bodies.animate().page) == "Two starts that differ by 0.1 rad/s."
    given = "One word, then <another>."
    assert said(bodies.animate(caption=given).page) == given


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        ({"orbit": rigid.Orbit(np.pi)}, "A body turns for 2 s (a period of its orbit)."),
        (
            {"orbit": rigid.Orbit(2.5 * np.pi, 0.2), "drag": 0.1},
            "A body turns for 2 s (2.5 periods of its orbit), under the gravity gradient and drag.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=1.5)},
            "A body turns for 2 s and passes a planet at t = 1.5 s.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=3.0)},
            "A body turns for 2 s before it passes a planet.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=-3.0)},
            "A body turns for 2 s after it passes a planet.",
        ),
    ],
)
def test_the_story_of_a_body_on_an_orbit_says_where_it_is(
    forces: dict[str, Any], words: str
) -> None:
    assert film_of(run_of(rigid.FreeBody(ASYMMETRIC.body, **forces))).story == words
