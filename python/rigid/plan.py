"""The plan of a request: closed form or scheme, what is carried, what is left out, and why.

Leave out what a scene does not need: rates only, no attitude; a closed form, no steps; a class
wanted, no trajectory. Symmetry counts only if two moments are equal to the bit: a relative
difference of 1e-16 changes a waking top by 1e-4, so nothing is symmetrised.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, one_of
from .bodies import possible
from .columns import check_scene, columns, each_row, fastest_rates
from .costs import cheapest, check_attainable, numbers, schemes, steps_for
from .criteria import Criterion, NoFlip, TiltBelow
from .grid import Pixels, pixels, tables
from .methods import (
    AUTO,
    EXACT,
    FALLBACK,
    STIFF,
    check_method,
    driven_methods,
    plain_methods,
    run_methods,
)
from .scenes import FreeBody, HeavyTop, Scene, scene_words
from .starts import Start

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from .mapspec import MapSpec

__all__ = [
    "RECORDS",
    "Plan",
    "Question",
    "decide",
    "lagrange_axes",
    "map_plan",
    "plan",
    "require_closed_forms",
]

Floats = NDArray[np.float64]
Question: TypeAlias = str | Criterion

RECORDS: Mapping[str, str] = {
    "rates": "rates at wanted times",
    "axis": "rates and vertical at wanted times",
    "attitude": "rates and attitude at wanted times",
}
"""The questions that are answered by states, in words."""

_STATES_RULE = (
    "closed forms are known of a free body, of a top with two moments equal to the bit and its "
    "centre of mass on the third axis, and of a top that swings about a principal axis"
)
_DRIVEN_RULE = (
    "under torque and damping there is none, but of a free body whose damping is a multiple of its "
    "inertia"
)
_CLASS_RULE = (
    "closed forms are known of no_flip of a free body, and of tilt_below(axis=±k, "
    "reference='vertical') and no_flip(k) of a top with two moments equal to the bit and its "
    "centre of mass on the third axis k"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What is done to answer a question about a scene; made by :func:`plan`.

    Attributes
    ----------
    scene, question : str
        What is asked, in words.
    closed_form : str or None
        The closed form: ``"free asymmetric"``, ``"free symmetric"``, ``"axis spin"``,
        ``"lagrange"`` or ``"pendulum"``; several are joined by commas.
    method : str
        ``"exact"``, the name of a scheme, or ``"auto"`` for a map where only some bodies have a
        closed form.
    carried : tuple of str
        Variables computed: ``"omega"``, ``"gamma"`` (the vertical in the body), ``"attitude"``;
        under torque and damping their ``"work"``.
    step : float or None
        Longest step (s), the shortest of many bodies; None for a closed form and where the rates
        are not known.
    steps : int or None
        About how many steps the body takes, the most of many bodies; 0 for a closed form.
    why, left_out : tuple of str
        The reasons, and what the scene or the question does not need.
    cost : float or None
        Estimate of the processor time of a body, ns; of the costliest of many.
    error : float or None
        Estimate of the error of the attitude at the end, rad: ``1e-15`` per radian turned, and for
        a scheme the phase error of its order. Saddles and chaos multiply it.
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
    cost: float | None
    error: float | None

    def to_dict(self) -> dict[str, Any]:
        """The plan as a JSON-able dictionary; :meth:`from_dict` is its inverse."""
        values = dataclasses.asdict(self)
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plan:
        """The plan that :meth:`to_dict` described."""
        values = dict(data)
        for name in ("carried", "why", "left_out"):
            values[name] = tuple(values[name])
        return cls(**values)

    def to_json(self) -> str:
        """The plan as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Plan:
        """The plan that :meth:`to_json` wrote."""
        return cls.from_dict(json.loads(text))

    def __str__(self) -> str:
        lines = [
            ("scene", self.scene),
            ("question", self.question),
            ("method", self.method_words()),
            ("carried", ", ".join(self.carried) or "nothing"),
            ("why", "; ".join(self.why)),
            ("left out", "; ".join(self.left_out) or "nothing"),
            ("cost", "unknown" if self.cost is None else f"about {_time_words(self.cost)} a body"),
            ("error", "unknown" if self.error is None else f"about {self.error:.1e} rad"),
        ]
        return "\n".join(f"{name:<12}{text}" for name, text in lines)

    def method_words(self) -> str:
        """Method, closed form and steps in a few words."""
        if self.method == EXACT:
            return f"{EXACT}, closed form: {self.closed_form}" if self.closed_form else EXACT
        parts = [self.method]
        if self.closed_form:
            parts.append(f"closed form where there is one: {self.closed_form}")
        parts.append("step chosen for each body" if self.step is None else f"step {self.step:g} s")
        if self.steps is not None:
            parts.append(f"about {self.steps:,} steps")
        return ", ".join(parts)


