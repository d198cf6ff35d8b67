"""Scenes: a body with its weight and the other forces on it.

A new scene is one more class in this file: its facts, the names of its numbers, its weight, and its
entry in :data:`SCENES`. The packages above use this interface and name no class.
The core integrates the scene under the same ``kind``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import brief, finite_float, numbers, one_of, shaped, vector
from .._checks.arrays import Floats, unit_vectors
from .batch import (
    ByValue,
    Index,
    Shape,
    Vector,
    axes_of,
    batch_shape,
    frozen,
    holds,
    index_of_bodies,
    taken,
    vector_of,
)
from .body import Body, check_body, pair_hint, require_one
from .damping import Damping, checked_damping, damping_words, matrices_of
from .forces import FORCES, EnergySink, Force, forces_in_words
from .frame import checked_frame, turned, turned_matrix
from .function import NO_STATES
from .gravity import about_pivot, checked_properties
from .noise import normal
from .orbit import Orbit
from .sampled import RotorTable, Sampled
from .start import Start
from .torque import Torque, checked_torque, forces_of

if TYPE_CHECKING:
    from ..solids.mass_properties import MassProperties


Made = TypeVar("Made")

_ACTING = ("torque", "damping", *FORCES)


class Scene(ByValue, ABC):
    """A body with its weight, applied torque and damping: the interface of all scenes.

    A scene holds many bodies if one of its parts does: ``len(scene)`` is their number, ``scene[i]``
    is the scene of one, and a slice or an array of indices takes some. A part of one body holds for
    all bodies.

    Attributes
    ----------
    kind : str
        Name of the scene in the core, in :data:`SCENES` and in saved files.
    title : str
        The scene in two words; with a hyphen it is the ``kind`` of a map file.
    fields : mapping of str to int
        The scene's own numbers, attributes and keyword arguments of the class, and how many axes
        the numbers of one body have: 1 of a vector.
    directions : tuple of str
        Directions fixed in space that the equations of motion contain, by their name in
        :attr:`rigid.Plan.carried`: ``"gamma"`` is the upward vertical.
    body : Body
    torque : Torque or None
    damping : 3 tuples of 3 floats, or None
    orbit, dissipation, rotor, drag : Orbit, EnergySink, tuple of 3 floats or RotorTable, or None
        The further forces.
    """

    __slots__ = ("_made",)

    kind: ClassVar[str]
    title: ClassVar[str]
    fields: ClassVar[Mapping[str, int]] = {}
    directions: ClassVar[tuple[str, ...]] = ()

    body: Body
    torque: Torque | None
    damping: Damping | None
    orbit: Orbit | None = None
    dissipation: EnergySink | None = None
    rotor: Vector | Floats | RotorTable | None = None
    drag: Vector | Floats | None = None

    _made: dict[Callable[[Any], Any], Any]

    @classmethod
    @abstractmethod
    def example(cls) -> Self:
        """The scene that :func:`rigid.stability_map` uses if it is given the class."""

    @abstractmethod
    def default_start(self) -> Start:
        """The start of a map without a given start."""

    @property
    @abstractmethod
    def weight(self) -> Floats:
        """``mgl com`` (J), zero without weight; shape (3,), or (..., 3) if many bodies differ."""

    def once(self, make: Callable[[Scene], Made]) -> Made:
        """The value of ``make(self)``, which is called once for this scene.

        A scene does not change, but its constructors change it: they do not call this method.
        """
        try:
            made = self._made
        except AttributeError:  # of a new scene, or of one that was copied or unpickled
            object.__setattr__(self, "_made", made := {})
        try:
            value: Made = made[make]
        except KeyError:
            value = made[make] = make(self)
        return value

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one body, ``(n,)`` of n bodies."""
        return self.once(Scene._shape_of_parts)

    def _shape_of_parts(self) -> Shape:
        shapes = {"moments": self.body.shape}
        for name, axes in self.fields.items():
            shapes[name] = axes_of(getattr(self, name), axes)
        if self.torque is not None:
            shapes["torque"] = self.torque.shape
        if self.damping is not None:
            shapes["damping"] = axes_of(self.damping, 2)
        for force, value in self.further():
            shapes[force.name] = force.shape(value)
        return batch_shape(shapes)

    def __len__(self) -> int:
        return holds(self.shape)

    def __iter__(self) -> Iterator[Self]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: Index) -> Self:
        shape = self.shape
        index_of_bodies(shape, index)
        own = {
            name: taken(getattr(self, name), axes, shape, index)
            for name, axes in self.fields.items()
        }
        torque = None if self.torque is None else self.torque.of(shape, index)
        some = type(self)(self.body.of(shape, index), **own, torque=torque)  # type: ignore[call-arg]
        if self.damping is not None:
            # Not through the constructor: one damping of all would be read as one of each body.
            damping = taken(self.damping, 2, shape, index)
            known = matrices_of(damping) if np.any(damping) else None
            object.__setattr__(some, "damping", known)
        for force, value in self.further():
            object.__setattr__(some, force.name, force.of(value, shape, index))
        return some

    def _take(
        self,
        torque: Torque | None,
        damping: ArrayLike | None,
        frame: ArrayLike | None,
        **further: Any,
    ) -> None:
        """Take what acts on the body of a new scene; ValueError if the parts do not broadcast."""
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "torque", checked_torque(torque))
        for name, given in further.items():
            set_field(self, name, None if given is None else FORCES[name].checked(given))
        set_field(self, "damping", None)
        if damping is not None:
            set_field(self, "damping", checked_damping(damping, self._shape_of_parts()))
        self._shape_of_parts()
        if frame is not None:
            self._turn_into_principal_axes(frame)

    @property
    def forces(self) -> tuple[str, ...]:
        """The names of the forces that act on any body, as in :attr:`rigid.Method.forces`."""
        return self.once(Scene._acting_forces)

    def _acting_forces(self) -> tuple[str, ...]:
        names = [name for name in ("torque", "damping") if getattr(self, name) is not None]
        if self.torque is not None and self.torque.function is not None:
            names.append("function")
        return (*names, *(force.name for force, _ in self.further()))

    def further(self) -> list[tuple[Force[Any], Any]]:
        """The further forces that act, and their values."""
        values = [(force, getattr(self, name)) for name, force in FORCES.items()]
        return [(force, value) for force, value in values if value is not None]

    def momentum_of_rotor(self, t: ArrayLike) -> Floats:
        """The momentum of the rotor (kg m²/s) at times, shape (..., m, 3), m perhaps 1."""
        if isinstance(self.rotor, RotorTable):
            return self.rotor.at(t)
        return np.asarray(np.zeros(3) if self.rotor is None else self.rotor)[..., np.newaxis, :]

    @property
    def tables(self) -> list[tuple[str, Floats]]:
        """The forces that follow a table over time, by name, and the times of their tables."""
        found = [(one.name, value.t) for one, value in self.further() if isinstance(value, Sampled)]
        if self.torque is not None and self.torque.times:
            found.insert(0, ("torque", np.array(self.torque.times)))
        return found

    @property
    def known_until(self) -> float:
        """The time (s) at which the first table of a force ends; infinite without a table."""
        return min((float(times[-1]) for _, times in self.tables), default=np.inf)

    @property
    def bounds_rates(self) -> bool:
        """Whether a bound of the rates is known; under a callback only if its bound is given."""
        function = None if self.torque is None else self.torque.function
        return function is None or function.fastest is not None

    @property
    def may_stop(self) -> bool:
        """Whether torque or weight may stop a body whose force has a corner at rest."""
        has_corner = any(force.has_corner for force, _ in self.further())
        return has_corner and (self.torque is not None or bool(np.any(self.weight)))

    @property
    def rates_need_attitude(self) -> bool:
        """Whether the rates depend on the attitude: by the weight or by a torque in space."""
        in_space = self.torque is not None and self.torque.acts_in_space
        by_force = any(force.in_space for force, _ in self.further())
        return bool(self.directions) or in_space or by_force

    def further_numbers(self) -> dict[str, Any]:
        """The numbers of the further forces by their names, one row of each body, or a table."""
        return {force.name: force.numbers(value) for force, value in self.further()}

    def acting(self) -> _core.Forces | None:
        """The forces on its bodies as the core reads them."""
        further = self.further_numbers()
        return forces_of(self.torque, self.damping, self.shape, further=further)

    def started(self, states: ArrayLike) -> Self:
        """The scene whose function begins at these states, shape (k,) or (..., k).

        Raises
        ------
        ValueError
            If the function has none, or not as many, or the axes of the bodies do not broadcast.
        """
        if self.torque is None:
            raise ValueError(NO_STATES)
        started = copy(self)
        object.__setattr__(started, "torque", self.torque.started(states))
        started._shape_of_parts()
        return started

    @property
    def states(self) -> int:
        """How many states the function of a torque has for each body."""
        return 0 if self.torque is None else self.torque.states

    def _turn_into_principal_axes(self, frame: ArrayLike) -> None:
        """Take the vectors of the scene, just made, from the axes of a drawing."""
        back = checked_frame(frame).T
        set_field = object.__setattr__  # the dataclass is frozen
        for name, axes in self.fields.items():
            if axes:
                value = getattr(self, name)
                set_field(self, name, _unit(name, turned(back, np.asarray(value))))
        if self.torque is not None:
            set_field(self, "torque", self.torque.turned(back))
        if self.damping is not None:
            given = np.asarray(self.damping)
            alike = given == given[..., :1, :1] * np.eye(3)
            if not alike.all():  # the same in all directions stays exactly so
                set_field(self, "damping", matrices_of(turned_matrix(back, given)))
        for force, value in self.further():
            set_field(self, force.name, force.turned(value, back))

    def to_dict(self) -> dict[str, Any]:
        """The scene as a dict of numbers."""
        data: dict[str, Any] = {"kind": self.kind, "body": self.body.to_dict()}
        for name in self.fields:
            data[name] = np.asarray(getattr(self, name)).tolist()
        if self.torque is not None:
            data["torque"] = self.torque.to_dict()
        if self.damping is not None:
            damping = np.asarray(self.damping)
            if damping.ndim == 2:
                # Not read as one damping of each body when it is read back.
                damping = damping.reshape(*(1,) * len(self.shape), 3, 3)
            data["damping"] = damping.tolist()
        for force, value in self.further():
            data[force.name] = force.to_data(value)
        return data

    def __repr__(self) -> str:
        names = ["body", *self.fields]
        names += [name for name in _ACTING if getattr(self, name) is not None]
        parts = ((name, getattr(self, name)) for name in names)
        values = (
            f"{name} of shape {part.shape}" if isinstance(part, np.ndarray) else f"{name}={part!r}"
            for name, part in parts
        )
        return f"{type(self).__name__}({', '.join(values)})"

    def words(self, varied: Container[str] = ()) -> str:
        """The scene in words; ``varied`` names the numbers that the axes of a map set."""
        return self._in_words(varied) if varied else self.once(Scene._in_words)

    def _in_words(self, varied: Container[str] = ()) -> str:
        parts = [self.title, _body_words(self.body, varied)]
        if self.shape:
            count = self.shape if len(self.shape) > 1 else len(self)
            parts[0] = f"{self.title} ({count} bodies)"
        for name, axes in self.fields.items():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                parts.append(f"{name} of each")
            elif name in varied:
                parts.append(f"{name} varied")
            elif not axes:
                parts.append(f"{name} {_numbers([(name, float(value))], varied)}")
            else:
                parts.append(f"{name} ({', '.join(f'{part:g}' for part in value)})")
        if self.torque is not None:
            parts.append(self.torque.words())
        if self.damping is not None:
            parts.append(damping_words(self.damping))
        parts += [force.words(value, varied) for force, value in self.further()]
        return ", ".join(parts)


