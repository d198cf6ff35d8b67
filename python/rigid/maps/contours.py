"""Lines where a field on a grid is zero, by marching squares."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arrays import Floats


def zero_lines(x: ArrayLike, y: ArrayLike, field: ArrayLike) -> list[Floats]:
    """Lines where a field is zero, linear between neighbouring points of its grid.

    Parameters
    ----------
    x, y : array_like, shapes (nx,), (ny,)
        Coordinates of the points.
    field : array_like, shape (ny, nx)
        The field; no line goes through a square with a NaN at the corner that the line needs.

    Returns
    -------
    list of ndarray, shape (points, 2)
        Each line from end to end; the first point of a closed line is its last point too.

    Examples
    --------
    >>> from rigid.maps.contours import zero_lines
    >>> [line.tolist() for line in zero_lines([0, 1, 2], [0, 1], [[-1, 1, 2], [-1, 1, 2]])]
    [[[0.5, 0.0], [0.5, 1.0]]]
    """
    values = np.asarray(field, dtype=np.float64)
    along_x, along_y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    ny, nx = values.shape
    places: dict[int, tuple[float, float]] = {}  # of crossed sides, by the numbers of the sides
    for axis, number in ((1, 0), (0, ny * nx)):
        low, high = values.take(range(values.shape[axis] - 1), axis), np.delete(values, 0, axis)
        crossed = ((low < 0.0) != (high < 0.0)) & np.isfinite(low) & np.isfinite(high)
        for j, i in np.argwhere(crossed).tolist():
            share = low[j, i] / (low[j, i] - high[j, i])
            here, there = (j, i), (j + (axis == 0), i + (axis == 1))
            places[number + j * nx + i] = (
                along_x[here[1]] + share * (along_x[there[1]] - along_x[here[1]]),
                along_y[here[0]] + share * (along_y[there[0]] - along_y[here[0]]),
            )
    met: dict[int, list[int]] = {side: [] for side in places}
    squares = {side % (ny * nx) for side in places}
    # A line through a square crosses its left side or one of its two rows. The second row is the
    # first one of the next square.
    squares |= {square - nx for square in squares}
    for square in sorted(squares):
        j, i = divmod(square, nx)
        if j < 0 or i >= nx - 1 or j >= ny - 1:
            continue
        around = (square, ny * nx + square + 1, square + nx, ny * nx + square)
        found = [side for side in around if side in places]
        for one, other in zip(found[::2], found[1::2], strict=False):
            met[one].append(other)
            met[other].append(one)
    lines = []
    ends = [side for side, others in met.items() if len(others) == 1]
    for first in (*ends, *met):  # then the closed lines
        line = [first]
        while met[line[-1]]:
            other = met[line[-1]].pop()
            met[other].remove(line[-1])
            line.append(other)
        if len(line) > 1:
            lines.append(np.array([places[side] for side in line]))
    return lines
