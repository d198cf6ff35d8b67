"""The motion of one body as plain data and words, for a film."""

from __future__ import annotations

import numpy as np

from .. import _core
from .._checks.arrays import Floats
from ..animation.story import Recording
from ..model.bodies import bodies_of
from ..model.forces import forces_in_words
from ..model.scene import FreeBody, Scene
from ..rotations.apply import to_space


def recording_of(
    scene: Scene, t: Floats, omega: Floats, attitude: Floats, frame: Floats | None
) -> Recording:
    """The motion of one body.

    Parameters
    ----------
    scene : Scene
        The scene of the body alone.
    t : ndarray, shape (m,)
        Times (s).
    omega, attitude : ndarray, shape (m, 3) and (m, 4)
        States along principal axes.
    frame : ndarray, shape (3, 3), or None
        The axes of a mesh of the body, as :attr:`rigid.Run.frame`.
    """
    is_free = isinstance(scene, FreeBody) and not scene.forces and len(t) > 1 and omega[0].any()
    flip, flips = turns_over(scene, t, omega) if is_free else (np.inf, 0)
    rotor = scene.momentum_of_rotor(t)
    return Recording(
        scene=scene.to_dict(),
        title=scene.words(),
        forces=scene.forces,
        acting=forces_in_words(scene.forces) if scene.forces else "",
        under=_under(scene, t),
        t=t,
        omega=omega,
        attitude=attitude,
        momentum=to_space(attitude, np.array(scene.body.moments) * omega + rotor),
        orbit=None if scene.orbit is None else scene.orbit.frame(t),
        frame=frame,
        flip=flip,
        flips=flips,
    )


def _under(scene: Scene, t: Floats) -> str:
    """Where a body is while it turns, and what acts on it, as the end of a sentence."""
    if scene.orbit is None:
        return f" under {forces_in_words(scene.forces)}" if scene.forces else ""
    others = [name for name in scene.forces if name != "orbit"]
    place = scene.orbit.passage(t[0], t[-1])
    return f" {place}" + (
        f", under the gravity gradient and {forces_in_words(others)}" if others else ""
    )


def turns_over(scene: Scene, t: Floats, omega: Floats) -> tuple[float, int]:
    """When a free body first turns over, and how many times it does, by the closed form.

    A body turns over when the rate along the axis of its first spin changes its sign; the times
    of a film may be too far apart to show it.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> from rigid.solve.recording import turns_over
    >>> box = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
    >>> run = rigid.simulate(box, [0.01, 10.0, 0.01], t=[0.0, 4.1])
    >>> first, count = turns_over(box, run.t, run.omega)
    >>> round(first, 3), count
    (1.202, 2)
    """
    span = float(t[-1] - t[0])
    axis = int(np.abs(omega[0]).argmax()) + 1
    bodies = bodies_of(scene, omega[0], None, rod=True)
    first, second = bodies.in_axes(_core.flip_times(bodies, axis, 2)).tolist()
    at = float(t[0]) + first
    if first > span:
        return at, 0
    return at, 1 + int((span - first) / (second - first))  # the times are equally spaced
