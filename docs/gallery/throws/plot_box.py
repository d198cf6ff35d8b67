"""The three axes of a box
=======================

A box of 25 cm by 8 cm by 1 cm is thrown with a spin. Rotation is stable about the axis through the
largest face, which has the largest moment of inertia, and about the axis through the smallest face.
About the axis between them every perturbation grows, at a rate of 0.89 per second for a spin of 1
rad/s, and the box tumbles.

How to: :doc:`describe a body of your own </bodies>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

figure = plt.figure(figsize=(6, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.box(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3)).plot(ax)

plt.show()
