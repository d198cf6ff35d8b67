"""The events of a run: when they happen, and the states then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._checks.arrays import Floats
from ..model.batch import Shape
from ..model.bodies import Bodies
from ..model.events import Event
from ..model.frame import turned
from ..model.scene import Scene
from .columns import Column, Columns, HasColumns
from .methods import EXACT, adaptive_methods
from .request import Problem
from .surfaces import Watched, found_points


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
            name: array[first:last] if name in self._of_points() else array[[index]]
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
        across = np.delete(self.gamma, axis - 1, axis=1)
        return np.arctan2(np.hypot(*across.T), self.gamma[:, axis - 1])


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


def find_events(problem: Problem, watched: Watched, method: str, *, check: bool) -> FoundEvents:
    """The events of bodies until their ends, or until the given number of counted events.

    The states are in principal axes, whatever the frame of the events.
    """
    found = found_points(problem, watched, method, check=check)
    scene, bodies = problem.scene, problem.bodies
    assert bodies is not None
    records = []
    for k, event in enumerate(watched.events):
        mine = np.flatnonzero(found["kind"] == k)
        rows: dict[str, Any] = {name: found[name][mine] for name in Events._of_points()}
        if not scene.states:
            del rows["states"]
        rows["slope"] = rows["slope"] / event.slope_scale
        rows |= {"complete": found["complete"][:, k], "lost_from": found["lost_from"]}
        records.append(Events(event=event, _columns=rows, _shape=bodies.shape))
    return FoundEvents(tuple(records), found["end"], found["stopped"])


def events_of_parts(
    bodies: Bodies, parts: Sequence[FoundEvents], groups: Sequence[NDArray[np.intp]]
) -> FoundEvents:
    """The events of all bodies, from the events of their groups."""
    back = np.argsort(np.concatenate(groups))  # from group after group to the order of the bodies
    end, stopped = (
        np.concatenate([getattr(part, name) for part in parts])[back] for name in ("end", "stopped")
    )
    joined = []
    for each in zip(*(part.events for part in parts), strict=True):
        body = np.concatenate([mine[one.body] for one, mine in zip(each, groups, strict=True)])
        order = np.argsort(body, kind="stable")
        rows: dict[str, Any] = {"body": body[order]}
        for name in each[0]._columns.keys() - {"body"}:
            whole = np.concatenate([one._columns[name] for one in each])
            rows[name] = whole[order if name in Events._of_points() else back]
        joined.append(Events(event=each[0].event, _columns=rows, _shape=bodies.shape))
    return FoundEvents(tuple(joined), end, stopped)