def _body_words(body: Body, varied: Container[str]) -> str:
    if body.shape:
        return "moments of each"
    moments = list(zip(("I1", "I2", "I3"), body.moments, strict=True))
    if body.sides is None or any(name in varied for name, _ in moments):
        physical = "" if body.physical else ", physical=False"
        return f"moments ({_numbers(moments, varied)}){physical}"
    sides = _numbers(zip("abc", body.sides, strict=True), varied)
    mass = _numbers([("mass", float(body.mass or 0.0))], varied)
    return f"box with sides ({sides}) m and mass {mass} kg"


def _numbers(values: Iterable[tuple[str, float]], varied: Container[str]) -> str:
    """Numbers in words, with so many digits that different ones differ."""
    pairs = list(values)
    short = len({f"{value:g}" for _, value in pairs}) == len({value for _, value in pairs})
    return ", ".join(
        "varied" if name in varied else f"{value:g}" if short else repr(value)
        for name, value in pairs
    )


def _checked_com(value: ArrayLike) -> Vector | Floats:
    try:
        return _unit("com", numbers("com", value))
    except ValueError as error:
        hint = "; HeavyTop.from_mass takes com in m" if "unit vector" in str(error) else ""
        raise ValueError(f"{error}{hint}") from None


def _unit(name: str, vectors: Floats) -> Vector | Floats:
    """Unit vectors in the form of a field: a tuple, or a read-only array of many."""
    return vector_of(unit_vectors(name, vectors))


