"""What acts on a satellite: energy sink, rotor, drag, and the orbit of a gravity gradient."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, shaped, unit_vector
from .leading import Index, Shape, axes_of, frozen, same, taken

__all__ = [
    "EnergySink",
    "Orbit",
    "checked_drag",
    "checked_rotor",
    "checked_sink",
    "drag_words",
    "rotor_words",
    "satellite_rows",
]

Floats = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class EnergySink:
    """Internal dissipation: it drains energy and keeps the angular momentum in space.

    Inside the body something lags behind: a viscous fluid, or a damper. To first order its momentum
    relative to the body is ``-P omega'``, where ``omega'`` is the rate of change without the sink
    (Chernousko 1965 of a cavity filled with a very viscous fluid). With ``omega`` the rates of the
    rigid body that has the momentum, ``I omega = L - h``, the body turns in space at ``omega + e``,
    ``e = I⁻¹ P omega'``. So

        I omega' = … + L × e,    dE/dt = -omega'·P omega' + torque·(omega + e).

    ``L`` is constant in space to rounding, whatever ``P``: the law is a double bracket (Bloch,
    Krishnaprasad, Marsden, Ratiu 1996). Every body ends in a rotation about its axis of the largest
    moment, in flat spin if it began about that of the smallest. Backward in time the energy grows.

    Physics asks that ``P |omega| / I`` is small; then ``e`` is too.

    Parameters
    ----------
    coefficient : float or array_like, shape (3,) or (..., 3)
        The diagonal of ``P`` in the axes of the body (kg m² s), one number if all three are equal;
        leading axes give each body a sink of its own.

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
        array = shaped("coefficient", coefficient, nonnegative=True)
        if array.ndim and array.shape[-1] != 3:
            raise ValueError(f"coefficient: expected shape () or (..., 3), got {array.shape}")
        object.__setattr__(
            self, "coefficient", _vector(np.broadcast_to(array, (*array.shape[:-1], 3)))
        )

    @classmethod
    def viscous_sphere(cls, radius: float, *, density: float, viscosity: float) -> Self:
        """The sink of a spherical cavity that is full of a very viscous fluid.

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
        return cls(8.0 * np.pi * rho * a**7 / (525.0 * nu))

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one sink, ``(n,)`` of one for each of n bodies."""
        return axes_of(self.coefficient, 1)

    def of(self, shape: Shape, index: Index) -> EnergySink:
        """The sink of some of the bodies of this shape."""
        return EnergySink(taken(self.coefficient, 1, shape, index)) if self.shape else self

    def words(self) -> str:
        """The sink in a few words."""
        if self.shape:
            return "dissipation of each"
        first, second, third = self.coefficient
        if first == second == third:
            return f"dissipation {first:g}"
        return f"dissipation ({first:g}, {second:g}, {third:g})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EnergySink):
            return NotImplemented
        return same(self.coefficient, other.coefficient)

    def __hash__(self) -> int:
        return hash(("sink", self.shape or self.coefficient))

    def __repr__(self) -> str:
        if self.shape:
            return f"EnergySink(coefficient of shape {np.shape(self.coefficient)})"
        return f"EnergySink({self.coefficient})"


