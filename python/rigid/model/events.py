"""Events of a motion: a quantity crosses a value, or turns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, one_of, vector
from .._checks.arrays import Floats
from .._checks.quantities import without_unit
from .._core import MOST_STATES
from .batch import three
from .compiling import taken_by
from .frame import turned
from .orbit_axes import (
    ANGLES,
    DIRECTIONS,
    Axes,
    at_rest,
    checked_axes,
    extreme_axis,
    require_orbit,
    rest_axes,
    unit_axis,
)
from .scene import Scene
from .start import body_axis

COMPONENTS = ("omega1", "omega2", "omega3", "gamma1", "gamma2", "gamma3")
"""Rates (rad/s) and the vertical in the body."""

TILTS = ("tilt1", "tilt2", "tilt3")
"""Angles between body axes and the upward vertical (rad)."""

MOMENTA = ("L1", "L2", "L3")
"""Angular momentum in space (kg m²/s)."""

SPEED = "speed"
"""The length of the rates (rad/s)."""

POINTING = "pointing"
"""The angle of a body axis from a direction (rad)."""

STATES = tuple(f"state{k}" for k in range(1, MOST_STATES + 1))
"""States of the function of a torque, in the units of the user."""

QUANTITIES = (*COMPONENTS, *TILTS, *MOMENTA, SPEED, POINTING, *ANGLES, *STATES)
"""Names of the quantities that can cross a value."""

UNITS = {
    "omega": "rad/s",
    "L": "kg m²/s",
    SPEED: "rad/s",
    **dict.fromkeys(("tilt", POINTING, *ANGLES), "rad"),
}
"""Units of quantities that have one, by their names without the axis."""

OPEN: Mapping[str, tuple[float, float, str]] = {
    "tilt": (0.0, pi, "a tilt lies between 0 and pi"),
    POINTING: (0.0, pi, "an angle between two directions lies between 0 and pi"),
    "pitch": (-0.5 * pi, 0.5 * pi, "a pitch lies between -pi/2 and pi/2"),
    SPEED: (0.0, float("inf"), "a speed is positive"),
}
"""The open intervals of values that quantities cross, with their rules."""

LEVELS: Mapping[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "tilt": (lambda angle: -cos(angle), sin),
    POINTING: (lambda angle: -cos(angle), sin),
    "pitch": (sin, cos),
    SPEED: (lambda speed: speed**2, lambda speed: 2.0 * speed),
    "roll": (lambda angle: 0.0, lambda angle: 1.0),
    "yaw": (lambda angle: 0.0, lambda angle: 1.0),
}
"""The smooth functions of quantities that are crossed in their place, and their derivatives."""

PLANE = "plane"
"""The name of a quantity that is given by vectors."""

MOST_EVENTS = 32
"""Events that a run watches at most."""

WORDS = {1: "rising", -1: "falling", 0: "both ways"}
_TURNS = {1: "lowest", -1: "highest", 0: "turns"}


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a motion, made by :func:`crosses` or :func:`turns`.

    Attributes
    ----------
    name : str
        The quantity, ``"plane"`` for one of vectors, or the name of a function and ``()``.
    omega, gamma, momentum : tuple of float
        The quantity is ``omega·w + gamma·n + momentum·L`` for the rates ``w`` and the vertical
        ``n`` in the body and the angular momentum ``L`` in space; of a tilt it is minus its cosine.
        All are zero of ``"speed"``, whose square is looked at, of angles from a direction of space
        or the orbit, of which sine or cosine is, of a state, and of a function.
    value : float
        The value that the quantity crosses; zero if it turns.
    direction : int
        1 for rising crossings and least values, -1 for falling ones and largest values, 0 for both.
    turns : bool
        Whether the quantity turns: its rate crosses zero.
    axis : int or None
        The body axis of ``"pointing"``; None for the long axis, and of other quantities.
    of : str or tuple of float or None
        The direction of ``"pointing"``: a name, or a unit vector in space.
    axes : (int, int) or None
        The body axes of roll, pitch and yaw at rest; None for the default of the body.
    function : callable or None
        The function of the state whose value is crossed. No file has it.
    """

    name: str
    omega: tuple[float, float, float]
    gamma: tuple[float, float, float]
    momentum: tuple[float, float, float]
    value: float
    direction: int
    turns: bool
    axis: int | None = None
    of: str | tuple[float, float, float] | None = None
    axes: Axes | None = None
    function: Callable[..., float] | None = None

    @property
    def state(self) -> int:
        """The number of the state that is looked at, from 1 on; 0 if none is."""
        return STATES.index(self.name) + 1 if self.name in STATES else 0

    def words(self) -> str:
        """The event in words.

        Returns
        -------
        str

        Examples
        --------
        >>> import rigid
        >>> rigid.crosses("omega2").words(), rigid.turns("gamma3", -1).words()
        ('omega2 = 0, both ways', 'gamma3 highest')
        """
        name = self.name
        if name == PLANE:
            parts = (("omega", self.omega), ("gamma", self.gamma), ("L", self.momentum))
            name = " + ".join(f"{vector}·{of}" for of, vector in parts if any(vector))
        if name == POINTING:
            axis = "long axis" if self.axis is None else f"axis {self.axis}"
            of = DIRECTIONS[self.of] if isinstance(self.of, str) else self.of
            name = f"angle of {axis} from {of}"
        if self.turns:
            return f"{name} {_TURNS[self.direction]}"
        return f"{name} = {self.value:g}, {WORDS[self.direction]}"

    @property
    def square(self) -> float:
        """The factor of the square of the speed in the function that crosses a level."""
        return 1.0 if self.name == SPEED else 0.0

    @property
    def level(self) -> float:
        """The value of the smooth function that crosses it when the quantity crosses its value."""
        levels = None if self.turns else LEVELS.get(self.name.rstrip("123"))
        return self.value if levels is None else levels[0](self.value)

    @property
    def slope_scale(self) -> float:
        """Ratio of two slopes: of this function, and of the quantity."""
        levels = None if self.turns else LEVELS.get(self.name.rstrip("123"))
        return 1.0 if levels is None else levels[1](self.value)

    def pointing(self, scene: Scene, frame: Floats | None) -> list[float]:
        """Two pairs of a body axis and a direction, and whether the directions are of the orbit.

        The function is the product of the first axis and direction. Of roll and yaw it is, times a
        positive number, the sine of the angle less its value; the product of the second pair is the
        cosine, and positive. Body axes are principal axes, in a frame the axes of the drawing.
        Zeros of other quantities.

        Raises
        ------
        ValueError
            If the scene has no orbit, or its bodies do not tell the axes.
        """
        none: Floats = np.zeros(3)
        pairs, in_orbit = [none] * 4, True
        if self.name not in (POINTING, *ANGLES):
            return [0.0] * 13
        if self.name == POINTING:
            axis = extreme_axis(scene, long=True) if self.axis is None else self.axis
            in_orbit = isinstance(self.of, str)
            of = np.eye(3)[[*DIRECTIONS].index(self.of)] if isinstance(self.of, str) else self.of
            pairs[:2] = -unit_axis(axis), np.asarray(of)
        else:
            roll, pitch, yaw = at_rest(rest_axes(scene) if self.axes is None else self.axes)
            radial, along, normal = np.eye(3)
            cosine, sine = cos(self.value), sin(self.value)
            pairs = {
                "roll": [cosine * pitch - sine * yaw, radial, sine * pitch + cosine * yaw, radial],
                "pitch": [-roll, radial, none, none],
                "yaw": [roll, cosine * normal - sine * along, roll, sine * normal + cosine * along],
            }[self.name]
        if in_orbit:
            require_orbit("turns" if self.turns else "crosses", scene)
        if frame is not None and (self.axis, self.axes) != (None, None):
            pairs[::2] = (turned(frame.T, axis) for axis in pairs[::2])
        return [*np.concatenate(pairs).tolist(), float(in_orbit)]

    def to_dict(self) -> dict[str, Any]:
        """All attributes but a function as plain Python values.

        Returns
        -------
        dict
        """
        values = {name: getattr(self, name) for name in self.__slots__ if name != "function"}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}

    @classmethod
    def from_dict(cls, entries: dict[str, Any]) -> Event:
        """The event that :meth:`to_dict` described.

        Parameters
        ----------
        entries : dict
            The attributes.

        Returns
        -------
        Event

        Examples
        --------
        >>> import rigid
        >>> event = rigid.crosses("omega2")
        >>> rigid.Event.from_dict(event.to_dict()) == event
        True
        """
        own: dict[str, Any] = {
            name: tuple(v) if isinstance(v, list) else v for name, v in entries.items()
        }
        return cls(**own)