@dataclass(frozen=True, slots=True, init=False, repr=False, eq=False)
class FreeBody(Scene):
    """A body without weight that turns about its centre of mass.

    Euler's equations ``I omega' = (I omega + h) × omega + torque - D omega - |omega| C omega`` in
    the principal axes of the body, ``h`` being the momentum of a rotor.

    Parameters
    ----------
    body : Body
        One body or many.
    torque : Torque, optional
        Applied torque: :meth:`Torque.body`, :meth:`Torque.space`,
        :meth:`Torque.call`, or a sum of them.
    damping : float or array_like, shape (3,) or (3, 3), optional
        Linear damping ``D`` (N m s): one coefficient, one for each body axis, or a symmetric
        positive semi-definite matrix in body axes. Use ``(0, 0, c)`` to damp only the spin. Axes
        before these count the bodies: ``(n,)``, ``(n, 3)``, ``(n, 3, 3)``. A shape that can be read
        in two ways, such as ``(3,)`` for three bodies, is refused.
    orbit : Orbit, optional
        The orbit about a planet, whose gravity gradient acts.
    dissipation : EnergySink, optional
        Internal dissipation, which drains energy and keeps the angular momentum in space.
    rotor : array_like, shape (3,) or (..., 3), or RotorTable, optional
        Angular momentum ``h`` (kg m²/s) of a rotor relative to the body, constant in the body, or a
        table over time: a gyrostat (Zhukovsky 1885, Volterra 1899). The whole momentum is
        ``I omega + h``. Energies are energies of ``omega``, without the spin energy of the
        rotor.
    drag : float or array_like, shape (3,) or (..., 3), optional
        Quadratic drag: the coefficients ``C`` (N m s²) of the torque ``-|omega| C omega``, one for
        each body axis or one for all.
    frame : array_like, shape (3, 3), optional
        The axes in which torques in the body, damping and rotor are given, if they are not the
        principal axes: ``axes`` as :meth:`Body.from_tensor` returns them. The scene keeps
        principal components, and rates and attitudes have the frame of the call.

    Attributes
    ----------
    damping : 3 tuples of 3 floats, ndarray of shape (..., 3, 3), or None
        The matrix, or the matrices of many bodies.

    Raises
    ------
    ValueError
        If the damping is not symmetric, not finite, or would add energy, if the rotor is not
        finite, or a drag is negative or not finite; if the frame is no rotation matrix, or there
        are no forces for it, or an energy sink or drag differs along the axes, with a frame: it
        has no components off its diagonal.

    Examples
    --------
    >>> import rigid
    >>> rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))).body.moments
    (1.0, 2.0, 3.0)
    >>> wheel = rigid.Body((1.0, 1.0, 1.8))
    >>> driven = rigid.FreeBody(wheel, torque=rigid.Torque.body((0, 0, 0.3)), damping=(0, 0, 0.1))
    >>> run = rigid.simulate(driven, [0.0, 0.0, 0.0], t=[200.0])  # N / c, to e^(-11)
    >>> round(float(run.omega[-1, 2]), 3)
    3.0
    >>> bodies = rigid.FreeBody(rigid.Body([[1.0, 2.0, 3.0], [1.0, 1.0, 1.8]]), damping=[0.1, 0.0])
    >>> len(bodies), bodies[1] == rigid.FreeBody(wheel)
    (2, True)
    """

    kind: ClassVar[str] = "free"
    title: ClassVar[str] = "free body"

    body: Body
    torque: Torque | None
    damping: Damping | None
    orbit: Orbit | None
    dissipation: EnergySink | None
    rotor: Vector | Floats | RotorTable | None
    drag: Vector | Floats | None

    def __init__(
        self,
        body: Body,
        *,
        torque: Torque | None = None,
        damping: ArrayLike | None = None,
        orbit: Orbit | None = None,
        dissipation: EnergySink | None = None,
        rotor: ArrayLike | RotorTable | None = None,
        drag: ArrayLike | None = None,
        frame: ArrayLike | None = None,
    ) -> None:
        object.__setattr__(self, "body", check_body(body))  # the dataclass is frozen
        further = {"orbit": orbit, "dissipation": dissipation, "rotor": rotor, "drag": drag}
        self._take(torque, damping, frame, **further)
        if frame is not None and not self.forces:
            raise ValueError(
                "frame: turns the forces of a scene, and there are none; rates and attitudes "
                "have the frame of the call, as in rigid.simulate(..., frame=axes)"
            )

    @classmethod
    def example(cls) -> Self:
        """A scene to try: a body with the moments (1, 1.5, 2) kg m².

        Returns
        -------
        FreeBody

        Examples
        --------
        >>> import rigid
        >>> rigid.FreeBody.example().body.moments
        (1.0, 1.5, 2.0)
        """
        return cls(Body((1.0, 1.5, 2.0)))

    def default_start(self) -> Start:
        """Rotation about the middle axis at 1 rad/s, with normal noise of 1e-3 rad/s.

        Returns
        -------
        Start

        Examples
        --------
        >>> import rigid
        >>> rigid.FreeBody.example().default_start().spin
        1.0
        """
        middle = int(np.argsort(self.body.moments, kind="stable")[1]) + 1
        return Start(spin=1.0, axis=middle, noise=normal(1e-3))

    @property
    def weight(self) -> Floats:
        """Zero weight; shape (3,)."""
        return np.zeros(3)


