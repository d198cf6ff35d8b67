"""A box and its axes
==================

A box of 25 cm by 8 cm by 1 cm, thrown spinning: about the axis through its largest face, which has
the largest moment of inertia, and about that through the smallest face the rotation lasts; about
the axis between them every disturbance grows, at 0.89 per second for a turn at 1 rad/s, and the box
tumbles.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.box(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3), ax=ax)

plt.show()
