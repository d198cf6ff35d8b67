"""The polhodes of one energy
==========================

Each curve holds the ends of omega of a free body, on the ellipsoid of one energy, for one angular
momentum. Around the axes of the smallest and of the largest moment the curves are closed: rotation
about these axes is stable. The two ellipses through the ends of the middle axis are the separatrix.
Near the separatrix the body rotates about its middle axis for a long time, then flips, and flips
back.

How to: :doc:`compute free rotation, step by step </tutorial_pages/plot_1_free_rotation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 4.5), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.polhodes((1.0, 2.0, 3.0)).plot(ax)

plt.show()
