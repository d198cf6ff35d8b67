"""The plan of a question: method, state variables, omitted computations, and reasons.

A plan omits what a scene does not need: no attitude for rates, no steps for a closed form, no
trajectory for a classification. Symmetry counts only if two moments are exactly equal: a relative
difference of 1e-16 changes a sleeping top by 1e-4, so nothing is symmetrised.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence, Sized
from dataclasses import dataclass
from math import prod
from typing import Any, Generic, Self, TypeAlias, TypeVar

import numpy as np

from .. import _core
from .._checks.arrays import IDENTITY, Floats, lengths
from .._checks.shown import labelled
from ..drawing.figure import html_table
from ..model.bodies import Bodies
from ..model.forces import FORCES, forces_in_words
from ..model.scene import Scene
from .closed_form import Codes, Question, names, question_words
from .methods import EXACT
from .request import Problem

Made = TypeVar("Made")

Reason: TypeAlias = str | Callable[[], str]
"""A reason of a plan, or how to word it."""

UNKNOWN = "error unknown: {}"
"""The sentence of a plan whose error is unknown."""

SLOW = 10.0
"""A body this many times slower than the rate that its weight can give it is nearly at rest."""

MAGNIFIED = 100.0
"""A saddle that magnifies the rounding of the start by more makes the error unknown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """The computation for a question about a scene: method, steps, error, cost, reasons.

    The plan of a run, :attr:`Run.plan <rigid.Run.plan>`, says what was done: the steps that were
    taken, and the largest error of a body.

    Attributes
    ----------
    scene, question : str
        Description of the question.
    closed_form : str or None
        The closed form: ``"free asymmetric"``, ``"free symmetric"``, ``"axis spin"``,
        ``"lagrange"`` or ``"pendulum"``; several are joined by commas.
    method : str
        ``"exact"``, the name of another method, or ``"auto"`` for a map where only some bodies have
        a closed form.
    carried : tuple of str
        State variables: ``"omega"``, ``"gamma"`` (the vertical in the body), ``"attitude"`` (as a
        quaternion, or as the axes of space in the body); under forces ``"work"``, with the impulse;
        ``"deviation"``, a deviation vector; ``"orbit"``, the place on the orbit, which all further
        forces share.
    step : float or None
        Longest step (s), the shortest of many bodies; None for a closed form, for adaptive steps
        and where the rates are not known.
    steps : int or None
        About how many steps the body takes, the most of many bodies; 0 for a closed form, None
        where they are not known before the run.
    why, left_out : tuple of str
        The reasons, and the omitted computations, which the scene or the question does not need.
    tolerance : float or None
        The tolerance of adaptive steps; None for a closed form and for equal steps.
    accuracy : float or None
        The error for which method and steps are made: the requested error, or 1e-8 for states if
        neither a method nor a step is given; else None.
    memory : int or None
        Bytes of the states of all bodies of the call at the output times, in double precision and
        without arrays of the user. None for a criterion, and if the number of bodies is not known.
    error : float or None
        Error of the attitude at the end (rad). For a closed form it is ``1e-15`` per radian turned,
        and None if the rates or the horizon are missing, or if ``why`` names a reason: rates that
        nearly vanish, or a saddle. The error of steps is not known before the run: it is None, or
        of a run and with ``cost=True`` the largest :attr:`Run.error <rigid.Run.error>` of the
        bodies that were run, if it is below one.
    cost : float or None
        Processor time of a body of the call (ns), of all threads together and with the second run
        that estimates the error, measured by running some of the bodies. None unless it was asked
        for by ``cost=True``.
    """

    scene: str
    question: str
    closed_form: str | None
    method: str
    carried: tuple[str, ...]
    step: float | None
    steps: int | None
    why: tuple[str, ...]
    left_out: tuple[str, ...]
    error: float | None
    tolerance: float | None = None
    accuracy: float | None = None
    memory: int | None = None
    cost: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The plan as a JSON-able dictionary; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        values = dataclasses.asdict(self)
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plan:
        """The plan that :meth:`to_dict` described.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        Plan
        """
        values = dict(data)
        for name in ("carried", "why", "left_out"):
            values[name] = tuple(values[name])
        return cls(**values)

    def to_json(self) -> str:
        """The plan as JSON text; floats keep all their digits.

        Returns
        -------
        str
        """
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Plan:
        """The plan that :meth:`to_json` wrote.

        Parameters
        ----------
        text : str
            The JSON text.

        Returns
        -------
        Plan

        Examples
        --------
        >>> import rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> plan = rigid.plan(box, "rates", t_end=10.0)
        >>> rigid.Plan.from_json(plan.to_json()) == plan
        True
        """
        return cls.from_dict(json.loads(text))

    def __repr__(self) -> str:
        error = "" if self.error is None else f"; error about {self.error:.1e} rad"
        return f"<Plan: {self.scene}; {self.method_words()}{error}>"

    def __str__(self) -> str:
        return labelled(self._lines())

    def _repr_html_(self) -> str:
        return html_table(self._lines())

    def _lines(self) -> list[tuple[str, str]]:
        lines = [
            ("scene", self.scene),
            ("question", self.question),
            ("method", self.method_words()),
            ("carried", ", ".join(self.carried) or "nothing"),
            ("why", "; ".join(self.why)),
            ("left out", "; ".join(self.left_out) or "nothing"),
            ("error", "unknown" if self.error is None else f"about {self.error:.1e} rad"),
        ]
        if self.cost is not None:
            lines.append(("cost", f"{_time_words(self.cost)} a body"))
        if self.memory is not None:
            lines.append(("memory", f"{memory_words(self.memory)} for the states"))
        return lines

    def method_words(self) -> str:
        """Method, closed form and steps in a few words.

        Returns
        -------
        str

        Examples
        --------
        >>> import rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> rigid.plan(box, "rates", t_end=10.0).method_words()
        'exact, closed form: free asymmetric'
        """
        if self.method == EXACT:
            return f"{EXACT}, closed form: {self.closed_form}" if self.closed_form else EXACT
        parts = [self.method]
        if self.closed_form:
            parts.append(f"closed form where there is one: {self.closed_form}")
        if self.tolerance is not None:
            parts.append(f"tolerance {self.tolerance:g}")
        else:
            known = self.step is not None
            parts.append(f"step {self.step:g} s" if known else "step chosen for each body")
        if self.steps is not None:
            parts.append(f"about {self.steps:,} steps")
        return ", ".join(parts)


