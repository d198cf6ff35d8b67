"""The stress suite: every method on extreme and stiff bodies, each result checked."""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from .. import _core
from .._checks.arguments import one_of
from .._checks.arrays import Floats
from .._checks.progress import ProgressOption, reporting
from .._checks.shown import aligned, counted, wrapped
from ..drawing.figure import html_text
from ..model.bodies import bodies_of
from ..solve.methods import EXACT, run_methods
from ..solve.run import Run
from ..solve.simulate import simulate
from ..solve.status import Status
from .stress_cases import Case, cases

ACCURACY = 1e-8
"""The requested accuracy of each run, which is also the largest error of a right result."""

MAX_STEPS = 50_000
"""Largest number of steps of a run, so that the suite ends within a minute."""

UNDETECTED_ERROR = "undetected error"
"""The class of a result with too large an error and without a flag: an undetected failure."""

UNIT_ROUNDOFF = 2.0**-53


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """The result of a method for a case.

    Attributes
    ----------
    case : Case
    method : str
    error : float
        Distance from the truth: of the rates relative to the fastest, of the attitude in rad. NaN
        if there is no state or no reference.
    bound : float
        Largest error of a right result: 1e-8, or the change caused by rounding of the start; with a
        given step, the estimated error of the run.
    verdict : str
        ``"right"``; ``"flagged"``; ``"step limit"``, ``"not finite"``, ``"drifted"``: the status;
        ``"refused"``; ``"unknown"``: there is no reference; ``"undetected error"``: the error is
        too large and the result is not flagged.
    reason : str
        The status or the message of the error.
    seconds : float
        Wall time of the run and of its check.
    """

    case: Case
    method: str
    error: float
    bound: float
    verdict: str
    reason: str
    seconds: float


@dataclass(frozen=True, slots=True)
class Extremes:
    """The result of :func:`extremes`: a cell for each case and method that applies to its scene."""

    cells: tuple[Cell, ...]

    @property
    def wrong(self) -> tuple[Cell, ...]:
        """Undetected failures: results with too large an error and without a flag."""
        return tuple(cell for cell in self.cells if cell.verdict == UNDETECTED_ERROR)

    def __repr__(self) -> str:
        return f"<Extremes: {self.conclusion()}>"

    def _repr_html_(self) -> str:
        return html_text(str(self))

    def counts(self) -> dict[str, int]:
        """Number of cells in each class."""
        verdicts = [cell.verdict for cell in self.cells]
        return {verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)}

    def __str__(self) -> str:
        """A table: a row for each case with the classes of its results, and the counts below."""
        rows: list[tuple[str, ...]] = [("case", "right", "worst error", "s", "other runs")]
        family = ""
        for case in dict.fromkeys(id(cell.case) for cell in self.cells):
            mine = [cell for cell in self.cells if id(cell.case) == case]
            if mine[0].case.family != family:
                family = mine[0].case.family
                rows.append((family, *[""] * 4))
            rows.append(_row(mine))
        lines = aligned(rows, right=range(1, 4))
        last = lines[0].index(rows[0][-1])
        table = [wrapped(line, indent=last) for line in lines]
        return "\n".join([*table, "", wrapped(self.conclusion(), indent=2)])

    def conclusion(self) -> str:
        """The last line: how many undetected errors there are, and what the other runs say."""
        counts = self.counts()
        wrong = counts.pop(UNDETECTED_ERROR, 0)
        others = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        errors = counted(wrong, "undetected error") if wrong else "no undetected error"
        runs = counted(len(self.cells), "run")
        return f"{errors} in {runs}{f': {others}' if others else ''}"


def _row(cells: list[Cell]) -> tuple[str, ...]:
    verdicts = [cell.verdict for cell in cells]
    right = [cell.error for cell in cells if cell.verdict == "right"]
    others = sorted(v for v in verdicts if v != "right")
    return (
        f"  {cells[0].case.name}",
        str(len(right)),
        f"{max(right):.0e}" if right else "",
        f"{sum(cell.seconds for cell in cells):.1f}",
        ", ".join(f"{others.count(v)} {v}" for v in dict.fromkeys(others)),
    )


