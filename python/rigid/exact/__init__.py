"""Closed forms of the free body and the Lagrange top, and the elliptic functions in them.

The functions give periods, flip times, precession and nutation without integration. The formulas
come from Whittaker, *Analytical Dynamics*, §§ 69, 71; Landau and Lifshitz, *Mechanics*, §§ 35, 37;
and Goldstein, *Classical Mechanics*, §§ 5.6, 5.7; written with the symmetric integrals of B. C.
Carlson, *Numerical Algorithms* 10 (1995) 13, and arranged so that no digits cancel near a
separatrix, a pole, or a symmetric or spherical body.

The modules are ``elliptic``, ``free``, ``flips`` and ``top``. They use ``model``, ``_checks``
and the core. ``free``, ``top`` and the figures use them.
"""

from .elliptic import agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj, jacobi
from .flips import flip_times
from .free import FreeMotion, free_body
from .top import (
    SteadyPrecession,
    TopMotion,
    lagrange_top,
    pendulum_period,
    sleeping_spin,
    steady_precession,
    tilt_time,
)

__all__ = [
    "FreeMotion",
    "SteadyPrecession",
    "TopMotion",
    "agm",
    "carlson_rc",
    "carlson_rd",
    "carlson_rf",
    "carlson_rj",
    "flip_times",
    "free_body",
    "jacobi",
    "lagrange_top",
    "pendulum_period",
    "sleeping_spin",
    "steady_precession",
    "tilt_time",
]
