"""A box thrown about each of its axes
===================================

A box of 1 cm by 8 cm by 25 cm rotates at 1 rad/s. Exactly about a principal axis the rotation
continues for ever. With noise of 0.05 rad/s on every component, the rotation about the middle axis
flips again and again. The dots are the growth rate of a perturbation if the rates were constant.
They describe the beginning of the motion only; later they are positive on stable motions too.

How to: :doc:`throw a box of your own </quickstart>`.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures, free

thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
figure, axes = plt.subplots(2, 3, figsize=(11, 6), layout="constrained")
figures.throw(thrown).plot(axes)

plt.show()
