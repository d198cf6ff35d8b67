"""The map explorer: what its page holds, its motions under Node, and its controls in a browser."""

import contextlib
import ctypes
import html
import itertools
import json
import math
import re
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from browsers import Opened
from pages import NODE, content, under_node, unpacked
from rigid import cli
from rigid.cli.toml_map import read_spec
from rigid.cli.toml_table import names_of
from rigid.drawing import colours
from rigid.maps.grid import nominal_starts
from rigid.maps.page import numbers_of_motion
from rigid.model.parameters import AT_REST
from rigid.solve.run import scene_of

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


# What the page holds


def test_a_page_holds_nominal_starts_and_the_outcomes_of_the_map(page: Path) -> None:
    held = content(page)
    count = held["samples"]
    assert (count, held["of"], held["shape"]) == (6, 6, [4, 7])
    outcomes = BOX.outcomes(range(count))
    nominal = held["draw"]
    assert (unpacked(nominal["omega"]).reshape(-1, 3) == [0.0, 10.0, 0.0]).all()
    assert (unpacked(nominal["omega_size"]).reshape(4, 7, 3)[2] == 1e-1).all()
    assert (nominal["laws"], nominal["key"]) == (["normal", None], ["2026", "0"])
    words = np.array([*held["classes"], ""])[unpacked(held["outcome"])]
    assert (words == outcomes.outcome.ravel()).all()
    left = outcomes.left.ravel().astype(np.float32)
    np.testing.assert_array_equal(unpacked(held["left"]), left)
    layers = {layer["name"]: unpacked(layer["data"]) for layer in held["layers"]}
    np.testing.assert_array_equal(layers["share"], BOX.share.ravel().astype(np.float32))
    assert {"lower", "upper", "undecided", "failed", "earliest"} <= set(layers)


def test_axes_are_called_as_in_the_picture(page: Path) -> None:
    assert [axis["label"] for axis in content(page)["axes"]] == [
        "side b (m)",
        "perturbation of the rates (rad/s)",
    ]
    result = tops(
        axes={"I3/I1": [0.5, 0.6], "omega2": [0.1, 0.2], "damping1": [0.0, 0.1]},
        start=rigid.Start(omega=(0.0, 0.0, 3.0)),
    )
    assert [axis["label"] for axis in content(result.explore())["axes"]] == [
        "I₃/I₁",
        "ω₂ (rad/s)",
        "damping about axis 1, D₁₁ (N m s)",
    ]


def test_a_notebook_shows_a_map_without_a_file() -> None:
    shown = BOX.explore(samples=2)
    assert re.fullmatch(r"Explorer\(page of \d+ kB\)", repr(shown))
    inside = re.search(r'<iframe srcdoc="([^"]*)"', shown._repr_html_())
    assert inside
    assert html.unescape(inside[1]) == shown.page


def test_the_words_of_a_regular_map_are_regular_and_chaotic() -> None:
    result = tops(axes={"spin": [3.0]}, stable=rigid.regular(), samples=1, t_end=50.0)
    held = content(result.explore())
    assert [held["words"][name] for name in held["classes"][:2]] == ["regular", "chaotic"]
    assert held["leaves"] is False
    assert held["layers"][0]["label"] == "share regular"
    assert "stable" not in "".join(layer["label"] for layer in held["layers"])


def test_a_page_needs_nothing_from_elsewhere(page: Path) -> None:
    assert not re.search(r"https?:|//[a-z]+\.|\bsrc=|\bhref=|@import|\bfetch\(", page.read_text())
    assert page.stat().st_size < 150_000


def test_a_page_has_as_many_bodies_as_are_asked_for() -> None:
    held = content(BOX.explore(samples=2))
    assert (held["samples"], len(unpacked(held["outcome"]))) == (2, 28 * 2)


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
    assert "exists; take another name, or replace the file with --force" in capsys.readouterr().err
    assert content(written)["samples"] == 1
    assert cli.main(["explore", str(data), "--force"]) == 0
    assert content(written)["samples"] == 6
    assert cli.main(["explore", str(data), "--out", str(tmp_path)]) == 2
    assert "--out: path = " in capsys.readouterr().err


# Colours

# G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009) 1291,
# doi 10.1109/TVCG.2009.113: severity 1.0, for linear RGB.
SIGHT = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


