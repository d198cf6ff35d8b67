"""When an upright top sleeps
==========================

An upright top stays upright if its cubic f is negative beside ``u = 1``. Below the least spin
``2 sqrt(mgl I1) / I3`` it is positive there (blue), and the top falls as far as that reaches. The
usual approximation ``(1 - u)² (2 alpha - a²)`` vanishes exactly at the least spin and cannot tell;
f itself is ``-alpha (1 - u)³`` there, and the top sleeps.
"""

import matplotlib.pyplot as plt

import rigid
from rigid import figures

top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
figure, axes = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
figures.upright_cubic(top, axes=axes)

plt.show()
