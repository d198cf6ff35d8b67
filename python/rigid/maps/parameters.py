"""The parameters that an axis of a map may vary: unit, range, and the number that they set.

A new parameter is one row of :data:`PARAMETERS`.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, numbers, of_known
from ..model.orbit import HYPERBOLA
from ..model.scene import Scene
from ..model.start import Noise, Start, cos_sin

Floats = NDArray[np.float64]

OF_RUN = "run"
"""The place of numbers of the whole request, such as the horizon, which no body has."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter that an axis of a map can set.

    Attributes
    ----------
    symbol, unit, meaning : str
        For plots and messages; the unit is ``"1"`` for a ratio.
    place : str
        The numbers among which the parameter is: a key of :data:`PLACES`, or :data:`OF_RUN`.
    index : tuple of int
        Its index among the numbers of one body there; empty if it sets all of them.
    times : int or None
        The index of the moment of which the value is a multiple; it is set before.
    number : callable or None
        The number in its place as a function of the value, if it is another one.
    lowest, highest : float
        Range of the values.
    open_end : bool
        Whether the bound ``lowest`` is excluded.
    """

    symbol: str
    unit: str
    meaning: str
    place: str
    index: tuple[int, ...] = ()
    times: int | None = None
    number: Callable[[Floats], Any] | None = None
    lowest: float = -np.inf
    highest: float = np.inf
    open_end: bool = False

    @property
    def rule(self) -> str:
        """The rule for the values."""
        if self.highest < np.inf:
            return f"must lie in [{self.lowest:.6g}, {self.highest:.6g}]"
        if self.lowest > 0.0:
            return f"must be at least {self.lowest:g}"
        return "must be positive" if self.open_end else "must not be negative"

    def rejects(self, values: Floats) -> NDArray[np.bool_]:
        """Which values are out of range."""
        low = values <= self.lowest if self.open_end else values < self.lowest
        rejected: NDArray[np.bool_] = low | (values > self.highest)
        return rejected

    def why_not(self, scene: Scene, start: Start) -> str:
        """The reason why the parameter does not apply to a scene and start; empty if it does."""
        return PLACES[self.place].why_not(scene, start, self) if self.place in PLACES else ""

    def sets(self, name: str) -> tuple[str, ...]:
        """The names of the numbers that the parameter of this name sets."""
        if self.times is not None:
            return (f"I{self.index[0] + 1}",)
        return (self.place in PLACES and PLACES[self.place].sets) or (name,)

    def put(self, numbers: Mapping[str, Floats], values: Floats) -> None:
        """Write a value for each pixel into the numbers of all pixels, by their places."""
        if self.place not in numbers:
            return  # a number of the whole request, or an argument of a function
        if self.times is not None:
            with np.errstate(over="ignore"):  # a moment that overflows makes an impossible body
                values = values * numbers[self.place][:, self.times]
        found = values if self.number is None else self.number(values)
        every: Any = numbers[self.place]
        every[:, *self.index].T[...] = found


# Where each parameter applies

_ATTITUDE_UNFELT = "the attitude of a free body without a torque in space has no effect"


def _anywhere(_scene: Scene, _start: Start, _asked: Parameter) -> str:
    return ""


def _needs_box(scene: Scene, _start: Start, _asked: Parameter) -> str:
    if scene.body.sides is None:
        return "the sides of the body are not known; make it with Body.box(a, b, c)"
    return ""


def _needs_free_body(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return f"a {scene.title} has none; use a FreeBody" if scene.directions else ""


def _needs_orbit(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return "the scene has no orbit; give it orbit=rigid.Orbit(rate)" if scene.orbit is None else ""


def _needs_vertical(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return "" if scene.directions else "a free body knows no vertical; use a HeavyTop"


def _needs_weight(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return "" if "mgl" in scene.fields else "a free body feels no weight; use a HeavyTop"


def _needs_diagonal_damping(scene: Scene, _start: Start, _asked: Parameter) -> str:
    matrix = _or_zero(scene.damping, 3, 3)
    if np.any(matrix - np.diag(np.diag(matrix))):
        return "the damping of the scene is not along the body axes"
    return ""


def _needs_constant_torque(scene: Scene, _start: Start, _asked: Parameter) -> str:
    is_table = scene.torque is not None and scene.torque.times
    return "the torque of the scene is a table" if is_table else ""


def _needs_spin(_scene: Scene, start: Start, _asked: Parameter) -> str:
    if start.spin is None:
        return "the start is given by omega; use omega1, omega2, omega3 or Start(spin=...)"
    return ""


def _needs_spin_or_attitude(scene: Scene, start: Start, _asked: Parameter) -> str:
    if start.attitude is not None:
        return "the attitude of the start is given; use Start(tilt=...)"
    if start.spin is None and not scene.directions:
        return "the start is given by omega; use Start(spin=...)"
    return ""


def _needs_omega(_scene: Scene, start: Start, _asked: Parameter) -> str:
    return "the start is given by spin; use Start(omega=...)" if start.omega is None else ""


def _needs_noise(scene: Scene, start: Start, asked: Parameter) -> str:
    name, is_kappa = asked.place, asked.unit == "1"
    of_attitude, kind = name == "attitude_noise", name.replace("_", " ")
    noise = start.attitude_noise if of_attitude else start.noise
    what = f"the {kind}" if of_attitude else f"the {kind} of the start"
    if of_attitude and not scene.rates_need_attitude:
        return f"{_ATTITUDE_UNFELT}; use {'kappa' if is_kappa else 'noise'}"
    is_direction = isinstance(noise, Noise) and noise.is_direction
    if is_kappa:
        return "" if is_direction else f"the start has no {name}=rigid.von_mises_fisher(0)"
    if noise is None:
        return f"the start has no {kind}; give a kind, as in Start({name}=rigid.normal(0))"
    if not isinstance(noise, Noise):
        return "the start has given samples, which have no size; use Start(noise=rigid.normal(0))"
    if noise.cov is not None:
        return f"{what} has a covariance; give it a size"
    if is_direction:
        return f"{what} has a concentration; use {name.replace('noise', 'kappa')}"
    if noise.kind == "uniform_attitude":
        return "uniform_attitude() has no size"
    if isinstance(noise.size, tuple) and not asked.index:
        return f"{what} has a size for each component; give it a single one"
    return ""


# Where the numbers of each parameter are


@dataclass(frozen=True, slots=True)
class Place:
    """Numbers of a scene or a start that axes set.

    Attributes
    ----------
    read : callable
        ``read(scene, start)`` gives the numbers of all bodies, or of each.
    width : int
        How many axes the numbers of one body have.
    why_not : callable
        ``why_not(scene, start, parameter)`` is the reason why an axis cannot set them, or empty.
    sets : tuple of str
        The names of what an axis sets; empty if it is the name of the axis.
    """

    read: Callable[[Any, Start], ArrayLike]
    width: int
    why_not: Callable[[Scene, Start, Parameter], str] = _anywhere
    sets: tuple[str, ...] = ()


def _or_zero(value: ArrayLike | None, *shape: int) -> Floats:
    """The value as an array, or zeros of this shape if there is none."""
    return np.zeros(shape) if value is None else np.asarray(value)


def _semi_axes(scene: Scene, _start: Start) -> Floats:
    """``a/b`` and ``c/b`` of homogeneous ellipsoids with these moments; NaN if there is none."""
    moments = np.asarray(scene.body.moments)
    squares = moments.sum(axis=-1, keepdims=True) - 2.0 * moments
    with np.errstate(all="ignore"):
        ratios: Floats = np.sqrt(squares[..., [0, 2]] / squares[..., [1]])
    return ratios


def _angles_of_com(scene: Any, _start: Start) -> Floats:
    """Cosine and sine of both angles of centres of mass; on axis 3 the azimuth is 0."""
    first, second, along = np.moveaxis(np.asarray(scene.com), -1, 0)
    across = np.sqrt(first * first + second * second)
    off = across > 0.0
    length = np.where(off, across, 1.0)
    turn = np.where(off, first / length, 1.0), np.where(off, second / length, 0.0)
    return np.stack([np.stack([along, across], axis=-1), np.stack(turn, axis=-1)], axis=-2)


def _torque_in_body(scene: Scene, _start: Start) -> Floats:
    torque = scene.torque
    return np.zeros(3) if torque is None else np.asarray(torque.in_body)[..., 0, :]


def _coefficient(scene: Scene, _start: Start) -> Floats:
    return _or_zero(None if scene.dissipation is None else scene.dissipation.coefficient, 3)


def _size_of_noise(_scene: Scene, start: Start) -> Floats:
    return np.broadcast_to(start.noise.size if isinstance(start.noise, Noise) else 0.0, 3)


def _size_of_attitude_noise(_scene: Scene, start: Start) -> Floats:
    size = 0.0 if start.attitude_noise is None else start.attitude_noise.size
    return np.broadcast_to(1.0 if start.joint else size, 3)


PLACES: Mapping[str, Place] = {
    "moments": Place(lambda scene, _: scene.body.moments, 1),
    "box": Place(lambda scene, _: (*scene.body.sides, scene.body.mass), 1, _needs_box),
    "semi-axes": Place(_semi_axes, 1, sets=("I1", "I2")),
    "mgl": Place(lambda scene, _: scene.mgl, 0, _needs_weight),
    "com": Place(lambda scene, _: scene.com, 1, _needs_weight, ("com",)),
    "com angles": Place(_angles_of_com, 2, _needs_weight, ("com",)),
    "damping": Place(lambda scene, _: _or_zero(scene.damping, 3, 3), 2, _needs_diagonal_damping),
    "torque": Place(_torque_in_body, 1, _needs_constant_torque),
    "rotor": Place(lambda scene, _: _or_zero(scene.rotor, 3), 1, _needs_free_body, ("rotor",)),
    "dissipation": Place(_coefficient, 1, _needs_free_body),
    "orbit": Place(lambda scene, _: scene.orbit.numbers[..., 1:3], 1, _needs_orbit),
    "spin": Place(lambda _, start: start.spin or 0.0, 0, _needs_spin),
    "tilt": Place(lambda _, start: start.tilt, 0, _needs_spin_or_attitude),
    "energy": Place(lambda _, _start: np.nan, 0),
    "l_gamma": Place(lambda _, _start: np.nan, 0, _needs_vertical),
    "omega": Place(lambda _, start: start.omega or (0.0, 0.0, 0.0), 1, _needs_omega),
    "noise": Place(_size_of_noise, 1, _needs_noise),
    "attitude_noise": Place(_size_of_attitude_noise, 1, _needs_noise),
}
"""The places of the parameters by name; of energy and momentum NaN, if they follow from rates."""


def _of_each_axis(
    name: str, symbol: str, unit: str, meaning: str, place: str, lowest: float = -np.inf
) -> dict[str, Parameter]:
    """A parameter for each body axis, whose number stands for ``#``."""
    found = {}
    for k in range(3):
        own, *words = (text.replace("#", str(k + 1)) for text in (name, symbol, unit, meaning))
        index = (k, k) if place == "damping" else (k,)
        found[own] = Parameter(words[0], words[1], words[2], place, index, lowest=lowest)
    return found