def crosses(
    name: str | Callable[..., float] | None = None,
    value: float = 0.0,
    direction: int = 0,
    *,
    omega: ArrayLike | None = None,
    gamma: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    axis: int | None = None,
    of: str | ArrayLike | None = None,
    axes: Axes | None = None,
) -> Event:
    """The event that a quantity crosses a value, for :func:`simulate`.

    Parameters
    ----------
    name : str or callable, optional
        A rate ``"omega1"`` to ``"omega3"`` (rad/s); a component of the upward vertical in the body,
        ``"gamma1"`` to ``"gamma3"``; the angle of a body axis from the vertical, ``"tilt1"`` to
        ``"tilt3"`` (rad), where the vertical is axis 3 of space, also on an orbit: the tilt of maps
        on orbits, from the normal, is ``"pointing"`` with ``of="normal"``; a component of the
        angular momentum in space, ``"L1"`` to ``"L3"`` (kg m²/s); ``"speed"``, the length of the
        rates (rad/s); ``"pointing"``, the angle of a body axis from a direction (rad); ``"roll"``,
        ``"pitch"`` or ``"yaw"`` of a body on an orbit (rad), as :func:`rigid.free.roll_pitch_yaw`
        has them; ``"state1"`` to ``"state8"``, the states of :meth:`Torque.call`, in their units.
        Or a function of the state, see below.
    value : float
        The value of the quantity.
    direction : {0, 1, -1}
        Both ways, rising, or falling.
    omega, gamma, momentum : array_like, shape (3,), optional
        Instead of a name: the quantity ``omega·w + gamma·n + momentum·L`` for the rates ``w`` and
        the vertical ``n`` in the body and the angular momentum ``L`` in space.
    axis : {1, 2, 3, -1, -2, -3}, optional
        The body axis of ``"pointing"``; negative for its opposite direction. By default the long
        axis, about which the moment is smallest, if it is the same of all bodies.
    of : {"radial", "along", "normal"} or array_like, shape (3,), optional
        The direction of ``"pointing"``: of the orbit, as in :func:`pointing_within`, by default
        away from the planet, to which the nadir is opposite; or a vector in space.
    axes : (int, int), optional
        The body axes of roll, pitch and yaw, as in :func:`rigid.free.roll_pitch_yaw`.

    Returns
    -------
    Event

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: an unknown name, a name beside vectors, neither
        of them, vectors that are all zero, another direction, a value that the quantity never
        crosses, an argument of another quantity. A run refuses directions and angles of an orbit
        that its scene does not have.

    Notes
    -----
    A function takes ``(t, omega, attitude)`` and returns a number: of time (s), rates in the body
    (rad/s), and the unit quaternion from the body to space, scalar first. Then may follow
    ``states`` and ``orbit_position``, as of a function of :meth:`Torque.call`. If numba is
    installed, numba compiles the function. The scalar of the quaternion is not negative: where it
    would pass zero, the quaternion changes its sign, and with it what is linear in the quaternion.

    Examples
    --------
    When does a box that turns about its middle axis flip?

    >>> import rigid
    >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> run = rigid.simulate(
    ...     box, [0.01, 1.0, 0.01], t=[0.0, 30.0], events=[rigid.crosses("omega2")]
    ... )
    >>> run.events[0].t.round(3).tolist()
    [10.917]

    When does a moon that turned too slowly lead the line to its planet by 0.3 rad?

    >>> moon = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)), orbit=rigid.Orbit(1.0))
    >>> run = rigid.simulate(
    ...     moon, [0.0, 0.0, 0.4], t=[0.0, 5.0], events=[rigid.crosses("pitch", 0.3)]
    ... )
    >>> run.events[0].t.round(3).tolist()
    [3.658]

    When does the energy of a body that friction slows fall to a half?

    >>> friction = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=0.1)
    >>> def energy(t, omega, attitude):
    ...     return 0.5 * (omega[0]**2 + 1.5 * omega[1]**2 + 2.0 * omega[2]**2)
    >>> run = rigid.simulate(
    ...     friction, [0.0, 0.0, 1.0], t=[0.0, 10.0], events=[rigid.crosses(energy, 0.5)]
    ... )
    >>> run.events[0].t.round(3).tolist()
    [6.931]
    """
    made = _quantity(name, omega, gamma, momentum, axis, of, axes)
    kind = made["name"].rstrip("123")
    value = finite_float("value", value, unit=UNITS.get(kind, "1"))
    if kind in OPEN:
        low, high, rule = OPEN[kind]
        if not low < value < high:
            raise ValueError(f"value = {value}: never crossed; {rule}")
    elif kind in ANGLES:
        if abs(value) > pi:
            raise ValueError(f"value = {value}: never crossed; a {kind} lies between -pi and pi")
    elif any(made["gamma"]) and not any(made["omega"]) and not any(made["momentum"]):
        check_reached(value, np.asarray(made["gamma"]), touching=False)
    return Event(**made, value=value, direction=checked_direction(direction), turns=False)


