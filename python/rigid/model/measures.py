"""The measures of a map: numbers of each body besides its class."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from .._checks.arguments import brief, one_of
from .bounds import PointingWithin
from .criteria import REFERENCES, no_flip, tilt_below
from .orbit_axes import extreme_axis, require_orbit
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
    """

    name: str
    axis: int | None = None
    reference: str | None = None

    def __post_init__(self) -> None:
        one_of("name", self.name, MEASURES)
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
        return self

    @property
    def runs(self) -> bool:
        """Whether this measure alone needs bodies to be integrated until the horizon."""
        return self.name not in ("time_to_leave", "drift")

    def check_forced(self, scene: Scene, forces: Sequence[str]) -> None:
        """Raise ValueError if a map cannot measure it under torque and damping."""
        if self.name == "largest_tilt":
            tilt_below(1.0, reference=self.reference).check_forced(scene, forces)

    def core(self) -> tuple[str, int]:
        """Name and axis as the core takes them."""
        name = f"tilt_from_{self.reference}" if self.name == "largest_tilt" else self.name
        return ON_ORBIT.get(name, name), self.axis or 0

    @property
    def unit(self) -> str:
        """Unit of the values, ``"1"`` for a number."""
        return MEASURES[self.name][0]

    @property
    def words(self) -> str:
        """Meaning in a few words."""
        of_axis = "" if self.axis is None else f" of axis {self.axis}"
        origin = "" if self.reference is None else f" from the {self.reference}"
        return f"{MEASURES[self.name][1]}{of_axis}{origin}"

    def to_dict(self) -> dict[str, Any]:
        """The measure as a JSON-able dictionary."""
        return asdict(self)

    def __str__(self) -> str:
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
        return asked.name in ON_ORBIT and asked.axis is None
    leaves = getattr(asked, "leaves", ())
    return any(isinstance(leaf, PointingWithin) and leaf.axis is None for leaf in leaves)


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
