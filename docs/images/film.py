"""Write the film of the README: ``python docs/images/film.py``."""

from pathlib import Path

import numpy as np

import rigid

box = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
run = rigid.simulate(box, [[0.01, 10.0, 0.0], [1e-6, 10.0, 0.0]], t=np.linspace(0.0, 2.6, 261))
run.animate(Path(__file__).with_name("two-throws.webp"), speed=0.3, size=280, fps=10)