def lab(colour: str, sight: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIELAB under D65 of an sRGB colour as it is seen (IEC 61966-2-1, ISO/CIE 11664-4)."""
    rgb = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    xyz = to_xyz @ np.clip(sight @ linear, 0.0, 1.0) / [0.9505, 1.0, 1.0890]
    x, y, z = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_outcomes_are_told_apart_by_the_colour_blind(sight: str) -> None:
    seen = [lab(colour, SIGHT[sight]) for colour in colours.OUTCOMES.values()]
    # A just noticeable difference is 2.3 (Mahy, van Eycken and Oosterlinck 1994).
    assert min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2)) > 30.0


# The motions of the page


def rows(held: dict[str, Any]) -> NDArray[np.float64]:
    """The numbers of the equations of motion of each body of a page, (pixels, samples, numbers)."""
    of_pixel = unpacked(held["motion"]["numbers"]).reshape(np.prod(held["shape"]), 1, -1)
    each = of_pixel.repeat(held["samples"], axis=1)
    if "own" in held:
        columns = held["own"]["columns"]
        each[..., columns] = unpacked(held["own"]["values"]).reshape(*each.shape[:2], -1)
    return each


def moved(
    held: dict[str, Any], omega: Any, attitude: Any, bodies: Any, t: Any
) -> list[dict[str, NDArray[np.float64]]]:
    """The motions of bodies, (pixel, sample), by a page, each at its times."""
    pixels, samples = np.transpose(bodies)
    found = under_node(
        "(n, w, q, t) => n.map((row, k) => motionOf(row, w[k], q[k], t[k]))",
        rows(held)[pixels, samples],
        omega[pixels, samples],
        attitude[pixels, samples],
        t,
    )
    return [{name: np.array(values) for name, values in one.items()} for one in found]


LONG = rigid.Body((1.0, 1.3, 1.6))
SIDEWAYS = {"normal": (0.0, 0.6, 0.8), "periapsis": (0.0, 0.8, -0.6)}
FORCED: dict[str, Any] = {
    "torque in the body": {"torque": rigid.Torque.body((0.05, -0.02, 0.01))},
    "torque in space": {"torque": rigid.Torque.space((0.05, 0.03, -0.02))},
    "damping": {"damping": np.diag([0.01, 0.02, 0.03])},
    "drag": {"drag": (0.1, 0.05, 0.2)},
    "rotor": {"rotor": (0.1, -0.3, 0.5)},
    "energy sink": {"dissipation": rigid.EnergySink((0.1, 0.05, 0.02))},
    "circle": {"orbit": rigid.Orbit(1.0)},
    "ellipse": {"orbit": rigid.Orbit(1.0, 0.5, 2.0, **SIDEWAYS)},
    # The planet is passed at t = 15, a tenth of the first distance away.
    "flyby": {"orbit": rigid.Orbit(0.5, 1.6, -7.5, **SIDEWAYS)},
    "all": {
        "torque": rigid.Torque.body((0.1, 0.2, 0.0)) + rigid.Torque.space((0.0, 0.1, 0.1)),
        "damping": np.diag([0.01, 0.02, 0.03]),
        "drag": 0.01,
        "rotor": (0.1, 0.2, 0.3),
        "dissipation": rigid.EnergySink(0.01),
        "orbit": rigid.Orbit(0.3, 0.2),
    },
}


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_motions_of_the_page_are_those_of_simulate() -> None:
    """States by the page's Taylor series of order 24, and by the core with errors below 1e-10."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0, damping=np.diag([0.01, 0.02, 0.03]))
    scenes: dict[str, Any] = {
        name: rigid.FreeBody(LONG, **forces) for name, forces in FORCED.items()
    }
    scenes |= {"free": rigid.FreeBody(LONG), "damped top": top}
    rng = np.random.default_rng(5)
    omega = rng.normal(size=(len(scenes), 3))
    attitude = rng.normal(size=(len(scenes), 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    t = np.linspace(0.0, 30.0, 61)
    numbers = np.concatenate(
        [numbers_of_motion(nominal_starts(scene, AT_REST)) for scene in scenes.values()]
    )
    found = under_node(
        "(n, w, q, t) => n.map((row, k) => motionOf(row, w[k], q[k], t))",
        numbers,
        omega,
        attitude,
        t,
    )
    for (name, scene), w, q, seen in zip(scenes.items(), omega, attitude, found, strict=True):
        run: Any = rigid.simulate(scene, w, q, t=t, accuracy=1e-10)
        # The page errs by rounding, 1e-16 a step, which grows with the motion as `error` does.
        assert np.abs(np.array(seen["omega"]) - run.omega).max() < 2e-10, name
        assert np.abs(np.array(seen["attitude"]) - run.attitude).max() < 2e-10, name


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_places_on_orbits_are_those_of_the_orbit() -> None:
    """Kepler's equation in doubles: 1e-16 of an anomaly, over a slope of at least 0.1."""
    orbits = [rigid.Orbit(1.5, e, -2.0, **SIDEWAYS) for e in (0.0, 0.3, 0.9, 1.1, 3.0)]
    t = np.linspace(-5.0, 40.0, 46)
    found = under_node(
        "(orbits, t) => orbits.map(orbit => t.map(time => placeOf(orbit, time)))",
        [orbit.numbers for orbit in orbits],
        t,
    )
    for orbit, places in zip(orbits, found, strict=True):
        far = np.linalg.norm(orbit.position(t), axis=-1, keepdims=True)
        assert (np.abs(np.array(places) - orbit.position(t)) / far).max() < 1e-13


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize("name", names_of("map"))
def test_bodies_of_every_built_in_map_move_in_the_page(name: str) -> None:
    """Over 30 rad: chaos enlarges an error of 1e-10 in this time by less than a hundred."""
    spec = read_spec(name).spec
    axes = {
        axis.name: [axis.values[len(axis.values) * k // 8] for k in (3, 6)] for axis in spec.axes
    }
    spec = spec.replace(samples=min(spec.samples, 2), axes=axes)
    result = rigid.stability_map(spec, progress=False)
    held = content(result.explore())
    possible = np.flatnonzero(result.status.ravel() == 0)
    bodies = [(pixel, sample) for pixel in possible.tolist() for sample in range(held["samples"])]
    assert bodies
    starts = result.starts(range(held["samples"]))
    omega, attitude = starts.omega.reshape(4, -1, 3), starts.attitude.reshape(4, -1, 4)
    rate = max(np.linalg.norm(omega[possible], axis=-1).max(), 0.5 * orbital_rate(spec.scene))
    t = np.linspace(0.0, min(30.0 / rate, spec.t_end), 31)
    found = moved(held, omega, attitude, bodies, np.tile(t, (len(bodies), 1)))
    for (pixel, sample), seen in zip(bodies, found, strict=True):
        run = result.replay(pixel, sample).run
        scene = scene_of(run) if isinstance(run, rigid.Run) else spec.grid.scene[pixel]
        truth: Any = rigid.simulate(
            scene, omega[pixel, sample], attitude[pixel, sample], t=t, accuracy=1e-10
        )
        size = np.abs(truth.omega).max()
        assert np.abs(seen["omega"] - truth.omega).max() < 1e-8 * size
        assert np.abs(seen["attitude"] - truth.attitude).max() < 1e-8


def orbital_rate(scene: Any) -> float:
    """The mean motion (rad/s) of an ellipse, 0 of other scenes."""
    orbit = scene.orbit if isinstance(scene, rigid.FreeBody) else None
    return 0.0 if orbit is None or np.max(orbit.eccentricity) > 1.0 else float(orbit.rate)


# What the criterion watches


SPUN = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0)
LEANING = SPUN, rigid.Start(spin=3.0, axis=3, tilt=0.4, noise=rigid.normal(0.3))
FREE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
BRAKED = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=np.diag([0.1, 0.1, 0.2]))
MOON = rigid.FreeBody(
    rigid.Body((1.0, 1.5, 2.0)),
    orbit=rigid.Orbit(2.0, 0.1, normal=(0.0, -0.6, 0.8), periapsis=(1.0, 0.0, 0.0)),
)
# Axes 1, 2, 3 at first along the periapsis, along the orbit and its normal.
ALONG = (math.sqrt(0.9), math.sqrt(0.1), 0.0, 0.0)
ROCKED = MOON, rigid.Start(spin=2.5, axis=3, attitude=ALONG, noise=rigid.normal(0.1))
TURNED = rigid.Start(spin=2.0, axis=2, noise=rigid.normal(0.1))


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize(
    ("scene", "start", "stable", "label"),
    [
        (*LEANING, rigid.tilt_below(1.0), "tilt of axis 3 from the vertical (°)"),
        (*LEANING, rigid.tilt_below(2.5, axis=-2), "tilt of axis −2 from the vertical (°)"),
        (FREE, TURNED, rigid.tilt_below(1.0, axis=2), "tilt of axis 2 from its start (°)"),
        (*LEANING, rigid.tilt_between(0.35, 2.0), "tilt of axis 3 from the vertical (°)"),
        (*LEANING, rigid.rate_within(0.6), "angle of ω from its start in space (°)"),
        (FREE, TURNED, rigid.rate_within(1.0, frame="body"), "angle of ω from its start in the bo"),
        (*LEANING, rigid.rate_within(0.4, of="L"), "angle of L from its start in space (°)"),
        (FREE, TURNED, rigid.rate_within(1.0, "L", "body"), "angle of L from its start in the bo"),
        (*LEANING, rigid.near_start(2.0), "rotation from the start (°)"),
        (BRAKED, TURNED, rigid.spin_above(1.0), "|ω| (rad/s)"),
        (FREE, TURNED, rigid.spin_above(0.5, axis=2), "ω₂ (rad/s)"),
        (FREE, TURNED, rigid.spin_above(0.05, axis=-1), "−ω₁ (rad/s)"),
        (FREE, TURNED, rigid.no_flip(2), "ω (rad/s)"),
        (*ROCKED, rigid.pointing_within(0.5, 1), "angle of axis 1 from the radial direction"),
        (*ROCKED, rigid.pointing_within(1.5, -1, either=True), "angle of axis −1 from the"),
        (*ROCKED, rigid.pointing_within(0.5, 2, "along"), "angle of axis 2 from the direction "),
        (*ROCKED, rigid.pointing_within(0.3, 3, "normal"), "angle of axis 3 from the normal o"),
        (*ROCKED, rigid.tilt_below(0.3, reference="vertical"), "tilt of axis 3 from the normal "),
    ],
)
def test_a_body_leaves_where_its_chart_meets_the_limit(
    scene: Any, start: Any, stable: Any, label: str
) -> None:
    result = rigid.stability_map(
        scene, axes={"spin": [2.0, 3.0]}, start=start, samples=8, t_end=30.0, stable=stable, rng=5
    )
    held = content(result.explore())
    chart = held["charts"][0]
    assert chart["label"].startswith(label)
    limits = [unpacked(limit) for limit in chart["limits"]]
    numbers = rows(held)[:, 0]
    starts, outcomes = result.starts(range(8)), result.outcomes(range(8))
    leaving = np.argwhere((outcomes.outcome == "unstable") & (outcomes.left > 0.0))
    assert len(leaving) > 2
    pixels, samples = leaving.T
    values = under_node(
        "(chart, numbers, omega, attitude, left) => left.map((end, k) => quantityOf("
        "chart, numbers[k], motionOf(numbers[k], omega[k], attitude[k], [0.0, end])))",
        {name: value for name, value in chart.items() if name != "limits"},
        numbers[pixels],
        starts.omega[pixels, samples],
        starts.attitude[pixels, samples],
        outcomes.left[pixels, samples],
    )
    for pixel, of_body in zip(pixels, values, strict=True):
        at = np.array(of_body)[:, -1]
        reached = [np.abs(at - limit[pixel]).min() for limit in limits]
        # Maps whose step is chosen for each body err by about 1e-8 rad, which is 6e-7 degrees. A
        # moon that tumbles past its planet enlarges errors tenfold.
        assert min(reached) < (1e-5 if scene is MOON else 1e-6)


def test_joined_criteria_share_the_charts_of_what_they_watch() -> None:
    result = tops(
        scene=SPUN,
        stable=rigid.tilt_below(0.9)
        & rigid.spin_above(1.0, axis=3)
        & (rigid.tilt_below(0.5) | ~rigid.near_start(2.0)),
    )
    charts = content(result.explore())["charts"]
    labels = ["tilt of axis 3 from the vertical (°)", "ω₃ (rad/s)", "rotation from the start (°)"]
    assert [chart["label"] for chart in charts] == [*labels, "ω (rad/s)"]
    limits = [[unpacked(limit)[0] for limit in chart["limits"]] for chart in charts]
    assert limits == [list(np.rad2deg([0.9, 0.5])), [1.0], [np.rad2deg(2.0)], []]


def test_an_axis_of_limits_gives_each_pixel_its_own() -> None:
    result = tops(axes={"spin": [3.0, 5.0], "limit": [0.3, 0.6, 0.9]})
    (limits,) = content(result.explore())["charts"][0]["limits"]
    np.testing.assert_allclose(unpacked(limits), np.rad2deg([0.3, 0.3, 0.6, 0.6, 0.9, 0.9]))


def test_regular_maps_show_tilt_and_rates_without_a_limit() -> None:
    result = tops(axes={"spin": [3.0]}, stable=rigid.regular(), samples=1, t_end=50.0)
    charts = content(result.explore())["charts"]
    assert [(chart["label"], chart["limits"]) for chart in charts] == [
        ("tilt of the centre of mass from the vertical (°)", []),
        ("ω (rad/s)", []),
    ]


@pytest.mark.parametrize("eccentricity", [0.0, 0.1])
def test_the_distance_of_the_planet_has_a_chart_where_it_changes(eccentricity: float) -> None:
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=rigid.Orbit(0.5, eccentricity)),
        axes={"spin": [1.0]},
        samples=1,
        t_end=1.0,
        stable=rigid.librates(),
        start=rigid.Start(spin=1.0, axis=3),
    )
    labels = [chart["label"] for chart in content(result.explore())["charts"]]
    assert any("distance" in label for label in labels) == (eccentricity > 0.0)


def test_lines_of_theory_are_fine_and_told_apart_by_dashes() -> None:
    """Pitch is stable above I1 = I3, which the pixels would draw as a stair."""
    spec = read_spec("gravity-gradient").spec
    axes = {axis.name: [0.5, 0.8, 1.1, 1.4, 1.7, 2.0] for axis in spec.axes}
    result = rigid.stability_map(spec.replace(samples=1, axes=axes, t_end=1.0), progress=False)
    curves = content(result.explore())["curves"]
    assert [(one["label"], one["dashes"]) for one in curves] == [
        ("DeBra-Delp: roll and yaw stable", "solid"),
        ("pitch stable", "dashed"),
    ]
    line = unpacked(curves[1]["planes"]["0"]).reshape(-1, 2)
    ends = np.isnan(line[:, 0])
    assert (np.isnan(line).all(axis=1) == ends).all()
    np.testing.assert_allclose(line[~ends, 0], line[~ends, 1], atol=1e-6)  # floats of 24 bits
    assert len(line) > 15


def test_a_page_has_a_layer_of_each_measure() -> None:
    result = tops(measure=[rigid.largest_tilt(), rigid.flips(1)])
    layers = content(result.explore())["layers"]
    for name in ("largest_tilt(3)", "flips(1)"):
        for of in ("mean", "least", "largest"):
            (layer,) = (layer for layer in layers if layer["name"] == f"{name}.{of}")
            meant = getattr(result.measures[name], of).ravel().astype(np.float32)
            np.testing.assert_array_equal(unpacked(layer["data"]), meant)


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_a_page_says_from_when_on_a_chaotic_motion_is_doubtful() -> None:
    # A start in the chaotic sea of the built-in map, and a fast, regular one.
    com = np.array([0.30076793861678304, 0.20051195907785537, 0.9323806097120270])
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=com)
    t = np.linspace(0.0, 200.0, 2001)
    numbers = numbers_of_motion(nominal_starts(top, AT_REST))[0]
    attitude = [np.cos(0.5), np.sin(0.5), 0.0, 0.0]
    found = []
    for spin in (2.0, 40.0):
        omega = np.array([0.0, 0.0, spin])
        twins = [omega, omega + 1e-12 * spin * np.array([0.6, -0.64, 0.48])]
        run: Any = rigid.simulate(top, twins, attitude, t=t, method="taylor26")
        apart = np.maximum(
            np.linalg.norm(run.omega[1] - run.omega[0], axis=-1) / spin,
            np.linalg.norm(run.attitude[1] - run.attitude[0], axis=-1),
        )
        meant = float(t[np.argmax(apart > 0.01)]) if apart.max() > 0.01 else np.inf
        seen = under_node(
            "(n, w, q, t) => doubtfulFrom(n, w, q, t, motionOf(n, w, q, t))",
            numbers,
            omega,
            attitude,
            t,
        )
        found.append((np.inf if seen is None else float(seen), meant))
    (chaotic, meant), regular = found
    assert 20.0 < meant < 180.0
    # Rounding errors change the deviation vector by 1e-3 of it, and its time by less than two of t.
    assert abs(chaotic - meant) <= 0.2
    assert regular == (np.inf, np.inf)


