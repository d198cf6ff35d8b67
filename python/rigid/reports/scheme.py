"""A user's own scheme, which a report measures beside the methods of the library."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._checks.arrays import Floats
from ..model.bodies import bodies_of
from ..model.scene import Scene
from ..rotations.apply import to_body
from ..solve.conserved import energy_of, momentum_of
from ..solve.plan import Lazy, Plan
from ..solve.request import Problem
from ..solve.run import Run, to_run
from ..solve.solution import Solution
from ..solve.status import Status


@dataclass(frozen=True, slots=True)
class Scheme:
    """An own scheme with its name; made by :func:`rigid.scheme`.

    Attributes
    ----------
    name : str
        The name in tables and pictures.
    function : callable
        What moves the bodies.
    """

    name: str
    function: Callable[..., Any]

    def run(
        self, scene: Scene, omega: Floats, attitude: Sequence[float], step: float, at: Sequence[int]
    ) -> Run:
        """The states of n bodies after these numbers of steps, ascending.

        Drifts of energy and momentum are NaN under forces: the work is not known.
        """
        count, times = len(omega), step * np.array(at, dtype=np.float64)
        now: list[NDArray[Any]] = [omega.copy(), np.tile(attitude, (count, 1))]
        kept = [np.empty((count, len(at), width)) for width in (3, 4)]
        spent, before = 0, 0
        for k, steps in enumerate(at):
            if steps > before:
                begun = time.process_time_ns(), time.thread_time_ns()
                with np.errstate(all="ignore"):  # with long steps bodies fly apart
                    made = self.function(scene, step * before, *now, step, steps - before)
                # Where the time of the process is limited its clock may tick every 4 ms only.
                process, thread = time.process_time_ns(), time.thread_time_ns()
                spent += max(process - begun[0], thread - begun[1])
                now, before = self._checked(made, count), steps
            for column, one in zip(kept, now, strict=True):
                column[:, k] = one
        energy_drift, momentum_drift = _drifts(scene, omega, attitude, *kept)
        arrived = np.isfinite(kept[0]).all(axis=(1, 2)) & np.isfinite(kept[1]).all(axis=(1, 2))
        states: dict[str, Any] = {
            "omega": kept[0],
            "attitude": kept[1],
            "energy_drift": energy_drift,
            "momentum_drift": momentum_drift,
            "status": np.where(arrived, Status.OK, Status.NOT_FINITE).astype(np.uint8),
            "steps": np.full(count, before, dtype=np.uint64),
            "nanoseconds": spent,
        }
        bodies = bodies_of(scene, omega, attitude)
        problem = Problem(scene=scene, record="attitude", bodies=bodies, times=times)
        return to_run(problem, Solution(states, self.name, None, Lazy(_no_plan)), times)

    def _checked(self, made: object, count: int) -> list[NDArray[Any]]:
        """What the function returned: rates and attitudes."""
        if isinstance(made, Sequence) and len(made) == 2:
            arrays = [np.asarray(one) for one in made]
            if [one.shape for one in arrays] == [(count, 3), (count, 4)]:
                return arrays
        raise TypeError(
            f"{self.name}: must return rates and attitudes of shapes ({count}, 3) and "
            f"({count}, 4), got {brief(made)}"
        )


def scheme(name: str, function: Callable[..., Any]) -> Scheme:
    """An own step or solver, for ``methods=`` of :func:`rigid.report`.

    It is measured as the methods of the library are: the same bodies, reference and steps, on the
    same axes. Its time is all processor time of the process in ``function``. A short call before
    the first measured one compiles what compiles itself.

    Parameters
    ----------
    name : str
        A name that no method of the library has.
    function : callable
        ``function(scene, t, omega, attitude, step, count)`` moves n bodies from the time ``t`` by
        ``count`` steps of length ``step`` (s). It gets their rates, (n, 3), and quaternions, scalar
        first, body to space, (n, 4), and returns both at the end. It may write to what it gets.
        The ``scene`` has moments, weight and forces. A ``ValueError`` says that it does not move
        the scene, or is unstable with so long a step.

    Returns
    -------
    Scheme

    Raises
    ------
    TypeError
        If the name is no text, or the function cannot be called.

    Examples
    --------
    Euler's method for a free body, beside the fourth order:

    >>> import numpy as np, rigid
    >>> def euler(scene, t, omega, attitude, step, count):
    ...     i = np.array(scene.body.moments)
    ...     for _ in range(count):
    ...         rotation = np.insert(0.5 * step * omega, 0, 1.0, axis=1)
    ...         omega = omega + step * np.cross(i * omega, omega) / i
    ...         attitude = rigid.rotations.quaternion_product(attitude, rotation)
    ...         attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    ...     return omega, attitude
    >>> result = rigid.report(
    ...     rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t_end=1.0, bodies=4, errors=[1e-2],
    ...     methods=["rk4", rigid.scheme("euler", euler)], seconds=5.0,
    ... )
    >>> round(result.order("euler"))
    1
    """
    if not isinstance(name, str) or not name.strip():
        raise TypeError(f"name = {brief(name)}: must be a name")
    if not callable(function):
        raise TypeError(f"function = {brief(function)}: must be callable")
    return Scheme(name, function)


def _no_plan() -> Plan:
    raise AttributeError("an own scheme has no plan")


def _drifts(
    scene: Scene, omega: Floats, attitude: Sequence[float], rates: Floats, attitudes: Floats
) -> tuple[Floats, Floats]:
    """Largest errors of energy and momentum of each body, as :class:`rigid.Run` scales them."""
    count = len(omega)
    if scene.forces:
        return np.full(count, np.nan), np.full(count, np.nan)
    weight = float(np.linalg.norm(scene.weight))

    def invariants(q: Floats, w: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        unit = q / np.linalg.norm(q, axis=-1, keepdims=True)
        gamma = to_body(unit, np.broadcast_to([0.0, 0.0, 1.0], w.shape))
        momentum = momentum_of(scene, (count,), w, np.zeros(1))
        size = np.linalg.norm(momentum, axis=-1)
        conserved = np.vecdot(momentum, gamma) if weight else size
        return energy_of(scene, (count,), w, gamma), conserved, np.vecdot(momentum, w) / 2.0, size

    with np.errstate(all="ignore"):  # some fly apart, and some are at rest
        start, now = (
            invariants(np.tile(attitude, (count, 1, 1)), omega[:, np.newaxis]),
            invariants(attitudes, rates),
        )
        *_, kinetic, size = start
        scales = kinetic + weight, size + sqrt(weight * max(scene.body.moments))
        errors = [np.abs(now[k] - start[k]) / scales[k] for k in range(2)]
    return errors[0].max(axis=1), errors[1].max(axis=1)
