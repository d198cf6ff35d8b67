"""States of a run that a picture can show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from ..model.scene import Scene, scene_from_dict
from ..solve.run import Run
from ..solve.status import Status

__all__ = ["pair_of", "rates_of", "scene_of", "states_of"]

Floats = NDArray[np.float64]


def scene_of(run: object, body: int | None = None) -> Scene:
    """The scene of a run, of one body of many; TypeError if the run is none."""
    if not isinstance(run, Run):
        raise TypeError(f"run = {brief(run)}: must be a rigid.Run, which rigid.simulate returns")
    scene = scene_from_dict(run.spec["scene"])
    if not scene.shape:
        return scene
    return scene[0 if len(scene) == 1 else body or 0]


def states_of(run: Run, body: int | None = None) -> tuple[Floats, Floats]:
    """Angular velocities (m, 3) and attitudes (m, 4) of one body of a run, in principal axes.

    The states end where an event of ``until`` ended the body.
    """
    if run.frame is not None:
        run = run.in_frame(None)
    if run.attitude is None:
        raise ValueError(
            f"record = {run.spec['record']!r}: record = 'attitude' is needed to show the motion"
        )
    index = _index_of(run, body)
    omega, attitude = run.omega[index], run.attitude[index]
    if run.status[index] == Status.STOPPED:
        known = int(np.isfinite(omega).all(axis=-1).cumprod().sum())
        omega, attitude = omega[:known], attitude[:known]
    if not (np.isfinite(omega).all() and np.isfinite(attitude).all()):
        raise ValueError("status: states that are not finite cannot be shown")
    return omega, attitude


def pair_of(run: object) -> tuple[int | None, ...]:
    """The bodies that a film shows if none is asked for: both of two, else the only one."""
    if isinstance(run, Run) and run.omega.ndim == 3 and len(run.omega) == 2:
        return (0, 1)
    return (None,)


def rates_of(run: Run, body: int | None = None) -> Floats:
    """Angular velocities (m, 3) of one body of a run, in principal axes."""
    if run.frame is not None:
        run = run.in_frame(None)
    omega: Floats = run.omega[_index_of(run, body)]
    if not np.isfinite(omega).all():
        raise ValueError("status: states that are not finite cannot be shown")
    return omega


def _index_of(run: Run, body: int | None) -> tuple[int, ...]:
    """The index of one body of a run: empty if the run has a single one."""
    omega = run.omega
    if run.t.ndim > 1:
        raise ValueError(f"t of shape {run.t.shape}: needs times that all bodies share, (m,)")
    if omega.ndim > 3:
        raise ValueError(f"omega of shape {omega.shape}: needs one axis of bodies, (n, m, 3)")
    if omega.ndim < 3:
        if body is not None:
            raise ValueError(f"body = {body}: the run has a single body")
        return ()
    bodies = len(omega)
    if body is None and bodies != 1:
        raise ValueError(f"body = None: the run has {bodies} bodies, choose one by its index")
    index = 0 if body is None else body
    if isinstance(index, bool) or not isinstance(index, (int, np.integer)):
        raise TypeError(f"body = {brief(body)}: must be a whole number")
    if not -bodies <= index < bodies:
        raise ValueError(f"body = {brief(body)}: the run has {bodies} bodies")
    return (int(index),)
