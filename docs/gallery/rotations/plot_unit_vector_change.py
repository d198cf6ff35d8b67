"""How a rotating unit vector changes
==================================

A unit vector that rotates with a frame cannot change its length, so its change is perpendicular to
itself: ``de/dt = omega × e``. In a small rotation by delta about the second axis, the first unit
vector moves by delta towards the negative third axis. The difference between the true change and
its first order decreases with the square of the angle.

Background: :doc:`the equations of motion </notation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(6, 5.5), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.unit_vector_change(0.45, unit=1, about=2).plot(ax)

plt.show()
