"""The axes of space and of the body
=================================

Six numbers give the position and attitude of a rigid body: three for the origin of its axes, three
angles for their direction. The dashed axes are parallel to the axes of space (thin, O') and move
with the origin of the body (thick, O). A point P of the body has constant components along the
thick axes. Its position in space is ``r = R + r'``.

Background: :doc:`axes, attitudes and signs in this library </notation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 4.5), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.frames([0.6, 0.7, 0.4], origin=[1.6, 1.2, 0.5], point=[0.4, -0.8, -0.5]).plot(ax)

plt.show()
