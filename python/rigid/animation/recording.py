"""What a film shows: the motion of one body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """The motion of one body at some times, in principal axes.

    Attributes
    ----------
    scene : Scene
        The scene of the body alone.
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (m, 3)
        Angular velocities in the body (rad/s).
    attitude : ndarray, shape (m, 4)
        Attitudes.
    frame : ndarray, shape (3, 3), or None
        The axes of a mesh of the body, as :attr:`rigid.Run.frame`; None: the principal axes.
    flip : float
        The time (s) at which a free body first turns over.
    flips : int
        How many times the body turns over; 0 if it is not free.
    """

    scene: Scene
    t: NDArray[np.float64]
    omega: NDArray[np.float64]
    attitude: NDArray[np.float64]
    frame: NDArray[np.float64] | None
    flip: float
    flips: int
