"""The free symmetric top: where omega, L and the axis are, and the cones that roll."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._check import finite_float, vector
from .._given import BodyLike, moments_of
from ..free import cones as cones_of
from ..free import symmetric_free_top
from ..quaternions import matrix_to_quaternion, quaternion_to_matrix
from ..so3 import rotate
from . import colours
from ._draw import (
    arc,
    arrow,
    arrow_in_plane,
    curve,
    fit,
    in_space,
    label,
    label_in_plane,
    panels,
)

__all__ = [
    "ConesArtists",
    "CoplanarVectors",
    "CoplanarVectorsArtists",
    "FreeTopOmega",
    "FreeTopOmegaArtists",
    "RollingCones",
    "cones",
    "cones_data",
    "coplanar_vectors",
    "coplanar_vectors_data",
    "free_top_omega",
    "free_top_omega_data",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeTopOmega:
    """The angular velocity of a free symmetric top, seen from the body.

    Attributes
    ----------
    axis : ndarray, shape (3,)
        Unit vector along the axis of symmetry.
    k : float
        Rate at which omega turns about it (rad/s).
    amplitude : float
        ``A``, the part of omega across the axis (rad/s).
    angle : float
        ``k t`` (rad).
    path : ndarray, shape (m, 3)
        omega over one period, closed (rad/s); constant for ``k = 0``.
    start, now : ndarray, shape (3,)
        omega at time 0 and at the time ``t`` (rad/s).
    """

    axis: Floats
    k: float
    amplitude: float
    angle: float
    path: Floats
    start: Floats
    now: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeTopOmegaArtists:
    """What :func:`free_top_omega` has drawn.

    Attributes
    ----------
    ax : Axes3D
        Where.
    data : FreeTopOmega
        What.
    start, now, amplitude : SpaceArrow
        omega at both times, and its part across the axis; an arrow has its ``start`` and its
        ``vector``.
    path, projection : Line3D
        The circle of omega, and that of its part across the axis.
    """

    ax: Any
    data: FreeTopOmega
    start: Any
    now: Any
    amplitude: Any
    path: Any
    projection: Any


def free_top_omega_data(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121
) -> FreeTopOmega:
    """Vectors under :func:`free_top_omega`.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them equal to the bit.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s), not zero.
    t : float
        Time (s).
    samples : int
        Points of the path.

    Returns
    -------
    FreeTopOmega

    Raises
    ------
    ValueError
        If the top is not symmetric, does not turn, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.free_top_omega_data((1.0, 1.0, 1.6), [0.9, 0.0, 2.3], t=1.0)
    >>> round(data.angle, 12), data.amplitude
    (1.38, 0.9)
    """
    rates = _turning(omega)
    time = finite_float("t", t)
    period = float(symmetric_free_top(body, rates).period)
    whole = np.linspace(0.0, period if np.isfinite(period) else 0.0, samples)
    path, now = (symmetric_free_top(body, rates, t=times) for times in (whole, [time]))
    assert path.omega is not None
    assert now.omega is not None
    return FreeTopOmega(
        axis=np.eye(3)[int(path.axis) - 1],
        k=float(path.k),
        amplitude=float(path.amplitude),
        angle=float(path.k) * time,
        path=path.omega,
        start=rates,
        now=now.omega[0],
    )


def free_top_omega(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, ax: Any | None = None
) -> FreeTopOmegaArtists:
    """Draw how omega turns about the axis of a free symmetric top, seen from the body.

    Its part along the axis stays, that across it turns by ``k t`` on a circle of radius ``A``: one
    way for an oblate top, the other for a prolate one (Ercan 2016, fig. 10, eqs. (43)-(45)).

    Parameters
    ----------
    body, omega, t
        As in :func:`free_top_omega_data`.
    ax : Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    FreeTopOmegaArtists

    Raises
    ------
    ValueError
        As in :func:`free_top_omega_data`, and if the axes are not three-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.free_top_omega((1.0, 1.0, 1.6), [0.9, 0.0, 1.3], t=0.9)
    >>> drawn.ax.figure.savefig("omega.png")  # doctest: +SKIP
    """
    data = free_top_omega_data(body, omega, t=t)
    ax = in_space(ax)
    size = float(np.linalg.norm(data.start))
    purple, black = colours.OMEGA.colour, colours.HUES["black"]
    along = (data.start @ data.axis) * data.axis
    reach = np.maximum(1.3 * data.amplitude, 0.6 * size) * np.ones(3)
    which = int(data.axis.argmax())
    reach[which] = 1.25 * size
    for axis, ink in enumerate(colours.AXES):
        arrow(ax, reach[axis] * np.eye(3)[axis], ink.colour, ink.label, linewidth=1.4)
    path = curve(ax, data.path, purple, linewidth=1.4)
    shadow = data.path - along
    projection = curve(ax, shadow, colours.FAINT, linewidth=1.4)
    _tips(ax, data.path, purple)
    drop = np.array([data.now, data.now - along])
    curve(ax, drop, colours.FAINT, linewidth=1.0, linestyle="dashed")
    # The vector at time 0 only where it is not the one at time t.
    start = arrow(ax, data.start, purple, linewidth=1.2, linestyle="dashed", alpha=0.7)
    now = arrow(ax, data.now, purple, r"$\boldsymbol{\omega}(t)$", linewidth=2.4)
    amplitude = arrow(ax, data.now - along, black, "$A$", linewidth=1.8)
    curve(ax, np.array([np.zeros(3), data.start - along]), black, linewidth=0.9, linestyle="dashed")
    if data.amplitude > 0.0:
        first = 0.5 * (data.start - along)
        arc(ax, data.axis, first, data.angle, black, "$k\\,t$", beyond=1.5)
        centre = np.array([data.now, along])
        curve(ax, centre, colours.FAINT, linewidth=1.0, linestyle="dashed")
    name = r"$\omega_" + str(which + 1) + "$"
    aside = np.roll(np.array([0.0, -0.14 * size, 0.0]), which - 2)
    label(ax, along + aside, name, colours.AXES[which].colour)
    fit(ax, data.path, shadow, np.diag(reach), np.zeros(3), elev=20.0, azim=35.0)
    return FreeTopOmegaArtists(
        ax=ax,
        data=data,
        start=start,
        now=now,
        amplitude=amplitude,
        path=path,
        projection=projection,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoplanarVectors:
    """L, omega and the axis of a free symmetric top, in the plane in which all three lie.

    Attributes
    ----------
    along, across : float
        Moments about the axis of symmetry and across it, ``I3`` and ``I`` (kg m²).
    omega, momentum : ndarray, shape (2,)
        Parts across and along the axis, of omega (rad/s) and of L (kg m²/s).
    alpha, theta : float
        Angles of omega and of L from the axis (rad).
    """

    along: float
    across: float
    omega: Floats
    momentum: Floats
    alpha: float
    theta: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoplanarVectorsArtists:
    """What :func:`coplanar_vectors` has drawn, a panel for each body.

    Attributes
    ----------
    axes : tuple of Axes
        The panels.
    data : tuple of CoplanarVectors
        What.
    omega, momentum : tuple of PlaneArrow
        omega, and L scaled to a length that can be compared; an arrow has its ``start`` and its
        ``vector``.
    """

    axes: tuple[Any, ...]
    data: tuple[CoplanarVectors, ...]
    omega: tuple[Any, ...]
    momentum: tuple[Any, ...]


def coplanar_vectors_data(body: BodyLike, omega: ArrayLike) -> CoplanarVectors:
    """Vectors under a panel of :func:`coplanar_vectors`.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them equal to the bit.
    omega : array_like, shape (3,)
        Angular velocity in the body (rad/s), not zero.

    Returns
    -------
    CoplanarVectors

    Raises
    ------
    ValueError
        If the top is not symmetric, does not turn, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.coplanar_vectors_data((1.0, 1.0, 1.6), [0.9, 0.0, 2.3])
    >>> data.theta < data.alpha  # oblate
    True
    """
    rates = _turning(omega)
    top = symmetric_free_top(body, rates)
    moments, which = moments_of(body), int(top.axis) - 1
    across, along = float(moments[which - 2]), float(moments[which])
    flat = np.array([float(top.amplitude), rates[which]])
    return CoplanarVectors(
        along=along,
        across=across,
        omega=flat,
        momentum=np.array([across, along]) * flat,
        alpha=float(top.alpha),
        theta=float(top.theta),
    )


def coplanar_vectors(
    bodies: Sequence[BodyLike], omega: ArrayLike, *, axes: Sequence[Any] | None = None
) -> CoplanarVectorsArtists:
    """Draw L, omega and the axis of free symmetric tops in their common plane.

    ``tan theta = (I / I3) tan alpha``: L lies between the axis and omega if the top is oblate, and
    omega between the axis and L if it is prolate (Ercan 2016, figs. 11a, b, eqs. (47), (48)).

    Parameters
    ----------
    bodies : sequence of Body, FreeBody or array_like, shape (3,)
        One for each panel, for instance an oblate and a prolate one.
    omega : array_like, shape (3,)
        Angular velocity in the body (rad/s), the same for all.
    axes : sequence of Axes, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    CoplanarVectorsArtists

    Raises
    ------
    ValueError
        As in :func:`coplanar_vectors_data`, and if there are no bodies or not as many axes.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.coplanar_vectors([(1, 1, 1.6), (1, 1, 0.55)], [0.9, 0.0, 1.3])
    >>> drawn.axes[0].figure.savefig("coplanar.png")  # doctest: +SKIP
    """
    if len(bodies) == 0:
        raise ValueError("bodies: expected at least one, got none")
    data = tuple(coplanar_vectors_data(body, omega) for body in bodies)
    found = panels(axes, ["plane"] * len(data))
    drawn = [_draw_coplanar(ax, one) for ax, one in zip(found, data, strict=True)]
    return CoplanarVectorsArtists(
        axes=tuple(found),
        data=data,
        omega=tuple(one for one, _ in drawn),
        momentum=tuple(one for _, one in drawn),
    )


def _draw_coplanar(ax: Any, data: CoplanarVectors) -> tuple[Any, Any]:
    size = float(np.linalg.norm(data.omega))
    longer = 1.25 * size
    arrow_in_plane(ax, np.array([0.0, longer]), colours.Z.colour, "axis", linewidth=1.6)
    spin = arrow_in_plane(ax, data.omega, colours.OMEGA.colour, colours.OMEGA.label, linewidth=2.4)
    shown = longer * data.momentum / np.linalg.norm(data.momentum)
    momentum = arrow_in_plane(ax, shown, colours.L.colour, colours.L.label, linewidth=2.4)
    for angle, radius, text in ((data.alpha, 0.62, r"$\alpha$"), (data.theta, 0.4, r"$\theta$")):
        turn = np.linspace(0.0, angle, 49)[:, np.newaxis]
        points = radius * size * np.hstack([np.sin(turn), np.cos(turn)])
        curve(ax, points, colours.ANGLE.colour)
        label_in_plane(ax, points[24] * (1.0 + 0.06 / radius), text)
    kind = "oblate: $I_3 > I$" if data.along > data.across else "prolate: $I_3 < I$"
    sign = "<" if data.theta < data.alpha else ">"
    if data.along == data.across:
        kind, sign = "spherical: $I_3 = I$", "="
    ax.set_title(rf"{kind},  $\theta {sign} \alpha$", fontsize="medium", y=0.95)
    low = -0.08 if data.omega[1] >= 0.0 else -1.42
    ax.set_aspect("equal")
    ax.set(xlim=(-0.25 * size, 1.3 * size), ylim=(low * size, 1.55 * size))
    ax.set_axis_off()
    return spin, momentum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RollingCones:
    """The cones of a free symmetric top at one time, in space with L upwards.

    Attributes
    ----------
    body_cone, space_cone : float
        Half angles (rad).
    rolling : str
        ``"outside"`` for a prolate top, ``"inside"`` for an oblate one, whose body cone goes around
        the space cone.
    omega, momentum, axis : ndarray, shape (3,)
        omega (rad/s), L (kg m²/s) and the unit vector along the axis, towards the spin.
    body_rim, space_rim : ndarray, shape (m, 3)
        The circles that omega describes in the body and in space (rad/s), both in space components.
        The first is carried by the body; both begin with omega at time 0.
    """

    body_cone: float
    space_cone: float
    rolling: str
    omega: Floats
    momentum: Floats
    axis: Floats
    body_rim: Floats
    space_rim: Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConesArtists:
    """What :func:`cones` has drawn.

    Attributes
    ----------
    ax : Axes3D
        Where.
    data : RollingCones
        What.
    body_cone, space_cone : Poly3DCollection
        The surfaces.
    body_rim, space_rim : Line3D
        Their rims.
    omega, momentum, axis : SpaceArrow
        omega, and L and the axis at lengths that can be compared; an arrow has its ``start`` and
        its ``vector``.
    """

    ax: Any
    data: RollingCones
    body_cone: Any
    space_cone: Any
    body_rim: Any
    space_rim: Any
    omega: Any
    momentum: Any
    axis: Any


def cones_data(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121
) -> RollingCones:
    """Cones under :func:`cones`: those of :func:`rigid.free.cones`, where they are at a time.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them equal to the bit.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s).
    t : float
        Time (s).
    samples : int
        Points of a rim.

    Returns
    -------
    RollingCones

    Raises
    ------
    ValueError
        If the top is not symmetric, or omega, L and the axis are one line or omega and L are one,
        so that nothing rolls, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.cones_data((1.0, 1.0, 0.55), [0.9, 0.0, 2.3], t=1.0)
    >>> data.rolling, round(data.space_cone, 9)
    ('outside', 0.245389808)
    """
    rates = _turning(omega)
    time = finite_float("t", t)
    start = _upright(moments_of(body) * rates)
    found = cones_of(body, rates, start, samples=samples)
    if str(found.rolling) == "none":
        raise ValueError(
            f"omega = {rates.tolist()}: nothing rolls where omega and L are one line, which is so "
            "along and across the axis and for a sphere"
        )
    top = symmetric_free_top(body, rates, start, t=[time])
    assert top.omega is not None
    assert top.attitude is not None
    turn = quaternion_to_matrix(top.attitude[0])
    size = float(top.rate)
    which = int(top.axis) - 1
    return RollingCones(
        body_cone=float(found.body_cone),
        space_cone=float(found.space_cone),
        rolling=str(found.rolling),
        omega=turn @ top.omega[0],
        momentum=turn @ (moments_of(body) * top.omega[0]),
        axis=np.copysign(1.0, rates[which]) * turn[:, which],
        body_rim=size * found.body_curve @ turn.T,
        space_rim=size * found.space_curve,
    )


def cones(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, ax: Any | None = None
) -> ConesArtists:
    """Draw the body cone of a free symmetric top as it rolls on the space cone.

    They touch along omega, where the body is at rest for the moment. The space cone has the half
    angle ``|alpha - theta|`` about L, the body cone alpha about the axis (Ercan 2016, figs. 12a, b,
    errata D-21 to D-23). Frames of an animation are pictures at successive times ``t``.

    Parameters
    ----------
    body, omega, t
        As in :func:`cones_data`.
    ax : Axes3D, optional
        Where to draw; by default on a new figure that pyplot does not know.

    Returns
    -------
    ConesArtists

    Raises
    ------
    ValueError
        As in :func:`cones_data`, and if the axes are not three-dimensional.
    ImportError
        Without matplotlib.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.cones((1.0, 1.0, 0.55), [0.9, 0.0, 1.3])
    >>> drawn.ax.figure.savefig("cones.png")  # doctest: +SKIP
    """
    data = cones_data(body, omega, t=t)
    ax = in_space(ax)
    surfaces, rims = [], []
    for rim, ink, alpha in (
        (data.space_rim, colours.SPACE, 0.35),
        (data.body_rim, colours.BODY, 0.25),
    ):
        sheet = np.array([0.0, 1.0])[:, np.newaxis, np.newaxis] * rim
        surfaces.append(
            ax.plot_surface(
                *np.moveaxis(sheet, -1, 0),
                color=ink.colour,
                alpha=alpha,
                linewidth=0.0,
                rcount=2,
                ccount=len(rim),
                shade=False,
                zorder=1,
            )
        )
        rims.append(curve(ax, rim, ink.colour, linewidth=1.8, zorder=2))
    # Generators that the body carries show how far it has turned.
    for end in data.body_rim[:-1:10]:
        curve(ax, np.array([np.zeros(3), end]), colours.BODY.colour, linewidth=0.7, zorder=2)
    size = float(np.linalg.norm(data.omega))
    spin = arrow(ax, 1.12 * data.omega, colours.OMEGA.colour, colours.OMEGA.label, linewidth=2.6)
    longer = 1.4 * size
    momentum = arrow(
        ax,
        longer * data.momentum / np.linalg.norm(data.momentum),
        colours.L.colour,
        colours.L.label,
        linewidth=2.2,
    )
    axis = arrow(ax, 1.3 * size * data.axis, colours.Z.colour, "axis", linewidth=2.2)
    for rim, angle, name, beyond, side in (
        (data.body_rim, data.body_cone, "body cone", 0.8, "center"),
        (data.space_rim, data.space_cone, "space cone", 1.04, "bottom"),
    ):
        place = beyond * rim[np.argmax(np.linalg.norm(rim - data.omega, axis=-1))]
        text = f"{name}\n{np.degrees(angle):.1f}°"
        label(ax, place, text, colours.NEUTRAL, fontsize="medium", va=side)
    # Room for the whole way around L, and a place to stand in space: frames fit on each other.
    shown = np.vstack([data.body_rim, data.space_rim, momentum.vector, axis.vector, spin.vector])
    swept = rotate(shown[:, np.newaxis, :], [0.0, 0.0, 1.0], np.linspace(0.0, 2.0 * np.pi, 25))
    azim = float(np.degrees(np.arctan2(*data.space_rim[0, 1::-1]))) - 90.0
    fit(ax, swept, np.zeros(3), elev=16.0, azim=azim, filled=0.84)
    return ConesArtists(
        ax=ax,
        data=data,
        body_cone=surfaces[1],
        space_cone=surfaces[0],
        body_rim=rims[1],
        space_rim=rims[0],
        omega=spin,
        momentum=momentum,
        axis=axis,
    )


def _turning(omega: ArrayLike) -> Floats:
    rates = vector("omega", omega, 3)
    if not rates.any():
        raise ValueError(f"omega = {rates.tolist()}: must not be zero, a body at rest has no axis")
    return rates


def _upright(momentum: Floats) -> Floats:
    """The attitude, a quaternion, that turns a vector of the body upwards in space."""
    up = momentum / np.linalg.norm(momentum)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return matrix_to_quaternion(np.stack([side, np.cross(up, side), up]))


def _tips(ax: Any, path: Floats, colour: str) -> None:
    """Arrow heads along a closed path, to tell its sense."""
    for place in range(len(path) // 6, len(path) - 2, len(path) // 3):
        step = path[place + 1] - path[place]
        if step.any():
            arrow(ax, step, colour, start=path[place], linewidth=0.0, mutation_scale=14.0)