PARAMETERS: Mapping[str, Parameter] = {
    **_of_each_axis("I#", "$I_#$", "kg m²", "principal moment", "moments"),
    **{
        f"I{i}/I{j}": Parameter(
            f"$I_{i}/I_{j}$", "1", "ratio of principal moments", "moments", (i - 1,), times=j - 1
        )
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i != j
    },
    **{
        name: Parameter(
            f"side ${name}$", "m", "side of the box", "box", (k,), lowest=0.0, open_end=True
        )
        for k, name in enumerate("abc")
    },
    "mass": Parameter("mass", "kg", "mass of the box", "box", (3,), lowest=0.0, open_end=True),
    **{
        name: Parameter(
            f"${name}$",
            "1",
            "ratio of the semi-axes a ≥ b ≥ c, along axes 1, 2, 3, of the homogeneous ellipsoid "
            "with these moments; I3 stays",
            "semi-axes",  # a/b and c/b
            (k,),
            number=number,
            lowest=1.0,
        )
        for k, (name, number) in enumerate({"a/b": None, "b/c": np.reciprocal}.items())
    },
    "mgl": Parameter(
        "$mgl$", "J", "weight times distance of the centre of mass", "mgl", lowest=0.0
    ),
    **_of_each_axis(
        "com#",
        "$c_#$",
        "1",
        "component # towards the centre of mass; only the direction counts",
        "com",
    ),
    "com_tilt": Parameter(
        "tilt of the centre of mass",
        "rad",
        "angle from axis 3 to the centre of mass",
        "com angles",
        (0,),
        number=cos_sin,
        lowest=0.0,
        highest=pi,
    ),
    "com_turn": Parameter(
        "turn of the centre of mass",
        "rad",
        "azimuth of the centre of mass, from axis 1 towards axis 2",
        "com angles",
        (1,),
        number=cos_sin,
        lowest=-2.0 * pi,
        highest=2.0 * pi,
    ),
    **_of_each_axis(
        "damping#",
        "damping about axis #, $D_{##}$",
        "N m s",
        "damping about body axis #",
        "damping",
        lowest=0.0,
    ),
    **_of_each_axis("torque#", "$N_#$", "N m", "constant torque about body axis #", "torque"),
    **_of_each_axis(
        "rotor#", "$h_#$", "kg m²/s", "angular momentum of the rotor about body axis #", "rotor"
    ),
    "dissipation": Parameter(
        "$P$",
        "kg m² s",
        "coefficient of the energy sink, the same along all axes",
        "dissipation",
        lowest=0.0,
    ),
    "eccentricity": Parameter(
        "eccentricity $e$",
        "1",
        "eccentricity of the orbit",
        "orbit",
        (0,),
        lowest=0.0,
        highest=HYPERBOLA[1],
    ),
    "anomaly": Parameter("$M_0$", "rad", "mean anomaly of the orbit at t = 0", "orbit", (1,)),
    "spin": Parameter("spin", "rad/s", "rate about the axis of the start", "spin"),
    "tilt": Parameter(
        "tilt", "rad", "angle to the axis of the start", "tilt", lowest=-pi, highest=pi
    ),
    "energy": Parameter(
        "energy",
        "J",
        "energy of the start without noise; the rates are scaled, with `l_gamma` their other part",
        "energy",
    ),
    "l_gamma": Parameter(
        r"$L\cdot\gamma$",
        "kg m²/s",
        "vertical angular momentum of the start without noise: the part of the rates along the "
        "vertical is set",
        "l_gamma",
    ),
    **_of_each_axis("omega#", r"$\omega_#$", "rad/s", "rate in body components", "omega"),
    "noise": Parameter(
        "perturbation of the rates", "rad/s", "size of the rate noise", "noise", lowest=0.0
    ),
    **_of_each_axis(
        "noise#",
        r"perturbation of $\omega_#$",
        "rad/s",
        "size of the noise of rate #",
        "noise",
        lowest=0.0,
    ),
    "attitude_noise": Parameter(
        "perturbation of the attitude",
        "rad",
        "size of the attitude noise",
        "attitude_noise",
        lowest=0.0,
    ),
    **_of_each_axis(
        "attitude_noise#",
        "perturbation of the attitude about axis #",
        "rad",
        "size of component # of the rotation vector of the attitude noise",
        "attitude_noise",
        lowest=0.0,
    ),
    "kappa": Parameter(
        r"$\kappa$", "1", "concentration of the direction of the rates", "noise", lowest=0.0
    ),
    "attitude_kappa": Parameter(
        r"$\kappa$ of the attitude",
        "1",
        "concentration of the direction of the axis of the start",
        "attitude_noise",
        lowest=0.0,
    ),
    "limit": Parameter(
        "limit",
        "rad",
        "angle that the criterion allows",
        OF_RUN,
        lowest=0.0,
        highest=pi,
        open_end=True,
    ),
    "t_end": Parameter("$t_{end}$", "s", "horizon", OF_RUN, lowest=0.0, open_end=True),
}
"""The parameters by name, in the order of messages and of the documentation."""

