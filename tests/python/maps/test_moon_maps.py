"""Maps of moons on eccentric orbits, and the lines where their rotation is in resonance."""

import re
from dataclasses import replace
from math import tau
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.cli.toml_map import parse_spec, read_spec
from rigid.maps.axes import make_axes
from rigid.maps.moons import averaged_torque
from rigid.maps.page import content_of_map
from rigid.maps.spec import MapSpec
from rigid.maps.theory import predict
from rigid.store.call import run_map
from small_maps import assert_same_map


def some_of(name: str, axes: dict[str, Any], samples: int) -> MapSpec:
    """A built-in map with other values of its axes."""
    return replace(read_spec(name).spec, axes=make_axes(axes), samples=samples)


COARSE: dict[str, dict[str, Any]] = {
    "dimorphos": {"a/b": [1.0, 1.15, 1.3, 1.45], "b/c": [1.05, 1.2, 1.35, 1.5]},
    "hyperion": {"spin": [0.5, 2.0, 3.5, 5.0], "tilt": [0.0, 1.0, 2.0, 3.0]},
    "spin-orbit": {"spin": [0.75, 1.0, 1.25, 1.5], "eccentricity": [0.0, 0.1, 0.4]},
}
LINES = {
    "dimorphos": [
        "libration at n/2",
        "libration at n",
        "slow mode of roll and yaw at n/2",
        "fast mode of roll and yaw at 3n/2",
    ],
    "hyperion": [],
    "spin-orbit": ["edges of 1:1", "edges of 3:2", "edges of 2:1"],
}


@pytest.mark.parametrize("name", COARSE)
def test_built_in_maps_of_moons_have_both_kinds_of_motion_and_their_lines(name: str) -> None:
    assert read_spec(name).spec.title
    result = run_map(some_of(name, COARSE[name], 1), progress=False)
    assert not result.failed.any()
    assert result.stable.sum() > 2
    assert result.unstable.sum() > 2
    whole = predict(read_spec(name).spec)
    assert ([] if whole is None else [curve.label for curve in whole.curves]) == LINES[name]
    if whole is not None:
        assert np.isnan(whole.share).all()
    assert ("lines, no shares" in result.summary()) == (result.theory() is not None)


def test_lines_of_a_moon_are_where_its_small_oscillations_have_half_the_rate_of_the_orbit() -> None:
    """By the eigenvalues of the linear equations of roll and yaw; the libration in closed form."""
    theory: Any = predict(read_spec("dimorphos").spec)
    ab, bc = (np.array(axis.values) for axis in read_spec("dimorphos").spec.axes)
    libration, whole, slow, fast = (curve.field for curve in theory.curves)
    # 3 (a² - b²)/(a² + b²) is 1/4 and 1.
    assert np.interp(0.0, libration[20], ab) == pytest.approx(np.sqrt(13.0 / 11.0), abs=1e-4)
    assert np.interp(0.0, whole[20], ab) == pytest.approx(np.sqrt(2.0), abs=1e-4)
    for row, column in ((10, 10), (25, 40), (50, 5)):
        a, b = ab[column] * bc[row], bc[row]
        along, across, normal = b * b + 1.0, a * a + 1.0, a * a + b * b
        # About rest on a circle: axes 1, 2, 3 away from the planet, along the motion, along the
        # normal; x and y are small turns about the first two.
        k1, k2 = (normal - along) / across, (normal - across) / along
        matrix = [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-k2, 0.0, 0.0, 1.0 - k2],
            [0.0, -4.0 * k1, k1 - 1.0, 0.0],
        ]
        rates = np.sort(np.abs(np.linalg.eigvals(np.array(matrix)).imag))[[0, 2]]
        assert slow[row, column] == pytest.approx(rates[0] - 0.5, abs=1e-12)
        assert fast[row, column] == pytest.approx(rates[1] - 1.5, abs=1e-12)


def test_a_moon_whose_libration_is_in_resonance_turns_over_and_its_neighbours_stay() -> None:
    on_the_line = float(np.sqrt(13.0 / 11.0))
    axes = {"a/b": [1.05, on_the_line, 1.13], "b/c": [1.15]}
    result = run_map(some_of("dimorphos", axes, 8), progress=False)
    assert result.share[0, 0] == result.share[0, 2] == 1.0
    assert result.share[0, 1] < 0.5


