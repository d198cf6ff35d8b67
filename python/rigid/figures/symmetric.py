"""The free symmetric top: omega, L and the axis, and the body cone on the space cone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, vector
from ..drawing import colours
from ..drawing.axes3d import (
    arc,
    arc_in_plane,
    arrow,
    cone,
    curve,
    fit,
    label,
)
from ..free import cones as cones_of
from ..free import symmetric_free_top
from ..model.body_like import BodyLike, moments_of
from ..rotations.quaternions import matrix_to_quaternion, quaternion_to_matrix
from ..rotations.so3 import rotate
from .picture import Picture

Floats = NDArray[np.float64]


def _draw_free_top_omega(data: Picture, ax: Any) -> None:
    size = float(np.linalg.norm(data.start))
    purple, black = colours.OMEGA.colour, colours.HUES["black"]
    along = (data.start @ data.axis) * data.axis
    reach = np.maximum(1.3 * data.amplitude, 0.6 * size) * np.ones(3)
    which = int(data.axis.argmax())
    reach[which] = 1.25 * size
    for axis, ink in enumerate(colours.AXES):
        arrow(ax, reach[axis] * np.eye(3)[axis], ink.colour, ink.label, linewidth=1.4)
    curve(ax, data.path, purple, linewidth=1.4, gid="path")
    shadow = data.path - along
    curve(ax, shadow, colours.FAINT, linewidth=1.4, gid="projection")
    _tips(ax, data.path, purple)
    drop = np.array([data.now, data.now - along])
    dashed: dict[str, Any] = {"linestyle": "dashed"}
    curve(ax, drop, colours.FAINT, linewidth=1.0, **dashed)
    # Draw the vector at time 0 only if it differs from the vector at time t.
    arrow(ax, data.start, purple, linewidth=1.2, alpha=0.7, gid="start", **dashed)
    arrow(ax, data.now, purple, r"$\boldsymbol{\omega}(t)$", linewidth=2.4, gid="now")
    arrow(ax, data.now - along, black, "$A$", linewidth=1.8, gid="amplitude")
    curve(ax, np.array([np.zeros(3), data.start - along]), black, linewidth=0.9, **dashed)
    if data.amplitude > 0.0:
        first = 0.5 * (data.start - along)
        arc(ax, data.axis, first, data.angle, black, "$k\\,t$", beyond=1.5)
        centre = np.array([data.now, along])
        curve(ax, centre, colours.FAINT, linewidth=1.0, **dashed)
    name = r"$\omega_" + str(which + 1) + "$"
    aside = np.roll(np.array([0.0, -0.14 * size, 0.0]), which - 2)
    label(ax, along + aside, name, colours.AXES[which].colour)
    fit(ax, data.path, shadow, np.diag(reach), np.zeros(3), elev=20.0, azim=35.0)


def free_top_omega(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121
) -> Picture:
    """How omega turns about the axis of a free symmetric top in the body frame.

    The component along the axis is constant; the perpendicular component turns by ``k t`` on a
    circle of radius ``A``, in opposite directions for oblate and prolate tops (Ercan 2016, fig. 10,
    eqs. (43)-(45)).

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s), not zero.
    t : float
        Time (s).
    samples : int
        Number of points of the path.

    Returns
    -------
    Picture
        The angular velocity of a free symmetric top in the body frame.

        axis : ndarray, shape (3,)
            Unit vector along the axis of symmetry.
        k : float
            Rate at which omega turns about the axis (rad/s).
        amplitude : float
            ``A``, the size of the component of omega perpendicular to the axis (rad/s).
        angle : float
            ``k t`` (rad).
        path : ndarray, shape (m, 3)
            omega over one period, closed (rad/s); constant for ``k = 0``.
        start, now : ndarray, shape (3,)
            omega at time 0 and at the time ``t`` (rad/s).

    Raises
    ------
    ValueError
        If the top is not symmetric, omega is zero, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.free_top_omega((1.0, 1.0, 1.6), [0.9, 0.0, 2.3], t=1.0)
    >>> round(data.angle, 12), data.amplitude
    (1.38, 0.9)
    """
    rates = turning(omega)
    time = finite_float("t", t)
    period = float(symmetric_free_top(body, rates).period)
    whole = np.linspace(0.0, period if np.isfinite(period) else 0.0, samples)
    path, now = (symmetric_free_top(body, rates, t=times) for times in (whole, [time]))
    assert path.omega is not None
    assert now.omega is not None
    return Picture(
        _draw_free_top_omega,
        axis=np.eye(3)[int(path.axis) - 1],
        k=float(path.k),
        amplitude=float(path.amplitude),
        angle=float(path.k) * time,
        path=path.omega,
        start=rates,
        now=now.omega[0],
    )


def _draw_coplanar_vectors(data: Picture, *panels: Any) -> None:
    for ax, one in zip(panels, data.tops, strict=True):
        _draw_coplanar(one, ax)


def coplanar_vectors(bodies: Sequence[BodyLike], omega: ArrayLike) -> Picture:
    """L, omega and the axis of free symmetric tops in their common plane.

    ``tan theta = (I / I3) tan alpha``: L lies between the axis and omega if the top is oblate, and
    omega between the axis and L if it is prolate (Ercan 2016, figs. 11a, b, eqs. (47), (48)).

    Parameters
    ----------
    bodies : sequence of Body, FreeBody or array_like, shape (3,)
        A body for each panel, for example an oblate and a prolate top; or its principal moments
        (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body (rad/s), not zero, used for all bodies.

    Returns
    -------
    Picture
        L, omega and the axis of free symmetric tops, each in their common plane.

        tops : tuple of Picture
            The panel of each body, with the attributes

            along, across : float
                Moments about the axis of symmetry, ``I3``, and about a perpendicular axis, ``I``
                (kg m²).
            omega, momentum : ndarray, shape (2,)
                Components of omega (rad/s) and of L (kg m²/s) perpendicular to the axis and along
                it.
            alpha, theta : float
                Angles of omega and of L from the axis (rad).

    Raises
    ------
    ValueError
        If there are no bodies, a top is not symmetric, does not turn, or an argument is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> oblate, prolate = figures.coplanar_vectors([(1, 1, 1.6), (1, 1, 0.55)], [0.9, 0, 2.3]).tops
    >>> oblate.theta < oblate.alpha, prolate.theta < prolate.alpha
    (True, False)
    """
    if len(bodies) == 0:
        raise ValueError("bodies: expected at least one, got none")
    return Picture(
        _draw_coplanar_vectors,
        panels=["plane"] * len(bodies),
        tops=tuple(_vectors_of(body, omega) for body in bodies),
    )


def _vectors_of(body: BodyLike, omega: ArrayLike) -> Picture:
    rates = turning(omega)
    top = symmetric_free_top(body, rates)
    moments, which = moments_of(body), int(top.axis) - 1
    across, along = float(moments[which - 2]), float(moments[which])
    flat = np.array([float(top.amplitude), rates[which]])
    return Picture(
        _draw_coplanar,
        ["plane"],
        along=along,
        across=across,
        omega=flat,
        momentum=np.array([across, along]) * flat,
        alpha=float(top.alpha),
        theta=float(top.theta),
    )


def _draw_coplanar(data: Picture, ax: Any) -> None:
    size = float(np.linalg.norm(data.omega))
    longer = 1.25 * size
    arrow(ax, np.array([0.0, longer]), colours.Z.colour, "axis", linewidth=1.6)
    momentum = longer * data.momentum / np.linalg.norm(data.momentum)
    for name, arrow_of, ink in (
        ("omega", data.omega, colours.OMEGA),
        ("momentum", momentum, colours.L),
    ):
        arrow(ax, arrow_of, ink.colour, ink.label, linewidth=2.4, gid=name)
    for angle, radius, text in ((data.alpha, 0.62, r"$\alpha$"), (data.theta, 0.4, r"$\theta$")):
        end = 0.5 * np.pi - angle
        arc_in_plane(ax, radius * size, 0.5 * np.pi, end, text, beyond=1.0 + 0.06 / radius)
    kind = "oblate: $I_3 > I$" if data.along > data.across else "prolate: $I_3 < I$"
    sign = "<" if data.theta < data.alpha else ">"
    if data.along == data.across:
        kind, sign = "spherical: $I_3 = I$", "="
    ax.set_title(rf"{kind},  $\theta {sign} \alpha$", fontsize="medium", y=0.95)
    low = -0.08 if data.omega[1] >= 0.0 else -1.42
    ax.set_aspect("equal")
    ax.set(xlim=(-0.25 * size, 1.3 * size), ylim=(low * size, 1.55 * size))
    ax.set_axis_off()


def turning(omega: ArrayLike) -> Floats:
    """The angular velocity, which must not be zero."""
    rates = vector("omega", omega, 3)
    if not rates.any():
        raise ValueError(f"omega = {rates.tolist()}: must not be zero, a body at rest has no axis")
    return rates


def _tips(ax: Any, path: Floats, colour: str) -> None:
    """Arrow heads that show the direction along a closed path."""
    for place in range(len(path) // 6, len(path) - 2, len(path) // 3):
        step = path[place + 1] - path[place]
        if step.any():
            arrow(ax, step, colour, start=path[place], linewidth=0.0, mutation_scale=14.0)


def _draw_cones(data: Picture, ax: Any) -> None:
    for name, rim, ink, alpha in (
        ("space", data.space_rim, colours.SPACE, 0.35),
        ("body", data.body_rim, colours.BODY, 0.25),
    ):
        cone(ax, rim, ink.colour, alpha, gid=f"{name}_cone")
        curve(ax, rim, ink.colour, linewidth=1.8, zorder=2, gid=f"{name}_rim")
    # Generators of the body cone show the rotation of the body.
    for end in data.body_rim[:-1:10]:
        curve(ax, np.array([np.zeros(3), end]), colours.BODY.colour, linewidth=0.7, zorder=2)
    size = float(np.linalg.norm(data.omega))
    omega, axis = 1.12 * data.omega, 1.3 * size * data.axis
    momentum = 1.4 * size * data.momentum / np.linalg.norm(data.momentum)
    for name, along, colour, text, width in (
        ("omega", omega, colours.OMEGA.colour, colours.OMEGA.label, 2.6),
        ("momentum", momentum, colours.L.colour, colours.L.label, 2.2),
        ("axis", axis, colours.Z.colour, "axis", 2.2),
    ):
        arrow(ax, along, colour, text, linewidth=width, gid=name)
    azim = float(np.degrees(np.arctan2(*data.space_rim[0, 1::-1]))) - 90.0
    # The names stand outside the cones, each on its own side of the page.
    right = rotate(np.array([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0], np.radians(azim))
    towards = 1.0 if data.axis @ right >= 0.0 else -1.0
    for rim, angle, name, side, height in (
        (data.body_rim, data.body_cone, "body cone", towards, "top"),
        (data.space_rim, data.space_cone, "space cone", -towards, "center"),
    ):
        outermost = rim[np.argmax(side * (rim @ right))]
        place = 0.5 * outermost + 0.07 * side * size * right
        if height == "top":  # below the edge, however flat it lies
            place[2] -= 0.06 * size
        text = f"{name}\n{np.degrees(angle):.1f}°"
        align = "left" if side > 0.0 else "right"
        label(ax, place, text, colours.NEUTRAL, fontsize="medium", va=height, ha=align)
    # Room for the whole motion around L and a fixed view, so that all frames have equal scales.
    shown = np.vstack([data.body_rim, data.space_rim, momentum, axis, omega])
    swept = rotate(shown[:, np.newaxis, :], [0.0, 0.0, 1.0], np.linspace(0.0, 2.0 * np.pi, 25))
    fit(ax, swept, np.zeros(3), elev=16.0, azim=azim, filled=0.84)


def cones(body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121) -> Picture:
    """The body cone of a free symmetric top as it rolls on the space cone.

    The cones touch along omega, the momentary axis of rotation. The space cone has the half angle
    ``|alpha - theta|`` about L, the body cone alpha about the axis (Ercan 2016, figs. 12a, b,
    errata D-21 to D-23). For the frames of an animation draw successive times ``t``.

    Parameters
    ----------
    body : Body, FreeBody or array_like, shape (3,)
        The body, or principal moments (kg m²), two of them exactly equal.
    omega : array_like, shape (3,)
        Angular velocity in the body at time 0 (rad/s).
    t : float
        Time (s).
    samples : int
        Number of points of a rim.

    Returns
    -------
    Picture
        The cones of a free symmetric top at one time, in space with L upwards.

        body_cone, space_cone : float
            Half angles (rad).
        rolling : str
            ``"outside"`` for a prolate top; ``"inside"`` for an oblate top, whose body cone
            encloses the space cone.
        omega, momentum, axis : ndarray, shape (3,)
            omega (rad/s), L (kg m²/s) and the unit vector along the axis in the direction of the
            spin.
        body_rim, space_rim : ndarray, shape (m, 3)
            The circles of omega in the body and in space (rad/s), with components in space. The
            body carries the first circle; both start with omega at time 0.

    Raises
    ------
    ValueError
        If the top is not symmetric, omega and L are parallel, so that no cone rolls, or an argument
        is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.cones((1.0, 1.0, 0.55), [0.9, 0.0, 2.3], t=1.0)
    >>> data.rolling, round(data.space_cone, 9)
    ('outside', 0.245389808)
    """
    rates = turning(omega)
    time = finite_float("t", t)
    start = _upright(moments_of(body) * rates)
    found = cones_of(body, rates, start, samples=samples)
    if str(found.rolling) == "none":
        raise ValueError(
            f"omega = {rates.tolist()}: no cone rolls if omega and L are parallel, as they are "
            "along the axis, perpendicular to the axis, and for a sphere"
        )
    top = symmetric_free_top(body, rates, start, t=[time])
    assert top.omega is not None
    assert top.attitude is not None
    turn = quaternion_to_matrix(top.attitude[0])
    size = float(top.rate)
    which = int(top.axis) - 1
    return Picture(
        _draw_cones,
        body_cone=float(found.body_cone),
        space_cone=float(found.space_cone),
        rolling=str(found.rolling),
        omega=turn @ top.omega[0],
        momentum=turn @ (moments_of(body) * top.omega[0]),
        axis=np.copysign(1.0, rates[which]) * turn[:, which],
        body_rim=size * found.body_curve @ turn.T,
        space_rim=size * found.space_curve,
    )


def _upright(momentum: Floats) -> Floats:
    """Quaternion of the attitude in which a vector of the body points upwards in space."""
    up = momentum / np.linalg.norm(momentum)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return matrix_to_quaternion(np.stack([side, np.cross(up, side), up]))
