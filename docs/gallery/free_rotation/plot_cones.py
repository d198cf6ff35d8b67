"""The body cone rolls on the space cone
=====================================

In space, omega of a free symmetric top moves around L on a fixed cone of half angle ``|alpha -
theta|``. In the body, omega moves around the symmetry axis on a cone of half angle alpha. The two
cones touch along omega, where the body is instantaneously at rest. So the body cone rolls on the
space cone: outside for a prolate top, around it for an oblate top. The lower pictures are later by
a sixth of a period of the body cone.

How to: :doc:`compute free rotation, step by step </tutorial_pages/plot_1_free_rotation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures, free

figure = plt.figure(figsize=(9, 9), layout="constrained")
for column, (body, name) in enumerate((((1.0, 1.0, 0.55), "prolate"), ((1.0, 1.0, 1.6), "oblate"))):
    period = float(free.symmetric_free_top(body, [0.9, 0.0, 1.3]).period)
    for row, t in enumerate((0.0, period / 6.0)):
        ax = figure.add_subplot(2, 2, 1 + column + 2 * row, projection="3d")
        figures.cones(body, [0.9, 0.0, 1.3], t=t).plot(ax)
        ax.set_title(f"{name}, t = {t:.2f} s")

plt.show()