def turns(
    name: str | None = None,
    direction: int = 0,
    *,
    omega: ArrayLike | None = None,
    gamma: ArrayLike | None = None,
    momentum: ArrayLike | None = None,
    axis: int | None = None,
    of: str | ArrayLike | None = None,
    axes: Axes | None = None,
) -> Event:
    """The event that a quantity has a maximum or a minimum, for :func:`simulate`.

    Parameters
    ----------
    name : str, optional
        As in :func:`crosses`.
    direction : {0, 1, -1}
        Both, least values (the rate rises through zero), or largest values.
    omega, gamma, momentum : array_like, shape (3,), optional
        As in :func:`crosses`.
    axis, of, axes : optional
        As in :func:`crosses`.

    Returns
    -------
    Event

    Raises
    ------
    ValueError
        As :func:`crosses`.

    Examples
    --------
    The nutation of a top is between its turns:

    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.0, 0.0, 1.0))
    >>> run = rigid.simulate(
    ...     top, [0.0, 0.0, 6.0], rigid.rotations.euler_to_quaternion([0.0, 0.5, 0.0]),
    ...     t=[0.0, 5.0], events=[rigid.turns("tilt3")],
    ... )
    >>> run.events[0].tilt(3).round(3).tolist()
    [0.65, 0.5, 0.65]
    """
    if callable(name):
        raise ValueError(
            f"name = {brief(name)}: a function has no known rate; let rigid.crosses find the zeros "
            "of its rate"
        )
    return Event(
        **_quantity(name, omega, gamma, momentum, axis, of, axes),
        value=0.0,
        direction=checked_direction(direction),
        turns=True,
    )


