"""The map explorer as a widget of Jupyter: where the reader zooms, a finer map is computed.

``page/widget.js`` shows the page of :mod:`rigid.animation.explorer` in a frame. Python answers its
zooms with new maps, and its clicks with the bodies of a pixel.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import resolve_threads
from .._checks.extras import install_extra
from ..maps.result import StabilityMap
from ..store.call import stability_map
from .explorer import (
    MOST_SAMPLES,
    content_of_map,
    content_of_outcomes,
    content_of_starts,
    drawn_edges,
    page_of,
)
from .web import as_json, template

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(install_extra("a widget needs anywidget", "notebook")) from None

if TYPE_CHECKING:
    from .._checks.progress import Progress
    from ..maps.parameters import Axis
    from ..maps.spec import MapSpec

__all__ = ["MapWidget", "zoomed"]


class MapWidget(anywidget.AnyWidget):
    """The view of a map in a notebook; see :meth:`rigid.StabilityMap.widget`, which makes it.

    Parameters
    ----------
    result : StabilityMap
        The whole map.
    threads : int, optional
        Threads that compute finer maps. Default: ``RIGID_NUM_THREADS``, else the cores that this
        process may use.

    Attributes
    ----------
    result : StabilityMap
        The map that the view shows: the whole map, or the finer map of the last zoom.

    Raises
    ------
    TypeError, ValueError
        If ``threads`` is no positive integer, or a function that the map needs is not known.

    Examples
    --------
    >>> import rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...     stable=rigid.no_flip(), rng=2026,
    ... )
    >>> widget = result.widget()  # the last line of a cell shows it
    >>> widget.result is result
    True
    """

    _esm = template("widget.js")
    _page = traitlets.Unicode().tag(sync=True)
    _content = traitlets.Unicode().tag(sync=True)
    """The map that is shown, as JSON."""
    _region = traitlets.Dict(None, allow_none=True).tag(sync=True)
    """The region that the reader asks to see, set by the view; None is the whole map."""
    _said = traitlets.Unicode().tag(sync=True)
    """What the view shows the reader about a computation."""

    def __init__(self, result: StabilityMap, *, threads: int | None = None) -> None:
        result.spec.require_functions()
        self._result = self._whole = result
        self._threads = resolve_threads(threads)
        self._zooms = self._shown = 0  # how many there were, and the number of that which is shown
        self._one_answer = threading.Lock()
        super().__init__(_page=page_of(None), _content=self._as_content(0, result, None))
        self.on_msg(self._list_bodies)

    @property
    def result(self) -> StabilityMap:
        """The map that is shown."""
        return self._result

    @traitlets.observe("_region")
    def _zoom(self, change: Any) -> None:
        """Begin to answer a zoom. The answer to an earlier zoom is given up."""
        with self._one_answer:
            self._zooms += 1
            number = self._zooms
        if change.new is None:
            self._show(number, self._whole, None)
        else:
            threading.Thread(target=self._compute, args=(number, change.new), daemon=True).start()

    def _compute(self, number: int, region: dict[str, Any]) -> None:
        """Compute the finer map of a region. The view shows any error."""

        def tell(progress: Progress) -> None:
            if number != self._zooms:
                raise _OvertakenError
            self._say(number, f"computing the finer map: {progress.done / progress.total:.0%}")

        self._say(number, "computing the finer map")
        try:
            spec = zoomed(self._whole.spec, region["view"], region["at"])
            finer = stability_map(spec, threads=self._threads, progress=tell)
            self._show(number, finer, region)
        except _OvertakenError:
            return
        except Exception as error:
            self._say(number, f"The finer map cannot be computed: {error}")

    def _show(self, number: int, result: StabilityMap, region: dict[str, Any] | None) -> None:
        """Let the view show a map, unless there was another zoom."""
        content = self._as_content(number, result, region)
        with self._one_answer:
            if number == self._zooms:
                self._result, self._shown = result, number
                self._content, self._said = content, ""

    def _say(self, number: int, words: str) -> None:
        with self._one_answer:
            if number == self._zooms:
                self._said = words

    def _as_content(self, number: int, result: StabilityMap, region: dict[str, Any] | None) -> str:
        whole = self._whole.spec
        content = content_of_map(result, self._count, python="widget.result", whole=whole)
        content |= {"zoom": number, "region": region}
        if region is not None:
            # How far the reader may zoom out: to the borders of the whole map.
            edges = [drawn_edges(axis, axis.geometric) for axis in whole.axes[:2]]
            ends = [[float(edge.min()), float(edge.max())] for edge in edges]
            content["all"] = [*ends[0], *(ends[1] if len(ends) > 1 else [0.0, 1.0])]
        return as_json(content)

    @property
    def _count(self) -> int:
        return min(self._whole.spec.samples, MOST_SAMPLES)

    def _list_bodies(self, _widget: object, asked: dict[str, Any], _buffers: object) -> None:
        """Answer a click on a pixel with its bodies, unless its map is shown no longer."""
        pixel = asked["pixel"]
        with self._one_answer:
            result, shown = self._result, self._shown
        if asked["zoom"] != shown:
            return
        try:
            numbers = range(self._count)
            start = result.starts(numbers, pixel=pixel)
            seen = result.outcomes(numbers, pixel=pixel, threads=self._threads)
            held = content_of_starts(start) | content_of_outcomes(seen)
            self.send(asked | {"bodies": as_json(held)})
        except Exception as error:
            self.send(asked | {"error": f"The bodies cannot be computed: {error}"})


class _OvertakenError(Exception):
    """A newer zoom makes a computation needless."""


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
    >>> from rigid.animation.widget import zoomed
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
