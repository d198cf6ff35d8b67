"""One sentence on a motion, or on two that a film shows side by side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import attitudes
from ..exact.flips import flip_times
from ..model.forces import forces_in_words
from ..model.scene import HeavyTop, Scene, check_heavy_top
from ..rotations.apply import to_space

__all__ = ["story_of", "story_of_two", "tilt_of", "turns_over"]

Floats = NDArray[np.float64]

ALONG = 0.9
"""A body spins about an axis if the rate along the axis is at least this share of the rate."""


def story_of(scene: Scene, view: str, t: Floats, omega: Floats, attitude: Floats) -> str:
    """What happens in a motion, in words.

    Parameters
    ----------
    scene : Scene
        The scene of one body.
    view : str
        The view of the film.
    t : ndarray, shape (m,)
    omega : ndarray, shape (m, 3)
    attitude : ndarray, shape (m, 4)

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid.animation.story import story_of
    >>> box = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
    >>> run = rigid.simulate(box, [0.01, 10.0, 0.01], t=np.linspace(0.0, 6.0, 361))
    >>> print(story_of(box, "box", run.t, run.omega, run.attitude))
    A box spins at 10 rad/s about its middle axis, and turns over 3 times in 6 s.
    """
    span = f"{abs(t[-1] - t[0]):.3g} s"
    if view == "cones":
        return "A symmetric body turns freely: its cone rolls on a cone that is at rest in space."
    if view == "poinsot":
        return "A body turns freely: its inertia ellipsoid rolls on a plane that is at rest."
    if view == "top":
        tilt = tilt_of(check_heavy_top(scene), attitude)
        least, most = _degrees(tilt.min()), _degrees(tilt.max())
        if least == most:
            return (
                f"A heavy top turns about the vertical: in all frames of {span} its tilt is {most}."
            )
        return (
            f"A heavy top starts at a tilt of {_degrees(tilt[0])}: in the frames of {span} its "
            f"tilt is between {least} and {most}."
        )
    what = "A body" if scene.body.sides is None else "A box"
    if scene.forces:
        return f"{what} turns for {span} under {forces_in_words(scene.forces)}."
    axis = _axis_of_spin(omega)
    if axis is None:
        return f"{what} turns freely for {span}: L is at rest in space, and ω moves."
    rate = f"{np.linalg.norm(omega[0]):.3g} rad/s"
    _, count = turns_over(scene, t, omega)
    over = f"turns over {_times(count)}" if count else "does not turn over"
    return f"{what} spins at {rate} about {_named(scene, axis)}, and {over} in {span}."


def story_of_two(scenes: tuple[Scene, Scene], t: Floats, omega: Floats, attitude: Floats) -> str:
    """What tells two motions apart, in words; the arrays have an axis of the two bodies first."""
    both = "Two motions side by side"
    if scenes[0] == scenes[1] and (attitude[0, 0] == attitude[1, 0]).all():
        if (omega[0, 0] == omega[1, 0]).all():
            return "The same motion on both sides."
        both = f"Two starts that differ by {np.linalg.norm(omega[1, 0] - omega[0, 0]):.3g} rad/s"
    if all(isinstance(scene, HeavyTop) for scene in scenes):
        left, right = (
            _degrees(tilt_of(check_heavy_top(scene), one).max())
            for scene, one in zip(scenes, attitude, strict=True)
        )
        tilts = f"the left top tilts up to {left}, the right top up to {right}"
        return f"{both}: in the frames {tilts}."
    axes = {_axis_of_spin(one) for one in omega}
    if any(scene.forces for scene in scenes) or len(axes) != 1 or None in axes:
        return f"{both}."
    if both.startswith("Two starts"):
        both = both.replace("starts", "throws")
    (first, flips), (second, others) = (
        turns_over(scene, t, one) for scene, one in zip(scenes, omega, strict=True)
    )
    what = "body" if scenes[0].body.sides is None else "box"
    if not flips and not others:
        return f"{both}: neither {what} turns over in {abs(t[-1] - t[0]):.3g} s."
    if flips and others:
        times = f"at {first:.2g} s, the right {what} at {second:.2g} s"
        return f"{both}: the left {what} turns over {times}."
    one, other = ("left", "right") if flips else ("right", "left")
    when = first if flips else second
    return f"{both}: the {one} {what} turns over at {when:.2g} s, the {other} {what} does not."


def tilt_of(scene: HeavyTop, attitude: Floats) -> Floats:
    """Angle in degrees between the vertical and the direction to the centre of mass."""
    axis = to_space(attitudes(attitude), np.array(scene.com))
    tilt: Floats = np.rad2deg(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))
    return tilt


def turns_over(scene: Scene, t: Floats, omega: Floats) -> tuple[float, int]:
    """When a free body first turns over, and how many times it does, by the closed form.

    A body turns over when the rate along the axis of its first spin changes its sign; the times
    of a film may be too far apart to show it.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid.animation.story import turns_over
    >>> box = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
    >>> run = rigid.simulate(box, [0.01, 10.0, 0.01], t=[0.0, 4.1])
    >>> first, count = turns_over(box, run.t, run.omega)
    >>> round(first, 3), count
    (1.202, 2)
    """
    span = float(t[-1] - t[0])
    # Backward in time a free body moves as with the opposite rates.
    start = omega[0] if span > 0.0 else -omega[0]
    axis = int(np.abs(start).argmax()) + 1
    first, second = flip_times(scene, start, axis=axis, count=2).tolist()
    at = float(t[0] + np.copysign(first, span))
    if first > abs(span):
        return at, 0
    return at, 1 + int((abs(span) - first) / (second - first))  # the times are equally spaced


def _axis_of_spin(omega: Floats) -> int | None:
    """The axis about which a motion begins to spin, if there is one."""
    axis = int(np.abs(omega[0]).argmax())
    return axis if abs(omega[0, axis]) > ALONG * np.linalg.norm(omega[0]) else None


def _named(scene: Scene, axis: int) -> str:
    moments = np.array(scene.body.moments)
    same = int((moments == moments[axis]).sum())
    if len(set(moments.tolist())) == 3:
        smaller = int((moments < moments[axis]).sum())
        return f"its {('longest', 'middle', 'shortest')[smaller]} axis"
    return f"axis {axis + 1}" if same > 1 else "its symmetry axis"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _degrees(angle: float) -> str:
    return f"{angle:.0f}°"
