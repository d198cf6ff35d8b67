"""Figures without a display, axes in space, arrows, colours and the faces of solids.

Uses :mod:`rigid.rotations`, NumPy and, inside functions, Matplotlib. Plots of maps and reports,
:mod:`rigid.animation` and :mod:`rigid.figures` use it.
"""
