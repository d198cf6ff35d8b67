"""Visible and hidden sides of surfaces, and shaded surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .colours import on_ground

Floats = NDArray[np.float64]


def eye(elev: float, azim: float) -> Floats:
    """Unit vector towards a viewer at this elevation and azimuth (degrees)."""
    e, a = np.radians([elev, azim])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def sides(points: Floats, outward: Floats, towards: Floats) -> tuple[Floats, Floats]:
    """Visible and hidden points (m, 3) of a curve on a surface; the other points are NaN."""
    seen = (outward @ towards >= 0.0)[:, np.newaxis]
    return np.where(seen, points, np.nan), np.where(seen, np.nan, points)


def surface(ax: Any, faces: Floats, colour: str, towards: Floats, **style: Any) -> Any:
    """Draw polygons (k, 4, 3), shaded by their angle to the viewer, below all curves."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    size = np.linalg.norm(normal, axis=1)
    light = 0.8 + 0.2 * np.abs(normal @ towards) / np.where(size > 0.0, size, 1.0)
    shades = light[:, np.newaxis] * np.array(to_rgb(on_ground(ax, colour)))
    given: dict[str, Any] = {"edgecolors": shades, "linewidths": 0.4, "zorder": 1}
    collection = Poly3DCollection(faces, facecolors=shades, **(given | style))
    ax.add_collection3d(collection)
    return collection
