"""Euler angles as three rotations
===============================

Three rotations produce the attitude of a body: by phi about the vertical, by theta about the line
of nodes N, by psi about the axis of the body. Each panel shows the axes before the rotation dashed
and after the rotation solid; two axes move by the same angle, and one stays. Seen from above, the
first rotation is a rotation of the plane: a point keeps its place and gets other coordinates.

How to: :doc:`convert Euler angles </bodies>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(8, 8), layout="constrained")
axes = [figure.add_subplot(2, 2, place, projection="3d") for place in (1, 2, 3)]
figures.euler_steps([0.7, 0.6, 0.8]).plot([*axes, figure.add_subplot(2, 2, 4)])

plt.show()
