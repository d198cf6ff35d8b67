"""Which rotations of a free body are stable
=========================================

Free bodies with ``I1 = 1`` and ``I3 = 2`` spin about axis 2 or at an angle to it. Each pixel is an
ensemble of bodies; its colour is the share of bodies that never flip. If I2 is the middle moment,
all bodies flip. If I2 is the largest moment, the rotation is stable up to a tilt. The white line is
the theoretical border, the separatrix ``2 E I2 = L²``.

How to: :doc:`compute such a map </maps>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid

result = rigid.stability_map(
    rigid.FreeBody,
    axes={"I2": np.linspace(0.8, 2.4, 60), "tilt": np.linspace(0.0, 1.5, 60)},
    samples=40,
    t_end=100.0,
    start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.03)),
    stable=rigid.no_flip(),
    rng=2026,
    progress=False,
)
figure, ax = plt.subplots(figsize=(8, 6), layout="constrained")
result.plot(ax=ax)

plt.show()
