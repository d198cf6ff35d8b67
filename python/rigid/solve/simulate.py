"""States of one body or many at given times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .._checks.arguments import (
    brief,
    finite_float,
    one_of,
    positive_int,
    resolve_threads,
    times_of_each,
)
from .._checks.float_environment import in_standard_floats
from .._checks.progress import Listening, ProgressOption
from ..model.batch import in_rows
from ..model.bodies import Bodies, bodies_of, time_ranges
from ..model.body import Body
from ..model.events import Event, checked_events
from ..model.frame import checked_frame
from ..model.scene import Scene, check_scene
from ..model.torque import NO_EXPONENT
from .choose_method import choose_method
from .closed_form import RECORDS
from .conserved import energy_of, momentum_of, needs_vertical
from .events import check_event_method
from .methods import FUNCTION, adaptive_methods
from .request import LEAST_TOLERANCE, MOST_STEPS, Problem
from .run import Run, to_run
from .solution import (
    DERIVED,
    PLAIN,
    Solution,
    Target,
    end_records,
    solve,
)
from .surfaces import Watched
from .tangent import check_parameters, check_tangent

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

AT_ONCE = 2**16
"""So many states in closed form take less than a tenth of a second: no progress is shown."""


@in_standard_floats
def simulate(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t: ArrayLike,
    states: ArrayLike | None = None,
    method: str | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    tolerance: float | None = None,
    record: str | Sequence[str] = "attitude",
    check: bool = True,
    tangent: bool | str | Sequence[str] = False,
    events: Event | Sequence[Event] | None = None,
    until: Event | Sequence[Event] | None = None,
    count: int | None = None,
    max_steps: int | None = None,
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
    out: Mapping[str, NDArray[Any]] | None = None,
    frame: ArrayLike | None = None,
    progress: ProgressOption = None,
) -> Run:
    """Compute the motion of one body or many: rates and attitudes at the given times.

    The closed form is used where there is one: for a free body, and for a top with two equal
    moments and its centre of mass on the third axis. It is evaluated at each given time and takes
    no steps. A top that swings as a pendulum about a principal axis has one too. All other bodies
    are integrated, and bodies under forces unless their only force is damping that is a multiple of
    their inertia. Each body is solved as if it were alone: its states and its error have the same
    bits in any batch, on any processor and for any number of threads.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body or many, with weight, applied torque, damping and other forces.
    omega : array_like, shape (3,) or (..., 3)
        Angular velocity at ``t = 0`` in the body (rad/s). The leading axes of the scene, the rates
        and the attitudes broadcast.
    attitude : array_like, shape (4,) or (..., 4), or scipy Rotation, optional
        Attitude at ``t = 0``: a quaternion, scalar first, that takes body components to space
        components; it is normalised. Default: body and space axes coincide.
    t : array_like, shape (m,) or (..., m)
        Output times (s), ascending; negative times are reached backward from 0. Leading axes give
        each body its times.
    states : array_like, shape (k,) or (..., k), optional
        States of :meth:`Torque.call` with ``states=k`` at ``t = 0``. Default: zero.
    method : str, optional
        ``"exact"``, the closed form, or one of :func:`rigid.methods`. Default for each body:
        ``"exact"`` if it has a closed form and no step is given; ``"dop853"`` under
        :meth:`Torque.call`; ``"taylor20"`` on an orbit or with events, with a tolerance of 1e-16 if
        no step is given; else ``"rk4"`` if a step is given, ``"etd4"`` if damping is ten times as
        fast as its turning, and ``"dop853"``, as for a body that drag stops.
    step : float, optional
        Largest step (s). Default with a method: each body turns by at most the ``angle_per_step``
        of the method a step, from a bound of its rates.
    accuracy : float, optional
        Largest error of all states (see :attr:`Run.error`), instead of a step. Default without a
        method and a step: 1e-8. ``"dop853"`` first takes equal steps, whose angle follows from the
        accuracy. A body whose estimated error is above the accuracy is integrated again, by
        ``"taylor20"`` with a tolerance of 1e-16, which leaves rounding alone. A named Taylor
        method begins with a tolerance of 0.0002 times the accuracy, at most 1e-6, and ``"dop853"``
        under :meth:`Torque.call` with 0.01 times the accuracy; a body that misses the accuracy is
        run once more, down to rounding. Other methods, and bodies that drag may stop, take shorter
        equal steps instead, and :attr:`Run.plan` has the last step. A body whose error stays above,
        because of chaos or rounding, is :attr:`Run.flagged` if the accuracy was asked for.
    tolerance : float, optional
        Adaptive steps of a Taylor method, instead of a step: the steps of each body are as long as
        the last terms of its series stay below this share of the largest rate and of a unit vector.
        Output times between two steps need no extra step. Under :meth:`Torque.call` of
        ``"dop853"``, whose estimated error of each step stays below this share and whose steps end
        at output times; at least 1e-14.
    record : {"attitude", "axis", "rates"}, or sequence of str
        Recorded states: rates and attitude; rates and the vertical in body components; or rates
        only. A smaller record is faster and changes no bit of the rates, except of tops by
        Runge-Kutta methods, whose attitude has another error of the method. A sequence may add
        ``"energy"`` and ``"momentum"``: what :meth:`Run.energy` and :meth:`Run.momentum` return is
        then computed with the run, has its ``dtype``, may be in ``out``, and is saved.
    check : bool
        Whether the error is estimated by a second run. Without the second run the error is NaN and
        the status ``UNCHECKED``, and no tolerance is made smaller. An ``accuracy`` always needs the
        second run.
    tangent : bool or sequence of str
        Whether to return the derivative of the motion by its start, as :attr:`Run.tangent`. It is
        integrated by the ``method`` in the same steps, with an ``accuracy`` in the steps of
        :func:`plan`, else by ``"taylor16"`` in its default steps. It changes no bit of the states.

        With names of parameters the derivative by these, from the same start, is returned as
        :attr:`Run.sensitivity`. None of these parameters need act on the body:

        * ``"I1"``, ``"I2"``, ``"I3"``: moments (kg m²);
        * ``"mgl"`` (J) of a top, and ``"com1"``, ``"com2"``, ``"com3"``, the components of ``com``
          with ``mgl`` fixed, as if each were free, or ``"com"`` for the three;
        * ``"damping1"`` to ``"damping3"``, the diagonal of the damping matrix (N m s), or
          ``"damping"``, one coefficient added to all of the diagonal;
        * ``"torque1"`` to ``"torque3"``, a constant torque about a body axis, added to the torque
          (N m).

        Parameters of forces that act have the names of maps, such as ``"rotor1"``,
        ``"dissipation2"``, ``"drag"``, one coefficient added to all, and ``"rate"`` of an orbit.
    events : Event or sequence of Event, optional
        Events to find from 0 to the last time, made by :func:`crosses` and :func:`turns`.
        :attr:`Run.events` has their times and the states then. Events are found by the closed form
        or by a Taylor method in adaptive steps; they change no bit of the states. Without a
        ``method``, bodies without a closed form are integrated by a Taylor method.
    until : Event or sequence of Event, optional
        Events that end the record of a body. Its later states are NaN, :attr:`Run.end` is the time
        of its last event, and its status is ``STOPPED`` unless its error is large. These events are
        in :attr:`Run.events` too.
    count : int, optional
        The number of events that end the record: of the events of ``until`` together, by default
        the first; without ``until`` of all events together, by default none.
    max_steps : int, optional
        Most steps. A body that needs more has the status ``STEP_LIMIT``: it is not run, or with a
        tolerance it is stopped there. Default: 10**9; 10**7 under the torque of a function, whose
        jumps may ask for steps without end.
    threads : int, optional
        Number of threads. Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.
    dtype : {numpy.float64, numpy.float32}
        Type of all arrays of times but ``work`` and ``states``. They are computed in float64;
        float32 takes half the memory and rounds them, which :attr:`Run.error` includes.
    out : mapping of str to ndarray, optional
        Arrays to fill, by the names of the attributes of :class:`Run` with an axis of times:
        C-contiguous, of the shape that the run has, float64 or float32. The run refers to these
        arrays.
    frame : array_like, shape (3, 3), optional
        The body axes of ``omega`` and ``attitude`` and of all results, if these axes are not the
        principal axes: ``axes`` as :meth:`Body.from_tensor` returns. The scene has a ``frame=``
        for its vectors. The start is rounded once when it is turned; see :meth:`Run.in_frame`.
    progress : None, bool or callable
        As in :func:`stability_map`, for a call that takes more than 2 s. A callable gets a
        :class:`Progress` in hundredths twenty times a second, until the error is estimated too.

    Returns
    -------
    Run
        Named arrays; see :class:`Run`.

    Raises
    ------
    MemoryError
        Before the start, with the number of bytes, if the states do not fit into the memory of this
        machine or into the memory that the system grants.
    ValueError
        Naming the argument, its value and the rule:

        * numbers that are not finite, wrong shapes, a zero quaternion, unsorted times;
        * an unknown method or record; a step, accuracy or tolerance that is not positive;
        * a tolerance for a method without adaptive steps;
        * ``"exact"`` for a body without a closed form;
        * a ``tangent`` of a method without one, or by a parameter that the scene does not have;
        * a frame that is no rotation matrix, or a frame together with ``out``;
        * events of a method that is neither the closed form nor a Taylor method, or of a run that
          goes backward;
        * under torque and damping a method that cannot integrate them, a step with which an
          explicit method is unstable, or a time that the table of the torque does not reach.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> book = rigid.FreeBody(rigid.Body.box(0.01, 0.08, 0.25, mass=0.3))
    >>> run = rigid.simulate(book, [1e-10, 1.0, 1e-10], t=[0.0, 26.634])
    >>> run.plan.method, int(run.steps)
    ('exact', 0)
    >>> bool(abs(run.omega[-1, 1]) < 1e-3)  # it has left the middle axis by then
    True
    >>> boxes = rigid.FreeBody(rigid.Body([[1.0, 2.0, 2.5], [1.0, 1.0, 1.8]]))  # two bodies
    >>> rigid.simulate(boxes, [0.1, 1.0, 0.1], t=[0.0, 1.0, 2.0]).omega.shape
    (2, 3, 3)

    A body in the axes of its drawing, which are not its principal axes:

    >>> tensor = [[2.0, 0.3, 0.0], [0.3, 2.5, 0.1], [0.0, 0.1, 3.0]]
    >>> body, axes = rigid.Body.from_tensor(tensor)
    >>> run = rigid.simulate(body, [0.0, 0.0, 1.0], t=[0.0, 1.0], frame=axes)
    >>> bool(np.allclose(run.omega[0], [0.0, 0.0, 1.0]))
    True
    >>> bool(np.allclose(run.momentum("space"), np.array(tensor) @ [0.0, 0.0, 1.0]))
    True

    How the rates of a top after 2 s change with its moments and its weight:

    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
    >>> run = rigid.simulate(top, [0.3, 0.4, 1.0], t=[2.0], tangent=("I1", "I2", "I3", "mgl"))
    >>> run.parameters, run.sensitivity.shape
    (('I1', 'I2', 'I3', 'mgl'), (1, 6, 4))
    >>> scaled = run.sensitivity[0] @ [1.0, 1.6, 0.7, 1.2]  # moments and weight in other units
    >>> bool(abs(scaled).max() < 1e-13)
    True
    """
    scene = check_scene(scene, many=True)
    if states is not None:
        scene = scene.started(states)
    record, derived = _checked_record(record, scene)
    watched = None
    if events is not None or until is not None or count is not None:
        found, counted = checked_events(events, until)
        watched = Watched(found, counted, _checked_count(count, found, until))
        check_event_method(method, scene)
    parameters = check_parameters(tangent, scene)
    if parameters is not None:
        check_tangent(method, forces=scene.forces, by_parameters=bool(parameters))
    if frame is not None:
        if out is not None:
            raise ValueError("frame, out: exclude each other, states in a frame are new arrays")
        frame = checked_frame(frame)
        watched = None if watched is None else watched._replace(frame=frame)
    given = times_of_each("t", t)
    shape, rod = given.shape[:-1], parameters is None
    bodies = bodies_of(scene, omega, attitude, frame=frame, times=shape, rod=rod)
    times = given if given.ndim == 1 else in_rows(given, bodies.shape)
    target = PLAIN
    if out is not None or dtype is not np.float64:
        recorded = (*_recorded(scene, record), *derived)
        target = Target.of(dtype, out, (*bodies.shape, times.shape[-1]), recorded)
        target.check(bodies, time_ranges(times), accuracy)
    if tolerance is not None:
        tolerance = _checked_tolerance(tolerance, method, step, accuracy, scene)
    if watched is not None and given.size and given.min() < 0.0:
        raise ValueError(f"t = {given.min():g}: events are found forward in time, from t = 0")
    if max_steps is None:  # some minutes
        max_steps = 10**7 if "function" in scene.forces else MOST_STEPS
    problem = Problem(
        scene=scene,
        record=record,
        bodies=bodies,
        times=times,
        accuracy=accuracy,
        method=method,
        step=step,
        tolerance=tolerance,
        inside=watched is not None,
        max_steps=positive_int("max_steps", max_steps),
        threads=resolve_threads(threads, len(bodies.omega)),
    )
    is_brief = len(bodies) * times.shape[-1] < AT_ONCE and problem.is_plain
    progress = False if is_brief and progress is None else progress
    # One more run finds the events.
    with Listening(progress, 1 if watched is None else 2):
        made = solve(problem, check=check, watched=watched, parameters=parameters, target=target)
    columns = made.states
    if "energy" in derived:
        columns["energy"] = energy_of(scene, bodies.shape, columns["omega"], columns["gamma"])
    if "momentum" in derived:
        columns["momentum"] = momentum_of(scene, bodies.shape, columns["omega"], times)
    if target is not PLAIN:
        made.states = target.finish(columns)
    if made.found is not None:
        end_records(made.states, times, made.found.last)
    run = to_run(problem, made, given, parameters or ())
    return run if frame is None else run.in_frame(frame)


def _checked_record(record: str | Sequence[str], scene: Scene) -> tuple[str, tuple[str, ...]]:
    """The recorded states, and what is recorded that follows from them."""
    if isinstance(record, str) or not isinstance(record, Sequence):
        return one_of("record", record, RECORDS), ()
    names = tuple(record)
    for name in names:
        one_of("record", name, (*RECORDS, *DERIVED))
    states, derived = ([name for name in names if name in of] for of in (RECORDS, DERIVED))
    if len(states) > 1 or len(set(derived)) < len(derived):
        raise ValueError(
            f"record = {brief(record)}: must be one of {', '.join(map(repr, RECORDS))}, and "
            "'energy' or 'momentum' once"
        )
    own = states[0] if states else "attitude"
    if "energy" in derived and own == "rates" and needs_vertical(scene):
        raise ValueError(
            f"record = {brief(record)}: the potential energy of a top needs its vertical: 'axis'"
        )
    return own, tuple(derived)


def _checked_count(count: int | None, watched: Sequence[Event], until: object) -> int | None:
    """The number of events that end the record of a body, None if none do."""
    if count is None:
        return None if until is None else 1
    if not watched:
        raise ValueError(f"count = {brief(count)}: needs events or until")
    return positive_int("count", count)


def _recorded(scene: Scene, record: str) -> tuple[str, ...]:
    """Names of the arrays of a run that have an axis of times."""
    names = ["omega"]
    if record == "axis" or (record == "attitude" and scene.directions):
        names.append("gamma")
    if record == "attitude":
        names.append("attitude")
    return (*names, "work") if scene.forces else tuple(names)


def replayed(
    scene: Scene,
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    *,
    t: NDArray[np.float64],
    method: str,
    step: float | None,
    tolerance: float | None = None,
    strides: Sequence[int] | None = None,
) -> Run:
    """A body of a map again: its states at these times, in steps or by a tolerance.

    From the start of the map bit for bit: an attitude of a user would be normalised. With
    ``strides`` the states are those after these numbers of further steps of exactly ``step``.
    """
    problem = Problem(
        scene=scene,
        record="attitude",
        bodies=Bodies.of_scene(scene, omega, attitude, (), NO_EXPONENT),
        times=t,
        method=method,
        step=step,
        tolerance=tolerance,
        max_steps=2**63,
    )
    choice = choose_method(problem)
    states = choice.request(problem, strides).states()
    # The map that this body comes from has its own check of the error.
    return to_run(problem, Solution(states, method, tolerance, choice.plan), t)


def _checked_tolerance(
    tolerance: float,
    method: str | None,
    step: float | None,
    accuracy: float | None,
    scene: Scene,
) -> float:
    """The tolerance, if it is valid and the method takes adaptive steps."""
    tolerance = finite_float("tolerance", tolerance, positive=True)
    if tolerance >= 1.0:
        raise ValueError(f"tolerance = {tolerance:g}: must be below one")
    for name, value in (("step", step), ("accuracy", accuracy)):
        if value is not None:
            raise ValueError(
                f"tolerance = {tolerance:g}, {name} = {value:g}: exclude each other, "
                "because the steps follow from the tolerance"
            )
    known = adaptive_methods(scene.forces)
    if method not in known and (method is not None or len(known) > 1):
        where = " under the torque of a function" if "function" in scene.forces else ""
        choose = "choose their" if len(known) > 1 else "chooses its"
        raise ValueError(
            f"tolerance = {tolerance:g}, method = {method!r}: only "
            f"{', '.join(map(repr, known))} {choose} steps by a tolerance{where}"
        )
    if known == [FUNCTION] and tolerance < LEAST_TOLERANCE:
        raise ValueError(
            f"tolerance = {tolerance:g}: must be at least {LEAST_TOLERANCE:g}, because the error "
            f"of a step of {method!r} is rounding below it"
        )
    return tolerance
