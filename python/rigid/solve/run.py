"""The result of a simulation: states of bodies at output times."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import (
    brief,
    first_place,
    one_of,
    one_time,
    resolve_threads,
    shaped,
    whole,
)
from .._checks.arrays import Floats
from .._checks.progress import ProgressOption
from .._checks.shown import counted
from ..drawing.colours import AXES, on_ground
from ..drawing.figure import axes_to_draw_on, html_text, html_with_picture
from ..model.batch import Shape, in_rows
from ..model.bodies import Bodies, Range, time_ranges
from ..model.frame import attitudes_in_frame, attitudes_in_principal_axes, checked_frame, turned
from ..model.scene import Scene
from ..rotations.apply import to_space
from .attitude_ephemeris import write_aem
from .columns import Column, Columns, Result, take_numbers
from .conserved import energy_of, momentum_of, needs_vertical
from .events import Events
from .methods import EXACT
from .plan import Lazy, Plan
from .request import Problem
from .solution import COLUMNS, Solution, end_records, solve
from .status import (
    COARSE_ERROR,
    Status,
    ending,
    error_limit,
    is_accurate,
    sentences,
    status_by_error,
)

if TYPE_CHECKING:
    from datetime import datetime
    from os import PathLike
    from pathlib import Path

    from matplotlib.axes import Axes
    from scipy.spatial.transform import Rotation

    from ..animation import Animation
    from ..animation.story import Recording


FORMAT = "rigid run 1"

_ROUNDING_OF_TURN = 1e-15
"""Error of components that are turned into other axes: a sum of three products."""

_SURPRISING_ERROR = 1e-6
"""A run says what the word ``ok`` allows if an error of these bodies is larger."""


# Not frozen: a frozen object takes twice as long to make.
class OrbitStates(NamedTuple):
    """States relative to the frame of an orbit, from :meth:`Run.in_orbit_frame`.

    Attributes
    ----------
    t : ndarray, shape (m,) or (n, m)
        Times (s).
    attitude : ndarray, shape (n, m, 4)
        Unit quaternions, from the body to the axes radial, along and normal.
    omega : ndarray, shape (n, m, 3)
        Rates relative to these axes, in the body (rad/s).
    """

    t: Floats
    attitude: Floats
    omega: Floats


@dataclass(slots=True, eq=False)
class Run(Result):
    """States of bodies at output times, with errors and statuses; made by :func:`simulate`.

    With a single body the leading axis ``n`` is absent.

    Scenes, rates and attitudes of other leading axes give these axes in the place of ``n``. All
    attributes are read-only.

    Attributes
    ----------
    t : ndarray, shape (m,) or (..., m)
        Output times (s); with leading axes each body has its times.
    omega : ndarray, shape (n, m, 3)
        Angular velocity in the body (rad/s).
    gamma : ndarray, shape (n, m, 3), or None
        Upward vertical in body components, if it was recorded.
    attitude : ndarray, shape (n, m, 4), or None
        Quaternion, scalar first, body to space, if it was recorded. It is not normalised again.
    states : ndarray, shape (n, m, k), or None
        The states of :meth:`Torque.call` with ``states=k``, in their units.
    work : ndarray, shape (n, m), or None
        Work done on the body by torque, damping and dissipation since ``t = 0`` (J), integrated
        with the motion; None for a scene without them.
    tangent : ndarray, shape (n, m, 6, 6), or None
        Derivative of the motion by its start, if it was requested. Rows and columns are a change of
        the rates (rad/s) and a rotation vector in the body (rad), ``R -> R exp(x)``. Column ``j``
        is the later form of component ``j`` of a small deviation vector at ``t = 0``. Infinite
        beyond the range of doubles.
    sensitivity : ndarray, shape (n, m, 6, k), or None
        Derivative of the motion by k parameters, from the same start, if it was requested: the
        change of the rates (rad/s) and the rotation vector in the body (rad) over the change of
        each parameter in its SI unit. Zero at ``t = 0``.
    end : ndarray, shape (n,), or None
        Time at which the record of each body ends (s), if there are events: its last time, or the
        time of the event of ``until`` that ended it. States at later times are NaN.
    start_omega : ndarray, shape (n, 3)
        Angular velocity at ``t = 0`` along the principal axes, whatever the :attr:`frame` (rad/s).
    start_attitude : ndarray, shape (n, 4)
        Attitude of the principal axes at ``t = 0``.
    energy_drift : ndarray, shape (n,)
        Largest error of the energy at a requested time, relative to the kinetic energy at the start
        (plus ``mgl`` for a top). Under torque and damping it is the residual of the power balance
        ``dE/dt = torque·omega - omega·D omega``: the error of the energy minus the ``work``,
        relative to the energy that the body can reach. ``"etd4"`` and ``"splitting"`` compute the
        work from the change of kinetic energy. For a body without weight this residual is then zero
        by construction and is no measure of the error. The energy of a satellite is the energy of
        ``omega``: the work includes the work of the gravity gradient and of the energy sink.
    momentum_drift : ndarray, shape (n,)
        Largest error of the conserved angular momentum at a requested time. For a free body it is
        the error of ``|L|`` relative to ``|L|``; for a top, the error of ``L·gamma`` relative to
        ``|L| + sqrt(mgl I_max)`` at the start. Under torque and damping it is the residual of the
        balance of ``L·gamma``, or of ``L·L`` if only rates are integrated. ``"etd4"``
        and ``"splitting"`` keep the balance of momentum by construction, ``"midpoint"`` keeps the
        balances of momentum and energy.
    unit_drift : ndarray, shape (n,)
        Largest deviation of ``|gamma|`` and ``|q|`` from one; 0 if neither is integrated.
    status : ndarray of uint8, shape (n,)
        A :class:`Status` for each body. ``FLAGGED``, ``COARSE`` and ``UNCHECKED`` follow from its
        ``error``; ``OK`` says that the error is below the requested accuracy, or below 1e-3.
    steps : ndarray of uint64, shape (n,)
        Steps taken; 0 by closed form.
    error : ndarray, shape (n,)
        Estimated error, the largest at the output times. It is the largest of four errors: of the
        rates, relative to the fastest rates of the body at these times; of the vertical and the
        attitude (rad); of the states of a function, each relative to the largest value that it
        reaches; of the work, relative to the largest kinetic energy that the body can reach,
        or did reach under the torque of a function, which nothing bounds.
        Rates that are all below 1e-13 of the fastest that the body can reach, or of
        ``sqrt(mgl / I_min)``, count as rest and are compared with the larger of these two.

        For steps a second run is compared, which begins at a differently rounded start. By default,
        and with an ``accuracy``, it is coarser, and mostly twice the difference is the error; with
        a ``method``, ``step`` or ``tolerance`` alone it is finer, and three times the difference.
        Beside an unstable equilibrium or a separatrix the error includes the rounding of the start,
        magnified by the motion.

        For a closed form the error is ``1e-15`` per radian turned, or ``1e-15`` magnified by the
        saddle of a top, relative to the rates of a top that hangs all but still.

        The error is NaN for a body that was not run or not checked.
    lost_from : ndarray, shape (n,)
        Time from which on, away from 0, the error is 1 or more (s): do not use later states.
        Negative if the run goes backward in time; infinite if there is no such time; NaN if the
        error is not known.

    Notes
    -----
    :func:`load_run` reads the file of :meth:`save`. In a Dataset moments, ``mgl``, ``com``, torque,
    damping and so on that differ between bodies are variables, along principal axes: Datasets of
    parts of :func:`simulate_chunks` can be appended along ``body``. What all bodies have in common
    is in the attribute ``spec``. A table has rates, vertical, attitude and work at each time.

    Examples
    --------
    >>> import rigid
    >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=[0.0, 5.0, 10.0])
    >>> run
    Run(one body at 3 times; exact; error 1.6e-14; ok)
    >>> run.omega.shape, run.attitude.shape
    ((3, 3), (3, 4))
    """

    _parameters: tuple[str, ...]
    _events: tuple[Events, ...]
    _spec: Lazy[dict[str, Any]]
    _shape: Shape
    _columns: Columns
    _plan: Lazy[Plan]

    t = Column[Floats]("s", "t")
    omega = Column[Floats]("rad/s", "body", "t", "axis")
    gamma = Column[Floats | None]("1", "body", "t", "axis")
    attitude = Column[Floats | None]("1", "body", "t", "part")
    states = Column[Floats | None]("", "body", "t", "state")
    work = Column[Floats | None]("J", "body", "t")
    _energy = Column[Floats | None]("J", "body", "t")
    _momentum = Column[Floats | None]("kg m²/s", "body", "t", "axis")
    tangent = Column[Floats | None]("", "body", "t", "row", "column")
    sensitivity = Column[Floats | None]("", "body", "t", "row", "parameter")
    end = Column[Floats | None]("s", "body")
    start_omega = Column[Floats]("rad/s", "body", "axis")
    start_attitude = Column[Floats]("1", "body", "part")
    energy_drift = Column[Floats]("1", "body")
    momentum_drift = Column[Floats]("1", "body")
    unit_drift = Column[Floats]("1", "body")
    status = Column[NDArray[np.uint8]]("", "body")
    steps = Column[NDArray[np.uint64]]("", "body")
    error = Column[Floats]("", "body")
    lost_from = Column[Floats]("s", "body")

    def __repr__(self) -> str:
        """Size, method, largest known error, and how many bodies ended how."""
        times = counted(len(self.t.T), "time")
        worst = float(np.fmax.reduce(np.ravel(self.error), initial=np.nan))
        error = "error unknown" if np.isnan(worst) else f"error {worst:.1e}"
        if self.status.ndim == 0:
            how = self._named(int(self.status))
            return f"Run(one body at {times}; {self.spec['method']}; {error}; {how})"
        codes, counts = np.unique(self.status, return_counts=True)
        ends = [
            f"{count:,} {self._named(code)}"
            for code, count in zip(codes.tolist(), counts.tolist(), strict=True)
        ]
        bodies = counted(self.status.size, "body", "bodies")
        parts = [f"{bodies} at {times}", self.spec["method"], error]
        return f"Run({'; '.join(parts)}; {', '.join(ends) or 'nothing'})"

    def _named(self, code: int) -> str:
        """The name of a status; of ``ok`` bodies with a surprising error with what it allows."""
        # Steps allow an error, where no accuracy was asked for.
        by_steps = self.spec["accuracy"] is None and self.spec["method"] != EXACT
        surprising = (self.status == Status.OK) & (self.error > _SURPRISING_ERROR)
        if code == Status.OK and by_steps and surprising.any():
            return f"ok (error below {COARSE_ERROR:g})"
        return Status(code).name.lower()

    def _repr_html_(self) -> str:
        """The rates over time, of the first body of many, and the line of the run."""
        words = repr(self)
        many = self.status.ndim > 0
        if self.status.ndim > 1 or not self.status.size or self.omega.shape[-2] < 2:
            return html_text(words)
        if self.status.size > 1:
            words += "\nThe picture shows body 0."
        return html_with_picture(
            lambda ax: self.plot(ax, body=0 if many else None), words, height=3.0
        )

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the parameters of the :attr:`sensitivity`, in the order of its columns."""
        return self._parameters

    @property
    def events(self) -> tuple[Events, ...]:
        """The found events: first of each of the given ``events``, then of ``until``."""
        return self._events

    @property
    def nanoseconds(self) -> int:
        """Processor time of the states (ns), of all threads together and of all runs.

        A second run is among them; ``check=False`` makes none. Of a run in closed form of some
        microseconds it is the time that passed.
        """
        return int(self._columns["nanoseconds"])

    @property
    def spec(self) -> dict[str, Any]:
        """The request: scene in principal axes, method, step, accuracy, tolerance and record."""
        return self._spec()

    @property
    def plan(self) -> Plan:
        """The plan of the run: method, omitted computations and reasons."""
        return self._plan()

    @property
    def frame(self) -> Floats | None:
        """The body axes of all components, shape (3, 3): see :meth:`in_frame`.

        None: the principal axes.
        """
        frame = self.spec.get("frame")
        return None if frame is None else np.array(frame)

    def in_frame(self, frame: ArrayLike | None) -> Run:
        """The same motion with components along other axes of the body.

        Rates, vertical, attitude, tangent, sensitivity and events are turned; :meth:`momentum`,
        :meth:`rotation` and :meth:`to_aem` follow them. :meth:`energy` does not depend on axes.

        Parameters
        ----------
        frame : array_like, shape (3, 3), or None
            Column k is the direction of principal axis k + 1 along the new axes, as
            :meth:`Body.from_tensor` returns ``axes``; None: the principal axes.

        Returns
        -------
        Run
            The ``error`` is larger by 1e-15, the rounding of a turn.

        Raises
        ------
        ValueError
            If the frame is no rotation matrix to 3.1e-4.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> body, axes = rigid.Body.from_tensor([[2.0, 0.3, 0.0], [0.3, 2.5, 0.1], [0, 0.1, 3.0]])
        >>> run = rigid.simulate(body, axes.T @ [0.0, 0.0, 1.0], t=[0.0, 1.0]).in_frame(axes)
        >>> bool(np.allclose(run.omega[0], [0.0, 0.0, 1.0]))
        True
        """
        frame = None if frame is None else checked_frame(frame)
        run = self
        if run.frame is not None:
            run = run._turned(run.frame.T, partial(attitudes_in_principal_axes, run.frame))
        if frame is not None:
            run = run._turned(frame, partial(attitudes_in_frame, frame))
        spec = {name: value for name, value in run.spec.items() if name != "frame"}
        if frame is not None:
            spec["frame"] = frame.tolist()
        return replace(run, _spec=Lazy.of(spec))

    def in_orbit_frame(self) -> OrbitStates:
        """The motion relative to the frame of the orbit: radial, along and normal.

        A run keeps rates and attitudes in space, so that they have one meaning everywhere: this
        turns the results, and :meth:`Orbit.to_space` turns a start. Roll, pitch and yaw follow from
        :func:`rigid.free.roll_pitch_yaw`.

        Returns
        -------
        OrbitStates
            Named arrays: ``t``; ``attitude``, shape (n, m, 4), from the body to the axes of
            :meth:`Orbit.frame`; ``omega``, shape (n, m, 3), the rates relative to these axes, in
            the body (rad/s). The rates in space are :attr:`omega` of the run.

        Raises
        ------
        ValueError
            If the scene has no orbit, or the attitude was not recorded.

        Examples
        --------
        >>> import rigid
        >>> orbit = rigid.Orbit(1.0, eccentricity=0.1)
        >>> moon = rigid.FreeBody(rigid.Body((1.0, 1.2, 1.3)), orbit=orbit)
        >>> run = rigid.simulate(moon, *orbit.to_space([0.0, 0.0, 0.05]), t=[0.0, 2.0])
        >>> run.in_orbit_frame().omega[0].round(12).tolist()
        [0.0, 0.0, 0.05]
        """
        orbit = self._scene.orbit
        if orbit is None:
            raise ValueError("scene: has no orbit; give rigid.FreeBody one by orbit=")
        attitude = self._recorded_attitude()
        omega, relative = orbit.from_space(self.omega, attitude, np.asarray(self.t))
        return OrbitStates(self.t, relative, omega)

    def _turned(self, axes: Floats, attitudes: Callable[[Floats], Floats]) -> Run:
        """The run with ``axes @ v`` for all vectors in the body, and with turned attitudes."""
        turns: dict[str, Callable[[Floats], Floats]] = {
            **dict.fromkeys(("omega", "gamma", "momentum"), partial(turned, axes)),
            "attitude": attitudes,
            "tangent": partial(_turned_tangent, axes),
            "sensitivity": partial(_turned_rows, axes),
            "error": lambda error: error + _ROUNDING_OF_TURN,
        }
        known = self._arrays()
        run = self.with_arrays(**{k: turn(known[k]) for k, turn in turns.items() if k in known})
        events = tuple(one.turned(axes, attitudes(one.attitude)) for one in self.events)
        return replace(run, _events=events)

    @property
    def flagged(self) -> NDArray[np.bool_]:
        """Whether the estimated error is above the requested accuracy, or 1 or more without one."""
        return np.asarray(self.error) >= error_limit(self.spec["accuracy"])

    def reasons(self) -> tuple[Any, ...]:
        """A sentence for each body: how its computation ended, and the remedy if it failed.

        With several leading axes the sentences are tuples of tuples.

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
        flagged: the estimated error is 1 or more from t = 50.8 on; end the run earlier or ask for \
an accuracy
        """
        words = partial(ending, self.spec, self._scene.forces)
        return sentences(words, self.status, self.error, self.lost_from)

    def at(self, t: ArrayLike) -> Run:
        """The run at other output times between its first and its last, with the errors there.

        States are not interpolated. A closed form is evaluated at these times. With a
        ``tolerance`` the body takes the steps of the run again, and each state is a value of the
        series of its step: both have the bits of a run whose output times had been these. Other
        runs are made again by the same method with steps of the same length, which end at these
        times. So request many times at once.

        Parameters
        ----------
        t : array_like, shape (k,) or (..., k)
            Times (s), in any order. Leading axes give each body its times.

        Returns
        -------
        Run
            With these times in the place of its output times, its own ``error`` and ``status``, and
            neither tangent nor events. NaN after the end of a body that an event has ended.

        Raises
        ------
        ValueError
            If a time is not finite or outside the run, or if the axes do not match the bodies.

        Examples
        --------
        >>> import rigid
        >>> box = rigid.Body((1.0, 2.0, 3.0))
        >>> run = rigid.simulate(box, [0.1, 1.0, 0.2], t=[0.0, 100.0])
        >>> run.at([50.0, 7.0])
        Run(one body at 2 times; exact; error 7.8e-14; ok)
        """
        shape, given = self.status.shape, np.atleast_1d(shaped("t", t))
        if given.ndim > 1 and given.shape[:-1] != shape:
            raise ValueError(
                f"t: expected shape (k,) or {(*shape, 'k')} for bodies of shape {shape}, "
                f"got {given.shape}"
            )
        order = np.argsort(given, axis=-1, kind="stable")
        ascending = np.take_along_axis(given, order, axis=-1)
        reached = time_ranges(self.t if self.t.ndim == 1 else in_rows(self.t, shape))
        times = ascending if given.ndim == 1 else in_rows(ascending, shape)
        _check_inside(times, reached)
        spec = {name: value for name, value in self.spec.items() if name != "frame"}
        scene = self._scene
        if "function" in scene.forces:
            raise ValueError(
                "t: a run under a function keeps no function; give these times to rigid.simulate"
            )
        bodies = Bodies.of_scene(scene, self.start_omega, self.start_attitude, shape)
        last = np.array([[np.inf]]) if self.end is None else np.reshape(self.end, (-1, 1))
        accuracy, named = spec["accuracy"], spec["asked"] is not None
        problem = Problem(
            scene=scene,
            record=spec["record"],
            bodies=bodies,
            times=np.minimum(times, last) if (times > last).any() else times,
            reach=reached,
            accuracy=accuracy,
            method=spec["asked"],
            step=spec["step"],
            tolerance=spec["tolerance"] if named and accuracy is None else None,
            inside=bool(self.events),
            threads=resolve_threads(None),
        )
        check = accuracy is not None or not np.isnan(self.error).all()
        solution = solve(problem, check=check)
        end_records(solution.states, times, last)
        made = to_run(problem, solution, ascending)
        made = replace(made, _spec=Lazy.of(spec), _plan=self._plan)
        if (np.diff(order, axis=-1) < 0).any():
            made = _in_order(made, given, order)
        return made if self.frame is None else made.in_frame(self.frame)

    def energy(self) -> Floats:
        """Kinetic and potential energy ``omega·I omega / 2 + mgl com·gamma`` (J), shape (n, m).

        Under torque and damping it changes by the :attr:`work`. If it was recorded, it is the
        recorded array.

        Returns
        -------
        ndarray, shape (n, m)
            Energy (J).

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
        recorded = self._energy
        if recorded is not None:
            return recorded
        scene, run = self._scene, self.in_frame(None)
        if run.gamma is None and needs_vertical(scene):
            raise ValueError("record = 'rates': the potential energy of a top needs its vertical")
        columns = run._columns
        energy = energy_of(scene, run._shape, columns["omega"], columns.get("gamma"))
        return energy.reshape(run.omega.shape[:-1])

    def momentum(self, frame: str = "body") -> Floats:
        """Angular momentum ``I omega`` (kg m²/s), with a rotor, shape (n, m, 3).

        About the fixed point of a top, else about the centre of mass. Along the body axes it is the
        recorded array, if it was recorded.

        Parameters
        ----------
        frame : {"body", "space"}
            The axes of its components: the body axes, given by :attr:`frame`, or the space axes,
            along which the angular momentum of a free body is constant.

        Returns
        -------
        ndarray, shape (n, m, 3)
            Angular momentum (kg m²/s).

        Raises
        ------
        ValueError
            If the frame is another, or is space and the attitude was not recorded.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t=[0.0, 3.0])
        >>> bool(np.allclose(run.momentum("space"), [0.1, 1.5, 0.4], rtol=1e-13))
        True
        """
        one_of("frame", frame, ("body", "space"))
        momentum = self._momentum
        if momentum is None:
            scene, axes, omega = self._scene, self.frame, self._columns["omega"]
            omega = omega if axes is None else turned(axes.T, omega)
            momentum = momentum_of(scene, self._shape, omega, self.t).reshape(self.omega.shape)
            if axes is not None:
                momentum = turned(axes, momentum)
        return momentum if frame == "body" else to_space(self._recorded_attitude(), momentum)

    def _recorded_attitude(self) -> Floats:
        if self.attitude is None:
            raise ValueError(
                "record = 'attitude' was not asked for: there is no attitude to return"
            )
        return self.attitude

    def _saved(self) -> dict[str, Any]:
        header = {
            "format": FORMAT,
            "parameters": list(self.parameters),
            "nanoseconds": int(self.nanoseconds),
            "spec": self.spec,
            "plan": self.plan.to_dict(),
            "events": [one.event.to_dict() for one in self.events],
        }
        of_events = {
            f"events{k}_{name}": array
            for k, one in enumerate(self.events)
            for name, array in one._arrays().items()
        }
        return {"header": json.dumps(header), **self._arrays(), **of_events}

    def _labels(self) -> Mapping[str, Any]:
        return {"parameter": np.array(self.parameters, dtype=object)}

    def _table(self) -> dict[str, NDArray[Any]]:
        table = Result._table(self)
        if self.end is None:
            return table
        # A row is an observation: after the end of its record a body has none.
        gone = np.isnan(self.omega[..., 0]) & (self.t > self.end[..., np.newaxis])
        return {name: np.broadcast_to(rows, gone.shape)[~gone] for name, rows in table.items()}

    def _dataset(self, spec: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        # super() does not know a class with slots.
        variables, coordinates = Result._dataset(self, spec)
        if self.t.ndim > 1:
            # Each body has its times: these are no common coordinate.
            del coordinates["t"]
            times = np.broadcast_to(self.t, self.omega.shape[:-1])
            variables["time"] = (variables["omega"][0][:-1], times)
        numbers, torque_times = take_numbers(spec["scene"], self._shape)
        return {**variables, **numbers}, {**coordinates, **torque_times}

    def plot(self, ax: Axes | None = None, *, body: int | None = None) -> Axes:
        """Draw the three rates of one body over time, in the colours of its axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure if not given.
        body : int, optional
            Which body, where there are many along one axis.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ValueError
            If there are many bodies and ``body`` names none, or there are fewer than two times.
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=[0.0, 5.0, 10.0])
        >>> run.plot().get_xlabel()
        't (s)'
        """
        times, omega = self._of_one(body, self.omega)
        if len(times) < 2:
            raise one_time("a plot", times)
        ax = axes_to_draw_on(ax)
        for k, ink in enumerate(AXES):
            ax.plot(times, omega[:, k], color=on_ground(ax, ink.colour), label=f"$\\omega_{k + 1}$")
        ax.set(xlabel="t (s)", ylabel="rate in the body (rad/s)")
        ax.legend()
        return ax

    def to_aem(
        self,
        path: str | PathLike[str],
        *,
        epoch: str | datetime,
        body: int | None = None,
        object_name: str = "BODY",
        object_id: str = "UNKNOWN",
        frame: str = "EME2000",
        body_frame: str = "SC_BODY_1",
        originator: str = "RIGID",
    ) -> Path:
        """Write the attitudes as an attitude ephemeris message (AEM) of CCSDS 504.0-B-2.

        Quaternions are normalised, scalar last, from frame A (space) to frame B (the body), with
        times in UTC to the microsecond. The message ends where the body ends, such as with an event
        of ``until``. :func:`rigid.load_aem` reads it.

        Parameters
        ----------
        path : path-like
        epoch : str or datetime
            UTC at ``t = 0``, as ``"2026-01-31T12:00:00"``; one with a time zone is converted.
        body : int, optional
            Which body, where there are many along one axis.
        object_name, object_id, frame, body_frame, originator : str
            The entries ``OBJECT_NAME``, ``OBJECT_ID``, ``REF_FRAME_A``, ``REF_FRAME_B`` and
            ``ORIGINATOR``.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the attitude was not recorded or is known at no time, the epoch is no time, an entry
            is empty or of several lines, two times share a microsecond, there are many bodies and
            ``body`` names none, or the name ends in neither ``.aem`` nor ``.txt``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=[0.0, 5.0, 10.0])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = run.to_aem(os.path.join(folder, "body.aem"), epoch="2026-01-31T12:00:00")
        ...     print(path.read_text().splitlines()[0])
        CCSDS_AEM_VERS = 2.0
        """
        times, attitudes = self._of_one(body, self._recorded_attitude())
        entries = {
            "object_name": object_name,
            "object_id": object_id,
            "frame": frame,
            "body_frame": body_frame,
            "originator": originator,
        }
        return write_aem(path, times, attitudes, epoch=epoch, entries=entries)

    def _of_one(self, body: int | None, values: Floats) -> tuple[Floats, Floats]:
        """Times and values (m, ...) of one body."""
        index = self._index(body)
        return (self.t if self.t.ndim == 1 else self.t[index]), values[index]

    def rotation(self) -> Rotation:
        """The attitudes as a SciPy ``Rotation`` of shape ``(n, m)`` (active, body to space).

        Returns
        -------
        scipy.spatial.transform.Rotation

        Raises
        ------
        ValueError
            If the attitude was not recorded.

        Examples
        --------
        >>> import rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=[0.0, 5.0, 10.0])
        >>> run.rotation().apply([0.0, 0.0, 1.0]).shape  # body axis 3 in space
        (3, 3)
        """
        attitude = self._recorded_attitude()
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(attitude, scalar_first=True)

    @overload
    def animate(
        self,
        path: None = None,
        *,
        view: str | None = None,
        speed: float | None = None,
        body: int | Sequence[int] | None = None,
        trail: float | None = None,
        shape: tuple[ArrayLike, ArrayLike] | None = None,
        caption: str | None = None,
    ) -> Animation: ...

    @overload
    def animate(
        self,
        path: str | PathLike[str],
        *,
        view: str | None = None,
        speed: float | None = None,
        body: int | Sequence[int] | None = None,
        trail: float | None = None,
        shape: tuple[ArrayLike, ArrayLike] | None = None,
        caption: str | None = None,
        fps: float = 25.0,
        size: int = 480,
        progress: ProgressOption = None,
    ) -> Path: ...

    def animate(
        self,
        path: str | PathLike[str] | None = None,
        *,
        view: str | None = None,
        speed: float | None = None,
        body: int | Sequence[int] | None = None,
        trail: float | None = None,
        shape: tuple[ArrayLike, ArrayLike] | None = None,
        caption: str | None = None,
        fps: float = 25.0,
        size: int = 480,
        progress: ProgressOption = None,
    ) -> Path | Animation:
        """Show the motion as a film, or write the film.

        The run needs attitudes at two times or more. Each time becomes a frame; there is no
        interpolation between the times. Of a body on an orbit the film shows the direction to the
        planet, and the plane of the orbit; the distance is not to scale.

        Parameters
        ----------
        path : path, optional
            ``.html`` for a page that a browser plays without a network, and whose view you turn
            with the pointer; ``.gif``, ``.webp`` or ``.mp4`` for a moving picture, which needs
            Matplotlib and Pillow, and ffmpeg or imageio-ffmpeg for ``.mp4``. Without a path the
            film is returned and a notebook shows it.
        view : str, optional
            For a free body ``"box"``, the box (or the box with equal moments) with omega and L;
            ``"cones"``, the body cone of a symmetric top rolling on the space cone; or
            ``"poinsot"``, the inertia ellipsoid rolling on the invariable plane. For a heavy top
            ``"top"``, with the path of its axis. Default for a free body: the box for a
            :meth:`rigid.Body.box` and for a body under torque or damping, else the cones if two
            moments are equal, else the ellipsoid.
        speed : float, optional
            Factor by which the film is faster than the motion. Default: 1, and for a motion of more
            than 20 s so that the film lasts 20 s.
        body : int or two int, optional
            Index of the body to show, if the run has many bodies; two indices show two bodies side
            by side, with one scale. Default: both bodies of a run of two.
        trail : float, optional
            Length of trails in seconds of the run, ``math.inf`` for trails without end. Default: a
            quarter of the run, on an orbit at most about two turns of the body, and without end in
            the view ``"poinsot"``.
        shape : tuple (vertices, faces), optional
            The surface of the body, to be shown instead of a box or a top: corners of shape (v, 3),
            and for each polygon the indices of its corners, shape (f, n) with n >= 3;
            :func:`rigid.meshes.read_mesh` returns both. The origin of the corners is the centre of
            mass, or the fixed point of a heavy top. The corners have the axes of the run: the
            principal axes, or ``frame``, if the run has one.
        caption : str, optional
            The sentence above the film. Default: what happens in the motion.
        fps : float
            Most frames in a second of a moving picture: closer frames are omitted. At most 50,
            which is what browsers show of a GIF.
        size : int
            Height of a moving picture in pixels, 64 or more.
        progress : None, bool or callable
            Progress of a moving picture, as in :func:`rigid.stability_map`.

        Returns
        -------
        Path or rigid.animation.Animation
            Path of the new file; without a path, the film.

        Raises
        ------
        ImportError
            If what a moving picture needs is not installed.
        OSError
            If the file cannot be written, or the path names something other than a file, or ffmpeg
            fails. An older file stays as it was.
        TypeError, ValueError
            Naming the argument, its value and the rule: an unknown suffix or view, a run without
            attitudes, of one time or not finite, a body at rest, cones of an asymmetric body or one
            under torque, a shape that is no mesh, frames too long for a picture.

        Warns
        -----
        UserWarning
            If the body turns by more than half a turn from one frame to the next, as frames are
            seen: the film shows another motion.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
        >>> tilted = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
        >>> run = rigid.simulate(top, [0.0, 0.0, 5.0], tilted, t=np.linspace(0.0, 10.0, 301))
        >>> run.animate("top.html").name
        'top.html'

        A body from a mesh: the corners move to the centre of mass.

        >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.5]])
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> solid = rigid.meshes.mesh_properties(corners, faces, mass=1.0)
        >>> body, axes = rigid.Body.from_properties(solid)
        >>> run = rigid.simulate(body, [0.1, 5.0, 0.1], t=np.linspace(0.0, 4.0, 201), frame=axes)
        >>> run.animate("mesh.html", shape=(corners - solid.centre, faces)).name
        'mesh.html'
        """
        from ..animation import animate  # takes long to import, as all that draws

        bodies: Sequence[int | None]
        if isinstance(body, Sequence):
            if not 1 <= len(body) <= 2:
                raise ValueError(f"body = {brief(body)}: must be one index or two")
            bodies = body
        else:
            bodies = (0, 1) if body is None and self.status.shape == (2,) else (body,)
        recordings = [_recording_of(self, one) for one in bodies]
        if len({len(one.t) for one in recordings}) > 1:
            raise ValueError(f"body = {brief(bodies)}: their records end at different times")
        return animate(
            recordings,
            path,
            view=view,
            speed=speed,
            trail=trail,
            shape=shape,
            caption=caption,
            fps=fps,
            size=size,
            progress=progress,
        )

    def _index(self, body: int | None) -> tuple[int, ...]:
        """The index of one body: empty if the run has a single one."""
        shape = self.status.shape
        if len(shape) > 1:
            raise ValueError(
                f"omega of shape {self.omega.shape}: needs one axis of bodies, (n, m, 3)"
            )
        if not shape:
            if body is not None:
                raise ValueError(f"body = {body}: the run has a single body")
            return ()
        bodies = len(self.status)
        if body is None and bodies != 1:
            raise ValueError(f"body = None: the run has {bodies} bodies, choose one by its index")
        index = 0 if body is None else whole("body", body)
        if not -bodies <= index < bodies:
            raise ValueError(f"body = {brief(body)}: the run has {bodies} bodies")
        return (index,)


def scene_of(run: object, body: int | None = None) -> Scene:
    """The scene of a run, of one body of many; TypeError if the run is none."""
    if not isinstance(run, Run):
        raise TypeError(f"run = {brief(run)}: must be a rigid.Run, which rigid.simulate returns")
    scene = run._scene
    return scene[0 if len(scene) == 1 else body or 0] if scene.shape else scene


def states_of(
    run: Run, body: int | None = None, names: Sequence[str] = ("omega", "attitude")
) -> list[Floats]:
    """States (m, ...) of one body of a run, in principal axes.

    They end where an event of ``until`` ended the body.
    """
    if "attitude" in names and run.attitude is None:
        raise ValueError(
            f"record = {run.spec['record']!r}: record = 'attitude' is needed to show the motion"
        )
    index = run._index(body)
    if run.t.ndim > 1:
        raise ValueError(f"t of shape {run.t.shape}: needs times that all bodies share, (m,)")
    plain = run.in_frame(None)
    states: list[Floats] = [getattr(plain, name)[index] for name in names]
    if run.status[index] == Status.STOPPED:
        known = int(np.isfinite(states[0]).all(axis=-1).sum())
        states = [values[:known] for values in states]
    if not all(np.isfinite(values).all() for values in states):
        raise ValueError("status: states that are not finite cannot be shown")
    return states


def of_known_states(run: Run) -> Run:
    """The run, if all its states are finite; ValueError with the reason of the first other body."""
    lost = np.asarray(~np.isfinite(run.omega).all(axis=(-2, -1)))
    if lost.any():
        index, place = first_place(lost)
        reason = np.array(run.reasons()).reshape(lost.shape)[index]
        raise ValueError(
            f"omega{place} = {run.start_omega[index].tolist()}: the motion is {reason}"
        )
    return run


def _recording_of(run: Run, body: int | None) -> Recording:
    """The motion of one body of a run, for a film."""
    from .recording import recording_of  # it loads what draws

    omega, attitude = states_of(run, body)
    return recording_of(scene_of(run, body), run.t[: len(omega)], omega, attitude, run.frame)


def to_run(
    problem: Problem, made: Solution, times: Floats, parameters: tuple[str, ...] = ()
) -> Run:
    """The run of the bodies of a problem at its times, as a user has given these."""
    bodies, states, found, accuracy = problem.bodies, made.states, made.found, problem.accuracy
    assert bodies is not None
    worst = states.worst if isinstance(states, _core.States) else None
    if worst is None or not is_accurate(worst, accuracy):
        nothing = np.full(len(bodies), np.nan)
        error, lost_from = (states.get(name, nothing) for name in ("error", "lost_from"))
        if np.count_nonzero(states["status"]):
            unknown = np.isin(states["status"], (Status.STEP_LIMIT, Status.NOT_FINITE))
            error, lost_from = (np.where(unknown, np.nan, values) for values in (error, lost_from))
        states["status"] = status_by_error(states["status"], error, accuracy)
        states["error"], states["lost_from"] = error, lost_from
    if found is not None:
        ended = found.stopped & np.isin(states["status"], (Status.OK, Status.UNCHECKED))
        states["status"] = np.where(ended, Status.STOPPED, states["status"]).astype(np.uint8)
        states["end"] = found.end
    attitude, count = bodies.attitude, len(bodies.omega)
    if len(attitude) != count:
        attitude = np.broadcast_to(attitude, (count, 4))
    states["t"], states["start_omega"], states["start_attitude"] = times, bodies.omega, attitude
    return Run(
        _parameters=parameters,
        _events=() if found is None else found.events,
        _spec=Lazy(_spec_of, problem, made.method, made.tolerance),
        _shape=bodies.shape,
        _columns=states,
        _plan=made.plan,
    )


def _spec_of(problem: Problem, method: str, tolerance: float | None) -> dict[str, Any]:
    """The request of a run in the form of a file."""
    return {
        "scene": problem.scene.to_dict(),
        "asked": problem.method,
        "method": method,
        "step": None if method == EXACT else problem.step,
        "accuracy": problem.accuracy,
        "tolerance": tolerance,
        "record": problem.record,
    }


def _check_inside(times: Floats, reached: Range) -> None:
    """Raise ValueError for a time outside the run."""
    first, last = (np.reshape(bound, (-1, 1)) for bound in reached)
    outside = np.argwhere((times < first) | (times > last))
    if len(outside):
        body = outside[0, 0] if len(first) > 1 else 0
        raise ValueError(
            f"t = {np.atleast_2d(times)[tuple(outside[0])]}: must be inside the run, which is from "
            f"t = {first[body, 0]} to {last[body, 0]}"
        )


def _in_order(run: Run, times: Floats, order: NDArray[np.intp]) -> Run:
    """The states of ascending times, in the order of the requested times."""
    place = np.argsort(in_rows(order, run._shape), axis=-1)
    known = {name: run._columns.get(name) for name in COLUMNS}
    moved = {
        name: np.take_along_axis(rows, place if rows.ndim == 2 else place[..., np.newaxis], axis=1)
        for name, rows in known.items()
        if rows is not None
    }
    return replace(run, _columns={**run._columns, **moved, "t": times})


def _turned_rows(axes: Floats, matrices: Floats) -> Floats:
    """The rows of rates and of a rotation vector in turned axes, from matrices (..., 6, k)."""
    rows = np.swapaxes(matrices, -1, -2)
    with np.errstate(invalid="ignore"):
        halves = [turned(axes, rows[..., :3]), turned(axes, rows[..., 3:])]
    both = np.swapaxes(np.concatenate(halves, axis=-1), -1, -2)
    return np.where(np.isnan(both) & ~np.isnan(matrices).any(), np.inf, both)


def _turned_tangent(axes: Floats, matrices: Floats) -> Floats:
    """Matrices (..., 6, 6) with both their rows and their columns in turned axes."""
    rows = _turned_rows(axes, matrices)
    return np.swapaxes(_turned_rows(axes, np.swapaxes(rows, -1, -2)), -1, -2)
