"""Refinement from coarse to fine: pixels without new information are omitted.

The first stage is every k-th row and column, and the last ones. Then each cell between computed
corners is split if its corners differ for certain: the intervals of two of them do not meet, or
their statuses differ. So is a cell that touches one that is split. A pixel that is computed has the
bits that it has in the full map, and the pixels to compute next follow from the known pixels.

A budget of bodies ends the map: the pixels of a stage are taken in order, as long as the bodies of
those before and the most that the next one may need fit. Pixels that stop early leave room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .spec import MapSpec

LEFT_OUT = 255
"""The stage of a pixel that is not computed."""

COARSEST = 16
"""Spacing of the widest lattice of pixels, which is computed first."""

Grid = NDArray[Any]
Cells = NDArray[np.int64]
"""First and last row, first and last column of each cell, shape (n, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """The pixels of a refined map that are computed, and the next ones.

    Attributes
    ----------
    stage : ndarray of uint8, shape of the grid
        The stage at which each pixel is computed; 255: omitted, so far.
    wanted : ndarray of int64
        The pixels to be computed now, in C order of the grid, the most telling first.
    cells : ndarray of int64, shape (n, 4)
        First and last row, first and last column of each cell that is not split.
    cut : int
        Pixels of the last stage that the budget does not allow, as far as is known.
    """

    stage: NDArray[np.uint8]
    wanted: NDArray[np.int64]
    cells: Cells
    cut: int


def refined(spec: MapSpec) -> bool:
    """Whether pixels may be omitted."""
    return spec.refine is not None or spec.budget is not None


def lattice_level(shape: tuple[int, ...], pixels: NDArray[np.int64]) -> NDArray[np.int64]:
    """The largest of 1, 2, 4, 8 and 16 that divides all indices of each pixel."""
    index = np.full(len(pixels), COARSEST, np.int64)
    for part in np.unravel_index(pixels, shape):
        index |= part
    level: NDArray[np.int64] = index & -index
    return level


def stages(spec: MapSpec, status: Grid, finished: Grid, bodies: Grid, ends: list[Grid]) -> Stages:
    """The stages of a map of which some pixels are computed.

    Parameters
    ----------
    spec : MapSpec
    status : ndarray of uint8
        Status of the body of each pixel.
    finished : ndarray of bool
        Pixels that are computed.
    bodies : ndarray of int64
        Bodies that were computed in each pixel.
    ends : list of two ndarrays
        Lower and upper ends of the intervals.
    """
    shape = spec.shape if len(spec.shape) == 2 else (1, math.prod(spec.shape))
    possible, finished, bodies = (array.reshape(shape) for array in (status == 0, finished, bodies))
    lower, upper = (end.reshape(shape) for end in ends)
    kinds = status.reshape(shape)
    rows, columns = (_lattice(length, spec.refine or 1) for length in shape)
    stage = np.full(shape, LEFT_OUT, np.uint8)
    cells = _cells(rows, columns) if spec.refine else np.zeros((0, 4), np.int64)
    new = np.zeros(shape, np.bool_)
    new[np.ix_(rows, columns)] = True
    every = np.arange(stage.size)
    gap = lattice_level(spec.shape, every).reshape(shape).astype(np.float64)
    leaves, parents = [], cells
    for number in range(LEFT_OUT):
        pixels = np.flatnonzero(new & possible)
        pixels = pixels[np.argsort(-gap.ravel()[pixels], kind="stable")]
        affordable = len(pixels)
        if spec.budget is not None:
            # Of pixels that are not computed the most that they may need.
            needed = np.where(finished, bodies, spec.samples).ravel()[pixels]
            before = int(bodies[stage != LEFT_OUT].sum()) + np.cumsum(needed) - needed
            affordable = int((before + spec.samples <= spec.budget).sum())
        new.ravel()[pixels[affordable:]] = False
        stage[new] = number
        wanted = pixels[:affordable][~finished.ravel()[pixels[:affordable]]]
        cut = len(pixels) - affordable
        if len(wanted) or cut or not len(cells):
            break
        split, gaps = _split(cells, possible, kinds, lower, upper)
        leaves.append(cells[~split])
        parents, gaps = cells[split], gaps[split]
        cells, new, gap = _halved(parents, gaps, shape)
        new &= stage == LEFT_OUT
    # Cells whose corners are not computed yet are drawn as those that they are parts of.
    together = np.concatenate([*leaves, parents])
    return Stages(stage.reshape(spec.shape), wanted, together, cut)


def _lattice(length: int, step: int) -> NDArray[np.int64]:
    return np.unique(np.append(np.arange(0, length, step), length - 1))


def _cells(rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Cells:
    """The cells between lines; a single line has cells of no height."""

    def pairs(lines: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.stack([lines[:-1], lines[1:]], axis=1) if len(lines) > 1 else lines[[[0, 0]]]

    down, across = pairs(rows), pairs(columns)
    return np.concatenate(
        [np.repeat(down, len(across), axis=0), np.tile(across, (len(down), 1))], axis=1
    )


def _corners(array: Grid, cells: Cells) -> Grid:
    """The values at the corners of each cell, shape (4, n)."""
    top, bottom, left, right = cells.T
    return np.stack([array[row, column] for row in (top, bottom) for column in (left, right)])


def _split(
    cells: Cells, possible: Grid, kinds: Grid, lower: Grid, upper: Grid
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Which cells are split, and the gaps between the intervals of their corners."""
    there = _corners(possible, cells)
    highest = np.where(there, _corners(lower, cells), -1.0)
    lowest = np.where(there, _corners(upper, cells), 2.0)
    gap = np.fmax.reduce(highest) - np.fmin.reduce(lowest)
    # The border of the possible bodies is as sharp as any.
    gap = np.where(np.ptp(_corners(kinds, cells).astype(np.int64), axis=0) > 0, 2.0, gap)
    divisible = (cells[:, 1] - cells[:, 0] > 1) | (cells[:, 3] - cells[:, 2] > 1)
    split = gap > 0.0
    touched = _covered(cells[split], kinds.shape)
    count = np.zeros((kinds.shape[0] + 1, kinds.shape[1] + 1), np.int64)
    count[1:, 1:] = touched.cumsum(axis=0).cumsum(axis=1)
    top, bottom, left, right = cells[:, 0], cells[:, 1] + 1, cells[:, 2], cells[:, 3] + 1
    split |= count[bottom, right] - count[top, right] - count[bottom, left] + count[top, left] > 0
    return split & divisible, gap


def _covered(cells: Cells, shape: tuple[int, ...]) -> Grid:
    """The pixels of cells, their borders included."""
    edges = np.zeros((shape[0] + 1, shape[1] + 1), np.int64)
    top, bottom, left, right = cells[:, 0], cells[:, 1] + 1, cells[:, 2], cells[:, 3] + 1
    for row, column, sign in (
        (top, left, 1),
        (bottom, left, -1),
        (top, right, -1),
        (bottom, right, 1),
    ):
        np.add.at(edges, (row, column), sign)
    covered: Grid = edges.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0
    return covered


def _halved(
    cells: Cells, gaps: NDArray[np.float64], shape: tuple[int, ...]
) -> tuple[Cells, Grid, Grid]:
    """The parts of cells, their corners, and the largest gap of the cells at each corner."""
    corners, gap = np.zeros(shape, np.bool_), np.full(shape, -np.inf)
    top, bottom, left, right = cells.T
    middle, centre = (top + bottom) // 2, (left + right) // 2
    for row in (top, middle, bottom):
        for column in (left, centre, right):
            corners[row, column] = True
            np.maximum.at(gap, (row, column), gaps)
    parts = []
    for one, other in _two_parts(top, middle, bottom):
        for first, second in _two_parts(left, centre, right):
            part = np.stack([one, other, first, second], axis=1)
            parts.append(part[(one >= 0) & (first >= 0)])
    return np.concatenate(parts), corners, gap


def _two_parts(
    begin: NDArray[np.int64], middle: NDArray[np.int64], end: NDArray[np.int64]
) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """The halves of sides; a side of at most one step stays whole, and its first half is -1."""
    return [(np.where(middle > begin, begin, -1), middle), (middle, end)]


def filled(share: Grid, status: Grid, known: Grid, cells: Cells) -> NDArray[np.float64]:
    """The share of every possible pixel: bilinear in each cell between the corners that are known.

    Pixels that were computed keep their share.
    """
    shape = share.shape if share.ndim == 2 else (1, *share.shape)
    values, status, known = (array.reshape(shape) for array in (share, status, known))
    usable = known & ~np.isnan(values)
    weights = usable.astype(np.float64)
    numbers = np.where(usable, values, 0.0)
    out = np.full(shape, np.nan)
    heights, widths = cells[:, 1] - cells[:, 0], cells[:, 3] - cells[:, 2]
    # Smaller cells know better where two meet.
    for height, width in sorted({*map(tuple, np.stack([heights, widths], 1).tolist())})[::-1]:
        mine = cells[(heights == height) & (widths == width)]
        down = np.linspace(0.0, 1.0, height + 1)[:, np.newaxis] if height else np.zeros((1, 1))
        across = np.linspace(0.0, 1.0, width + 1) if width else np.zeros(1)
        up, back = 1.0 - down, 1.0 - across
        shares = (up * back, up * across, down * back, down * across)
        total, weight = (
            sum(
                corner[:, np.newaxis, np.newaxis] * part
                for corner, part in zip(_corners(array, mine), shares, strict=True)
            )
            for array in (numbers, weights)
        )
        with np.errstate(invalid="ignore"):  # no corner is known
            block = total / weight
        rows = mine[:, 0, np.newaxis, np.newaxis] + np.arange(height + 1)[:, np.newaxis]
        columns = mine[:, 2, np.newaxis, np.newaxis] + np.arange(width + 1)
        out[rows, columns] = block
    out[known] = values[known]
    out[status != 0] = np.nan
    return out.reshape(share.shape)
