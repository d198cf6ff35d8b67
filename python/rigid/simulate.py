"""States of one body or many at wanted times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, one_of, positive_int, resolve_threads, sorted_times
from .belief import Belief, around, span_of
from .columns import check_scene, columns, laid_out, unit_of
from .methods import EXACT, series_methods
from .plan import RECORDS, Plan, decide
from .scenes import Scene, scene_from_dict
from .stepping import Request, by_steps, of_closed_form

if TYPE_CHECKING:
    from os import PathLike
    from pathlib import Path

    from scipy.spatial.transform import Rotation

__all__ = ["Run", "Status", "simulate"]


class Status(IntEnum):
    """How a body ended."""

    OK = 0  #: at the last wanted time
    FINISHED = 0  #: the same
    STOPPED = 1  #: when the question of a map was answered
    STEP_LIMIT = 2  #: it would have needed more than ``max_steps``: not run, or stopped there
    NOT_FINITE = 3  #: overflow or NaN: too long a step, or a phase beyond 2**50 turns
    DRIFTED = 4  #: energy, momentum or unit lengths off by more than 0.1: the step is too long
    FLAGGED = 5  #: its error is above the accuracy asked for, or 1 or more: see ``lost_from``


@dataclass(frozen=True, slots=True)
class Run:
    """What :func:`simulate` returns. With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (n, m, 3)
        Angular velocity in the body (rad/s).
    gamma : ndarray, shape (n, m, 3), or None
        Upward vertical seen from the body, if it was carried.
    attitude : ndarray, shape (n, m, 4), or None
        Quaternion, scalar first, body to space, if it was recorded. Not renormalised.
    work : ndarray, shape (n, m), or None
        Work done on the body by torque and damping since ``t = 0`` (J), integrated with the motion;
        None of a scene without them.
    energy_drift : ndarray, shape (n,)
        Largest error of the energy at a wanted time, relative to the kinetic energy at the start
        (plus ``mgl`` for a top). Under torque and damping: of the energy less the ``work``, the
        residual of the power balance ``dE/dt = torque·omega - omega·D omega``, relative to the
        energy that the body can reach. Of ``"etd4"`` and ``"splitting"`` the
        ``work`` is what the kinetic energy gained but for the work of the weight: of a body without
        weight the residual tells nothing.
    momentum_drift : ndarray, shape (n,)
        The same of the conserved angular momentum: ``|L|`` of a free body, relative to itself;
        ``L·gamma`` of a top, relative to ``|L| + sqrt(mgl I_max)`` at the start. Under torque and
        damping: of ``L·gamma`` (of ``L·L`` where rates alone are carried) less what they added;
        ``"etd4"`` and ``"splitting"`` keep that by construction, ``"midpoint"`` both balances.
    unit_drift : ndarray, shape (n,)
        Largest deviation of ``|gamma|`` and ``|q|`` from one; 0 if neither is carried.
    status : ndarray of uint8, shape (n,)
        A :class:`Status` for each body. ``FLAGGED`` follows from ``error``, which of a large call
        may be that of a sample; the others are the body's own.
    steps : ndarray of uint64, shape (n,)
        Steps taken; 0 by closed form.
    error : ndarray, shape (n,)
        What the run believes its error to be: of the rates relative to the fastest, of the vertical
        and the attitude in rad, the largest at up to 16 of the times, the last among them. By steps
        it is three times the difference from a second run with shorter steps; of a call with more
        than 32 bodies and no ``accuracy``, a sample of 32 is run again and the others are given its
        largest error. By closed form, ``1e-15`` per radian turned. NaN for a body that was not run.
    lost_from : ndarray, shape (n,)
        Time from which on, away from 0, the error is 1 or more: from there the state is numerical,
        not physical. Negative if that is backward in time; infinite if there is none; NaN for a
        body that was not run or overflowed.
    nanoseconds : int
        Processor time of the states, of all threads together; not that of the second run.
    spec : dict
        Scene, method, step, accuracy, tolerance and record, as plain data.
    plan : Plan
        What was done, what was left out, and why.
    """

    t: NDArray[np.float64]
    omega: NDArray[np.float64]
    gamma: NDArray[np.float64] | None
    attitude: NDArray[np.float64] | None
    work: NDArray[np.float64] | None
    energy_drift: NDArray[np.float64]
    momentum_drift: NDArray[np.float64]
    unit_drift: NDArray[np.float64]
    status: NDArray[np.uint8]
    steps: NDArray[np.uint64]
    error: NDArray[np.float64]
    lost_from: NDArray[np.float64]
    nanoseconds: int
    spec: dict[str, Any]
    plan: Plan

    @property
    def flagged(self) -> NDArray[np.bool_]:
        """Whether the error is above the accuracy asked for, or, if none was, 1 or more."""
        flagged: NDArray[np.bool_] = np.asarray(self.error) >= self._limit
        return flagged

    @property
    def _limit(self) -> float:
        wanted = self.spec["accuracy"]
        return 1.0 if wanted is None else float(wanted)

    def reasons(self) -> tuple[str, ...]:
        """How each body ended, in words.

        Examples
        --------
        >>> import rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> run = rigid.simulate(
        ...     box, [[1.0, 0.0, 0.1], [1e-12, 1.0, 1e-12]], t=[100.0], method="rk4"
        ... )
        >>> for words in run.reasons():
        ...     print(words)
        ok
        flagged: the error is believed to be 1 or more from t = 50.8 on
        """
        statuses, errors, lost = (
            np.atleast_1d(values) for values in (self.status, self.error, self.lost_from)
        )
        return tuple(
            self._reason(Status(status), float(error), float(since))
            for status, error, since in zip(statuses, errors, lost, strict=True)
        )

    def _reason(self, status: Status, error: float, since: float) -> str:
        if status == Status.FLAGGED:
            words = f"{error:.1e}, above the {self._limit:g} asked for"
            if np.isfinite(since):
                words = f"1 or more from t = {since:.4g} on"
            return f"flagged: the error is believed to be {words}"
        return {
            Status.OK: "ok",
            Status.STOPPED: "stopped when the question was answered",
            Status.STEP_LIMIT: "step limit: it needs more than max_steps steps",
            Status.NOT_FINITE: "not finite: a number overflowed",
            Status.DRIFTED: "drifted: energy, momentum or a length is off by more than 0.1",
        }[status]

    def energy(self) -> NDArray[np.float64]:
        """Kinetic and potential energy ``omega·I omega / 2 + mgl com·gamma`` (J), shape (n, m).

        Under torque and damping it changes by the :attr:`work`.

        Raises
        ------
        ValueError
            If a top's vertical was not recorded.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> wheel = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.8)), damping=0.2)
        >>> run = rigid.simulate(wheel, [0.0, 0.3, 2.0], t=[0.0, 5.0])
        >>> bool(np.isclose(np.diff(run.energy())[0], run.work[-1]))
        True
        """
        scene = scene_from_dict(self.spec["scene"])
        energy: NDArray[np.float64] = 0.5 * (self.omega**2 @ np.array(scene.body.moments))
        if not scene.weight.any():
            return energy
        if self.gamma is None:
            raise ValueError("record = 'rates': the potential energy of a top needs its vertical")
        return energy + self.gamma @ scene.weight

    def rotation(self) -> Rotation:
        """The attitudes as a SciPy ``Rotation`` of shape ``(n, m)`` (active, body to space).

        Raises
        ------
        ValueError
            If the attitude was not recorded.
        """
        if self.attitude is None:
            raise ValueError(
                "record = 'attitude' was not asked for: there is no attitude to return"
            )
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.attitude, scalar_first=True)

    def animate(self, path: str | PathLike[str], **options: Any) -> Path:
        """Write the motion to a page or a picture that moves: :func:`rigid.animation.animate`."""
        from .animation import animate

        return animate(self, path, **options)


def simulate(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike,
    method: str | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    tolerance: float | None = None,
    record: str = "attitude",
    check: bool = True,
    max_steps: int = 10**9,
    threads: int | None = None,
) -> Run:
    """States of one body or many at the wanted times, by closed form where there is one.

    A free body and a top with two equal moments and its centre of mass on the third axis have a
    closed form: it is evaluated at each wanted time and takes no steps. Anything else is
    integrated, unless all tops of the call swing as pendulums about a principal axis; so is what
    moves under torque or damping. With a given
    method each body is independent of the others: its numbers are the same bits alone, in any
    batch, on any processor and for any number of threads.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body and what acts on it.
    omega : array_like, shape (3,) or (n, 3)
        Angular velocity at ``t = 0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitude at ``t = 0``: quaternion, scalar first, body to space; normalised here. Default:
        body and space axes coincide.
    t : array_like, shape (m,)
        Wanted times (s), ascending; negative times are reached backward from 0.
    method : str, optional
        ``"exact"``, the closed form, or one of :func:`rigid.methods`. Default: ``"exact"`` where
        all bodies have a closed form and no step is given, else ``"rk4"``; under damping ten times
        as fast as the turning, ``"etd4"``. Steps are equal between wanted times and end exactly on
        them, and on the knots of a torque's table.
    step : float, optional
        Largest step (s). Default: each body turns by at most the ``angle_per_step`` of the method a
        step, from a bound of its rates.
    accuracy : float, optional
        Wanted error of the last state, relative to its size (see :attr:`Run.error`), instead of a
        step. Method and step follow from a calibrated model of the error; every body is then run
        again with shorter steps, and with shorter ones still until its error is below. A body that
        cannot be brought there, by chaos or rounding, is :attr:`Run.flagged`.
    tolerance : float, optional
        Of a Taylor method, instead of a step: each body takes steps of its own, as long as the last
        terms of its series stay below this share of the largest rate and of a unit vector. Wanted
        times between two steps cost no step.
    record : {"attitude", "axis", "rates"}
        What is carried: the attitude; or the vertical seen from the body; or rates only. Asking for
        less is faster and changes no bit of the rates.
    check : bool
        Whether steps are checked by a second run with shorter ones, which tells the error. Without
        it the error is NaN; an ``accuracy`` cannot do without.
    max_steps : int
        A body that would need more has the status ``STEP_LIMIT``: it is not run, or with a
        tolerance stopped there.
    threads : int, optional
        Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

    Returns
    -------
    Run
        Named arrays; see :class:`Run`.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: not finite, wrong shape, zero quaternion,
        unsorted times, unknown method or record, step, accuracy or tolerance not positive, a
        tolerance for what is no Taylor method, ``"exact"`` for a body without a closed form. Under
        torque and damping: a method that does not know of them, a step with which an explicit
        method would blow up, a time that the table of the torque does not reach.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> book = rigid.FreeBody(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3))
    >>> run = rigid.simulate(book, [1e-10, 1.0, 1e-10], t=[0.0, 26.634])
    >>> run.plan.method, int(run.steps)
    ('exact', 0)
    >>> bool(abs(run.omega[-1, 1]) < 1e-3)  # it has left the middle axis by then
    True
    """
    check_scene(scene)
    one_of("record", record, RECORDS)
    table, single = columns(scene, omega, attitude)
    times = sorted_times("t", t)
    if tolerance is not None:
        tolerance = _checked_tolerance(tolerance, method, step, accuracy)
    made, steps = decide(
        scene,
        record,
        table=table,
        span=span_of(times),
        back=around(times)[0],
        accuracy=accuracy,
        method=method,
        step=step,
        states=len(times),
    )
    if tolerance is not None:
        own = f"each body takes its own steps, last terms below {tolerance:g}"
        made = replace(made, why=(*made.why, own), step=None, steps=None, cost=None, error=None)
    request = Request(
        table=table,
        times=times,
        method=made.method,
        record=record,
        max_steps=positive_int("max_steps", max_steps),
        threads=resolve_threads(threads),
        tolerance=tolerance,
    )
    if made.method == EXACT:
        states = request.states(table, None)
        belief = of_closed_form(table, times)
    else:
        states, belief = by_steps(request, steps, accuracy, check=check)
    if states["work"] is not None:
        states["work"] = np.ldexp(states["work"], unit_of(scene))
    spec = {
        "scene": scene.to_dict(),
        "method": made.method,
        "step": None if made.method == EXACT else step,
        "accuracy": accuracy,
        "tolerance": tolerance,
        "record": record,
    }
    return _to_run(states, times, belief, spec, made, single=single)


def replay_steps(
    scene: Scene,
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    *,
    method: str,
    step: float,
    strides: Sequence[int],
) -> Run:
    """A body of a map again: its states after these numbers of steps of exactly ``step``."""
    table = laid_out(scene, omega.reshape(1, 3), attitude.reshape(1, 4), 1)
    times = np.cumsum(strides) * step
    made, steps = decide(
        scene, "attitude", table=table, span=span_of(times), method=method, step=step
    )
    states = _core.simulate(
        **table,
        method=method,
        record="attitude",
        step=steps,
        max_steps=2**63,
        threads=1,
        strides=list(strides),
    )
    spec = {
        "scene": scene.to_dict(),
        "method": method,
        "step": step,
        "accuracy": None,
        "tolerance": None,
        "record": "attitude",
    }
    # The map that this sample comes from knows what is believed of it.
    unknown = Belief(np.full(1, np.nan), np.full(1, np.nan))
    return _to_run(states, times, unknown, spec, made, single=True)


def _checked_tolerance(
    tolerance: float, method: str | None, step: float | None, accuracy: float | None
) -> float:
    """The tolerance, if it is one and if the method chooses its steps by it."""
    tolerance = finite_float("tolerance", tolerance, positive=True)
    if tolerance >= 1.0:
        raise ValueError(f"tolerance = {tolerance:g}: must be below one")
    for name, value in (("step", step), ("accuracy", accuracy)):
        if value is not None:
            raise ValueError(
                f"tolerance = {tolerance:g}, {name} = {value:g}: exclude each other, "
                "because the steps follow from the tolerance"
            )
    if method not in series_methods():
        raise ValueError(
            f"tolerance = {tolerance:g}, method = {method!r}: only "
            f"{', '.join(map(repr, series_methods()))} choose their steps by a tolerance"
        )
    return tolerance


def _to_run(
    states: dict[str, Any],
    times: NDArray[np.float64],
    belief: Belief,
    spec: dict[str, Any],
    made: Plan,
    *,
    single: bool,
) -> Run:
    def of_body(values: Any) -> Any:
        return values[0] if single and values is not None else values

    limit = 1.0 if spec["accuracy"] is None else spec["accuracy"]
    unknown = np.isin(states["status"], (Status.STEP_LIMIT, Status.NOT_FINITE))
    belief = Belief(*(np.where(unknown, np.nan, x) for x in (belief.error, belief.lost_from)))
    lost = (states["status"] == Status.OK) & (belief.error >= limit)
    states["status"] = np.where(lost, np.uint8(Status.FLAGGED), states["status"])
    return Run(
        t=times,
        omega=of_body(states["omega"]),
        gamma=of_body(states["vertical"]),
        attitude=of_body(states["attitude"]),
        work=of_body(states["work"]),
        energy_drift=of_body(states["energy_drift"]),
        momentum_drift=of_body(states["momentum_drift"]),
        unit_drift=of_body(states["unit_drift"]),
        status=of_body(states["status"]),
        steps=of_body(states["steps"]),
        error=of_body(belief.error),
        lost_from=of_body(belief.lost_from),
        nanoseconds=states["nanoseconds"],
        spec=spec,
        plan=made,
    )
