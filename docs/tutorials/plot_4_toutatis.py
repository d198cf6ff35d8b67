r"""
A tumbling asteroid
===================

(4179) Toutatis turns about no fixed axis. Its two periods follow from its moments of inertia and
its rates on one day.

Radar showed in 1992 that Toutatis turns about its long axis in 5.41 days, while the long axis goes
round the angular momentum in 7.35 days on average (Hudson and Ostro, *Science* 270 (1995) 84).
From the flyby of Chang'e-2 Zhao and others found 5.38 ± 0.03 and 7.40 ± 0.03 days (IAU Symposium
318 (2016) 156).
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid

# %%
# Ratios of the moments and the rates of 9 November 1992, as Takahashi, Busch and Scheeres give
# them (*Astronomical Journal* 146 (2013) 95); axis 3 is the long one. The unit of time is the day.
asteroid = rigid.FreeBody(rigid.Body((3.0836, 3.235, 1.0)))
rates = np.radians([14.5, 33.7, -98.5])
run = rigid.simulate(asteroid, rates, t=np.linspace(0.0, 1500.0, 30001))

# %%
# The rotation: the angle of the angular momentum about the long axis, seen in the body.
momentum = run.omega * np.array(asteroid.body.moments)
turned = np.unwrap(np.arctan2(momentum[:, 1], momentum[:, 0]))
rotation = 2.0 * np.pi * run.t[-1] / abs(turned[-1] - turned[0])

# %%
# The precession: the angle of the long axis about the angular momentum, seen in space.
attitude = run.rotation()
pole = attitude[0].apply(momentum[0])
pole /= np.linalg.norm(pole)
across = np.cross(pole, [1.0, 0.0, 0.0])
across /= np.linalg.norm(across)
long_axis = attitude.apply([0.0, 0.0, 1.0])
carried = np.unwrap(np.arctan2(long_axis @ np.cross(pole, across), long_axis @ across))
precession = 2.0 * np.pi * run.t[-1] / abs(carried[-1] - carried[0])
print(f"rotation {rotation:.2f} d, precession {precession:.2f} d")
assert abs(rotation - 5.38) < 0.03
assert abs(precession - 7.40) < 0.03

# %%
# Both periods follow from the state of one day in closed form, without a run.
found = rigid.free.spin_periods(asteroid, rates)
print(f"rotation {found.rotation:.4f} d, precession {found.precession:.4f} d, {found.mode}")
assert abs(found.rotation - rotation) < 0.01
assert abs(found.precession - precession) < 0.01

# %%
# The periods differ from those of 1995 by half a percent: the rates of a day are known to about a
# degree a day. The tip of the long axis fills a band about the angular momentum and never comes
# back.
figure, ax = plt.subplots()
height = np.degrees(np.arccos(np.abs(long_axis @ pole)))
ax.plot(run.t[:1200], height[:1200], color="#0072b2")
ax.set(xlabel="t (days)", ylabel="angle of the long axis from L (degrees)", title="Toutatis nods")
plt.show()
