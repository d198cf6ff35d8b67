"""Sensitivity: how much a motion magnifies a small change of its start, whatever the solver."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import resolve_threads, sorted_times
from ..model.scene import Scene, check_scene
from .arrays import time_range
from .batch import Batch
from .methods import EXACT, SECOND

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "amplification",
    "condition",
]

Floats = NDArray[np.float64]

DIFFERENCE = 1e-11
"""Size of the changes of the start, relative and in rad.

Rounding shows in the fifth digit of their growth, as it is magnified like them."""

WAYPOINTS = 65
"""Times at which neighbours are compared, besides the requested ones."""

BENT = 0.1
"""Largest ratio of second to first differences at which a derivative is accepted."""


def condition(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike,
    threads: int | None = None,
) -> Floats:
    """Factor by which a motion magnifies the worst small change of its start.

    The largest singular value of the derivative of the state with respect to the start, with rates
    in units of ``sqrt(|omega|² + mgl / I_min)`` and attitudes in rad. The factor is a
    property of the motion, not of a solver: an error of 1e-16 in the start, the size of rounding,
    becomes ``1e-16 condition`` with every method. It grows like ``t`` on regular motions and
    exponentially on chaotic ones and near a separatrix.

    The derivative is that of six pairs of neighbours, one for each component of the rates and of
    the attitude, by closed form where all have one, else by ``taylor16``. They are 1e-11 apart at
    the start, so four digits are right, and what grows by more than some 1e10 is infinite.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body, or many, with their weight, applied torque and damping.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``. Default: body and space axes coincide.
    t : array_like, shape (m,)
        Times (s), ascending.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

    Returns
    -------
    ndarray, shape (..., m), or (m,) of a single body
        At least 1 at ``t = 0``, where it is 1. NaN for a body whose motion overflows.

    Raises
    ------
    ValueError
        As :func:`rigid.simulate`.

    Notes
    -----
    Chaos indicators are functions of the linearised flow (Skokos & Gerlach, Phys. Rev. E 82
    (2010) 036704, doi 10.1103/PhysRevE.82.036704); its largest singular value bounds them all.

    Examples
    --------
    >>> import rigid
    >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> stable = rigid.condition(box, [1.0, 1e-3, 1e-3], t=[10.0])
    >>> tumbling = rigid.condition(box, [1e-3, 1.0, 1e-3], t=[10.0])
    >>> print(f"{stable[0]:.0f} {tumbling[0]:.0f}")
    10 490
    """
    check_scene(scene, many=True)
    batch, shape = Batch.from_input(scene, omega, attitude)
    factors = amplification(batch, sorted_times("t", t), resolve_threads(threads))
    return factors.reshape(*shape, factors.shape[1])


def amplification(batch: Batch, times: Floats, threads: int) -> Floats:
    """The condition of some bodies at these times, shape (n, m)."""
    # Between the times too: neighbours that have parted may meet again.
    every = np.union1d(times, np.linspace(*time_range(times), WAYPOINTS))
    factors = _factors(batch, every, threads)
    for side in (every >= 0.0, every <= 0.0):
        outward = np.flatnonzero(side)[np.argsort(np.abs(every[side]), kind="stable")]
        parted = np.logical_or.accumulate(np.isinf(factors[:, outward]), axis=1)
        factors[:, outward] = np.where(parted, np.inf, factors[:, outward])
    found: Floats = factors[:, np.searchsorted(every, times)]
    return found


@np.errstate(all="ignore")
def _factors(batch: Batch, times: Floats, threads: int) -> Floats:
    """The condition at each time, independent of other times; infinite if neighbours diverged."""
    from ..rotations.quaternions import quaternion_product  # loads a module of the textbook

    count = len(batch)
    weight = np.linalg.norm(batch.weight, axis=1) / batch.moments.min(axis=1)
    scale = np.sqrt(np.sum(batch.omega**2, axis=1) + weight)
    scale = np.where(scale > 0.0, scale, 1.0)
    neighbours = _neighbours(batch, scale)
    exact = batch.forcing is None and "" not in neighbours.closed_forms()
    states = _core.simulate(
        **neighbours.columns(),
        method=EXACT if exact else SECOND,
        record="attitude",
        # One step for a body and all its neighbours: they then share its truncation.
        step=None if exact else np.repeat(_steps(batch, times), 13),
        max_steps=10**9,
        threads=threads,
        times=times[np.newaxis],
    )
    omega = states["omega"].reshape(count, 13, len(times), 3) / scale[:, None, None, None]
    attitude = states["attitude"].reshape(count, 13, len(times), 4)
    known = np.isfinite(omega).all(axis=(1, 3)) & np.isfinite(attitude).all(axis=(1, 3))
    attitude = np.where(known[:, None, :, None], attitude, [1.0, 0.0, 0.0, 0.0])
    turn = quaternion_product(attitude[:, :1] * [1.0, -1.0, -1.0, -1.0], attitude)
    angle = 2.0 * turn[..., 1:] * np.copysign(1.0, turn[..., :1])
    # Body, time, component, change.
    away = np.concatenate([omega - omega[:, :1], angle], axis=-1).transpose(0, 2, 3, 1)
    forward, back = away[..., 1:7], away[..., 7:]
    first, second = forward - back, forward + back
    first[~known] = 0.0
    factors = np.linalg.norm(first, 2, axis=(-2, -1)) / (2.0 * DIFFERENCE)
    size = np.abs(first).max(axis=(-2, -1))
    bent = (np.abs(second).max(axis=(-2, -1)) > BENT * size) | (size > BENT)
    found: Floats = np.where(known, np.where(bent, np.inf, factors), np.nan)
    return found


def _steps(batch: Batch, times: Floats) -> Floats:
    """Steps half as long as the default steps of the method."""
    rates = batch.fastest_rates(time_range(times), SECOND)
    return 0.5 * _core.default_steps(SECOND, rates)


def _neighbours(batch: Batch, scale: Floats) -> Batch:
    """Each body, then six of its neighbours on one side and six on the other."""
    from ..rotations.quaternions import quaternion_product  # loads a module of the textbook

    six = np.vstack([np.eye(6), -np.eye(6)]) * DIFFERENCE
    change = np.tile(np.vstack([np.zeros(6), six]), (len(batch), 1))
    turn = np.concatenate([np.ones((len(change), 1)), 0.5 * change[:, 3:]], axis=1)
    several = batch.repeat(13)
    return replace(
        several,
        omega=several.omega + change[:, :3] * np.repeat(scale, 13)[:, None],
        attitude=np.ascontiguousarray(quaternion_product(several.attitude, turn)),
    )
