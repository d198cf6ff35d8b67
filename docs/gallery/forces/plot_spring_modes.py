"""Stiff springs become a rigid body
=================================

A spring joins each pair of five particles. Six of the fifteen modes have frequency zero: the three
translations and the three rotations of a rigid body. The frequencies of the other modes grow with
the square root of the stiffness, and the cost of the integration grows with them. The distance from
the motion of the rigid body is inversely proportional to the stiffness. To compute a rotation, use
the rigid body, not the springs.

Background: :doc:`the equations of motion </notation>`.
"""

import matplotlib.pyplot as plt
import numpy as np

from rigid import figures

masses = [1.0, 2.0, 1.0, 1.5, 1.0]
positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.8, 0.9, 0.7]])
figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
figures.spring_modes(masses, positions, [0.0, 1.0, 0.3], stiffness=[1e2, 1e3, 1e4]).plot(axes)

plt.show()
