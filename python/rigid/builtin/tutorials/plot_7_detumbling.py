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
# The satellite is on a polar orbit 500 km above the ground, in the plane of the space axes 1 and 3.
# The Earth is a dipole along axis 3. The *B-dot* law makes a magnetic moment against the change of
# the field that the magnetometer sees. For a body that tumbles quickly this change is
# :math:`-\omega\times B`, so the moment is :math:`m = k\,\omega\times B`. Each coil has a largest
# moment. The torque is :math:`m\times B`.

RATE = 1.107e-3  # mean motion of the orbit, rad/s
FIELD = 2.4e-5  # field above the equator, T


def magnets(t, omega, attitude, data, torque):
    """B-dot with a gain and a largest moment, along the principal axes."""
    gain, most = data[0], data[1]
    sine, cosine = np.sin(RATE * t), np.cos(RATE * t)
    x, z = 3.0 * FIELD * sine * cosine, FIELD * (3.0 * sine * sine - 1.0)
    # The columns of the rotation matrix that turn this field (x, 0, z) into the body.
    w, i, j, k = attitude[0], attitude[1], attitude[2], attitude[3]
    b1 = x * (w * w + i * i - j * j - k * k) + 2.0 * z * (i * k - w * j)
    b2 = 2.0 * x * (i * j - w * k) + 2.0 * z * (j * k + w * i)
    b3 = 2.0 * x * (i * k + w * j) + z * (w * w - i * i - j * j + k * k)
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
# compiles it where it is installed. ``until`` ends the run at 0.01 rad/s, which is slow enough to
# point the satellite.
body = rigid.Body((0.02, 0.035, 0.04))  # kg m²
torque = rigid.Torque.call(magnets, [1e5, 0.02])
orbit = 2.0 * np.pi / RATE
run = rigid.simulate(
    rigid.FreeBody(body, torque=torque),
    [0.1, 0.12, -0.09],
    t=np.linspace(0.0, 2.0 * orbit, 601),
    accuracy=1e-6,
    until=rigid.crosses("speed", 0.01, -1),
)
print(f"slow after {float(run.end) / orbit:.2f} orbits; estimated error {float(run.error):.0e}")
energy = run.energy()[run.t < run.end]
# sphinx_gallery_start_ignore
assert run.status == rigid.Status.STOPPED
assert (np.diff(energy) < 0.0).all()
# sphinx_gallery_end_ignore

figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
ax.semilogy(run.t / orbit, np.linalg.norm(run.omega, axis=1), color=HUES["blue"])
ax.set(xlabel="orbits", ylabel="angular velocity (rad/s)", title="A CubeSat slows down")
plt.show()

# %%
# The coils can never speed the satellite up: the power is :math:`-m\cdot(\omega\times B)`, and
# each component of :math:`m` has the sign of the component beside it. So the energy falls all the
# time. It falls slowly while the axis of rotation lies along the field.
#
# A map over the coils
# --------------------
#
# A function of the axes returns the scene. Each pixel is a largest moment and a first spin; its
# four satellites begin in random attitudes. ``fastest`` is a bound of the angular velocity, from
# which the map takes its steps. ``~rigid.spin_above(0.01)`` holds for a body that became slow.


def cubesat(moment):
    data = np.stack([np.full_like(moment, 1e5), moment], axis=-1)
    return rigid.FreeBody(body, torque=rigid.Torque.call(magnets, data, fastest=0.25))


result = rigid.stability_map(
    cubesat,
    axes={"moment": np.linspace(0.002, 0.024, 12), "spin": np.linspace(0.03, 0.19, 9)},
    start=rigid.Start(
        spin=0.1, axis=3, noise=rigid.normal(0.01), attitude_noise=rigid.uniform_attitude()
    ),
    stable=~rigid.spin_above(0.01),
    t_end=2.0 * orbit,
    time_unit=("orbit", orbit),
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
