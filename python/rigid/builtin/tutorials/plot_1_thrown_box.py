r"""
The thrown box
==============

A box is thrown about each of its axes. About two axes it lands as it was thrown; about the middle
one it turns over. This page has the theory, the throw, the times of the flips, and a map.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid

# %%
# The box of the laboratory has sides of 25 cm, 8 cm and 1 cm along axes 1, 2, 3. With the mass
# divided out, :math:`12 I/m` is 65, 626 and 689 cm². Euler's equations read
#
# .. math:: \dot\omega_1 = \gamma_1\,\omega_2\omega_3,\quad \gamma_1 = \frac{I_2 - I_3}{I_1}
#
# and so on in a circle.
body = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
gammas = np.array(body.gammas)
# sphinx_gallery_start_ignore
assert np.allclose(gammas, [-63 / 65, 312 / 313, -561 / 689])
# sphinx_gallery_end_ignore
print("gamma", gammas)

# %%
# A rotation about axis :math:`k` grows a small perturbation like :math:`e^{\lambda t}` if the
# product of the other two :math:`\gamma` is positive: only about axis 2.
growth = np.sqrt(gammas[0] * gammas[2])  # at 1 rad/s
# sphinx_gallery_start_ignore
assert abs(growth - 0.888352678) < 1e-9
# sphinx_gallery_end_ignore
print(f"a perturbation grows by e in {1 / growth:.3f} s at 1 rad/s")

# %%
# Throw it about axis 2, with an error of 0.05 rad/s in each rate. The motion has a closed form.
scene = rigid.FreeBody(body)
start = [0.05, 1.05, -0.05]
run = rigid.simulate(scene, start, t=np.linspace(0.0, 30.0, 601))
# sphinx_gallery_start_ignore
assert np.allclose(run.omega[-1], [0.0710711568231, -1.04874988073, -0.0681404080350], atol=1e-10)
# sphinx_gallery_end_ignore
flips = rigid.exact.flip_times(scene, start, count=2)
print("it turns over at", flips.round(3), "s")
# sphinx_gallery_start_ignore
assert abs(2.0 * np.diff(flips)[0] - 22.4739532603) < 1e-7  # the period
# sphinx_gallery_end_ignore

# %%
# The rates show long stays about axis 2 with short flips between.
ax = run.plot()
ax.set_title("A box thrown about its middle axis")

# %%
# How steady must the hand be? A map throws 32 boxes for each side b and each error, with a spin
# of 10 rad/s. Its colour is the share of boxes that still turn the same way after a second.
result = rigid.stability_map(
    scene,
    axes={"b": np.linspace(0.02, 0.24, 45), "noise": np.geomspace(1e-4, 1.0, 40)},
    start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(0.0)),
    stable=rigid.no_flip(2),
    t_end=1.0,
    samples=32,
    rng=2026,
    progress=False,
)
print(result.summary())
result.plot()
plt.show()
