"""The further forces of a scene, besides applied torque and linear damping.

A new force is one class in this file, and its keyword and attribute in the scenes on which it acts.
Parameters, TOML files, datasets and the core know it by its name.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, Self, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import brief, finite_float, shaped
from .._checks.arrays import Floats
from .batch import ByValue, Index, Shape, Vector, axes_of, taken, vector_of
from .frame import turned
from .orbit import Orbit
from .sampled import RotorTable, Sampled

Value = TypeVar("Value")
Momentum: TypeAlias = Vector | Floats | RotorTable


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class EnergySink(ByValue):
    """Internal dissipation, which drains energy and keeps the angular momentum in space.

    Inside the body something lags behind: a viscous fluid, or a damper. To first order its momentum
    relative to the body is ``-P omega'``, where ``omega'`` is the rate of change without the sink
    (Chernousko 1965 of a cavity filled with a very viscous fluid). With ``omega`` the rates of the
    rigid body that has the momentum, ``I omega = L - h``, the body turns in space at ``omega + e``,
    ``e = I⁻¹ P omega'``. So

        I omega' = … + L × e,    dE/dt = -omega'·P omega' + torque·(omega + e).

    ``L`` is constant in space to rounding, whatever ``P``: the dissipation is a double bracket
    (Bloch, Krishnaprasad, Marsden, Ratiu 1996). Every body ends in a rotation about its axis of the
    largest moment, in flat spin if it began about the axis of the smallest moment. Backward in time
    the energy grows.

    Physics asks that ``P |omega| / I`` is small; then ``e`` is too.

    Parameters
    ----------
    coefficient : float or array_like, shape (3,) or (..., 3)
        The diagonal of ``P`` in the axes of the body (kg m² s), one number if all three are equal;
        leading axes give each body its sink.

    Attributes
    ----------
    coefficient : tuple of 3 floats, or ndarray of shape (..., 3)

    Raises
    ------
    ValueError
        If a coefficient is negative or not finite, or the shape does not fit.

    References
    ----------
    F. L. Chernousko, Motion of a rigid body with cavities filled with a viscous fluid at small
    Reynolds numbers, USSR Comput. Math. Math. Phys. 5 (1965) 99-127.
    A. Bloch, P. S. Krishnaprasad, J. E. Marsden, T. S. Ratiu, The Euler-Poincaré equations and
    double bracket dissipation, Commun. Math. Phys. 175 (1996) 1-42.

    Examples
    --------
    A long body that spins about its long axis, and ends in a flat spin with the same momentum:

    >>> import numpy as np, rigid
    >>> body = rigid.Body((1.0, 3.0, 3.2))
    >>> debris = rigid.FreeBody(body, dissipation=rigid.EnergySink(0.05))
    >>> run = rigid.simulate(debris, [2.0, 0.01, 0.0], t=[0.0, 2000.0])
    >>> [round(float(np.linalg.norm(body.moments * omega)), 6) for omega in run.omega]
    [2.000225, 2.000225]
    >>> bool(abs(run.omega[-1, 2]) > 0.999999 * 2.000225 / 3.2)
    True
    """

    coefficient: Vector | Floats

    def __init__(self, coefficient: ArrayLike) -> None:
        object.__setattr__(self, "coefficient", vector_of(_along("coefficient", coefficient)))

    @classmethod
    def viscous_sphere(cls, radius: float, *, density: float, viscosity: float) -> Self:
        """The energy sink of a spherical cavity filled with a very viscous fluid.

        ``P = 8 pi rho a⁷ / (525 nu)``, of a cavity anywhere in the body (Chernousko 1965).

        Parameters
        ----------
        radius : float
            Radius ``a`` of the cavity (m).
        density : float
            Density ``rho`` of the fluid (kg/m³).
        viscosity : float
            Kinematic viscosity ``nu`` (m²/s); the Reynolds number ``a² |omega| / nu`` must be
            small.

        Returns
        -------
        EnergySink

        Raises
        ------
        ValueError
            If a number is not positive and finite.

        Examples
        --------
        >>> import rigid
        >>> sink = rigid.EnergySink.viscous_sphere(0.2, density=1000.0, viscosity=0.01)
        >>> round(sink.coefficient[0], 6)
        0.061276
        """
        a = finite_float("radius", radius, positive=True)
        rho = finite_float("density", density, positive=True)
        nu = finite_float("viscosity", viscosity, positive=True)
        with np.errstate(all="ignore"):
            coefficient = float(8.0 * np.pi * rho * np.float64(a) ** 7 / (525.0 * nu))
        if not 0.0 < coefficient < np.inf:
            raise ValueError(
                f"radius = {a:g}: the coefficient, {coefficient:g}, leaves the range of doubles; "
                "count in other units"
            )
        return cls(coefficient)

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one sink, ``(n,)`` of one for each of n bodies."""
        return axes_of(self.coefficient, 1)

    def __repr__(self) -> str:
        if self.shape:
            return f"EnergySink(coefficient of shape {np.shape(self.coefficient)})"
        return f"EnergySink({self.coefficient})"


