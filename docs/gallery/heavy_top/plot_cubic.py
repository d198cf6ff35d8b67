"""The cubic of the heavy top
==========================

The height ``u = cos(theta)`` of a symmetric top obeys ``u'² = f(u)`` with a cubic f. The top moves
where f is positive between -1 and 1 (grey), from u1 to u2; it never reaches the third root. The
precession reverses at ``u = a/b``. For a top with loops, as here, this height lies between the
roots; for a top with cusps it is u2.

How to: :doc:`compute a heavy top, step by step </tutorial_pages/plot_2_heavy_top>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
figure, ax = plt.subplots(figsize=(7, 5), layout="constrained")
figures.cubic(top, [0.0, -0.3 * np.sin(np.pi / 3), 5.0], tilted).plot(ax)

plt.show()
