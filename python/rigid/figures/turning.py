"""Small turns of a vector or of the axes, and of a unit vector about another."""

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
    in_space,
    label,
    panels,
)
from ..model.start import body_axis
from ..rotations.euler import rotation_z
from ..rotations.so3 import rotate

__all__ = [
    "ActivePassive",
    "ActivePassiveArtists",
    "UnitVectorChange",
    "UnitVectorChangeArtists",
    "active_passive",
    "active_passive_data",
    "unit_vector_change",
    "unit_vector_change_data",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ActivePassive:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ActivePassiveArtists:
    """Artists of the figure :func:`active_passive`.

    Attributes
    ----------
    axes : tuple of 2 Axes
        The panels, passive and active.
    data : ActivePassive
        Data of the figure.
    turned_axes : tuple of 2 PlaneArrow
        Passive: the axes after the turn; an arrow has the attributes ``start`` and ``vector``.
    vector, turned, change : PlaneArrow
        Active: the vector before and after the turn, and its change to first order.
    """

    axes: tuple[Any, ...]
    data: ActivePassive
    turned_axes: tuple[Any, ...]
    vector: Any
    turned: Any
    change: Any


def active_passive_data(angle: float, *, vector: ArrayLike = (0.75, 0.6)) -> ActivePassive:
    """Vectors of the figure :func:`active_passive`.

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
    >>> data = figures.active_passive_data(np.pi / 2, vector=[1.0, 0.0])
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


def active_passive(
    angle: float = 0.35,
    *,
    vector: ArrayLike = (0.75, 0.6),
    axes: Sequence[Any] | None = None,
) -> ActivePassiveArtists:
    """Draw a turn of the axes (passive) and a turn of the vector (active).

    In the passive turn the axes turn and the components of the vector change. In the active turn
    the vector turns and changes by ``angle n × r`` to first order. A passive turn gives the same
    components as the active turn by the opposite angle (lecture notes, fig. 5.1).

    Parameters
    ----------
    angle, vector
        As in :func:`active_passive_data`.
    axes : sequence of 2 Axes, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    ActivePassiveArtists

    Raises
    ------
    ValueError
        As in :func:`active_passive_data`, and if there are not two axes.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.active_passive(0.3)
    >>> drawn.axes[0].figure.savefig("turns.png")  # doctest: +SKIP
    """
    data = active_passive_data(angle, vector=vector)
    passive, active = panels(axes, ["plane", "plane"])
    length = 1.2 * float(np.linalg.norm(data.vector))
    black = colours.HUES["black"]
    thin: dict[str, Any] = {"linewidth": 1.0, "linestyle": "dashed"}

    turned_axes = []
    for along, old, ink in zip(data.axes, np.eye(2), colours.AXES[:2], strict=True):
        name = ink.label.strip("$")
        arrow_in_plane(passive, length * old, ink.colour, ink.label, **thin)
        turned_axes.append(arrow_in_plane(passive, length * along, ink.colour, f"${name}'$"))
        arrow_in_plane(active, length * old, ink.colour, ink.label)
    for component, along, ink in zip(data.seen, data.axes, colours.AXES[:2], strict=True):
        foot = np.array([data.vector, component * along])
        curve(passive, foot, ink.colour, linewidth=0.9, linestyle="dotted")
    arrow_in_plane(passive, data.vector, black, colours.POSITION.label)
    _flat_arc(passive, 0.0, data.angle, 0.42 * length)

    before = arrow_in_plane(active, data.vector, black, colours.POSITION.label, **thin)
    after = arrow_in_plane(active, data.turned, black, r"$\mathbf{r}'$")
    purple = colours.HUES["purple"]
    change = arrow_in_plane(active, data.first_order, purple, start=data.vector, linewidth=1.4)
    beside = data.vector + 0.5 * data.first_order + 0.04 * data.vector
    label(active, beside, r"$\varepsilon\,\mathbf{n}\times\mathbf{r}$", purple, ha="left")
    start = float(np.arctan2(data.vector[1], data.vector[0]))
    _flat_arc(active, start, start + data.angle, 0.42 * length)

    shown = np.vstack(
        [[[0.0, 0.0]], length * np.eye(2), length * data.axes, [data.vector, data.turned]]
    )
    for ax, title in ((passive, "passive: the axes turn"), (active, "active: the vector turns")):
        _flat(ax, shown, 0.18 * length)
        ax.set_title(title, fontsize="medium")
    return ActivePassiveArtists(
        axes=(passive, active),
        data=data,
        turned_axes=tuple(turned_axes),
        vector=before,
        turned=after,
        change=change,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnitVectorChange:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnitVectorChangeArtists:
    """Artists of the figure :func:`unit_vector_change`.

    Attributes
    ----------
    ax : Axes3D
        Axes of the figure.
    data : UnitVectorChange
        Data of the figure.
    axes : tuple of 3 SpaceArrow
        The unit vectors before the turn; an arrow has the attributes ``start`` and ``vector``.
    turned, change, first_order : SpaceArrow
        The vector after the turn, the difference, and the difference to first order.
    """

    ax: Any
    data: UnitVectorChange
    axes: tuple[Any, ...]
    turned: Any
    change: Any
    first_order: Any


def unit_vector_change_data(angle: float, *, unit: int = 1, about: int = 2) -> UnitVectorChange:
    """Vectors of the figure :func:`unit_vector_change`.

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
    >>> figures.unit_vector_change_data(1e-3).first_order.tolist()
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


def unit_vector_change(
    angle: float = 0.35, *, unit: int = 1, about: int = 2, ax: Any | None = None
) -> UnitVectorChangeArtists:
    """Draw how a unit vector changes in a small turn about another: ``d e/dt = omega × e``.

    A turn about axis 2 moves the first unit vector towards the negative third axis (Ercan 2016,
    fig. 8, eqs. (13)-(15); the caption names the first axis instead, erratum D-05).

    Parameters
    ----------
    angle, unit, about
        As in :func:`unit_vector_change_data`.
    ax : Axes3D, optional
        Axes to draw on; by default the axes of a new figure.

    Returns
    -------
    UnitVectorChangeArtists

    Raises
    ------
    ValueError
        As in :func:`unit_vector_change_data`, and if the axes are not three-dimensional.
    ImportError
        If Matplotlib is not installed.

    Examples
    --------
    >>> from rigid import figures
    >>> drawn = figures.unit_vector_change(0.3)
    >>> drawn.ax.figure.savefig("change.png")  # doctest: +SKIP
    """
    data = unit_vector_change_data(angle, unit=unit, about=about)
    ax = in_space(ax)
    one, other = int(data.unit.argmax()), int(data.about.argmax())
    axes = tuple(
        arrow(ax, along, ink.colour, rf"$\mathbf{{e}}_{number}$", linewidth=2.0)
        for number, along, ink in zip((1, 2, 3), np.eye(3), colours.AXES, strict=True)
    )
    third = 3 - one - other
    toward = np.sign(data.first_order[third]) * np.eye(3)[third]
    if toward.any():
        curve(
            ax,
            np.array([np.zeros(3), 0.6 * toward]),
            colours.AXES[third].colour,
            linewidth=1.0,
            linestyle="dashed",
        )
    colour = colours.AXES[one].colour
    turned = arrow(ax, data.turned, colour, linestyle="dashed")
    below = 0.95 * data.turned + 0.1 * toward
    label(ax, below, rf"$\mathbf{{e}}_{one + 1}'$", colour)
    black = colours.HUES["black"]
    change = arrow(ax, data.change, black, start=data.unit, linewidth=1.8)
    label(ax, 0.87 * data.unit + 0.6 * data.change, rf"$\Delta\mathbf{{e}}_{one + 1}$", black)
    purple = colours.OMEGA.colour
    first = arrow(ax, data.first_order, purple, start=data.unit, linewidth=1.8)
    label(
        ax,
        1.04 * data.unit + 0.5 * data.first_order,
        rf"$\delta\,\mathbf{{e}}_{other + 1}\times\mathbf{{e}}_{one + 1}$",
        purple,
        ha="left",
    )
    arc(ax, data.about, 0.45 * data.unit, data.angle, black, r"$\delta$")
    # The sense of the turn: most of a circle about the axis.
    sense = np.copysign(5.0, data.angle)
    arc(ax, data.about, 0.12 * np.eye(3)[third], sense, purple, centre=0.6 * data.about)
    shown = np.vstack([np.eye(3), data.turned, data.unit + data.first_order, np.zeros(3)])
    fit(ax, shown, elev=18.0, azim=-58.0, filled=0.85)
    return UnitVectorChangeArtists(
        ax=ax, data=data, axes=axes, turned=turned, change=change, first_order=first
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
