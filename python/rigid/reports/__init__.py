"""Error against run time of all methods, and the stress suite of extreme bodies.

From low to high: ``spec``, ``ensemble`` (the bodies that are run), ``reference`` (the solution
that errors are measured against), ``row``, ``sweep`` (the measurement), ``data`` (the numbers),
``table`` and ``plot``, ``result`` with :class:`rigid.Report`, and ``compute`` with
:func:`rigid.report`. The modules ``stress_cases`` and ``stress`` with :func:`rigid.extremes` are
separate. The package uses ``model``, ``solve`` and ``drawing``; the command line and citations
use the package.
"""
