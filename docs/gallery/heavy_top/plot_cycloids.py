"""A fast top nearly draws a cycloid
=================================

The faster a top spins, the smaller and faster its nutation, and the closer the unrolled path of its
axis comes to a cycloid. If the axis is released at rest, the path has cusps. If it is pushed half
as fast as the steady precession, it never turns back; if it is pushed backward, it makes loops.
The first-order cycloid (dashed) has the right width, but gets ahead or behind over a long time,
because the true frequency differs by twice the precession.

How to: :doc:`compute a heavy top, step by step </tutorial_pages/plot_2_heavy_top>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure, axes = plt.subplots(3, 1, figsize=(7, 6.5), layout="constrained")
figures.cycloids(top, 1.0, 20.0).plot(axes)

plt.show()
