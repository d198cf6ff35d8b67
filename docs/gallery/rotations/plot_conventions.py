"""Conventions in one picture
==========================

Above: the axes of space (primed), the axes of the body, and the three rotations between them: phi
about the vertical z', theta about the line of nodes ON, psi about the axis z of the body. The
matrix ``R = Rz(phi) Rx(theta) Rz(psi)`` takes components in the body to components in space; the
quaternion ``(w, x, y, z)`` describes the same rotation. Below: a top in the same attitude. The
weight acts along -z'. The centre of mass lies in the direction ``com`` of the body, at a distance l
from the fixed point.

Background: :doc:`axes, attitudes and signs in this library </notation>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures, rotations

angles = [0.9, 0.7, 0.8]  # phi, theta, psi

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)

q = rotations.euler_to_quaternion(angles)
R = rotations.euler_to_matrix(angles)
gamma = R.T @ [0.0, 0.0, 1.0]  # the upward vertical, seen from the body
run = rigid.simulate(top, [0.0, 0.0, 5.0], q, t=[0.0])  # run.gamma is the same
# sphinx_gallery_start_ignore
assert abs(run.rotation().as_matrix() - R).max() < 1e-14
assert abs(run.gamma - gamma).max() < 1e-14
# sphinx_gallery_end_ignore

figure = plt.figure(figsize=(7.5, 13), layout="constrained")
frame = figures.node_frame(angles).plot(figure.add_subplot(2, 1, 1, projection="3d"))
frame.set_title("axes of space, of the body, and of the line of nodes", y=-0.04)
still = figures.heavy_top(top, angles).plot(figure.add_subplot(2, 1, 2, projection="3d"))
still.set_title("a heavy top in this attitude", y=-0.04)

plt.show()
