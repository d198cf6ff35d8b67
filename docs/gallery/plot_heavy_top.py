"""The heavy top and its angles
============================

A top turns about the fixed point O under the weight at its centre of mass C, at the distance l. The
torque ``M g l sin theta`` is along the line of nodes, and so across the vertical as well as across
the axis: the angular momenta about these two stay constant, and theta alone is left to be solved
for.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.heavy_top(scene, [0.8, 0.6, 0.9], ax=ax)

plt.show()
