"""The points at which bodies cross surfaces, from the core, and the errors of their times."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import Floats, lengths
from .._core import LEAST_STATE, MOST_STATES
from ..model.batch import in_rows
from ..model.bodies import Bodies
from ..model.compiling import Callback, Taken, of_state, taken_by
from ..model.events import Event
from ..model.frame import turned
from ..model.orbit import Orbit
from ..model.sampled import RotorTable, Sampled, require_place
from ..model.scene import Scene
from .methods import EXACT, FUNCTION, SERIES, TO_ROUNDING
from .request import Problem, Request
from .status import Status

TOLERANCE = 2.0**-57
"""Size of the last terms of a step: a sixteenth of rounding, which alone is left then."""

FUNCTION_TOLERANCE = 1e-12
"""The tolerance with a callback: the error of a Runge-Kutta step, and of its polynomial.

The second run needs a smaller one that is not rounding."""

LOST = 1e-3
"""Largest error of a point, in the scale of the surface, before the point counts as lost."""

SAFETY = 3.0
"""Factor from the difference of two runs to the stated error."""

MARKOV = 2.0 * 7**2
"""Bound of the rate of a polynomial of degree 7 over a step, in its largest value over the step."""

ROUNDINGS = 4.0
"""Roundings of the function that is zero on the surface, in its scale, that two runs may share."""


def default_method(forces: Collection[str]) -> str:
    """The method that finds points under these forces."""
    return FUNCTION if "function" in forces else SERIES


def default_tolerance(forces: Collection[str]) -> float:
    """The tolerance of the method that finds points under these forces."""
    return FUNCTION_TOLERANCE if "function" in forces else TOLERANCE


_OF_SURFACES = ("normal", "momentum", "square", "states", "value")
"""Coefficients of the surfaces of each body."""

_OF_BODIES = ("starts", "rotor", "orbit", "ends")
"""What each body has once, whatever its surfaces."""


class Watched(NamedTuple):
    """Events to find: which of them are counted, and how many of these end the record of a body."""

    events: tuple[Event, ...]
    counted: tuple[bool, ...]
    number: int | None
    frame: Floats | None = None


class Called(NamedTuple):
    """A function of the state in place of a surface, what it takes, and the same for the core."""

    function: Callable[..., float]
    taken: Taken
    callback: Callback


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Search:
    """The points of some bodies on their surfaces.

    A surface is ``normal·(omega, gamma) + momentum·L + square |omega|² + states·s + cosine =
    value``, with the cosine of a body axis from a direction; or a function in place of all this.

    Attributes
    ----------
    bodies : Bodies
    kinds : tuple of (bool, int, bool)
        Of each surface of a body: whether it is the rate of the left side that is zero, the
        direction, and whether its points are counted.
    normal : ndarray, shape (n, kinds, 6)
    momentum : ndarray, shape (n, kinds, 3)
        In one over the unit of moments of the bodies.
    square : ndarray, shape (n, kinds)
    states : ndarray, shape (n, kinds, 8)
    starts : ndarray, shape (n, 8)
        States of a function at the start, zero beyond those that there are.
    value : ndarray, shape (n, kinds)
    rotor : ndarray, shape (n, 3)
        Momentum of a rotor in each body, in the unit of moments of the bodies.
    pointing : ndarray, shape (kinds, 13)
        Of :meth:`Event.pointing`.
    functions : tuple of Called or None
        Of each kind.
    orbit : ndarray, shape (n, 9)
        The numbers of the orbit of each body.
    ends : ndarray, shape (n,)
        Time at which the motion of each body ends (s).
    count : int or None
        Number of points that count after which a body ends.
    method : str
        A Taylor method.
    closed : bool
        Whether each step begins at the state in closed form.
    tolerance : float
        Size of the last terms of a step.
    max_steps, threads : int
    """

    bodies: Bodies
    kinds: tuple[tuple[bool, int, bool], ...]
    normal: Floats
    momentum: Floats
    square: Floats
    states: Floats
    starts: Floats
    value: Floats
    rotor: Floats
    pointing: Floats
    functions: tuple[Called | None, ...]
    orbit: Floats
    ends: Floats
    count: int | None
    method: str
    closed: bool
    tolerance: float
    max_steps: int
    threads: int

    def found(self, *, check: bool) -> dict[str, NDArray[Any]]:
        """The columns of the core, with the ``body`` and the ``error`` of each point.

        ``lost_from`` is the time from which on the points of each body are lost. Both are NaN
        without a ``check``, unless a closed form gives them. ``complete``, (n, kinds), is whether
        no point of a surface is missed or doubtful.
        """
        found = self._points()
        counts = found.pop("points").astype(np.intp)
        body = found["body"] = np.repeat(np.arange(len(self.bodies)), counts)
        found["error"], found["lost_from"] = (
            self._errors(found, counts, body, check=check)
            if check or self.closed
            else (np.full(len(body), np.nan), np.full(len(self.bodies), np.nan))
        )
        found["slope"] = found["slope"] / self._shares(found, body)
        ended, grazing = found["status"] == Status.OK, found["grazing"]
        stays = found["stays"][:, np.newaxis] >> np.arange(len(self.kinds)) & 1
        found["complete"] = ended[:, np.newaxis] & (stays == 0)
        found["complete"][body[grazing], found["kind"][grazing]] = False
        return found

    def _shares(self, found: dict[str, NDArray[Any]], body: NDArray[np.intp]) -> Floats:
        """What the slopes of roll and yaw are times, or the slope of their rates; one of others."""
        share = np.ones(len(body))
        at = np.flatnonzero(self.pointing[found["kind"], 6:12].any(axis=-1))
        if len(at):
            own = {name: found[name][at, np.newaxis] for name in ("t", "attitude", "kind")}
            first, second = self._cosines(own["attitude"], own, self.orbit[body[at]])
            turns = self._turns[found["kind"][at]]
            share[at] = np.where(turns, first[:, 0] ** 2 + second[:, 0] ** 2, second[:, 0])
        return share

    def _cosines(
        self, attitude: Floats, known: Mapping[str, Any], orbit: Floats
    ) -> tuple[Floats, Floats]:
        """The products of both pairs of an axis and a direction at attitudes at points, (n, m)."""
        rows = self.pointing[known["kind"]]
        pairs = np.moveaxis(rows[..., :12].reshape(*rows.shape[:-1], 2, 2, 3), (-3, -2), (0, 1))
        in_orbit, space = rows[..., 12:] != 0.0, _space_axes(attitude)
        frame = space
        if in_orbit.any():
            frame = Orbit.of_numbers(orbit).frame(known["t"])
        first, second = (
            _dot(_times(space, axis), np.where(in_orbit, _times(frame, direction), direction))
            for axis, direction in pairs
        )
        return first, second

    def _points(self) -> dict[str, NDArray[Any]]:
        """The columns of the core for all bodies."""
        parts = [np.atleast_3d(getattr(self, name)) for name in _OF_SURFACES]
        surfaces = np.concatenate(parts, axis=-1)
        found = _core.section(
            self.bodies,
            method=self.method,
            kinds=list(self.kinds),
            pointing=self.pointing,
            functions=[
                (0, False) if one is None else (one.callback.address, one.callback.of_eight)
                for one in self.functions
            ],
            surfaces=np.ascontiguousarray(surfaces.reshape(-1, surfaces.shape[-1])),
            ends=self.ends,
            count=2**63 - 1 if self.count is None else self.count,
            closed=self.closed,
            tolerance=self.tolerance,
            max_steps=self.max_steps,
            threads=self.threads,
        )
        forces = self.bodies.forces
        found["states"] = found["states"][:, : 0 if forces is None else forces.states]
        return found

    def _select(self, some: NDArray[np.intp]) -> Self:
        """The search of some bodies."""
        own = {name: getattr(self, name)[some] for name in (*_OF_SURFACES, *_OF_BODIES)}
        return replace(self, bodies=self.bodies.select(some), **own)

    @property
    def _are_called(self) -> NDArray[np.bool_]:
        """Whether a function stands in place of the surface, of each kind."""
        return np.array([one is not None for one in self.functions], dtype=bool)

    @property
    def _turns(self) -> NDArray[np.bool_]:
        """Whether it is the rate of the left side that is zero, of each kind."""
        return np.array([turns for turns, _, _ in self.kinds], dtype=bool)

    def _fastest(self, met: Floats) -> Floats:
        """Bounds of the rates, under a function at least the rates met: it may have no bound."""
        rates = self.bodies.fastest_rates((np.zeros_like(self.ends), self.ends))
        is_called = self.bodies.forces is not None and self.bodies.forces.calls
        return np.fmax(rates, met) if is_called else rates

    def _scales(self, met: Floats) -> Floats:
        """The scale of the function that is zero on each surface, shape (n, kinds).

        Bodies under a function, which may have no bound, have met these rates, (n,).
        """
        rate = self._fastest(met)[:, np.newaxis]
        of_omega, of_gamma = np.split(np.abs(self.normal), 2, axis=-1)
        size = np.linalg.norm
        # A rate that overflows belongs to a body that is not run.
        with np.errstate(invalid="ignore", over="ignore"):
            momentum = self.bodies.moments.max(axis=1)[:, np.newaxis] * rate
            momentum = momentum + size(self.rotor, axis=-1)[:, np.newaxis]
            of_momentum = size(self.momentum, axis=-1)
            scale: Floats = size(of_omega, axis=-1) * rate + size(of_gamma, axis=-1)
            scale = scale + np.where(of_momentum > 0.0, of_momentum * momentum, 0.0)
            scale = scale + np.where(self.square != 0.0, np.abs(self.square) * rate**2, 0.0)
            scale = scale + self.pointing.any(axis=-1)
            size_of_states = np.maximum(np.abs(self.starts), LEAST_STATE)[:, np.newaxis]
            scale = scale + (np.abs(self.states) * size_of_states).sum(axis=-1)
            return np.where(self._turns, scale * rate, scale)

    def _errors(
        self,
        found: dict[str, NDArray[Any]],
        counts: NDArray[np.intp],
        body: NDArray[np.intp],
        *,
        check: bool,
    ) -> tuple[Floats, Floats]:
        """Errors of the times (p,), and when the points of each body are lost (n,).

        Of a closed form they follow from its own error; else, and of functions, from a second run,
        by a method of another order: three times what it makes of the surface, the largest until
        then.
        """
        t, kind = found["t"], found["kind"]
        met = np.zeros(len(self.bodies))
        np.maximum.at(met, body, lengths(found["omega"]))
        scale = self._scales(met)[body, kind]
        slope, called = np.abs(found["slope"]), self._are_called[kind]
        # Nothing tells the size of a state but its start and its rate, of a function its rate.
        grown = np.where(self.states[body, kind].any(axis=-1) | called, slope * t, 0.0)
        scale = np.maximum(scale, grown)
        if self.closed:
            omega = found["omega"][:, np.newaxis]
            bodies = self.bodies.select(body)
            error, _ = _core.errors_of_closed_forms(bodies, t[:, np.newaxis], omega)
            off = error * scale
        if called.any() or not self.closed:
            second = SAFETY * self._second_run(found, counts) if check else np.full(len(t), np.nan)
            off = np.where(called, second, off) if self.closed else second
        value = np.abs(self.value[body, kind])
        rounding = ROUNDINGS * np.finfo(float).eps * (scale + value)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            late = (off + rounding) / slope + np.spacing(t)
        lost_from = np.full(len(self.bodies), np.inf)
        # A jump tells no scale of a function, and without a second run nothing tells its error.
        known = ~called | (np.isfinite(slope) & check)
        lost = np.flatnonzero(known & ~(off <= LOST * scale))
        np.minimum.at(lost_from, body[lost], t[lost])
        return late, lost_from

    @property
    def _other_method(self) -> str:
        """The method of the second run."""
        if self.method == FUNCTION:
            return self.method  # no other is known inside its steps under a function
        return TO_ROUNDING if self.method != TO_ROUNDING else SERIES

    def _second_run(self, found: dict[str, NDArray[Any]], counts: NDArray[np.intp]) -> Floats:
        """The largest value on the surface in a second run until each point, (p,)."""
        off = np.full(len(found["t"]), np.nan)
        first = np.concatenate([[0], np.cumsum(counts)])
        needs = self.momentum.any() or self.pointing.any() or self._are_called.any()
        record = "attitude" if needs else "axis"
        for some in _alike(counts):
            most = np.arange(counts[some].max())
            places = first[some, np.newaxis] + np.minimum(most, counts[some, np.newaxis] - 1)
            own = self._select(some)
            states = Request(
                bodies=own.bodies.doubted(),
                times=found["t"][places],
                method=self._other_method,
                record=record,
                max_steps=self.max_steps,
                threads=self.threads,
                tolerance=max(1e-3 * self.tolerance, min(self.tolerance, TOLERANCE)),
            ).states(_core.ELSEWHERE if self.method == FUNCTION else 1.0)
            names = ("t", "omega", "gamma", "attitude", "states", "kind")
            known = {name: found[name][places] for name in names}
            with np.errstate(divide="ignore", invalid="ignore"):
                known["pace"] = (found["steps"][some] / found["end"][some])[:, np.newaxis]
            # The value behind a jump is no error.
            jumps = np.isnan(found["slope"][places])
            size = np.where(jumps, 0.0, np.abs(own._values(states, known)))
            # Errors grow along a motion; where two runs agree by chance, those before still count.
            # The scales of functions differ.
            alike = np.where(self._are_called[known["kind"]], known["kind"], -1)
            for kind in np.unique(alike):
                mine = alike == kind
                grown = np.maximum.accumulate(np.where(mine, size, 0.0), axis=1)
                off[places[mine]] = grown[mine]
        return off

    def _values(self, states: Mapping[str, Any], known: dict[str, NDArray[Any]]) -> Floats:
        """Values of the surface functions at states of bodies at points of these kinds, (n, m)."""
        kind = known["kind"]
        rows = np.arange(len(kind))[:, np.newaxis]
        normal = self.normal[rows, kind]
        of_omega, of_gamma = normal[..., :3], normal[..., 3:]
        of_momentum = self.momentum[rows, kind]
        omega, gamma = states["omega"], states["gamma"]
        turning = self._turns[kind]
        if states["attitude"] is None:  # no event of any body needs it
            along = np.zeros(kind.shape)
        else:
            axes = _space_axes(states["attitude"])
            gamma = axes[..., 2, :]
            momentum = self.bodies.moments[:, np.newaxis] * omega + self.rotor[:, np.newaxis]
            along = np.einsum("...j,...jk,...k->...", of_momentum, axes, momentum)
        if self.pointing.any():
            along += self._cosines(states["attitude"], known, self.orbit)[0]
        square = self.square[rows, kind]
        values: Floats = _dot(of_omega, omega) + _dot(of_gamma, gamma) + along
        values += square * _dot(omega, omega)
        for index, one in enumerate(self.functions):
            if one is not None:
                mine = kind == index
                values[mine] = self._of_function(one, mine, states, known["t"])
        values -= self.value[rows, kind]
        of_states = self.states[rows, kind][..., : known["states"].shape[-1]]
        if of_states.any():
            values += _dot(of_states, states["states"])
        if not turning.any():
            return values
        # The vertical changes by gamma x omega. Of the rates and the momentum, whose change depends
        # on the torque, the distance of two states is taken instead.
        rate = _dot(of_gamma, np.cross(gamma, omega))
        unknown = of_omega.any(axis=-1) | of_momentum.any(axis=-1) | (square != 0.0)
        unknown |= self.pointing[kind].any(axis=-1)
        if (turning & unknown).any():
            met = lengths(known["omega"]).max(axis=1)
            pair = [
                {
                    "omega": one["omega"],
                    "gamma": turned,
                    "attitude": one["attitude"] if self.pointing.any() else None,
                }
                for one, turned in ((states, gamma), (known, known["gamma"]))
            ]
            apart = _core.distances(pair[0], pair[1], self._fastest(met))
            rate = np.where(unknown, apart * self._scales(met)[rows, kind], rate)
        if (turning & of_states.any(axis=-1)).any():
            # Of the rate of a polynomial nothing is known but Markov's inequality, from its error.
            size = np.abs(of_states * known["states"]).sum(axis=-1)
            off = np.abs(_dot(of_states, states["states"] - known["states"]))
            off = MARKOV * known["pace"] * np.maximum(off, self.tolerance * size)
            rate = np.where(of_states.any(axis=-1), off, rate)
        return np.where(turning, rate, values)

    def _of_function(
        self, one: Called, mine: NDArray[np.bool_], states: Mapping[str, Any], t: Floats
    ) -> list[float]:
        """The values of a function at some states of bodies at times, (n, m)."""
        first, last = one.taken.others
        attitude = states["attitude"][mine]
        attitude = np.where(attitude[:, :1] < 0.0, -attitude, attitude)
        places = Orbit.of_numbers(self.orbit).position(t) if one.taken.asks_place else t
        own = states["states"] if one.taken.states else t
        others = [part[mine] for part in (own, t, places)[first:last:2]]
        told = zip(t[mine], states["omega"][mine], attitude, *others, strict=True)
        return [float(one.function(*each)) for each in told]


def search_of(problem: Problem, watched: Watched, method: str) -> Search:
    """The search of the events of a problem, which is solved by a method.

    A closed form gives the state at the begin of each step of a Taylor series; without one, or
    under damping, the series goes on from step to step.
    """
    scene, bodies, (events, counted, number, frame) = problem.scene, problem.bodies, watched
    assert bodies is not None
    assert problem.reach is not None
    n = len(bodies)
    normals = np.array([[event.omega, event.gamma] for event in events])
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
    orbit = np.zeros(9)
    if scene.orbit is not None and not isinstance(scene.orbit, Sampled):
        orbit = scene.orbit.numbers
    momentum = _of_each([event.momentum for event in events], n, 3)
    if momentum.any() and isinstance(scene.rotor, RotorTable):
        raise ValueError(
            f"rotor = {scene.rotor!r}: the momentum of a rotor by a table is not watched; take the "
            "rates, or look at run.momentum()"
        )
    rotor = in_rows(scene.momentum_of_rotor(0.0)[..., 0, :], bodies.shape)
    kinds = zip(events, counted, strict=True)
    tolerance = problem.tolerance
    return Search(
        bodies=bodies,
        kinds=tuple((event.turns, event.direction, counts) for event, counts in kinds),
        normal=_of_each(normals, n, 6),
        momentum=np.ldexp(momentum, exponents[:, np.newaxis]),
        square=_of_each([event.square for event in events], n),
        states=_of_each(of_states, n, MOST_STATES),
        starts=starts,
        value=_of_each([event.level for event in events], n),
        rotor=np.broadcast_to(np.ldexp(rotor, -exponents), (n, 3)),
        pointing=np.array([event.pointing(scene, frame) for event in events]),
        functions=tuple(_called(event, scene, frame) for event in events),
        orbit=np.broadcast_to(in_rows(orbit, bodies.shape), (n, 9)),
        ends=np.broadcast_to(problem.reach[1], (n,)).astype(np.float64),
        count=number,
        method=SERIES if method == EXACT else method,
        closed=method == EXACT and bodies.forces is None,
        tolerance=default_tolerance(scene.forces) if tolerance is None else tolerance,
        max_steps=problem.max_steps,
        threads=problem.threads,
    )


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
    if asks_place:
        require_place(event.name, scene.orbit)
    return Called(function, *of_state(function, scene.states))


def _of_each(values: Any, n: int, *width: int) -> Floats:
    """The values of all events for each of n bodies, shape (n, events, ...)."""
    row = np.array(values, dtype=np.float64).reshape(1, len(values), *width)
    return np.repeat(row, n, axis=0)


def _dot(a: Floats, b: Floats) -> Floats:
    dot: Floats = np.einsum("...i,...i->...", a, b)
    return dot


def _times(matrix: Floats, v: Floats) -> Floats:
    product: Floats = np.einsum("...ij,...j->...i", matrix, v)
    return product


def _space_axes(attitude: Floats) -> Floats:
    """The rows of the rotation matrices of quaternions: the space axes in the body."""
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _alike(counts: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """Bodies with points, in parts whose numbers of points differ by a factor of at most two."""
    order = np.argsort(counts, kind="stable")
    order = order[counts[order] > 0]
    while len(order):
        together = counts[order] <= 2 * counts[order[0]]
        yield np.sort(order[together])
        order = order[~together]
