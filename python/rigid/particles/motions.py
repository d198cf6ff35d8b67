"""Motions of a rigid body: displacements, screws, fields of velocities, and the path of a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import shaped, sorted_times, together, vectors_together
from .._checks.arrays import Floats, of_size_one
from .._checks.matrices import rotation_matrices
from .._checks.overflow import refuses_overflow
from ..model.body import Body, require_one
from ..model.scene import FreeBody
from ..solve.run import Run
from ..solve.simulate import simulate

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

SMALL = 1e-9
"""Relative size that counts as zero: extent of the points, misfit, orthogonality error."""

NARROW = 1e-6
"""Least width of a system of points, relative to its length, that determines a turn about it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Displacement:
    """A turn and a shift, ``b = rotation a + translation``.

    Attributes
    ----------
    rotation : ndarray, shape (..., 3, 3)
        Proper rotation, active.
    translation : ndarray, shape (..., 3)
        Shift (m) of the point of the body that was at the origin.
    residual : ndarray, shape (...)
        Weighted root mean square of ``|b - rotation a - translation|`` (m).
    determined : ndarray of bool, shape (...)
        Whether the points determine the rotation. False if the points lie within a millionth of
        their length from a line: the turn about this line is then arbitrary, and ``rotation`` is
        one of many that fit.
    """

    rotation: Floats
    translation: Floats
    residual: Floats
    determined: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Screw:
    """A displacement as a turn about an axis and a shift along it.

    Attributes
    ----------
    axis : ndarray, shape (..., 3)
        Unit vector of the axis, right-handed for the angle; the direction of the shift if the angle
        is zero; zero if angle and shift are zero.
    point : ndarray, shape (..., 3)
        The point of the axis that is nearest to the origin (m); the origin if the angle is zero,
        because then any line along ``axis`` is an axis.
    angle : ndarray, shape (...)
        Angle (rad) in [0, pi]. At pi the sign of the axis is arbitrary.
    advance : ndarray, shape (...)
        Shift along the axis (m).
    """

    axis: Floats
    point: Floats
    angle: Floats
    advance: Floats

    @property
    def pitch(self) -> Floats:
        """Shift along the axis per angle (m/rad); inf without a turn, 0 without turn and shift."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.where(self.advance == 0.0, 0.0, self.advance / self.angle)[()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OmegaFit:
    """The rigid motion that fits the velocities of points best.

    Attributes
    ----------
    omega : ndarray, shape (..., 3)
        Angular velocity (rad/s); it does not depend on the base. Components that the points do not
        determine are zero.
    velocity : ndarray, shape (..., 3)
        Velocity (m/s) of the point of the body at ``base``.
    base : ndarray, shape (..., 3)
        The base point (m).
    residual : ndarray, shape (...)
        Root mean square of the residual velocities (m/s).
    rank : ndarray of int, shape (...)
        Number of components of ``omega`` that the points determine: 3; 2 if the points lie on a
        line, because a rotation about this line does not move them; 0 if the points coincide.
    """

    omega: Floats
    velocity: Floats
    base: Floats
    residual: Floats
    rank: NDArray[np.intp]


@refuses_overflow
def rigid_motion(
    before: ArrayLike, after: ArrayLike, weights: ArrayLike | None = None
) -> Displacement:
    """The rotation and the translation that take one set of points to another.

    Every displacement of a rigid body is a rotation and a translation (Euler, Chasles; Goldstein,
    *Classical Mechanics*, § 4.6; Ercan 2016, § 1). If the points are not exactly rigid, the result
    is the weighted least-squares fit (Kabsch, *Acta Cryst.* A32 (1976) 922).

    Parameters
    ----------
    before, after : array_like, shape (..., N, 3)
        Positions (m) of the points before and after the displacement, in the same order.
    weights : array_like, shape (..., N), optional
        Weights, >= 0, for instance masses. Default: equal.

    Returns
    -------
    Displacement

    Raises
    ------
    ValueError
        If the numbers of points differ, a weight is negative, all weights are zero, or ``after`` is
        a mirror image of ``before``: a reflection fits at least twice as well as any rotation.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import particles
    >>> corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> turned = particles.rigid_motion(corner, corner[:, [2, 0, 1]] + [5, 0, 0])
    >>> np.allclose(turned.rotation, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    True
    >>> np.allclose(turned.translation, [5, 0, 0])
    True
    """
    a = shaped("before", before, None, 3)
    b = shaped("after", after, None, 3)
    w = np.ones(a.shape[-2]) if weights is None else shaped("weights", weights, None)
    if not a.shape[-2] == b.shape[-2] == w.shape[-1] > 0:
        raise ValueError(
            f"before {a.shape}, after {b.shape}, weights {w.shape}: must have as many points each"
        )
    if (w < 0.0).any() or (w.sum(axis=-1) <= 0.0).any():
        raise ValueError("weights: must not be negative, and not all be zero")
    a, b, w = together(before=a, after=b, weights=w[..., np.newaxis])
    w = w / w.sum(axis=-2, keepdims=True)
    mean_a, mean_b = (w * a).sum(axis=-2), (w * b).sum(axis=-2)
    own_a, own_b = a - mean_a[..., np.newaxis, :], b - mean_b[..., np.newaxis, :]

    left, extent, right = np.linalg.svd(np.swapaxes(w * own_b, -1, -2) @ own_a)
    handed = np.where(np.linalg.det(left) * np.linalg.det(right) < 0.0, -1.0, 1.0)
    mirror = np.ones_like(extent)
    mirror[..., 2] = handed
    rotation = (left * mirror[..., np.newaxis, :]) @ right

    def residual(matrix: Floats) -> Floats:
        left_over = own_b - own_a @ np.swapaxes(matrix, -1, -2)
        return np.asarray(np.sqrt((w * left_over * left_over).sum(axis=(-2, -1))))

    proper, best = residual(rotation), residual(left @ right)
    size = np.sqrt((w * own_b * own_b).sum(axis=(-2, -1)))
    mirrored = proper > 2.0 * best + SMALL * size
    if mirrored.any():
        index = tuple(int(i) for i in np.argwhere(mirrored)[0])
        raise ValueError(
            f"after: a mirror image of before; no rotation comes nearer than {proper[index]:g}, a "
            f"reflection than {best[index]:g}"
        )
    return Displacement(
        rotation=rotation,
        translation=mean_b - (rotation @ mean_a[..., np.newaxis])[..., 0],
        residual=proper[()],
        # A turn about the longest direction moves points along the other two; extents are squares.
        determined=extent[..., 1] + handed * extent[..., 2] > NARROW**2 * extent[..., 0],
    )


@refuses_overflow
def screw(rotation: ArrayLike, translation: ArrayLike) -> Screw:
    """The screw axis of a displacement, the angle about this axis and the shift along this axis.

    Chasles' (Mozzi's) theorem: with ``t`` the translation perpendicular to the axis ``n``, the axis
    passes through ``(t + cot(angle / 2) n × t) / 2`` (Goldstein, *Classical Mechanics*, § 4.6;
    Ercan 2016, § 1). The function needs SciPy.

    Parameters
    ----------
    rotation : array_like, shape (..., 3, 3)
        Rotation, active.
    translation : array_like, shape (..., 3)
        Shift (m) of the point of the body that was at the origin.

    Returns
    -------
    Screw

    Raises
    ------
    ValueError
        If a matrix is not a rotation to 3.1e-4; within, the nearest rotation is taken.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import particles
    >>> quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    >>> turn = particles.screw(quarter, [1, 1, 3])
    >>> np.allclose(turn.axis, [0, 0, 1]), np.allclose(turn.point, [0, 1, 0]), float(turn.advance)
    (True, True, 3.0)
    """
    from scipy.spatial.transform import Rotation

    matrix = rotation_matrices("rotation", rotation)
    shift = shaped("translation", translation, 3)
    vector = Rotation.from_matrix(matrix.reshape(-1, 3, 3)).as_rotvec().reshape(matrix.shape[:-1])
    vector, shift = together(rotation=vector, translation=shift)
    shift, power = of_size_one(shift)
    angle, distance = (np.linalg.norm(of, axis=-1)[..., np.newaxis] for of in (vector, shift))
    axis = np.divide(shift, distance, out=np.zeros(shift.shape), where=distance > 0.0)
    np.divide(vector, angle, out=axis, where=angle > 0.0)
    advance = (axis * shift).sum(axis=-1, keepdims=True)
    across = shift - advance * axis
    with np.errstate(divide="ignore", invalid="ignore"):
        point = 0.5 * (across + np.cross(axis, across) / np.tan(0.5 * angle))
    return Screw(
        axis=axis,
        point=np.ldexp(np.where(angle > 0.0, point, 0.0), power),
        angle=angle[..., 0],
        advance=np.ldexp(advance, power)[..., 0],
    )


@refuses_overflow
def velocity_field(
    omega: ArrayLike,
    points: ArrayLike,
    *,
    velocity: ArrayLike = (0.0, 0.0, 0.0),
    base: ArrayLike = (0.0, 0.0, 0.0),
) -> Floats:
    """Velocities of the points of a rigid body: ``v = V + omega × (r - base)``.

    Landau and Lifshitz, *Mechanics*, § 31; Ercan 2016, eq. (21), where the arm must begin at the
    base (erratum D-11). Another base point with its own velocity gives the same velocity field.

    Parameters
    ----------
    omega : array_like, shape (..., 3)
        Angular velocity (rad/s), along the same axes as the other vectors.
    points : array_like, shape (..., 3)
        Positions (m); broadcast with the other arguments.
    velocity : array_like, shape (..., 3)
        Velocity (m/s) of the base. Default: zero, the body turns about the base.
    base : array_like, shape (..., 3)
        The base point (m). Default: the origin.

    Returns
    -------
    ndarray, shape (..., 3)
        Velocities (m/s).

    Raises
    ------
    ValueError
        If an argument is not finite or has the wrong shape.

    Examples
    --------
    >>> from rigid import particles
    >>> particles.velocity_field([0, 0, 2], [[1, 0, 0], [0, 3, 0]], velocity=[0, 0, 1]).tolist()
    [[0.0, 2.0, 1.0], [-6.0, 0.0, 1.0]]
    """
    w, r, v, r0 = vectors_together(omega=omega, points=points, velocity=velocity, base=base)
    return np.asarray(v + np.cross(w, r - r0))


@refuses_overflow
def fit_omega(
    points: ArrayLike, velocities: ArrayLike, *, base: ArrayLike | None = None
) -> OmegaFit:
    """The angular velocity of a rigid body from the velocities of its points.

    Least-squares solution of ``v = V + omega × (r - base)``. The angular velocity of a rigid body
    is the same for every base (Ercan 2016, theorem 1, eq. (21)); it is unique if two arms are not
    parallel (erratum D-11).

    Parameters
    ----------
    points, velocities : array_like, shape (..., N, 3)
        Positions (m) and velocities (m/s) of the points.
    base : array_like, shape (..., 3), optional
        The point (m) whose velocity is returned. Default: the mean of the points.

    Returns
    -------
    OmegaFit

    Raises
    ------
    ValueError
        If there are no points, the shapes do not match, or an argument is not finite.

    Examples
    --------
    >>> from rigid import particles
    >>> rim, speeds = [[1, 0, 0], [0, 1, 0], [-1, 0, 0]], [[5, 2, 0], [3, 0, 0], [5, -2, 0]]
    >>> wheel = particles.fit_omega(rim, speeds)
    >>> wheel.omega.round(9).tolist(), int(wheel.rank)
    ([0.0, 0.0, 2.0], 3)
    """
    r = shaped("points", points, None, 3)
    v = shaped("velocities", velocities, None, 3)
    if r.shape[-2] != v.shape[-2] or r.shape[-2] == 0:
        raise ValueError(f"points {r.shape}, velocities {v.shape}: must have as many points each")
    r, v = together(points=r, velocities=v)
    count = r.shape[-2]
    centre, drift = r.mean(axis=-2), v.mean(axis=-2)
    arms, own = r - centre[..., np.newaxis, :], v - drift[..., np.newaxis, :]
    # omega × r = -hat(r) omega, one 3×3 block a point.
    blocks = np.swapaxes(np.cross(np.eye(3), arms[..., np.newaxis, :]), -1, -2)
    left, extent, right = np.linalg.svd(
        blocks.reshape(*r.shape[:-2], 3 * count, 3), full_matrices=False
    )
    seen = extent > SMALL * extent[..., :1]
    inverse = np.divide(1.0, extent, out=np.zeros_like(extent), where=seen)
    flat = own.reshape(*r.shape[:-2], 3 * count, 1)
    modes = inverse[..., np.newaxis] * (np.swapaxes(left, -1, -2) @ flat)
    omega = (np.swapaxes(right, -1, -2) @ modes)[..., 0]
    left_over = own - np.cross(omega[..., np.newaxis, :], arms)
    at = centre if base is None else shaped("base", base, 3)
    at, centre, drift, turning = together(base=at, points=centre, velocities=drift, omega=omega)
    return OmegaFit(
        omega=omega,
        velocity=drift + np.cross(turning, at - centre),
        base=np.array(at),
        residual=np.sqrt((left_over * left_over).sum(axis=(-2, -1)) / count)[()],
        rank=seen.sum(axis=-1),
    )


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
    return once(times) - once([0.0]), twice(times) - twice([0.0]) - once([0.0]) * t
