"""Active and passive turns
========================

The same matrix turns the axes one way or the vector the other way. Passive: the axes turn by
epsilon, the vector stays and has other components. Active: the vector turns, the axes stay; to
first order it gains ``epsilon n × r``, across itself. This library's rotations are active, from
body to space; the passive ones are their transposes.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure, axes = plt.subplots(1, 2, figsize=(8, 4), layout="constrained")
figures.active_passive(0.35, axes=axes)

plt.show()
