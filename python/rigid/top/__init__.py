"""The heavy top: constants of its motion, potential, cubic, steady precession, and its locus.

A symmetric top has two moments exactly equal and its centre of mass exactly on the third axis, on
either side of the fixed point. The tilt ``theta`` is the angle of the direction to the centre of
mass from the upward vertical, ``phi`` the azimuth of the node line, ``psi`` the angle of spin about
the direction to the centre of mass. For the motion use :func:`rigid.simulate` or
:mod:`rigid.exact`; this package has the quantities of textbooks. A scene may hold many tops: its
axes, the axes of states and the axes of other numbers broadcast as in NumPy.

The package uses :mod:`rigid.exact`, :mod:`rigid.free`, runs and starts of sections; it imports
neither maps nor the planner. :mod:`rigid.figures` uses it.
"""

from .._checks.exported import exported as _exported
from ..exact import SteadyPrecession as SteadyPrecession
from ..exact import steady_precession as steady_precession
from ..sections.starts import on_surface as on_surface
from .constants import HeavyConstants as HeavyConstants
from .constants import gravity_torque as gravity_torque
from .constants import heavy_constants as heavy_constants
from .constants import precession_spin_rates as precession_spin_rates
from .cubic import Roots as Roots
from .cubic import f_roots as f_roots
from .cubic import f_u as f_u
from .cubic import nutation_period as nutation_period
from .cubic import time_of as time_of
from .cubic import u_of as u_of
from .loci import Advance as Advance
from .loci import FastTop as FastTop
from .loci import Locus as Locus
from .loci import advance as advance
from .loci import classify_locus as classify_locus
from .loci import fast_top_approx as fast_top_approx
from .loci import locus as locus
from .potential import EffectivePotential as EffectivePotential
from .potential import effective_minimum as effective_minimum
from .potential import effective_potential as effective_potential
from .potential import turning_angles as turning_angles
from .steady import SleepingTop as SleepingTop
from .steady import SpinDown as SpinDown
from .steady import sleeping_top as sleeping_top
from .steady import spin_down as spin_down
from .steady import spin_from_precession as spin_from_precession
from .steady import upright_f as upright_f

__all__ = _exported(globals())