def _quantity(
    name: str | Callable[..., float] | None,
    omega: ArrayLike | None,
    gamma: ArrayLike | None,
    momentum: ArrayLike | None,
    axis: int | None,
    of: str | ArrayLike | None,
    axes: Axes | None,
) -> dict[str, Any]:
    """Name, vectors and axes of a quantity."""
    given = {"omega": omega, "gamma": gamma, "momentum": momentum}
    rows = {
        key: np.zeros(3) if factors is None else vector(key, without_unit(key, factors, "1"), 3)
        for key, factors in given.items()
    }
    if all(value is None for value in given.values()):
        if name is None:
            raise ValueError("name: give the name of a quantity, or the vectors of one")
        if callable(name):
            taken_by(name)
        elif one_of("name", name, QUANTITIES) in (*COMPONENTS, *TILTS, *MOMENTA):
            kind, place = name[:-1], int(name[-1]) - 1
            key = {"omega": "omega", "L": "momentum"}.get(kind, "gamma")
            rows[key][place] = -1.0 if kind == "tilt" else 1.0
    elif name is not None:
        raise ValueError(f"name = {brief(name)}: leave the name out beside omega, gamma, momentum")
    elif not any(row.any() for row in rows.values()):
        raise ValueError("omega, gamma, momentum: all are zero, so they are no quantity")
    owners = {"axis": (axis, (POINTING,)), "of": (of, (POINTING,)), "axes": (axes, ANGLES)}
    for key, (argument, known) in owners.items():
        if argument is not None and name not in known:
            raise ValueError(f"{key} = {brief(argument)}: belongs to {' or '.join(known)}")
    function = name if callable(name) else None
    if function is not None:
        name = f"{getattr(function, '__name__', type(function).__name__)}()"
    return {
        "name": PLANE if name is None else name,
        **{key: three(row) for key, row in rows.items()},
        "axis": None if axis is None else body_axis(axis, signed=True),
        "of": _direction("radial" if of is None else of) if name == POINTING else None,
        "axes": None if axes is None else checked_axes(axes),
        "function": function,
    }


