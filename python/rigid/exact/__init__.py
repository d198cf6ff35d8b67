"""Closed forms of the free body and the Lagrange top, and the elliptic functions in them.

The functions give periods, flip times, precession and nutation without integration. The formulas
come from Whittaker, *Analytical Dynamics*, §§ 69, 71; Landau and Lifshitz, *Mechanics*, §§ 35, 37;
and Goldstein, *Classical Mechanics*, §§ 5.6, 5.7; written with the symmetric integrals of B. C.
Carlson, *Numerical Algorithms* 10 (1995) 13, and arranged so that no digits cancel near a
separatrix, a pole, or a symmetric or spherical body.

The modules are ``elliptic``, ``free``, ``flips`` and ``top``. They use ``model``, ``_checks``
and the core. ``free``, ``top`` and the figures use them.
"""

from .._checks.exported import exported as _exported
from .elliptic import agm as agm
from .elliptic import carlson_rc as carlson_rc
from .elliptic import carlson_rd as carlson_rd
from .elliptic import carlson_rf as carlson_rf
from .elliptic import carlson_rj as carlson_rj
from .elliptic import jacobi as jacobi
from .flips import flip_times as flip_times
from .free import FreeMotion as FreeMotion
from .free import free_body as free_body
from .top import SteadyPrecession as SteadyPrecession
from .top import TopMotion as TopMotion
from .top import lagrange_top as lagrange_top
from .top import pendulum_period as pendulum_period
from .top import sleeping_spin as sleeping_spin
from .top import steady_precession as steady_precession
from .top import tilt_time as tilt_time

__all__ = _exported(globals())
