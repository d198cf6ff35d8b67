"""The map explorer: one page with a map, the bodies of its pixels, and films of their motions.

The page has the verdicts of some bodies of each pixel. It draws their starts as the core does
(``page/draw.js``), and computes their motions by a Taylor series (``page/motion.js``).
:mod:`rigid.maps.page` writes what the page holds.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .web import Page, assembled

SCRIPTS = (
    *("vectors.js", "stage.js", "charts.js", "player.js"),
    *("motion.js", "draw.js", "quantities.js", "solids.js", "map.js", "explorer.js"),
)


class Explorer(Page):
    """The page of a map, which a notebook shows.

    Attributes
    ----------
    page : str
        The page as HTML; it needs no network.
    """

    __slots__ = ()

    title = "map explorer"
    height = 720


def page_of(content: dict[str, Any] | None) -> str:
    """The page of a map; without content, the page that waits for maps."""
    return assembled("explorer.html", ("film.css", "explorer.css"), SCRIPTS, map=content)


def compressed(array: NDArray[Any]) -> bytes:
    """Little-endian bytes, deflated. Bytes of equal weight stand together: they repeat more."""
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    planes = little.reshape(-1).view(np.uint8).reshape(-1, little.dtype.itemsize).T
    return zlib.compress(np.ascontiguousarray(planes).tobytes(), 9)


def packed(array: ArrayLike, dtype: Any) -> dict[str, Any]:
    """An array for ``unpacked`` of the page."""
    plain = np.asarray(array).astype(dtype)
    return {"type": plain.dtype.name, "data": base64.b64encode(compressed(plain)).decode()}
