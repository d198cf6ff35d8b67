"""Free rotation: Euler's equations, free tops, Poinsot's construction, and stable rotations.

Body axes are principal axes, ``omega`` is in the body (rad/s), attitudes are unit quaternions,
scalar first, body to space. Arrays may have any leading axes. For the motion use
:func:`rigid.simulate` or :mod:`rigid.exact`; this package has the quantities of textbooks.

The package uses :mod:`rigid.exact`, :mod:`rigid.rotations` and runs; it imports neither maps nor
the planner. :mod:`rigid.top`, :mod:`rigid.earth` and :mod:`rigid.figures` use it.
"""

from .equations import Invariants, PowerBalance, euler_rhs, invariants, power_balance
from .relaxation import Relaxation, damping_time, relaxation, sink_of_damping
from .rolling import Cones, Poinsot, cones, poinsot
from .satellites import Libration, jacobi_integral, libration, roll_pitch_yaw
from .stability import (
    Circulation,
    PermanentRotation,
    ThrowExperiment,
    circulation,
    crossings,
    gamma_residual,
    gammas,
    jacobian,
    local_stability,
    permanent_rotation,
    throw_experiment,
)
from .tops import (
    AsymmetricTop,
    SymmetricTop,
    asymmetric_free_top,
    steady_axis_frame,
    steady_axis_spin,
    symmetric_free_top,
)
from .tumbling import SpinState, spin_periods, spin_state

__all__ = [
    "AsymmetricTop",
    "Circulation",
    "Cones",
    "Invariants",
    "Libration",
    "PermanentRotation",
    "Poinsot",
    "PowerBalance",
    "Relaxation",
    "SpinState",
    "SymmetricTop",
    "ThrowExperiment",
    "asymmetric_free_top",
    "circulation",
    "cones",
    "crossings",
    "damping_time",
    "euler_rhs",
    "gamma_residual",
    "gammas",
    "invariants",
    "jacobi_integral",
    "jacobian",
    "libration",
    "local_stability",
    "permanent_rotation",
    "poinsot",
    "power_balance",
    "relaxation",
    "roll_pitch_yaw",
    "sink_of_damping",
    "spin_periods",
    "spin_state",
    "steady_axis_frame",
    "steady_axis_spin",
    "symmetric_free_top",
    "throw_experiment",
]
