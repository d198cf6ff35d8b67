"""The bodies of a call, checked once, as columns of equal length in one unit for the core."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arrays import IDENTITY, AttitudeLike, Floats, attitudes, unit_quaternions, vectors
from .._checks.moments import hold_rods, refuse_rods, without_spin
from .batch import Shape, batch_shape, in_rows, rows_of_each
from .body import rates_of_rods
from .frame import attitudes_in_principal_axes, turned
from .scene import HeavyTop, Scene
from .torque import NO_EXPONENT, forces_of

SLOWEST = 1e-140
"""Least rate (rad/s) whose square, and products of rates, do not underflow."""

HEAVIEST = 1e153
"""Weight over the least moment (1/s²) near which its square overflows, 1e308."""


Range: TypeAlias = tuple[float, float] | tuple[Floats, Floats]
"""First and last of some times and 0 (s), or of the times of each body with shape (n,)."""


def time_ranges(times: Floats) -> Range:
    """First and last of ascending times and 0 (s), or of the times (n, m) of each body."""
    if times.ndim == 1:
        return (min(float(times[0]), 0.0), max(float(times[-1]), 0.0)) if len(times) else (0.0, 0.0)
    if not times.shape[1]:
        return np.zeros(len(times)), np.zeros(len(times))
    return np.minimum(times[:, 0], 0.0), np.maximum(times[:, -1], 0.0)


@dataclass(slots=True, eq=False)
class Bodies:
    """Bodies of one kind with their starts: of a call, of a second run, or of pixels of a map.

    Nothing here is checked again. :func:`bodies_of` checks what a user gives.
    It is not frozen: a frozen object takes twice as long to make.

    Attributes
    ----------
    kind : str
        The :attr:`kind <rigid.model.scene.Scene.kind>` of their scene.
    shape : tuple of int
        The axes of the bodies, ``()`` for a single one; the arrays have them as one axis of n.
    moments, weight : ndarray, shape (n, 3) or (1, 3)
        Principal moments and ``mgl com``; one row may serve all bodies.
    omega : ndarray, shape (n, 3)
        Angular velocities in the body (rad/s). A run keeps them and the attitudes: they are copies.
    attitude : ndarray, shape (n, 4) or (1, 4)
        Unit quaternions; one row may serve all bodies.
    forces : Forces or None
        Torque and damping of each body or of all, None if nothing acts on any.
    may_stop : bool
        Whether a torque or weight may stop them, on which drag acts.
    scale_exponent : ndarray of int, shape (n,) or (1,)
        Moments, weight and forces are counted in units of ``2**scale_exponent``.
    """

    kind: str
    shape: Shape
    moments: Floats
    weight: Floats
    omega: Floats
    attitude: Floats
    forces: _core.Forces | None = None
    may_stop: bool = False
    scale_exponent: NDArray[np.intc] = field(default_factory=lambda: NO_EXPONENT)
    _rates: dict[object, Floats] = field(default_factory=dict, init=False, repr=False)
    _forms: NDArray[np.uint8] | None = field(default=None, init=False, repr=False)

    @classmethod
    def of_scene(
        cls,
        scene: Scene,
        omega: Floats,
        attitude: Floats,
        shape: Shape,
        exponents: NDArray[np.intc] | None = None,
    ) -> Self:
        """Bodies of a scene with these rates and unit quaternions, as they are.

        Without ``exponents`` the largest moment of each is near one.

        Raises
        ------
        ValueError
            If torque or damping overflow in this unit.
        """
        omega, attitude = rows_of_each(omega, shape), in_rows(attitude, shape)
        if exponents is None:
            known = scene.once(_inertia_of_one)
            if known is not None:
                moments, weight, unit, _ = known
                return cls(scene.kind, shape, moments, weight, omega, attitude, None, False, unit)
            exponents = _scale_exponents(scene, shape)
        units = -exponents[:, np.newaxis]
        moments = np.ldexp(in_rows(without_spin(np.asarray(scene.body.moments)), shape), units)
        weight = in_rows(scene.weight, shape)
        if np.count_nonzero(weight):
            with np.errstate(over="ignore"):
                weight = np.ldexp(weight, units)
        further = scene.further_numbers()
        forces = forces_of(scene.torque, scene.damping, shape, exponents, further)
        return cls(
            kind=scene.kind,
            shape=shape,
            moments=moments,
            weight=weight,
            omega=omega,
            attitude=attitude,
            forces=forces,
            may_stop=forces is not None and scene.may_stop,
            scale_exponent=exponents,
        )

    def __len__(self) -> int:
        return len(self.omega)

    def in_axes(self, values: NDArray[Any]) -> Any:
        """Values of the bodies, (n, ...), in the axes of the bodies; of a single body its value."""
        return values.reshape(*self.shape, *values.shape[1:]) if self.shape else values[0]

    def select(self, bodies: NDArray[np.intp]) -> Self:
        """The bodies of these indices; a row that holds for all bodies stays."""
        columns = {
            name: column[bodies] if len(column) > 1 else column
            for name in ("moments", "weight", "attitude", "scale_exponent")
            for column in (getattr(self, name),)
        }
        forces = None if self.forces is None else self.forces.select(bodies)
        if forces is not None and not forces.kinds(len(bodies)).any():
            forces = None
        shape, omega = (len(bodies),), self.omega[bodies]
        chosen = replace(self, **columns, shape=shape, omega=omega, forces=forces)
        chosen._rates.update({key: rates[bodies] for key, rates in self._rates.items()})
        return chosen

    def doubted(self) -> Self:
        """The bodies of a second run: the spline of :meth:`Orbit.table` is another by its doubt."""
        return self if self.forces is None else replace(self, forces=self.forces.doubted())

    def kinds_of_forces(self) -> NDArray[np.uint64]:
        """Which forces act on each body, as bits in the order of the core; 0 if none does."""
        if self.forces is None:
            return np.zeros(len(self), dtype=np.uint64)
        return self.forces.kinds(len(self))

    def under_forces(self) -> NDArray[np.bool_]:
        """Whether torque or damping acts on each body; shape (n,)."""
        act: NDArray[np.bool_] = self.kinds_of_forces() != 0
        return act

    def fastest_rates(self, span: Range, method: str | None = None) -> Floats:
        """Bounds of ``|omega|`` (rad/s), shape (n,); each is computed once.

        Parameters
        ----------
        span : tuple of float, or of ndarray of shape (n,)
            First and last time (s), around 0; the same for all bodies, or for each.
        method : str, optional
            Instead of bounds: the rates that the steps of this method follow. Without torque and
            damping the bounds hold for all times and are these rates.
        """
        spans = None if self.forces is None else _rows_of(span)
        key = None if spans is None else (spans.tobytes(), method)
        if key not in self._rates:
            rates = (
                _core.fastest_rates(self)
                if spans is None
                else _core.fastest_rates(self, spans, method)
            )
            rates.flags.writeable = False
            self._rates[key] = rates
        return self._rates[key]

    def planned_steps(
        self, method: str, span: Range, of: str, step: float | None = None
    ) -> tuple[Floats, Floats]:
        """The longest step of each body (s), and the time in which so long ones are as many.

        On an orbit over whose anomaly the steps are equal the time is not the time of the run.

        Parameters
        ----------
        method : str
        span : tuple of float, or of ndarray of shape (n,)
            First and last time (s).
        of : {"states", "samples", "growth"}
            What the run is for: states, the samples of a map, or the growth of their deviations.
        step : float, optional
            The longest step of all bodies (s), instead of the method's steps. ValueError if
            damping makes it unstable.
        """
        longest, time = _core.planned_steps(self, method, _rows_of(span), of, step).T
        return longest, time

    def gammas(self) -> Floats:
        """The upward verticals in body components; shape (n, 3)."""
        w, x, y, z = np.broadcast_to(self.attitude, (len(self), 4)).T
        first, second = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x)
        return np.stack([first, second, w * w - x * x - y * y + z * z], axis=-1)

    def separatrices(self) -> tuple[Floats, Floats]:
        """Relative distance from the separatrix, and exponent of its saddle (1/s); (n,) each.

        Of tops and pendulums in closed form; 1 and 0 for other bodies.
        """
        if self.forces is not None:
            return np.ones(len(self)), np.zeros(len(self))
        distance, exponent = _core.saddles(self).T
        return distance, exponent

    def note_rates(self, rates: Floats) -> None:
        """Keep the bounds of the rates that a run in closed form has returned."""
        if self.forces is None:
            self._rates.setdefault(None, rates)

    def closed_forms(self) -> NDArray[np.uint8]:
        """The code of the closed form of each body from its start, 0 for none; shape (n,)."""
        if self._forms is None:
            forms = _core.closed_forms(self)
            if self.forces is not None:
                forms[self.under_forces()] = 0
            forms.flags.writeable = False
            self._forms = forms
        return self._forms

    def _swings(self) -> Floats:
        """The rate of the swing of each body, or of all (rad/s)."""
        if not np.count_nonzero(self.weight):
            return np.zeros(1)
        # Rows of weights and moments may differ in number.
        with np.errstate(over="ignore"):
            swings: Floats = np.sqrt(np.abs(self.weight).max(axis=1) / self.moments.min(axis=1))
        return swings

    def check_ranges(self, scene: Scene) -> None:
        """Raise ValueError for a weight that overflows, or rates whose squares underflow.

        The compared rates are the rates of the start and of the swings, in the unit of the moments.
        """
        known = scene.once(_inertia_of_one)
        swing = self._swings() if known is None else known[3]
        fastest = float(swing[0]) if len(swing) == 1 else swing.max(initial=0.0)
        if not fastest**2 < HEAVIEST:
            self._check_weight(scene)
        if len(swing) == 1:
            slow = _core.first_slow(self.omega, fastest, SLOWEST)
        else:
            first, second, third = np.abs(self.omega).T
            rates = np.maximum(np.maximum(np.maximum(first, second), third), swing)
            found = np.flatnonzero((rates > 0.0) & (rates < SLOWEST))
            slow = int(found[0]) if len(found) else None
        if slow is not None:
            rate = max(np.broadcast_to(swing, len(self))[slow], np.abs(self.omega[slow]).max())
            raise ValueError(
                f"omega{self._place(slow)}: the rates of the body are {rate:.3g} rad/s at most; "
                f"they must be zero or reach {SLOWEST:g} rad/s: count the time in another unit"
            )

    def _check_weight(self, scene: Scene) -> None:
        with np.errstate(over="ignore"):
            heavy = ~(np.abs(self.weight).max(axis=1) / self.moments.min(axis=1) < HEAVIEST)
        if not heavy.any():
            return
        body = int(np.argmax(heavy))
        place = self._place(body) if len(heavy) > 1 else ""
        assert isinstance(scene, HeavyTop)
        values = in_rows(np.asarray(scene.mgl)[..., np.newaxis], self.shape)[:, 0]
        leasts = np.ldexp(self.moments.min(axis=1), self.scale_exponent)
        value, least = (np.broadcast_to(each, heavy.shape)[body] for each in (values, leasts))
        raise ValueError(
            f"mgl{place} = {value:g}: must be below {HEAVIEST:g} times the least moment, "
            f"{least:.3g}: count the time in another unit"
        )

    def _place(self, body: int) -> list[int]:
        """The index of a body in their axes."""
        return [int(i) for i in np.unravel_index(body, self.shape or (1,))]


def bodies_of(
    scene: Scene,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    frame: NDArray[np.float64] | None = None,
    times: Shape = (),
    rod: bool = False,
) -> Bodies:
    """The bodies that the arguments of a call describe.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    omega, attitude : array_like
        What a user gives; without an attitude the axes of body and space coincide.
    frame : ndarray, shape (3, 3), optional
        The checked axes of rates and attitude, if they are not the principal axes.
    times : tuple of int
        The leading axes of the times.
    rod : bool
        Whether a rod may be among the bodies: what is asked does not vary its spin.

    Raises
    ------
    ValueError
        If an array is not finite, has the wrong shape, or holds a zero quaternion, if the axes of
        bodies, rates and attitudes do not broadcast, if the rates are so slow that their squares
        underflow, or the weight, torque or damping so large that they overflow in the unit of the
        moments.
    """
    rates, attitude, shape = starts_of(scene, omega, attitude, frame=frame, times=times, rod=rod)
    bodies = Bodies.of_scene(scene, rates, attitude, shape)
    bodies.check_ranges(scene)
    return bodies


def starts_of(
    scene: Scene,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    frame: NDArray[np.float64] | None = None,
    times: Shape = (),
    rod: bool = False,
) -> tuple[Floats, Floats, Shape]:
    """Checked rates and unit quaternions of the principal axes, and the axes of the bodies.

    It takes the arguments of :func:`bodies_of`, and refuses the same but for ranges of rates.
    """
    rates = _core.plain_numbers(omega, 3, kept=True)
    if rates is None:
        rates = vectors("omega", omega)
        if not isinstance(omega, (list, tuple)):
            rates = rates.copy()  # a run keeps it: the caller may write to this memory
        rates.setflags(write=False)
    attitude = attitudes(attitude)
    if frame is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            rates = turned(frame.T, rates)
        if not np.isfinite(rates).all():
            raise ValueError("omega: must be finite along the principal axes of the frame too")
        rates.setflags(write=False)
        attitude = unit_quaternions("attitude", attitudes_in_principal_axes(frame, attitude))
    if attitude is not IDENTITY:
        attitude.setflags(write=False)
    shape = scene.shape
    if shape or times or rates.ndim > 1 or attitude.ndim > 1:
        own = rates.shape[:-1], attitude.shape[:-1]
        shape = batch_shape({"scene": shape, "omega": own[0], "attitude": own[1], "t": times})
    if scene.once(holds_rods):
        moments = np.asarray(scene.body.moments)
        if not rod:
            refuse_rods(moments)
        rates = rates_of_rods("omega", rates, moments, scene.weight, scene.forces)
    return rates, attitude, shape


def lagrange_axes(moments: Floats, weight: Floats) -> NDArray[np.int64]:
    """The symmetry axis 1, 2 or 3 of each Lagrange top, 0 of other bodies, shape (n,).

    The moments about the other two axes are exactly equal, the weight lies exactly on the axis. One
    row of moments or weight may hold for all.
    """
    first, second = np.broadcast_arrays(moments, weight)
    return _core.lagrange_axes(np.ascontiguousarray(first), np.ascontiguousarray(second))


def holds_rods(scene: Scene) -> bool:
    """Whether a body of the scene is a rod, without a moment about its axis."""
    return hold_rods(np.asarray(scene.body.moments))


def _scale_exponents(scene: Scene, shape: Shape) -> NDArray[np.intc]:
    """Exponents of the unit in which the largest moment of each body, or of all, is near one.

    No product with rates leaves the range of doubles, and the unit of moments, torques and energies
    changes no bit of a motion.
    """
    if scene.body.shape:
        first, second, third = in_rows(np.asarray(scene.body.moments), shape).T
        exponents: NDArray[np.intc] = np.frexp(np.maximum(np.maximum(first, second), third))[1]
        return exponents
    return np.array([math.frexp(max(scene.body.moments))[1]], dtype=np.intc)


def _inertia_of_one(
    scene: Scene,
) -> tuple[Floats, Floats, NDArray[np.intc], Floats] | None:
    """Moments, weight, unit and swing of a scene of one body without torque and damping, or None.

    A scene of many bodies or under torque keeps none: they would take memory.
    """
    if scene.shape or scene.forces:
        return None
    exponents = _scale_exponents(scene, ())
    bodies = Bodies.of_scene(scene, np.zeros(3), IDENTITY, (), exponents)
    columns = bodies.moments, bodies.weight, exponents, bodies._swings()
    for column in columns:
        column.flags.writeable = False
    return columns


def _rows_of(span: Range) -> Floats:
    """First and last time in rows: one for all bodies, or one for each."""
    return np.ascontiguousarray(np.atleast_2d(np.transpose(span)), dtype=np.float64)
