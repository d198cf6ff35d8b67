"""Loops, cusps and monotone precession of a heavy top
===================================================

The axis of a symmetric top stays between two circles on the unit sphere. The shape of its path
depends on where ``phi' = (a - b cos) / sin²`` changes sign. Between the circles: loops. On the
upper circle, as for a top that is released at rest: cusps. Outside the circles: the precession is
monotone; it has the sense of the spin or, if ``a/b`` is below both circles, is retrograde. All four
tops start at 60 degrees, pushed sideways at -0.3, 0, 0.2 and -4 rad/s.

How to: :doc:`compute a heavy top, step by step </tutorial_pages/plot_2_heavy_top>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
push, spin = np.array([-0.3, 0.0, 0.2, -4.0]), np.array([5.0, 5.0, 5.0, 1.0])
omega = np.stack([np.zeros(4), np.sin(np.pi / 3) * push, spin], axis=1)
figure, axes = plt.subplots(
    2, 2, figsize=(8, 8), subplot_kw={"projection": "3d"}, layout="constrained"
)
figures.loci(top, omega, tilted).plot(axes)

plt.show()

# %%
# A single top that starts on its lower circle: large loops that nearly reach the vertical. Seen
# from as many degrees as the lower circle is tilted, no part of the path is hidden.

figure = plt.figure(figsize=(6, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.locus(top, [0.0, 1.5 * np.sin(np.pi / 3), 5.0], tilted, elev=60.0).plot(ax)
ax.set_title("loops of a top that starts on its lower circle")

plt.show()
