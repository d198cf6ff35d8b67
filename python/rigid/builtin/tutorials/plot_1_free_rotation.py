r"""
Free rotation
=============

A thrown body turns steadily about its longest and its shortest axis, and turns over about the one
between. This page shows why: Euler's equations, flips, Poinsot's construction, and the cones of a
symmetric body.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid import figures

# %%
# Which axis is unstable?
# -----------------------
#
# A box has sides of 25 cm, 8 cm and 1 cm along its axes 1, 2, 3. Euler's equations read
#
# .. math:: \dot\omega_1 = \gamma_1\,\omega_2\omega_3,\quad \gamma_1 = \frac{I_2 - I_3}{I_1}
#
# and cyclically. Near a rotation about axis :math:`k` a small perturbation grows like
# :math:`e^{\lambda t}` if the product of the other two :math:`\gamma` is positive. That is so for
# the middle axis only.
body = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
gammas = np.array(body.gammas)
growth = np.sqrt(gammas[0] * gammas[2])  # at 1 rad/s
print("gamma:", gammas.round(3))
print(f"about axis 2, at 1 rad/s, a perturbation grows by e in {1 / growth:.3f} s")
# sphinx_gallery_start_ignore
assert np.allclose(gammas, [-63 / 65, 312 / 313, -561 / 689])
assert abs(growth - 0.888352678) < 1e-9
# sphinx_gallery_end_ignore

# %%
# Throw it about axis 2
# ---------------------
#
# The motion has a closed form, so the flips are known to rounding. Between two flips the box turns
# nearly steadily; it is the flip that is short.
scene = rigid.FreeBody(body)
start = [0.05, 1.05, -0.05]
run = rigid.simulate(scene, start, t=np.linspace(0.0, 30.0, 601))
flips = rigid.exact.flip_times(scene, start, count=2)
print("it turns over at", flips.round(3), "s")
# sphinx_gallery_start_ignore
assert np.allclose(run.omega[-1], [0.0710711568231, -1.04874988073, -0.0681404080350], atol=1e-10)
assert abs(2.0 * np.diff(flips)[0] - 22.4739532603) < 1e-7  # the period
# sphinx_gallery_end_ignore
ax = run.plot()
ax.set_title("A box thrown about its middle axis")
plt.show()

# %%
# Poinsot: a body that rolls
# --------------------------
#
# Energy and angular momentum are constant, so the ellipsoid of inertia rolls on a plane at right
# angles to :math:`L`. The distance of the plane from the centre is the component of
# :math:`\omega` along :math:`L`, which is :math:`2E/L`.
three = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
rolling = rigid.simulate(three, [1.1, 0.3, 0.4], t=np.linspace(0.0, 20.0, 801))
momenta = rolling.momentum()
along = np.sum(rolling.omega * momenta, axis=1) / np.linalg.norm(momenta, axis=1)
print(f"component along L: {along[0]:.6f} rad/s; it changes by {np.ptp(along):.0e}")
# sphinx_gallery_start_ignore
assert np.ptp(along) < 1e-14
asymmetric = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
state = rigid.simulate(asymmetric, [0.3, 0.2, 1.2], t=[10.0]).omega[-1]
assert np.allclose(state, [0.360501364129, -0.00622627184467, 1.20553739518], atol=1e-11)
# sphinx_gallery_end_ignore
figures.poinsot(rolling, frame=455).plot()
plt.show()

# %%
# The path of :math:`\omega` on the ellipsoid is the *polhode*. About the longest and the shortest
# axis polhodes are small closed curves, so the rotation stays; through the middle axis passes the
# separatrix.
#
# A symmetric body
# ----------------
#
# With :math:`I_1 = I_2` the polhode is a circle: in the body :math:`\omega` goes round axis 3 at
# :math:`k = \omega_3 (I_3 - I_1)/I_1`. In space the axis goes round :math:`L` at :math:`L/I_1`.
disk = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.6)))
omega = np.array([0.9, 0.0, 2.3])
k = omega[2] * 0.6
precession = np.linalg.norm(np.array(disk.body.moments) * omega)
run = rigid.simulate(disk, omega, t=[0.0, 2.0 * np.pi / k])
print(f"in the body {k:.3f} rad/s, in space {precession:.4f} rad/s")
print("after one period in the body:", run.omega[-1].round(9))
# sphinx_gallery_start_ignore
momentum = np.array(disk.body.moments) * omega
assert abs(2.0 * np.pi / k - 4.55303283129) < 1e-10
assert abs(np.arctan2(momentum[0], momentum[2]) - 0.239857068984) < 1e-11
assert abs(precession - 3.7884561499) < 1e-9
assert np.allclose(run.omega[-1], omega, atol=1e-12)
# sphinx_gallery_end_ignore

# %%
# So a body cone rolls on a space cone. :doc:`The gallery </figures/index>` draws both cones, and
# ``run.animate("disk.html")`` shows the motion. :doc:`Draw a stability map </maps>` to see how
# steady a throw must be.