# In a browser


@pytest.mark.browser
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (375, "dark")])
def test_the_explorer_works_in_a_browser(opens: Any, page: Path, width: int, scheme: str) -> None:
    opened = opens(page, width=width, height=800, scheme=scheme, shows=".map[data-ready]")
    inks = "new Set(new Uint32Array(document.querySelector('.map').getContext('2d')"
    inks += ".getImageData(0, 0, 300, 200).data.buffer)).size"
    assert opened.evaluate(inks) > 10
    place = opened.locator(".map").bounding_box()
    opened.locator(".map").click(
        position={"x": 25.0 + 0.5 * place["width"], "y": 0.4 * place["height"]}
    )
    opened.wait_for_selector("canvas.stage")
    first = opened.evaluate("location.hash")
    assert re.fullmatch(r"#layer=share&pixel=2,3&body=\d", first)
    start = BOX.starts(3, pixel=(2, 3))
    drawn = opened.evaluate("explorer.bodies.start(3)")
    assert drawn == [start.omega.tolist(), start.attitude.tolist()]
    line = opened.locator(".python").text_content()
    assert re.fullmatch(r"result\.replay\(pixel=\(2, 3\), sample=\d\)", line)
    assert opened.locator(".dots button").count() == 6
    opened.press("n")
    assert opened.evaluate("location.hash") != first
    opened.press("p")
    assert opened.evaluate("location.hash") == first
    # The film runs, and its canvas is not blank.
    frame = "explorer.player.frame"
    opened.evaluate("explorer.player.play(true)")
    opened.wait_for_function(f"{frame} > 3")
    opened.evaluate("explorer.player.play(false)")
    stage = opened.pixels("canvas.stage")
    assert len(np.unique(stage.reshape(-1, 3), axis=0)) > 200
    assert len(stage) > 100
    assert opened.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.browser