MOST_AXES = 32
"""Most axes of a map: all versions of NumPy allow as many."""

EXCLUSIVE = (
    ("box", "moments", "the moments of a box follow from its sides"),
    ("semi-axes", "moments", "the moments of an ellipsoid follow from its semi-axes"),
    ("semi-axes", "box", "both say which shape the body has"),
    ("com angles", "com", "both say where the centre of mass is"),
)
"""Places whose parameters exclude each other, and why."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a map: a parameter name and its values, increasing or decreasing."""

    name: str
    values: tuple[float, ...]
    own: bool = False
    """Whether the axis is an argument of the function that makes the scene."""

    @property
    def parameter(self) -> Parameter:
        """The row of :data:`PARAMETERS` that the axis varies."""
        return _own_parameter(self.name) if self.own else PARAMETERS[self.name]

    @property
    def unit(self) -> str:
        """Unit of the values (SI, or any consistent set)."""
        return self.parameter.unit

    @property
    def label(self) -> str:
        """Symbol and unit for a plot."""
        symbol = self.parameter.symbol
        return symbol if self.unit == "1" else f"{symbol} ({self.unit})"

    @property
    def geometric(self) -> bool:
        """Whether the values form a geometric progression, which is drawn on a logarithmic axis."""
        values = np.array(self.values)
        if values.size < 3 or values.min() <= 0.0:
            return False
        steps = np.diff(np.log(values))
        return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        count = f"{len(self.values)} values{', geometric' if self.geometric else ''}"
        return f"{self.name} from {self.values[0]:g} to {self.values[-1]:g}{unit} ({count})"


