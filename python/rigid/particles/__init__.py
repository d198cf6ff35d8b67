"""Systems of particles: total momenta, constraints, rigid displacements, and the path of a body.

Vectors have components along axes of space; moments refer to the origin of space unless you pass
another point.

The package uses :mod:`rigid.rotations` and, for the path of a body, :func:`rigid.simulate`.
"""

from __future__ import annotations

from .._checks.exported import exported as _exported
from .motions import BodyPath as BodyPath
from .motions import Displacement as Displacement
from .motions import OmegaFit as OmegaFit
from .motions import Screw as Screw
from .motions import fit_omega as fit_omega
from .motions import propagate_body as propagate_body
from .motions import rigid_motion as rigid_motion
from .motions import screw as screw
from .motions import velocity_field as velocity_field
from .systems import Freedom as Freedom
from .systems import Split as Split
from .systems import Totals as Totals
from .systems import degrees_of_freedom as degrees_of_freedom
from .systems import particle_totals as particle_totals
from .systems import rigidity_residual as rigidity_residual
from .systems import split_com as split_com

__all__ = _exported(globals())
