"""The surface of a body that a film shows, from the corners and faces of a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, shaped
from .._checks.quantities import plain

Floats = NDArray[np.float64]


def faces_of(shape: tuple[ArrayLike, ArrayLike], *, frame: Floats | None) -> Floats:
    """The polygons of a mesh along the principal axes, with its farthest corner at distance one.

    Parameters
    ----------
    shape : tuple (vertices, faces)
        Corners of shape (v, 3) in any unit of length, from the origin of the body, and the indices
        of the corners of each polygon, from 0, whole numbers of shape (f, n) with n >= 3.
    frame : ndarray, shape (3, 3), or None
        The axes of the corners, as :attr:`rigid.Run.frame`; None if they are principal axes.

    Returns
    -------
    ndarray, shape (f, n, 3)

    Raises
    ------
    TypeError
        If it is no pair.
    ValueError
        If the arrays have other shapes, a face names a corner that is not there, or all used
        corners are at the origin.

    Examples
    --------
    >>> from rigid.animation.mesh import faces_of
    >>> corners = [[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 2]]
    >>> faces_of((corners, [[0, 2, 1]]), frame=None)[0]
    array([[0. , 0. , 0. ],
           [0. , 0.5, 0. ],
           [1. , 0. , 0. ]])
    """
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise TypeError(f"shape = {brief(shape)}: must be a pair, (vertices, faces)")
    vertices, faces = shape
    points = shaped("shape[0]", vertices, 3)
    if points.ndim != 2:
        raise ValueError(f"shape[0]: the corners need the shape (v, 3), not {points.shape}")
    index = np.asarray(plain("shape[1]", faces))
    if index.ndim != 2 or index.dtype.kind not in "iu" or not len(index) or index.shape[1] < 3:
        raise ValueError(
            f"shape[1]: the faces need whole numbers of shape (f, n) with n >= 3, not "
            f"{index.dtype} of shape {index.shape}"
        )
    if index.min() < 0 or index.max() >= len(points):
        bad = int(index.max() if index.max() >= len(points) else index.min())
        raise ValueError(f"shape[1]: no corner {brief(bad)} among {len(points)} corners")
    if frame is not None:
        points = points @ frame  # back from the axes of the drawing
    polygons = points[index]
    farthest = float(np.linalg.norm(polygons, axis=-1).max())
    if farthest == 0.0:
        raise ValueError("shape[0]: all corners of the faces are at the origin")
    solid: Floats = polygons / farthest
    return solid
