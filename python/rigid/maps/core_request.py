"""The request of a map to the core: the one list of its inputs, which the core reads by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import Floats
from ..model.criterion import Condition


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoreStarts:
    """Nominal starts of pixels and the distributions of their perturbations.

    Attributes
    ----------
    omega, attitude : ndarray, shapes (P, 3), (P, 4)
        Rates (rad/s); quaternions (w, x, y, z).
    omega_noise, attitude_noise : str
        Names of the distributions.
    omega_size, attitude_size : ndarray, shape (P, 3)
        Sizes of the perturbations (rad/s; rad).
    mix : ndarray, shape (6, 6), optional
        Factor of the covariance of rates and attitude.
    mixed : pair of bool
        Which of the two it makes.
    given_omega, given_attitude, given_shares : ndarray, shapes (n, 3), (n, 4), (n,), optional
        Perturbations that are given one by one, and their cumulative shares.
    """

    omega: Floats
    omega_noise: str
    omega_size: Floats
    attitude: Floats
    attitude_noise: str
    attitude_size: Floats
    mix: Floats | None = None
    mixed: tuple[bool, bool] = (False, False)
    given_omega: Floats | None = None
    given_attitude: Floats | None = None
    given_shares: Floats | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoreRequest:
    """A map of one horizon and one limit.

    Attributes
    ----------
    scene, method : str
    moments, weight : ndarray, shape (P, 3)
        Principal moments (kg m²); ``mgl * com`` (N m).
    physical : bool
        Whether a body must be able to have the moments.
    starts : sequence of CoreStarts
        One start, or the starts of a mixture.
    shares : sequence of float
        The share of the samples that begin so or as a start before; the last is 1.
    conditions : sequence of (str, int, sequence of float)
        Name, axis and numbers of each condition.
    logic : str
        How they are joined: their numbers, and the operations after their operands.
    measures : sequence of (str, int, tuple of float)
        Name, axis and numbers of each measure.
    t_end : float
    step : float or None
    max_steps, samples, seed : int
    checked : int or None
        Samples with smaller numbers are classified twice; None: the doubtful.
    forces : Forces, optional
        Those on the pixels, or those on all.
    numbers, first : ndarray of uint64, shape (P,), optional
        The number of each pixel in the whole map, and the number of its first sample, a multiple of
        64 unless there is one sample of each.
    """

    scene: str
    method: str
    moments: Floats
    physical: bool = True
    weight: Floats
    starts: Sequence[CoreStarts]
    shares: Sequence[float] = (1.0,)
    conditions: Sequence[tuple[str, int, Sequence[float]]]
    logic: str
    measures: Sequence[Condition]
    t_end: float
    step: float | None
    max_steps: int
    samples: int
    checked: int | None
    seed: int
    forces: _core.Forces | None = None
    numbers: NDArray[np.uint64] | None = None
    first: NDArray[np.uint64] | None = None
