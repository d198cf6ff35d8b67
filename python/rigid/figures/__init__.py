"""Figures of the textbook: the data of each, and its drawing.

A function, such as :func:`poinsot`, computes a figure: a :class:`Picture`, whose attributes are
arrays, with a method ``plot``, which draws these data on your Matplotlib axes, or on new axes, and
returns the axes. Each artist has a name, its ``gid``.

Drawing needs Matplotlib, the extra ``maps``; importing the package and computing the data do not. A
notebook and ``plt.show()`` show new figures; ``axes.figure.savefig(...)`` saves them. All colours
and labels come from :mod:`rigid.drawing.colours`.

The package uses all physics modules and ``drawing``. No other module uses it.
"""

from __future__ import annotations

from .curves import bearing_torque, invariants, spring_modes, throw
from .free import box, cones, coplanar_vectors, free_top_omega, poinsot, polhodes
from .picture import Picture
from .rotations import (
    active_passive,
    euler_steps,
    frames,
    node_frame,
    rotating_body,
    unit_vector_change,
)
from .tops import cubic, cycloids, effective_potential, heavy_top, loci, locus, upright_cubic

__all__ = [
    "Picture",
    "active_passive",
    "bearing_torque",
    "box",
    "cones",
    "coplanar_vectors",
    "cubic",
    "cycloids",
    "effective_potential",
    "euler_steps",
    "frames",
    "free_top_omega",
    "heavy_top",
    "invariants",
    "loci",
    "locus",
    "node_frame",
    "poinsot",
    "polhodes",
    "rotating_body",
    "spring_modes",
    "throw",
    "unit_vector_change",
    "upright_cubic",
]
