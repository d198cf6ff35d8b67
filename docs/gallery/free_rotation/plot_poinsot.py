"""Poinsot's rolling ellipsoid
===========================

A free body rotates as if its inertia ellipsoid rolled without slipping on a plane that is fixed in
space and perpendicular to the angular momentum. The ellipsoid touches the plane at omega, where the
body is instantaneously at rest. On the ellipsoid the point of contact moves around a closed curve,
the polhode. In the plane it draws the herpolhode, which in general does not close: bold from its
first point to the present one, thin after it.

How to: :doc:`compute free rotation, step by step </tutorial_pages/plot_1_free_rotation>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

body = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
run = rigid.simulate(body, [1.1, 0.3, 0.4], t=np.linspace(0.0, 20.0, 801))
figure = plt.figure(figsize=(7, 7), layout="constrained")
ax = figure.add_subplot(projection="3d")
figures.poinsot(run, frame=455).plot(ax)

plt.show()

# %%
# ``run.animate("poinsot.html")`` writes the motion to a page that plays in a browser.
