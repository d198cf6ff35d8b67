"""A run at other output times: its motion is computed again, by the same method."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import resolve_threads
from .._checks.arrays import finite_array
from ..model.scene import scene_from_dict
from .arrays import Range, in_rows, time_ranges
from .bodies import Bodies
from .lazy import Lazy
from .made_run import end_records, to_run
from .methods import EXACT
from .problem import Problem
from .request import Request
from .run import Run
from .solution import solve
from .target import COLUMNS

__all__ = ["states_at"]


def states_at(run: Run, t: ArrayLike) -> Run:
    """The run at other output times; see :meth:`Run.at`."""
    shape, given = run.status.shape, np.atleast_1d(finite_array("t", t))
    if given.ndim > 1 and given.shape[:-1] != shape:
        raise ValueError(
            f"t: expected shape (k,) or {(*shape, 'k')} for bodies of shape {shape}, "
            f"got {given.shape}"
        )
    order = np.argsort(given, axis=-1, kind="stable")
    ascending = np.take_along_axis(given, order, axis=-1)
    reached = time_ranges(run.t if run.t.ndim == 1 else in_rows(run.t, shape))
    times = ascending if given.ndim == 1 else in_rows(ascending, shape)
    _check_inside(times, reached)
    spec = {name: value for name, value in run.spec.items() if name != "frame"}
    scene = scene_from_dict(spec["scene"])
    if "function" in scene.forces:
        raise ValueError(
            "t: a run under a function keeps no function; give these times to rigid.simulate"
        )
    bodies = Bodies.of_scene(scene, run.start_omega, run.start_attitude, shape)
    last = np.array([[np.inf]]) if run.end is None else np.reshape(run.end, (-1, 1))
    request = Request(
        bodies=bodies,
        times=np.minimum(times, last) if (times > last).any() else times,
        method=EXACT,
        record=spec["record"],
        max_steps=10**9,
        threads=resolve_threads(None),
    )
    accuracy, named = spec["accuracy"], spec["asked"] is not None
    problem = Problem(
        scene=scene,
        record=spec["record"],
        bodies=bodies,
        begin=reached[0],
        end=reached[1],
        accuracy=accuracy,
        method=spec["asked"],
        step=spec["step"],
        tolerance=spec["tolerance"] if named and accuracy is None else None,
        states=times.shape[-1],
        inside=bool(run.events),
    )
    check = accuracy is not None or not np.isnan(run.error).all()
    solution = solve(scene, problem, request, check=check)
    states, estimate = solution.states, solution.estimate
    end_records(states, times, last)
    made = to_run(states, ascending, estimate, accuracy, Lazy.of(spec), run._plan, bodies)
    if (order[..., 1:] < order[..., :-1]).any():
        made = _in_order(made, given, order)
    return made if run.frame is None else made.in_frame(run.frame)


def _check_inside(times: NDArray[np.float64], reached: Range) -> None:
    """Raise ValueError for a time outside the run."""
    first, last = (np.reshape(bound, (-1, 1)) for bound in reached)
    outside = np.argwhere((times < first) | (times > last))
    if len(outside):
        body = outside[0, 0] if len(first) > 1 else 0
        raise ValueError(
            f"t = {np.atleast_2d(times)[tuple(outside[0])]}: must be inside the run, which is from "
            f"t = {first[body, 0]} to {last[body, 0]}"
        )


def _in_order(run: Run, times: NDArray[np.float64], order: NDArray[np.intp]) -> Run:
    """The states of ascending times, in the order of the requested times."""
    place = np.argsort(order, axis=-1)

    def moved(array: NDArray[Any] | None, width: int) -> NDArray[Any] | None:
        if array is None:
            return None
        axis = array.ndim - 1 - (width > 1)
        shape = (*place.shape, 1) if width > 1 else place.shape
        index = place.reshape((1,) * (array.ndim - len(shape)) + shape)
        return np.take_along_axis(array, index, axis=axis)

    states = {name: moved(getattr(run, name), width) for name, width in COLUMNS.items()}
    return run.with_arrays(**states, t=times)