def _own_parameter(name: str) -> Parameter:
    """The parameter of a function that makes the scene."""
    return Parameter(name, "1", "argument of the function of the scene", "function")


def make_axes(axes: Mapping[str, ArrayLike], own: Container[str] = ()) -> tuple[Axis, ...]:
    """The axes of a map from names and values; x first, then y.

    The names in ``own`` are arguments of the function that makes the scene.

    Raises
    ------
    ValueError
        For an unknown name, no axes or more than 32, or values that are not finite, not
        one-dimensional, not strictly increasing or decreasing, or out of range.
    """
    if not isinstance(axes, Mapping):
        raise TypeError(f"axes = {brief(axes)}: must be a dict of names and values")
    if not 1 <= len(axes) <= MOST_AXES:
        raise ValueError(
            f"axes: expected 1 to {MOST_AXES} parameters (x, then y, ...), got {len(axes)}"
        )
    return tuple(_axis(name, values, name in own) for name, values in axes.items())


def check_axis_name(name: str) -> None:
    """Raise ValueError if no parameter of a map has this name."""
    if name not in PARAMETERS:
        raise ValueError(f"axes: unknown parameter {brief(name)}{of_known(name, PARAMETERS)}")


def _axis(name: str, values: ArrayLike, own: bool) -> Axis:
    if not own:
        check_axis_name(name)
    array = numbers(f"axes[{name!r}]", values, None if own else PARAMETERS[name].unit)
    if array.ndim != 1 or array.size == 0:
        raise ValueError(f"axes[{name!r}]: expected shape (n,) with n >= 1, got {array.shape}")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array))[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]}: must be finite")
    steps = np.diff(array)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError(f"axes[{name!r}]: must increase or decrease strictly")
    axis = Axis(name, tuple(array.tolist()), own)
    rejected = np.flatnonzero(axis.parameter.rejects(array))
    if rejected.size:
        bad = int(rejected[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]:g}: {axis.parameter.rule}")
    return axis