@dataclass(frozen=True, slots=True, init=False, repr=False, eq=False)
class HeavyTop(Scene):
    """A body that turns about a fixed point under its weight.

    ``I omega' = (I omega) × omega - mgl com × gamma + torque - D omega`` and
    ``gamma' = gamma × omega`` in the principal axes at the fixed point; ``gamma`` is the upward
    vertical in body components.

    Parameters
    ----------
    body : Body
        Moments about the fixed point, not the centre of mass: :meth:`from_mass` and
        :meth:`from_properties` compute them.
    mgl : float or array_like, shape (...)
        Mass times gravity times the distance from the fixed point to the centre of mass (J), >= 0.
    com : array_like, shape (3,) or (..., 3), optional
        Unit vector from the fixed point to the centre of mass in the body. Default ``(0, 0, 1)``.
    torque, damping, drag, frame : optional
        As in :class:`FreeBody`; ``com`` too is given in the frame.

    Raises
    ------
    ValueError
        If ``mgl`` is negative or not finite, ``com`` is not a unit vector, or the damping is not
        symmetric, not finite, or would add energy; if the body is known by its moments about its
        centre of mass, as after :meth:`Body.cone`, and ``mgl`` is not zero.

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    >>> top.com
    (0.0, 0.0, 1.0)
    >>> lighter = rigid.HeavyTop(top.body, mgl=[1.0, 0.5, 0.25])  # three tops
    >>> len(lighter), lighter[2].mgl
    (3, 0.25)
    """

    kind: ClassVar[str] = "top"
    title: ClassVar[str] = "heavy top"
    fields: ClassVar[Mapping[str, int]] = {"mgl": 0, "com": 1}
    directions: ClassVar[tuple[str, ...]] = ("gamma",)

    body: Body
    mgl: float | Floats
    com: tuple[float, float, float] | Floats
    torque: Torque | None
    damping: Damping | None
    drag: Vector | Floats | None

    def __init__(
        self,
        body: Body,
        *,
        mgl: ArrayLike,
        com: ArrayLike = (0.0, 0.0, 1.0),
        torque: Torque | None = None,
        damping: ArrayLike | None = None,
        drag: ArrayLike | None = None,
        frame: ArrayLike | None = None,
    ) -> None:
        check_body(body)
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "body", body)
        set_field(self, "mgl", _checked_mgl(mgl))
        if body.about == "centre" and np.any(self.mgl):
            raise ValueError(
                f"body = {body!r}: a top needs the moments about its fixed point, and these are "
                "about the centre of mass; use rigid.HeavyTop.from_mass(body, com=(x, y, z)), "
                "with com from the fixed point to the centre of mass in m"
            )
        set_field(self, "com", _checked_com(com))
        self._take(torque, damping, frame, drag=drag)

    @classmethod
    def from_mass(
        cls,
        body: Body,
        *,
        com: ArrayLike,
        mass: float | None = None,
        g: float = 9.81,
    ) -> tuple[Self, Floats]:
        """The heavy top of a body fixed at a point other than its centre of mass, and its axes.

        Parameters
        ----------
        body : Body
            One body, with its moments about its centre of mass.
        com : array_like, shape (3,)
            Centre of mass, from the fixed point, along the axes of ``body`` (m).
        mass : float, optional
            Mass (kg); by default the mass of the body, if it is known.
        g : float
            Acceleration of gravity (m/s²).

        Returns
        -------
        top : HeavyTop
            With the moments about the fixed point (Steiner), ``mgl`` and ``com``.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 of the top along the axes of ``body``; the identity if the
            fixed point lies on a principal axis or if the products of inertia vanish otherwise.
            Moments are ascending if the axes change.

        Raises
        ------
        ValueError
            If there is no mass, a mass other than the known mass of the body, or moments that
            already refer to another point.

        Examples
        --------
        >>> import rigid
        >>> cone = rigid.Body.cone(0.05, 0.1, mass=0.2)
        >>> top, axes = rigid.HeavyTop.from_mass(cone, com=(0, 0, 0.075))
        >>> round(top.mgl, 5), round(rigid.exact.sleeping_spin(top))
        (0.14715, 183)
        """
        check_body(body)
        require_one(body)
        if body.about == "point":
            raise ValueError(
                f"body = {body!r}: must have the moments about its centre of mass, and has "
                "moments about another point"
            )
        if mass is None:
            if body.mass is None:
                raise ValueError("mass: is needed, because the body has none; give mass=...")
            mass = float(body.mass)
        mass = finite_float("mass", mass, positive=True)
        if body.mass is not None and not np.isclose(mass, body.mass, rtol=1e-12, atol=0.0):
            raise ValueError(
                f"mass = {mass:g}: must be {body.mass:g}, the mass of the body; omit it here"
            )
        moments, axes, mgl, direction = about_pivot(np.diag(body.moments), mass, com, g)
        body = Body(moments, mass=mass, physical=body.physical)._marked("point")
        return cls(body, mgl=mgl, com=direction), axes

    @classmethod
    def from_properties(
        cls,
        properties: MassProperties,
        *,
        pivot: ArrayLike,
        g: float = 9.81,
    ) -> tuple[Self, Floats]:
        """The heavy top of a body with these mass properties, fixed at a pivot, and its axes.

        Parameters
        ----------
        properties : MassProperties
            Mass properties of one body, as :mod:`rigid.solids` and :mod:`rigid.meshes` give them.
        pivot : array_like, shape (3,)
            The fixed point (m), in the coordinates of the centre of mass.
        g : float
            Acceleration of gravity (m/s²).

        Returns
        -------
        top : HeavyTop
            With the moments about the pivot, ``mgl`` and ``com``.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the coordinates of ``properties``; the identity if the
            tensor about the pivot is diagonal, else moments are ascending.

        Raises
        ------
        ValueError
            As for :meth:`from_mass`.

        Examples
        --------
        >>> import rigid
        >>> solid = rigid.solids.cone(0.05, 0.1, mass=0.2)
        >>> top, axes = rigid.HeavyTop.from_properties(solid, pivot=(0, 0, 0))
        >>> round(rigid.exact.sleeping_spin(top))
        183
        """
        tensor, mass, centre = checked_properties(properties)
        com = centre - vector("pivot", pivot, 3)
        moments, axes, mgl, direction = about_pivot(tensor, mass, com, g)
        return cls(Body(moments, mass=mass)._marked("point"), mgl=mgl, com=direction), axes

    @classmethod
    def example(cls) -> Self:
        """A scene to try: a symmetric top with the moments (1, 1, 0.5) kg m² and mgl = 1 J.

        Returns
        -------
        HeavyTop

        Examples
        --------
        >>> import rigid
        >>> rigid.HeavyTop.example().mgl
        1.0
        """
        return cls(Body((1.0, 1.0, 0.5)), mgl=1.0)

    def default_start(self) -> Start:
        """Upright with a spin of 5 rad/s, with normal noise of the attitude of 1e-3 rad.

        Returns
        -------
        Start

        Examples
        --------
        >>> import rigid
        >>> rigid.HeavyTop.example().default_start().spin
        5.0
        """
        return Start(spin=5.0, attitude_noise=normal(1e-3))

    @property
    def weight(self) -> Floats:
        """Weight ``mgl com`` (J), shape (3,), or (..., 3) if many tops differ."""
        weight: Floats = np.asarray(self.mgl)[..., np.newaxis] * np.array(self.com)
        return weight