@pytest.mark.parametrize(
    ("p", "terms"),
    [
        (1.0, {0: 1.0, 2: -5.0 / 2.0, 4: 13.0 / 16.0, 6: -35.0 / 288.0}),
        (1.5, {1: 7.0 / 2.0, 3: -123.0 / 16.0, 5: 489.0 / 128.0}),
        (2.0, {2: 17.0 / 2.0, 4: -115.0 / 6.0, 6: 601.0 / 48.0}),
    ],
)
def test_the_averaged_torque_is_the_series_of_cayley(p: float, terms: dict[int, float]) -> None:
    e = np.array([0.0, 0.01, 0.05])
    series = sum(factor * e**power for power, factor in terms.items())
    # The next terms are e⁷ and e⁸ with factors of the order of 1.
    np.testing.assert_allclose(averaged_torque(p, e), series, rtol=0.0, atol=5.0 * 0.05**7)


def test_the_averaged_torque_does_not_depend_on_the_points_of_its_mean(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    e = np.array([0.3, 0.8, 0.95])
    found = averaged_torque(1.5, e)
    monkeypatch.setattr("rigid.maps.moons.PLACES", 1024)
    # Terms of the mean are up to 400: 400 times the rounding of a double.
    np.testing.assert_allclose(averaged_torque(1.5, e), found, rtol=0.0, atol=1e-13 * 400.0)


@pytest.mark.parametrize(("name", "p"), [("1:1", 1.0), ("3:2", 1.5), ("2:1", 2.0)])
def test_a_spin_between_the_edges_of_a_resonance_librates_and_one_outside_does_not(
    name: str, p: float
) -> None:
    """A nearly round moon, whose resonances are far apart: its mean spin is a multiple, or not."""
    moments, e = (0.9997, 1.0, 1.0003), 0.2
    strength = 3.0 * (moments[1] - moments[0]) / moments[2]
    half = float(np.sqrt(strength * averaged_torque(p, np.array([e]))[0]))
    t_end = 20.0 * 2.0 * np.pi / half
    # The swing with the orbit moves the edges by some percent of their distance.
    spins = p + half * np.array([-1.2, -0.8, 0.8, 1.2])
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(1.0)),
        axes={"spin": spins, "eccentricity": [0.5 * e, e]},
        start=rigid.Start(spin=1.0),
        stable=rigid.librates(),
        measure=rigid.spin_orbit_ratio(3),
        samples=1,
        t_end=t_end,
        check=0.0,
        rng=1,
    )
    off = np.abs(result.measures["spin_orbit_ratio(3)"].mean[1] - p)
    # Within an oscillation of pi to either side of the middle.
    assert (off[[1, 2]] < np.pi / t_end).all()
    # A pendulum that turns over at 1.2 of the edge does so at 0.7 of it on average.
    assert (off[[0, 3]] > 0.5 * half).all()
    theory: Any = result.theory()
    (edges,) = (curve.field for curve in theory.curves if curve.label == f"edges of {name}")
    assert (edges[1] > 0.0).tolist() == [False, True, True, False]


def lines_of(**changes: Any) -> list[str]:
    """The lines of a map of moons with such a change."""
    orbit = rigid.Orbit(1.0, changes.pop("eccentricity", 0.05), changes.pop("anomaly", 0.0))
    start = rigid.Start(omega=(0.0, 0.0, 1.0), **changes.pop("start", {}))
    scene = rigid.FreeBody(rigid.Body((0.6, 0.8, 1.0)), orbit=orbit, **changes.pop("forces", {}))
    axes = changes.pop("axes", {"a/b": [1.05, 1.2, 1.45], "b/c": [1.1, 1.45]})
    spec = replace(
        read_spec("dimorphos").spec,
        scene=scene,
        axes=make_axes(axes),
        start=start,
        **changes,
    )
    theory = predict(spec)
    return [] if theory is None else [curve.label for curve in theory.curves]


