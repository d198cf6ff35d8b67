"""The frame of the line of nodes
==============================

The node frame follows the line of nodes but does not spin: xi along ON, eta along OM, zeta along
the axis of the body. In this frame the angular velocity has its simplest form, ``(theta', phi' sin
theta, phi' cos theta + psi')``: theta changes about ON, phi about the vertical z', psi about the
axis z. The moments of a symmetric top are constant in this frame too.

Background: :doc:`axes, attitudes and signs in this library </notation>`.
"""

import matplotlib.pyplot as plt

from rigid import figures

figure = plt.figure(figsize=(6.5, 6), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.node_frame([0.9, 0.7, 0.8]).plot(ax)

plt.show()