def check_applicable(scene: Scene, start: Start, axes: Iterable[Axis]) -> None:
    """Raise ValueError, with the reason, if an axis or a part of the start has no meaning here."""
    if not scene.rates_need_attitude and start.attitude_noise is not None:
        raise ValueError(f"attitude_noise = {start.attitude_noise.describe()}: {_ATTITUDE_UNFELT}")
    if not scene.rates_need_attitude and start.noise is not None and start.joint:
        raise ValueError(f"noise = {start.noise.describe()}: {_ATTITUDE_UNFELT}")
    if not scene.directions and start.omega is not None and start.tilt != 0.0:
        raise ValueError("tilt: has no effect on a free body started by omega; use Start(spin=...)")
    axes = tuple(axes)
    for axis in axes:
        reason = axis.parameter.why_not(scene, start)
        if reason:
            raise ValueError(f"axes: {axis.name!r} does not apply: {reason}")
    for one, other, reason in EXCLUSIVE:
        _check_exclusive(_at(axes, one), _at(axes, other), reason)
    for place in ("noise", "attitude_noise"):
        mine = _at(axes, place)
        whole, parts = (
            [a for a in mine if bool(a.parameter.index) is part] for part in (False, True)
        )
        _check_exclusive(whole, parts, "both say how large the noise is")
    _check_moments(_at(axes, "moments"))