class Lazy(Generic[Made]):
    """An object made when it is first read: many runs are made, few of their parts are read.

    What it is made of must not change meanwhile. Two threads that read it first make the same.
    """

    __slots__ = ("_made", "_making")

    def __init__(self, make: Callable[..., Made], *given: Any) -> None:
        self._making: tuple[Callable[..., Made], tuple[Any, ...]] | None = make, given
        self._made: Made | None = None

    @classmethod
    def of(cls, made: Made) -> Self:
        """A wrapper of an object that is made already."""
        return cls(lambda: made)

    def __call__(self) -> Made:
        """The object."""
        making = self._making
        if making is not None:
            make, given = making
            self._made = make(*given)
            self._making = None  # and what it holds: this comes last, for other threads
        assert self._made is not None
        return self._made

    def amend(self, reason: str | None = None, **fields: Any) -> None:
        """Change fields of a plan that is not yet read, and add a reason."""
        assert self._making is not None
        self._making = _amended, (*self._making, reason, fields)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).of, (self(),)


def _amended(
    make: Callable[..., Any], given: tuple[Any, ...], reason: str | None, fields: dict[str, Any]
) -> Any:
    """The plan with other fields, and with a further reason."""
    plan = make(*given)
    if reason is not None:
        fields = {**fields, "why": (*plan.why, reason)}
    return dataclasses.replace(plan, **fields)


def plan_of_parts(scene: Scene, plans: Sequence[Lazy[Plan]], groups: Sequence[Sized]) -> Plan:
    """The plan of a scene whose bodies are solved in groups, from a group that takes steps."""
    parts = [plan() for plan in plans]
    # Of the plans in closed form and by steps the latter tells more.
    chosen = min(range(len(parts)), key=lambda k: parts[k].method == EXACT)
    whole, count = parts[chosen], sum(map(len, groups))
    numbers: dict[str, int] = {}
    for part, mine in zip(parts, groups, strict=True):
        numbers[part.method] = numbers.get(part.method, 0) + len(mine)
    others = [
        f"{number} of {count} bodies " + ("in closed form" if name == EXACT else f"by {name}")
        for name, number in numbers.items()
        if name != whole.method
    ]

    def known(name: str) -> list[Any]:
        return [value for part in parts if (value := getattr(part, name)) is not None]

    forms = known("closed_form")
    return dataclasses.replace(
        whole,
        scene=scene.words(),
        closed_form=forms[0] if forms else None,
        carried=tuple(dict.fromkeys(name for part in parts for name in part.carried)),
        why=(*whole.why, *others),
        step=min(known("step"), default=None),
        steps=max(known("steps"), default=None),
        error=max(known("error")) if len(known("error")) == len(parts) else None,
        memory=sum(known("memory")) if len(known("memory")) == len(parts) else None,
    )


