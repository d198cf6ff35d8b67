"""Error against run time of all methods, over short and long runs, and the stress suite.

From low to high: ``spec``, ``ensemble`` (the bodies that are run), ``reference`` (the solution that
errors are measured against), ``data`` (rows and JSON), ``sweep`` (the measurement), ``table`` and
``plot``, ``result`` with :class:`rigid.Report`, ``compute`` with :func:`rigid.report`. The modules
``stress_cases`` and ``stress`` with :func:`rigid.extremes` are separate. The package uses
``model``, ``solve`` and ``drawing``; the command line and citations use the package.
"""
