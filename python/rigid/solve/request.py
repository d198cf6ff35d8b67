"""A request to the core: bodies, times, method, record and limits."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .bodies import Bodies

MutableMapping.register(_core.States)


Floats = NDArray[np.float64]


@dataclass(slots=True, kw_only=True, eq=False)
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
    strides: Sequence[int] | None = None

    def states(
        self,
        steps: Floats | None,
        refinement: float = 1.0,
        *,
        deviations: Floats | None = None,
        changes: Floats | None = None,
        out: Mapping[str, NDArray[Any]] | None = None,
        single: bool = False,
    ) -> _core.States:
        """The states, each body with its longest step (s); None leaves the steps to the core.

        Between two output times a body takes ``refinement`` times the steps, rounded up. Columns of
        ``out``, of shape (n, m, k), are written where they are; other columns of rows are new, in
        single precision if requested. Deviation vectors are recorded instead of the states if the
        record is ``"tangent"``, from those at the start, (n, 6), or ``"sensitivity"``, by changes
        of parameters, (n, 15).
        """
        return _core.simulate(self, steps, refinement, deviations, changes, out, single)

    def solve(
        self,
        steps: Floats | None,
        accuracy: float | None,
        *,
        check: bool,
        free: bool = False,
        out: Mapping[str, NDArray[Any]] | None = None,
    ) -> _core.States:
        """The states by steps, as accurate as asked for, with ``error`` and ``lost_from``.

        Parameters
        ----------
        steps : ndarray, shape (n,), or None
            The longest step of each body (s); None leaves them to the core.
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
        return _core.solve(self, steps, accuracy, check, free, out)

    def select(self, some: NDArray[np.intp]) -> Self:
        """The request for some of the bodies."""
        times = self.times if self.times.ndim == 1 else self.times[some]
        return replace(self, bodies=self.bodies.select(some), times=times)
