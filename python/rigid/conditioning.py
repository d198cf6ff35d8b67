"""How much a motion magnifies a small change of its start: the physics, apart from the solver."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import resolve_threads, sorted_times
from .belief import around
from .columns import check_scene, columns, each_row, fastest_rates
from .grid import pixels, tables
from .mapspec import MapSpec, core_job
from .methods import EXACT, SECOND, angle_per_step
from .quaternions import quaternion_product
from .scenes import Scene

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["condition", "growth", "over_map"]

Floats = NDArray[np.float64]

DIFFERENCE = 1e-11
"""Size of the changes of the start, relative and in rad.

Rounding shows in the fifth digit of their growth, as it is magnified like them."""

WAYPOINTS = 65
"""Times at which neighbours are compared, beside those asked for."""

BENT = 0.1
"""Second differences above this share of the first: neighbours so far apart say nothing."""


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
    in units of ``sqrt(|omega|² + mgl / I_min)`` and attitudes in rad. It belongs to the
    motion, not to a solver: an error of 1e-16 in the start, which rounding alone leaves, has become
    ``1e-16 condition`` whatever the method. It grows like ``t`` on regular motions and
    exponentially on chaotic ones and near a separatrix.

    The derivative is that of six pairs of neighbours, one for each component of the rates and of
    the attitude, by closed form where all have one, else by ``taylor16``. They are 1e-11 apart at
    the start, so four digits are right, and what grows by more than some 1e10 is infinite.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body and what acts on it.
    omega : array_like, shape (3,) or (n, 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitude at ``t = 0``. Default: body and space axes coincide.
    t : array_like, shape (m,)
        Times (s), ascending.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

    Returns
    -------
    ndarray, shape (n, m), or (m,) of a single body
        At least 1 at ``t = 0``, where it is 1. NaN for a body whose motion overflows.

    Raises
    ------
    ValueError
        As :func:`rigid.simulate`.

    Notes
    -----
    The linearised flow is what chaos indicators are made of (Skokos & Gerlach, Phys. Rev. E 82
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
    check_scene(scene)
    table, single = columns(scene, omega, attitude)
    factors = growth(table, sorted_times("t", t), resolve_threads(threads))
    return factors[0] if single else factors


def growth(table: Mapping[str, Any], times: Floats, threads: int) -> Floats:
    """The condition of the bodies of a table at these times, shape (n, m)."""
    # On the way too: neighbours that have parted may meet again.
    way = np.union1d(times, np.linspace(*around(times), WAYPOINTS))
    factors = _on_the_way(table, way, threads)
    for side in (way >= 0.0, way <= 0.0):
        outward = np.flatnonzero(side)[np.argsort(np.abs(way[side]), kind="stable")]
        parted = np.logical_or.accumulate(np.isinf(factors[:, outward]), axis=1)
        factors[:, outward] = np.where(parted, np.inf, factors[:, outward])
    found: Floats = factors[:, np.searchsorted(way, times)]
    return found


@np.errstate(all="ignore")
def _on_the_way(table: Mapping[str, Any], times: Floats, threads: int) -> Floats:
    """The same at each time by itself."""
    count = len(table["omega"])
    weight = np.linalg.norm(table["weight"], axis=1) / table["moments"].min(axis=1)
    scale = np.sqrt(np.sum(table["omega"] ** 2, axis=1) + weight)
    scale = np.where(scale > 0.0, scale, 1.0)
    neighbours = _neighbours(table, scale)
    exact = "outside" not in table and "" not in np.array(
        _core.closed_forms(**each_row(neighbours)), dtype=np.str_
    )
    states = _core.simulate(
        **neighbours,
        method=EXACT if exact else SECOND,
        record="attitude",
        # One step for a body and all its neighbours: they then share its truncation.
        step=None if exact else np.repeat(_steps(table, times), 13),
        max_steps=10**9,
        threads=threads,
        times=times.tolist(),
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


def over_map(spec: MapSpec, samples: int, threads: int) -> Floats:
    """The median condition of the first samples of each pixel at the horizon of a map."""
    rows, job = pixels(spec.scene, spec.start, spec.axes), core_job(spec)
    possible = np.flatnonzero(job.status == 0)
    drawn = [job.sample(int(pixel), sample) for pixel in possible for sample in range(samples)]
    of_pixel = np.repeat(possible, samples)
    omega = np.array([body["omega"] for body in drawn]).reshape(-1, 3)
    attitude = np.array([body["attitude"] for body in drawn]).reshape(-1, 4)
    factors = np.empty(len(drawn))
    for mine, table in tables(spec.scene, rows, of_pixel, omega, attitude):
        factors[mine] = growth(table, np.array([spec.t_end]), threads)[:, 0]
    layer = np.full(spec.shape, np.nan)
    layer.flat[possible] = np.median(factors.reshape(-1, samples), axis=1)
    return layer


def _steps(table: Mapping[str, Any], times: Floats) -> Floats:
    """Steps that are half as long as those of the method itself."""
    return 0.5 * angle_per_step(SECOND) / fastest_rates(table, around(times), SECOND)


def _neighbours(table: Mapping[str, Any], scale: Floats) -> dict[str, Any]:
    """Each body, then six of its neighbours on one side and six on the other."""
    count = len(table["omega"])
    several = {
        name: np.repeat(values, 13, axis=0)
        if isinstance(values, np.ndarray) and len(values) == count
        else values
        for name, values in table.items()
    }
    six = np.vstack([np.eye(6), -np.eye(6)]) * DIFFERENCE
    change = np.tile(np.vstack([np.zeros(6), six]), (count, 1))
    omega = several["omega"] + change[:, :3] * np.repeat(scale, 13)[:, None]
    turn = np.concatenate([np.ones((len(change), 1)), 0.5 * change[:, 3:]], axis=1)
    attitude = quaternion_product(several["attitude"], turn)
    return {
        **several,
        "omega": np.ascontiguousarray(omega),
        "attitude": np.ascontiguousarray(attitude),
    }
