"""Error against run time of all methods, over short and long runs, and the stress suite.

From low to high: ``spec``, ``stored`` (JSON), ``ensemble`` (the bodies that are run), ``reference``
(the solution that errors are measured against), ``row``, ``sweep`` (the measurement), ``data`` and
``long_data`` (the numbers), tables and plots, ``result`` with :class:`rigid.Report` and
:class:`rigid.LongRun`, ``compute`` with :func:`rigid.report`, and ``long_run`` with
:func:`rigid.long_run`. The modules ``stress_cases`` and ``stress`` with :func:`rigid.extremes` are
separate. The package uses ``model``, ``solve`` and ``drawing``; the command line and citations
use the package.
"""