def test_lines_are_those_of_a_moon_that_faces_its_planet_on_an_ellipse() -> None:
    assert len(lines_of()) == 4
    assert len(lines_of(anomaly=np.pi, start={"noise": rigid.normal(0.01)})) == 4
    assert lines_of(eccentricity=0.0) == []
    assert lines_of(anomaly=0.5) == []
    assert lines_of(start={"attitude": (0.5, 0.5, 0.5, 0.5)}) == []
    assert lines_of(start={"attitude_noise": rigid.uniform_attitude()}) == []
    assert lines_of(forces={"rotor": (0.0, 0.0, 0.1)}) == []
    assert lines_of(axes={"a/b": [1.05, 1.45], "anomaly": [0.0, 1.0]}) == []
    edges = {"omega3": [0.5, 1.0, 1.5, 2.0, 2.5], "eccentricity": [0.1, 0.2]}
    assert lines_of(axes=edges) == ["edges of 1:1", "edges of 3:2", "edges of 2:1"]
    assert lines_of(axes=edges, anomaly=np.pi) == []


def test_a_picture_has_all_lines_and_a_title_that_fits() -> None:
    result = run_map(some_of("dimorphos", COARSE["dimorphos"], 1), progress=False)
    ax: Any = result.plot()
    legend = ax.get_legend()
    assert [text.get_text().replace("\n", " ") for text in ax.texts] == LINES["dimorphos"]
    assert not any("theory" in text.get_text() for text in legend.get_texts())
    ax.figure.canvas.draw()
    assert ax._left_title.get_window_extent().x1 < ax.figure.bbox.x1
    words = ax.get_title(loc="left")
    assert words.endswith("until t = 70 d\n1 body per pixel")


# Times in the unit that a map has for words and pictures; its numbers stay in its own unit.


DAY = 86400.0
RATE = 2.0e-6
"""Mean motion of a moon (rad/s)."""


def moon_map(rate: float = RATE, **options: Any) -> rigid.StabilityMap:
    """A moon of four spins on an eccentric orbit over twenty orbits, regular or chaotic."""
    request: dict[str, Any] = {
        "scene": rigid.FreeBody(
            rigid.Body((0.6, 0.85, 1.0)), orbit=rigid.Orbit(rate, eccentricity=0.1)
        ),
        "axes": {"spin": np.array([0.5, 1.0, 1.5, 2.0]) * rate},
        "start": rigid.Start(spin=1.0, axis=3),
        "stable": rigid.regular(),
        "t_end": 20.0 * tau / rate,
        "samples": 1,
        "rng": 1,
        "progress": False,
    }
    return rigid.stability_map(**{**request, **options})


@pytest.mark.parametrize(
    ("unit", "seconds", "words"),
    [
        ("s", 1.0, "6.28319e+07 s"),
        ("h", 3600.0, "1.75e+04 h"),
        ("d", DAY, "727 d"),
        ("a", 365.25 * DAY, "1.99 a"),
        ("orbit", tau / RATE, "20 orbits"),
        (("sol", 88775.2), 88775.2, "708 sol"),
    ],
)
def test_words_and_pictures_show_times_in_the_unit(unit: Any, seconds: float, words: str) -> None:
    pytest.importorskip("matplotlib")
    result = moon_map(time_unit=unit)
    name = unit if isinstance(unit, str) else unit[0]
    number = float(words.split()[0])
    assert number == pytest.approx(result.spec.t_end / seconds, rel=5e-3)  # three digits
    assert f"until t = {words}" in result.summary()
    assert f"until t = {words}" in result.plot().get_title(loc="left").replace("\n", " ")
    # An exponent times a unit of time is a pure number.
    told: Any = re.search(
        rf"exponents +largest (\S+)/{name}; none below (\S+)/{name}", result.summary()
    )
    largest = np.nanmax(result.largest_exponent)
    assert float(told[1]) == pytest.approx(largest * seconds, rel=5e-3)
    assert float(told[2]) == pytest.approx(10.0 / result.spec.t_end * seconds, rel=5e-3)
    drawn = result.plot(what="largest_exponent")
    assert drawn.get_ylabel() == f"largest exponent (1/{name})"
    assert drawn.lines[0].get_ydata() == pytest.approx(result.largest_exponent * seconds, rel=1e-15)
    layers = {layer["name"]: layer["label"] for layer in content_of_map(result, 1)["layers"]}
    assert layers["largest_exponent"] == f"largest exponent (1/{name})"


