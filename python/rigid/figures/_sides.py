"""Which side of a surface is seen, and surfaces themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["eye", "sides", "surface"]

Floats = NDArray[np.float64]


def eye(elev: float, azim: float) -> Floats:
    """Unit vector towards who looks from this elevation and azimuth (degrees)."""
    e, a = np.radians([elev, azim])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def sides(points: Floats, outward: Floats, towards: Floats) -> tuple[Floats, Floats]:
    """Points (m, 3) of a curve on a surface that are seen, and those behind; NaN elsewhere."""
    seen = (outward @ towards >= 0.0)[:, np.newaxis]
    return np.where(seen, points, np.nan), np.where(seen, np.nan, points)


def surface(ax: Any, faces: Floats, colour: str, **style: Any) -> Any:
    """Polygons (k, corners, 3), shaded by the way they face."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    given = {"facecolors": colour, "edgecolors": "none", "alpha": 0.3, "zorder": 1, "shade": True}
    collection = Poly3DCollection(faces, **(given | style))
    ax.add_collection3d(collection)
    return collection
