"""Extreme and stiff bodies by every method: whether each answer is right, flagged or refused."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .belief import distances
from .bodies import Body
from .forces import Torque
from .methods import EXACT, run_methods
from .progress import Progress, ProgressOption, reporting
from .scenes import FreeBody, HeavyTop, Scene
from .simulate import Run, Status, simulate

__all__ = ["Case", "Cell", "Extremes", "cases", "extremes"]

Floats = NDArray[np.float64]

ACCURACY = 1e-8
"""What is asked of each run, and what a right answer keeps to."""

MAX_STEPS = 50_000
"""A run that needs more is refused by its status: the suite is to end within a minute."""

UNIT_ROUNDOFF = 2.0**-53


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One extreme body with its start and the time at which its state is compared.

    Attributes
    ----------
    family, name : str
        What is extreme, and how much.
    scene : FreeBody or HeavyTop
    omega, attitude : tuple of float
        Start.
    t : float
        Time (s), perhaps negative.
    step : float or None
        A step to be taken instead of asking for an accuracy.
    truth : tuple of array, or None
        Rates and attitude at ``t`` where a formula gives them; None for a body whose truth is its
        closed form or, without one, a converged run.
    """

    family: str
    name: str
    scene: Scene
    omega: tuple[float, float, float]
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    t: float
    step: float | None = None
    truth: tuple[Floats, Floats] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """What a method made of a case.

    Attributes
    ----------
    case : Case
    method : str
    error : float
        Distance from the truth: of the rates relative to the fastest, of the attitude in rad. NaN
        if there is no state or no truth.
    bound : float
        What a right answer keeps to: 1e-8, or what rounding the start alone does to the motion; by
        a given step, the error that the run states.
    verdict : str
        ``"right"``; ``"flagged"``; ``"step limit"``, ``"not finite"``, ``"drifted"``: the status;
        ``"refused"``; ``"unknown"``: no truth to compare with; ``"WRONG"``: none of these.
    reason : str
        The status or the refusal in words.
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
    """What :func:`extremes` returns: a cell for each case and method that moves its scene."""

    cells: tuple[Cell, ...]

    @property
    def wrong(self) -> tuple[Cell, ...]:
        """Answers that are wrong without saying so."""
        return tuple(cell for cell in self.cells if cell.verdict == "WRONG")

    def counts(self) -> dict[str, int]:
        """How many cells have each verdict."""
        verdicts = [cell.verdict for cell in self.cells]
        return {verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)}

    def __str__(self) -> str:
        """A table: a row for each case, with its verdicts, and the counts below."""
        rows: list[tuple[str, ...]] = [
            ("case", "right", "worst error", "flagged", "refused or status", "WRONG", "s")
        ]
        family = ""
        for case in dict.fromkeys(id(cell.case) for cell in self.cells):
            mine = [cell for cell in self.cells if id(cell.case) == case]
            if mine[0].case.family != family:
                family = mine[0].case.family
                rows.append((family, *[""] * 6))
            rows.append(_row(mine))
        widths = [max(len(row[k]) for row in rows) for k in range(7)]
        lines = [
            "  ".join(
                part.ljust(width) if k == 0 else part.rjust(width)
                for k, (part, width) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
            for row in rows
        ]
        counts = ", ".join(f"{count} {verdict}" for verdict, count in self.counts().items())
        return "\n".join([*lines, "", f"{len(self.cells)} cells: {counts}"])


def _row(cells: list[Cell]) -> tuple[str, ...]:
    verdicts = [cell.verdict for cell in cells]
    right = [cell.error for cell in cells if cell.verdict == "right"]
    others = [v for v in verdicts if v not in ("right", "flagged", "WRONG")]
    return (
        f"  {cells[0].case.name}",
        str(len(right)),
        f"{max(right):.0e}" if right else "",
        str(verdicts.count("flagged") or ""),
        ", ".join(f"{others.count(v)} {v}" for v in dict.fromkeys(others)),
        str(verdicts.count("WRONG") or ""),
        f"{sum(cell.seconds for cell in cells):.1f}",
    )


def extremes(
    family: str | None = None, *, method: str | None = None, progress: ProgressOption = None
) -> Extremes:
    """Run every extreme case by every method that moves its scene.

    Each run is asked for 1e-8. The truth of bodies with a closed form was computed with 1000 bits;
    that of damped cubes is a formula, that of the others a run by ``taylor26`` converged to 1e-9.

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
        known = ", ".join(dict.fromkeys(repr(case.family) for case in cases()))
        raise ValueError(f"family = {family!r}: must be one of {known}")
    names = run_methods()
    if method is not None and method not in names:
        raise ValueError(f"method = {method!r}: must be one of {', '.join(map(repr, names))}")
    cells: list[Cell] = []
    begun = time.perf_counter()
    with reporting(progress, len(wanted)) as report:
        for done, case in enumerate(wanted, start=1):
            cells += _cells_of(case, [method] if method else list(names))
            elapsed = time.perf_counter() - begun
            report(Progress(done=done, total=len(wanted), elapsed=elapsed, failures=0))
    return Extremes(tuple(cells))


