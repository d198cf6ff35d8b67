"""How a unit vector changes
=========================

A unit vector that turns with a frame cannot change its length, so it changes across itself:
``de/dt = omega × e``. In a small turn by delta about the second axis, the first unit vector moves
by delta towards the negative third axis. What is left between the true change and its first order
falls as the square of the angle.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.unit_vector_change(0.35, unit=1, about=2, ax=ax)

plt.show()