def test_the_address_restores_the_view(opens: Any, page: Path) -> None:
    opened = opens(page, address="#layer=upper&pixel=1,2&body=3", shows="canvas.stage")
    assert opened.locator(".python").text_content() == "result.replay(pixel=(1, 2), sample=3)"
    assert opened.locator("select.layer").input_value() == "upper"


@pytest.mark.browser
def test_the_keyboard_alone_explores_a_map(opens: Any, page: Path) -> None:
    opened = opens(page, address="#pixel=2,3", shows="canvas.stage")
    opened.locator(".map").focus()
    opened.press("ArrowRight")
    opened.press("ArrowUp")
    assert opened.evaluate("explorer.index(explorer.pixel)") == [3, 4]
    said = opened.locator(".chosen")
    assert said.get_attribute("aria-live") == "polite"
    assert said.text_content().startswith(
        "side b = 0.1667 m, perturbation of the rates = 1 rad/s — "
    )
    whole = opened.evaluate("explorer.view")
    opened.press("+")
    near = opened.evaluate("explorer.view")
    assert near[1] - near[0] == pytest.approx(0.7 * (whole[1] - whole[0]))
    assert near[0] < 0.1667 < near[1]
    opened.press("0")
    assert opened.evaluate("explorer.view") == whole
    assert opened.evaluate("explorer.player.speed") == 1  # the film has the same keys elsewhere
    # All that can be pressed or chosen has a name.
    unnamed = (
        "[...document.querySelectorAll('button, select, input, canvas, [role]')].filter(one =>"
    )
    unnamed += " !(one.textContent.trim() && one.tagName == 'BUTTON') && !one.ariaLabel &&"
    unnamed += " !one.labels?.length).map(one => one.outerHTML)"
    assert opened.evaluate(unnamed) == []


