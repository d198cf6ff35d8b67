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

from .._checks.exported import exported as _exported
from .curves import bearing_torque as bearing_torque
from .curves import invariants as invariants
from .curves import spring_modes as spring_modes
from .curves import throw as throw
from .free import box as box
from .free import cones as cones
from .free import coplanar_vectors as coplanar_vectors
from .free import free_top_omega as free_top_omega
from .free import poinsot as poinsot
from .free import polhodes as polhodes
from .picture import Picture as Picture
from .rotations import active_passive as active_passive
from .rotations import euler_steps as euler_steps
from .rotations import frames as frames
from .rotations import node_frame as node_frame
from .rotations import rotating_body as rotating_body
from .rotations import unit_vector_change as unit_vector_change
from .tops import cubic as cubic
from .tops import cycloids as cycloids
from .tops import effective_potential as effective_potential
from .tops import heavy_top as heavy_top
from .tops import loci as loci
from .tops import locus as locus
from .tops import upright_cubic as upright_cubic

__all__ = _exported(globals())
