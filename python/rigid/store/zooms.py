"""The widget of a map: the finer maps of its zooms, and the bodies of its pixels."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import resolve_threads
from .._checks.progress import Progress
from ..animation.widget import MapWidget, Region
from ..maps.axes import Axis
from ..maps.data import MapData
from ..maps.page import (
    MOST_SAMPLES,
    content_of_map,
    content_of_numbers,
    content_of_outcomes,
    content_of_starts,
    drawn_edges,
)
from ..maps.samples import outcomes
from ..maps.spec import MapSpec
from .resume import carry_on, result_of
from .running import Memory


def widget_of(whole: MapData, threads: int | None) -> MapWidget:
    """The widget of a map, whose finer maps are results of the same class."""
    spec = whole.spec
    spec.require_functions()
    workers = resolve_threads(threads)
    bodies_shown = range(min(spec.samples, MOST_SAMPLES))

    def content(data: MapData, region: Region | None) -> dict[str, Any]:
        held = content_of_map(data, len(bodies_shown), python="widget.result", whole=spec)
        if region is not None:
            # How far the reader may zoom out: to the borders of the whole map.
            edges = [drawn_edges(axis, axis.geometric) for axis in spec.axes[:2]]
            ends = [[float(edge.min()), float(edge.max())] for edge in edges]
            held["all"] = [*ends[0], *(ends[1] if len(ends) > 1 else [0.0, 1.0])]
        return held

    def finer(region: Region, tell: Callable[[Progress], None]) -> MapData:
        begun = time.perf_counter()
        running = Memory(zoomed(spec, region["view"], region["at"]).renewed())
        carry_on(running, threads=workers, stop=lambda: False, progress=tell)
        elapsed = time.perf_counter() - begun
        return result_of(running, type(whole), elapsed=elapsed, threads=workers)

    def bodies(data: MapData, pixel: int) -> dict[str, Any]:
        seen = outcomes(data, bodies_shown, pixel, workers)
        held = content_of_starts(data, bodies_shown, pixel) | content_of_outcomes(seen)
        return held | content_of_numbers(data, bodies_shown, pixel)

    return MapWidget(whole, content=content, finer=finer, bodies=bodies)


def zoomed(spec: MapSpec, view: list[float], at: list[int]) -> MapSpec:
    """The specification of the finer map of a region, with as many pixels.

    Parameters
    ----------
    spec : MapSpec
        The specification of the whole map.
    view : list of float
        Least and largest x, then y, between the borders of cells; logarithms on an axis whose
        values form a geometric progression.
    at : list of int
        Indices of the values of the other axes, of which the finer map has these alone.

    Returns
    -------
    MapSpec
        Its values lie between the least and the largest value of the whole map. Seed and samples
        are taken from the whole map. Random numbers follow from the number of a pixel, so the
        bodies are others.

    Raises
    ------
    ValueError
        If the values are too close to each other.

    Examples
    --------
    >>> import rigid
    >>> from rigid.store.zooms import zoomed
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0, 2.0, 3.0, 4.0]}, samples=10, t_end=50.0,
    ...     stable=rigid.no_flip(), rng=2026,
    ... )
    >>> zoomed(result.spec, [2.0, 3.0, 0.0, 1.0], []).axes[0].values
    (2.125, 2.375, 2.625, 2.875)
    """
    axes: dict[str, Any] = {
        axis.name: _finer(axis, *view[2 * place : 2 * place + 2])
        for place, axis in enumerate(spec.axes[:2])
    }
    for axis, index in zip(spec.axes[2:], at, strict=True):
        axes[axis.name] = [axis.values[index]]
    return spec.replace(axes=axes)


def _finer(axis: Axis, low: float, high: float) -> NDArray[np.float64]:
    """As many values as the axis has, in the middles of cells between these borders."""
    values: NDArray[np.float64] = np.array(axis.values)
    count = len(values)
    if count == 1:
        return values
    drawn = np.log(values) if axis.geometric else values
    half = 0.5 * (high - low) / count
    least, most = np.clip([low + half, high - half], drawn.min(), drawn.max())
    finer = np.linspace(least, most, count)
    if axis.geometric:
        finer = np.clip(np.exp(finer), values.min(), values.max())
    return finer if values[0] < values[-1] else finer[::-1]