@pytest.mark.browser
def test_charts_and_layers_are_chosen_and_kept(opens: Any, tmp_path: Path) -> None:
    result = tops(
        stable=rigid.tilt_between(0.001, 0.5) & rigid.near_start(2.0),
        measure=[rigid.largest_tilt()],
    )
    page = result.explore(tmp_path / "joined.html")
    where = "#layer=largest_tilt(3).mean&chart=1&pixel=1,2&body=0"
    opened = opens(page, address=where, width=375, height=800, shows="canvas.strip")
    strip = "explorer.player.films[0].chart"
    assert opened.evaluate(f"{strip}.label") == "rotation from the start (°)"
    assert "mean of the pixel" in opened.locator(".legend").text_content()
    assert opened.evaluate("document.documentElement.scrollWidth") <= 375
    opened.locator("select.quantity").select_option(index=0)
    opened.settle()
    assert opened.evaluate(f"{strip}.limits") == list(np.rad2deg([0.5, 0.001]))[::-1]
    assert "chart" not in opened.evaluate("location.hash")


@pytest.mark.browser
@pytest.mark.parametrize("swapped", [False, True])
def test_the_chart_is_that_of_the_limit_that_a_body_meets(
    swapped: bool, opens: Any, tmp_path: Path
) -> None:
    """A body of 2 rad/s has turned by 2 rad after 1 s; damping halves its spin after 10 s."""
    parts = [rigid.spin_above(1.0), rigid.near_start(2.0)][:: -1 if swapped else 1]
    body = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=np.diag([0.1, 0.1, 0.2]))
    result = tops(scene=body, axes={"spin": [2.0, 2.1]}, stable=parts[0] & parts[1], start=TURNED)
    assert (result.outcomes(range(4)).left < 2.0).all()
    opened = opens(result.explore(tmp_path / "a.html"), shows="canvas.stage")
    strip = "explorer.player.films[0].chart"
    assert opened.evaluate(f"{strip}.label") == "rotation from the start (°)"
    opened.locator("select.quantity").select_option("|ω| (rad/s)")
    opened.press("n")  # what the reader has chosen stays
    assert opened.evaluate(f"{strip}.label") == "|ω| (rad/s)"


@pytest.mark.browser
def test_times_and_rates_are_those_of_the_clock_of_the_map(opens: Any, tmp_path: Path) -> None:
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), orbit=rigid.Orbit(1.0, 0.1)),
        axes={"spin": [1.0, 2.6]},
        start=rigid.Start(spin=1.0, axis=3, tilt=0.3, noise=rigid.normal(0.1)),
        stable=rigid.pointing_within(0.5, 1),
        t_end=4.0 * np.pi,
        samples=4,
        rng=3,
        time_unit="orbit",
    )
    opened = opens(
        result.explore(tmp_path / "a.html"), address="#pixel=1&body=0", shows="canvas.stage"
    )
    left = result.outcomes(0, pixel=1).left
    assert f"left at {left / (2.0 * np.pi):.4g} orbits" in opened.locator(".chosen").inner_text()
    assert "spin = 2.6 n" in opened.locator(".chosen").inner_text()
    opened.press("End")
    assert opened.locator("#player output").inner_text() == "t = 2.000 orbits"
    assert "ω (n)" in opened.locator("select.quantity").inner_text()


@pytest.mark.browser
def test_a_page_says_what_an_old_browser_lacks(browser: Any, page: Path) -> None:
    old = Opened(browser, page, before="delete window.DecompressionStream")
    said = old.page.locator(".detail").text_content()
    assert said.startswith("The map cannot be shown: this browser cannot unpack the map; it needs")
    old.page.close()
    # Without scripts the page says so itself.
    shown = browser.new_page(java_script_enabled=False)
    shown.goto(page.as_uri())
    assert "where scripts run" in shown.locator(".detail").text_content()
    shown.close()


@pytest.mark.browser
def test_films_are_drawn_without_webgl(opens: Any, page: Path) -> None:
    without = "const got = HTMLCanvasElement.prototype.getContext;"
    without += "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
    without += " return kind === 'webgl2' ? null : got.call(this, kind, ...more); };"
    opened = opens(page, address="#pixel=1,2&body=3", before=without, shows="canvas.stage")
    assert "without WebGL2" in opened.locator("#player h2").text_content()
    stage = opened.pixels("canvas.stage")
    assert len(np.unique(stage.reshape(-1, 3), axis=0)) > 50


