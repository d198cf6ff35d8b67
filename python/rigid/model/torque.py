"""Applied torques, and all forces on bodies as the core reads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief, shaped, sorted_times
from .._checks.arrays import Floats
from .batch import ByValue, Index, Shape, Vector, axes_of, batch_shape, frozen, taken
from .forces import FORCES
from .frame import turned
from .function import NO_STATES, TorqueFunction
from .sampled import Sampled, linear, on_piece

NO_EXPONENT: NDArray[np.intc] = np.zeros(1, dtype=np.intc)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Torque(ByValue):
    """An applied torque in the body or in space, constant or a table over time, of each body.

    Made by :meth:`body`, :meth:`space` and :meth:`call`; torques add.
    Between the times of a table the torque is linear. Two values at one time are a jump. The torque
    is unknown outside the times of the table, so a run beyond them raises ValueError; if the torque
    ends, end the table with zeros.

    Attributes
    ----------
    times : tuple of float
        Times (s) of the table, ascending; empty if the torque is constant.
    in_body, in_space : tuple of (float, float, float), or ndarray of shape (..., m, 3)
        Torque (N m) in the body and in space at these times, or always, m being 1; the torques of
        many bodies are read-only arrays.
    function : TorqueFunction or None
        The function that returns a further torque.

    Examples
    --------
    >>> import rigid
    >>> motor = rigid.Torque.body([(0, 0, 2), (0, 0, 2), (0, 0, 0), (0, 0, 0)], times=[0, 5, 5, 60])
    >>> len((motor + rigid.Torque.space((0.1, 0.0, 0.0))).times)
    4
    """

    times: tuple[float, ...]
    in_body: tuple[Vector, ...] | Floats
    in_space: tuple[Vector, ...] | Floats
    function: TorqueFunction | None = None

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one torque, ``(n,)`` of one for each of n bodies."""
        own = axes_of(self.in_body, 2)
        if self.function is None:
            return own
        return batch_shape({"torque": own, "data": self.function.shape})

    def of(self, shape: Shape, index: Index) -> Torque:
        """The torque of some of the bodies of this shape."""
        if not self.shape:
            return self
        body, space = (
            np.asarray(taken(part, 2, shape, index)) for part in (self.in_body, self.in_space)
        )
        function = None if self.function is None else self.function.of(shape, index)
        return Torque(self.times, _vectors(body), _vectors(space), function)

    def __repr__(self) -> str:
        if self.shape:
            return f"Torque({self.words()}, bodies of shape {self.shape})"
        others = "" if self.function is None else f", {self.function}"
        return (
            f"Torque(times={self.times}, in_body={self.in_body}, in_space={self.in_space}{others})"
        )

    @classmethod
    def body(cls, values: ArrayLike, *, times: ArrayLike | None = None) -> Torque:
        """A torque with these components along the body axes.

        Parameters
        ----------
        values : array_like, shape (..., 3), or (..., m, 3) with ``times``
            Torque (N m); leading axes give each body its torque.
        times : array_like, shape (m,), optional
            Times (s) of the table, ascending, at least two; equal neighbours are a jump. The tables
            of many bodies have the same times.

        Returns
        -------
        Torque

        Raises
        ------
        ValueError
            If the shapes do not fit, a number is not finite, or the times are not ascending.

        Examples
        --------
        >>> import rigid
        >>> rigid.Torque.body((0.0, 0.0, 0.2)).words()
        'torque (0, 0, 0.2) in the body'
        """
        return cls._made(values, times, 0)

    @classmethod
    def space(cls, values: ArrayLike, *, times: ArrayLike | None = None) -> Torque:
        """A torque with these components along the space axes; arguments as in :meth:`body`.

        Parameters
        ----------
        values, times
            As in :meth:`body`.

        Returns
        -------
        Torque

        Raises
        ------
        ValueError
            As for :meth:`body`.

        Examples
        --------
        >>> import rigid
        >>> rigid.Torque.space((0.0, 0.0, 0.2)).words()
        'torque (0, 0, 0.2) in space'
        """
        return cls._made(values, times, 1)

    @classmethod
    def call(
        cls,
        address: object,
        data: ArrayLike | None = None,
        *,
        fastest: float | None = None,
        states: int = 0,
    ) -> Torque:
        """A callback: the torque in the body that a function returns.

        The function takes ``(t, omega, attitude, data, torque)``: the time (s), the rates (3,
        rad/s, in the body), the attitude (4, unit quaternion, scalar first and not negative, body
        to space) and ``data``, empty if there are none. It writes the torque (3, N m, along the
        principal axes). A number that it does not write is NaN, which ends the body with the status
        ``NOT_FINITE``. It must not depend on earlier calls, and must be safe to call from several
        threads at once. What a function raises, the call of ``rigid`` raises.

        A function of Python gets arrays. If numba is installed (``pip install
        'rigid-rotation[numba]'``), it compiles the function once, with what the function takes from
        outside, into a loop over bodies side by side. Else, and if numba cannot compile it, Python
        calls it for each body with the lock of the interpreter, which :func:`plan` says.

        With ``states=k`` each body has k further numbers, such as the momentum of a wheel or the
        signal of a filter, which are integrated with the body. The function then takes ``(t, omega,
        attitude, data, torque, states, rates)`` and writes the rates of change of its states (k)
        into ``rates``, in the units of the user per second. They begin at zero, or at the
        ``states`` of :func:`simulate` and :class:`Start`. The states count in the error
        of a step and of a run, each relative to its largest value. A value below 1e-9, or below a
        millionth of the largest state of the body, counts as so large: choose units accordingly.

        A function whose last argument is named ``orbit_position`` is told the place of the body on
        its ``orbit``, from the planet, along the axes of space, over the semi-major axis of an
        ellipse or a hyperbola (3): times ``(gm / rate**2)**(1/3)`` it is a length. Along
        :meth:`Orbit.table` the rate counts as 1 rad/s: times ``gm**(1/3)`` the place is a length.

        A function at an address is called for each body, and has the signature ::

            void torque(double t, const double *omega, const double *attitude,
                        const double *data, double *torque)

        or, with states, and if its signature is known, the signature ::

            void torque(double t, const double *omega, const double *attitude,
                        const double *data, double *torque, const double *states,
                        double *rates, const double *orbit_position)

        whose ``orbit_position`` is zero without an orbit.

        At corners of the torque equal steps lose their order, and steps by a ``tolerance`` become
        short; at a jump where a rate changes its sign they become endless, unless the torque has a
        dead zone. A run makes at least 64 steps and ends one at each output time: it sees every
        pulse that is longer than 0.42 % of the run. Shorter ones need output times, or a ``step``.

        ``"dop853"`` is the default, alone takes a ``tolerance``, and finds events and sections.
        ``"rk4"`` and ``"midpoint"`` take equal steps, ``"midpoint"`` without states. At a jump two
        runs in equal steps may err alike by chance, so that the stated error is too small: leave
        the method out, or give a step that puts the jumps at its ends. The bits depend on the
        function.

        Parameters
        ----------
        address : callable, numba.cfunc, function of ctypes or cffi, or int
            The function, also one of ``numba.njit``, or the address of one. A function is kept
            alive as long as the torque; that at an address you keep. A wrong address ends the
            process.
        data : array_like, shape (k,) or (..., k), optional
            Numbers for the function, copied; leading axes give each body its numbers.
        fastest : float, optional
            A bound of ``|omega|`` under this torque (rad/s), and of the rate at which the torque
            varies: equal steps follow from it, and no other step is longer than 2 rad.
        states : int
            The number of further states of each body, at most 8.

        Returns
        -------
        Torque

        Raises
        ------
        TypeError
            If there is no function, or it tells that it takes other arguments.
        ValueError
            If the address is not positive, data or bound are not finite, or there are too many
            states.

        Warns
        -----
        UserWarning
            If numba is installed, but cannot compile the function.

        Examples
        --------
        Damping by a function, whose data is the coefficient:

        >>> import numpy as np, rigid
        >>> def damping(t, omega, attitude, data, torque):
        ...     for k in range(3):
        ...         torque[k] = -data[0] * omega[k]
        >>> body = rigid.Body((1.0, 1.5, 2.0))
        >>> scene = rigid.FreeBody(body, torque=rigid.Torque.call(damping, [0.1], fastest=2.0))
        >>> run = rigid.simulate(scene, [0.3, 1.0, 0.2], t=[5.0], accuracy=1e-9)
        >>> damped = rigid.simulate(rigid.FreeBody(body, damping=0.1), [0.3, 1.0, 0.2], t=[5.0])
        >>> bool(np.allclose(run.omega, damped.omega, rtol=0.0, atol=1e-8))
        True

        A wheel about the third axis, whose motor slows the body; its momentum is a state:

        >>> def wheel(t, omega, attitude, data, torque, states, rates):
        ...     h, motor = states[0], -0.5 * omega[2]
        ...     torque[0], torque[1], torque[2] = -omega[1] * h, omega[0] * h, motor
        ...     rates[0] = -motor
        >>> scene = rigid.FreeBody(body, torque=rigid.Torque.call(wheel, states=1))
        >>> run = rigid.simulate(scene, [0.0, 0.0, 1.0], states=[0.1], t=[0.0, 30.0])
        >>> bool(np.allclose(2.0 * run.omega[:, 2] + run.states[:, 0], 2.1, rtol=1e-8))
        True
        """
        none = ((0.0, 0.0, 0.0),)
        function = TorqueFunction.of_input(address, data, fastest, states)
        return cls((), none, none, function)

    @property
    def states(self) -> int:
        """How many states a function has for each body."""
        return 0 if self.function is None else self.function.states

    def started(self, states: ArrayLike) -> Torque:
        """The torque whose function begins at these states, shape (k,) or (..., k).

        Raises
        ------
        ValueError
            If there are none, or not as many.
        """
        if self.function is None:
            raise ValueError(NO_STATES)
        return replace(self, function=self.function.started(states))

    @classmethod
    def _made(cls, values: ArrayLike, times: ArrayLike | None, frame: int) -> Torque:
        _refuse_function(values)
        array = shaped("torque", values)
        if times is None:
            knots = np.empty(0)
            wanted: Shape = (3,)
        else:
            knots = sorted_times("torque times", times)
            if len(knots) < 2:
                raise ValueError(f"torque times = {knots.tolist()}: a table has at least two times")
            wanted = (len(knots), 3)
        if array.shape[-len(wanted) :] != wanted:
            shape = ", ".join(map(str, wanted))
            raise ValueError(f"torque: expected shape (..., {shape}), got {array.shape}")
        acting = array if len(knots) else array[..., np.newaxis, :]
        parts = [acting, np.zeros_like(acting)]
        made = cls(tuple(knots.tolist()), _vectors(parts[frame]), _vectors(parts[1 - frame]))
        forces_of(made, None, made.shape)
        return made

    def __add__(self, other: Torque) -> Torque:
        """Both torques together, over the times that both tables reach."""
        if not isinstance(other, Torque):
            return NotImplemented
        knots = _common_knots(self.times, other.times)
        parts = [
            [_at(torque.times, values, knots) for values in (torque.in_body, torque.in_space)]
            for torque in (self, other)
        ]
        batch_shape({"torque": self.shape, "other torque": other.shape})
        body, space = (_vectors(parts[0][frame] + parts[1][frame]) for frame in (0, 1))
        if self.function is not None and other.function is not None:
            raise ValueError("torque: both are functions; write one function for their sum")
        return Torque(tuple(knots.tolist()), body, space, self.function or other.function)

    def turned(self, axes: Floats) -> Torque:
        """The torque with other body axes: the part in the body becomes ``axes @ torque``."""
        if self.function is not None:
            raise ValueError(
                "frame: a function returns a torque along the principal axes; turn its arguments "
                "and its torque in the function, and leave the frame out"
            )
        body = turned(axes, np.asarray(self.in_body))
        return Torque(self.times, _vectors(body), self.in_space)

    @property
    def acts_in_space(self) -> bool:
        """Whether the torque may depend on the attitude: a part acts in space, or a callback."""
        return self.function is not None or bool(np.any(self.in_space))

    def at(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Torque (N m) in the body and in space at times ``t``, without a callback.

        Parameters
        ----------
        t : array_like, shape (m,)
            Times (s).

        Returns
        -------
        in_body, in_space : ndarray, shape (..., m, 3)
            Torque (N m), without a callback; at a jump the value after it.

        Raises
        ------
        ValueError
            If the table does not reach a time.

        Examples
        --------
        >>> import rigid
        >>> ramp = rigid.Torque.body([(0, 0, 0), (0, 0, 2)], times=[0.0, 4.0])
        >>> ramp.at([1.0, 2.0])[0][:, 2].tolist()
        [0.5, 1.0]
        """
        parts = (self.in_body, self.in_space)
        body, space = (linear("torque", self.times, part, t) for part in parts)
        return body, space

    def words(self) -> str:
        """The torque in a few words.

        Returns
        -------
        str
        """
        frames = [
            (name, values)
            for name, values in (("body", self.in_body), ("space", self.in_space))
            if np.any(values)
        ]
        if self.function is not None:
            others = Torque(self.times, self.in_body, self.in_space)
            own = "torque by a function"
            return f"{own}, {others.words()}" if frames else own
        if not frames:
            return "torque zero"
        if self.shape and not self.times:
            places = " and ".join(name for name, _ in frames)
            return f"torque of each in the {places}".replace("the space", "space")
        if self.times:
            places = " and ".join(name for name, _ in frames)
            return f"torque in the {places} by a table of {len(self.times)} times".replace(
                "the space", "space"
            )
        return ", ".join(
            f"torque ({', '.join(f'{part:g}' for part in values[0])}) in "
            f"{'the body' if name == 'body' else 'space'}"
            for name, values in frames
        )

    def to_dict(self) -> dict[str, Any]:
        """The torque as a dict of numbers; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        return {
            "times": list(self.times),
            "in_body": np.asarray(self.in_body).tolist(),
            "in_space": np.asarray(self.in_space).tolist(),
            **({} if self.function is None else {"function": self.function.to_dict()}),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Torque:
        """The torque that :meth:`to_dict` described; a callback in it cannot be called.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        Torque

        Examples
        --------
        >>> import rigid
        >>> torque = rigid.Torque.body((0.0, 0.0, 0.2))
        >>> rigid.Torque.from_dict(torque.to_dict()) == torque
        True
        """
        times = data["times"] or None
        parts = []
        for make, values in ((cls.body, data["in_body"]), (cls.space, data["in_space"])):
            parts.append(make(values if times else np.asarray(values)[..., 0, :], times=times))
        given = data.get("function")
        function = None if given is None else TorqueFunction.from_dict(given)
        return cls(parts[0].times, parts[0].in_body, parts[1].in_space, function)


def _refuse_function(torque: object) -> None:
    if callable(torque):
        raise TypeError(
            f"torque = {brief(torque)}: a torque is constant or a table of times; for one that "
            "depends on the state take rigid.Torque.call, or make steps with rigid.Motion"
        )


def checked_torque(torque: object) -> Torque | None:
    """``torque``, if it is a torque; None if there is none."""
    if torque is None or isinstance(torque, Torque):
        return torque
    _refuse_function(torque)
    raise TypeError(
        f"torque = {brief(torque)}: must be a rigid.Torque: rigid.Torque.body((N1, N2, N3)) or "
        "rigid.Torque.space((N1, N2, N3))"
    )


@np.errstate(over="ignore")
def forces_of(
    torque: Torque | None,
    damping: ArrayLike | None,
    shape: Shape = (),
    exponents: NDArray[np.intc] = NO_EXPONENT,
    further: Mapping[str, ArrayLike | Sampled] = MappingProxyType({}),
) -> _core.Forces | None:
    """The forces on bodies of this shape as the core reads them; None if nothing acts.

    They are counted in units of ``2**exponents``, one for each body or one for all. ``further``
    has the numbers or the tables of further forces by their names.

    Raises
    ------
    ValueError
        If they are too large for the unit.
    """
    if torque is None and damping is None and not further:
        return None
    if torque is not None and torque.function is not None:
        torque.function.check_place(further.get("orbit"))
    d = np.zeros((3, 3)) if damping is None else np.asarray(damping)
    entries = d[..., [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    none = np.empty((0, 3))
    tables = [none, none] if torque is None else [np.asarray(torque.in_body), torque.in_space]

    def scaled(name: str, values: ArrayLike, width: int, has_mass: bool = True) -> Floats:
        array = np.asarray(values)
        if array.ndim > width:
            array = np.broadcast_to(array, (*shape, *array.shape[-width:]))
        lead, tail = array.shape[: array.ndim - width], array.shape[array.ndim - width :]
        each = array.reshape(prod(lead), *tail)
        units = exponents if has_mass else NO_EXPONENT
        found: Floats = np.ldexp(each, -units.reshape(-1, *(1,) * width))
        if not np.isfinite(found).all():
            raise ValueError(f"{name}: must be below 1e308 times the largest moment")
        return np.ascontiguousarray(found.reshape(prod(found.shape[:-1]), tail[-1]))

    others, knots = {}, {}
    for name, given in further.items():
        has_mass = FORCES[name].has_mass
        if isinstance(given, Sampled):
            vectors = scaled(name, given.samples, 2, has_mass)
            others[name] = vectors.reshape(-1, 3 * len(given.t))
            knots[name] = given.t
        else:
            others[name] = scaled(name, given, 1, has_mass)
    return _core.Forces(
        times=np.array(() if torque is None else torque.times, dtype=np.float64),
        body=scaled("torque", tables[0], 2),
        space=scaled("torque", tables[1], 2),
        damping=scaled("damping", entries, 1),
        further=others or None,
        knots=knots or None,
        function=None
        if torque is None or torque.function is None
        else torque.function.for_core(shape, exponents),
    )


def _rows(array: Floats) -> tuple[Vector, ...]:
    return tuple((float(a), float(b), float(c)) for a, b, c in array)


def _vectors(array: Floats) -> tuple[Vector, ...] | Floats:
    """The vectors of one body as tuples, the vectors of many bodies as an array."""
    return _rows(array) if array.ndim == 2 else frozen(array)


def _common_knots(first: tuple[float, ...], second: tuple[float, ...]) -> Floats:
    """The times of both tables, as far as both reach; jumps stay."""
    if not first or not second:
        return np.array(first or second)
    begin, end = max(first[0], second[0]), min(first[-1], second[-1])
    if not begin < end:
        raise ValueError(
            f"torque times: the tables have no time in common: [{first[0]:g}, {first[-1]:g}] and "
            f"[{second[0]:g}, {second[-1]:g}]"
        )
    every = sorted({knot for knot in (*first, *second) if begin <= knot <= end})
    jumps = {knot for times in (first, second) for knot in every if times.count(knot) > 1} - {
        begin,
        end,
    }
    return np.array([knot for knot in every for _ in range(2 if knot in jumps else 1)])


def _at(times: Sequence[float], values: ArrayLike, knots: Floats) -> Floats:
    """A table at the knots of a finer one: before a jump and after it, where there is one."""
    if not len(knots) or not times:
        array = np.array(values)
        return np.broadcast_to(array, (*array.shape[:-2], max(len(knots), 1), 3)).copy()
    own, array = np.array(times), np.array(values)
    before = np.zeros(len(knots), dtype=bool)
    before[:-1] = knots[:-1] == knots[1:]
    before[-1] = True
    after = np.searchsorted(own, knots, side="right") - 1
    left = np.searchsorted(own, knots, side="left") - 1
    piece = np.clip(np.where(before, left, after), 0, len(own) - 2)
    return on_piece(own, array, piece, knots)
