"""Poincaré sections: the surface, the points where motions cross it, and starts on it.

Uses the integration of :mod:`rigid.solve`; the command line and :mod:`rigid.top` use it.
"""
