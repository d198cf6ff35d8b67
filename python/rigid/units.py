"""Workshop units as numbers: ``omega = 300 * units.rpm``, ``run.omega / units.degree``.

All numbers of :mod:`rigid` are in SI units. Quantities of `Pint <https://pint.readthedocs.io>`_
are taken wherever a length, a mass, a moment of inertia, a time, an angle, a rate, a torque or a
damping is expected; they become numbers in SI units when given, and one of another kind raises
ValueError. Results are numbers.

Examples
--------
>>> import rigid
>>> from rigid import units
>>> start = rigid.Start(spin=300 * units.rpm, tilt=5 * units.degree)
>>> round(start.spin, 6), round(start.tilt, 6)
(31.415927, 0.087266)
"""

from __future__ import annotations

from math import pi

__all__ = ["degree", "rpm"]

degree: float = pi / 180.0
"""One degree in rad; also one degree per second in rad/s."""

rpm: float = 2.0 * pi / 60.0
"""One revolution per minute in rad/s."""