@pytest.mark.browser
def test_a_page_opens_at_the_border_of_stability(opens: Any, page: Path) -> None:
    opened = opens(page, shows="canvas.stage")
    share = BOX.share.ravel()
    pairs = [(k, k + 1) for k in range(28) if k % 7 < 6] + [(k, k + 7) for k in range(21)]
    crossed = [pair for pair in pairs if len({share[k] < 0.5 for k in pair}) == 2]
    border = {k for pair in crossed for k in pair
              if abs(share[k] - 0.5) == min(abs(share[list(pair)] - 0.5))}  # fmt: skip
    far = {k: np.hypot((k % 7 + 0.5) / 7 - 0.5, (k // 7 + 0.5) / 4 - 0.5) for k in border}
    opened_at = opened.evaluate("explorer.pixel")
    assert far[opened_at] == pytest.approx(min(far.values()))
    assert opened.locator(".chosen").text_content().startswith("side b = ")


DOUBLES = ctypes.POINTER(ctypes.c_double)


@ctypes.CFUNCTYPE(None, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES)  # type: ignore[untyped-decorator]
def braking(t: float, omega: Any, attitude: Any, data: Any, torque: Any) -> None:
    for k in range(3):
        torque[k] = -0.1 * omega[k]


CALLED = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=rigid.Torque.call(braking, fastest=1.0))


def test_motions_under_the_torque_of_a_function_are_not_in_the_page() -> None:
    result = tops(scene=CALLED, axes={"spin": [1.0, 2.0]}, stable=rigid.no_flip(3), start=None)
    assert content(result.explore())["motion"] is None


def test_bodies_that_vary_along_an_ephemeris_have_a_page_without_motions() -> None:
    t = np.linspace(0.0, 6.0, 61)
    path = rigid.Orbit.table(t, rigid.Orbit(1.0, 2.0, -3.0).position(t), gm=1.0)
    scene = rigid.FreeBody(rigid.Body((0.61, 0.965, 1.0)), orbit=path)
    result = rigid.stability_map(
        scene,
        axes={"spin": [0.4, 0.6]},
        vary={"I1": rigid.normal(0.02)},
        stable=rigid.no_flip(3),
        samples=4,
        t_end=6.0,
        rng=1,
    )
    assert content(result.explore())["motion"] is None


def longer(spin: Any) -> rigid.FreeBody:
    return rigid.FreeBody(rigid.Body(np.stack([spin, 1.1 * spin, 1.5 * spin], axis=-1)))


def forward(states: Any) -> Any:
    return states.omega[:, -1, 0] > 0.0


nameless = lambda states: states.omega[:, -1, 0] > 0.0  # noqa: E731


@pytest.mark.parametrize(
    ("given", "names"),
    [
        ({"scene": rigid.FreeBody, "stable": rigid.no_flip(), "t_end": 5.0}, {}),
        ({"scene": CALLED, "stable": rigid.no_flip(), "t_end": 5.0}, {"scene": CALLED}),
        (
            {"scene": rigid.FreeBody, "stable": rigid.judged(forward, [0.0, 5.0])},
            {"forward": forward},
        ),
        (
            {"scene": longer, "stable": rigid.judged(nameless, [0.0, 5.0])},
            {"longer": longer, "stable": nameless},
        ),
    ],
)
def test_the_copied_python_names_what_no_file_has(
    given: dict[str, Any], names: dict[str, Any], tmp_path: Path
) -> None:
    result = rigid.stability_map(**given, axes={"spin": [1.0, 2.0]}, samples=2, rng=1)
    result.save(tmp_path / "map.npz")
    code = content(result.explore(tmp_path / "map.html"))["load"]
    notes = [line for line in code.splitlines() if line.startswith("#")]
    words = f"# First define {' and '.join(names)} as for the map: no file has functions."
    assert notes == ([words] if names else [])
    known = dict(names)
    with contextlib.chdir(tmp_path):
        exec(code, known)
    assert not known["result"].spec.misses_functions


@pytest.mark.browser
@pytest.mark.parametrize("pixel", ["2,3", "0,6"])
def test_the_copied_python_runs_as_it_is(
    pixel: str, opens: Any, page: Path, tmp_path: Path
) -> None:
    keep = "navigator.clipboard.writeText = async text => { window.copied = text; }"
    opened = opens(page, address=f"#pixel={pixel}&body=4", before=keep, shows="canvas.stage")
    opened.locator(".copy").click()
    opened.wait_for_function("window.copied")
    code = opened.evaluate("window.copied")
    start = opened.evaluate("explorer.bodies.start(4)")
    BOX.save(tmp_path / page.with_suffix(".npz").name)
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            f"{code}import json; print(json.dumps([body.omega.tolist(), body.attitude.tolist()]))",
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout) == start
    assert (tmp_path / "body.html").stat().st_size > 50_000


@pytest.mark.browser
def test_the_copied_python_of_a_map_of_chaos_draws_the_growth(opens: Any, tmp_path: Path) -> None:
    result = tops(axes={"spin": [3.0]}, stable=rigid.regular(), samples=1, t_end=50.0)
    keep = "navigator.clipboard.writeText = async text => { window.copied = text; }"
    opened = opens(result.explore(tmp_path / "map.html"), before=keep, shows="canvas.stage")
    opened.locator(".copy").click()
    opened.wait_for_function("window.copied")
    code = opened.evaluate("window.copied")
    result.save(tmp_path / "map.npz")
    with contextlib.chdir(tmp_path):
        exec(code, {})
    assert (tmp_path / "body.png").stat().st_size > 5000


@pytest.mark.browser
def test_samples_are_one_stop_of_the_tabulator(opens: Any, page: Path) -> None:
    opened = opens(page, address="#pixel=2,3&body=3", shows="canvas.stage")

    def focused() -> str:
        return str(opened.evaluate("document.activeElement.dataset.sample ?? ''"))

    opened.locator(".map").focus()
    stops = []
    for _ in range(6):
        opened.press("Tab")
        stops.append(focused())
    assert stops == ["", "3", "", "", "", ""]  # first the button of the previous body
    opened.locator(".dots [tabindex='0']").focus()
    order = [str(one) for one in opened.evaluate("explorer.order")]
    at, frame = order.index("3"), opened.evaluate("explorer.player.frame")
    for key, by in [("ArrowRight", 1), ("ArrowDown", 2), ("ArrowLeft", 1)]:
        opened.press(key)
        assert focused() == order[(at + by) % 6]
        assert opened.evaluate("explorer.sample") == int(focused())
        assert opened.evaluate("explorer.player.frame") == frame
    opened.press("End")
    assert focused() == order[-1]
    opened.press("Home")
    assert focused() == order[0]
    assert opened.locator(".dots [tabindex='0']").count() == 1


@pytest.mark.browser
def test_on_a_phone_a_tap_shows_the_bodies_without_a_jump(opens: Any, page: Path) -> None:
    opened = opens(page, width=375, height=720, touch=True, shows="canvas.stage")
    tops = "['.map', '.chosen', '.dots', '#player'].map(n => find(n).getBoundingClientRect().top)"
    places = f"(find => {tops})(name => document.querySelector(name))"
    before = opened.evaluate(places)
    opened.locator(".map").tap(position={"x": 285.0, "y": 90.0})
    opened.wait_for_function("explorer.index(explorer.pixel).join() === '2,5'")
    assert opened.evaluate("scrollY") == 0
    assert opened.evaluate(places) == before
    assert before[2] < 720  # what the bodies are is in view, below the map
    assert not opened.locator(".note").is_visible()  # folded
    assert opened.locator(".hint .touch").is_visible()
    assert not opened.locator(".hint .mouse").is_visible()


@pytest.mark.browser
def test_a_third_axis_is_chosen_and_has_its_own_lines_of_theory(opens: Any, tmp_path: Path) -> None:
    """A sleeping top is stable above the spin 2 √(mgl I1) / I3, which the weight moves."""
    result = tops(
        scene=rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
        axes={
            "spin": np.linspace(3.0, 6.0, 7),
            "attitude_noise": [1e-3, 1e-2, 0.1],
            "mgl": [0.75, 1.5],
        },
    )
    page = result.explore(tmp_path / "a.html")
    (curve, _) = content(page)["curves"]
    assert curve["label"].startswith("sleeping-top bound")
    for plane, mgl in (("0", 0.75), ("1", 1.5)):
        spins = unpacked(curve["planes"][plane]).reshape(-1, 2)[:-1, 0]
        # The field is linear in the square of the spin: a chord of h errs by h² / 8 over it.
        np.testing.assert_allclose(spins, 2.0 * np.sqrt(mgl) / 0.5, atol=0.125**2 / 8.0 / 3.0)
    opened = opens(page, shows="canvas.stage")
    assert opened.locator(".slices select option").all_text_contents() == ["0.75", "1.5"]
    opened.locator(".slices select").select_option("1.5")
    opened.locator(".map").click(position={"x": 300.0, "y": 150.0})
    opened.wait_for_function("explorer.index(explorer.pixel)[0] === 1")
    assert "mgl = 1.5 J" in opened.locator(".chosen").inner_text()


@pytest.mark.browser
def test_many_bodies_stand_in_one_row_on_a_phone(opens: Any, tmp_path: Path) -> None:
    result = tops(samples=40, axes={"spin": [3.0, 4.0]})
    opened = opens(result.explore(tmp_path / "a.html"), width=375, height=720, shows="canvas.stage")
    of_dots = "[...document.querySelectorAll('.dots button')]"
    assert opened.evaluate(f"new Set({of_dots}.map(dot => dot.offsetTop)).size") == 1
    assert opened.evaluate("document.documentElement.scrollWidth") <= 375
    for _ in range(2):
        opened.press("p")  # from the first body to the last, and back by one
        row, dot = (
            opened.locator(name).bounding_box() for name in (".dots", ".dots [aria-pressed=true]")
        )
        assert row["x"] <= dot["x"]
        assert dot["x"] + dot["width"] <= row["x"] + row["width"]
        assert opened.evaluate("scrollY") == 0


@pytest.mark.browser
def test_fingers_find_targets_of_44_pixels(opens: Any, page: Path) -> None:
    opened = opens(page, width=375, height=720, touch=True, shows="canvas.stage")
    small = "[...document.querySelectorAll('button, select, input, summary')].filter(one => {"
    small += " const box = one.getBoundingClientRect();"
    small += (
        " return box.width && (box.width < 44 || box.height < 44); }).map(one => one.outerHTML)"
    )
    assert opened.evaluate(small) == []
    levels = "[...document.querySelectorAll('h1, h2, h3')].map(one => one.tagName).join()"
    assert opened.evaluate(levels) == "H1,H2"


@pytest.mark.browser
def test_two_fingers_zoom_where_they_are_and_one_moves(opens: Any, page: Path) -> None:
    opened = opens(page, width=375, height=720, touch=True, shows="canvas.stage")
    box = opened.locator(".map").bounding_box()
    driver = opened.context.new_cdp_session(opened.page)

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
        driver.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        opened.settle()

    x, y = box["x"] + 200.0, box["y"] + 120.0
    at = f"explorer.from({{clientX: {x}, clientY: {y}}}).slice(0, 2)"
    chosen, whole, middle = (
        opened.evaluate(one) for one in ("explorer.pixel", "explorer.view", at)
    )
    touch("touchStart", (x - 20.0, y), (x + 20.0, y))
    touch("touchMove", (x - 30.0, y), (x + 30.0, y))
    touch("touchMove", (x - 40.0, y), (x + 40.0, y))
    touch("touchEnd")
    near = opened.evaluate("explorer.view")
    assert near[1] - near[0] == pytest.approx(0.5 * (whole[1] - whole[0]))
    assert opened.evaluate(at) == pytest.approx(middle)
    width = opened.evaluate("explorer.room().right - explorer.room().left")
    touch("touchStart", (x, y))
    touch("touchMove", (x + 10.0, y))
    touch("touchMove", (x + 30.0, y))
    touch("touchEnd")
    moved_to = opened.evaluate("explorer.view")
    assert near[0] - moved_to[0] == pytest.approx(30.0 / width * (near[1] - near[0]))
    assert opened.evaluate("explorer.pixel") == chosen


@pytest.mark.browser
def test_buttons_zoom_and_a_hint_says_how(opens: Any, page: Path) -> None:
    opened = opens(page, shows="canvas.stage")
    assert opened.locator(".hint .mouse").inner_text() == (
        "click a pixel · wheel or + − zooms · drag moves"
    )
    whole = opened.evaluate("explorer.view")
    opened.locator(".closer").click()
    opened.locator(".closer").click()
    near = opened.evaluate("explorer.view")
    assert near[1] - near[0] == pytest.approx(0.49 * (whole[1] - whole[0]))
    opened.locator(".farther").click()
    far = opened.evaluate("explorer.view")
    assert far[1] - far[0] == pytest.approx(0.7 * (whole[1] - whole[0]))
    opened.locator(".whole").click()
    assert opened.evaluate("explorer.view") == whole


@pytest.mark.browser
def test_all_bodies_of_a_pixel_are_counted_and_the_colours_explained(
    opens: Any, tmp_path: Path
) -> None:
    result = tops(
        scene=rigid.FreeBody,
        axes={"I2/I1": [0.3, 1.2, 1.5, 1.9], "noise": [0.01, 0.3]},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
        stable=rigid.no_flip(2),
        samples=9,
    )
    assert (result.status[:, 0] > 0).all()  # no body has these moments
    opened = opens(
        result.explore(tmp_path / "a.html", samples=2), address="#pixel=1,2", shows="canvas.stage"
    )
    counts = [
        int(getattr(result, name)[1, 2]) for name in ("stable", "unstable", "undecided", "failed")
    ]
    said = opened.locator(".kinds").inner_text()
    assert [int(number) for number in re.findall(r"(\d+) [a-z]+", said)][:4] == counts
    assert said.endswith("of 9 bodies; the first 2 are here")
    share, low, high = (
        float(f"{getattr(result, name)[1, 2]:.3g}") for name in ("share", "lower", "upper")
    )
    assert opened.locator(".facts").inner_text() == (
        f"share stable {share:g}, 95 % interval {low:g} to {high:g}"
    )
    inks = "[...document.querySelectorAll('.kinds i')].map(one => one.style.backgroundColor)"
    rgb = [tuple(bytes.fromhex(ink[1:])) for ink in colours.OUTCOMES.values()]
    assert opened.evaluate(inks) == [f"rgb{ink}" for ink in rgb]
    assert "no such body" in opened.locator(".legend").inner_text()


@pytest.mark.browser
def test_times_of_a_page_are_in_the_unit_of_the_map(opens: Any, tmp_path: Path) -> None:
    """Half a second is a beat: twice the number of seconds, at the dots and at the clock."""
    result = tops(axes={"spin": [2.0]}, samples=3, t_end=30.0, time_unit=("beat", 0.5))
    assert result.unstable.sum() == 3
    opened = opens(result.explore(tmp_path / "a.html"), shows="canvas.stage")
    for dot in opened.locator(".dots button").all():
        found: Any = re.search(r"left at (\S+) beat", str(dot.get_attribute("title")))
        body = result.replay(0, int(str(dot.get_attribute("data-sample"))))
        assert float(found[1]) == pytest.approx(2.0 * body.left, rel=1e-3)
    opened.evaluate("explorer.player.seek(explorer.player.films[0].t.length - 1)")
    opened.wait_for_function("document.querySelector('output').textContent.startsWith('t = 60')")
    assert opened.locator("output").inner_text().endswith(" beat")


@pytest.mark.browser
def test_regular_maps_speak_of_chaos(opens: Any, tmp_path: Path) -> None:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.36, 0.48, 0.8))
    result = tops(
        scene=top, axes={"spin": [2.0, 4.0]}, stable=rigid.regular(), samples=3, t_end=300.0,
        start=rigid.Start(spin=1.0, axis=3, tilt=1.0, noise=rigid.normal(0.3)),
    )  # fmt: skip
    assert result.unstable.sum() > 0
    opened = opens(result.explore(tmp_path / "a.html"), shows="canvas.stage")
    words = opened.locator("#explorer").inner_text()
    words += "".join(dot.get_attribute("title") for dot in opened.locator(".dots button").all())
    assert "chaotic" in words
    assert "left at" not in words
    assert not re.search(r"\b(un)?stable\b", words)
    assert "share regular" in opened.locator(".legend").inner_text()
    opened.locator("select.layer").select_option("undecided")
    assert "share undecided" in opened.locator(".legend").inner_text()


