"""Euler angles, turn by turn
==========================

The attitude of a body is reached by three turns: by phi about the vertical, by theta about the line
of nodes N, by psi about the axis of the body. Each panel has the axes before the turn dashed and
those after it solid; two of them move, by the same angle, and one stays. Seen from the vertical,
the first turn is one of the plane, where a point keeps its place and changes its coordinates.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(8, 8), layout="constrained")
axes = [figure.add_subplot(2, 2, place, projection="3d") for place in (1, 2, 3)]
figures.euler_steps([0.7, 0.6, 0.8], axes=[*axes, figure.add_subplot(2, 2, 4)])

plt.show()
