"""The parameters of scenes and starts: unit, range, the numbers that they set, and derivatives.

Axes of maps, tangents and fits know a parameter by its name. A new parameter is one row of
:data:`PARAMETERS`; the rows of a further force follow from its class.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arrays import Floats
from .._checks.moments import box_moments
from .body import Body
from .forces import FORCES, Force, Guess, tenth_of_moment
from .noise import Noise
from .orbit import HYPERBOLA, MOST_ECCENTRIC
from .sampled import Sampled
from .scene import HeavyTop, Scene
from .start import Start, cos_sin
from .torque import Torque

OF_RUN = "run"
"""The place of numbers of the whole request, such as the horizon, which no body has."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a scene or a start.

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
    number, value : callable or None
        The number in its place as a function of the value, if it is another one, and the value as a
        function of the number. None of an angle, whose bits would depend on the machine.
        A motion has no derivative by a parameter with such a number.
    lowest, highest : float
        Range of the values.
    open_end : bool
        Whether the bound ``lowest`` is excluded.
    gap : tuple of float, or None
        Ends of an open interval inside the range that has no values.
    """

    symbol: str
    unit: str
    meaning: str
    place: str
    index: tuple[int, ...] = ()
    times: int | None = None
    number: Callable[[Floats], Any] | None = None
    value: Callable[[Floats], Any] | None = None
    lowest: float = -np.inf
    highest: float = np.inf
    open_end: bool = False
    gap: tuple[float, float] | None = None

    @property
    def rule(self) -> str:
        """The rule for the values."""
        if self.gap is not None:
            below, above = self.gap
            return f"must lie in [{self.lowest:.6g}, {below:g}] or [{above:g}, {self.highest:.6g}]"
        if self.highest < np.inf:
            return f"must lie in [{self.lowest:.6g}, {self.highest:.6g}] ({self.unit})"
        if self.lowest > 0.0:
            return f"must be at least {self.lowest:g}"
        return "must be positive" if self.open_end else "must not be negative"

    def rejects(self, values: Floats) -> NDArray[np.bool_]:
        """Which values are out of range."""
        low = values <= self.lowest if self.open_end else values < self.lowest
        rejected: NDArray[np.bool_] = low | (values > self.highest)
        if self.gap is not None:
            rejected |= (values > self.gap[0]) & (values < self.gap[1])
        return rejected

    def why_not(self, scene: Scene, start: Start) -> str:
        """The reason why an axis cannot set it for a scene and start; empty if it can."""
        return PLACES[self.place].why_not(scene, start, self) if self.place in PLACES else ""

    def has_derivative(self, scene: Scene) -> bool:
        """Whether the motion of a scene has a derivative by the parameter."""
        place = PLACES.get(self.place)
        if place is None or place.first is None or (self.times, self.number) != (None, None):
            return False
        if self.place in FORCES:
            # A rotor by a table may be larger at all times, an orbit by a table has no numbers.
            is_table = self.place == "orbit" and isinstance(scene.orbit, Sampled)
            return self.place in scene.forces and not is_table
        return self.place not in OF_WEIGHT or "mgl" in scene.fields

    def change(self, scene: Scene) -> tuple[int, Floats]:
        """The change of the numbers of the core by the parameter.

        Returns the place of the first number, and the derivatives of the numbers from there on,
        shape (..., k).
        """
        place = PLACES[self.place]
        assert place.first is not None
        slopes = place.slopes(scene)
        return place.first, slopes[..., self.index[0]] if self.index else slopes.sum(axis=-1)

    def sets(self, name: str) -> tuple[str, ...]:
        """The names of the numbers that the parameter of this name sets."""
        if self.times is not None:
            return (f"I{self.index[0] + 1}",)
        return (self.place in PLACES and PLACES[self.place].sets) or (name,)

    def get(self, numbers: Mapping[str, Floats]) -> Floats:
        """Its values among the numbers of all bodies; of all components, shape (components, n).

        A parameter whose number is not its value, and that has no ``value``, is not asked for.
        """
        every: Any = numbers[self.place]
        found: Floats = every[:, *self.index].T.copy()
        if self.value is not None:
            found = self.value(found)
        return found if self.times is None else found / every[:, self.times]

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

ATTITUDE_UNFELT = "the attitude of a free body without a torque in space has no effect"


def _anywhere(_scene: Scene, _start: Start, _asked: Parameter) -> str:
    return ""


def _needs_box(scene: Scene, _start: Start, _asked: Parameter) -> str:
    if scene.body.sides is None:
        return "the sides of the body are not known; make it with Body.box(a, b, c)"
    return ""


def _needs_free_body(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return f"a {scene.title} has none; use a FreeBody" if scene.directions else ""


def _needs_orbit(scene: Scene, start: Start, asked: Parameter) -> str:
    if scene.orbit is None:
        return "the scene has no orbit; give it orbit=rigid.Orbit(rate)"
    return _needs_constant(scene, start, asked)


def _needs_vertical(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return "" if scene.directions else "a free body knows no vertical; use a HeavyTop"


def _needs_weight(scene: Scene, _start: Start, _asked: Parameter) -> str:
    return "" if "mgl" in scene.fields else "a free body feels no weight; use a HeavyTop"


def _needs_diagonal_damping(scene: Scene, _start: Start, _asked: Parameter) -> str:
    if scene.damping is not None and np.any(np.asarray(scene.damping) * (1.0 - np.eye(3))):
        return "the damping of the scene is not along the body axes"
    return ""


def _needs_constant_torque(scene: Scene, _start: Start, _asked: Parameter) -> str:
    is_table = scene.torque is not None and scene.torque.times
    return "the torque of the scene is a table" if is_table else ""


def _needs_constant(scene: Scene, start: Start, asked: Parameter) -> str:
    if isinstance(getattr(scene, asked.place), Sampled):
        return f"the {asked.place} of the scene is a table"
    return _needs_free_body(scene, start, asked)


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
        return f"{ATTITUDE_UNFELT}; use {'kappa' if is_kappa else 'noise'}"
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


def _alike(_scene: Scene) -> Floats:
    return np.eye(3)


@dataclass(frozen=True, slots=True)
class Place:
    """Numbers of a scene or a start that parameters set.

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
    first : int or None
        Where the core keeps the first of the numbers that they change; None if a motion has no
        derivative by them.
    slopes : callable
        ``slopes(scene)``: the derivatives of these numbers of the core, shape (..., k, numbers).
    guess : Guess or None
        How far off the first guess of a fit may be; None if no fit takes it.
    """

    read: Callable[[Any, Start], ArrayLike]
    width: int
    why_not: Callable[[Scene, Start, Parameter], str] = _anywhere
    sets: tuple[str, ...] = ()
    first: int | None = None
    slopes: Callable[[Any], Floats] = _alike
    guess: Guess | None = None


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


def _damping(scene: Scene, _start: Start) -> Floats:
    damping = scene.damping
    return np.zeros(3) if damping is None else np.diagonal(damping, axis1=-2, axis2=-1)


def _further(name: str) -> Place:
    """The place of the coefficients, or of the vector, of a further force."""
    force = FORCES[name]

    def read(scene: Scene, _start: Start) -> Floats:
        value = getattr(scene, name)
        return np.zeros(3) if value is None else np.asarray(force.numbers(value))

    why_not = _anywhere if name in HeavyTop.__slots__ else _needs_constant
    return Place(read, 1, why_not, (name,), force.first, guess=force.guess)


def _slopes_of_weight(scene: Any) -> Floats:
    return np.asarray(scene.com)[..., np.newaxis]


def _slopes_of_com(scene: Any) -> Floats:
    return np.asarray(scene.mgl)[..., np.newaxis, np.newaxis] * np.eye(3)


def _slopes_of_orbit(scene: Scene) -> Floats:
    """Of rate, eccentricity and anomaly; the second semi-axis, sqrt(1 - e²) long, changes too."""
    assert scene.orbit is not None
    numbers = np.asarray(scene.orbit.numbers)
    e = numbers[..., 1:2]
    slopes = np.broadcast_to(np.eye(9, 3), (*numbers.shape, 3)).copy()
    slopes[..., 6:, 1] = -e / (1.0 - e * e) * numbers[..., 6:]
    return slopes


def _size_of_noise(_scene: Scene, start: Start) -> Floats:
    return np.broadcast_to(start.noise.size if isinstance(start.noise, Noise) else 0.0, 3)


def _size_of_attitude_noise(_scene: Scene, start: Start) -> Floats:
    size = 0.0 if start.attitude_noise is None else start.attitude_noise.size
    return np.broadcast_to(1.0 if start.joint else size, 3)


OF_WEIGHT = ("mgl", "com")
"""Places that only a scene with weight has."""

AT_REST = Start(omega=(0.0, 0.0, 0.0))
"""A start for numbers of the scene alone."""

OF_START = ("spin", "tilt", "energy", "l_gamma", "omega", "noise", "attitude_noise")
"""Places of numbers of a start."""

PLACES: Mapping[str, Place] = {
    "moments": Place(lambda scene, _: scene.body.moments, 1, first=0),
    "box": Place(lambda scene, _: (*scene.body.sides, scene.body.mass), 1, _needs_box),
    "semi-axes": Place(_semi_axes, 1, sets=("I1", "I2")),
    "mgl": Place(
        lambda scene, _: scene.mgl,
        0,
        _needs_weight,
        first=3,
        slopes=_slopes_of_weight,
        guess=lambda mgl, moment, rate: float(mgl) or moment * rate**2,
    ),
    "com": Place(lambda scene, _: scene.com, 1, _needs_weight, ("com",), 3, _slopes_of_com),
    "com angles": Place(_angles_of_com, 2, _needs_weight, ("com",)),
    "damping": Place(_damping, 1, _needs_diagonal_damping, first=6, guess=tenth_of_moment(1)),
    "torque": Place(_torque_in_body, 1, _needs_constant_torque, first=12, guess=tenth_of_moment(2)),
    **{name: _further(name) for name in FORCES if name != "orbit"},
    "orbit": Place(
        lambda scene, _: scene.orbit.numbers[..., :3],
        1,
        _needs_orbit,
        first=FORCES["orbit"].first,
        slopes=_slopes_of_orbit,
        guess=FORCES["orbit"].guess,
    ),
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
        found[own] = Parameter(words[0], words[1], words[2], place, (k,), lowest=lowest)
    return found


def _of_all_and_each(
    name: str, unit: str, of_all: tuple[str, str], of_each: tuple[str, str]
) -> dict[str, Parameter]:
    """A parameter of all body axes, and one for each, by symbol and meaning; not negative."""
    symbol, meaning = of_all
    each = _of_each_axis(f"{name}#", of_each[0], unit, of_each[1], name, lowest=0.0)
    return {name: Parameter(symbol, unit, meaning, name, lowest=0.0), **each}


def _of_force(force: Force[Any]) -> dict[str, Parameter]:
    """The parameters of the coefficients, or of the vector, of a further force."""
    name, unit = force.name, force.unit
    if force.of_each is None:
        return {}
    if force.of_all is not None:
        return _of_all_and_each(name, unit, force.of_all, force.of_each)
    symbol, meaning = force.of_each
    return _of_each_axis(f"{name}#", symbol, unit, meaning, name)


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
            value=number,  # the reciprocal is its own inverse
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
    **_of_all_and_each(
        "damping",
        "N m s",
        ("damping", "damping, the same about all body axes"),
        ("damping about axis #, $D_{##}$", "damping about body axis #"),
    ),
    **_of_each_axis("torque#", "$N_#$", "N m", "constant torque about body axis #", "torque"),
    **{
        name: row
        for force in sorted(FORCES.values(), key=lambda force: not force.is_vector)
        for name, row in _of_force(force).items()
    },
    "rate": Parameter(
        "rate $n$", "rad/s", "rate of the orbit", "orbit", (0,), lowest=0.0, open_end=True
    ),
    "eccentricity": Parameter(
        "eccentricity $e$",
        "1",
        "eccentricity of the orbit",
        "orbit",
        (1,),
        lowest=0.0,
        highest=HYPERBOLA[1],
        gap=(MOST_ECCENTRIC, HYPERBOLA[0]),
    ),
    "anomaly": Parameter("$M_0$", "rad", "mean anomaly of the orbit at t = 0", "orbit", (2,)),
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
    **_of_all_and_each(
        "noise",
        "rad/s",
        ("perturbation of the rates", "size of the rate noise"),
        (r"perturbation of $\omega_#$", "size of the noise of rate #"),
    ),
    **_of_all_and_each(
        "attitude_noise",
        "rad",
        ("perturbation of the attitude", "size of the attitude noise"),
        (
            "perturbation of the attitude about axis #",
            "size of component # of the rotation vector of the attitude noise",
        ),
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


# Scenes from numbers


def numbers_of(scene: Scene, start: Start, places: Iterable[str], count: int) -> dict[str, Floats]:
    """A copy of the numbers in these places, a row for each of so many bodies."""
    found = {}
    for name in places:
        place = PLACES[name]
        array = np.asarray(place.read(scene, start), dtype=np.float64)
        own = array.shape[array.ndim - place.width :]
        found[name] = np.broadcast_to(array, (count, *own)).copy()
    return found


def moments_of(numbers: Mapping[str, Floats]) -> Floats:
    """The principal moments of the bodies with these numbers."""
    if "box" in numbers:
        return box_moments(*numbers["box"].T)
    moments = numbers["moments"]
    if "semi-axes" in numbers:
        a, c = numbers["semi-axes"].T
        long, short, largest = a * a, c * c, moments[:, 2].copy()
        moments[:, 0] = largest * (1.0 + short) / (1.0 + long)
        moments[:, 1] = largest * (long + short) / (1.0 + long)
    return moments


def scene_of(scene: Scene, numbers: Mapping[str, Floats], moments: Floats) -> Scene:
    """The scene of the bodies with these moments and numbers, like a scene in all else.

    Raises
    ------
    ValueError
        If all components of the direction to a centre of mass are zero.
    """
    own: dict[str, Any] = {
        name: force.varied(getattr(scene, name), numbers[name])
        for name, force in FORCES.items()
        if name in numbers
    }
    if "mgl" in numbers:
        own["mgl"] = numbers["mgl"]
    if "damping" in numbers:
        own["damping"] = numbers["damping"][:, :, np.newaxis] * np.eye(3)
    elif scene.damping is not None:
        own["damping"] = np.broadcast_to(np.asarray(scene.damping), (len(moments), 3, 3))
    if "com angles" in numbers:
        (along, across), (first, second) = np.moveaxis(numbers["com angles"], 0, -1)
        own["com"] = np.stack([across * first, across * second, along], axis=1)
    if "com" in numbers:
        first, second, third = numbers["com"].T
        with np.errstate(invalid="ignore", over="ignore"):
            length = np.sqrt(first * first + second * second + third * third)
            own["com"] = numbers["com"] / length[:, np.newaxis]
        if not np.isfinite(own["com"]).all():
            raise ValueError("axes: com1, com2 and com3 must not all be zero: they are a direction")
    if "torque" in numbers:
        part = Torque.body(numbers["torque"])
        if scene.torque is not None:
            in_space = np.broadcast_to(scene.torque.in_space, np.shape(part.in_body))
            part = replace(part, in_space=in_space, function=scene.torque.function)
        own["torque"] = part
    body = Body(moments, physical=scene.body.physical)
    made: Scene = replace(scene, body=body, **own)  # type: ignore[type-var]
    return made
