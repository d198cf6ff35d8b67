r"""How deviation vectors grow
==========================

Above: the logarithm :math:`\Lambda(t)` of the size of a small deviation vector for five motions,
and three formulas (dotted). On a sphere, with a deviation along its spin, :math:`\Lambda` is
:math:`\frac12\ln(1+|\omega|^2t^2)`. For a regular top :math:`\Lambda` stays near a logarithm.
Beside the separatrix of a free body it grows like :math:`\lambda t` until the body has turned over,
and then shrinks again, turn after turn. For a chaotic top :math:`\Lambda` grows for ever. It does
so too for a top upright at rest, by :math:`\lambda = \sqrt{mgl/\min(I_1, I_2)}`, although nothing
is chaotic there.

Below: MEGNO of a regular top oscillates about 2 for ever, but its mean settles. The verdict uses
the mean.

How to: :doc:`measure how motions part </chaos>`.
"""

import matplotlib.pyplot as plt
import numpy as np

import rigid
from rigid.drawing.colours import HUES

SPHERE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)))
FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
UPRIGHT = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=0.1)
LEANING = [0.9, 0.3, 0.2, 0.1]

t = np.linspace(0.25, 200.0, 800)
along = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
motions = {
    "sphere": rigid.lyapunov(SPHERE, [0.0, 0.0, 1.0], t=t, start=along, of="attitude"),
    "regular top": rigid.lyapunov(TOP, [0.1, 0.0, 4.0], LEANING, t=t),
    "beside a separatrix": rigid.lyapunov(FREE, [1e-6, 0.5, 0.0], t=t),
    "chaotic top": rigid.lyapunov(TOP, [0.3, 0.4, 1.0], LEANING, t=t),
    "upright at rest": rigid.lyapunov(UPRIGHT, [0.0, 0.0, 0.0], t=t),
}

figure, (above, below) = plt.subplots(2, 1, figsize=(8, 9), layout="constrained")
inks = ("sky", "blue", "green", "vermilion", "purple")
dashes = ("solid", "dashed", "dashdot", "solid", (0, (6, 1)))
for (name, growth), ink, dash in zip(motions.items(), inks, dashes, strict=True):
    above.plot(t, growth.log_growth, color=HUES[ink], linestyle=dash, label=name)
leaves = 0.5 * np.sqrt((2.0 - 1.0) * (3.0 - 2.0) / (1.0 * 3.0))
for law in (0.5 * np.log(1.0 + t**2), leaves * t, np.sqrt(0.1 / 1.0) * t):
    (line,) = above.plot(t, law, "k:", linewidth=1.2)
line.set_label("laws")
above.set(xlabel="$t$ (s)", ylabel=r"$\Lambda$, logarithm of the size", ylim=(-2.0, 22.0))
above.legend(loc="upper right")

late = np.linspace(0.1, 100.0, 2000)
regular = rigid.lyapunov(TOP, [0.1, 0.0, 4.0], LEANING, t=late)
below.plot(late, regular.megno, color=HUES["vermilion"], linewidth=0.8, label="MEGNO")
below.plot(late, regular.mean_megno, color=HUES["blue"], linewidth=2.0, label="mean MEGNO")
below.axhline(2.0, color="k", linestyle=":", linewidth=1.2, zorder=0)
below.set(xlabel="$t$ (s)", ylabel="MEGNO of a regular top", ylim=(-1.5, 3.5))
below.legend()

plt.show()
