"""Sensitivity: how much a motion magnifies a small change of its start, whatever the method."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import resolve_threads, sorted_times
from .._checks.arrays import AttitudeLike, Floats
from ..model.body import Body
from ..model.scene import Scene, check_scene
from .bodies import Bodies, bodies_of
from .methods import TO_ROUNDING
from .request import Request
from .tangent import ROUNDING, tangent_matrices


def condition(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike,
    threads: int | None = None,
) -> Floats:
    """Factor by which a motion magnifies the worst small change of its start.

    The largest singular value of the derivative of the state with respect to the start, with rates
    in units of ``sqrt(|omega|² + mgl / I_min)`` and attitudes in rad. The factor is a
    property of the motion, not of a method: an error of 1e-16 in the start, the size of rounding,
    becomes ``1e-16 condition`` with every method. It grows like ``t`` on regular motions and
    exponentially on chaotic ones and near a separatrix.

    The derivative is the tangent of the motion (see :attr:`Run.tangent`), integrated by
    ``taylor16``. Its relative error is about ``1e-16 condition``, as for the motion: of a factor
    above 1e16 only the size is known.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
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
        1 at ``t = 0``. Infinite beyond the range of doubles; NaN for a body whose motion overflows.

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
    scene = check_scene(scene, many=True)
    bodies = bodies_of(scene, omega, attitude)
    factors = amplification(bodies, sorted_times("t", t), resolve_threads(threads))
    return factors.reshape(*bodies.shape, factors.shape[1])


def amplification(bodies: Bodies, times: Floats, threads: int) -> Floats:
    """The condition of some bodies at these times, shape (n, m)."""
    matrices = tangent_matrices(
        Request(
            bodies=bodies,
            times=times,
            method=TO_ROUNDING,
            record="rates",
            max_steps=10**9,
            threads=threads,
            tolerance=ROUNDING,
        )
    )
    scale = _core.rate_units(bodies)[:, None, None, None]
    matrices[..., :3, 3:] /= scale
    matrices[..., 3:, :3] *= scale
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    lost = np.where(np.isnan(matrices).any(axis=(-2, -1)), np.nan, np.inf)
    matrices[~finite] = 0.0
    return np.where(finite, np.linalg.norm(matrices, 2, axis=(-2, -1)), lost)
