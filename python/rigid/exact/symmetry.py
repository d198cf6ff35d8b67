"""Symmetry axes of heavy tops, one top or many, and the refusal of a top without such an axis."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import first_place
from .._checks.arrays import Floats
from .._checks.moments import refuse_rods
from ..model.batch import in_rows
from ..model.bodies import lagrange_axes
from ..model.scene import HeavyTop


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """Symmetry axes through the centres of mass, and the moments, in the shape of the tops.

    Numbers of a top without symmetry are NaN.
    """

    axis: NDArray[np.int64]  #: 1, 2 or 3; 0 without symmetry
    side: Floats  #: 1 if the centre of mass is along the axis, -1 if it is against it
    along: Floats  #: I3, about the axis
    across: Floats  #: I1 = I2


def symmetry_of(scene: HeavyTop, line: Floats | None = None, *, rod: bool = False) -> Symmetry:
    """The symmetry of heavy tops about a line, by default the line through ``com``.

    A rod is refused unless ``rod`` is true: it has no moment along its axis.
    """
    shape = scene.shape
    moments, com = np.asarray(scene.body.moments), np.asarray(scene.com)
    if not rod:
        refuse_rods(moments)
    axes = lagrange_axes(in_rows(moments, shape), in_rows(com if line is None else line, shape))
    axis = np.broadcast_to(axes.reshape(shape if len(axes) == prod(shape) else ()), shape)
    side, along, across = (
        np.where(axis == 0, np.nan, _components(part, place, shape))
        for part, place in ((np.sign(com), axis - 1), (moments, axis - 1), (moments, axis - 2))
    )
    return Symmetry(axis, side, along, across)


def _components(vectors: Floats, place: NDArray[np.int64], shape: tuple[int, ...]) -> Floats:
    """One component of each vector."""
    every = np.broadcast_to(vectors, (*shape, 3))
    taken: Floats = np.take_along_axis(every, place[..., np.newaxis] % 3, axis=-1)[..., 0]
    return taken


def require_each(
    scene: HeavyTop, good: NDArray[np.bool_], rule: str, names: tuple[str, ...]
) -> None:
    """Raise ValueError for the first top that breaks the rule, with these numbers of the top."""
    if good.all():
        return
    index, place = first_place(~np.broadcast_to(good, scene.shape))
    top = scene[index] if index else scene
    values = {"moments": top.body.moments, "com": top.com, "mgl": f"{top.mgl:g}"}
    words = ", ".join(f"{name}{place} = {values[name]}" for name in names)
    raise ValueError(f"{words}: {rule}")
