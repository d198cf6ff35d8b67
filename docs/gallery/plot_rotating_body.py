"""Velocities in a rotating body
=============================

At each instant, every point of a body that rotates about a fixed point moves on a circle about the
axis through omega, with the velocity ``v = omega × r``. Points on the axis are at rest. The speed
grows with the distance from the axis, and the distance between any two points is constant.
"""

from itertools import product

import matplotlib.pyplot as plt

from rigid import figures

corners = list(product((-1.0, 1.0), (-0.6, 0.6), (-0.3, 0.3)))
figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.rotating_body(corners, [0.35, 0.1, 1.2], ax=ax)

plt.show()