def extremes(
    family: str | None = None, *, method: str | None = None, progress: ProgressOption = None
) -> Extremes:
    """Run every extreme case by every method that integrates its scene, and check the results.

    The requested accuracy of each run is 1e-8. The reference of bodies with a closed form was
    computed with 1000 bits; the reference of damped cubes is a formula, and all other references
    are runs by ``taylor26`` converged to 1e-9.

    Parameters
    ----------
    family : str, optional
        Only the cases of this family; see :func:`cases`.
    method : str, optional
        Only this method.
    progress : bool or callable, optional
        As of :func:`stability_map`.

    Returns
    -------
    Extremes

    Raises
    ------
    ValueError
        If there is no such family or method.

    Examples
    --------
    >>> import rigid
    >>> found = rigid.extremes("near spherical", method="exact", progress=False)
    >>> len(found.wrong)
    0
    """
    wanted = [case for case in cases() if family in (None, case.family)]
    if not wanted:
        one_of("family", family, dict.fromkeys(case.family for case in cases()))
    names = run_methods()
    if method is not None:
        one_of("method", method, names)
    cells: list[Cell] = []
    with reporting(progress, len(wanted), unit=" cases") as report:
        for done, case in enumerate(wanted, start=1):
            truth = _truth(case)
            for name in [method] if method else names:
                cells.append(_cell(case, name, truth))
            report(done)
    return Extremes(tuple(cells))


def _cell(case: Case, method: str, truth: _Truth | None) -> Cell:
    """The result of a method for a case."""
    begin = time.perf_counter()
    steps = {"accuracy": ACCURACY} if case.step is None else {"step": case.step}
    how = {} if method == EXACT else steps
    run: Run | None = None
    try:
        run = _simulated(case, method=method, max_steps=MAX_STEPS, **how)
        reason = run.reasons()[0]
    except ValueError as error:
        reason = str(error)
    seconds = time.perf_counter() - begin
    verdict = _verdict(case, run, truth)
    return Cell(case=case, method=method, reason=reason, seconds=seconds, **verdict)


def _simulated(case: Case, **how: Any) -> Run:
    return simulate(case.scene, case.omega, case.attitude, t=[case.t], threads=1, **how)


@dataclass(frozen=True, slots=True)
class _Truth:
    """A state, and the factor by which the motion magnifies relative changes of its start."""

    omega: Floats
    attitude: Floats
    condition: float


@cache
def _exact_states() -> dict[str, dict[str, dict[str, Any]]]:
    """The reference states that ``tests/golden/make_extremes.py`` computed with 1000 bits."""
    text = resources.files("rigid").joinpath("builtin/extremes.json").read_text(encoding="utf-8")
    found: dict[str, dict[str, dict[str, Any]]] = json.loads(text)
    return found


def _truth(case: Case) -> _Truth | None:
    """The state at the end, if it is known."""
    if case.truth is not None:
        return _Truth(*case.truth, condition=0.0)
    known = _exact_states().get(case.family, {}).get(case.name)
    if known is not None:
        return _Truth(np.array(known["omega"]), np.array(known["attitude"]), known["condition"])
    try:
        run = _simulated(case, method="taylor26", accuracy=1e-9, max_steps=20 * MAX_STEPS)
    except ValueError:
        return None
    if run.attitude is None or run.status != Status.OK:
        return None
    return _Truth(run.omega[-1], run.attitude[-1], condition=0.0)


def _verdict(case: Case, run: Run | None, truth: _Truth | None) -> dict[str, Any]:
    bound = ACCURACY if truth is None else max(ACCURACY, 4.0 * UNIT_ROUNDOFF * truth.condition)
    if run is None:
        return {"error": math.nan, "bound": bound, "verdict": "refused"}
    if case.step is not None:
        # No accuracy was requested: the error must not exceed the estimate of the run.
        bound = max(bound, float(run.error))
    status = Status(int(run.status))
    error = math.nan
    if truth is not None and run.attitude is not None:
        states = {"omega": run.omega[None], "attitude": run.attitude[None], "gamma": None}
        exact = {
            "omega": np.broadcast_to(truth.omega, run.omega.shape)[None],
            "attitude": np.broadcast_to(truth.attitude, run.attitude.shape)[None],
        }
        scale = bodies_of(case.scene, case.omega, case.attitude).fastest_rates((0.0, case.t))
        error = float(_core.distances(states, exact, scale)[0, -1])
    if status not in (Status.OK, Status.COARSE):
        verdict = status.name.lower().replace("_", " ")
    elif truth is None:
        verdict = "unknown"
    else:
        verdict = "right" if error <= bound else UNDETECTED_ERROR
    return {"error": error, "bound": bound, "verdict": verdict}
