"""What can be shown of a run or a scene, and what not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .scenes import Scene

if TYPE_CHECKING:
    from .simulate import Run

__all__ = ["states_of", "undriven"]

Floats = NDArray[np.float64]


def states_of(run: Run, body: int | None = None) -> tuple[Floats, Floats]:
    """Rates (m, 3) and attitudes (m, 4) of the body that is shown."""
    if run.attitude is None:
        raise ValueError(
            f"record = {run.spec['record']!r}: record = 'attitude' is needed to show the motion"
        )
    omega, attitude = run.omega, run.attitude
    if omega.ndim == 3:
        bodies = len(omega)
        if body is None and bodies != 1:
            raise ValueError(f"body = None: the run has {bodies} bodies, choose one by its index")
        index = 0 if body is None else body
        if isinstance(index, bool) or not isinstance(index, (int, np.integer)):
            raise TypeError(f"body = {body!r}: must be a whole number")
        if not -bodies <= index < bodies:
            raise ValueError(f"body = {body}: the run has {bodies} bodies")
        omega, attitude = omega[index], attitude[index]
    elif body is not None:
        raise ValueError(f"body = {body}: the run has a single body")
    if not (np.isfinite(omega).all() and np.isfinite(attitude).all()):
        raise ValueError("status: states that are not finite cannot be shown")
    return omega, attitude


def undriven(scene: Scene, what: str) -> None:
    """Raise under torque or damping, which change the constants that a picture is made of."""
    if scene.outside is not None:
        raise ValueError(f"{what}: needs a scene without torque and damping")
