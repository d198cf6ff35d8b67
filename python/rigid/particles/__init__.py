"""Systems of particles: total momenta, constraints, rigid displacements, and the path of a body.

Vectors have components along axes of space; moments refer to the origin of space unless you pass
another point.

The package uses :mod:`rigid.rotations` and, for the path of a body, :func:`rigid.simulate`.
"""

from __future__ import annotations

from .motions import (
    BodyPath,
    Displacement,
    OmegaFit,
    Screw,
    fit_omega,
    propagate_body,
    rigid_motion,
    screw,
    velocity_field,
)
from .systems import (
    Freedom,
    Split,
    Totals,
    degrees_of_freedom,
    particle_totals,
    rigidity_residual,
    split_com,
)

__all__ = [
    "BodyPath",
    "Displacement",
    "Freedom",
    "OmegaFit",
    "Screw",
    "Split",
    "Totals",
    "degrees_of_freedom",
    "fit_omega",
    "particle_totals",
    "propagate_body",
    "rigid_motion",
    "rigidity_residual",
    "screw",
    "split_com",
    "velocity_field",
]