def test_no_number_depends_on_the_unit(tmp_path: Path) -> None:
    plain, shown = moon_map(), moon_map(time_unit="d")
    assert shown.spec != plain.spec
    assert shown.spec.replace(time_unit="s") == plain.spec
    assert shown.receipt()["key"] == plain.receipt()["key"]
    assert shown.receipt()["fingerprint"] == plain.receipt()["fingerprint"]
    assert "time_unit" not in plain.spec.to_dict()
    # A store goes on, whatever the unit.
    moon_map(store=tmp_path / "run")
    again = moon_map(store=tmp_path / "run", time_unit="orbit")
    assert (again.computed, again.complete) == (0, True)


@pytest.mark.parametrize("unit", ["d", "orbit", ("sol", 88775.2)])
def test_files_keep_the_unit(unit: Any, tmp_path: Path) -> None:
    result = moon_map(time_unit=unit)
    loaded = rigid.load_map(result.save(tmp_path / "moon.npz"))
    assert loaded.spec.time_unit == unit
    assert_same_map(loaded, result)
    assert rigid.MapSpec.from_json(result.spec.to_json()) == result.spec


def test_on_an_orbit_of_rate_one_rates_are_multiples_of_the_mean_motion() -> None:
    pytest.importorskip("matplotlib")
    result = moon_map(1.0, time_unit="orbit")
    assert result.plot().get_xlabel() == "spin over mean motion"
    assert content_of_map(result, 1)["axes"][0]["label"] == "spin over mean motion"
    facts = result.summary()
    assert "orbit at 1 n," in facts
    assert "spin from 0.5 to 2 n (4 values)" in facts
    assert "rad/s" not in facts
    # In seconds they are rates, as on an orbit of another rate.
    assert moon_map(1.0).plot().get_xlabel() == "spin (rad/s)"
    assert moon_map(time_unit="orbit").plot().get_xlabel() == "spin (rad/s)"


def test_measures_of_times_are_shown_in_the_unit() -> None:
    pytest.importorskip("matplotlib")
    leaving = rigid.time_to_leave()
    asked: dict[str, Any] = {"stable": rigid.pointing_within(0.5, 1), "measure": leaving}
    result = moon_map(time_unit="d", samples=9, **asked)
    measured = result.measures["time_to_leave"]
    drawn = result.plot(what="mean of time_to_leave")
    assert drawn.get_ylabel() == "mean of time_to_leave (d)"
    known = ~np.isnan(measured.mean)
    assert known.any()
    assert drawn.lines[0].get_ydata()[known] == pytest.approx(measured.mean[known] / DAY, rel=1e-15)
    mean: Any = re.search(r"time_to_leave: mean (\S+) d,", result.summary())
    assert float(mean[1]) == pytest.approx(measured.totals()[1] / DAY, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("apophis", "t = 41.7 d"),
        ("dimorphos", "t = 70 d"),
        ("gravity-gradient", "t = 15.9 orbits"),
        ("hyperion", "t = 79.6 orbits"),
        ("spin-orbit", "t = 63.7 orbits"),
    ],
)
def test_built_in_maps_with_orbits_have_their_unit(name: str, words: str) -> None:
    """Periods by hand: 100, 500 and 400 over 2 pi; 6.048e6 s and 3.6e6 s over 86400 s."""
    spec = read_spec(name).spec
    assert spec.horizon == words
    assert spec.criterion.endswith(f" until {words}")


def test_a_file_of_a_map_has_the_key() -> None:
    text = Path(rigid.__file__).with_name("builtin").joinpath("hyperion.toml").read_text()
    changed = parse_spec(text, "hyperion.toml", ['run.time_unit=["turn", 2.0]'])
    assert changed.time_unit == ("turn", 2.0)
    assert changed.horizon == "t = 250 turn"


def test_an_orbit_without_one_period_is_no_unit() -> None:
    flyby = rigid.FreeBody(rigid.Body((0.6, 0.85, 1.0)), orbit=rigid.Orbit(RATE, 4.0, -20.0))
    message = "time_unit = 'orbit': the scene must have one orbit with a period"
    with pytest.raises(ValueError, match=message):
        moon_map(scene=flyby, time_unit="orbit")
    with pytest.raises(ValueError, match="the orbits of this map have several periods"):
        moon_map(time_unit="orbit", axes={"rate": [RATE, 2.0 * RATE]})
