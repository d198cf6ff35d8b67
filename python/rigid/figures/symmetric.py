"""The free symmetric top: directions of omega, L and the axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, vector
from ..drawing import colours
from ..drawing.axes3d import (
    arc,
    arrow,
    arrow_in_plane,
    curve,
    fit,
    label,
)
from ..free import symmetric_free_top
from ..model.body_like import BodyLike, moments_of
from .picture import Kind, Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeTopOmega(Picture):
    """The angular velocity of a free symmetric top in the body frame.

    Attributes
    ----------
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
    """

    axis: Floats
    k: float
    amplitude: float
    angle: float
    path: Floats
    start: Floats
    now: Floats

    def _draw(self, ax: Any) -> None:
        size = float(np.linalg.norm(self.start))
        purple, black = colours.OMEGA.colour, colours.HUES["black"]
        along = (self.start @ self.axis) * self.axis
        reach = np.maximum(1.3 * self.amplitude, 0.6 * size) * np.ones(3)
        which = int(self.axis.argmax())
        reach[which] = 1.25 * size
        for axis, ink in enumerate(colours.AXES):
            arrow(ax, reach[axis] * np.eye(3)[axis], ink.colour, ink.label, linewidth=1.4)
        curve(ax, self.path, purple, linewidth=1.4, gid="path")
        shadow = self.path - along
        curve(ax, shadow, colours.FAINT, linewidth=1.4, gid="projection")
        _tips(ax, self.path, purple)
        drop = np.array([self.now, self.now - along])
        dashed: dict[str, Any] = {"linestyle": "dashed"}
        curve(ax, drop, colours.FAINT, linewidth=1.0, **dashed)
        # Draw the vector at time 0 only if it differs from the vector at time t.
        arrow(ax, self.start, purple, linewidth=1.2, alpha=0.7, gid="start", **dashed)
        arrow(ax, self.now, purple, r"$\boldsymbol{\omega}(t)$", linewidth=2.4, gid="now")
        arrow(ax, self.now - along, black, "$A$", linewidth=1.8, gid="amplitude")
        curve(ax, np.array([np.zeros(3), self.start - along]), black, linewidth=0.9, **dashed)
        if self.amplitude > 0.0:
            first = 0.5 * (self.start - along)
            arc(ax, self.axis, first, self.angle, black, "$k\\,t$", beyond=1.5)
            centre = np.array([self.now, along])
            curve(ax, centre, colours.FAINT, linewidth=1.0, **dashed)
        name = r"$\omega_" + str(which + 1) + "$"
        aside = np.roll(np.array([0.0, -0.14 * size, 0.0]), which - 2)
        label(ax, along + aside, name, colours.AXES[which].colour)
        fit(ax, self.path, shadow, np.diag(reach), np.zeros(3), elev=20.0, azim=35.0)


def free_top_omega(
    body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121
) -> FreeTopOmega:
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
    FreeTopOmega

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
    return FreeTopOmega(
        axis=np.eye(3)[int(path.axis) - 1],
        k=float(path.k),
        amplitude=float(path.amplitude),
        angle=float(path.k) * time,
        path=path.omega,
        start=rates,
        now=now.omega[0],
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TopVectors:
    """L, omega and the axis of a free symmetric top, in their common plane.

    Attributes
    ----------
    along, across : float
        Moments about the axis of symmetry, ``I3``, and about a perpendicular axis, ``I`` (kg m²).
    omega, momentum : ndarray, shape (2,)
        Components of omega (rad/s) and of L (kg m²/s) perpendicular to the axis and along it.
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
class CoplanarVectors(Picture):
    """L, omega and the axis of free symmetric tops, each in their common plane.

    Attributes
    ----------
    tops : tuple of TopVectors
        The vectors of each body.
    """

    tops: tuple[TopVectors, ...]

    def _kinds(self) -> list[Kind]:
        return ["plane"] * len(self.tops)

    def _draw(self, *panels: Any) -> None:
        for ax, one in zip(panels, self.tops, strict=True):
            _draw_coplanar(ax, one)


def coplanar_vectors(bodies: Sequence[BodyLike], omega: ArrayLike) -> CoplanarVectors:
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
    CoplanarVectors

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
    return CoplanarVectors(tops=tuple(_vectors_of(body, omega) for body in bodies))


def _vectors_of(body: BodyLike, omega: ArrayLike) -> TopVectors:
    rates = turning(omega)
    top = symmetric_free_top(body, rates)
    moments, which = moments_of(body), int(top.axis) - 1
    across, along = float(moments[which - 2]), float(moments[which])
    flat = np.array([float(top.amplitude), rates[which]])
    return TopVectors(
        along=along,
        across=across,
        omega=flat,
        momentum=np.array([across, along]) * flat,
        alpha=float(top.alpha),
        theta=float(top.theta),
    )


def _draw_coplanar(ax: Any, data: TopVectors) -> None:
    size = float(np.linalg.norm(data.omega))
    longer = 1.25 * size
    arrow_in_plane(ax, np.array([0.0, longer]), colours.Z.colour, "axis", linewidth=1.6)
    momentum = longer * data.momentum / np.linalg.norm(data.momentum)
    for name, arrow_of, ink in (
        ("omega", data.omega, colours.OMEGA),
        ("momentum", momentum, colours.L),
    ):
        arrow_in_plane(ax, arrow_of, ink.colour, ink.label, linewidth=2.4, gid=name)
    for angle, radius, text in ((data.alpha, 0.62, r"$\alpha$"), (data.theta, 0.4, r"$\theta$")):
        turn = np.linspace(0.0, angle, 49)[:, np.newaxis]
        points = radius * size * np.hstack([np.sin(turn), np.cos(turn)])
        curve(ax, points, colours.ANGLE.colour)
        label(ax, points[24] * (1.0 + 0.06 / radius), text)
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