def _at(axes: Iterable[Axis], place: str) -> list[Axis]:
    """The axes whose numbers are in this place."""
    return [axis for axis in axes if axis.parameter.place == place]


def _check_exclusive(first: Sequence[Axis], second: Sequence[Axis], reason: str) -> None:
    """Raise ValueError if there are axes of both kinds."""
    if first and second:
        raise ValueError(
            f"axes: {second[0].name!r} and {first[0].name!r} exclude each other: {reason}"
        )


def _check_moments(axes: Sequence[Axis]) -> None:
    """Raise ValueError if axes set one moment twice or give a ratio of moments twice."""
    setters: dict[int | None, Axis] = {}
    for axis in axes:
        (moment,) = axis.parameter.index
        if moment in setters:
            both = f"{setters[moment].name!r} and {axis.name!r}"
            raise ValueError(f"axes: {both} both set I{moment + 1}")
        setters[moment] = axis
    for axis in axes:
        seen, at = [axis.name], axis.parameter.times
        while at in setters:
            if setters[at] is axis:
                both = " and ".join(map(repr, seen))
                what = "the same ratio" if len(seen) == 2 else "ratios that depend on each other"
                raise ValueError(f"axes: {both} set {what}")
            seen.append(setters[at].name)
            at = setters[at].parameter.times


def in_order(axes: Sequence[Axis]) -> list[int]:
    """Positions of axes in an order in which each moment is set before it is read."""
    setters = {axis.parameter.index: axis for axis in _at(axes, "moments")}

    def depth(axis: Axis) -> int:
        read = axis.parameter.times
        before = None if read is None else setters.get((read,))
        return 0 if before is None else 1 + depth(before)

    return sorted(range(len(axes)), key=lambda place: depth(axes[place]))


def axis_letter(place: int) -> str:
    """The name of an axis by its place, for tables, files and pictures: x, y, z, axis4, ..."""
    return "xyz"[place] if place < 3 else f"axis{place + 1}"
