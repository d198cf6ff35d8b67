"""The path of a body in space: its centre of mass under a force, its rotation about it.

The names of this module are also those of :mod:`rigid.particles`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import shaped, sorted_times, together
from .bodies import Body
from .scenes import FreeBody
from .simulate import Run, simulate

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["BodyPath", "propagate_body"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyPath:
    """The six coordinates of a body. With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    position, velocity : ndarray, shape (n, m, 3)
        Centre of mass (m) and its velocity (m/s), in space.
    rotation : Run
        Rates, attitude and how exact they are, of :func:`rigid.simulate`.
    """

    t: Floats
    position: Floats
    velocity: Floats
    rotation: Run


def propagate_body(
    body: Body | FreeBody,
    position: ArrayLike,
    velocity: ArrayLike,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    force: ArrayLike = (0.0, 0.0, 0.0),
    t: ArrayLike,
) -> BodyPath:
    """Path of a thrown body: the centre of mass under a force through it, and the rotation.

    ``F = dP/dt`` moves the centre of mass, ``N = dL/dt`` with ``N = 0`` turns the body about it
    (Ercan 2016, § 2, eqs. (38)–(40)). Without torque the angular momentum is constant, the rotation
    in general is not (erratum D-02). A constant force gives the parabola, no force the straight
    line, without an error of method; of sampled forces the cubic spline is integrated twice (needs
    SciPy; the error falls with the fourth power of their spacing). The rotation is that of
    :func:`rigid.simulate`, by closed form.

    Parameters
    ----------
    body : Body or FreeBody
        The body; a force needs its mass. Its moments are about the centre of mass.
    position, velocity : array_like, shape (3,) or (n, 3)
        Centre of mass (m) and its velocity (m/s) at ``t = 0``.
    omega, attitude : array_like
        Rates and attitude at ``t = 0``, as in :func:`rigid.simulate`.
    force : array_like, shape (3,), (m, 3) or (n, m, 3)
        Force (N) in space, through the centre of mass: constant, or sampled at the times. An axis
        of length one instead of ``m`` is a constant, too.
    t : array_like, shape (m,)
        Wanted times (s), ascending; strictly, and on both sides of ``t = 0`` or from there, for
        sampled forces.

    Returns
    -------
    BodyPath

    Raises
    ------
    ValueError
        If there is a force and no mass, or an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> import rigid
    >>> from rigid import particles
    >>> racket = rigid.Body((1.0, 2.0, 2.5), mass=0.3)
    >>> weight = [0.0, 0.0, -9.81 * racket.mass]
    >>> path = particles.propagate_body(
    ...     racket, [0, 0, 1], [2, 0, 5], [0, 10, 0.01], force=weight, t=[0.0, 1.0]
    ... )
    >>> path.position[-1].round(9).tolist()
    [2.0, 0.0, 1.095]
    """
    if isinstance(body, FreeBody):
        body = body.body
    if not isinstance(body, Body):
        raise TypeError(f"body = {body!r}: must be a rigid.Body or a rigid.FreeBody")
    times = sorted_times("t", t)
    r0, v0 = shaped("position", position, 3), shaped("velocity", velocity, 3)
    f = shaped("force", force, 3)
    if body.mass is None and f.any():
        raise ValueError("body: its mass is None; a force moves a body of known mass")
    impulse, shift = _impulse_and_shift(f, times)
    run = simulate(FreeBody(body), omega, attitude, t=times)
    mass = 1.0 if body.mass is None else body.mass
    r0, v0, impulse, shift, _ = together(
        position=r0[..., np.newaxis, :],
        velocity=v0[..., np.newaxis, :],
        force=impulse,
        shift=shift,
        omega=run.omega,
    )
    return BodyPath(
        t=times,
        position=r0 + v0 * times[:, np.newaxis] + shift / mass,
        velocity=v0 + impulse / mass,
        rotation=run,
    )


def _impulse_and_shift(force: Floats, times: Floats) -> tuple[Floats, Floats]:
    """First and second integral of the force from ``t = 0``, shape (..., m, 3)."""
    rows = force.shape[-2] if force.ndim > 1 else 1
    t = times[:, np.newaxis]
    if rows == 1:
        return force * t, force * (0.5 * t * t)
    if rows != len(times) or rows == 0:
        raise ValueError(
            f"force: expected shape (3,) or (..., {len(times)}, 3), a row for each of the times, "
            f"got {force.shape}"
        )
    if (np.diff(times) <= 0.0).any() or times[0] > 0.0 or times[-1] < 0.0:
        raise ValueError(
            f"t = {times[0]:g} ... {times[-1]:g}: times of sampled forces must be strictly "
            "ascending and reach or pass t = 0, where the path starts"
        )
    from scipy.interpolate import CubicSpline

    once = CubicSpline(times, force, axis=-2).antiderivative()
    twice = once.antiderivative()
    impulse, shift = once(times) - once([0.0]), twice(times) - twice([0.0]) - once([0.0]) * t
    return impulse, shift
