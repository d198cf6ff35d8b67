"""The effective potential of a heavy top
======================================

Two momenta of a symmetric top are constant, so its tilt moves like a particle in a potential well.
The weight pulls the tilt down; the term ``I1 (a - b cos)² / (2 sin²)`` of the precession keeps it
away from the vertical. With the energy E' the tilt moves between the two angles at which the
potential is E'. With the least energy the tilt stays at the minimum: this is steady precession.
Here a top is released at 60 degrees with a spin of 5 rad/s; this tilt is its upper turning point.

How to: :doc:`compute a heavy top, step by step </tutorial_pages/plot_2_heavy_top>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
figure, ax = plt.subplots(figsize=(7, 5), layout="constrained")
figures.effective_potential(top, [0.0, 0.0, 5.0], tilted).plot(ax)

plt.show()
