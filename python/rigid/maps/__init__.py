"""Stability maps: parameters, specification, computation, result, theory, pictures and files.

From low to high: ``parameters`` and ``grid`` (the nominal start of every pixel), ``spec``, ``plan``
and ``job`` (the request as the core reads it), ``data`` (the arrays), what reads these (``theory``,
``summary``, ``plot``, ``file``, ``dataset``, ``replay``, ``sensitivity``), ``result`` with
:class:`rigid.StabilityMap`. Uses ``model``, ``solve`` and ``drawing``; ``store`` computes maps.
"""
