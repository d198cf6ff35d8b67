"""The heavy top and its angles
============================

A top turns about the fixed point O under the weight at its centre of mass C, at the distance l. The
torque ``mgl sin theta`` is along the line of nodes, perpendicular to the vertical and to the axis
of the top. So the angular momenta about the vertical and about the axis are constant, and theta is
the only unknown.

How to: :doc:`describe a top on its tip </bodies>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

scene = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure = plt.figure(figsize=(6, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.heavy_top(scene, [0.8, 0.6, 0.9]).plot(ax)

plt.show()