def plan(
    scene: Scene,
    question: Question,
    *,
    omega: ArrayLike | None = None,
    attitude: ArrayLike | Rotation | None = None,
    t_end: float | None = None,
    accuracy: float | None = None,
    method: str | None = None,
    step: float | None = None,
) -> Plan:
    """What :func:`simulate` or a map would do for a question about a scene, without doing it.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body and what acts on it.
    question : {"rates", "axis", "attitude"}, NoFlip or TiltBelow
        States at wanted times, or a criterion: :func:`no_flip`, :func:`tilt_below`.
    omega, attitude : array_like, optional
        Where the bodies start, as in :func:`simulate`. Known rates give the step, the steps and the
        error; known starts tell whether a top swings as a pendulum.
    t_end : float, optional
        Horizon (s).
    accuracy : float, optional
        Wanted error of the last state relative to its size. A closed form has it; otherwise the
        cheapest scheme and its step follow from it, the rates and the horizon.
    method : str, optional
        ``"exact"`` or one of :func:`rigid.methods`; by default the closed form if all bodies have
        one and no step is given, else ``"rk4"``, or ``"etd4"`` under strong damping.
    step : float, optional
        Longest step (s).

    Returns
    -------
    Plan

    Raises
    ------
    ValueError
        If ``"exact"`` is asked for and a body has no closed form, the accuracy is beyond float64,
        or the rates or the horizon are missing that the step follows from.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> print(rigid.plan(scene, "rates", omega=[0.1, 1.0, 0.2], t_end=100.0))
    scene       free body, moments (1, 2, 3)
    question    rates at wanted times
    method      exact, closed form: free asymmetric
    carried     omega
    why         every body has a closed form
    left out    no torque: no steps; rates only: no attitude; no weight: no vertical
    cost        about 240 ns a body
    error       about 1.6e-13 rad
    >>> rigid.plan(scene, rigid.tilt_below(0.5)).method
    'rk4'
    """
    check_scene(scene)
    if omega is None and attitude is not None:
        raise ValueError("attitude: says nothing without omega; give both")
    table = None if omega is None else columns(scene, omega, attitude)[0]
    span = None if t_end is None else finite_float("t_end", t_end, positive=True)
    return decide(
        scene,
        _resolved(scene, question, table),
        table=table,
        span=span,
        accuracy=accuracy,
        method=method,
        step=step,
        states=1 if isinstance(question, str) else 0,
    )[0]


