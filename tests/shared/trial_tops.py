"""Heavy symmetric tops that several tests try, and their constants and Euler rates."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import rigid
from physics import Floats, present, rotation_matrix, tilted
from rigid import top

SIXTY = np.pi / 3
#: The top of the worked cases.
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
#: Body and start on which the printed formulas were tried: tilt, precession, nutation and spin.
I1, I3, MGL = 1.3, 0.7, 2.1
OTHER = rigid.HeavyTop(rigid.Body((I1, I1, I3)), mgl=MGL)
TILT, PUSH, NOD, SPIN = 0.9, 0.25, 0.35, 5.0


def state(tilt: float, push: float, nod: float, spin: float) -> tuple[list[float], Floats]:
    """Rates and attitude with phi = psi = 0."""
    return [nod, push * np.sin(tilt), spin], tilted(tilt)


def four(scene: rigid.HeavyTop, omega: ArrayLike, attitude: ArrayLike) -> dict[str, Any]:
    found = top.heavy_constants(scene, omega, attitude)
    return {name: getattr(found, name) for name in ("a", "b", "alpha", "beta")}


def euler(scene: rigid.HeavyTop, start: Any, t: ArrayLike) -> tuple[Floats, ...]:
    """Tilt and the three Euler rates along the path, from the rates and the attitude."""
    run = rigid.simulate(scene, *start, t=t)
    matrix = rotation_matrix(present(run.attitude))
    theta = np.arccos(matrix[:, 2, 2])
    psi = np.arctan2(matrix[:, 2, 0], matrix[:, 2, 1])
    w1, w2, w3 = run.omega.T
    precession = (w1 * np.sin(psi) + w2 * np.cos(psi)) / np.sin(theta)
    return theta, precession, w1 * np.cos(psi) - w2 * np.sin(psi), w3 - precession * np.cos(theta)


def random_tops(count: int, random: np.random.Generator) -> tuple[Floats, Floats]:
    tilt = random.uniform(0.05, 3.09, count)
    push, nod = 3.0 * random.normal(size=count), 2.0 * random.normal(size=count)
    spin = np.abs(4.0 * random.normal(size=count)) + 0.01
    omega = np.stack([nod, push * np.sin(tilt), spin], axis=-1)
    zero = np.zeros(count)
    return omega, np.stack([np.cos(tilt / 2), np.sin(tilt / 2), zero, zero], axis=-1)
