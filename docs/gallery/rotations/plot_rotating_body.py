"""Velocities in a rotating body
=============================

At each instant, every point of a body that rotates about a fixed point moves on a circle about the
axis through omega, with the velocity ``v = omega × r``. Points on the axis are at rest. The speed
grows with the distance from the axis, and the distance between any two points is constant.

Background: :doc:`the equations of motion </notation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

omega = [0.25, 0.1, 1.0]
points = [[0.6, -0.4, -0.9], [0.6, -0.4, 0.9], [-0.5, 0.4, 0.9], [0.225, 0.09, 0.9]]
figure = plt.figure(figsize=(6, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.rotating_body(points, omega, sides=[1.2, 0.8, 1.8]).plot(ax)

plt.show()
