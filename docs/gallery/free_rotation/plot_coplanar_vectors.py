"""L, omega and the axis lie in one plane
======================================

A free symmetric top has its axis, its angular velocity and its angular momentum in one plane, which
turns about L. The angles from the axis obey ``tan theta = (I / I3) tan alpha``: L lies between axis
and omega if the top is oblate, and beyond omega if it is prolate.

How to: :doc:`compute free rotation, step by step </tutorial_pages/plot_1_free_rotation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure, axes = plt.subplots(1, 2, figsize=(8, 4), layout="constrained")
figures.coplanar_vectors([(1.0, 1.0, 1.6), (1.0, 1.0, 0.55)], [0.9, 0.0, 1.3]).plot(axes)

plt.show()
