"""The effective potential of a heavy top
======================================

With its two momenta constant, the tilt of a symmetric top moves as a particle in a well: the weight
pulls it down, and the term ``I1 (a - b cos)² / (2 sin²)`` of the precession keeps it off the
vertical. With the energy E' it goes up and down between the two circles where the well is as high;
with the least energy it stays at the bottom, which is steady precession. Here a top is let go at 60
degrees with a spin of 5 rad/s: that is its upper circle.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
figure, ax = plt.subplots(figsize=(7, 5), layout="constrained")
figures.effective_potential(top, [0.0, 0.0, 5.0], tilted, ax=ax)

plt.show()