def _checked_mgl(value: ArrayLike) -> float | Floats:
    if not np.ndim(value):
        return finite_float("mgl", value, nonnegative=True)
    return frozen(shaped("mgl", value, nonnegative=True))


SCENES: Mapping[str, type[Scene]] = {scene.kind: scene for scene in (FreeBody, HeavyTop)}
"""All scenes by their kind."""


def check_scene(scene: object, *, many: bool = False) -> Scene:
    """``scene`` if it is one, the free body of a body; of many only where ``many`` allows it."""
    if isinstance(scene, Body):
        scene = FreeBody(scene)
    if isinstance(scene, Scene):
        if not many:
            require_one(scene)
        return scene
    known = " or ".join(f"rigid.{known.__name__}" for known in SCENES.values())
    raise TypeError(
        f"scene = {brief(scene)}: must be a {known}, or a rigid.Body without weight"
        f"{pair_hint(scene)}"
    )


def check_heavy_top(scene: object, *, many: bool = False) -> HeavyTop:
    """``scene`` if it is a heavy top; of many tops only where ``many`` allows it."""
    if isinstance(scene, HeavyTop):
        if not many:
            require_one(scene)
        return scene
    raise TypeError(f"scene = {brief(scene)}: must be a rigid.HeavyTop{pair_hint(scene)}")


def require_unforced(scene: Scene, what: str) -> None:
    """Raise ValueError under torque, damping or another force: ``what`` holds without them."""
    if scene.forces:
        raise ValueError(
            f"scene = {scene.words()}: {what} needs a scene without "
            f"{forces_in_words(scene.forces)}; rigid.simulate integrates the motion"
        )


def scene_from_dict(data: Mapping[str, Any]) -> Scene:
    """The scene of :meth:`Scene.to_dict`."""
    scene = SCENES[one_of("kind", data.get("kind"), SCENES)]
    body = Body.from_dict(data["body"])
    torque = None if data.get("torque") is None else Torque.from_dict(data["torque"])
    own = {name: data[name] for name in scene.fields}
    own.update(
        {
            name: force.of_data(data[name])
            for name, force in FORCES.items()
            if data.get(name) is not None
        }
    )
    return scene(body, **own, torque=torque, damping=data.get("damping"))  # type: ignore[call-arg]
