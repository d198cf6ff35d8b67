r"""
Detumbling with magnets
=======================

A CubeSat leaves its launcher tumbling. Its magnetic coils can only turn it across the field of the
Earth, and only weakly. How strong must they be to stop it within two orbits?

The answer takes a torque that you write as a function, and a map over it.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

# %%
# The controller
# --------------
#
# The satellite is on a polar orbit 500 km above the ground. The Earth is a dipole along space axis
# 3. The *B-dot* law makes a magnetic moment against the change of the field that the magnetometer
# sees. For a body that tumbles quickly this change is :math:`-\omega\times B`, so the moment is
# :math:`m = k\,\omega\times B`. Each coil has a largest moment. The torque is :math:`m\times B`.

FIELD = 2.4e-5  # above the equator, T


def magnets(t, omega, attitude, data, torque, orbit_position):
    """B-dot with a gain and a largest moment, along the principal axes."""
    gain, most = data[0], data[1]
    a, b, c = orbit_position[0], orbit_position[1], orbit_position[2]
    x, y, z = 3.0 * FIELD * c * a, 3.0 * FIELD * c * b, FIELD * (3.0 * c * c - 1.0)
    # This field is in space. The transpose of the rotation matrix turns it into the body.
    w, i, j, k = attitude[0], attitude[1], attitude[2], attitude[3]
    b1 = (1 - 2 * (j * j + k * k)) * x + 2 * (i * j + w * k) * y + 2 * (i * k - w * j) * z
    b2 = 2 * (i * j - w * k) * x + (1 - 2 * (i * i + k * k)) * y + 2 * (j * k + w * i) * z
    b3 = 2 * (i * k + w * j) * x + 2 * (j * k - w * i) * y + (1 - 2 * (i * i + j * j)) * z
    m1 = min(most, max(-most, gain * (omega[1] * b3 - omega[2] * b2)))
    m2 = min(most, max(-most, gain * (omega[2] * b1 - omega[0] * b3)))
    m3 = min(most, max(-most, gain * (omega[0] * b2 - omega[1] * b1)))
    torque[0] = m2 * b3 - m3 * b2
    torque[1] = m3 * b1 - m1 * b3
    torque[2] = m1 * b2 - m2 * b1


# %%
# One satellite
# -------------
#
# ``Torque.call`` takes the function and its two numbers, the gain and the largest moment. numba
# compiles it where it is installed. The gravity gradient of the orbit acts too. ``until`` ends the
# run at 0.01 rad/s, which is slow enough to point the satellite.
body = rigid.Body((0.02, 0.035, 0.04))  # kg m²
torque = rigid.Torque.call(magnets, [1e5, 0.02])
orbit = rigid.Orbit(1.107e-3, normal=(0.0, -1.0, 0.0))
run = rigid.simulate(
    rigid.FreeBody(body, torque=torque, orbit=orbit),
    [0.1, 0.12, -0.09],
    t=np.linspace(0.0, 2.0 * orbit.period, 601),
    accuracy=1e-6,
    until=rigid.crosses("speed", 0.01, -1),
)
print(f"slow after {float(run.end) / orbit.period:.2f} orbits, error {float(run.error):.0e}")
# sphinx_gallery_start_ignore
energy = run.energy()[run.t < run.end]
assert run.status == rigid.Status.STOPPED
assert (np.diff(energy) < 1e-3 * energy[0]).all()  # the gradient may add a little
# sphinx_gallery_end_ignore

figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
ax.semilogy(run.t / orbit.period, np.linalg.norm(run.omega, axis=1), color=HUES["blue"])
ax.set(xlabel="orbits", ylabel="angular velocity (rad/s)", title="A CubeSat slows down")
plt.show()

# %%
# The coils can never speed the satellite up: their power is :math:`-m\cdot(\omega\times B)`, and
# each component of :math:`m` has the sign of the component beside it. The rotation about the field
# decays last, because no coil can brake it.
#
# A map over the coils
# --------------------
#
# A function of the axes returns the scene. Each pixel is a largest moment and a first spin; its
# four satellites begin in random attitudes. ``fastest`` is a bound of the angular velocity, from
# which the map takes its steps. ``~rigid.spin_above(0.01)`` holds for a body that became slow.


def cubesat(moment):
    data = np.stack([np.full_like(moment, 1e5), moment], axis=-1)
    torque = rigid.Torque.call(magnets, data, fastest=0.25)
    return rigid.FreeBody(body, torque=torque, orbit=orbit)


result = rigid.stability_map(
    cubesat,
    axes={"moment": np.linspace(0.002, 0.024, 12), "spin": np.linspace(0.03, 0.19, 9)},
    start=rigid.Start(
        spin=0.1, axis=3, noise=rigid.normal(0.01), attitude_noise=rigid.uniform_attitude()
    ),
    stable=~rigid.spin_above(0.01),
    t_end=2.0 * orbit.period,
    time_unit=("orbits", orbit.period),
    samples=4,
    rng=2026,
    progress=False,
)
print(result.summary())
# sphinx_gallery_start_ignore
assert result.undecided.sum() < 0.02 * result.stable.size * 4
assert result.share[0, -1] == 1.0
assert result.share[-1, 0] == 0.0
# sphinx_gallery_end_ignore
figure, ax = plt.subplots(figsize=(8, 6), layout="constrained")
result.plot(ax=ax)
ax.set(xlabel="largest moment of a coil (A m²)", ylabel="first spin (rad/s)")
ax.set_title("Is the satellite slow after two orbits?", loc="left")
plt.show()

# %%
# Yellow satellites are slow in time. While a coil is saturated it removes a nearly constant part of
# the spin in each orbit, so the border is nearly a straight line: twice the spin needs twice the
# coil.
#
# A real controller also has wheels and filters. :doc:`Torque functions </forces>` give each body
# further numbers with their own rates of change.
