"""Fast tops draw cycloids
=======================

The faster a top spins, the smaller and quicker its nutation; unrolled, the path of its axis comes
near a cycloid. Let go at rest it has cusps; pushed half as fast as the steady precession it only
waves; pushed backward it loops. The first-order cycloid (dashed) has the right width, but runs
ahead or behind in the long run, because the true frequency differs by twice the precession.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure, axes = plt.subplots(3, 1, figsize=(7, 6.5), layout="constrained")
figures.cycloids(top, 1.0, 20.0, axes=axes)

plt.show()
