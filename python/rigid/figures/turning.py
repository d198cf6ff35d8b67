"""Small turns of a vector or of the axes, and of a unit vector about another."""

from __future__ import annotations

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
    triad,
)
from ..model.start import body_axis
from ..rotations.euler import rotation_z
from ..rotations.so3 import rotate
from .picture import Kind, Picture

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ActivePassive(Picture):
    """A turn in a plane, passive and active.

    Attributes
    ----------
    angle : float
        Angle of the turn (rad).
    vector : ndarray, shape (2,)
        The vector before the turn.
    axes : ndarray, shape (2, 2)
        Passive: unit vectors along the turned axes, one in a row.
    seen : ndarray, shape (2,)
        Passive: components of the vector along the turned axes.
    turned : ndarray, shape (2,)
        Active: the turned vector.
    first_order : ndarray, shape (2,)
        Change of the vector by the active turn to first order, ``angle n × r``.
    """

    angle: float
    vector: Floats
    axes: Floats
    seen: Floats
    turned: Floats
    first_order: Floats

    def _kinds(self) -> list[Kind]:
        return ["plane", "plane"]

    def _draw(self, passive: Any, active: Any) -> None:
        length = 1.2 * float(np.linalg.norm(self.vector))
        black = colours.HUES["black"]
        thin: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}

        for along, old, ink in zip(self.axes, np.eye(2), colours.AXES[:2], strict=True):
            name = ink.label.strip("$")
            arrow_in_plane(passive, length * old, ink.colour, ink.label, **thin)
            arrow_in_plane(passive, length * along, ink.colour, f"${name}'$", gid="axes")
            arrow_in_plane(active, length * old, ink.colour, ink.label)
        for component, along, ink in zip(self.seen, self.axes, colours.AXES[:2], strict=True):
            foot = np.array([self.vector, component * along])
            curve(passive, foot, ink.colour, linewidth=0.9, linestyle="dotted")
        arrow_in_plane(passive, self.vector, black, colours.POSITION.label)
        _flat_arc(passive, 0.0, self.angle, 0.42 * length)

        arrow_in_plane(active, self.vector, black, colours.POSITION.label, gid="vector", **thin)
        arrow_in_plane(active, self.turned, black, r"$\mathbf{r}'$", gid="turned")
        purple = colours.HUES["purple"]
        tip: dict[str, Any] = {"start": self.vector, "linewidth": 1.4, "gid": "first_order"}
        arrow_in_plane(active, self.first_order, purple, **tip)
        beside = self.vector + 0.5 * self.first_order + 0.04 * self.vector
        label(active, beside, r"$\varepsilon\,\mathbf{n}\times\mathbf{r}$", purple, ha="left")
        start = float(np.arctan2(self.vector[1], self.vector[0]))
        _flat_arc(active, start, start + self.angle, 0.42 * length)

        shown = np.vstack(
            [[[0.0, 0.0]], length * np.eye(2), length * self.axes, [self.vector, self.turned]]
        )
        for ax, title in (
            (passive, "passive: the axes turn"),
            (active, "active: the vector turns"),
        ):
            _flat(ax, shown, 0.18 * length)
            ax.set_title(title, fontsize="medium")