def left_out(
    scene: Scene,
    question: Question,
    method: str,
    step: float | None,
    forms: Codes,
    forces: tuple[str, ...],
) -> tuple[str, ...]:
    """The omitted computations under these forces, with reasons."""
    left = []
    done = carried(scene, question, method, forces)
    if method == EXACT:
        reasons = {
            "free symmetric": "symmetric: no elliptic functions",
            "lagrange": "symmetric: closed form, no steps",
            "pendulum": "plane swing: closed form, no steps",
        }
        if forces:
            left.append("damping a multiple of the inertia: the free motion, slowed; no steps")
        elif not scene.directions:
            left.append("no torque: no steps")
        left.extend(reasons[form] for form in names(forms) if form in reasons)
        if step is not None:
            left.append(f"closed form: step = {step:g} is not needed")
    if not isinstance(question, str):
        attitude = "" if "attitude" in done else "no attitude, "
        left.append(
            "class only: no trajectory, no attitude"
            if method == EXACT
            else f"class only: {attitude}no trajectory kept"
        )
        if forces == ("orbit",) and "work" not in done:
            left.append("no force but the orbit: no work")
    elif question != "attitude" and "attitude" not in done:
        left.append(f"{'rates' if question == 'rates' else 'vertical'} only: no attitude")
    if not scene.directions and question in ("rates", "attitude") and "gamma" not in done:
        left.append("no weight: no vertical")
    return tuple(left)


def not_left_out(done: tuple[str, ...], forces: tuple[str, ...]) -> tuple[str, ...]:
    """Why a computation by steps is made although the scene does not need it."""
    further = [name for name in FORCES if name in forces]
    if not further or (forces == ("orbit",) and "work" not in done):
        return ()
    idle = [
        name
        for name, force in FORCES.items()
        if name not in forces and ("attitude" in done or not force.in_space)
    ]
    if not idle:
        return ()
    zero = "is computed as zero" if len(idle) == 1 else "are computed as zeros"
    return (f"one kernel has all further forces: {forces_in_words(idle)} {zero}",)


def carried(
    scene: Scene, question: Question, method: str, forces: tuple[str, ...]
) -> tuple[str, ...]:
    """The state variables that are computed under these forces."""
    exact = method == EXACT
    watched = not isinstance(question, str)
    record = question if isinstance(question, str) else question.record
    if watched and exact and not forces:
        return ()
    has_deviation = not isinstance(question, str) and question.has_deviation
    if has_deviation and not forces:
        return ("omega", "gamma", "deviation")
    if forces and (watched or not exact):
        further = [FORCES[name] for name in FORCES if name in forces]
        in_space = scene.rates_need_attitude or any(force.in_space for force in further)
        bare = record == "rates" and not in_space and not has_deviation
        variables = ("omega",) if bare else ("omega", "gamma", "attitude")
        # A class of a body on an orbit alone needs no balance of energy: nothing is constant.
        balance = ("work",) if has_deviation or not watched or forces != ("orbit",) else ()
        own = ("orbit",) if further and not bare else ()
        return (*variables, *balance, *(("deviation",) if has_deviation else ()), *own)
    turns = bool(scene.directions)
    if exact:
        # The rates of a top and every vertical come from the attitude.
        return {
            "rates": ("omega", "attitude") if turns else ("omega",),
            "axis": ("omega", "gamma", "attitude"),
            "attitude": ("omega", "attitude"),
        }[record]
    return {
        "rates": ("omega", "gamma") if turns else ("omega",),
        "axis": ("omega", "gamma"),
        "attitude": ("omega", "gamma", "attitude") if turns else ("omega", "attitude"),
    }[record]


def memory_words(size: int) -> str:
    """A number of bytes in words, in a unit of suitable size."""
    for name, unit in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= unit:
            return f"{size / unit:.3g} {name}"
    return f"{size} bytes"


def _time_words(nanoseconds: float) -> str:
    for limit, unit, size in ((1e3, "ns", 1.0), (1e6, "µs", 1e3), (1e9, "ms", 1e6)):
        if nanoseconds < limit:
            return f"{nanoseconds / size:.3g} {unit}"
    return f"{nanoseconds / 1e9:.3g} s"


# The plan of a problem whose method is chosen


def plan_of(
    problem: Problem,
    method: str,
    steps: Floats | None,
    forms: Codes,
    accuracy: float | None,
    why: tuple[Reason, ...],
) -> Plan:
    """The plan of a method, made only on demand: it takes longer than the choice of the method.

    Parameters
    ----------
    problem : Problem
    method : str
    steps : ndarray, shape (n,), or None
        The longest step of each body (s); None if there are none or if they are left to the core.
    forms : ndarray of uint8
        The closed forms of the bodies, by their codes; empty if a method was requested.
    accuracy : float or None
        The error for which method and steps were chosen.
    why : tuple of str or callable
        The reasons; functions without arguments return those that take time to word.
    """
    scene, record, error = problem.scene, problem.record, None
    words = tuple(reason if isinstance(reason, str) else reason() for reason in why)
    step: float | None
    count: int | None
    if method == EXACT:
        step, count = None, 0
        error = closed_form_error(problem.rates(), problem.span)
    else:
        step, count = _step_and_count(problem, method, steps, accuracy)
    if scene.torque is not None and scene.torque.function is not None:
        words = (*words, *scene.torque.function.reasons)
    done = carried(scene, record, method, scene.forces)
    return Plan(
        scene=scene.words(),
        question=question_words(record),
        closed_form=", ".join(names(forms)) or None if method == EXACT else None,
        method=method,
        carried=done,
        why=(*words, *not_left_out(done, scene.forces)),
        left_out=left_out(scene, record, method, problem.step, forms, scene.forces),
        step=step,
        steps=count,
        tolerance=problem.tolerance,
        error=error,
        accuracy=accuracy,
        memory=_memory(problem),
    )


