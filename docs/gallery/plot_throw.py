"""A box thrown about each of its axes
===================================

A box of 1 cm by 8 cm by 25 cm, turning at 1 rad/s: exactly about an axis it goes on for ever; with
0.05 rad/s of noise on every component the rotation about the middle axis turns over, again and
again. The dots are the growth rate of a disturbance if the rates stood still. They say what happens
at the start; later they are positive on lasting motions too.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures, free

thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
figure, axes = plt.subplots(2, 3, figsize=(11, 6), layout="constrained")
figures.throw(thrown, axes=axes)

plt.show()