def _cells_of(case: Case, methods: list[str]) -> list[Cell]:
    truth = _truth(case)
    cells = []
    for name in methods:
        run, reason, seconds = _run(case, name)
        judged = _judged(case, run, truth)
        cells.append(Cell(case=case, method=name, reason=reason, seconds=seconds, **judged))
    return cells


def _run(case: Case, method: str) -> tuple[Run | None, str, float]:
    begin = time.perf_counter()
    how: dict[str, Any] = {} if method == EXACT else {"accuracy": ACCURACY}
    if case.step is not None and method != EXACT:
        how = {"step": case.step}
    try:
        run = _simulated(case, method=method, max_steps=MAX_STEPS, **how)
    except ValueError as error:
        return None, str(error), time.perf_counter() - begin
    return run, run.reasons()[0], time.perf_counter() - begin


def _simulated(case: Case, **how: Any) -> Run:
    return simulate(case.scene, case.omega, case.attitude, t=[case.t], threads=1, **how)


@dataclass(frozen=True, slots=True)
class _Truth:
    """A state, and how much the motion magnifies relative changes of its start."""

    omega: Floats
    attitude: Floats
    condition: float


@cache
def _exact_states() -> dict[str, dict[str, dict[str, Any]]]:
    """What ``tests/golden/make_extremes.py`` computed with 1000 bits."""
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


def _judged(case: Case, run: Run | None, truth: _Truth | None) -> dict[str, Any]:
    bound = ACCURACY if truth is None else max(ACCURACY, 4.0 * UNIT_ROUNDOFF * truth.condition)
    if run is None:
        return {"error": math.nan, "bound": bound, "verdict": "refused"}
    if case.step is not None and run.error < 1.0:
        # Nothing was asked for: it has to keep to what it states.
        bound = max(bound, float(run.error))
    status = Status(int(run.status))
    error = math.nan
    if truth is not None and run.attitude is not None:
        states = {"omega": run.omega[None], "attitude": run.attitude[None], "vertical": None}
        exact = {"omega": truth.omega[None, None], "attitude": truth.attitude[None, None]}
        with np.errstate(invalid="ignore"):
            error = float(distances(states, exact)[0, -1])
    if status != Status.OK:
        verdict = status.name.lower().replace("_", " ")
    elif truth is None:
        verdict = "unknown"
    else:
        verdict = "right" if error <= bound else "WRONG"
    return {"error": error, "bound": bound, "verdict": verdict}


def cases() -> tuple[Case, ...]:
    """All cases, family by family."""
    return tuple(
        case
        for family in (_shapes, _spherical, _separatrix, _sizes, _tops, _times, _damped, _coarse)
        for case in family()
    )


TUMBLE = (0.3, -0.5, 1.1)
"""Rates of a body that turns about no axis in particular (rad/s)."""

TILTED = (0.8, 0.4, -0.4, 0.2)
"""An attitude that is none in particular."""


