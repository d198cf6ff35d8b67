"""Maps with a custom criterion, a function of the user: the interface of ``_core.MapJob``.

The core draws the starts and computes the states of a block of bodies; the custom criterion
classifies them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import Floats
from ..model.judged import Custom, States
from ..rotations.apply import to_body
from ..solve.closed_form import NO_FORM, closed_forms
from ..solve.methods import AUTO, EXACT, TO_ROUNDING, adaptive_methods
from ..solve.request import Request
from ..solve.status import Status
from .core_request import CoreRequest
from .grid import Pixels
from .spec import MapSpec

Ints = NDArray[np.int64]

ROWS = 2**16
"""Most states of a block of bodies: the states of a thread stay near its cache."""

TOLERANCE = 1e-7
"""Tolerance of adaptive steps by series, which compute states inside steps cheaply. The error is
1e-8 rad per radian, as by the steps of other maps. The tolerance of the second method is a
hundredth of it."""

_AGREED = np.array(_core.agreed_classes(), dtype=np.uint8)
"""The class of a body from the classes of its two runs."""

CLASSES = _core.class_names()
STABLE, UNSTABLE, UNDECIDED, FAILED = range(len(CLASSES))

UPWARD = np.array([0.0, 0.0, 1.0])
"""The vertical in space."""

_DRIFTS = ("energy_drift", "momentum_drift", "unit_drift")
_OF_BOTH_RUNS = ("checked", "steps_of_both", "errors")


def is_adaptive(spec: MapSpec, method: str) -> bool:
    """Whether the bodies of a map with a custom criterion take adaptive steps by this method."""
    is_second = method == TO_ROUNDING and method != spec.scheme
    known = method in adaptive_methods(spec.forces)
    return spec.step is None and known and (spec.method == AUTO or is_second)


class BlockedJob:
    """Bodies that are computed some at a time: the interface of ``_core.MapJob``.

    Attributes
    ----------
    status : ndarray of uint8
        The status of the moments of each row.
    """

    def __init__(self, status: NDArray[np.uint8], samples: int, measures: int, most: int) -> None:
        self.status = status
        self._samples, self._measures, self._most = samples, measures, most

    def _blocks(self, numbers: NDArray[Any]) -> Iterator[Ints]:
        """Some numbers of bodies at a time."""
        for begin in range(0, len(numbers), self._most):
            yield numbers[begin : begin + self._most].astype(np.int64)

    def _counted(
        self, flat: Ints, threads: int, interrupted: Callable[[], bool] | None
    ) -> dict[str, Any] | None:
        """The columns of a map with a row for each of these bodies; None if interrupted."""
        raise NotImplementedError

    def _found(self, flat: Ints, threads: int) -> dict[str, NDArray[Any]]:
        """As ``MapJob.outcomes``, of a block."""
        raise NotImplementedError

    def run(
        self,
        start: int,
        stop: int,
        threads: int,
        interrupted: Callable[[], bool] | None = None,
    ) -> dict[str, Any] | None:
        """As ``MapJob.run``."""
        first, last = start // self._samples, -(-stop // self._samples)
        statistics = _core.MapStatistics(last - first, self._measures)
        numbers = np.arange(start, stop)
        for flat in self._blocks(numbers[self.status[numbers // self._samples] == 0]):
            part = self._counted(flat, threads, interrupted)
            if part is None:
                return None
            statistics.merge({**part, "pixels": flat // self._samples - first})
        return {**statistics.arrays(), "measures": statistics.bins()}

    def outcomes(self, samples: NDArray[np.uint64], threads: int) -> dict[str, NDArray[Any]]:
        """As ``MapJob.outcomes``."""
        parts = [self._found(flat, threads) for flat in self._blocks(samples)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


class CustomJob(BlockedJob):
    """The request of a map with a custom criterion.

    Parameters
    ----------
    spec : MapSpec
    drawing : MapJob
        What draws the bodies and measures them.
    request : CoreRequest
        What it was asked.
    pixels : ndarray of int64
        Numbers of the pixels in the grid of the map.
    fixed : dict of str to float
        Values of further axes of the whole map.
    grid : Pixels
        The nominal starts of the rows.
    """

    def __init__(
        self,
        spec: MapSpec,
        drawing: _core.MapJob,
        request: CoreRequest,
        pixels: Ints,
        fixed: Mapping[str, float],
        grid: Pixels,
    ) -> None:
        assert isinstance(spec.stable, Custom)
        most = max(1, ROWS // len(spec.stable.times))
        super().__init__(drawing.status, request.samples, len(spec.measure), most)
        self._spec, self._drawing, self._request = spec, drawing, request
        self._stable, self._pixels, self._fixed = spec.stable, pixels, fixed
        self._grid = grid
        self._closed = np.zeros(len(grid.moments), dtype=np.bool_)
        if spec.method in (AUTO, EXACT) and not spec.forces:
            self._closed = closed_forms("states", grid.moments, grid.weight) != NO_FORM
        self.starts = drawing.starts

    def _counted(
        self, flat: Ints, threads: int, interrupted: Callable[[], bool] | None
    ) -> dict[str, Any] | None:
        if interrupted is not None and interrupted():
            return None
        # Of the threads of the core too, if there are any.
        clock = time.thread_time if threads == 1 else time.process_time
        began = clock()
        found = self._judged(flat, threads)
        statistics = _core.MapStatistics(len(flat), self._measures)
        rows = np.arange(len(flat), dtype=np.uint64)
        for k in range(self._measures):
            statistics.add(k, rows, found["measures"][:, k], found["errors"][:, k])
        counts = {
            **{name: found["class"] == code for code, name in enumerate(CLASSES)},
            "checked": found["checked"],
            "audited": found["checked"],
            "audited_undecided": found["checked"] & (found["class"] == UNDECIDED),
            "step_limit": found["status"] == Status.STEP_LIMIT,
            "not_finite": found["status"] == Status.NOT_FINITE,
            "drifted": found["status"] == Status.DRIFTED,
            "steps": found["steps_of_both"],
            "exact": found["exact"],
        }
        return {
            **statistics.arrays(),
            "measures": statistics.bins(),
            **{name: values.astype(np.int64) for name, values in counts.items()},
            # A drift of no number is one of a body that was not integrated.
            **{
                name: np.where(counts["not_finite"] & np.isnan(found[name]), np.inf, found[name])
                for name in _DRIFTS
            },
            "nanoseconds": np.full(len(flat), 1e9 * (clock() - began) / len(flat)),
        }

    def _found(self, flat: Ints, threads: int) -> dict[str, NDArray[Any]]:
        found = self._judged(flat, threads)
        return {
            **{name: values for name, values in found.items() if name not in _OF_BOTH_RUNS},
            "part_class": found["class"][:, np.newaxis],
            "part_left": found["left"][:, np.newaxis],
        }

    def _judged(self, flat: Ints, threads: int) -> dict[str, NDArray[Any]]:
        """The outcomes of bodies by their numbers, as arrays with one number for each body."""
        count, spec = len(flat), self._spec
        row, within = np.divmod(flat, self._request.samples)
        omega, attitude = self._drawing.starts(flat.astype(np.uint64))
        starts = omega.reshape(-1, 3), attitude.reshape(-1, 4)
        found: dict[str, NDArray[Any]] = {
            **_core.unknown_outcomes(count),
            "checked": np.zeros(count, dtype=np.bool_),
            "steps_of_both": np.zeros(count, dtype=np.int64),
            "measures": np.empty((count, 0)),
            "errors": np.empty((count, 0)),
        }
        possible = self.status[row] == 0
        begins, checked = self._request.first, self._request.checked
        number = within if begins is None else within + begins[row].astype(np.int64)
        for closed in (True, False):
            mine = np.flatnonzero(possible & (self._closed[row] == closed))
            if not len(mine):
                continue
            method = EXACT if closed else spec.scheme
            first = self._judge(method, mine, row, starts, threads, is_second=False)
            for name, values in first.items():
                found[name][mine] = values
            found["steps_of_both"][mine] = first["steps"]
            found["exact"][mine] = closed
            if closed:
                for name in _DRIFTS:
                    found[name][mine] = np.nan
                continue
            again = mine if checked is None else mine[number[mine] < checked]
            if not len(again):
                continue
            second = self._judge(spec.second, again, row, starts, threads, is_second=True)
            was_run = second["status"] != Status.STEP_LIMIT
            before = found["class"][again]
            both = _AGREED[before, second["class"]]
            found["class"][again] = np.where(was_run, both, before)
            found["checked"][again] = was_run
            found["steps_of_both"][again] += second["steps"]
        if spec.measure:
            self._measure(flat, found, threads)
        return found

    def _measure(self, flat: Ints, found: dict[str, NDArray[Any]], threads: int) -> None:
        """The values of the measures of bodies, with extra runs for the measures that need them."""
        both, steps = self._drawing.measured(flat.astype(np.uint64), threads)
        found["measures"], found["errors"] = both
        found["steps_of_both"] += steps.astype(np.int64)
        for place, one in enumerate(self._spec.measure):
            if one.name == "drift":
                worst = np.fmax.reduce([found[name] for name in _DRIFTS])
                found["measures"][:, place] = np.where(found["class"] == FAILED, np.nan, worst)

    def _judge(
        self,
        method: str,
        mine: NDArray[np.intp],
        row: Ints,
        starts: tuple[Floats, Floats],
        threads: int,
        *,
        is_second: bool,
    ) -> dict[str, NDArray[Any]]:
        """Classes, statuses, drifts and steps of some bodies by one method."""
        times, count = np.array(self._stable.times), len(mine)
        omega, attitude = (values[mine] for values in starts)
        bodies = self._grid.bodies(row[mine], omega, attitude)
        bodies = bodies.doubted() if is_second else bodies
        tolerance, steps = self._steps(method, bodies, times[-1], is_second=is_second)
        part = Request(
            bodies=bodies,
            times=times,
            method=method,
            record=self._stable.of,
            max_steps=self._spec.max_steps,
            threads=threads,
            tolerance=tolerance,
            steps=steps,
        ).states(_core.ELSEWHERE if is_second and steps is None else 1.0)
        drifts = {name: part[name] for name in _DRIFTS}
        status = part["status"].copy()
        has_drifted = np.fmax.reduce(list(drifts.values())) > _core.DRIFT_LIMIT
        status[(status == Status.OK) & has_drifted] = Status.DRIFTED
        out: dict[str, NDArray[Any]] = {
            "class": np.full(count, FAILED, dtype=np.uint8),
            "status": status,
            "steps": part["steps"].astype(np.int64),
            "step": np.full(count, np.nan) if steps is None else steps,
            **drifts,
        }
        kept = np.flatnonzero(status == Status.OK)
        if not len(kept):
            return out
        seen: dict[str, Any] = {
            name: None if part[name] is None else part[name][kept]
            for name in ("omega", "gamma", "attitude", "states")
        }
        if seen["gamma"] is None and seen["attitude"] is not None:
            # Of free bodies, whose motion needs none.
            seen["gamma"] = to_body(seen["attitude"], UPWARD)
        parameters = self._parameters(row[mine][kept])
        verdict = self._stable.verdicts(States(t=times, parameters=parameters, **seen))
        known = np.where(verdict > 0.0, STABLE, UNSTABLE)
        out["class"][kept] = np.where(np.isnan(verdict), UNDECIDED, known)
        return out

    def _steps(
        self, method: str, batch: Any, t_end: float, *, is_second: bool
    ) -> tuple[float | None, Floats | None]:
        """Tolerance, or steps (s), of a batch by a method."""
        spec = self._spec
        if method == EXACT:
            return None, None
        if is_adaptive(spec, method):
            return (0.01 * TOLERANCE if is_second else TOLERANCE), None
        own, _ = batch.planned_steps(method, (0.0, t_end), "states")
        if spec.step is None:
            return None, 0.5 * own if is_second and method == spec.scheme else own
        return None, np.minimum(own, 0.5 * spec.step) if is_second else np.full_like(own, spec.step)

    def _parameters(self, row: Ints) -> dict[str, Floats]:
        """Values of the axes and of what varies, in these rows."""
        values = self._spec.values(self._pixels[row])
        fixed = {name: np.full(len(row), value) for name, value in self._fixed.items()}
        drawn = {name: every[row] for name, every in self._grid.drawn.items()}
        return {**values, **fixed, **drawn}
