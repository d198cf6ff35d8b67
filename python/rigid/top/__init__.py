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

from ..exact import SteadyPrecession, steady_precession
from ..sections.starts import on_surface
from .constants import HeavyConstants, gravity_torque, heavy_constants, precession_spin_rates
from .cubic import Roots, f_roots, f_u, nutation_period, time_of, u_of
from .loci import Advance, FastTop, Locus, advance, classify_locus, fast_top_approx, locus
from .potential import EffectivePotential, effective_minimum, effective_potential, turning_angles
from .steady import (
    SleepingTop,
    SpinDown,
    sleeping_top,
    spin_down,
    spin_from_precession,
    upright_f,
)

__all__ = [
    "Advance",
    "EffectivePotential",
    "FastTop",
    "HeavyConstants",
    "Locus",
    "Roots",
    "SleepingTop",
    "SpinDown",
    "SteadyPrecession",
    "advance",
    "classify_locus",
    "effective_minimum",
    "effective_potential",
    "f_roots",
    "f_u",
    "fast_top_approx",
    "gravity_torque",
    "heavy_constants",
    "locus",
    "nutation_period",
    "on_surface",
    "precession_spin_rates",
    "sleeping_top",
    "spin_down",
    "spin_from_precession",
    "steady_precession",
    "time_of",
    "turning_angles",
    "u_of",
    "upright_f",
]