@pytest.mark.browser
def test_an_explorer_follows_the_theme_of_its_page(opens: Any, page: Path) -> None:
    # The page around sends its theme once the frame is loaded, perhaps before the map is unpacked.
    early = "addEventListener('load', () => postMessage({rigidTheme: 'dark'}, '*'))"
    opened = opens(page, before=early, shows="canvas.stage")
    opened.settle()
    for selector in (".map", "canvas.stage", ".strip"):
        assert opened.pixels(selector)[2, 2].mean() < 60
    opened.evaluate("postMessage({rigidTheme: 'light'}, '*')")
    opened.settle()
    opened.settle()
    for selector in (".map", "canvas.stage", ".strip"):
        assert opened.pixels(selector)[2, 2].mean() > 200


@pytest.mark.browser
def test_a_map_in_a_notebook_keeps_no_address(opens: Any, tmp_path: Path) -> None:
    (tmp_path / "book.html").write_text(BOX.explore(samples=2)._repr_html_(), encoding="utf-8")
    opened = opens(tmp_path / "book.html")
    frame = opened.frames[1]
    frame.wait_for_selector("canvas.stage")


# The starts that the page of the explorer draws, against those of the core


@pytest.mark.skipif(NODE is None, reason="needs node")
def test_a_product_and_a_sum_are_rounded_once() -> None:
    rng = np.random.default_rng(5)
    tiny = [0.0, 1.0, -1.0, 2.0**-53, -(2.0**-106), 1e-290, -1e-290, 1e100, 1.0 + 2.0**-52]
    numbers = np.concatenate([tiny, rng.normal(size=6)])
    asked = list(itertools.product(numbers.tolist(), repeat=3))
    asked = [one for one in asked if abs(one[0] * one[1]) > 1e-300 or 0.0 in one[:2]]
    found = under_node("cases => cases.map(one => fma(...one))", asked)
    # The quotient of two whole numbers is correctly rounded in Python.
    exact = [Fraction(a) * Fraction(b) + Fraction(c) for a, b, c in asked]
    assert found == [float(one) for one in exact]


