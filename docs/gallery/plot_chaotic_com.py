"""Between two theorems
====================

A top with the moments 2, 2 and 1 whose centre of mass leaves the axis of symmetry. On the axis, at
the left edge, it is Lagrange's top; across it, at the right edge, Kovalevskaya's: there every
motion is regular, whatever the spin. Between them there is chaos. Below: the exponents; Lagrange's
top has a closed form, and none is measured.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.figures.colours import CHAOS_MAP

result = rigid.stability_map(
    rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0),
    axes={"com_tilt": np.linspace(0.0, 0.5 * np.pi, 64), "spin": np.linspace(0.0, 5.0, 64)},
    start=rigid.Start(spin=0.0, tilt=1.0),
    stable=rigid.regular(),
    t_end=800.0,
    samples=1,
    rng=2026,
    progress=False,
)
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 10), layout="constrained")
result.plot(ax=above)

x, y = result.spec.axes
mesh = below.pcolormesh(x.values, y.values, result.exponent, cmap=CHAOS_MAP, rasterized=True)
below.set(xlabel=x.label, ylabel=y.label)
figure.colorbar(mesh, ax=below, label="mean exponent (1/s)")

plt.show()