def decide(
    scene: Scene,
    question: Question,
    *,
    table: Mapping[str, Any] | None,
    span: float | None,
    back: float = 0.0,
    accuracy: float | None = None,
    method: str | None = None,
    step: float | None = None,
    states: int = 1,
) -> tuple[Plan, Floats | None]:
    """The plan for the bodies of ``table`` over a time ``span``, and the step of each body.

    The span begins at ``back``, which is not positive. The steps are None if there are none or they
    are left to the core.
    """
    if method is not None:
        one_of("method", method, run_methods())
        watched = not isinstance(question, str)
        check_method(method, scene.kind, watched=watched, driven=scene.outside is not None)
    if step is not None:
        step = finite_float("step", step, positive=True)
    if accuracy is not None:
        accuracy = finite_float("accuracy", accuracy, positive=True)
    if accuracy is not None and step is not None:
        raise ValueError(
            f"accuracy = {accuracy:g}, step = {step:g}: exclude each other, "
            "because the step follows from the accuracy"
        )
    forms = closed_forms(question, np.array([scene.body.moments]), scene.weight[np.newaxis])
    driven = scene.outside is not None
    if driven and not (isinstance(question, str) and _slows_evenly(scene)):
        forms = np.full_like(forms, "")
    asked = not driven and (method == EXACT or (method is None and step is None))
    if asked and table is not None and isinstance(question, str) and "" in forms:
        # Whether a top swings as a pendulum is for its start to say.
        forms = np.array(_core.closed_forms(**each_row(table)), dtype=np.str_)
    if method == EXACT and "" in forms:
        body = int(np.flatnonzero(forms == "")[0])
        which = f"body {body} of the" if forms.size > 1 else "the"
        raise ValueError(
            f"method = {EXACT!r}: no closed form of {_question_words(question)} for {which} "
            f"{scene_words(scene)}; {_DRIVEN_RULE if driven else _rule(question)}"
        )
    chosen, why = _choice(scene, question, forms, method, step)
    rates = turning = None
    between = (back, back + (span or 0.0))
    if scene.torque is not None and span is not None:
        scene.torque.at(between)  # refuses times that its table does not reach
    if table is not None and (span is not None or not driven):
        turning = fastest_rates(table, between)
        rates = turning
    if driven and chosen != EXACT:
        slowing = _slowing(scene)
        if method is None and _is_stiff(slowing, turning, step):
            chosen = STIFF
            why.append(f"strong damping, at a rate of {slowing:.3g} 1/s: {STIFF}")
        if rates is not None and table is not None:
            rates = fastest_rates(table, between, chosen)
    asked_for = question
    if driven and isinstance(question, str):
        bare = "gamma" not in _carried(scene, question, chosen)
        asked_for = "rates" if bare else "attitude"
    steps = None
    kind = _kind(scene)
    if accuracy is not None:
        if turning is not None and span is not None:
            check_attainable(accuracy, turning * span)
        if chosen != EXACT:
            if table is None or rates is None or span is None:
                raise ValueError(
                    f"accuracy = {accuracy:g}: the step follows from the rates and the horizon; "
                    f"{'omega' if rates is None else 't_end'} is missing"
                )
            if method is None:
                names = driven_methods() if driven else plain_methods()
                angles = {
                    name: float(fastest_rates(table, between, name).max(initial=0.0) * span)
                    if driven
                    else float(rates.max(initial=0.0) * span)
                    for name in names
                }
                chosen = cheapest(accuracy, kind, asked_for, angles)
                if driven:
                    rates = fastest_rates(table, between, chosen)
                why.append(f"{chosen} is the cheapest scheme for it")
            steps = steps_for(accuracy, schemes()[chosen, kind], rates, span)
            why.append(f"the step follows from the accuracy, {accuracy:g} at the end")
    elif step is not None and rates is not None and chosen != EXACT:
        steps = np.full(rates.shape, step)
    made = Plan(
        scene=scene_words(scene),
        question=_question_words(question),
        closed_form=_listed(forms) if chosen == EXACT else None,
        method=chosen,
        carried=_carried(scene, question, chosen),
        why=tuple(why),
        left_out=_left_out(scene, question, chosen, step, forms),
        **numbers(kind, asked_for, chosen, forms, rates, span, steps, step, states),
    )
    return made, steps


def _slows_evenly(scene: Scene) -> bool:
    """Whether damping is a multiple of the inertia and all that acts: the free motion, slowed."""
    outside = scene.outside
    if outside is None or scene.weight.any() or isinstance(scene, HeavyTop):
        return False
    return outside.slows_evenly(scene.body.moments) is not None


