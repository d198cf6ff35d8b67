"""Active and passive rotations
============================

The same matrix rotates the axes one way, or the vector the other way. Passive: the axes rotate by
epsilon; the vector stays and gets other components. Active: the vector rotates and the axes stay;
to first order the vector changes by ``epsilon n × r``, perpendicular to itself. The rotations of
this library are active, from body to space. The passive matrices are their transposes.

Background: :doc:`axes, attitudes and signs in this library </notation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure, axes = plt.subplots(1, 2, figsize=(8, 4), layout="constrained")
figures.active_passive(0.35).plot(axes)

plt.show()
