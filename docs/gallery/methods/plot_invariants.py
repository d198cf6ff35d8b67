"""Which method conserves energy and momentum
==========================================

Two methods of order 4 compute a tumbling body over a hundred turns with the same step; the drift of
energy and angular momentum is drawn. The Runge-Kutta method loses a little of each in every step.
The symplectic splitting preserves the angular momentum in the body and in space to rounding, and
the error of its energy does not grow.

How to: :doc:`choose a method </methods>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

body = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), sharey=True, layout="constrained")
for ax, method in zip(axes, ("rk4", "splitting4"), strict=True):
    run = rigid.simulate(
        body, [1.0, 1.0, 1.0], t=np.linspace(0.0, 500.0, 1001), method=method, step=0.05
    )
    figures.invariants(run).plot(ax)
axes[0].get_legend().remove()  # the legend of the second panel names both
axes[1].set(ylabel="", ylim=(1e-17, 1e-4))

plt.show()
