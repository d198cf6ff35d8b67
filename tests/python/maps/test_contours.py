"""Lines where a field is zero, for the lines of theory in pages."""

import numpy as np
import pytest

from rigid.maps.contours import zero_lines


def test_a_circle_is_one_closed_line() -> None:
    h = 0.05
    x, y = np.arange(-30, 31) * h, np.arange(-25, 26) * h
    (line,) = zero_lines(x, y, x**2 + y[:, np.newaxis] ** 2 - 1.0)
    assert (line[0] == line[-1]).all()
    # The field has the second derivative 2: it is off a chord by up to h²/4, and its slope is 2.
    assert np.abs(np.hypot(*line.T) - 1.0).max() <= h * h / 8.0
    angles = np.unwrap(np.arctan2(*line.T))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi)


def test_a_line_ends_at_the_edges_and_where_the_field_is_unknown() -> None:
    x, y = np.linspace(-1.0, 1.0, 21), np.linspace(0.0, 2.0, 41)
    field = np.tile(x - 0.33, (41, 1))
    field[20] = np.nan
    first, second = sorted(zero_lines(x, y, field), key=lambda line: line[:, 1].min())
    np.testing.assert_allclose(np.concatenate([first, second])[:, 0], 0.33, rtol=1e-15)
    assert {0.0, y[19]} == {*first[[0, -1], 1]}
    assert {y[21], 2.0} == {*second[[0, -1], 1]}


def test_hyperbolas_do_not_meet() -> None:
    x = np.linspace(-2.0, 2.0, 41)
    lines = zero_lines(x, x, x * x[:, np.newaxis] - 0.1)
    assert len(lines) == 2
    # Each branch lies on one side, and x y is linear along every side of the grid.
    assert [len({*np.sign(line[:, 0])}) for line in lines] == [1, 1]
    for line in lines:
        np.testing.assert_allclose(np.prod(line, axis=1), 0.1, rtol=1e-13)
