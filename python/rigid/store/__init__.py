"""The computation of maps, in memory or in folders, and their results.

A running map is computed in many sittings, by many processes, on many machines. It is a folder of a
specification, ``head.json``, and of logs, one for each process that has computed rows. What is done
is what rows there are. Nothing is rewritten, nothing is locked.

From low to high: ``disk`` (every operation on files), ``head`` and ``rows`` (the specification and
the numbers of a unit of work), ``log`` (the tar files), ``running`` (the rows of a folder, or of
the memory), ``drive`` (blocks of work on threads or executors), ``resume`` (what is missing, and
whether this machine computes the rows that there are), ``status`` (what a map has, and what a call
would compute), ``zooms`` (the finer maps of the widget), ``result`` with
:class:`rigid.StabilityMap`, ``compare`` (two maps, or a map and its numbers computed again),
``store`` with :class:`rigid.Store`, and ``call`` with :func:`rigid.stability_map`. Uses ``maps``;
the command line uses it.
"""
