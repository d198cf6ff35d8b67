"""A free symmetric top, seen from the body
========================================

Without torque, the component of omega along the axis of a symmetric top is constant, and the
component A perpendicular to the axis rotates at the constant rate ``k = omega3 (I3 - I) / I``. Seen
from the body, omega moves around the axis on a cone. For an oblate top it moves in the sense of the
spin: the pole of a rigid Earth would move on a small circle in some 300 days. For a prolate top it
moves in the opposite sense.

How to: :doc:`compute free rotation, step by step </tutorial_pages/plot_1_free_rotation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(6, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.free_top_omega((1.0, 1.0, 1.6), [0.9, 0.0, 1.3], t=1.5).plot(ax)

plt.show()
