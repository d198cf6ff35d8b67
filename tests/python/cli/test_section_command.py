"""``rigid section``: a picture and the points, from a built-in section or a file."""

from pathlib import Path

import numpy as np
import pytest

import rigid
from printed_text import unwrapped
from rigid.cli import main
from rigid.cli.toml_section import read_section
from rigid.cli.toml_table import names_of

SPEC = """
title = "A small section"
[scene]
kind = "heavy-top"
moments = [1.0, 1.6, 0.7]
mgl = 1.2
com = [0.6, 0.0, 0.8]
[section]
name = "gamma1"
value = 0.1
direction = 1
[start]
energy = 2.0
l_gamma = 0.4
bodies = 5
seed = 3
[run]
points = 6
t_end = 500.0
[plot]
x = "gamma2"
y = "omega3"
"""


def test_a_section_writes_picture_and_points(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["section", "small.toml"]) == 0
    output, errors = capsys.readouterr()
    assert errors == ""
    first, *facts = output.splitlines()
    assert first == "<Crossings: 30 points of 5 bodies, gamma1 = 0.1, rising; complete>"
    assert [line.split() for line in facts] == [["data", "small.npz"], ["picture", "small.png"]]
    assert (folder / "small.png").read_bytes().startswith(b"\x89PNG\r\n")
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    surface = rigid.section("gamma1", 0.1)
    omega, attitude = rigid.top.on_surface(top, 2.0, 0.4, 5, section=surface, rng=3)
    points = rigid.poincare(top, omega, attitude, surface, t_end=500.0, count=6)
    with np.load("small.npz") as file:
        np.testing.assert_array_equal(file["t"], points.t)
        np.testing.assert_array_equal(file["gamma"], points.gamma)


def test_options_replace_what_the_file_says(folder: Path) -> None:
    assert (
        main(["section", "small.toml", "--bodies", "2", "--seed", "9", "--out", "other.npz"]) == 0
    )
    with np.load(folder / "other.npz") as file:
        assert set(file["body"].tolist()) == {0, 1}
    assert (folder / "other.png").exists()


@pytest.mark.parametrize("name", names_of("section"))
def test_a_built_in_section_is_complete(name: str, folder: Path) -> None:
    assert main(["section", name, "--bodies", "3"]) == 0
    with np.load(folder / f"{name}.npz") as file:
        assert file["complete"].all()
        assert (np.bincount(file["body"]) == read_section(name).points).all()


def test_built_in_sections_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sections"]) == 0
    lines = unwrapped(capsys.readouterr().out, indent=21)
    names = [line.split()[0] for line in lines.splitlines()]
    assert names == ["chaotic", "goryachev-chaplygin", "kovalevskaya", "lagrange"]


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ('name = "gamma1"', 'name = "gama1"', "[section] name = 'gama1'"),
        ("value = 0.1", "value = 1.1", "[section] value = 1.1: never crossed"),
        ("energy = 2.0", "energy = -3.0", "energy = -3.0: must be at least"),
        ("bodies = 5", "bodies = 0", "[start] bodies = 0: must be at least 1"),
        ("points = 6", "point = 6", "[run] unknown key 'point'"),
        ('x = "gamma2"', 'x = "height"', "[plot] x = 'height'"),
        (
            '"heavy-top"',
            '"free-body"',
            "kind = 'free-body': must be 'heavy-top', whose starts have one energy",
        ),
        ("t_end = 500.0", "t_end = 0.0", "[run] t_end = 0.0: must be positive"),
    ],
)
def test_mistakes_are_one_line(
    line: str, instead: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = SPEC.replace(line, instead, 1)
    if "free-body" in instead:
        text = text.replace("mgl = 1.2\ncom = [0.6, 0.0, 0.8]\n", "")
    (folder / "small.toml").write_text(text)
    assert main(["section", "small.toml"]) == 2
    output, errors = capsys.readouterr()
    assert output == ""
    assert errors.count("\n") == 1
    assert message in errors
    assert not (folder / "small.npz").exists()