def _step_and_count(
    problem: Problem, method: str, steps: Floats | None, accuracy: float | None
) -> tuple[float | None, int | None]:
    """The shortest step (s) and the most steps, as far as they are known before a run."""
    if problem.tolerance is not None or (steps is None and accuracy is not None):
        return None, None
    scene, bodies = problem.scene, problem.bodies
    unknown = bodies is None or (problem.span is None and scene.forces)
    if unknown and problem.step is None:
        return None, None
    if bodies is None:  # at rest: damping makes a step unstable from any start
        bodies = Bodies.of_scene(scene, np.zeros(3), IDENTITY, scene.shape)
    reach = problem.reach or (0.0, problem.step or 0.0)
    own, time = bodies.planned_steps(method, reach, "states", problem.step)
    if unknown:
        return problem.step, None
    if steps is not None:
        own = steps
    return shortest_and_most(own, None if problem.span is None else time, problem.states)


@np.errstate(all="ignore")
def shortest_and_most(
    steps: Floats, times: Floats | None, states: int = 1
) -> tuple[float | None, int | None]:
    """The shortest step (s), and about how many steps the body with the most of them takes.

    Parameters
    ----------
    steps : ndarray, shape (n,)
        The longest step of each body (s), infinite for a body at rest.
    times : ndarray, shape (n,), or None
        In which steps of that length are as many as in the run (s), None if not known.
    states : int
        Number of output times: each interval between them has a whole number of steps.
    """
    shortest = float(steps.min(initial=np.inf))
    most = np.inf
    if times is not None:
        each = np.ceil(times / steps + 0.5 * (states - 1))
        most = float(np.maximum(each, max(states, 1)).max(initial=0.0))
    return shortest if shortest < np.inf else None, int(most) if most < 2.0**63 else None


@np.errstate(all="ignore")
def closed_form_error(rates: Floats | None, span: float | Floats | None) -> float | None:
    """The largest error of closed forms (rad) for bounds of the rates, shape (n,), if known."""
    if rates is None or span is None:
        return None
    worst = _core.ROUNDING * (1.0 + float((rates * span).max(initial=0.0)))
    return worst if worst < np.inf else None


@np.errstate(all="ignore")
def why_unforeseen(bodies: Bodies, end: float) -> str | None:
    """Why the error of closed forms until a time (s) is not known before the run; None if it is."""
    if not np.count_nonzero(bodies.weight):
        return None
    tops = np.flatnonzero(np.broadcast_to(bodies.weight.any(axis=1), len(bodies)))
    if not len(tops):
        return None
    some = bodies.select(tops)
    if np.any(some.fastest_rates((0.0, end)) > SLOW * _fastest_above_rest(some)):
        return "a body is nearly at rest, and its small rates are what the error is relative to"
    distance, exponent = some.separatrices()
    growth = np.exp(exponent * end)
    if np.any(np.fmin(growth, 1.0 / distance) > MAGNIFIED):
        return "a body passes a saddle, which magnifies it"
    return None


def _fastest_above_rest(bodies: Bodies) -> Floats:
    """The fastest rate (rad/s) that a top can reach by its energy above hanging; shape (n,)."""
    size = lengths(bodies.weight)
    kinetic = 0.5 * np.sum(bodies.moments * bodies.omega**2, axis=1)
    # A difference of unit vectors: small angles lose no digits.
    raised = 0.5 * np.sum((bodies.gammas() + bodies.weight / size[:, None]) ** 2, axis=1)
    fastest: Floats = np.sqrt(2.0 * (kinetic + size * raised) / bodies.moments.min(axis=1))
    return fastest


def _memory(problem: Problem) -> int | None:
    """Bytes of the states of the bodies, if their number is known."""
    number = problem.number
    if number is None and problem.bodies is not None:
        number = len(problem.bodies)
    if number is None and problem.scene.shape:
        number = prod(problem.scene.shape)
    if number is None:
        return None
    return _core.state_bytes(
        scene=problem.scene.kind,
        record=problem.record,
        bodies=number,
        times=problem.states,
        forces=problem.forces(),
    )
