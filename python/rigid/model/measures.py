"""The measures of a map: numbers of each body besides its class."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import pi
from typing import Any

from .._checks.arguments import brief, finite_float, one_of
from .bounds import (
    REFERENCES,
    AngleWithin,
    PointingWithin,
    checked_angle,
    no_flip,
    tilt_below,
)
from .criterion import Condition
from .orbit_axes import ANGLES, Axes, checked_axes, extreme_axis, require_orbit, rest_axes
from .scene import Scene
from .start import Start, body_axis

MEASURES: Mapping[str, tuple[str, str]] = {
    "time_to_leave": ("s", "time of leaving stability"),
    "flips": ("1", "sign changes of the rate"),
    "largest_tilt": ("rad", "largest tilt"),
    "mean_rate": ("rad/s", "mean rate"),
    "libration_amplitude": ("rad", "largest angle from the line to the planet"),
    "obliquity": ("rad", "largest angle from the normal of the orbit"),
    "spin_orbit_ratio": ("1", "mean rate over the mean motion of the orbit"),
    "largest_roll": ("rad", "largest roll of either sign"),
    "largest_pitch": ("rad", "largest pitch of either sign"),
    "largest_yaw": ("rad", "largest yaw of either sign"),
    "time_to_settle": ("s", "time from which on"),
    "drift": ("1", "largest drift of an invariant"),
}
"""All measures by their name, with unit and meaning; a function of this name makes each."""

MOST_MEASURES = 16

ON_ORBIT = {
    "libration_amplitude": "angle_from_radial",
    "obliquity": "angle_from_normal",
    "spin_orbit_ratio": "mean_rate_over_motion",
}
"""The measures in the frame of an orbit, and their names in the core."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of each body that a map collects; made by the functions of this module.

    Attributes
    ----------
    name : str
        Name in :data:`MEASURES`.
    axis : int or None
        The body axis; None for a default that is still open, or without meaning.
    reference : {"start", "vertical"} or None
        The direction of a tilt.
    of : {"speed", "roll", "pitch", "yaw"} or None
        What settles, or the angle whose largest value is measured.
    limit : float or None
        The limit (rad/s or rad) below which it settles.
    axes : (int, int) or None
        The body axes of an angle at rest along the line from the planet and along the normal.
    """

    name: str
    axis: int | None = None
    reference: str | None = None
    of: str | None = None
    limit: float | None = None
    axes: Axes | None = None

    def __post_init__(self) -> None:
        one_of("name", self.name, MEASURES)
        if self.axes is not None:
            object.__setattr__(self, "axes", checked_axes(self.axes))
        if self.axis is not None:
            object.__setattr__(self, "axis", body_axis(self.axis, signed=self.name != "flips"))
        if self.reference is not None:
            one_of("reference", self.reference, REFERENCES)

    def resolved(self, scene: Scene, start: Start) -> Measure:
        """The measure with the defaults of a criterion that watches the same quantity."""
        if self.name == "flips":
            return replace(self, axis=no_flip(self.axis).resolved(scene, start).axis)
        if self.name == "largest_tilt":
            assert self.axis is not None
            tilt = tilt_below(1.0, axis=self.axis, reference=self.reference)
            return replace(self, reference=tilt.resolved(scene, start).reference)
        if self.name in ON_ORBIT:
            require_orbit(self.name, scene)
            if self.axis is None:
                is_long = self.name == "libration_amplitude"
                return replace(self, axis=extreme_axis(scene, long=is_long))
        if self.of in ANGLES:
            require_orbit(self.name, scene)
            return self if self.axes is not None else replace(self, axes=rest_axes(scene))
        return self

    @property
    def runs(self) -> bool:
        """Whether this measure alone needs bodies to be integrated until the horizon."""
        return self.name not in ("time_to_leave", "drift")

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:
        """Raise ValueError if a map cannot measure it under torque and damping."""
        if self.name == "largest_tilt":
            tilt_below(1.0, reference=self.reference).check_forced(scene, forces)

    def core(self) -> Condition:
        """Name, axis and numbers as the core takes them."""
        if self.of is not None:
            kind = "largest" if self.limit is None else "settled"
            limit = pi if self.limit is None else self.limit
            if self.axes is None:
                return f"{kind}_speed_below", 0, (limit,)
            return f"{kind}_{self.of}_within", self.axes[0], (limit, float(self.axes[1]))
        name = f"tilt_from_{self.reference}" if self.name == "largest_tilt" else self.name
        return ON_ORBIT.get(name, name), self.axis or 0, ()

    @property
    def unit(self) -> str:
        """Unit of the values, ``"1"`` for a number."""
        return MEASURES[self.name][0]

    @property
    def words(self) -> str:
        """Meaning in a few words."""
        if self.limit is not None:
            what, unit = ("|omega|", "rad/s") if self.of == "speed" else (self.of, "rad")
            return f"{MEASURES[self.name][1]} {what} stays within {self.limit:g} {unit}"
        of_axis = "" if self.axis is None else f" of axis {self.axis}"
        origin = "" if self.reference is None else f" from the {self.reference}"
        return f"{MEASURES[self.name][1]}{of_axis}{origin}"

    def to_dict(self) -> dict[str, Any]:
        """The measure as a JSON-able dictionary."""
        every = asdict(self)
        own = {key: every[key] for key in ("of", "limit", "axes") if every[key] is not None}
        return {**{key: every[key] for key in ("name", "axis", "reference")}, **own}

    def __str__(self) -> str:
        if self.limit is not None:
            of = "" if self.of == "speed" else f", {self.of}"
            return f"{self.name}({self.limit:g}{of})"
        return self.name if self.axis is None else f"{self.name}({self.axis})"


def make_measures(measure: Measure | Iterable[Measure]) -> tuple[Measure, ...]:
    """One or several measures as a tuple."""
    if isinstance(measure, Measure) or not isinstance(measure, Iterable):
        measures: tuple[Measure, ...] = (measure,)
    else:
        measures = (measure,) if isinstance(measure, str) else tuple(measure)
    for one in measures:
        if not isinstance(one, Measure):
            known = ", ".join(f"rigid.{name}()" for name in MEASURES)
            raise TypeError(f"measure = {brief(one)}: must be a measure: {known}")
    if len(measures) > MOST_MEASURES:
        raise ValueError(f"measure: {len(measures)} are asked for, at most {MOST_MEASURES} may be")
    return measures


def asks_for_an_axis(asked: object) -> bool:
    """Whether the default axis of a criterion or a measure on an orbit follows from the bodies."""
    if isinstance(asked, Measure):
        of_angle = asked.of in ANGLES and asked.axes is None
        return of_angle or (asked.name in ON_ORBIT and asked.axis is None)
    leaves = getattr(asked, "leaves", ())
    return any(
        (isinstance(leaf, PointingWithin) and leaf.axis is None)
        or (isinstance(leaf, AngleWithin) and leaf.axes is None)
        for leaf in leaves
    )


def check_distinct(measures: tuple[Measure, ...]) -> None:
    """Raise ValueError if two measures have the same name and axis."""
    names = [str(one) for one in measures]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"measure: {name} is asked for {names.count(name)} times")


def time_to_leave() -> Measure:
    """Time (s) at which a body leaves stability; only unstable bodies have one.

    Returns
    -------
    Measure

    Notes
    -----
    The time is taken from the first run. For joined criteria it is the last time at which their
    logic, applied to the conditions kept until then, turned from true to false; bodies without such
    a time do not count.

    Examples
    --------
    >>> import rigid
    >>> rigid.time_to_leave().unit
    's'
    """
    return Measure("time_to_leave")


def flips(axis: int | None = None) -> Measure:
    """Number of sign changes of the rate about a body axis, until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3}, optional
        The body axis; by default the axis of :func:`no_flip`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis is unknown.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.flips(2))
    'flips(2)'
    """
    return Measure("flips", axis)


def largest_tilt(*, axis: int = 3, reference: str | None = None) -> Measure:
    """Largest angle (rad) of a body axis from a direction of space, until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3, -1, -2, -3}
        The body axis; negative for its opposite direction.
    reference : {"start", "vertical"}, optional
        The direction, as in :func:`tilt_below`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis or the reference is unknown.

    Examples
    --------
    >>> import rigid
    >>> rigid.largest_tilt(reference="vertical").words
    'largest tilt of axis 3 from the vertical'
    """
    return Measure("largest_tilt", axis, reference)


def mean_rate(axis: int) -> Measure:
    """Mean over the time of the rate about a body axis (rad/s), until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3, -1, -2, -3}
        The body axis; negative for its opposite direction.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis is unknown.

    Notes
    -----
    The rate is integrated as the polynomial of each step, by methods without one as the cubic
    through the rates and their slopes at both ends.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.mean_rate(1))
    'mean_rate(1)'
    """
    return Measure("mean_rate", axis)


def libration_amplitude(axis: int | None = None) -> Measure:
    """Largest angle (rad) of an axis from the line to the planet, until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3}, optional
        The body axis, by default the long one, about which the moment is smallest, if this axis is
        the same in all pixels. The end counts that is nearer to the direction from the planet at
        the start: a body that turns round has about pi.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis is unknown. A map of a scene without an orbit refuses the measure.

    Notes
    -----
    The angle is the angle of :func:`pointing_within`, at four places of each step and at its
    largest between them.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.libration_amplitude(1))
    'libration_amplitude(1)'
    """
    return Measure("libration_amplitude", axis)


def obliquity(axis: int | None = None) -> Measure:
    """Largest angle (rad) of an axis from the normal of the orbit, until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3, -1, -2, -3}, optional
        The body axis, by default the axis of the largest moment, if it is the same in all pixels;
        negative for its opposite direction.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis is unknown. A map of a scene without an orbit refuses the measure.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.obliquity(3))
    'obliquity(3)'
    """
    return Measure("obliquity", axis)


def spin_orbit_ratio(axis: int | None = None) -> Measure:
    """Mean rate about a body axis over the mean motion of the orbit, until the horizon.

    Parameters
    ----------
    axis : {1, 2, 3, -1, -2, -3}, optional
        The body axis, by default the axis of the largest moment, if it is the same in all pixels.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axis is unknown. A map of a scene without an orbit refuses the measure.

    Examples
    --------
    >>> import rigid
    >>> str(rigid.spin_orbit_ratio(3))
    'spin_orbit_ratio(3)'
    """
    return Measure("spin_orbit_ratio", axis)


def largest_roll(axes: Axes | None = None) -> Measure:
    """Largest roll (rad) of either sign of a body on its orbit, until the horizon.

    Parameters
    ----------
    axes : (int, int), optional
        As in :func:`roll_within`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axes are unknown. A map of a scene without an orbit refuses the measure.

    Examples
    --------
    >>> import rigid
    >>> rigid.largest_roll().words
    'largest roll of either sign'
    """
    return Measure("largest_roll", of="roll", axes=axes)


def largest_pitch(axes: Axes | None = None) -> Measure:
    """Largest pitch (rad) of either sign of a body on its orbit, until the horizon.

    Parameters
    ----------
    axes : (int, int), optional
        As in :func:`pitch_within`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axes are unknown. A map of a scene without an orbit refuses the measure.

    Examples
    --------
    >>> import rigid
    >>> rigid.largest_pitch().words
    'largest pitch of either sign'
    """
    return Measure("largest_pitch", of="pitch", axes=axes)


def largest_yaw(axes: Axes | None = None) -> Measure:
    """Largest yaw (rad) of either sign of a body on its orbit, until the horizon.

    Parameters
    ----------
    axes : (int, int), optional
        As in :func:`yaw_within`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the axes are unknown. A map of a scene without an orbit refuses the measure.

    Examples
    --------
    >>> import rigid
    >>> rigid.largest_yaw().words
    'largest yaw of either sign'
    """
    return Measure("largest_yaw", of="yaw", axes=axes)


def time_to_settle(limit: float, of: str = "speed", axes: Axes | None = None) -> Measure:
    """Time (s) from which on a body stays slow, or near its rest on the orbit, until the horizon.

    Parameters
    ----------
    limit : float
        The limit of the quantity: rad/s of the speed, rad of an angle.
    of : {"speed", "roll", "pitch", "yaw"}
        The length of the rates; or an angle in the frame of the orbit, of either sign.
    axes : (int, int), optional
        Of an angle, as in :func:`roll_within`.

    Returns
    -------
    Measure

    Raises
    ------
    ValueError
        If the limit is not positive, the quantity is unknown, or axes are given for the speed. A
        map of a scene without an orbit refuses an angle.

    Notes
    -----
    The time is zero of a body that never leaves the limit. A body beyond the limit at the horizon
    has no time: quantiles and means are of the bodies that have settled.

    Examples
    --------
    How long does a damper need to slow tumbling bodies down to 0.1 rad/s?

    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody(rigid.Body((2.0, 2.0, 2.0)), damping=0.5),
    ...     axes={"spin": [1.0]}, t_end=60.0, samples=64, rng=1,
    ...     start=rigid.Start(spin=1.0, noise=rigid.normal(0.0)),
    ...     stable=~rigid.spin_above(0.1), measure=rigid.time_to_settle(0.1),
    ... )
    >>> settled = result.measures["time_to_settle"]
    >>> bool(np.isclose(settled.quantile(0.5)[0], 4.0 * np.log(10.0), rtol=1e-6))
    True
    """
    of = one_of("of", of, ("speed", *ANGLES))
    if of == "speed":
        limit = finite_float("limit", limit, positive=True, unit="rad/s")
        if axes is not None:
            raise ValueError(f"axes = {brief(axes)}: the speed has none")
    else:
        limit = checked_angle("limit", limit)
    return Measure("time_to_settle", of=of, limit=limit, axes=axes)


def drift() -> Measure:
    """Largest relative drift of energy, momentum and unit lengths of a body that is integrated.

    Returns
    -------
    Measure

    Notes
    -----
    It is the drift of the first run until it ended, as in the columns ``energy_drift``,
    ``momentum_drift`` and ``unit_drift``. Bodies in closed form have none and do not count.

    Examples
    --------
    >>> import rigid
    >>> rigid.drift().words
    'largest drift of an invariant'
    """
    return Measure("drift")