@dataclass(frozen=True, slots=True)
class Orbit:
    """A circular orbit: its rate, and the directions to the centre now and a quarter later.

    Attributes
    ----------
    rate : float
        Angle per time (rad/s).
    towards, ahead : tuple of 3 floats
        Direction to the centre at ``t = 0``, and a quarter of an orbit later; in space.
    """

    rate: float
    towards: Vector
    ahead: Vector

    @classmethod
    def of(cls, rate: object, normal: ArrayLike, towards: ArrayLike) -> Self:
        """The orbit about this normal.

        Raises
        ------
        ValueError
            If the rate is not positive, a direction is no unit vector, or the two are not at right
            angles.
        """
        n = finite_float("rate", rate, positive=True, unit="rad/s")
        axis, begin = unit_vector("normal", normal, 3), unit_vector("towards", towards, 3)
        along = float(axis @ begin)
        if abs(along) > 1e-9:
            raise ValueError(
                f"towards = {begin.tolist()}: must be at right angles to normal, their product is "
                f"{along:g}"
            )
        begin = begin - along * axis
        begin /= np.linalg.norm(begin)
        return cls(n, _tuple(begin), _tuple(np.cross(axis, begin)))

    @property
    def normal(self) -> Floats:
        """The normal of the orbit, about which it turns; shape (3,)."""
        return np.cross(self.towards, self.ahead)

    def to_dict(self) -> dict[str, Any]:
        """The orbit as a dict of numbers."""
        return {"rate": self.rate, "towards": list(self.towards), "ahead": list(self.ahead)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The orbit of :meth:`to_dict`."""
        return cls(float(data["rate"]), _tuple(data["towards"]), _tuple(data["ahead"]))


def checked_sink(dissipation: object) -> EnergySink | None:
    """``dissipation`` if it is a sink that drains energy; None if there is none."""
    if dissipation is None:
        return None
    if isinstance(dissipation, EnergySink):
        return dissipation if np.any(dissipation.coefficient) else None
    raise TypeError(f"dissipation = {brief(dissipation)}: must be a rigid.EnergySink")


def checked_rotor(rotor: ArrayLike | None) -> Vector | Floats | None:
    """``rotor`` as a momentum of one body or of each; None if there is none.

    Raises
    ------
    ValueError
        If it is not finite or has another shape.
    """
    if rotor is None:
        return None
    array = shaped("rotor", rotor, 3)
    return _vector(array) if array.any() else None


def checked_drag(drag: ArrayLike | None) -> Vector | Floats | None:
    """``drag`` as coefficients along the axes of one body or of each; None if there is none.

    Raises
    ------
    ValueError
        If a coefficient is negative or not finite, or the shape does not fit.
    """
    if drag is None:
        return None
    array = shaped("drag", drag, nonnegative=True)
    if array.ndim and array.shape[-1] != 3:
        raise ValueError(f"drag: expected shape () or (..., 3), got {array.shape}")
    return _vector(np.broadcast_to(array, (*array.shape[:-1], 3))) if array.any() else None


def drag_words(drag: Vector | Floats) -> str:
    """The quadratic drag in a few words."""
    if isinstance(drag, np.ndarray):
        return "drag of each"
    first, second, third = drag
    if first == second == third:
        return f"drag {first:g}"
    return f"drag ({first:g}, {second:g}, {third:g})"


def rotor_words(rotor: Vector | Floats) -> str:
    """The rotor in a few words."""
    if isinstance(rotor, np.ndarray):
        return "rotor of each"
    return f"rotor ({', '.join(f'{part:g}' for part in rotor)})"


def satellite_rows(
    rotor: Vector | Floats | None,
    dissipation: EnergySink | None,
    drag: Vector | Floats | None,
    orbit: Orbit | None,
) -> Floats | None:
    """The numbers that the core reads, shape (..., 16); None if nothing acts."""
    if rotor is None and dissipation is None and drag is None and orbit is None:
        return None
    none = (0.0, 0.0, 0.0)
    parts = [
        np.asarray(none if rotor is None else rotor),
        np.asarray(none if dissipation is None else dissipation.coefficient),
        np.asarray(none if drag is None else drag),
        np.array(
            (0.0, *none, *none) if orbit is None else (orbit.rate, *orbit.towards, *orbit.ahead)
        ),
    ]
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate(
        [np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1
    )


def _tuple(values: ArrayLike) -> Vector:
    first, second, third = (float(value) for value in np.asarray(values))
    return first, second, third


def _vector(array: Floats) -> Vector | Floats:
    """The vector of one body as a tuple, those of many as an array."""
    return _tuple(array) if array.ndim == 1 else frozen(array)
