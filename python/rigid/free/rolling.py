"""Free rotation as rolling: cones on each other, and Poinsot's ellipsoid on a plane."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import positive_int, require
from .._checks.arrays import AttitudeLike, Floats, attitudes, of_size_one, vectors
from .._checks.overflow import refuses_overflow
from ..model.body_like import BodyLike, moments_of
from ..rotations.apply import to_space
from .tops import symmetric_free_top


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cones:
    """The cones of a free symmetric top, which roll on each other along omega.

    Attributes
    ----------
    body_cone, space_cone : ndarray, shape (...)
        Half angles (rad) about the axis, fixed in the body, and about L, fixed in space.
    rolling : str, or ndarray of str of shape (...)
        ``"outside"``: the body cone of a prolate top rolls on the outside of the space cone;
        ``"inside"``: the body cone of an oblate top rolls with the space cone inside; ``"none"`` if
        omega, axis and L are parallel, omega is perpendicular to the axis, or the body is a sphere.
    body_curve : ndarray, shape (..., samples, 3)
        Unit vectors along omega in the body: one turn about the axis from the given omega.
    space_curve : ndarray, shape (..., samples, 3)
        Unit vectors along omega in space: one turn about L from the given omega.
    """

    body_cone: Floats
    space_cone: Floats
    rolling: str | NDArray[np.str_]
    body_curve: Floats
    space_curve: Floats


@refuses_overflow
def cones(
    body: BodyLike,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    samples: int = 181,
) -> Cones:
    """Body cone and space cone of a free symmetric top.

    In space omega moves around L on the space cone; in the body omega moves around the axis on the
    body cone: Goldstein, *Classical Mechanics*, § 5.6; Ercan 2016, § 9.2, where the names of the
    cones are exchanged (errata D-21, D-23).

    Parameters
    ----------
    body, omega
        As in :func:`rigid.free.symmetric_free_top`; omega must not be zero.
    attitude : array_like, shape (..., 4), or scipy Rotation, optional
        Attitude; by default body and space axes coincide.
    samples : int
        Number of points of each curve, at least 2; the first and the last point coincide.

    Returns
    -------
    Cones

    Raises
    ------
    ValueError
        As in :func:`rigid.free.symmetric_free_top`, and for a body at rest.

    Examples
    --------
    >>> from rigid import free
    >>> found = free.cones((1.0, 1.0, 1.6), [0.9, 0.0, 2.3])
    >>> str(found.rolling), round(float(found.space_cone), 12)
    ('inside', 0.133130652816)
    """
    top = symmetric_free_top(body, omega)
    moments, rates = np.broadcast_arrays(moments_of(body), vectors("omega", omega))
    rates, _ = of_size_one(rates)
    size = np.linalg.norm(rates, axis=-1, keepdims=True)
    require("|omega|", size[..., 0], size[..., 0] > 0.0, "a body at rest has no cones")
    start = attitudes(attitude)
    angle = np.linspace(0.0, 2.0 * pi, positive_int("samples", samples, minimum=2))
    axis = np.eye(3)[top.axis - 1]
    turn = np.where(top.k < 0.0, -1.0, 1.0)[..., np.newaxis] * angle
    unit = rates / size
    momentum = to_space(start, moments * rates)
    about = momentum / np.linalg.norm(momentum, axis=-1, keepdims=True)
    across = np.take_along_axis(moments, np.asarray(top.axis)[..., np.newaxis] % 3, axis=-1)
    along = np.take_along_axis(moments, np.asarray(top.axis)[..., np.newaxis] - 1, axis=-1)
    kinds = np.where(
        top.space_cone == 0.0, "none", np.where(along > across, "inside", "outside")[..., 0]
    )
    return Cones(
        body_cone=top.body_cone,
        space_cone=top.space_cone,
        rolling=kinds[()],
        body_curve=_around(axis, unit, turn),
        space_curve=_around(about, to_space(start, unit), angle),
    )


def _around(axis: Floats, vector: Floats, angle: Floats) -> Floats:
    """Vectors turned about unit axes by each of the angles (Rodrigues), shape (..., angles, 3)."""
    axis, vector = axis[..., np.newaxis, :], vector[..., np.newaxis, :]
    cosine, sine = np.cos(angle)[..., np.newaxis], np.sin(angle)[..., np.newaxis]
    along = axis * (axis * vector).sum(axis=-1, keepdims=True)
    turned: Floats = along + cosine * (vector - along) + sine * np.cross(axis, vector)
    return turned


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Poinsot:
    """Poinsot's construction: the inertia ellipsoid rolls on a plane that is fixed in space.

    Attributes that need the attitude are None if you do not pass it.

    Attributes
    ----------
    semi_axes : ndarray, shape (..., 3)
        Semi axes ``sqrt(2 E / I)`` of the ellipsoid ``y·I y = 2 E`` in the body (rad/s); inf along
        a thin rod, whose ellipsoid is a cylinder and touches the plane in a line (erratum G-16).
    distance : ndarray, shape (...)
        Distance ``2 E / |L|`` of the invariable plane ``x·L = 2 E`` from the centre (rad/s).
    polhode : ndarray, shape (..., m, 3)
        The point of contact in the body, which is omega (rad/s).
    normal : ndarray, shape (..., 3), or None
        Unit normal of the plane in space, along L.
    contact : ndarray, shape (..., m, 3), or None
        The point of contact in space (rad/s).
    herpolhode : ndarray, shape (..., m, 2), or None
        Coordinates of the contact in the plane, from the foot of the normal (rad/s). The first axis
        is the projection of the axis of space that is farthest from the normal.
    radius : ndarray, shape (..., m), or None
        Distance of the contact from the foot of the normal (rad/s).
    residual : ndarray, shape (..., m), or None
        Distance of the contact from the plane, relative to the distance of the plane.
    slip : ndarray, shape (...), or None
        Difference of the lengths of herpolhode and polhode, as polygons, relative to the distance
        of the plane. Because the ellipsoid rolls without slipping, the difference is of order 2 in
        the time between states.
    """

    semi_axes: Floats
    distance: Floats
    polhode: Floats
    normal: Floats | None
    contact: Floats | None
    herpolhode: Floats | None
    radius: Floats | None
    residual: Floats | None
    slip: Floats | None


@refuses_overflow
def poinsot(body: BodyLike, omega: ArrayLike, attitude: AttitudeLike | None = None) -> Poinsot:
    """Inertia ellipsoid, invariable plane, polhode and herpolhode of a free motion.

    Landau and Lifshitz, *Mechanics*, § 37; Goldstein, *Classical Mechanics*, § 5.6. The function
    takes energy and angular momentum from the first state.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (..., 3)
        The body, or principal moments (kg m²); one moment may be zero.
    omega : array_like, shape (..., m, 3)
        Angular velocity in the body at successive times (rad/s).
    attitude : array_like, shape (..., m, 4), or scipy Rotation, optional
        Attitudes at these times.

    Returns
    -------
    Poinsot

    Raises
    ------
    ValueError
        If there are no states, a body has no angular momentum, or a value is not finite.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> body = rigid.Body((1.0, 2.0, 2.5))
    >>> run = rigid.simulate(rigid.FreeBody(body), [1.1, 0.3, 0.4], t=np.linspace(0.0, 9.0, 91))
    >>> rolled = rigid.free.poinsot(body, run.omega, run.attitude)
    >>> round(float(rolled.distance), 11), bool(np.abs(rolled.residual).max() < 1e-14)
    (1.11657132218, True)
    """
    moments, rates = moments_of(body, rod=True), vectors("omega", omega)
    if rates.ndim < 2 or rates.shape[-2] == 0:
        raise ValueError(
            f"omega: expected the states of a motion, shape (..., m, 3) with m > 0, got "
            f"{rates.shape}"
        )
    rates, power = of_size_one(rates, (-2, -1))
    momentum = moments * rates[..., 0, :]
    size = np.linalg.norm(momentum, axis=-1)
    require("|L|", size, size > 0.0, "a body without angular momentum has no invariable plane")
    twice_energy = (momentum * rates[..., 0, :]).sum(axis=-1)
    distance = twice_energy / size
    with np.errstate(divide="ignore"):
        semi_axes = np.sqrt(twice_energy[..., np.newaxis] / moments)
    normal = contact = herpolhode = radius = residual = slip = None
    if attitude is not None:
        quaternions = attitudes(attitude)
        if quaternions.shape[:-1] != rates.shape[:-1]:
            raise ValueError(
                f"attitude: expected shape {(*rates.shape[:-1], 4)} to go with omega, "
                f"got {quaternions.shape}"
            )
        normal = to_space(quaternions[..., 0, :], momentum) / size[..., np.newaxis]
        contact = to_space(quaternions, rates)
        height = (contact * normal[..., np.newaxis, :]).sum(axis=-1)
        residual = height / distance[..., np.newaxis] - 1.0
        herpolhode = np.einsum("...mi,...ji->...mj", contact, _in_plane(normal))
        radius = np.linalg.norm(herpolhode, axis=-1)
        slip = (_length(contact) - _length(rates)) / distance
    of_one, of_all = power[..., 0, 0], power[..., 0]

    def back(scaled: Floats | None, powers: NDArray[np.intc]) -> Floats | None:
        return None if scaled is None else np.ldexp(scaled, powers)

    return Poinsot(
        semi_axes=np.ldexp(semi_axes, of_all),
        distance=np.ldexp(distance, of_one)[()],
        polhode=np.ldexp(rates, power),
        normal=normal,
        contact=back(contact, power),
        herpolhode=back(herpolhode, power),
        radius=back(radius, of_all),
        residual=residual,
        slip=slip,
    )


def _in_plane(normal: Floats) -> Floats:
    """Two unit vectors that complete each normal to a right-handed triad, shape (..., 2, 3)."""
    far = np.eye(3)[np.abs(normal).argmin(axis=-1)]
    first = far - normal * (far * normal).sum(axis=-1, keepdims=True)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normal, first)], axis=-2)


def _length(curve: Floats) -> Floats:
    steps: Floats = np.linalg.norm(np.diff(curve, axis=-2), axis=-1).sum(axis=-1)
    return steps
