"""The map explorer as a widget of Jupyter: where the reader zooms, a finer map is computed.

``page/widget.js`` shows the page of :mod:`rigid.animation.explorer` in a frame. Python answers its
zooms with new maps, and its clicks with the bodies of a pixel.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from .._checks.extras import install_extra
from .._checks.progress import Progress
from .explorer import page_of
from .web import as_json, template

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(install_extra("a widget needs anywidget", "notebook")) from None


Region = dict[str, Any]
"""The ``view`` of a zoom, as least and largest x, then y, and the places ``at`` on other axes."""


class MapWidget(anywidget.AnyWidget):
    """The view of a map in a notebook; see :meth:`rigid.StabilityMap.widget`, which makes it.

    Parameters
    ----------
    result : object
        The whole map.
    content : callable
        ``content(result, region)`` is the page content of a map, the whole one or a finer one.
    finer : callable
        ``finer(region, tell)`` is the finer map of a region; ``tell`` gets the progress.
    bodies : callable
        ``bodies(result, pixel)`` is the page content of the bodies of a pixel.

    Attributes
    ----------
    result : StabilityMap
        The map that the view shows: the whole map, or the finer map of the last zoom.

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

    def __init__(
        self,
        result: Any,
        *,
        content: Callable[[Any, Region | None], dict[str, Any]],
        finer: Callable[[Region, Callable[[Progress], None]], Any],
        bodies: Callable[[Any, int], dict[str, Any]],
    ) -> None:
        self._result = self._whole = result
        self._held, self._finer, self._bodies = content, finer, bodies
        self._zooms = self._shown = 0  # how many there were, and the number of that which is shown
        self._one_answer = threading.Lock()
        super().__init__(_page=page_of(None), _content=self._as_content(0, result, None))
        self.on_msg(self._list_bodies)

    @property
    def result(self) -> Any:
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

    def _compute(self, number: int, region: Region) -> None:
        """Compute the finer map of a region. The view shows any error."""

        def tell(progress: Progress) -> None:
            if number != self._zooms:
                raise _OvertakenError
            self._say(number, f"computing the finer map: {progress.done / progress.total:.0%}")

        self._say(number, "computing the finer map")
        try:
            self._show(number, self._finer(region, tell), region)
        except _OvertakenError:
            return
        except Exception as error:
            self._say(number, f"The finer map cannot be computed: {error}")

    def _show(self, number: int, result: Any, region: Region | None) -> None:
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

    def _as_content(self, number: int, result: Any, region: Region | None) -> str:
        return as_json(self._held(result, region) | {"zoom": number, "region": region})

    def _list_bodies(self, _widget: object, asked: dict[str, Any], _buffers: object) -> None:
        """Answer a click on a pixel with its bodies, unless its map is shown no longer."""
        pixel = asked["pixel"]
        with self._one_answer:
            result, shown = self._result, self._shown
        if asked["zoom"] != shown:
            return
        try:
            self.send(asked | {"bodies": as_json(self._bodies(result, pixel))})
        except Exception as error:
            self.send(asked | {"error": f"The bodies cannot be computed: {error}"})


class _OvertakenError(Exception):
    """A newer zoom makes a computation needless."""
