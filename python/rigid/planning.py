"""The plan of a question before its computation: of states by ``solve``, of a class by ``maps``."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks.arguments import brief, finite_float, one_of, positive_int
from ._checks.arrays import AttitudeLike
from ._timing import LEAST_SHARE, LEAST_STEPS, seconds_of_one
from .maps.job import to_core
from .maps.plan import map_plan, of_one_pixel, shortened
from .maps.spec import MapSpec
from .model.bodies import bodies_of
from .model.body import Body
from .model.criteria import known_criteria
from .model.criterion import Criterion
from .model.mixture import Mixture
from .model.scene import Scene, check_scene
from .model.start import Start
from .solve.choose_method import plan_states
from .solve.closed_form import RECORDS
from .solve.methods import EXACT
from .solve.plan import Plan
from .solve.request import Problem
from .solve.run import Run
from .solve.simulate import simulate
from .store.call import run_map

SAMPLES = 1000
"""Bodies of a pixel if their number is not given."""


def plan(
    scene: Scene | Body,
    question: str | Criterion = "attitude",
    *,
    omega: ArrayLike | None = None,
    attitude: AttitudeLike | None = None,
    start: Start | Mixture | None = None,
    t_end: float | None = None,
    accuracy: float | None = None,
    method: str | None = None,
    step: float | None = None,
    bodies: int | None = None,
    times: int | None = None,
    cost: bool = False,
) -> Plan:
    """Plan a call of :func:`simulate` or a pixel of :func:`stability_map`: method, steps, reasons.

    A question in words requests states at output times, as :func:`simulate` returns. A criterion
    requests a class: its plan is the plan of the map with the same scene, criterion, start,
    horizon, method and step, in a pixel that no axis changes.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, or for states many, with weight, applied torque and damping.
    question : {"rates", "axis", "attitude"} or Criterion
        The recorded states, or a criterion: :func:`no_flip`, :func:`tilt_below`, :func:`regular`
        and the others that :func:`stability_map` takes.
    omega : array_like, optional
        Initial rates (rad/s): of states as in :func:`simulate`; for a criterion of one body, short
        for ``start=rigid.Start(omega=omega)``. The step, the number of steps and the error follow
        from the rates.
    attitude : array_like, optional
        Initial attitudes of states, as in :func:`simulate`: they show whether a top swings as a
        pendulum.
    start : Start or Mixture, optional
        The start of a criterion, by default the start of :func:`stability_map`.
    t_end : float, optional
        Horizon (s). A criterion needs one, unless it is :func:`judged`, which has times.
    accuracy : float, optional
        Largest error of the last state relative to its size. A closed form reaches this accuracy;
        otherwise the accuracy, the rates and the horizon determine the cheapest method and its
        step. Default without a method and a step: 1e-8. A criterion has none: a map classifies
        bodies again whose class an error could change.
    method : str, optional
        ``"exact"`` or one of :func:`rigid.methods`; by default the method of :func:`simulate` or of
        :func:`stability_map`.
    step : float, optional
        Longest step (s).
    bodies : int, optional
        Number of bodies of the call, which the memory and the cost of one depend on. Default: the
        number of ``omega``. Of a criterion the samples of the pixel; default: 1000.
    times : int, optional
        Number of output times, which memory and cost depend on. Default: 1. A criterion has none.
    cost : bool
        Whether to measure :attr:`Plan.cost`, and the error of steps: by the call itself of some of
        the bodies, up to a share of the horizon if they take long. That takes half a second at
        most. States need ``omega`` and ``t_end`` for it; the output times are evenly spaced.

    Returns
    -------
    Plan

    Raises
    ------
    TypeError
        If a criterion lacks its horizon.
    ValueError
        As for :func:`stability_map`; if ``"exact"`` is requested and a body has no closed form; if
        the accuracy is beyond float64; if the rates or the horizon are missing, from which the step
        follows, or that the cost needs; if an argument belongs to the other kind of question.

    Examples
    --------
    >>> import rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> made = rigid.plan(scene, "rates", omega=[0.1, 1.0, 0.2], t_end=100.0)
    >>> print(made)  # doctest: +ELLIPSIS
    scene       free body, moments (1, 2, 3)
    question    rates at output times
    method      exact, closed form: free asymmetric
    carried     omega
    why         every body has a closed form
    left out    no torque: no steps; rates only: no attitude; no weight: no vertical
    error       about 1.6e-13 rad
    memory      65 bytes for the states

    What a body of this call takes, measured:

    >>> rigid.plan(scene, omega=[0.1, 1.0, 0.2], t_end=100.0, cost=True).cost > 0.0
    True

    The largest tilt of a free body has no closed form:

    >>> start = rigid.Start(spin=1.0, axis=3, tilt=0.1)
    >>> made = rigid.plan(scene, rigid.tilt_below(0.5), start=start, t_end=100.0)
    >>> result = rigid.stability_map(
    ...     scene, axes={"tilt": [0.1]}, stable=rigid.tilt_below(0.5), start=start, t_end=100.0,
    ...     samples=1,
    ... )
    >>> made == result.plan
    True
    """
    if isinstance(question, Criterion):
        for name, value, why in (
            ("attitude", attitude, "the start of a map is given by start"),
            ("accuracy", accuracy, "a map classifies again what an error could change"),
            ("times", times, "a class is no state at output times"),
        ):
            if value is not None:
                raise ValueError(f"{name} = {brief(value)}: has no place beside a criterion: {why}")
        if omega is not None:
            if start is not None:
                raise ValueError("omega, start: exclude each other, because both are the start")
            start = Start(omega=omega)  # type: ignore[arg-type]  # normalised
        asked = of_one_pixel(scene, question, start=start, t_end=t_end, method=method, step=step)
        to_core(asked)  # which refuses what no map computes
        samples = SAMPLES if bodies is None else positive_int("bodies", bodies)
        made = map_plan(asked)
        return _timed_map(made, asked, samples) if cost else made
    if not isinstance(question, str):
        raise TypeError(
            f"question = {brief(question)}: must be one of {', '.join(map(repr, RECORDS))}, "
            f"{known_criteria()}"
        )
    if start is not None:
        raise ValueError(
            f"start = {brief(start)}: belongs to a criterion; states start from omega and attitude"
        )
    scene = check_scene(scene, many=True)
    if omega is None and attitude is not None:
        raise ValueError("attitude: says nothing without omega; give both")
    problem = Problem(
        scene=scene,
        record=one_of("question", question, RECORDS),
        bodies=None if omega is None else bodies_of(scene, omega, attitude, rod=True),
        reach=None if t_end is None else (0.0, finite_float("t_end", t_end, positive=True)),
        accuracy=accuracy,
        method=method,
        step=step,
        states=1 if times is None else positive_int("times", times),
        number=None if bodies is None else positive_int("bodies", bodies),
    )
    made = plan_states(problem)
    if not cost:
        return made
    if omega is None or t_end is None:
        name = "omega" if omega is None else "t_end"
        raise ValueError(f"cost = True: some of the bodies are run, for which {name} is missing")
    return _timed_states(made, problem)


def _timed_states(made: Plan, problem: Problem) -> Plan:
    """The plan of a valid call of :func:`simulate`, with its cost and the error of its steps."""
    bodies, t_end = problem.bodies, problem.span
    assert bodies is not None
    assert isinstance(t_end, float)
    # The most steps of a body under a function are a hundredth of others.
    first = 100.0 * LEAST_SHARE if "function" in problem.scene.forces else LEAST_SHARE
    if not len(bodies):
        raise ValueError("cost = True: some of the bodies are run, and there are none")
    alone = not bodies.shape and problem.number in (None, 1)

    def run(count: int, share: float) -> Run:
        # Fewer bodies than the call has are repeated.
        part = problem.select(np.resize(_spread_indices(len(bodies), count), count))
        own, row = part.bodies, 0 if alone else slice(None)
        assert own is not None
        return simulate(
            part.scene,
            own.omega[row],
            own.attitude[row],
            t=np.linspace(0.0, share * t_end, math.ceil(share * problem.states) + 1)[1:],
            max_steps=None if share == 1.0 else int(LEAST_STEPS * share / first),
            progress=False,
            record=problem.record,
            accuracy=problem.accuracy,
            method=problem.method,
            step=problem.step,
        )

    seconds, whole = seconds_of_one(run, problem.number or len(bodies), share=first)
    error = made.error
    if whole is not None and made.method != EXACT:
        worst = float(np.fmax.reduce(np.ravel(whole.error)))  # NaN of bodies that are not checked
        error = worst if worst < 1.0 else None
    return dataclasses.replace(made, cost=1e9 * seconds, error=error)


def _timed_map(made: Plan, spec: MapSpec, samples: int) -> Plan:
    """The plan of a criterion with the cost of a sample."""
    moments = np.asarray(spec.scene.body.moments)
    axis = int(moments.argmax())
    # A map has an axis; this one changes nothing.
    whole = spec.replace(axes={f"I{axis + 1}": moments[axis : axis + 1]})

    def run(count: int, share: float) -> None:
        run_map(shortened(whole, share).replace(samples=count), progress=False)

    seconds, _ = seconds_of_one(run, samples)
    return dataclasses.replace(made, cost=1e9 * seconds)


def _spread_indices(count: int, most: int) -> NDArray[np.intp]:
    """At most ``most`` indices below ``count``, evenly spread, the last one among them."""
    # From the last to the first: a single one is the last.
    spread = (count - 1) - np.linspace(0, count - 1, min(count, most))
    return np.unique(spread.round().astype(np.intp))
