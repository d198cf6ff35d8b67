"""Velocities in a rotating body
=============================

Every point of a body that turns about a fixed point goes, at this instant, on a circle about the
axis through omega, with the velocity ``v = omega × r``. Points on the axis are at rest; the speed
rises with the distance from it, and no distance between two points changes.
"""

from itertools import product

import matplotlib.pyplot as plt

from rigid import figures

corners = list(product((-1.0, 1.0), (-0.6, 0.6), (-0.3, 0.3)))
figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.rotating_body(corners, [0.35, 0.1, 1.2], ax=ax)

plt.show()