LAWS: list[Callable[..., rigid.Noise]] = [rigid.normal, rigid.uniform, rigid.direction]


@pytest.mark.skipif(NODE is None, reason="needs node")
@pytest.mark.parametrize(
    ("noise", "attitude_noise"),
    [
        *((law(0.3), None) for law in LAWS),
        *((law([0.1, 0.0, 1e-3]), law(size)) for law in LAWS for size in (1e-3, 3.0)),
        (None, rigid.uniform_attitude()),
    ],
)
def test_the_page_draws_the_starts_of_the_map_to_the_bit(noise: Any, attitude_noise: Any) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0),
        # Pixels of other horizons draw by the same numbers; one body has impossible moments.
        axes={"spin": [-3.0, 1.0, 4.0], "t_end": [0.1, 0.2], "I3": [0.5, 9.0]},
        start=rigid.Start(spin=1.0, axis=3, tilt=0.4, noise=noise, attitude_noise=attitude_noise),
        samples=40,
        stable=rigid.tilt_below(1.0),
        rng=2**100 + 7,
    )
    draw = content(result.explore())["draw"]
    arrays = {name: unpacked(packed) for name, packed in draw.items() if "type" in packed}
    found = under_node(
        "draw => { for (const name in draw) if (!['key', 'laws'].includes(name)) "
        "draw[name] = Float64Array.from(draw[name]); "
        "return [0, 2, 4].flatMap(pixel => "
        "Array.from({length: 40}, (_, k) => startOf(draw, pixel, k))); }",
        draw | {name: array.tolist() for name, array in arrays.items()},
    )
    meant = result.starts(range(40))
    for name, column in (("omega", 0), ("attitude", 1)):
        of_map = getattr(meant, name).reshape(12, 40, -1)[[0, 2, 4]]
        np.testing.assert_array_equal([body[column] for body in found], of_map.reshape(120, -1))


MIXED = rigid.mixture([rigid.Start(spin=1.0, axis=3), rigid.Start(spin=2.0, axis=3)])
GIVEN = rigid.samples(omega=[[0.1, 0.0, 0.0], [0.0, 0.2, 0.0]])


@pytest.mark.parametrize(
    "start",
    [
        MIXED,
        rigid.Start(spin=1.0, axis=3, noise=GIVEN),
        rigid.Start(spin=1.0, axis=3, noise=rigid.normal(cov=np.diag([0.1, 0.2, 0.3]))),
        rigid.Start(spin=1.0, axis=3, noise=rigid.von_mises_fisher(20.0)),
    ],
)
def test_a_page_holds_the_starts_that_it_does_not_draw(start: Any) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.5)), mgl=1.0),
        axes={"mgl": [0.6, 1.0]},
        start=start,
        samples=4,
        t_end=1.0,
        stable=rigid.tilt_below(1.0),
        rng=7,
    )
    held = content(result.explore())
    assert "draw" not in held
    meant = result.starts(range(held["samples"]))
    assert (unpacked(held["omega"]) == meant.omega.ravel()).all()
    assert (unpacked(held["attitude"]) == meant.attitude.ravel()).all()
