"""Times at which the rate about a body axis changes sign."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import positive_int
from .._checks.arrays import Floats
from ..model.bodies import Bodies, bodies_of
from ..model.body import Body
from ..model.scene import Scene, check_scene, require_unforced
from ..model.start import body_axis

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def flip_times(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    axis: int | None = None,
    count: int = 1,
) -> Floats:
    """First ``count`` times at which the rate about a body axis changes sign.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        A free body, or a top that :func:`lagrange_top` accepts. For a top ``axis`` must be the
        symmetry axis; the rate about this axis is constant.
    omega, attitude : array_like
        Initial states of the bodies, as in :func:`rigid.simulate`.
    axis : {1, 2, 3}, optional
        The body axis; by default the axis with the largest rate of each body.
    count : int
        Number of times.

    Returns
    -------
    ndarray, shape (count,) or (..., count)
        Times > 0 (s), ascending; inf if the rate does not change sign again.

    Raises
    ------
    MemoryError
        If the times do not fit into memory.
    ValueError
        If there is no closed form, or if ``axis`` is not given and two rates are the largest.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> times = rigid.exact.flip_times(scene, [1e-3, 1.0, 0.0], count=3)
    >>> np.round(np.diff(times), 6)
    array([28.731424, 28.731424])
    """
    scene = check_scene(scene, many=True)
    require_unforced(scene, "a closed form")
    number = positive_int("count", count)
    bodies = bodies_of(scene, omega, attitude, rod=True)
    chosen = None if axis is None else body_axis(axis)
    try:
        times = _core.flip_times(bodies, chosen, number)
    except ValueError:
        axes = _largest(bodies.omega) if chosen is None else np.array([chosen])
        _require_closed_forms(scene, bodies, axes)
        raise
    found: Floats = bodies.in_axes(times)
    return found


def _require_closed_forms(scene: Scene, bodies: Bodies, axes: NDArray[np.intp]) -> None:
    """Raise ValueError for a body that has no closed form for its axis."""
    for chosen in np.unique(axes).tolist():
        some = bodies.select(np.flatnonzero(np.broadcast_to(axes == chosen, len(bodies))))
        if not _core.closed_forms_for("no_flip", some.moments, some.weight, chosen).all():
            raise ValueError(
                f"axis = {chosen}: no closed form for the {scene.words()}; there is one for a "
                "free body, and for the symmetry axis of a Lagrange top"
            )


def _largest(omega: Floats) -> NDArray[np.intp]:
    """The body axis with the largest rate, for each body."""
    size = np.abs(omega)
    several = np.count_nonzero(size == size.max(axis=1, keepdims=True), axis=1) > 1
    if several.any():
        body = int(np.flatnonzero(several)[0])
        raise ValueError(
            f"omega[{body}] = {omega[body].tolist()}: has no single largest component; say axis=..."
        )
    axes: NDArray[np.intp] = size.argmax(axis=1) + 1
    return axes
