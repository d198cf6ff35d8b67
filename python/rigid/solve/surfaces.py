"""The points at which bodies cross surfaces, with the errors of their times, from the core."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from .._checks.arrays import Floats
from .._core import MOST_STATES
from ..model.compiling import Callback, of_state, taken_by
from ..model.events import Event
from ..model.frame import turned
from ..model.function import require_orbit
from ..model.sampled import RotorTable
from ..model.scene import Scene
from .methods import EXACT, FUNCTION, SERIES
from .request import Problem

FUNCTION_TOLERANCE = 1e-12
"""The tolerance with a callback: the error of a Runge-Kutta step, and of its polynomial.

The second run needs a smaller one that is not rounding."""


def default_method(forces: Collection[str]) -> str:
    """The method that finds points under these forces."""
    return FUNCTION if "function" in forces else SERIES


def default_tolerance(forces: Collection[str]) -> float:
    """The tolerance of the method that finds points under these forces."""
    return FUNCTION_TOLERANCE if "function" in forces else _core.CROSSING_TOLERANCE


class Watched(NamedTuple):
    """Events to find: which of them are counted, and how many of these end the record of a body."""

    events: tuple[Event, ...]
    counted: tuple[bool, ...]
    number: int | None
    frame: Floats | None = None


def found_points(
    problem: Problem, watched: Watched, method: str, *, check: bool, normals: Floats | None = None
) -> dict[str, Any]:
    """The points of the events of a problem, which is solved by a method, as columns of the core.

    A closed form gives the state at the begin of each step of a Taylor series; without one, or
    under damping, the series goes on from step to step.

    Parameters
    ----------
    problem : Problem
    watched : Watched
    method : str
        ``"exact"``, or a method that is known inside its steps.
    check : bool
        Whether a second run tells errors. Without it the ``error`` of each point and the time
        ``lost_from`` of each body are NaN, unless a closed form gives them.
    normals : ndarray, shape (n, kinds, 6), optional
        What rates and vertical are multiplied by in each body, in place of the events' own.
    """
    scene, bodies, (events, counted, number, frame) = problem.scene, problem.bodies, watched
    assert bodies is not None
    assert problem.reach is not None
    n, tolerance = len(bodies), problem.tolerance
    if normals is None:
        normals = np.array([[event.omega, event.gamma] for event in events])
        normals = normals if frame is None else turned(frame.T, normals)
        normals = normals.reshape(-1, 6)
    momentum = np.array([event.momentum for event in events])
    if momentum.any() and isinstance(scene.rotor, RotorTable):
        raise ValueError(
            f"rotor = {scene.rotor!r}: the momentum of a rotor by a table is not watched; take the "
            "rates, or look at run.momentum()"
        )
    surfaces = np.zeros((n, len(events), 11 + MOST_STATES))
    surfaces[..., :6] = normals
    # Moments are counted in this unit.
    surfaces[..., 6:9] = np.ldexp(momentum, bodies.scale_exponent[:, np.newaxis, np.newaxis])
    surfaces[..., 9] = [event.square for event in events]
    surfaces[..., -1] = [event.level for event in events]
    kinds, callbacks = [], [_callback(event, scene, frame) for event in events]
    for k, (event, counts, called) in enumerate(zip(events, counted, callbacks, strict=True)):
        if event.state > scene.states:
            raise ValueError(
                f"name = {event.name!r}: the scene has {scene.states} states of Torque.call"
            )
        if event.state:
            surfaces[:, k, 9 + event.state] = 1.0
        *pairs, in_orbit = event.pointing(scene, frame)
        pointing = np.reshape(pairs, (2, 2, 3)), in_orbit != 0.0
        function = (0, False) if called is None else (called.address, called.of_eight)
        kinds.append((event.turns, event.direction, counts, *pointing, function))
    return _core.section(
        bodies,
        method=SERIES if method == EXACT else method,
        kinds=kinds,
        surfaces=surfaces.reshape(-1, 11 + MOST_STATES),
        ends=np.broadcast_to(problem.reach[1], (n,)).astype(np.float64),
        count=2**63 - 1 if number is None else number,
        closed=method == EXACT and bodies.forces is None,
        check=check,
        tolerance=default_tolerance(scene.forces) if tolerance is None else tolerance,
        max_steps=problem.max_steps,
        threads=problem.threads,
    )


def _callback(event: Event, scene: Scene, frame: Floats | None) -> Callback | None:
    """The function of an event for the bodies of a scene, if it has one."""
    function = event.function
    if function is None:
        if event.name.endswith("()"):
            raise ValueError(f"events: no file has the function {event.name}; give it again")
        return None
    if frame is not None:
        raise ValueError(
            "frame: the function of an event is told principal axes; turn its arguments in the "
            "function, and leave the frame out"
        )
    takes_states, asks_place = taken_by(function)
    if takes_states and not scene.states:
        raise ValueError(f"states: {event.name} takes them; give Torque.call(..., states=k)")
    if asks_place:
        require_orbit(event.name, scene.orbit)
    return of_state(function, scene.states)
