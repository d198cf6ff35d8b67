"""Figures of the textbook: the data of each, and its drawing.

A function, such as :func:`poinsot`, computes a figure: a frozen dataclass of arrays with a method
``plot``, which draws these data on your Matplotlib axes, or on new axes, and returns the axes. Each
artist has a name, its ``gid``, as :class:`Picture` says.

Drawing needs Matplotlib, the extra ``maps``; importing the package and computing the data do not. A
notebook and ``plt.show()`` show new figures; ``axes.figure.savefig(...)`` saves them. All colours
and labels come from :mod:`rigid.drawing.colours`.

The package uses all physics modules and ``drawing``. No other module uses it.
"""

from __future__ import annotations

from .bodies import box, heavy_top
from .bodycones import cones
from .cubics import cubic, upright_cubic
from .eulersteps import euler_steps
from .family import polhodes
from .measured import bearing_torque, spring_modes
from .orientation import frames, node_frame
from .paths import loci, locus
from .picture import Picture
from .potential import effective_potential
from .rolling import poinsot
from .rotating import rotating_body
from .symmetric import coplanar_vectors, free_top_omega
from .throws import invariants, throw
from .turning import active_passive, unit_vector_change
from .unrolled import cycloids

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
