"""Times in the unit that a map has for words and pictures; its numbers stay in its own unit."""

import re
from math import tau
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from rigid.cli.toml_map import parse_spec, read_spec
from rigid.maps.page import content_of_map
from small_maps import assert_same_map

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