STIFFNESS = 10.0
"""How many times faster than it turns damping slows a body whose explicit steps are a waste."""


def _slowing(scene: Scene) -> float:
    """The fastest rate at which damping slows the body (1/s)."""
    outside = scene.outside
    return 0.0 if outside is None else float(outside.damping_rates(scene.body.moments)[-1])


def _is_stiff(slowing: float, turning: Floats | None, step: float | None) -> bool:
    """Whether explicit steps would follow the damping, not the motion."""
    if step is not None:
        # Of an explicit scheme the error would be that of the damping.
        return step * slowing > 1.0
    return turning is not None and slowing > STIFFNESS * float(turning.max(initial=0.0)) > 0.0


def _kind(scene: Scene) -> str:
    """The class of bodies that a scheme is calibrated on."""
    if scene.outside is not None:
        return "driven"
    if isinstance(scene, FreeBody) or not scene.weight.any():
        return scene.kind
    axes = lagrange_axes(np.array([scene.body.moments]), scene.weight[np.newaxis])
    return "lagrange" if axes[0] else scene.kind


def map_plan(spec: MapSpec) -> Plan:
    """The plan of a map; its numbers are those of the costliest nominal start, run once."""
    rows = pixels(spec.scene, spec.start, spec.axes)
    real = possible(rows.moments)
    moments, weight = rows.moments[real], rows.weight[real]
    forms = closed_forms(spec.stable, moments, weight)
    if spec.is_driven:
        forms = np.full_like(forms, "")
    closed = forms != ""
    scheme = FALLBACK if spec.method in (AUTO, EXACT) else spec.method
    if spec.method not in (AUTO, EXACT):
        chosen, why = scheme, f"method = {scheme!r} was asked for"
    elif not closed.size:
        chosen, why = EXACT, "no pixel has a possible body: nothing is done"
    elif closed.all():
        chosen, why = EXACT, "every body has a closed form"
    elif closed.any():
        chosen, why = AUTO, f"{closed.sum():,} of {closed.size:,} pixels have a closed form"
    elif spec.is_driven:
        chosen, why = scheme, "no closed form under torque and damping"
    else:
        chosen, why = scheme, _why_not(spec.stable, moments[0], weight[0])
    rates = _map_rates(spec, rows, real, scheme)
    if chosen == AUTO:
        rates = rates[~closed]
    steps = None if spec.step is None else np.full(rates.shape, spec.step)
    varied = [axis.name.partition("/")[0] for axis in spec.axes]
    return Plan(
        scene=scene_words(spec.scene, varied),
        question=spec.criterion,
        closed_form=_listed(forms) if chosen in (AUTO, EXACT) else None,
        method=chosen,
        carried=_carried(spec.scene, spec.stable, chosen),
        why=(why,),
        left_out=_left_out(spec.scene, spec.stable, chosen, spec.step, forms),
        **numbers(
            "driven" if spec.is_driven else spec.scene.kind,
            spec.stable,
            EXACT if chosen == EXACT else scheme,
            forms,
            rates,
            spec.t_end,
            steps,
            spec.step,
            0,
        ),
    )


def _map_rates(spec: MapSpec, rows: Pixels, real: NDArray[np.bool_], scheme: str) -> Floats:
    """The rates that the steps of each possible pixel follow."""
    possible = np.flatnonzero(real)
    rates = np.empty(len(possible))
    starts = rows.omega[possible], rows.attitude[possible]
    for mine, table in tables(spec.scene, rows, possible, *starts):
        rates[mine] = fastest_rates(table, (0.0, spec.t_end), scheme)
    return rates


