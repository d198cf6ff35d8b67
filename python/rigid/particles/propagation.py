"""The path of a body in space: the centre of mass under a force, and the rotation of the body.

Import the names of this module from :mod:`rigid.particles`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import shaped, sorted_times, together
from ..model.body import Body, require_one
from ..model.scene import FreeBody
from ..solve.run import Run
from ..solve.simulate import simulate

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyPath:
    """Position, velocity and rotation of thrown bodies over time.

    Arrays of a single body lack the leading axis ``n``.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    position, velocity : ndarray, shape (n, m, 3)
        Centre of mass (m) and its velocity (m/s), in space.
    rotation : Run
        Angular velocities and attitudes with their errors, from :func:`rigid.simulate`.
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

    The centre of mass obeys ``F = dP/dt``, the rotation obeys ``N = dL/dt`` (Ercan 2016, § 2, eqs.
    (38)–(40)). Without torque the angular momentum is constant, but the angular velocity in general
    is not (erratum D-02). The path is exact for a constant force. For sampled forces the function
    integrates their cubic spline twice, which needs SciPy; the error falls with the fourth power of
    the spacing. :func:`rigid.simulate` gives the rotation.

    Parameters
    ----------
    body : Body or FreeBody
        The body, with moments about the centre of mass; it must have a mass if there is a force.
        The torques of a :class:`rigid.FreeBody` turn the body. An orbit is refused, because it
        moves the centre of mass in another way.
    position, velocity : array_like, shape (3,) or (n, 3)
        Centre of mass (m) and its velocity (m/s) at ``t = 0``.
    omega, attitude : array_like
        Angular velocity and attitude at ``t = 0``, as in :func:`rigid.simulate`.
    force : array_like, shape (3,), (m, 3) or (n, m, 3)
        Force (N) in space, through the centre of mass: constant, or sampled at the times. An axis
        of length one instead of ``m`` means a constant force.
    t : array_like, shape (m,)
        Times (s), ascending. For sampled forces the times must be strictly ascending and must
        contain or enclose ``t = 0``.

    Returns
    -------
    BodyPath

    Raises
    ------
    ValueError
        If there is a force but the body has no mass, the body is on an orbit, or an argument is not
        finite or has the wrong shape.

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
    scene = body if isinstance(body, FreeBody) else FreeBody(body)
    require_one(body)
    if scene.orbit is not None:
        raise ValueError(
            f"body = {scene.words()}: position, velocity and force move its centre of mass; "
            "rigid.simulate gives the rotation on an orbit"
        )
    mass = scene.body.mass
    times = sorted_times("t", t)
    r0, v0 = shaped("position", position, 3), shaped("velocity", velocity, 3)
    f = shaped("force", force, 3)
    if mass is None and f.any():
        raise ValueError("body: its mass is None; give the body a mass, or no force")
    impulse, shift = _impulse_and_shift(f, times)
    run = simulate(scene, omega, attitude, t=times)
    mass = 1.0 if mass is None else mass
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
