"""Free rotation: Euler's equations, free tops, Poinsot's picture, and which rotations last.

Body axes are principal axes, ``omega`` is in the body (rad/s), attitudes are unit quaternions,
scalar first, body to space. Arrays may have any leading axes. Motion itself is that of
:func:`rigid.simulate` and :mod:`rigid.exact`; this is the textbook's view of it.
"""

from .equations import Invariants, PowerBalance, euler_rhs, invariants, power_balance
from .rolling import Cones, Poinsot, cones, poinsot
from .stability import (
    Circulation,
    PermanentRotation,
    circulation,
    crossings,
    gamma_residual,
    gammas,
    jacobian,
    local_stability,
    permanent_rotation,
)
from .throw import ThrowExperiment, throw_experiment
from .tops import (
    AsymmetricTop,
    SymmetricTop,
    asymmetric_free_top,
    steady_axis_frame,
    steady_axis_spin,
    symmetric_free_top,
)

__all__ = [
    "AsymmetricTop",
    "Circulation",
    "Cones",
    "Invariants",
    "PermanentRotation",
    "Poinsot",
    "PowerBalance",
    "SymmetricTop",
    "ThrowExperiment",
    "asymmetric_free_top",
    "circulation",
    "cones",
    "crossings",
    "euler_rhs",
    "gamma_residual",
    "gammas",
    "invariants",
    "jacobian",
    "local_stability",
    "permanent_rotation",
    "poinsot",
    "power_balance",
    "steady_axis_frame",
    "steady_axis_spin",
    "symmetric_free_top",
    "throw_experiment",
]
