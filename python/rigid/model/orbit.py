"""The orbit of a body about a planet, which the rotation of the body does not change."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import finite_float, first_place, numbers, of_shape, require, shaped
from .._checks.arrays import UNIT, AttitudeLike, Floats, attitudes, unit_vectors, vectors
from ..rotations import matrix_to_quaternion
from ..rotations.apply import to_body
from ..rotations.quaternions import product_of_checked
from .batch import ByValue, Shape, Vector, batch_shape, frozen, vector_of
from .sampled import Sampled, reached, table_times

MOST_ECCENTRIC = 0.95
"""Largest eccentricity of an ellipse."""

HYPERBOLA = 1.05, 1e6
"""Least and largest eccentricity of a hyperbola."""

_LARGEST_ANOMALY = 1e3
"""Largest anomaly (rad) of an ellipse; the rounding of a larger one exceeds the error of steps."""

_LARGEST_OF_HYPERBOLA = 1e6
"""Largest anomaly of a hyperbola: about the distance in semi-major axes.

A rounding of the place there moves the passage by as many roundings.
"""

_LARGEST_ANGLE = 1e15
"""Largest angle (rad); the place on the orbit is lost in the rounding of a larger one."""

_ROUNDED = 4.0 * np.finfo(np.float64).eps
"""Largest product of two unit vectors that count as perpendicular."""


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class Orbit(ByValue):
    """A Keplerian orbit about a point mass, or a flyby, whose gravity gradient turns the body.

    The torque is ``3 n² (a/r)³ o × I o``, with the mean motion ``n``, the semi-major axis ``a``,
    the distance ``r``, and the direction ``o`` from the planet to the body (Hughes, *Spacecraft
    Attitude Dynamics*, 1986, § 8.1). The orbit is given: the rotation does not act on it. The
    torque omits terms of the size of the body over ``r``, and the oblateness of the planet. A large
    moon close to its planet changes its orbit and its libration (Agrusa et al., Icarus 370 (2021)
    114624, § 5): take a code of the full two-body problem for one.

    Parameters
    ----------
    rate : float or array_like, shape (...)
        Mean motion ``n`` (rad/s), positive: 2π over the period of an ellipse, ``sqrt(μ/|a|³)`` of
        both. :meth:`flyby` computes it from a speed and a distance.
    eccentricity : float or array_like, shape (...)
        Of an ellipse from 0, a circle, to 0.95; of a hyperbola from 1.05 to 10⁶. A parabola, 1, is
        no orbit of this class.
    anomaly : float or array_like, shape (...)
        Mean anomaly at ``t = 0`` (rad): 0 at the periapsis, negative before it. On a hyperbola it
        is ``e sinh H - H``, which grows by ``n`` a second, too.
    normal : array_like, shape (3,) or (..., 3)
        Unit vector about which the body goes around, in space.
    periapsis : array_like, shape (3,) or (..., 3)
        Unit vector from the planet to the periapsis, in space, at right angles to ``normal``. On a
        circle it is where the body is at the anomaly 0. Of the elements Ω, i, ω (rad), ``normal``
        and ``periapsis`` are columns 3 and 1 of ``rigid.rotations.euler_to_matrix([Ω, i, ω])``.
    true_anomaly : float or array_like, shape (...), optional
        Angle from the periapsis at ``t = 0`` (rad), instead of ``anomaly``. On a hyperbola it is
        within the asymptotes, ``cos f > -1/e``.

    Leading axes give each body its orbit.

    Attributes
    ----------
    rate, eccentricity, anomaly : float, or ndarray of shape (...)
    normal, periapsis : tuple of 3 floats, or ndarray of shape (..., 3)

    Raises
    ------
    ValueError
        If the rate is not positive; if the eccentricity is none of an ellipse or a hyperbola; if a
        direction is no unit vector, or the two are not perpendicular; if an anomaly is above
        1000 rad, or 10⁶ on a hyperbola, or beyond an asymptote, or both anomalies are given; if the
        shapes do not broadcast.

    References
    ----------
    C. D. Murray, S. F. Dermott, *Solar System Dynamics*, 1999, § 2.4; R. H. Battin, *An
    Introduction to the Mathematics and Methods of Astrodynamics*, 1999, § 4.4 (the hyperbola).

    Examples
    --------
    A satellite on a circular orbit, its long axis near the vertical, swings with ``n sqrt(1.5)``:

    >>> import numpy as np, rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.0)), orbit=rigid.Orbit(1.0))
    >>> period = 2.0 * np.pi / np.sqrt(1.5)
    >>> run = rigid.simulate(scene, [0.0, 0.0, 1.001], t=[0.0, period], accuracy=1e-9)
    >>> [round(rate, 6) for rate in run.omega[-1].tolist()]
    [0.0, 0.0, 1.001]

    An orbit of the Earth by its semi-major axis (m) and its elements:

    >>> axes = rigid.rotations.euler_to_matrix(np.radians([20.0, 97.4, 0.0]))  # Ω, i, ω
    >>> n = np.sqrt(3.986004e14 / 6.878e6**3)
    >>> orbit = rigid.Orbit(n, eccentricity=0.001, normal=axes[:, 2], periapsis=axes[:, 0])
    >>> round(float(orbit.period) / 60.0, 1)  # min
    94.6
    """

    rate: float | Floats
    eccentricity: float | Floats
    anomaly: float | Floats
    normal: Vector | Floats
    periapsis: Vector | Floats

    def __init__(
        self,
        rate: ArrayLike,
        eccentricity: ArrayLike = 0.0,
        anomaly: ArrayLike | None = None,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        periapsis: ArrayLike = (1.0, 0.0, 0.0),
        *,
        true_anomaly: ArrayLike | None = None,
    ) -> None:
        rates = shaped("rate", rate, positive=True, unit="rad/s")
        e = shaped("eccentricity", eccentricity, nonnegative=True)
        least, largest = HYPERBOLA
        outside = (e > MOST_ECCENTRIC) & (e < least) | (e > largest)
        if np.any(outside):
            index, place = first_place(outside)
            raise ValueError(
                f"eccentricity{place} = {e[index]:g}: must be at most {MOST_ECCENTRIC} (an "
                f"ellipse), or from {least} to {largest:g} (a hyperbola); near a parabola, 1, the "
                "anomaly does not tell the place well enough"
            )
        mean = shaped("anomaly", 0.0 if anomaly is None else anomaly, unit="rad")
        if true_anomaly is not None:
            if anomaly is not None:
                raise ValueError("anomaly, true_anomaly: give one of them")
            mean = _mean_anomaly(shaped("true_anomaly", true_anomaly, unit="rad"), e)
        axis, begin = _plane(normal, periapsis, "periapsis")
        of_each, most = np.broadcast_arrays(
            mean, np.where(e > 1.0, _LARGEST_OF_HYPERBOLA, _LARGEST_ANOMALY)
        )
        if np.any(np.abs(of_each) > most):
            index, place = first_place(np.abs(of_each) > most)
            todo = "leave out whole revolutions of 2π"
            if most[index] == _LARGEST_OF_HYPERBOLA:
                todo = "begin nearer to the periapsis"
            raise ValueError(
                f"anomaly{place} = {of_each[index]:g}: must be within {most[index]:g} rad; {todo}"
            )
        set_field = object.__setattr__  # the dataclass is frozen
        for name, array in (("rate", rates), ("eccentricity", e), ("anomaly", mean)):
            set_field(self, name, frozen(array) if array.ndim else float(array))
        for name, array in (("normal", axis), ("periapsis", begin)):
            set_field(self, name, vector_of(array))
        # Raises for shapes that do not broadcast.
        self.shape  # noqa: B018

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one orbit, ``(n,)`` of one for each of n bodies."""
        shapes = {name: np.shape(getattr(self, name)) for name in self.__slots__}
        axes = {name: shapes[name][:-1] for name in ("normal", "periapsis")}
        return batch_shape({**shapes, **axes})

    @property
    def gm(self) -> float | Floats:
        """Gravitational parameter over the cube of the unit of :meth:`position` (1/s²)."""
        return self.rate * self.rate

    @property
    def period(self) -> float | Floats:
        """Time of a revolution (s), shape (...); infinite on a hyperbola."""
        of_ellipse = 2.0 * np.pi / self.rate
        return np.where(np.greater(self.eccentricity, 1.0), np.inf, of_ellipse)[()]

    @classmethod
    def flyby(
        cls,
        gm: ArrayLike,
        periapsis: ArrayLike,
        speed: ArrayLike,
        time: ArrayLike = 0.0,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        towards: ArrayLike = (1.0, 0.0, 0.0),
    ) -> Self:
        """The hyperbola of a body that passes a planet once.

        The semi-major axis is ``a = gm / speed²``, the eccentricity ``1 + periapsis / a`` and the
        mean motion ``speed³ / gm`` (Battin 1999, § 4.4). Lengths and times are in any units, if
        they are the same everywhere.

        Parameters
        ----------
        gm : float or array_like, shape (...)
            Gravitational parameter of the planet (m³/s²).
        periapsis : float or array_like, shape (...)
            Least distance from the centre of the planet (m).
        speed : float or array_like, shape (...)
            Speed at infinity (m/s).
        time : float or array_like, shape (...)
            Time of the passage through the periapsis (s).
        normal, towards : array_like, shape (3,) or (..., 3)
            Unit vectors in space at right angles: about which the body passes, and from the planet
            to the periapsis.

        Returns
        -------
        Orbit

        Raises
        ------
        ValueError
            If ``gm``, ``periapsis`` or ``speed`` is not positive, or they give no hyperbola of this
            class, as in different units; or as for :class:`Orbit`.

        Examples
        --------
        Apophis passes the Earth on 13 April 2029, with 5.84 km/s at infinity, at 38 011 km:

        >>> import rigid
        >>> orbit = rigid.Orbit.flyby(gm=398600.4, periapsis=38011.0, speed=5.8414, time=86400.0)
        >>> round(orbit.eccentricity, 3)
        4.254
        """
        mu = shaped("gm", gm, positive=True, unit="m³/s²")
        nearest = shaped("periapsis", periapsis, positive=True, unit="m")
        fast = shaped("speed", speed, positive=True, unit="m/s")
        passage = shaped("time", time, unit="s")
        rate, plane = fast**3 / mu, _plane(normal, towards, "towards")
        e, (least, largest) = 1.0 + nearest * fast**2 / mu, HYPERBOLA
        require(
            "eccentricity",
            e,
            (e >= least) & (e <= largest),
            f"1 + periapsis speed² / gm must lie in [{least}, {largest:g}]; are the lengths and "
            "times of gm, periapsis and speed in the same units?",
        )
        return cls(rate, e, -rate * passage, *plane)

    @staticmethod
    def table(t: ArrayLike, positions: ArrayLike, gm: float) -> OrbitTable:
        """The trajectory of an ephemeris: of a flyby with more than two bodies, say.

        Between the times ``sqrt(3 gm/r³) o`` is a cubic spline, where ``r o`` is the position. The
        run that tells the errors of a motion takes another spline, which differs from it by a third
        of its distance from the spline of every second sample: so the stated errors, of states, of
        times of events and of growth, contain the error of the spline.

        Parameters
        ----------
        t : array_like, shape (m,)
            Times (s), 9 or more, each after the one before.
        positions : array_like, shape (m, 3)
            Vectors from the planet to the body in space (m).
        gm : float
            Gravitational parameter of the planet (m³/s²).

        Returns
        -------
        OrbitTable

        Raises
        ------
        ValueError
            If there are fewer than 9 times, or two are equal; if a number is not finite or ``gm``
            not positive; if a position is zero, or there is not one for each time; if neighbouring
            intervals of time differ by more than a factor of two, or the direction from the planet
            turns by more than 45° within one.

        Examples
        --------
        A body on a circle of radius 1, whose direction is told every twentieth of a revolution:

        >>> import numpy as np, rigid
        >>> t = np.linspace(0.0, 2.0 * np.pi, 21)
        >>> circle = np.stack([np.cos(t), np.sin(t), np.zeros(21)], axis=1)
        >>> orbit = rigid.Orbit.table(t, circle, gm=1.0)
        >>> orbit.position(0.3).round(4).tolist(), np.round([np.cos(0.3), np.sin(0.3)], 4).tolist()
        ([0.9553, 0.2955, 0.0], [0.9553, 0.2955])
        """
        return OrbitTable(t, positions, gm)

    def position(self, t: ArrayLike) -> Floats:
        """Vector from the planet to the body in space, divided by the semi-major axis.

        Parameters
        ----------
        t : array_like, shape (m,), () or (..., m)
            Times (s), of all orbits or of each.

        Returns
        -------
        ndarray, shape (..., m, 3) or (..., 3)

        Raises
        ------
        ValueError
            If a time is not finite, the shapes do not broadcast, or the orbit turns so far that its
            place is lost to rounding.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> orbit = rigid.Orbit(2.0 * np.pi, eccentricity=0.5)
        >>> orbit.position([0.0, 0.5]).round(12).tolist()
        [[0.5, 0.0, 0.0], [-1.5, 0.0, 0.0]]
        """
        times = np.atleast_1d(shaped("t", t))
        numbers = self.numbers[..., np.newaxis, :]
        bodies = np.broadcast_shapes(self.shape, times.shape[:-1])
        each = np.broadcast_to(numbers, (*bodies, times.shape[-1], 9))
        lost = np.abs(each[..., 0] * times) > _LARGEST_ANGLE
        if lost.any():
            when = np.broadcast_to(times, lost.shape)[lost][0]
            raise ValueError(
                f"t = {when:g}: the orbit turns by more than {_LARGEST_ANGLE:g} rad until then; "
                "doubles do not tell where the body is"
            )
        found = _core.orbit_anomalies(
            np.ascontiguousarray(each.reshape(-1, 9)),
            np.ascontiguousarray(np.broadcast_to(times, each.shape[:-1]).reshape(-1)),
        ).reshape(*each.shape[:-1], 2)
        place: Floats = (found[..., :1] - each[..., 1:2]) * each[..., 3:6]
        place = place + found[..., 1:] * each[..., 6:]
        return place if np.ndim(t) else place[..., 0, :]

    def frame(self, t: ArrayLike) -> Floats:
        """The axes of the orbit in space: columns radial, along and normal.

        The radial axis points from the planet to the body. The axis *along* is perpendicular to the
        radial axis in the plane of the orbit: on a circle it has the direction of the motion. The
        normal of a table of positions is at right angles to position and velocity.

        Parameters
        ----------
        t : array_like, shape (m,), () or (..., m)
            Times (s), of all orbits or of each.

        Returns
        -------
        ndarray, shape (..., m, 3, 3) or (..., 3, 3)
            Rotation matrices.

        Raises
        ------
        ValueError
            As for :meth:`position`; if the body of a table moves along the line to the planet.

        Examples
        --------
        >>> import rigid
        >>> rigid.Orbit(1.0).frame(0.0).tolist()
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        """
        frame, _ = self._turning(np.atleast_1d(shaped("t", t)))
        return frame if np.ndim(t) else frame[..., 0, :, :]

    def to_space(
        self, omega: ArrayLike, attitude: AttitudeLike | None = None, t: ArrayLike = 0.0
    ) -> tuple[Floats, Floats]:
        """Rates and attitudes in space, of a body whose motion is told in the frame of the orbit.

        A run, a map and every other call take a start in space, so that rates and attitudes have
        one meaning: this turns a start that is told beside the orbit, and
        :meth:`Run.in_orbit_frame` turns the results.

        Parameters
        ----------
        omega : array_like, shape (..., 3)
            Angular velocities relative to the frame of the orbit, in the body (rad/s).
        attitude : array_like, shape (..., 4), or scipy Rotation, optional
            Attitudes relative to the axes of :meth:`frame`, radial, along and normal: from the body
            to these axes. Default: the body axes 1, 2, 3 lie along them.
        t : array_like, shape (...)
            Times (s) of the states.

        Returns
        -------
        omega : ndarray, shape (..., 3)
            Angular velocities in space, in the body (rad/s).
        attitude : ndarray, shape (..., 4)
            Unit quaternions, from the body to space.

        Raises
        ------
        ValueError
            If the shapes do not broadcast, an attitude is zero, or as for :meth:`position`.

        Examples
        --------
        A moon at rest in the frame of its circular orbit stays there:

        >>> import numpy as np, rigid
        >>> orbit = rigid.Orbit(2e-5, anomaly=0.4)
        >>> moon = rigid.FreeBody(rigid.Body.ellipsoid(1.3, 1.1, 1.0), orbit=orbit)
        >>> run = rigid.simulate(moon, *orbit.to_space([0.0, 0.0, 0.0]), t=[0.0, 1e6])
        >>> bool(np.allclose(run.in_orbit_frame().attitude, [1.0, 0.0, 0.0, 0.0]))
        True
        """
        rates = vectors("omega", omega)
        relative, times = attitudes(attitude), shaped("t", t)
        leading = {"omega": rates.shape[:-1], "attitude": relative.shape[:-1], "t": times.shape}
        shape = batch_shape({"orbit": self.shape, **leading})
        frame, turning = self._turning(np.broadcast_to(times, shape)[..., np.newaxis])
        turned = product_of_checked(matrix_to_quaternion(frame[..., 0, :, :]), relative)
        return rates + to_body(relative, turning[..., 0, :]), turned

    def from_space(self, omega: Floats, attitude: Floats, t: Floats) -> tuple[Floats, Floats]:
        """The inverse of :meth:`to_space`, of checked arrays with the axis of times."""
        frame, turning = self._turning(t)
        back = matrix_to_quaternion(frame) * np.array([1.0, -1.0, -1.0, -1.0])
        relative = product_of_checked(back, attitude)
        return omega - to_body(relative, turning), relative

    def _turning(self, t: Floats) -> tuple[Floats, Floats]:
        """The axes of the orbit, and how fast they turn, along these axes (rad/s).

        The direction from the planet turns by ``n sqrt|1 - e²| (a/r)²`` about the normal.
        """
        place, e = self.position(t), np.asarray(self.eccentricity)
        radial = place / np.linalg.norm(place, axis=-1, keepdims=True)
        normal = np.broadcast_to(np.asarray(self.normal)[..., np.newaxis, :], radial.shape)
        momentum = np.asarray(self.rate) * np.sqrt(np.abs((1.0 - e) * (1.0 + e)))
        turning = np.zeros(place.shape)
        turning[..., 2] = momentum[..., np.newaxis] / np.sum(place * place, axis=-1)
        return np.stack([radial, np.cross(normal, radial), normal], axis=-1), turning

    @property
    def numbers(self) -> Floats:
        """Rate, eccentricity, mean anomaly and both semi-axes, as the core reads them; (..., 9)."""
        shape = self.shape
        scalars = [
            np.broadcast_to(np.asarray(number), shape)[..., np.newaxis]
            for number in (self.rate, self.eccentricity, self.anomaly)
        ]
        first, normal = (
            np.broadcast_to(np.asarray(axis), (*shape, 3)) for axis in (self.periapsis, self.normal)
        )
        e = scalars[1]
        second = np.sqrt(np.abs((1.0 - e) * (1.0 + e))) * np.cross(normal, first)
        return np.concatenate([*scalars, _sign(e) * first, second], axis=-1)

    @classmethod
    def of_numbers(cls, numbers: ArrayLike) -> Self:
        """The orbit with these :attr:`numbers`, shape (..., 9)."""
        every = np.asarray(numbers, dtype=np.float64)
        rate, e, mean = (every[..., k] for k in range(3))
        first = _sign(every[..., 1:2]) * every[..., 3:6]
        normal = np.cross(first, every[..., 6:])
        normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        return cls(rate, e, mean, normal, first)

    def to_dict(self) -> dict[str, Any]:
        """The orbit as a dict of numbers; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        return {name: np.asarray(getattr(self, name)).tolist() for name in self.__slots__}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The orbit that :meth:`to_dict` described.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        Orbit

        Examples
        --------
        >>> import rigid
        >>> orbit = rigid.Orbit(1e-3, eccentricity=0.1)
        >>> rigid.Orbit.from_dict(orbit.to_dict()) == orbit
        True
        """
        return OrbitTable(**data) if "positions" in data else cls(**data)  # type: ignore[return-value]

    def __repr__(self) -> str:
        parts = []
        for name, usual in _USUAL.items():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                parts.append(f"{name} of shape {value.shape}")
            elif value != usual:
                parts.append(f"{name}={value}")
        return f"Orbit({', '.join(parts)})"

    def words(self, varied: Container[str] = ()) -> str:
        """The orbit in a few words; ``varied`` names the numbers that the axes of a map set."""
        if self.shape:
            return "orbit of each"
        path = f"eccentricity {self.eccentricity:g}" if self.eccentricity else "circular"
        if "eccentricity" in varied:
            path = "eccentricity varied"
        kind = "flyby" if self.eccentricity > 1.0 else "orbit"
        rate = "a varied rate" if "rate" in varied else f"{self.rate:g} rad/s"
        return f"{kind} at {rate}, {path}"

    def passage(self, begin: float, end: float) -> str:
        """Where one body goes from one time to another (s), in words that follow a verb."""
        if self.eccentricity < 1.0:
            periods = f"{self.rate * abs(end - begin) / (2.0 * np.pi):.3g}"
            return f"({'a period' if periods == '1' else f'{periods} periods'} of its orbit)"
        nearest = -self.anomaly / self.rate
        low, high = sorted((begin, end))
        if low <= nearest <= high:
            return f"and passes a planet at t = {nearest:.3g} s"
        return f"{'before' if nearest > high else 'after'} it passes a planet"


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class OrbitTable(Sampled, Orbit):
    """A trajectory of an ephemeris, as :meth:`Orbit.table` returns it.

    It has no rate, eccentricity, anomaly or periapsis. What asks for these refuses it: axes of
    maps, derivatives, events and criteria in the frame of the orbit.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    positions : ndarray, shape (m, 3)
        Vectors from the planet to the body in space (m).
    gm : float
        Gravitational parameter of the planet (m³/s²).
    """

    t: Floats
    positions: Floats
    gm: float

    def __init__(self, t: ArrayLike, positions: ArrayLike, gm: float) -> None:
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "t", table_times(t))
        set_field(self, "gm", finite_float("gm", gm, positive=True))
        places = numbers("positions", positions, "m")
        if places.shape != (len(self.t), 3):
            raise ValueError(f"positions: expected shape ({len(self.t)}, 3), got {places.shape}")
        place = of_shape("positions", places, None, 3)
        at_planet = ~np.any(place != 0.0, axis=-1)
        if at_planet.any():
            raise ValueError(f"positions{[int(np.argmax(at_planet))]} = 0: must not be the planet")
        set_field(self, "positions", frozen(place))
        gaps = np.diff(self.t)
        uneven = np.maximum(gaps[1:] / gaps[:-1], gaps[:-1] / gaps[1:]) > _UNEVEN
        if uneven.any():
            raise ValueError(
                f"t = {self.t[int(np.argmax(uneven)) + 1]:g}: the intervals before and after it "
                "must not differ by more than a factor of two: the spline would hide its error"
            )
        try:
            self._spline(self.t[0])
        except ValueError as error:  # too few positions
            raise ValueError(str(error).replace("orbit", "positions", 1)) from None

    def __reduce__(self) -> tuple[Any, ...]:
        return OrbitTable, (self.t, self.positions, self.gm)

    def __getattr__(self, name: str) -> Any:
        # Python asks for a property of ellipses, too, after it has not found one of their numbers.
        if hasattr(Orbit, name):
            raise _NotOfTablesError(
                f"orbit = {self!r}: has no rate, eccentricity, anomaly or periapsis, which this "
                "needs; a table of positions takes part in runs and maps, give rigid.Orbit or "
                "rigid.Orbit.flyby for the rest"
            )
        raise AttributeError(name)

    @property
    def shape(self) -> Shape:
        """One trajectory of all bodies: ``()``."""
        return ()

    @property
    def samples(self) -> Floats:
        """``sqrt(3 gm/r³) o`` in space at the times of the table (1/s)."""
        x, y, z = self.positions.T
        square = x * x + y * y + z * z
        size: Floats = np.sqrt(3.0 * self.gm / np.sqrt(square)) / square
        return self.positions * size[:, np.newaxis]

    def _spline(self, t: ArrayLike) -> Floats:
        """Value, slope and bend of the spline through the samples, shape (..., m, 3, 3)."""
        times = reached("orbit", self.t, t)
        return _core.spline(self.t, self.samples, times.ravel()).reshape(*times.shape, 3, 3)

    def position(self, t: ArrayLike) -> Floats:
        """Vector from the planet to the body in space (m), from the spline.

        Parameters
        ----------
        t : array_like, shape (m,), () or (..., m)
            Times (s).

        Returns
        -------
        ndarray, shape (..., m, 3) or (..., 3)

        Raises
        ------
        ValueError
            If the table does not reach a time.
        """
        root = self._spline(t)[..., 0, :]
        square = np.sum(root * root, axis=-1, keepdims=True)
        place: Floats = root * np.cbrt(3.0 * self.gm / square) / np.sqrt(square)
        return place if np.ndim(t) else place[..., 0, :]

    def _turning(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """The axes at times, and how fast they turn, along these axes (rad/s).

        With the root ``c`` of the gradient they turn by ``|c × c'|/c²`` about the normal ``n``, and
        by ``|c| n·c''/|c × c'|`` about the radial axis.
        """
        root, slope, bend = np.moveaxis(self._spline(t), -2, 0)
        size = np.linalg.norm(root, axis=-1)
        normal = np.cross(root, slope)
        swept = np.linalg.norm(normal, axis=-1)
        if not np.all(swept > 0.0):
            raise ValueError("t: the body moves along the line to the planet; no frame is known")
        radial, normal = root / size[..., np.newaxis], normal / swept[..., np.newaxis]
        turning = np.zeros(root.shape)
        turning[..., 0] = size * np.sum(normal * bend, axis=-1) / swept
        turning[..., 2] = swept / size**2
        return np.stack([radial, np.cross(normal, radial), normal], axis=-1), turning

    def words(self, varied: Container[str] = ()) -> str:
        """The trajectory in a few words."""
        return f"orbit by a table of {len(self.t)} times"

    def passage(self, begin: float, end: float) -> str:
        """Where a body goes, in words that follow a verb."""
        return "along a trajectory by a table"


class _NotOfTablesError(ValueError, AttributeError):
    """A table has no such attribute, and is a wrong value where an ellipse or a flyby is needed."""


_UNEVEN = 2.0 + 1e-9
"""Largest quotient of neighbouring intervals of a table, but for rounding.

Without a sample the interval is then at least 1.5 times as long, and a cubic spline errs 1.5⁴ = 5
times as much: a third of the difference is still above the error.
"""

_USUAL: Mapping[str, Any] = {
    "rate": None,
    "eccentricity": 0.0,
    "anomaly": 0.0,
    "normal": (0.0, 0.0, 1.0),
    "periapsis": (1.0, 0.0, 0.0),
}
"""Default values, which ``repr`` omits."""


def _sign(e: Floats) -> Floats:
    """1 of an ellipse, -1 of a hyperbola, whose first semi-axis leads away from the periapsis."""
    return np.where(e > 1.0, -1.0, 1.0)


def _plane(normal: ArrayLike, direction: ArrayLike, name: str) -> tuple[Floats, Floats]:
    """The normal of an orbit, and the direction of its periapsis made perpendicular to it.

    Raises
    ------
    ValueError
        If one is no unit vector, or the two are not at right angles; ``name`` is the argument.
    """
    axis, begin = unit_vectors("normal", normal), unit_vectors(name, direction)
    along = np.sum(axis * begin, axis=-1, keepdims=True)
    if np.any(np.abs(along) > 2.0 * UNIT):  # each vector may be off by UNIT
        index, place = first_place(np.abs(along[..., 0]) > 2.0 * UNIT)
        given = np.broadcast_to(begin, (*along.shape[:-1], 3))[index].tolist()
        raise ValueError(
            f"{name}{place} = {given}: must be at right angles to normal, their product is "
            f"{along[index][0]:g}, above {2.0 * UNIT:g}"
        )
    # Vectors perpendicular to rounding stay: a file gives back the same orbit.
    turned = begin - along * axis
    turned = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    return axis, np.where(np.abs(along) > _ROUNDED, turned, begin)


def _mean_anomaly(true: Floats, e: Floats) -> Floats:
    """The mean anomaly at a true anomaly, of the same revolution (Murray and Dermott, eq. 2.46).

    On a hyperbola ``tanh`` takes the place of ``tan`` (Battin 1999, eq. 4.35).
    """
    true, e = np.broadcast_arrays(true, e)
    half = 0.5 * np.remainder(true + np.pi, 2.0 * np.pi) - 0.5 * np.pi
    turns = true - 2.0 * half
    across, along = np.sqrt(np.abs(1.0 - e)) * np.sin(half), np.sqrt(1.0 + e) * np.cos(half)
    beyond = (e > 1.0) & (np.abs(across) >= along)
    if np.any(beyond):
        index, place = first_place(beyond)
        raise ValueError(
            f"true_anomaly{place} = {true[index]:g}: must be within the asymptotes of the "
            f"hyperbola, {np.arccos(-1.0 / e[index]):g} rad from the periapsis"
        )
    eccentric = 2.0 * np.arctan2(across, along)
    ratio = np.where(e > 1.0, across / along, 0.0)
    hyperbolic = 2.0 * np.arctanh(ratio)
    return np.where(
        e > 1.0, e * np.sinh(hyperbolic) - hyperbolic, eccentric - e * np.sin(eccentric) + turns
    )
