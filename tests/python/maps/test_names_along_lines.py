"""Names of lines of theory: beside their line, rotated as it is, and over no other line."""

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rigid.drawing.along import SIZE, _broken, write_along
from small_maps import Floats

DPI = 100
EM = SIZE / 72.0 * DPI
"""Size of the font (pixels)."""


def unit_square(size: tuple[float, float] = (6.4, 5.2)) -> Axes:
    ax = Figure(figsize=size, dpi=DPI).add_subplot()
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    return ax


def pixels(ax: Axes, points: Any) -> Floats:
    return np.asarray(ax.transData.transform(points))


def line(slope: float, height: float) -> Floats:
    x = np.linspace(0.0, 1.0, 50)
    return np.stack([x, height + slope * x], axis=1)


@pytest.mark.parametrize("size", [(6.4, 5.2), (3.2, 2.6)])
def test_a_name_lies_beside_its_line_and_over_no_other(size: tuple[float, float]) -> None:
    ax = unit_square(size)
    own, other = line(0.8, 0.0), line(0.8, 0.13)
    ends = write_along(ax, "a line", [own], [other])
    assert ends is not None
    (name,) = ax.texts
    first, last = pixels(ax, ends)
    begin, end = pixels(ax, [own[0], own[-1]])
    along = (end - begin) / np.hypot(*(end - begin))
    across = np.array([-along[1], along[0]])
    # Half a line of text from its own line; the name's height is 1.25 font sizes.
    assert abs((first - begin) @ across) == pytest.approx(0.625 * EM, rel=1e-6)
    assert (last - first) @ across == pytest.approx(0.0, abs=1e-6)
    assert name.get_rotation() == pytest.approx(np.degrees(np.arctan2(*along[::-1])), abs=1e-9)
    assert abs((first - pixels(ax, other[0])) @ across) > 0.625 * EM


def test_names_of_crossing_lines_do_not_overlap() -> None:
    ax = unit_square()
    lines = {"rising": line(1.0, 0.0), "falling": line(-1.0, 1.0), "level": line(0.0, 0.5)}
    written: list[Floats] = []
    for name, own in lines.items():
        others = [other for other in lines.values() if other is not own]
        ends = write_along(ax, name, [own], others + written)
        assert ends is not None
        written.append(ends)
    middles = [pixels(ax, np.linspace(ends[0], ends[1], 30)) for ends in written]
    for k, one in enumerate(middles):
        for other in middles[:k]:
            assert np.hypot(*(one[:, np.newaxis] - other).transpose(2, 0, 1)).min() > EM


def test_a_name_without_a_straight_stretch_is_not_written() -> None:
    """The circle has 0.04 x 500 pixels of radius, a name of eight letters needs 50 in a row."""
    ax = unit_square()
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    circle = 0.5 + 0.04 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert write_along(ax, "aname" * 6, [circle], []) is None
    assert not ax.texts


def test_a_long_name_is_broken_but_no_formula_and_no_time() -> None:
    assert list(_broken("passes $a + b = c$ by t = 40 s")) == [
        "passes $a + b = c$ by t = 40 s",
        "passes $a + b = c$\nby t = 40 s",
        "passes\n$a + b = c$ by\nt = 40 s",
    ]