def _direction(of: str | ArrayLike) -> str | tuple[float, float, float]:
    """A direction of the orbit, or the unit vector of one of space."""
    if isinstance(of, str):
        return one_of("of", of, DIRECTIONS)
    given = vector("of", without_unit("of", of, "1"), 3)
    largest = np.abs(given).max()
    if largest == 0.0:
        raise ValueError("of: is zero, so it is no direction")
    x, y, z = given / largest
    return three(given / largest / sqrt(x * x + y * y + z * z))


def checked_events(events: object, until: object) -> tuple[tuple[Event, ...], tuple[bool, ...]]:
    """The events that a run watches, and which of these it counts.

    The events of ``until`` are counted; without ``until`` all events are. An event of ``until``
    that is not among the others is watched after them.
    """
    watched, ends = (_listed(name, given) for name, given in (("events", events), ("until", until)))
    every = (*watched, *(event for event in dict.fromkeys(ends) if event not in watched))
    if len(every) > MOST_EVENTS:
        raise ValueError(f"events: {len(every)} of them; a run watches {MOST_EVENTS} at most")
    return every, tuple(not ends or event in ends for event in every)


def _listed(name: str, given: Any) -> tuple[Event, ...]:
    if given is None:
        return ()
    events = (given,) if isinstance(given, Event) else given
    if isinstance(events, (str, bytes)) or not hasattr(events, "__iter__"):
        raise TypeError(_rule(name, given))
    events = tuple(events)
    for event in events:
        if not isinstance(event, Event):
            raise TypeError(_rule(name, event))
    return events


def _rule(name: str, value: object) -> str:
    return f"{name} = {brief(value)}: must be made by rigid.crosses or rigid.turns, or a list"


def check_reached(value: float, normal: Floats, *, touching: bool) -> None:
    """Raise ValueError if the vertical has no component that crosses, or touches, the value."""
    reach = float(np.linalg.norm(normal))
    if abs(value) > reach or (abs(value) == reach and not touching):
        raise ValueError(
            f"value = {value}: never crossed; along this direction the vertical has components "
            f"from -{reach:g} to {reach:g}"
        )


def checked_direction(direction: object) -> int:
    """The direction of a crossing: 1, -1 or 0 for both."""
    if isinstance(direction, bool) or direction not in (-1, 0, 1):
        raise ValueError(f"direction = {brief(direction)}: must be 1, -1 or 0")
    return int(direction)
