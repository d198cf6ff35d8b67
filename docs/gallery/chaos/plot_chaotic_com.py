"""Chaos between Lagrange's top and Kovalevskaya's
===============================================

A top with the moments 2, 2 and 1 whose centre of mass leaves the axis of symmetry. On the axis, at
the left edge, it is Lagrange's top; across it, at the right edge, Kovalevskaya's: there every
motion is regular, whatever the spin. Between them there is chaos. Below: the exponents, bright
where they are small; Lagrange's top has a closed form, and none is measured.

How to: :doc:`ask whether a motion is chaotic </chaos>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid

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
result.plot(ax=below, what="exponent")
plt.show()
