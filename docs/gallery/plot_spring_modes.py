"""Stiff springs become a rigid body
=================================

Five particles, each pair joined by a spring. Of the fifteen modes six have no frequency: the three
shifts and the three turns of a rigid body. The frequencies of the others rise as the root of the
stiffness, and with them the cost of the steps; the distance from the motion of the rigid body falls
as one over it. Rotation is better computed without the springs.
"""

import matplotlib.pyplot as plt
import numpy as np

from rigid import figures

masses = [1.0, 2.0, 1.0, 1.5, 1.0]
positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.8, 0.9, 0.7]])
figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
figures.spring_modes(masses, positions, [0.0, 1.0, 0.3], stiffness=[1e2, 1e3, 1e4], axes=axes)

plt.show()