def require_closed_forms(spec: MapSpec) -> None:
    """Raise ValueError, naming the first, if a possible body of a map has no closed form."""
    rows = pixels(spec.scene, spec.start, spec.axes)
    forms = closed_forms(spec.stable, rows.moments, rows.weight)
    if spec.is_driven:
        raise ValueError(f"method = {EXACT!r}: {_DRIVEN_RULE}")
    missing = np.flatnonzero(possible(rows.moments) & (forms == ""))
    if missing.size:
        flat = int(missing[0])
        pixel = tuple(int(i) for i in np.unravel_index(flat, spec.shape))
        moments = ", ".join(f"{moment:g}" for moment in rows.moments[flat])
        raise ValueError(
            f"method = {EXACT!r}: no closed form of {_question_words(spec.stable)} for the body of "
            f"pixel {pixel}, moments ({moments}); {_rule(spec.stable)}"
        )


def lagrange_axes(moments: Floats, weight: Floats) -> NDArray[np.intp]:
    """The symmetry axis 1, 2 or 3 of each Lagrange top, 0 for any other body; shape (n,).

    The moments about the other two axes are equal to the bit, the weight lies exactly on the axis.
    """
    axes = np.zeros(len(moments), dtype=np.intp)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        symmetric = moments[:, i] == moments[:, j]
        on_axis = (weight[:, i] == 0.0) & (weight[:, j] == 0.0) & (weight[:, k] != 0.0)
        axes[symmetric & on_axis] = k + 1
    return axes


def closed_forms(question: Question, moments: Floats, weight: Floats) -> NDArray[np.str_]:
    """The closed form that answers the question for each body from any start, or ""; shape (n,)."""
    first, second, third = moments.T
    pairs = np.array([first == second, second == third, third == first])
    free = np.select(
        [pairs.all(axis=0), pairs.any(axis=0)], ["axis spin", "free symmetric"], "free asymmetric"
    )
    weightless = ~weight.any(axis=1)
    axes = lagrange_axes(moments, weight)
    known = np.where(weightless, free, np.where(axes > 0, "lagrange", ""))
    if isinstance(question, NoFlip):
        return np.where(weightless | (axes == question.axis), known, "")
    if isinstance(question, TiltBelow):
        vertical = question.reference == "vertical"
        return np.where(vertical & (axes == abs(question.axis)) & ~weightless, known, "")
    return known


def _resolved(scene: Scene, question: object, table: Mapping[str, Any] | None) -> Question:
    """The question with its defaults filled in."""
    if isinstance(question, TiltBelow):
        return question.resolved(scene, Start(spin=0.0))
    if isinstance(question, NoFlip):
        if question.axis is None and table is not None and len(table["omega"]) == 1:
            return question.resolved(scene, Start(omega=table["omega"][0]))
        if question.axis is None and isinstance(scene, HeavyTop):
            raise ValueError("no_flip() without an axis: say no_flip(axis) to plan for a top")
        return question
    if isinstance(question, str):
        return one_of("question", question, RECORDS)
    raise TypeError(
        f"question = {question!r}: must be one of {', '.join(map(repr, RECORDS))}, "
        "rigid.no_flip() or rigid.tilt_below(angle)"
    )


def _question_words(question: Question) -> str:
    return RECORDS[question] if isinstance(question, str) else str(question)


def _rule(question: Question) -> str:
    return _STATES_RULE if isinstance(question, str) else _CLASS_RULE


def _listed(forms: NDArray[np.str_]) -> str | None:
    """The closed forms that occur."""
    return ", ".join(sorted(set(forms.tolist()) - {""})) or None


def _choice(
    scene: Scene,
    question: Question,
    forms: NDArray[np.str_],
    method: str | None,
    step: float | None,
) -> tuple[str, list[str]]:
    """The method, and why."""
    if method is not None:
        return method, [f"method = {method!r} was asked for"]
    if scene.outside is not None and "" in forms:
        return FALLBACK, ["no closed form under torque and damping"]
    if "" in forms:
        return FALLBACK, [_why_not(question, np.array(scene.body.moments), scene.weight)]
    if step is not None:
        return FALLBACK, ["a step was asked for"]
    if not forms.size:
        return EXACT, ["there are no bodies: nothing is done"]
    return EXACT, ["every body has a closed form"]


