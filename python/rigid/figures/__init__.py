"""Figures of the textbook, each drawn by one call.

Every figure has two functions. ``x_data`` (or a function of the physics modules) computes the data,
a frozen dataclass of arrays. ``x`` draws these data on your Matplotlib axes, or on new axes, and
returns the artists by name, so that you can test, restyle or animate them.

Drawing needs Matplotlib, the extra ``maps``; importing the package does not. A notebook
and ``plt.show()`` show new figures; ``artists.ax.figure.savefig(...)`` saves them. All colours and
labels come from :mod:`rigid.figures.colours`.

The package uses all physics modules and ``drawing``. No other module uses it.
"""

from __future__ import annotations

from . import colours
from .bodies import box, box_data, heavy_top, heavy_top_data
from .bodycones import cones, cones_data
from .cubics import cubic, cubic_data, upright_cubic, upright_cubic_data
from .eulersteps import euler_steps, euler_steps_data
from .family import polhodes, polhodes_data
from .measured import bearing_torque, bearing_torque_data, spring_modes, spring_modes_data
from .orientation import frames, frames_data, node_frame, node_frame_data
from .paths import loci, locus, locus_data
from .potential import effective_potential, effective_potential_data
from .rolling import poinsot, poinsot_data
from .rotating import rotating_body, rotating_body_data
from .symmetric import coplanar_vectors, coplanar_vectors_data, free_top_omega, free_top_omega_data
from .throws import invariants, invariants_data, throw
from .turning import (
    active_passive,
    active_passive_data,
    unit_vector_change,
    unit_vector_change_data,
)
from .unrolled import cycloids, cycloids_data

__all__ = [
    "active_passive",
    "active_passive_data",
    "bearing_torque",
    "bearing_torque_data",
    "box",
    "box_data",
    "colours",
    "cones",
    "cones_data",
    "coplanar_vectors",
    "coplanar_vectors_data",
    "cubic",
    "cubic_data",
    "cycloids",
    "cycloids_data",
    "effective_potential",
    "effective_potential_data",
    "euler_steps",
    "euler_steps_data",
    "frames",
    "frames_data",
    "free_top_omega",
    "free_top_omega_data",
    "heavy_top",
    "heavy_top_data",
    "invariants",
    "invariants_data",
    "loci",
    "locus",
    "locus_data",
    "node_frame",
    "node_frame_data",
    "poinsot",
    "poinsot_data",
    "polhodes",
    "polhodes_data",
    "rotating_body",
    "rotating_body_data",
    "spring_modes",
    "spring_modes_data",
    "throw",
    "unit_vector_change",
    "unit_vector_change_data",
    "upright_cubic",
    "upright_cubic_data",
]
