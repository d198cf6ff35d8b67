"""The plan of a question before its computation: of states by ``solve``, of a class by ``maps``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ._checks.arguments import brief
from .maps.job import to_core
from .maps.plan import map_plan
from .maps.request import of_one_pixel
from .model.body import Body
from .model.criteria import Criterion, known_criteria
from .model.mixture import Mixture
from .model.scene import Scene
from .model.start import Start
from .solve.choose_method import plan_states
from .solve.closed_form import RECORDS
from .solve.plan import Plan

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["plan"]


def plan(
    scene: Scene | Body,
    question: str | Criterion = "attitude",
    *,
    omega: ArrayLike | None = None,
    attitude: ArrayLike | Rotation | None = None,
    start: Start | Mixture | None = None,
    t_end: float | None = None,
    accuracy: float | None = None,
    method: str | None = None,
    step: float | None = None,
    bodies: int | None = None,
    times: int | None = None,
) -> Plan:
    """Plan a call of :func:`simulate` or a pixel of :func:`stability_map`: method, steps and cost.

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
        Number of bodies of the call, which the cost of one depends on. Default: the number of
        ``omega``; without ``omega`` many. Of a criterion many bodies share a call.
    times : int, optional
        Number of output times, which cost and memory depend on. Default: 1. A criterion has none.

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
        follows; if an argument belongs to the other kind of question.

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
    cost        about ... µs a body
    error       about 1.6e-13 rad
    memory      65 bytes for the states

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
            ("bodies", bodies, "many bodies of a map share a call"),
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
        return map_plan(asked)
    if not isinstance(question, str):
        raise TypeError(
            f"question = {brief(question)}: must be one of {', '.join(map(repr, RECORDS))}, "
            f"{known_criteria()}"
        )
    if start is not None:
        raise ValueError(
            f"start = {brief(start)}: belongs to a criterion; states start from omega and attitude"
        )
    return plan_states(
        scene,
        question,
        omega=omega,
        attitude=attitude,
        t_end=t_end,
        accuracy=accuracy,
        method=method,
        step=step,
        bodies=bodies,
        times=times,
    )
