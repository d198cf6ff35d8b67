"""What a film shows, and a sentence on one motion, or on two that stand side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats, attitudes
from ..rotations.apply import to_space

ALONG = 0.9
"""A body spins about an axis if the rate along the axis is at least this share of the rate."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """The motion of one body at some times, in principal axes.

    Attributes
    ----------
    scene : mapping
        The scene of the body alone, as plain data: :meth:`rigid.FreeBody.to_dict`.
    title : str
        The scene in words.
    forces : tuple of str
        The names of what acts on the body; the orbit is one.
    acting, under : str
        What acts on it in words; the same as the end of a sentence, with where on its orbit it is.
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (m, 3)
        Angular velocities in the body (rad/s).
    attitude : ndarray, shape (m, 4)
        Attitudes.
    momentum : ndarray, shape (m, 3)
        Angular momentum in space, rotors included (kg m²/s).
    orbit : ndarray, shape (m, 3, 3), or None
        The directions radial, along and normal of its orbit in space, as columns.
    frame : ndarray, shape (3, 3), or None
        The axes of a mesh of the body, as :attr:`rigid.Run.frame`; None: the principal axes.
    flip : float
        The time (s) at which a free body first turns over.
    flips : int
        How many times the body turns over; 0 if it is not free.
    """

    scene: Mapping[str, Any]
    title: str
    forces: tuple[str, ...]
    acting: str
    under: str
    t: NDArray[np.float64]
    omega: NDArray[np.float64]
    attitude: NDArray[np.float64]
    momentum: NDArray[np.float64]
    orbit: NDArray[np.float64] | None
    frame: NDArray[np.float64] | None
    flip: float
    flips: int

    @property
    def moments(self) -> Floats:
        """Principal moments (kg m²), shape (3,)."""
        return np.array(self.scene["body"]["moments"])

    @property
    def sides(self) -> list[float] | None:
        """The sides of a box (m), if it is one."""
        sides: list[float] | None = self.scene["body"]["sides"]
        return sides

    @property
    def is_top(self) -> bool:
        """Whether it has weight and a fixed point; else it is free."""
        return "com" in self.scene

    @property
    def com(self) -> Floats:
        """Direction from the fixed point of a top to its centre of mass, shape (3,)."""
        return np.array(self.scene["com"])


def story_of(one: Recording, view: str) -> str:
    """What happens in a motion, in words, for a view of the film."""
    span = f"{one.t[-1] - one.t[0]:.3g} s"
    if view == "cones":
        return "A symmetric body turns freely: its cone rolls on a cone that is at rest in space."
    if view == "poinsot":
        return "A body turns freely: its inertia ellipsoid rolls on a plane that is at rest."
    if view == "top":
        tilt = tilt_of(one)
        least, most = _degrees(tilt.min()), _degrees(tilt.max())
        if least == most:
            return (
                f"A heavy top turns about the vertical: in all frames of {span} its tilt is {most}."
            )
        return (
            f"A heavy top starts at a tilt of {_degrees(tilt[0])}: in the frames of {span} its "
            f"tilt is between {least} and {most}."
        )
    what = "A body" if one.sides is None else "A box"
    if one.forces:
        return f"{what} turns for {span}{one.under}."
    axis = _axis_of_spin(one.omega)
    if axis is None:
        return f"{what} turns freely for {span}: L is at rest in space, and ω moves."
    rate = f"{np.linalg.norm(one.omega[0]):.3g} rad/s"
    times = {1: "once", 2: "twice"}.get(one.flips, f"{one.flips} times")
    over = f"turns over {times}" if one.flips else "does not turn over"
    return f"{what} spins at {rate} about {_named(one.moments, axis)}, and {over} in {span}."


def story_of_two(left: Recording, right: Recording) -> str:
    """What tells two motions apart, in words."""
    both = "Two motions side by side"
    if left.scene == right.scene and (left.attitude[0] == right.attitude[0]).all():
        apart = np.linalg.norm(right.omega[0] - left.omega[0])
        if apart == 0.0:
            return "The same motion on both sides."
        both = f"Two starts that differ by {apart:.3g} rad/s"
    if left.is_top and right.is_top:
        first, second = (_degrees(tilt_of(one).max()) for one in (left, right))
        tilts = f"the left top tilts up to {first}, the right top up to {second}"
        return f"{both}: in the frames {tilts}."
    axes = {_axis_of_spin(one.omega) for one in (left, right)}
    if left.forces or right.forces or len(axes) != 1 or None in axes:
        return f"{both}."
    if both.startswith("Two starts"):
        both = both.replace("starts", "throws")
    what = "body" if left.sides is None else "box"
    if not left.flips and not right.flips:
        return f"{both}: neither {what} turns over in {left.t[-1] - left.t[0]:.3g} s."
    if left.flips and right.flips:
        times = f"at {left.flip:.2g} s, the right {what} at {right.flip:.2g} s"
        return f"{both}: the left {what} turns over {times}."
    side, other = ("left", "right") if left.flips else ("right", "left")
    when = left.flip if left.flips else right.flip
    return f"{both}: the {side} {what} turns over at {when:.2g} s, the {other} {what} does not."


def tilt_of(top: Recording) -> Floats:
    """Angle in degrees between the vertical and the direction to the centre of mass."""
    axis = to_space(attitudes(top.attitude), top.com)
    return np.rad2deg(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))


def _axis_of_spin(omega: Floats) -> int | None:
    """The axis about which a motion begins to spin, if there is one."""
    axis = int(np.abs(omega[0]).argmax())
    return axis if abs(omega[0, axis]) > ALONG * np.linalg.norm(omega[0]) else None


def _named(moments: Floats, axis: int) -> str:
    same = int((moments == moments[axis]).sum())
    if len(set(moments.tolist())) == 3:
        smaller = int((moments < moments[axis]).sum())
        return f"its {('longest', 'middle', 'shortest')[smaller]} axis"
    return f"axis {axis + 1}" if same > 1 else "its symmetry axis"


def _degrees(angle: float) -> str:
    return f"{angle:.0f}°"