def _start(**parts: Any) -> dict[str, Any]:
    return parts


def _free(family: str, name: str, moments: tuple[float, float, float], **rest: Any) -> Case:
    start = _start(omega=TUMBLE, attitude=TILTED, t=10.0) | rest
    return Case(family=family, name=name, scene=FreeBody(Body(moments)), **start)


def _shapes() -> Iterator[Case]:
    for ratio in (1e-12, 1e-9, 1e-6, 1e-3):
        # Spinning about its length a needle nutates at 1/ratio times its rate.
        yield _free("needle", f"I3/I1 = {ratio:g}", (1.0, 1.0 - ratio / 2.0, ratio), t=4.0 * ratio)
        yield _free("needle", f"I3/I1 = {ratio:g}, symmetric", (1.0, 1.0, ratio))
    for small in (1.0, 1e-3, 1e-6, 1e-12):
        yield _free("lamina", f"moments 1, {small:g} and their sum", (1.0, small, 1.0 + small))
    yield _free("lamina", "I3/I1 = 2", (0.5, 0.5, 1.0))


def _spherical() -> Iterator[Case]:
    for digits in (3, 6, 9, 12, 15):
        apart = 10.0**-digits
        moments = (1.0, 1.0 + apart, 1.0 + 3.0 * apart)
        yield _free("near spherical", f"moments 1e-{digits} apart", moments, t=100.0)
    yield _free("near spherical", "sphere", (1.0, 1.0, 1.0), t=100.0)


def _separatrix() -> Iterator[Case]:
    for digits in (1, 2, 4, 6, 8, 10, 12, 14):
        aside = 10.0**-digits
        start = _start(omega=(aside, 1.0, aside), t=8.0 * digits + 20.0)
        yield _free(
            "separatrix", f"omega = (1e-{digits}, 1, 1e-{digits})", (1.0, 2.0, 3.0), **start
        )
    yield _free("separatrix", "on the middle axis", (1.0, 2.0, 3.0), omega=(0.0, 1.0, 0.0), t=60.0)


def _sizes() -> Iterator[Case]:
    for power in (-12, -6, 6, 12):
        size = 10.0**power
        first, second, third = TUMBLE
        start = _start(omega=(size * first, size * second, size * third), t=20.0 / size)
        yield _free("spin", f"1e{power} rad/s", (1.0, 1.6, 2.0), **start)
    for unit in (-1060, -1000, 1000, 1020):
        scaled = tuple(math.ldexp(moment, unit) for moment in (1.0, 1.625, 2.0))
        yield _free("unit", f"moments near 2^{unit}", (scaled[0], scaled[1], scaled[2]))


def _top(family: str, name: str, mgl: float, *, lagrange: bool, **rest: Any) -> Case:
    body = Body((1.0, 1.0, 0.5)) if lagrange else Body((1.0, 1.6, 0.7))
    com = (0.0, 0.0, 1.0) if lagrange else (0.6, 0.0, 0.8)
    return Case(family=family, name=name, scene=HeavyTop(body, mgl=mgl, com=com), **rest)


def _leaning(tilt: float) -> tuple[float, float, float, float]:
    return (math.cos(0.5 * tilt), math.sin(0.5 * tilt), 0.0, 0.0)


def _tops() -> Iterator[Case]:
    for power in (-12, -6, 6, 12):
        mgl = 10.0**power
        for lagrange in (True, False):
            kind = "symmetric" if lagrange else "asymmetric"
            start = _start(omega=TUMBLE, attitude=TILTED, t=10.0 / max(1.0, math.sqrt(mgl)))
            yield _top("weight", f"mgl = 1e{power}, {kind}", mgl, lagrange=lagrange, **start)
    for tilt in (1e-16, 1e-12, 1e-8, 1e-4, 1.0):
        for spin, state in ((3.0, "waking"), (6.0, "asleep")):
            start = _start(omega=(0.0, 0.0, spin), attitude=_leaning(tilt), t=30.0)
            yield _top("sleeping top", f"{state}, tilt {tilt:g}", 1.0, lagrange=True, **start)
    for off in (-1e-12, 0.0, 1e-12):
        spin = 4.0 * (1.0 + off)
        start = _start(omega=(0.0, 0.0, spin), attitude=_leaning(1e-4), t=30.0)
        name = f"spin {off:+g} from the threshold" if off else "spin at the threshold"
        yield _top("sleeping top", name, 1.0, lagrange=True, **start)
    for tilt, pole in ((0.0, "upright"), (math.pi, "hanging")):
        for lagrange in (True, False):
            kind = "symmetric" if lagrange else "asymmetric"
            start = _start(omega=TUMBLE, attitude=_leaning(tilt), t=10.0)
            yield _top("pole", f"{pole}, {kind}", 1.0, lagrange=lagrange, **start)


