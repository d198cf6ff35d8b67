"""What is asked: the problem of the choice of a method, and the request to the core."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import finite_float, one_of
from .._checks.arrays import Floats
from .._checks.moments import without_spin
from ..model.batch import in_rows
from ..model.bodies import Bodies, Range, time_ranges
from ..model.scene import Scene
from .closed_form import closed_forms
from .methods import EXACT, check_method, run_methods

MutableMapping.register(_core.States)


USUAL_ACCURACY = 1e-8
"""The accuracy of states if neither a method nor a step is given."""

MOST_STEPS = 10**9
"""Most steps of a body, unless a call says others: some minutes."""

LEAST_TOLERANCE = _core.LEAST_UNDER_FUNCTION
"""The least tolerance of Runge-Kutta steps: the second run has a smaller tolerance."""


@dataclass(slots=True, kw_only=True, eq=False)
class Problem:
    """Requested states for which a method is to be chosen, and all that is known of them.

    Attributes
    ----------
    scene : Scene
    record : {"rates", "axis", "attitude"}
    bodies : Bodies or None
        The bodies with their starts, None if the starts are not known.
    times : ndarray, shape (m,) or (n, m), or None
        Output times (s), ascending; of all bodies or of each. None if they are not known.
    reach : Range or None
        First and last time (s) of the motion and 0, from which the steps follow: by default of the
        output times, which a user may change later. None if they are not known or needed.
    accuracy, step : float or None
        Largest error at the end; longest step (s). Only one of the two can be given.
    method : str or None
        The requested method.
    tolerance : float or None
        Tolerance of adaptive steps, which need no bound of the rates.
    states : int
        Number of requested states of a body: of the output times, if they are known.
    number : int or None
        How many share a call; None: as many as the bodies.
    inside : bool
        Whether the motion must be known inside its steps, as events ask for.
    max_steps : int
        A body that needs more is not run to its end.
    threads : int
    is_plain : bool
        Whether nothing but the closed form is asked for of bodies of one inertia without torque and
        damping, which have it from any start. Not so a top that may swing as a pendulum.

    Raises
    ------
    ValueError
        If the method is unknown or does not move the scene, if accuracy or step are not positive,
        or if both are given.
    """

    scene: Scene
    record: str
    bodies: Bodies | None = None
    times: Floats | None = None
    reach: Range | None = None
    accuracy: float | None = None
    method: str | None = None
    step: float | None = None
    tolerance: float | None = None
    states: int = 1
    number: int | None = None
    inside: bool = False
    max_steps: int = MOST_STEPS
    threads: int = 1
    is_plain: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        if self.method is not None:
            one_of("method", self.method, run_methods())
            check_method(self.method, self.scene.kind, watched=False, forces=self.scene.forces)
        if self.step is not None:
            self.step = finite_float("step", self.step, positive=True)
        if self.accuracy is not None:
            self.accuracy = finite_float("accuracy", self.accuracy, positive=True)
        if self.accuracy is not None and self.step is not None:
            raise ValueError(
                f"accuracy = {self.accuracy:g}, step = {self.step:g}: exclude each other, "
                "because the step follows from the accuracy"
            )
        if self.times is not None:
            self.states = self.times.shape[-1]
            self.is_plain = (
                self.method in (None, EXACT)
                and self.step is None
                and self.accuracy is None
                and self.tolerance is None
                and self.times.ndim == 1
                and self.scene.once(_has_closed_form)
            )
            if self.reach is None and (self.inside or not self.is_plain):
                self.reach = time_ranges(self.times)

    @property
    def span(self) -> float | Floats | None:
        """Time that the run covers (s), None if unknown."""
        return None if self.reach is None else self.reach[1] - self.reach[0]

    def select(self, some: NDArray[np.intp]) -> Self:
        """The problem of some of the bodies, as if they were alone."""
        scene, bodies = self.scene, self.bodies
        assert bodies is not None
        if scene.shape:
            every = np.arange(prod(scene.shape)).reshape(scene.shape)
            places = np.broadcast_to(every, bodies.shape).ravel()[some]
            scene = scene[np.unravel_index(places, scene.shape)]
        chosen = bodies.select(some)
        may_stop = chosen.forces is not None and scene.may_stop
        times = self.times if self.times is None or self.times.ndim == 1 else self.times[some]
        reach = self.reach
        if reach is not None and isinstance(reach[0], np.ndarray):
            reach = reach[0][some], reach[1][some]
        own = replace(chosen, may_stop=may_stop)
        number = None if self.number is None else round(self.number * len(some) / len(bodies))
        return replace(self, scene=scene, bodies=own, times=times, reach=reach, number=number)

    def inertia(self) -> tuple[Floats, Floats]:
        """Moments and weight of the bodies in rows, in any unit; one row may hold for all."""
        if self.bodies is not None:
            return self.bodies.moments, self.bodies.weight
        return _inertia(self.scene)

    def forces(self) -> _core.Forces | None:
        """What acts on the bodies, None if nothing does, in the unit of :meth:`inertia`."""
        return self.scene.acting() if self.bodies is None else self.bodies.forces

    def rates(self, method: str | None = None) -> Floats | None:
        """Bounds of the rates, or the rates that the steps of a method follow, if known."""
        if self.bodies is None or (self.span is None and self.scene.forces):
            return None
        return self.bodies.fastest_rates(self.reach or (0.0, 0.0), method)


def _has_closed_form(scene: Scene) -> bool:
    """Whether the scene is one body without torque and damping, with a closed form of any start."""
    if scene.shape or scene.forces:
        return False
    return bool(closed_forms("rates", *_inertia(scene)).all())


def _inertia(scene: Scene) -> tuple[Floats, Floats]:
    """Moments and ``mgl com`` of the bodies in rows; one row if all have the same."""
    moments = without_spin(np.asarray(scene.body.moments))
    return in_rows(moments, scene.shape), in_rows(scene.weight, scene.shape)


@dataclass(slots=True, eq=False)
class Request:
    """A call of the core for states of bodies at output times.

    Attributes
    ----------
    bodies : Bodies
    times : ndarray, shape (m,) or (n, m)
        Times of the states (s), ascending; of all bodies or of each.
    method : str
        ``"exact"`` or the name of another method.
    record : {"rates", "axis", "attitude", "tangent", "sensitivity"}
    max_steps : int
        A body that needs more is not run to its end.
    threads : int
    tolerance : float or None
        Tolerance of adaptive steps, for a Taylor method, and for ``dop853`` under a function.
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None leaves them to the core.
    strides : sequence of int, optional
        The states are those after these numbers of further steps of exactly the longest step.
    """

    bodies: Bodies
    times: Floats
    method: str
    record: str
    max_steps: int
    threads: int
    tolerance: float | None = None
    steps: Floats | None = None
    strides: Sequence[int] | None = None

    def states(
        self,
        refinement: float = 1.0,
        *,
        deviations: Floats | None = None,
        changes: Floats | None = None,
        out: Mapping[str, NDArray[Any]] | None = None,
        single: bool = False,
    ) -> _core.States:
        """The states.

        Between two output times a body takes ``refinement`` times the steps, rounded up. Columns of
        ``out``, of shape (n, m, k), are written where they are; other columns of rows are new, in
        single precision if requested. Deviation vectors are recorded instead of the states if the
        record is ``"tangent"``, from those at the start, (n, 6), or ``"sensitivity"``, by changes
        of parameters, (n, 15).
        """
        found = _core.simulate(self, self.steps, refinement, deviations, changes, out, single)
        return self._cut(found)

    def solve(
        self,
        accuracy: float | None,
        *,
        check: bool,
        free: bool = False,
        out: Mapping[str, NDArray[Any]] | None = None,
    ) -> _core.States:
        """The states by steps, as accurate as asked for, with ``error`` and ``lost_from``.

        Parameters
        ----------
        accuracy : float or None
            Largest error: tolerance or steps of a body are made smaller until its estimated error
            is smaller. None for a tolerance or a step that the user chose.
        check : bool
            Whether errors are estimated; without it there is one run.
        free : bool
            Whether no method was given: a series follows where equal steps are not accurate. The
            column ``by_series`` says of which bodies, if of any.
        out : mapping, optional
            Arrays for columns, in double precision.
        """
        return self._cut(_core.solve(self, self.steps, accuracy, check, free, out))

    def _cut(self, states: _core.States) -> _core.States:
        """The states without columns of states of a function beyond those that there are."""
        forces = self.bodies.forces
        if forces is not None and forces.states and states["states"] is not None:
            states["states"] = states["states"][..., : forces.states].copy()
        return states

    def select(self, some: NDArray[np.intp]) -> Self:
        """The request for some of the bodies."""
        times = self.times if self.times.ndim == 1 else self.times[some]
        steps = None if self.steps is None else self.steps[some]
        return replace(self, bodies=self.bodies.select(some), times=times, steps=steps)
