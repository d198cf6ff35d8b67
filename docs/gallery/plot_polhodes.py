"""All polhodes of one energy
==========================

The ends of omega of a free body, for one energy and all angular momenta, on its inertia ellipsoid.
Around the axes of the least and of the largest moment the curves are closed: rotations about these
axes last. The two ellipses through the ends of the middle axis are the separatrix: near them the
body stays about the middle axis for long, then turns over, and back again.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(7, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.polhodes((1.0, 2.0, 3.0), ax=ax)

plt.show()
