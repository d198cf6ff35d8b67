"""When an upright top sleeps
==========================

An upright top stays upright if its cubic f is negative near ``u = 1``. Below the least spin ``2
sqrt(mgl I1) / I3`` f is positive there (blue), and the top falls as far as f is positive. The usual
approximation ``(1 - u)² (2 beta - b²)`` is zero at the least spin and does not decide; f itself is
``-beta (1 - u)³`` there, and the top sleeps.

How to: :doc:`compute which tops sleep </tutorial_pages/plot_2_heavy_top>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure, axes = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
figures.upright_cubic(top).plot(axes)

plt.show()
