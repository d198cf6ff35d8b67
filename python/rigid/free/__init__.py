"""Free rotation: Euler's equations, free tops, Poinsot's construction, and stable rotations.

Body axes are principal axes, ``omega`` is in the body (rad/s), attitudes are unit quaternions,
scalar first, body to space. Arrays may have any leading axes. For the motion use
:func:`rigid.simulate` or :mod:`rigid.exact`; this package has the quantities of textbooks.

The package uses :mod:`rigid.exact`, :mod:`rigid.rotations` and runs; it imports neither maps nor
the planner. :mod:`rigid.top`, :mod:`rigid.earth` and :mod:`rigid.figures` use it.
"""

from .._checks.exported import exported as _exported
from .equations import Invariants as Invariants
from .equations import PowerBalance as PowerBalance
from .equations import euler_rhs as euler_rhs
from .equations import invariants as invariants
from .equations import power_balance as power_balance
from .relaxation import Relaxation as Relaxation
from .relaxation import damping_time as damping_time
from .relaxation import relaxation as relaxation
from .relaxation import sink_of_damping as sink_of_damping
from .rolling import Cones as Cones
from .rolling import Poinsot as Poinsot
from .rolling import cones as cones
from .rolling import poinsot as poinsot
from .satellites import Libration as Libration
from .satellites import jacobi_integral as jacobi_integral
from .satellites import libration as libration
from .satellites import roll_pitch_yaw as roll_pitch_yaw
from .stability import Circulation as Circulation
from .stability import PermanentRotation as PermanentRotation
from .stability import ThrowExperiment as ThrowExperiment
from .stability import circulation as circulation
from .stability import crossings as crossings
from .stability import gamma_residual as gamma_residual
from .stability import gammas as gammas
from .stability import jacobian as jacobian
from .stability import local_stability as local_stability
from .stability import permanent_rotation as permanent_rotation
from .stability import throw_experiment as throw_experiment
from .tops import AsymmetricTop as AsymmetricTop
from .tops import SymmetricTop as SymmetricTop
from .tops import asymmetric_free_top as asymmetric_free_top
from .tops import steady_axis_frame as steady_axis_frame
from .tops import steady_axis_spin as steady_axis_spin
from .tops import symmetric_free_top as symmetric_free_top
from .tumbling import SpinState as SpinState
from .tumbling import spin_periods as spin_periods
from .tumbling import spin_state as spin_state

__all__ = _exported(globals())
