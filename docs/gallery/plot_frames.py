"""Frames of a rigid body
======================

Six numbers place a rigid body: three for the origin of its axes, three angles for their direction.
Between the axes of space (thin, O') and those of the body (thick, O) stand axes that are parallel
to the first and go with the second (dashed). A point P of the body has constant components along
the thick axes and is seen from space at ``r = R + r'``.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.frames([0.6, 0.7, 0.4], origin=[1.6, 1.2, 0.5], point=[0.9, -0.7, 0.3], ax=ax)

plt.show()