def _along(name: str, given: ArrayLike, unit: str | None = None) -> Floats:
    """Coefficients along the principal axes, none negative, from one for all or one for each."""
    array = shaped(name, given, nonnegative=True, unit=unit)
    if array.ndim and array.shape[-1] != 3:
        raise ValueError(f"{name}: expected shape () or (..., 3), got {array.shape}")
    return np.broadcast_to(array, (*array.shape[:-1], 3))


Guess: TypeAlias = Callable[[Floats, float, float], ArrayLike]
"""How far off the first guess of a fit may be, from its numbers, largest moment and rates."""


def tenth_of_moment(power: int) -> Guess:
    """A tenth of the largest moment times a power of the rates."""
    return lambda numbers, moment, rate: 0.1 * moment * rate**power


_IN_CORE, CHANGES = _core.further_forces()
"""Words, width and first place of each further force; and how many numbers the core keeps of a
body: before the forces moments, ``mgl com``, damping 11, 22, 33, 23, 31, 12, and torque in body."""


class Force(Generic[Value]):
    """A force of a scene: its attribute, keyword, key in TOML files and name in the core.

    Its numbers are a vector, or coefficients along the principal axes, of one body or of each.

    Attributes
    ----------
    name : str
        The name.
    title : str
        What the numbers are.
    unit : str
        Unit of the numbers.
    is_vector : bool
        Whether the numbers are a vector, which turns with the axes; coefficients do not.
    has_corner : bool
        Whether the torque has a corner where the body stops.
    has_mass : bool
        Whether the numbers are in proportion to the mass of the body.
    in_space : bool
        Whether the torque depends on the attitude.
    power : int
        The numbers are moments times this power of rates.
    of_all, of_each : tuple of (str, str)
        Symbol and meaning of the parameter that sets all coefficients, and of the one that sets
        the number along an axis, which stands for ``#``; None without such a parameter.
    phrase : str
        The force in messages.
    width : int
        How many numbers it has.
    first : int
        Where the core keeps the first of them.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    unit: ClassVar[str]
    is_vector: ClassVar[bool] = False
    has_corner: ClassVar[bool] = False
    has_mass: ClassVar[bool] = True
    in_space: ClassVar[bool] = False
    power: ClassVar[int]
    of_all: ClassVar[tuple[str, str] | None] = None
    of_each: ClassVar[tuple[str, str] | None] = None

    def __init__(self) -> None:
        self.phrase, self.width, self.first = _IN_CORE[self.name]

    def checked(self, given: Any) -> Value | None:
        """The given value, as a value of one body or of each; None if it is zero.

        Raises
        ------
        ValueError
            If it is impossible.
        """
        if self.is_vector:
            return self._value(shaped(self.name, given, 3, unit=self.unit))
        return self._value(_along(self.name, given, self.unit))

    def _value(self, array: Floats) -> Value | None:
        value: Any = vector_of(array) if array.any() else None
        return cast("Value | None", value)

    def numbers(self, value: Value) -> Any:
        """The numbers for the core: a tuple of one body, an array of many; or their table."""
        return value

    def shape(self, value: Value) -> Shape:
        """The axes of the bodies of a value."""
        numbers = self.numbers(value)
        return numbers.shape if isinstance(numbers, RotorTable) else axes_of(numbers, 1)

    def made(self, numbers: Any) -> Value | None:
        """The value with these numbers; None if they are zero."""
        return self.checked(numbers)

    def varied(self, value: Value | None, numbers: Floats) -> Value | None:
        """The value like another one with the numbers that parameters set, of each body."""
        return self.made(numbers)

    def to_data(self, value: Value) -> Any:
        """The value in the form that files hold."""
        return np.asarray(self.numbers(value)).tolist()

    def of_data(self, data: Any) -> Value | None:
        """The value from the form of :meth:`to_data`, or from a key of a TOML file."""
        return self.made(data)

    def of(self, value: Value, shape: Shape, index: Index) -> Value | None:
        """The value of some of the bodies of this shape."""
        return self.made(taken(self.numbers(value), 1, shape, index))

    def turned(self, value: Value, axes: Floats) -> Value | None:
        """The value with other body axes."""
        numbers = np.asarray(self.numbers(value))
        if self.is_vector:
            return self.checked(turned(axes, numbers))
        if not (numbers == numbers[..., :1]).all():
            raise ValueError(
                f"{self.name} = {brief(value)}: has coefficients along the principal axes; with a "
                "frame give one number"
            )
        return value

    def words(self, value: Value, varied: Container[str] = ()) -> str:
        """The force in a few words; ``varied`` names the numbers that the axes of a map set."""
        if self.name in varied:
            return f"{self.name} varied"
        numbers = self.numbers(value)
        if isinstance(numbers, np.ndarray):
            return f"{self.name} of each"
        if not self.is_vector and len(set(numbers)) == 1:
            return f"{self.name} {numbers[0]:g}"
        return f"{self.name} ({', '.join(f'{part:g}' for part in numbers)})"

    def guess(self, numbers: Floats, moment: float, rate: float) -> ArrayLike:
        """How far off the first guess of a fit may be: see :data:`Guess`."""
        return tenth_of_moment(self.power)(numbers, moment, rate)

    def torque(self, numbers: Floats, omega: Floats) -> Floats | float:
        """The torque in the body at rates, as in the equations of motion; N m."""
        return 0.0


class GravityGradient(Force[Orbit]):
    """The gravity gradient on an orbit."""

    name = "orbit"
    title = "rate, eccentricity, mean anomaly and semi-axes of the orbit"
    unit = ""
    has_mass = False
    in_space = True

    def checked(self, given: Any) -> Orbit | None:
        """The orbit."""
        if not isinstance(given, Orbit):
            raise TypeError(f"orbit = {brief(given)}: must be a rigid.Orbit")
        return given

    def numbers(self, value: Orbit) -> Any:
        """Its numbers, shape (..., 9), or the table that it is."""
        return value if isinstance(value, Sampled) else value.numbers

    def guess(self, numbers: Floats, moment: float, rate: float) -> Floats:
        """Of the rate a share, of the eccentricity and the anomaly all that is not told at once."""
        return np.array([0.1 * numbers[0], 0.1, 1.0])

    def varied(self, value: Orbit | None, numbers: Floats) -> Orbit | None:
        """The orbit with these rates, eccentricities and anomalies."""
        assert value is not None
        rate, e, anomaly = numbers.T
        return Orbit(rate, e, anomaly, value.normal, value.periapsis)

    def of(self, value: Orbit, shape: Shape, index: Index) -> Orbit | None:
        """The orbits of some of the bodies."""
        if not value.shape:
            return value
        parts = ("rate", "eccentricity", "anomaly"), ("normal", "periapsis")
        return Orbit(
            **{
                name: taken(getattr(value, name), width, shape, index)
                for width, names in enumerate(parts)
                for name in names
            }
        )

    def to_data(self, value: Orbit) -> Any:
        """The orbit as a dict."""
        return value.to_dict()

    def of_data(self, data: Any) -> Orbit | None:
        """The orbit of a dict."""
        return Orbit.from_dict(data)

    def turned(self, value: Orbit, axes: Floats) -> Orbit | None:
        """The orbit, which is in space."""
        return value

    def words(self, value: Orbit, varied: Container[str] = ()) -> str:
        """The orbit in a few words."""
        return value.words(varied)


class Dissipation(Force[EnergySink]):
    """Internal dissipation."""

    name = "dissipation"
    title = "coefficients of the energy sink"
    unit = "kg m² s"
    power = -1
    of_all = "$P$", "coefficient of the energy sink, the same along all axes"
    of_each = "$P_#$", "coefficient of the energy sink along axis #"

    def checked(self, given: Any) -> EnergySink | None:
        """The sink, if it drains energy."""
        if not isinstance(given, EnergySink):
            raise TypeError(f"dissipation = {brief(given)}: must be a rigid.EnergySink")
        return given if np.any(given.coefficient) else None

    def numbers(self, value: EnergySink) -> Any:
        """The coefficients."""
        return value.coefficient

    def made(self, numbers: Any) -> EnergySink | None:
        """The sink with these coefficients."""
        return self.checked(EnergySink(_along(self.name, numbers, self.unit)))


class Rotor(Force[Momentum]):
    """A rotor at constant speed, or with a momentum by a table."""

    name = "rotor"
    title = "angular momentum of the rotor"
    unit = "kg m²/s"
    is_vector = True
    power = 1
    of_each = "$h_#$", "angular momentum of the rotor about body axis #"

    def checked(self, given: Any) -> Momentum | None:
        """The momentum, or its table."""
        return given if isinstance(given, RotorTable) else super().checked(given)

    def to_data(self, value: Momentum) -> Any:
        """The momentum as a list, a table as a dict."""
        return value.to_dict() if isinstance(value, RotorTable) else super().to_data(value)

    def of_data(self, data: Any) -> Momentum | None:
        """The momentum of a list, or the table of a dict."""
        return RotorTable(**data) if isinstance(data, Mapping) else super().of_data(data)

    def of(self, value: Momentum, shape: Shape, index: Index) -> Momentum | None:
        """The rotors of some of the bodies."""
        if isinstance(value, RotorTable):
            return value.of(shape, index)
        return super().of(value, shape, index)

    def turned(self, value: Momentum, axes: Floats) -> Momentum | None:
        """The rotor with other body axes."""
        return value.turned(axes) if isinstance(value, RotorTable) else super().turned(value, axes)

    def words(self, value: Momentum, varied: Container[str] = ()) -> str:
        """The rotor in a few words."""
        return value.words() if isinstance(value, RotorTable) else super().words(value, varied)


class Drag(Force[Vector | Floats]):
    """Quadratic drag."""

    name = "drag"
    title = "coefficients of the drag"
    unit = "N m s²"
    has_corner = True
    power = 0
    of_all = "drag $C$", "coefficient of the quadratic drag, the same about all axes"
    of_each = "$C_#$", "coefficient of the quadratic drag about axis #"

    def torque(self, numbers: Floats, omega: Floats) -> Floats:
        """``-|omega| C omega``."""
        speed = np.linalg.norm(omega, axis=-1, keepdims=True)
        return np.asarray(-speed * omega * numbers)


FORCES: Mapping[str, Force[Any]] = {kind.name: kind() for kind in Force.__subclasses__()}
"""The further forces by their names."""

_PHRASES = {
    "function": "the torque of a function",
    **{name: force.phrase for name, force in FORCES.items()},
}


def forces_in_words(names: Iterable[str]) -> str:
    """What acts on a body, for messages: the names as in :attr:`rigid.Method.forces`."""
    every = list(names)
    words = [
        _PHRASES.get(name, name) for name in every if name != "torque" or "function" not in every
    ]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
