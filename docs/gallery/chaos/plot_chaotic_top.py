"""Regular islands of a chaotic top
================================

An asymmetric top released with a spin about its third axis, which is tilted. Yellow motions are
regular, dark ones are chaotic; hatched ones are undecided at this horizon. Below: the exponents,
on the same grid, bright where they are small.

How to: :doc:`ask whether a motion is chaotic </chaos>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid

top = rigid.HeavyTop(
    rigid.Body((1.0, 1.6, 0.7)),
    mgl=1.2,
    com=np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93]),
)
result = rigid.stability_map(
    top,
    axes={"tilt": np.linspace(0.05, 3.09, 64), "spin": np.linspace(0.0, 8.0, 64)},
    start=rigid.Start(spin=0.0),
    stable=rigid.regular(),
    t_end=200.0,
    samples=1,
    rng=2026,
    progress=False,
)
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 10), layout="constrained")
result.plot(ax=above)
result.plot(ax=below, what="exponent")
plt.show()
