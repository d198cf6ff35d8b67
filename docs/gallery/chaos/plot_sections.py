r"""Poincaré sections of regular and of chaotic tops
================================================

Poincaré sections of four tops at the energy 1.5 J: every point at which the centre of mass of a
motion is highest, forty motions each. Lagrange's, Kovalevskaya's and Goryachev's and Chaplygin's
top with :math:`\mathbf{L}\cdot\gamma = 0` are integrable, so the points of each motion lie on a
curve; the colours only tell the motions apart. The last top is the third one with
:math:`\mathbf{L}\cdot\gamma = 1.5` kg m²/s: most of its motions wander through one chaotic sea
(blue), around islands of regular motions (yellow), by the verdicts of :func:`rigid.lyapunov`.

How to: :doc:`compute a section </chaos>`.
"""

import matplotlib.pyplot as plt

import rigid

LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
KOVALEVSKAYA = rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
GORYACHEV = rigid.HeavyTop(rigid.Body((4.0, 4.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))

PANELS = (
    ("Lagrange, $\\mathbf{L}\\cdot\\gamma = 0.5$ kg m²/s", LAGRANGE, 0.5, "gamma1", "gamma2"),
    (
        "Kovalevskaya, $\\mathbf{L}\\cdot\\gamma = 0.5$ kg m²/s",
        KOVALEVSKAYA,
        0.5,
        "gamma2",
        "omega3",
    ),
    ("Goryachev–Chaplygin, $\\mathbf{L}\\cdot\\gamma = 0$", GORYACHEV, 0.0, "gamma2", "omega3"),
    ("the same, $\\mathbf{L}\\cdot\\gamma = 1.5$ kg m²/s", GORYACHEV, 1.5, "gamma2", "omega3"),
)

figure, axes = plt.subplots(2, 2, figsize=(10, 9), layout="constrained")
for ax, (title, top, momentum, x, y) in zip(axes.flat, PANELS, strict=True):
    omega, attitude = rigid.top.on_surface(top, 1.5, momentum, count=40, rng=2026)
    points = rigid.poincare(top, omega, attitude, t_end=1e5, count=400, check=False)
    verdict = rigid.lyapunov(top, omega, attitude, t=[1000.0, 2000.0], check=False).verdict
    points.plot(x, y, ax=ax, by=verdict if "chaotic" in verdict else None)
    ax.set_title(title)

plt.show()
