"""Energy and angular momentum of states at output times.

Sums are written out: products of matrices by a BLAS have other bits on other machines.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats
from ..model.batch import Shape, in_rows
from ..model.scene import Scene

_BLOCK = 2**14
"""States of a block, whose intermediate results stay in the cache."""


def needs_vertical(scene: Scene) -> bool:
    """Whether the energy of a scene depends on the vertical."""
    return bool(scene.weight.any())


def energy_of(
    scene: Scene, shape: Shape, omega: NDArray[Any], gamma: NDArray[Any] | None
) -> Floats:
    """Kinetic and potential energy (J) of bodies of this shape in rows, shape (n, m).

    Parameters
    ----------
    scene : Scene
    shape : tuple of int
    omega : ndarray, shape (n, m, 3)
        Along principal axes.
    gamma : ndarray, shape (n, m, 3), or None
        The vertical; not needed without weight.
    """
    moments = in_rows(np.asarray(scene.body.moments), shape)[:, np.newaxis]
    weight = in_rows(scene.weight, shape)[:, np.newaxis]
    weighs = needs_vertical(scene)
    energy = np.empty(omega.shape[:-1])
    rows = max(1, _BLOCK // max(1, omega.shape[1]))
    for first in range(0, len(omega), rows):
        some = slice(first, first + rows)
        i, w = (one[some] if len(one) > 1 else one for one in (moments, weight))
        rates = omega[some]
        twice = i * rates * rates
        energy[some] = 0.5 * (twice[..., 0] + twice[..., 1] + twice[..., 2])
        if weighs:
            assert gamma is not None
            parts = w * gamma[some]
            energy[some] += parts[..., 0] + parts[..., 1] + parts[..., 2]
    return energy


def momentum_of(scene: Scene, shape: Shape, omega: NDArray[Any], t: Floats) -> Floats:
    """Angular momentum (kg m²/s) along principal axes, rotors included, shape (n, m, 3)."""
    momentum: Floats = in_rows(np.asarray(scene.body.moments), shape)[:, np.newaxis] * omega
    if scene.rotor is not None:
        rotor = scene.momentum_of_rotor(t if t.ndim == 1 else t.reshape(*shape, -1))
        if rotor.ndim > 2:
            last = rotor.shape[-2:]
            rotor = np.broadcast_to(rotor, (*shape, *last)).reshape(-1, *last)
        momentum += rotor
    return momentum
