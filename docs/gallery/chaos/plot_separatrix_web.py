"""How chaotic tops form a web
===========================

A Lagrange top gets slightly different moments. Its slow nutation near the upright position has a
separatrix, which becomes a chaotic layer; thinner layers follow the resonances of nutation and
spin. Below: the mean MEGNO, which tends to 2 on regular motions. The symmetric top at the left edge
has a closed form; no MEGNO is measured there.

How to: :doc:`ask whether a motion is chaotic </chaos>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import CHAOS_MAP

result = rigid.stability_map(
    rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
    axes={"I2/I1": np.linspace(1.0, 1.3, 64), "tilt": np.linspace(0.02, 1.4, 64)},
    start=rigid.Start(spin=2.0),
    stable=rigid.regular(),
    t_end=400.0,
    samples=1,
    rng=2026,
    progress=False,
)
figure, (above, below) = plt.subplots(2, 1, figsize=(8, 10), layout="constrained")
result.plot(ax=above)

x, y = result.spec.axes
megno = np.minimum(result.mean_megno, 10.0)
mesh = below.pcolormesh(x.values, y.values, megno, cmap=CHAOS_MAP, rasterized=True)
below.set(xlabel=x.label, ylabel=y.label)
figure.colorbar(mesh, ax=below, label="mean MEGNO, at most 10")

plt.show()