def _times() -> Iterator[Case]:
    for t, name in ((0.0, "t = 0"), (-20.0, "t = -20"), (1e12, "t = 1e12 rad"), (1e15, "t = 1e15")):
        yield _free("time", name, (1.0, 1.6, 2.0), t=t)
        start = _start(omega=TUMBLE, attitude=TILTED, t=t)
        yield _top("time", f"{name}, top", 1.0, lagrange=True, **start)
        yield _top("time", f"{name}, asymmetric top", 1.0, lagrange=False, **start)
    # Moments and rate of the Earth (IERS Conventions 2010), its axis 0.2 arc seconds off.
    day, off, years = 7.292115e-5, 1e-6, 26_000.0 * 365.25 * 86_400.0
    for moments, name in (
        ((8.0101e37, 8.0101e37, 8.0365e37), "symmetric"),
        ((8.0101e37, 8.0103e37, 8.0365e37), "triaxial"),
    ):
        rates = (off * day, 0.0, day)
        yield _free("Earth", f"26 000 years, {name}", moments, omega=rates, t=years)


def _damped() -> Iterator[Case]:
    """Closed forms of a cube that a motor turns against damping, and of one that slows down."""
    for power in (-6, -3, 0, 3, 6, 9):
        c = 10.0**power
        t = 3.0
        for torque in (0.0, 2.0):
            motor = None if torque == 0.0 else Torque.body((0.0, 0.0, torque))
            scene = FreeBody(Body((1.0, 1.0, 1.0)), damping=c, torque=motor)
            gone = -math.expm1(-c * t)
            # (N/c)(t - (1 - e^{-ct})/c) loses its digits where c t is small: its series there.
            ahead = (
                torque * (t * t / 2.0 - c * t**3 / 6.0 + c * c * t**4 / 24.0 - c**3 * t**5 / 120.0)
                if c * t < 1e-2
                else torque / c * (t - gone / c)
            )
            rate = 1.5 * (1.0 - gone) + torque * gone / c
            angle = 1.5 * gone / c + ahead
            yield Case(
                family="damping",
                name=f"c/I = 1e{power}" + (", with a motor" if torque else ""),
                scene=scene,
                omega=(0.0, 0.0, 1.5),
                t=t,
                truth=(
                    np.array([0.0, 0.0, rate]),
                    np.array([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)]),
                ),
            )


def _coarse() -> Iterator[Case]:
    """Steps far too long, taken as asked: what comes out has to say so."""
    for turns in (1.0, 10.0, 1000.0):
        step = 2.0 * math.pi * turns
        name = f"{turns:g} turns a step"
        yield _free("long steps", name, (1.0, 1.6, 2.0), step=step, t=40.0 * step)
        start = _start(omega=TUMBLE, attitude=TILTED, t=40.0 * step)
        yield _top("long steps", f"{name}, top", 1.0, lagrange=False, step=step, **start)
        if turns > 100.0:
            continue  # the truth would take minutes
        scene = FreeBody(Body((1.0, 1.6, 2.0)), damping=1.0)
        yield Case(
            family="long steps",
            name=f"{name}, damped",
            scene=scene,
            omega=TUMBLE,
            attitude=TILTED,
            step=step,
            t=40.0 * step,
        )
