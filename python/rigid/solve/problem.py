"""The problem of the choice of a method: states of a scene at output times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from typing import Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import finite_float
from ..model.scene import Scene
from .arrays import Range
from .bodies import Bodies
from .closed_form import moment_rows, weight_rows
from .methods import check_method, known_method, run_methods

Floats = NDArray[np.float64]

USUAL_ACCURACY = 1e-8
"""The accuracy of states if neither a method nor a step is given."""

LEAST_TOLERANCE = _core.LEAST_UNDER_FUNCTION
"""The least tolerance of Runge-Kutta steps: the second run has a smaller tolerance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """Requested states for which a method is to be chosen, and all that is known of them.

    Attributes
    ----------
    scene : Scene
    record : {"rates", "axis", "attitude"}
    bodies : Bodies or None
        The bodies with their starts, None if the starts are not known.
    begin : float or ndarray, shape (n,)
        First time of the run (s), not positive; of all bodies or of each.
    end : float, ndarray of shape (n,), or None
        Last time of the run (s), None if it is not known.
    accuracy, step : float or None
        Largest error at the end; longest step (s). Only one of the two can be given.
    method : str or None
        The requested method.
    tolerance : float or None
        Tolerance of adaptive steps, which need no bound of the rates.
    states : int
        Number of requested states of a body.
    number : int or None
        How many share a call; None: as many as the bodies.
    inside : bool
        Whether the motion must be known inside its steps, as events ask for.

    Raises
    ------
    ValueError
        If the method is unknown or does not move the scene, if accuracy or step are not positive,
        or if both are given.
    """

    scene: Scene
    record: str
    bodies: Bodies | None = None
    begin: float | Floats = 0.0
    end: float | Floats | None = None
    accuracy: float | None = None
    method: str | None = None
    step: float | None = None
    tolerance: float | None = None
    states: int = 1
    number: int | None = None
    inside: bool = False

    def __post_init__(self) -> None:
        if self.method is not None:
            known_method("method", self.method, run_methods())
            check_method(
                self.method,
                self.scene.kind,
                watched=False,
                forces=self.scene.forces,
            )
        for name in ("step", "accuracy"):
            if getattr(self, name) is not None:
                value = finite_float(name, getattr(self, name), positive=True)
                object.__setattr__(self, name, value)
        if self.accuracy is not None and self.step is not None:
            raise ValueError(
                f"accuracy = {self.accuracy:g}, step = {self.step:g}: exclude each other, "
                "because the step follows from the accuracy"
            )

    @property
    def times(self) -> Range:
        """First and last time of the run (s)."""
        begin, end = self.begin, 0.0 if self.end is None else self.end
        if isinstance(begin, float) and isinstance(end, float):
            return begin, end
        first, last = np.broadcast_arrays(begin, end)
        return first, last

    @property
    def span(self) -> float | Floats | None:
        """Time that the run covers (s), None if unknown."""
        return None if self.end is None else self.end - self.begin

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
        begin = self.begin[some] if isinstance(self.begin, np.ndarray) else self.begin
        end = self.end[some] if isinstance(self.end, np.ndarray) else self.end
        own = replace(chosen, may_stop=may_stop)
        number = None if self.number is None else round(self.number * len(some) / len(bodies))
        return replace(self, scene=scene, bodies=own, begin=begin, end=end, number=number)

    def inertia(self) -> tuple[Floats, Floats]:
        """Moments and weight of the bodies in rows, in any unit; one row may hold for all."""
        if self.bodies is not None:
            return self.bodies.moments, self.bodies.weight
        return moment_rows(self.scene), weight_rows(self.scene)

    @property
    def knows_angles(self) -> bool:
        """Whether rates and horizon are known, and so the angles that the bodies turn."""
        return self.bodies is not None and self.span is not None

    def rates(self, method: str | None = None) -> Floats | None:
        """Bounds of the rates, or the rates that the steps of a method follow, if known."""
        if self.bodies is None or (self.span is None and self.scene.forces):
            return None
        return self.bodies.fastest_rates(self.times, method)
