"""The body cone of a free symmetric top, rolling on the space cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float
from ..drawing import colours
from ..drawing.axes3d import arrow, cone, curve, fit, label
from ..free import cones as cones_of
from ..free import symmetric_free_top
from ..model.body_like import BodyLike, moments_of
from ..rotations.quaternions import matrix_to_quaternion, quaternion_to_matrix
from ..rotations.so3 import rotate
from .picture import Picture
from .symmetric import turning

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RollingCones(Picture):
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

    def _draw(self, ax: Any) -> None:
        for name, rim, ink, alpha in (
            ("space", self.space_rim, colours.SPACE, 0.35),
            ("body", self.body_rim, colours.BODY, 0.25),
        ):
            cone(ax, rim, ink.colour, alpha, gid=f"{name}_cone")
            curve(ax, rim, ink.colour, linewidth=1.8, zorder=2, gid=f"{name}_rim")
        # Generators of the body cone show the rotation of the body.
        for end in self.body_rim[:-1:10]:
            curve(ax, np.array([np.zeros(3), end]), colours.BODY.colour, linewidth=0.7, zorder=2)
        size = float(np.linalg.norm(self.omega))
        omega, axis = 1.12 * self.omega, 1.3 * size * self.axis
        momentum = 1.4 * size * self.momentum / np.linalg.norm(self.momentum)
        for name, vector, colour, text, width in (
            ("omega", omega, colours.OMEGA.colour, colours.OMEGA.label, 2.6),
            ("momentum", momentum, colours.L.colour, colours.L.label, 2.2),
            ("axis", axis, colours.Z.colour, "axis", 2.2),
        ):
            arrow(ax, vector, colour, text, linewidth=width, gid=name)
        azim = float(np.degrees(np.arctan2(*self.space_rim[0, 1::-1]))) - 90.0
        # The names stand outside the cones, each on its own side of the page.
        right = rotate(np.array([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0], np.radians(azim))
        towards = 1.0 if self.axis @ right >= 0.0 else -1.0
        for rim, angle, name, side, height in (
            (self.body_rim, self.body_cone, "body cone", towards, "top"),
            (self.space_rim, self.space_cone, "space cone", -towards, "center"),
        ):
            outermost = rim[np.argmax(side * (rim @ right))]
            place = 0.5 * outermost + 0.07 * side * size * right
            if height == "top":  # below the edge, however flat it lies
                place[2] -= 0.06 * size
            text = f"{name}\n{np.degrees(angle):.1f}°"
            align = "left" if side > 0.0 else "right"
            label(ax, place, text, colours.NEUTRAL, fontsize="medium", va=height, ha=align)
        # Room for the whole motion around L and a fixed view, so that all frames have equal scales.
        shown = np.vstack([self.body_rim, self.space_rim, momentum, axis, omega])
        swept = rotate(shown[:, np.newaxis, :], [0.0, 0.0, 1.0], np.linspace(0.0, 2.0 * np.pi, 25))
        fit(ax, swept, np.zeros(3), elev=16.0, azim=azim, filled=0.84)


def cones(body: BodyLike, omega: ArrayLike, *, t: float = 0.0, samples: int = 121) -> RollingCones:
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
    RollingCones

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


def _upright(momentum: Floats) -> Floats:
    """Quaternion of the attitude in which a vector of the body points upwards in space."""
    up = momentum / np.linalg.norm(momentum)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return matrix_to_quaternion(np.stack([side, np.cross(up, side), up]))
