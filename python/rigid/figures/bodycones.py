"""The body cone of a free symmetric top, rolling on the space cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float
from ..drawing import colours
from ..drawing.axes3d import arrow, curve, fit, in_space, label
from ..free import cones as cones_of
from ..free import symmetric_free_top
from ..model.body_like import BodyLike, moments_of
from ..rotations.quaternions import matrix_to_quaternion, quaternion_to_matrix
from ..rotations.so3 import rotate
from .symmetric import turning

__all__ = ["ConesArtists", "RollingCones", "cones", "cones_data"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RollingCones:
    """The cones of a free symmetric top at one time, in space with L upwards.

    Attributes
    ----------
    body_cone, space_cone : float
        Half angles (rad).
    rolling : str
        ``"outside"`` for a prolate top; ``"inside"`` for an oblate top, whose body cone encloses
        the space cone.
    omega, momentum, axis : ndarray, shape (3,)
        omega (rad/s), L (kg m²/s) and the unit vector along the axis in the direction of the spin.
    body_rim, space_rim : ndarray, shape (m, 3)
        The circles of omega in the body and in space (rad/s), with components in space. The body
        carries the first circle; both start with omega at time 0.
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
    """Artists of the figure :func:`cones`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : RollingCones
        Data of the figure.
    body_cone, space_cone : Poly3DCollection
        The surfaces.
    body_rim, space_rim : Line3D
        Their rims.
    omega, momentum, axis : SpaceArrow
        Arrows of omega, L and the axis, L and the axis scaled to comparable lengths, with the
        attributes ``start`` and ``vector``.
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
    """Cones of the figure :func:`cones`: the cones of :func:`rigid.free.cones` at a time.

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
    RollingCones

    Raises
    ------
    ValueError
        If the top is not symmetric, omega and L are parallel, so that no cone rolls, or an argument
        is not finite.

    Examples
    --------
    >>> from rigid import figures
    >>> data = figures.cones_data((1.0, 1.0, 0.55), [0.9, 0.0, 2.3], t=1.0)
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

    The cones touch along omega, the momentary axis of rotation. The space cone has the half angle
    ``|alpha - theta|`` about L, the body cone alpha about the axis (Ercan 2016, figs. 12a, b,
    errata D-21 to D-23). For the frames of an animation draw successive times ``t``.

    Parameters
    ----------
    body, omega, t
        As in :func:`cones_data`.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    ConesArtists

    Raises
    ------
    ValueError
        As in :func:`cones_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

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
    # Generators of the body cone show the rotation of the body.
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
    shown = np.vstack([data.body_rim, data.space_rim, momentum.vector, axis.vector, spin.vector])
    swept = rotate(shown[:, np.newaxis, :], [0.0, 0.0, 1.0], np.linspace(0.0, 2.0 * np.pi, 25))
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


def _upright(momentum: Floats) -> Floats:
    """Quaternion of the attitude in which a vector of the body points upwards in space."""
    up = momentum / np.linalg.norm(momentum)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return matrix_to_quaternion(np.stack([side, np.cross(up, side), up]))