def _why_not(question: Question, moments: Floats, weight: Floats) -> str:
    """Why this body has no closed form."""
    axis = int(lagrange_axes(moments[np.newaxis], weight[np.newaxis])[0])
    if axis or not weight.any():
        symmetry = f": the symmetry axis is {axis}" if axis else ""
        return f"no closed form of {_question_words(question)}{symmetry}"
    reasons = {
        1: "the centre of mass is on no principal axis",
        2: "the centre of mass is not on the symmetry axis",
        3: "no two moments of the top are equal to the bit",
    }
    return f"no closed form: {reasons[len(set(moments.tolist()))]}"


def _left_out(
    scene: Scene,
    question: Question,
    method: str,
    step: float | None,
    forms: NDArray[np.str_],
) -> tuple[str, ...]:
    """What is not done, and why not."""
    left = []
    if method == EXACT:
        reasons = {
            "free symmetric": "symmetric: no elliptic functions",
            "lagrange": "symmetric: closed form, no steps",
            "pendulum": "plane swing: closed form, no steps",
        }
        if scene.outside is not None:
            left.append("damping a multiple of the inertia: the free motion, slowed; no steps")
        elif isinstance(scene, FreeBody):
            left.append("no torque: no steps")
        left.extend(reasons[form] for form in sorted(set(forms.tolist())) if form in reasons)
        if step is not None:
            left.append(f"closed form: step = {step:g} is not needed")
    if not isinstance(question, str):
        left.append(
            "class only: no trajectory, no attitude"
            if method == EXACT
            else "class only: no attitude, no trajectory kept"
        )
    elif question != "attitude" and "attitude" not in _carried(scene, question, method):
        left.append(f"{'rates' if question == 'rates' else 'vertical'} only: no attitude")
    if "gamma" not in _carried(scene, question, method) and (
        isinstance(scene, FreeBody) and question in ("rates", "attitude")
    ):
        left.append("no weight: no vertical")
    return tuple(left)


def _carried(scene: Scene, question: Question, method: str) -> tuple[str, ...]:
    """The variables that are computed."""
    exact = method == EXACT
    if scene.outside is not None and not isinstance(question, str):
        bare = isinstance(scene, FreeBody) and isinstance(question, NoFlip)
        in_space = scene.torque is not None and scene.torque.acts_in_space
        return ("omega",) if bare and not in_space else ("omega", "gamma", "attitude")
    if isinstance(question, NoFlip):
        return () if exact else ("omega",) if isinstance(scene, FreeBody) else ("omega", "gamma")
    if isinstance(question, TiltBelow):
        return () if exact else ("omega", "gamma")
    heavy = isinstance(scene, HeavyTop)
    if scene.outside is not None and not exact:
        in_space = scene.torque is not None and scene.torque.acts_in_space
        bare = question == "rates" and not heavy and not in_space
        return ("omega", "work") if bare else ("omega", "gamma", "attitude", "work")
    if exact:
        # The rates of a top and every vertical come from the attitude.
        return {
            "rates": ("omega", "attitude") if heavy else ("omega",),
            "axis": ("omega", "gamma", "attitude"),
            "attitude": ("omega", "attitude"),
        }[question]
    return {
        "rates": ("omega", "gamma") if heavy else ("omega",),
        "axis": ("omega", "gamma"),
        "attitude": ("omega", "gamma", "attitude") if heavy else ("omega", "attitude"),
    }[question]


def _time_words(nanoseconds: float) -> str:
    for limit, unit, size in ((1e3, "ns", 1.0), (1e6, "µs", 1e3), (1e9, "ms", 1e6)):
        if nanoseconds < limit:
            return f"{nanoseconds / size:.3g} {unit}"
    return f"{nanoseconds / 1e9:.3g} s"