def active_passive(angle: float = 0.35, *, vector: ArrayLike = (0.75, 0.6)) -> ActivePassive:
    """A turn of the axes (passive) and a turn of the vector (active).

    In the passive turn the axes turn and the components of the vector change. In the active turn
    the vector turns and changes by ``angle n × r`` to first order. A passive turn gives the same
    components as the active turn by the opposite angle (lecture notes, fig. 5.1).

    Parameters
    ----------
    angle : float
        Angle of the turn (rad).
    vector : array_like, shape (2,)
        The vector, not zero.

    Returns
    -------
    ActivePassive

    Raises
    ------
    ValueError
        If the vector is zero or an argument is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import figures
    >>> data = figures.active_passive(np.pi / 2, vector=[1.0, 0.0])
    >>> data.turned.round(12).tolist(), (data.seen.round(12) + 0.0).tolist()
    ([0.0, 1.0], [0.0, -1.0])
    """
    turn = finite_float("angle", angle)
    before = _nonzero("vector", vector, 2)
    active = rotation_z(turn)[:2, :2]
    return ActivePassive(
        angle=turn,
        vector=before,
        axes=active.T,
        seen=rotation_z(turn, passive=True)[:2, :2] @ before,
        turned=active @ before,
        first_order=turn * np.array([-before[1], before[0]]),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnitVectorChange(Picture):
    """A unit vector under a small turn about another.

    Attributes
    ----------
    angle : float
        Angle of the turn (rad).
    unit, about : ndarray, shape (3,)
        The vector before the turn, and the axis of the turn.
    turned : ndarray, shape (3,)
        The vector after the turn.
    change : ndarray, shape (3,)
        Difference of the vector after and before the turn.
    first_order : ndarray, shape (3,)
        ``angle about × unit``.
    """

    angle: float
    unit: Floats
    about: Floats
    turned: Floats
    change: Floats
    first_order: Floats

    def _draw(self, ax: Any) -> None:
        one, other = int(self.unit.argmax()), int(self.about.argmax())
        names = [rf"$\mathbf{{e}}_{number}$" for number in (1, 2, 3)]
        triad(ax, np.eye(3), np.zeros(3), names, linewidth=2.0, gid="axes")
        third = 3 - one - other
        toward = np.sign(self.first_order[third]) * np.eye(3)[third]
        if toward.any():
            part = np.array([np.zeros(3), 0.6 * toward])
            curve(ax, part, colours.AXES[third].colour, linewidth=1.0, linestyle="dashed")
        colour = colours.AXES[one].colour
        arrow(ax, self.turned, colour, linestyle="dashed", gid="turned")
        below = 0.95 * self.turned + 0.1 * toward
        label(ax, below, rf"$\mathbf{{e}}_{one + 1}'$", colour)
        black = colours.HUES["black"]
        tip: dict[str, Any] = {"start": self.unit, "linewidth": 1.8}
        arrow(ax, self.change, black, gid="change", **tip)
        label(ax, 0.87 * self.unit + 0.6 * self.change, rf"$\Delta\mathbf{{e}}_{one + 1}$", black)
        purple = colours.OMEGA.colour
        arrow(ax, self.first_order, purple, gid="first_order", **tip)
        product = rf"$\delta\,\mathbf{{e}}_{other + 1}\times\mathbf{{e}}_{one + 1}$"
        label(ax, 1.04 * self.unit + 0.5 * self.first_order, product, purple, ha="left")
        arc(ax, self.about, 0.45 * self.unit, self.angle, black, r"$\delta$")
        # The sense of the turn: most of a circle about the axis.
        sense = np.copysign(5.0, self.angle)
        arc(ax, self.about, 0.12 * np.eye(3)[third], sense, purple, centre=0.6 * self.about)
        shown = np.vstack([np.eye(3), self.turned, self.unit + self.first_order, np.zeros(3)])
        fit(ax, shown, elev=18.0, azim=-58.0, filled=0.85)


def unit_vector_change(angle: float = 0.35, *, unit: int = 1, about: int = 2) -> UnitVectorChange:
    """How a unit vector changes in a small turn about another: ``d e/dt = omega × e``.

    A turn about axis 2 moves the first unit vector towards the negative third axis (Ercan 2016,
    fig. 8, eqs. (13)-(15); the caption names the first axis instead, erratum D-05).

    Parameters
    ----------
    angle : float
        Angle of the turn (rad).
    unit, about : {1, 2, 3}
        Number of the unit vector that turns, and number of the axis of the turn; they must differ.

    Returns
    -------
    UnitVectorChange

    Raises
    ------
    ValueError
        If the angle is not finite, or ``unit`` and ``about`` are equal or not 1, 2 or 3.

    Examples
    --------
    >>> from rigid import figures
    >>> figures.unit_vector_change(1e-3).first_order.tolist()
    [0.0, 0.0, -0.001]
    """
    turn = finite_float("angle", angle)
    one, other = body_axis(unit) - 1, body_axis(about) - 1
    if one == other:
        raise ValueError(f"unit = {unit}, about = {about}: a vector does not turn about itself")
    before, axis = np.eye(3)[[one, other]]
    turned = rotate(before, axis, turn)
    return UnitVectorChange(
        angle=turn,
        unit=before,
        about=axis,
        turned=turned,
        change=turned - before,
        first_order=turn * np.cross(axis, before),
    )


def _nonzero(name: str, value: ArrayLike, length: int) -> Floats:
    found = vector(name, value, length)
    if not found.any():
        raise ValueError(f"{name} = {found.tolist()}: must not be zero")
    return found


def _flat_arc(ax: Any, start: float, end: float, radius: float) -> None:
    """The angle epsilon in a plane."""
    angles = np.linspace(start, end, 49)[:, np.newaxis]
    points = radius * np.hstack([np.cos(angles), np.sin(angles)])
    curve(ax, points, colours.ANGLE.colour)
    label(ax, 1.2 * points[24], r"$\varepsilon$")


def _flat(ax: Any, points: Floats, margin: float) -> None:
    """Prepare axes with equal scales and without frame."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    ax.set_aspect("equal")
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set_axis_off()
