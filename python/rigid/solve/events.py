"""The events of a run: when they happen, and the states then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._core import MOST_STATES
from ..model.compiling import of_state, taken_by
from ..model.events import Event
from ..model.frame import turned
from ..model.leading import Shape
from ..model.scene import Scene
from .arrays import Floats, in_rows
from .bodies import Bodies
from .columns import Column, Columns, HasColumns
from .methods import EXACT, SERIES, adaptive_methods
from .status import Status
from .surfaces import Called, Search, default_tolerance


class Points(HasColumns):
    """Points of motions: body after body, in order of time."""

    __slots__ = ()

    body = Column[NDArray[np.intp]]("", "point")
    t = Column[Floats]("s", "point")
    omega = Column[Floats]("rad/s", "point", "axis")
    gamma = Column[Floats]("1", "point", "axis")
    attitude = Column[Floats]("1", "point", "part")
    direction = Column[NDArray[np.int8]]("1", "point")
    slope = Column[Floats]("", "point")
    grazing = Column[NDArray[np.bool_]]("", "point")
    error = Column[Floats]("s", "point")
    complete = Column[NDArray[np.bool_]]("", "motion")
    lost_from = Column[Floats]("s", "motion")

    def __len__(self) -> int:
        return len(self.t)

    def _completeness(self) -> tuple[str, str]:
        """How many bodies there are, and of how many the points are complete, in words."""
        bodies, complete = np.size(self.complete), int(np.count_nonzero(self.complete))
        whole = "complete" if complete == bodies else f"{complete} of {bodies} complete"
        return "1 body" if bodies == 1 else f"{bodies:,} bodies", whole

    @classmethod
    def _of_points(cls) -> tuple[str, ...]:
        """The columns with a row for each point."""
        return tuple(name for name, column in cls._known().items() if column.axes[0] == "point")


@dataclass(frozen=True, repr=False, eq=False)
class Events(Points):
    """The times of an event in a run, and the states then: body after body, in order of time.

    Attributes
    ----------
    event : Event
        The event, in the axes in which it was given.
    t : ndarray, shape (p,)
        Times (s), positive: a start at which the quantity has the value already is no event.
    omega, gamma : ndarray, shape (p, 3)
        Rates (rad/s) and the upward vertical, in the body.
    attitude : ndarray, shape (p, 4)
        Unit quaternions with a positive scalar, body to space.
    states : ndarray, shape (p, k), or None
        The states of :meth:`Torque.call` with ``states=k``.
    direction : ndarray of int8, shape (p,)
        1 where the quantity rises through the value, -1 where it falls, 0 where it touches it. Of
        :func:`turns` 1 where it is least and -1 where it is largest.
    slope : ndarray, shape (p,)
        Rate of the quantity; of :func:`turns` its second derivative. Of the turns of a tilt and of
        pointing it is the second derivative of minus the cosine, of a pitch of the sine.
    grazing : ndarray of bool, shape (p,)
        Events at which the quantity turns so near the value, within 1e-12 of its scale or within
        the error of a closed form, that rounding may decide whether it crosses. They are kept
        whatever their direction.
    error : ndarray, shape (p,)
        Estimated error of ``t`` (s): the error of the quantity over its slope. The error of the
        quantity follows from the error of the closed form. Without a closed form it is three times
        the largest difference until then from a second run by a method of another order. NaN
        without the second run.
    body : ndarray of int, shape (p,)
        Index of the body, in the flat order of all.
    complete : ndarray of bool, shape (n,)
        Whether every event until the end of the record of the body is here and no other: the body
        was run, no event grazes, and the quantity does not have the value all along. With a single
        body the axis is absent.
    lost_from : ndarray, shape (n,)
        Time from which on the events are lost to rounding: they belong to a motion of another start
        nearby. Infinite if there is none, NaN without a second run.
    """

    event: Event
    _columns: Columns
    _shape: Shape

    states = Column[Floats | None]("", "point", "state")

    def __repr__(self) -> str:
        each, whole = self._completeness()
        return f"<Events: {self.event.words()}; {len(self):,} of {each}; {whole}>"

    @property
    def count(self) -> NDArray[np.intp]:
        """Number of events of each body, shape (n,)."""
        counts = np.bincount(self.body, minlength=np.size(self.complete))
        return counts.reshape(np.shape(self.complete))

    @property
    def offsets(self) -> NDArray[np.intp]:
        """First row of each body: its rows are ``offsets[i]`` to ``offsets[i + 1]``; (n + 1,)."""
        return np.concatenate([[0], np.cumsum(np.ravel(self.count))])

    def of(self, body: int | tuple[int, ...]) -> Self:
        """The events of one body, by its index or, with several leading axes, its indices.

        Parameters
        ----------
        body : int or tuple of int
            Index, or with several leading axes the indices, of the body.

        Returns
        -------
        Events

        Raises
        ------
        IndexError
            If there is no such body.

        Examples
        --------
        >>> import rigid
        >>> boxes = rigid.FreeBody(rigid.Body([[1.0, 2.0, 3.0], [1.0, 2.0, 2.5]]))
        >>> run = rigid.simulate(
        ...     boxes, [0.01, 1.0, 0.01], t=[0.0, 30.0], events=[rigid.crosses("omega2")]
        ... )
        >>> run.events[0].of(1).t.round(3).tolist()
        [17.721]
        """
        shape = np.shape(self.complete) or (1,)
        place = body if isinstance(body, tuple) else (body,)
        try:
            index = int(np.arange(np.prod(shape)).reshape(shape)[place])
        except (IndexError, TypeError):
            raise IndexError(
                f"body = {brief(body)}: must be the index of one of the bodies of shape {shape}"
            ) from None
        first, last = self.offsets[index : index + 2]
        rows = {
            name: array[first:last] if name in self._of_points() else array[index : index + 1]
            for name, array in self._columns.items()
        }
        rows["body"] = np.zeros(last - first, dtype=np.intp)
        return replace(self, _columns=rows, _shape=())

    def turned(self, axes: Floats, attitude: Floats) -> Self:
        """The events with vectors ``axes @ v`` in the body, and with the given attitudes."""
        return self.with_arrays(
            omega=turned(axes, self.omega),
            gamma=turned(axes, self.gamma),
            attitude=np.where(attitude[:, :1] < 0.0, -attitude, attitude),
        )

    def tilt(self, axis: int = 3) -> Floats:
        """Angle of a body axis from the upward vertical (rad), shape (p,).

        Parameters
        ----------
        axis : {1, 2, 3}
            The body axis.

        Returns
        -------
        ndarray, shape (p,)
            Angles (rad), from 0 to pi.

        Examples
        --------
        >>> import rigid
        >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
        >>> tilted = rigid.rotations.euler_to_quaternion([0.0, 1.0, 0.0])
        >>> run = rigid.simulate(
        ...     top, [0.0, 0.0, 5.0], tilted, t=[0.0, 9.0], events=[rigid.turns("tilt3", 1)]
        ... )
        >>> run.events[0].tilt().round(6).tolist()
        [1.0, 1.0, 1.0]
        """
        others = [k for k in range(3) if k != axis - 1]
        return np.arctan2(
            np.hypot(self.gamma[:, others[0]], self.gamma[:, others[1]]), self.gamma[:, axis - 1]
        )


@dataclass(frozen=True, slots=True)
class FoundEvents:
    """The result of a search of events.

    Attributes
    ----------
    events : tuple of Events
    end : ndarray, shape (n,)
        Time at which the record of each body ends (s).
    stopped : ndarray of bool, shape (n,)
        Whether it ends with an event.
    """

    events: tuple[Events, ...]
    end: Floats
    stopped: NDArray[np.bool_]

    @property
    def last(self) -> Floats:
        """Time from which on a body has no states (s), infinite for most; shape (n, 1)."""
        return np.where(self.stopped, self.end, np.inf)[:, np.newaxis]


def check_event_method(method: str | None, scene: Scene) -> None:
    """Raise ValueError for a method without a polynomial between two steps."""
    known = adaptive_methods(scene.forces)
    who = f"a function is known inside the steps of {known[0]!r} alone"
    if "function" not in scene.forces:
        known = [EXACT, *known]
        who = (
            "only a closed form and a Taylor series know the motion between two steps, so that "
            "none is missed"
        )
    if method is not None and method not in known:
        raise ValueError(
            f"method = {brief(method)}: has no events, because {who}; take one of "
            f"{', '.join(map(repr, known))}, or none"
        )


def find_events(
    scene: Scene,
    bodies: Bodies,
    ends: Floats,
    events: tuple[Event, ...],
    counted: tuple[bool, ...],
    count: int | None,
    frame: Floats | None,
    *,
    method: str,
    tolerance: float | None,
    check: bool,
    max_steps: int,
    threads: int,
) -> FoundEvents:
    """The events of bodies until their ends (s), or until the given number of counted events.

    The states are in principal axes, whatever the frame of the events.

    A closed form gives the state at the begin of each step of a Taylor series; without one, or
    under damping, the series goes on from step to step.
    """
    n = len(bodies)
    normals = np.array([[event.omega, event.gamma] for event in events])
    pointing = np.array([event.pointing(scene, frame) for event in events])
    orbit = np.zeros(9) if scene.orbit is None else scene.orbit.numbers
    if frame is not None:
        normals = turned(frame.T, normals)
    of_states = np.zeros((len(events), MOST_STATES))
    for row, event in zip(of_states, events, strict=True):
        if event.state > scene.states:
            raise ValueError(
                f"name = {event.name!r}: the scene has {scene.states} states of Torque.call"
            )
        if event.state:
            row[event.state - 1] = 1.0
    starts = np.zeros((n, MOST_STATES))
    function = None if scene.torque is None else scene.torque.function
    if function is not None and function.start is not None:
        starts[:, : function.states] = in_rows(function.start, bodies.shape)
    # Moments are counted in this unit.
    exponents = bodies.scale_exponent[:, np.newaxis]
    rotor = in_rows(np.zeros(3) if scene.rotor is None else np.asarray(scene.rotor), bodies.shape)
    momentum = _of_each([event.momentum for event in events], n, 3)
    kinds = zip(events, counted, strict=True)
    found: dict[str, Any] = Search(
        bodies=bodies,
        kinds=tuple((event.turns, event.direction, counts) for event, counts in kinds),
        normal=_of_each(normals, n, 6),
        momentum=np.ldexp(momentum, exponents[:, np.newaxis]),
        square=_of_each([event.square for event in events], n),
        states=_of_each(of_states, n, MOST_STATES),
        starts=starts,
        value=_of_each([event.level for event in events], n),
        rotor=np.broadcast_to(np.ldexp(rotor, -exponents), (n, 3)),
        pointing=pointing,
        functions=tuple(_called(event, scene, frame) for event in events),
        orbit=np.broadcast_to(in_rows(orbit, bodies.shape), (n, 9)),
        ends=np.broadcast_to(ends, (n,)).astype(np.float64),
        count=count,
        method=SERIES if method == EXACT else method,
        closed=method == EXACT and bodies.forces is None,
        tolerance=default_tolerance(scene.forces) if tolerance is None else tolerance,
        max_steps=max_steps,
        threads=threads,
    ).found(check=check)
    body = found["body"]
    ended = found["status"] == Status.OK
    records = []
    for k, event in enumerate(events):
        mine = np.flatnonzero(found["kind"] == k)
        grazing = np.bincount(body[mine], found["grazing"][mine], minlength=n) > 0
        complete = ended & ~grazing & ((found["stays"] >> k) & 1 == 0)
        rows: dict[str, Any] = {name: found[name][mine] for name in Events._of_points()}
        if not scene.states:
            del rows["states"]
        rows["slope"] = rows["slope"] / event.slope_scale
        rows |= {"complete": complete, "lost_from": found["lost_from"]}
        records.append(Events(event=event, _columns=rows, _shape=bodies.shape))
    return FoundEvents(tuple(records), found["end"], found["stopped"])


def _called(event: Event, scene: Scene, frame: Floats | None) -> Called | None:
    """The function of an event for the bodies of a scene, if it has one."""
    function = event.function
    if function is None:
        if event.name.endswith("()"):
            raise ValueError(f"events: no file has the function {event.name}; give it again")
        return None
    if frame is not None:
        raise ValueError(
            "frame: the function of an event is told principal axes; turn its arguments in the "
            "function, and leave the frame out"
        )
    takes_states, asks_place = taken_by(function)
    if takes_states and not scene.states:
        raise ValueError(f"states: {event.name} takes them; give Torque.call(..., states=k)")
    if asks_place and scene.orbit is None:
        raise ValueError(f"orbit_position: {event.name} takes it, but the scene has no orbit")
    return Called(function, *of_state(function, scene.states))


def events_of_parts(
    bodies: Bodies, parts: Sequence[FoundEvents], groups: Sequence[NDArray[np.intp]]
) -> FoundEvents:
    """The events of all bodies, from the events of their groups."""
    count = len(bodies)
    end, stopped = np.empty(count), np.empty(count, dtype=bool)
    for part, mine in zip(parts, groups, strict=True):
        end[mine], stopped[mine] = part.end, part.stopped
    each = zip(*(part.events for part in parts), strict=True)
    return FoundEvents(tuple(_joined(bodies, one, groups) for one in each), end, stopped)


def _joined(bodies: Bodies, parts: Sequence[Events], groups: Sequence[NDArray[np.intp]]) -> Events:
    """One event of groups of bodies, body after body."""
    pairs = list(zip(parts, groups, strict=True))
    body = np.concatenate([mine[part.body] for part, mine in pairs])
    order = np.argsort(body, kind="stable")
    rows: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts])[order]
        for name in Events._of_points()
        if getattr(parts[0], name) is not None
    }
    complete, lost_from = np.empty(len(bodies), dtype=bool), np.empty(len(bodies))
    for part, mine in pairs:
        complete[mine], lost_from[mine] = part.complete, part.lost_from
    rows |= {"body": body[order], "complete": complete, "lost_from": lost_from}
    return Events(event=parts[0].event, _columns=rows, _shape=bodies.shape)


def _of_each(values: Any, n: int, *width: int) -> Floats:
    """The values of all events for each of n bodies, shape (n, events, ...)."""
    row = np.array(values, dtype=np.float64).reshape(1, len(values), *width)
    return np.repeat(row, n, axis=0)
