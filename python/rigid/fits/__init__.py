"""Fits: the body, the forces and the start that measured rates tell.

Uses the runs of :mod:`rigid.solve` and their derivatives; nothing else uses it.
"""
