"""Stability maps: parameters, specification, computation, theory, pictures and files.

From low to high: ``axes`` and ``grid`` (the nominal start of every pixel), ``spec``, ``plan``
and ``job`` (the request as the core reads it), ``data`` (the arrays), what reads these (``theory``,
``summary``, ``plot``, ``file``, ``dataset``, ``replay``, ``samples``, and ``page`` for the map
explorer). Uses ``model``, ``solve``, ``drawing`` and ``animation``; ``store`` computes maps.
"""
