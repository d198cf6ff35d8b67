"""The free symmetric top seen from the body
=========================================

Without torque, the part of omega along the axis of a symmetric top stays, and the part A across it
turns at the constant rate ``k = omega3 (I3 - I) / I``. So omega goes around the axis on a cone,
seen from the body: the same way as the spin for an oblate top such as the Earth, whose pole moves
on a small circle in some 300 days if the Earth is taken as rigid, and the other way for a prolate
one.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 6))
ax = figure.add_subplot(projection="3d")
figures.free_top_omega((1.0, 1.0, 1.6), [0.9, 0.0, 1.3], t=1.5, ax=ax)

plt.show()
