"""The parameters that an axis of a map may vary: unit, range, and the effect on a pixel.

A new parameter is one row of :data:`PARAMETERS`.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, numbers, of_known
from .._moments import box_moments
from ..model.orbit import MOST_ECCENTRIC, Orbit
from ..model.scene import Scene
from ..model.start import Noise, Start, cos_sin

__all__ = [
    "MOST_AXES",
    "PARAMETERS",
    "Axis",
    "Parameter",
    "PixelValues",
    "axis_letter",
    "check_applicable",
    "check_axis_name",
    "in_order",
    "make_axes",
]

Floats = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class PixelValues:
    """Values that the axes of a map may set, with one row for each pixel.

    Attributes
    ----------
    moments : ndarray, shape (P, 3)
        Principal moments, kg m².
    sides, mass : ndarray, shapes (P, 3), (P,)
        Sides (m) and mass (kg) of a box; NaN for a body that is no box.
    own : dict of str to ndarray, shape (P,)
        The numbers of the scene's own that may vary, such as ``mgl`` (J) of a heavy top; vectors
        have the shape (P, 3).
    com : ndarray, shape (P, 3)
        Components towards the centre of mass, of any length.
    com_tilt, com_turn : ndarray, shape (P, 2)
        Cosine and sine of the angle from axis 3 to the centre of mass, and of its azimuth from
        axis 1 towards axis 2.
    shape : ndarray, shape (P, 2)
        ``a/b`` and ``c/b`` of the homogeneous ellipsoid with these moments; NaN if there is none.
    damping : ndarray, shape (P, 3, 3)
        Damping in the principal axes, N m s.
    torque : ndarray, shape (P, 3)
        Constant torque in the body, N m.
    further : dict of str to ndarray
        The numbers of further forces, such as ``rotor``, that act or that an axis has set.
    spin, tilt : ndarray, shape (P,)
        Rate about the axis of the start (rad/s) and angle to it (rad).
    energy, l_gamma : ndarray, shape (P,)
        Energy (J) and vertical angular momentum (kg m²/s) of the start without noise; NaN if they
        follow from the rates.
    omega : ndarray, shape (P, 3)
        Rates of a start that is given by its rates (rad/s).
    omega_size, attitude_size : ndarray, shape (P, 3)
        Sizes of the noise, rad/s and rad.
    """

    moments: Floats
    sides: Floats
    mass: Floats
    shape: Floats
    own: dict[str, Floats]
    com: Floats
    com_tilt: Floats
    com_turn: Floats
    damping: Floats
    torque: Floats
    further: dict[str, Floats]
    spin: Floats
    tilt: Floats
    energy: Floats
    l_gamma: Floats
    omega: Floats
    omega_size: Floats
    attitude_size: Floats


Apply: TypeAlias = Callable[[PixelValues, Floats], None]
"""Write one value for each pixel into the values of all pixels."""

WhyNot: TypeAlias = Callable[[Scene, Start], str]
"""The reason why a parameter has no meaning for a scene and start; empty if it has a meaning."""


def _anywhere(_scene: Scene, _start: Start) -> str:
    return ""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter that an axis of a map can set.

    Attributes
    ----------
    symbol, unit, meaning : str
        For plots and messages; the unit is ``"1"`` for a ratio.
    apply : callable
        ``apply(pixels, values)`` writes the values of the axis into :class:`PixelValues`.
    why_not : callable
        ``why_not(scene, start)`` is the reason why the parameter does not apply, or empty.
    sets, reads : str or None
        The moment or number of the scene that the parameter sets, if it has another name, and the
        moment that it needs: it is applied after the parameter that sets what it reads.
    force : str or None
        The name of the further force whose numbers the parameter sets.
    describes : str or None
        What the parameter is one of, such as ``"moments"``; some kinds exclude each other.
    of_run : bool
        Whether it is a number of the whole request, such as the horizon, and not one of a body.
    lowest, highest : float
        Range of the values.
    open_end : bool
        Whether the bound ``lowest`` is excluded.
    """

    symbol: str
    unit: str
    meaning: str
    apply: Apply
    why_not: WhyNot = _anywhere
    sets: str | None = None
    reads: str | None = None
    force: str | None = None
    describes: str | None = None
    lowest: float = -np.inf
    highest: float = np.inf
    open_end: bool = False
    of_run: bool = False

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


# What each parameter sets


def _whole(name: str) -> Apply:
    """Replace a whole array."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        setattr(pixels, name, values)

    return apply


def _component(name: str, *index: int) -> Apply:
    """Replace one component of an array."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        getattr(pixels, name)[:, *index] = values

    return apply


def _own(name: str) -> Apply:
    """Replace a number that only this kind of scene has."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        pixels.own[name] = values

    return apply


def _com(name: str) -> Apply:
    """Set one of the two angles of the centre of mass."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        setattr(pixels, name, np.stack(cos_sin(values), axis=1))
        (along, across), (first, second) = pixels.com_tilt.T, pixels.com_turn.T
        pixels.own["com"] = np.stack([across * first, across * second, along], axis=1)

    return apply


def _com_component(index: int) -> Apply:
    """Set one component towards the centre of mass; the direction counts, the length does not."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        pixels.com[:, index] = values
        first, second, third = pixels.com.T
        with np.errstate(invalid="ignore", over="ignore"):
            length = np.sqrt(first * first + second * second + third * third)
            pixels.own["com"] = pixels.com / length[:, np.newaxis]

    return apply


def _box(apply_to_box: Apply) -> Apply:
    """Replace a side or the mass of a box, and let the moments follow."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        apply_to_box(pixels, values)
        a, b, c = pixels.sides.T
        pixels.moments = box_moments(a, b, c, pixels.mass)

    return apply


def _shape(index: int, power: int) -> Apply:
    """Set ``a/b``, or the inverse of ``b/c``, of an ellipsoid; the largest moment stays."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        pixels.shape[:, index] = values**power
        a, c = pixels.shape.T
        long, short, largest = a * a, c * c, pixels.moments[:, 2].copy()
        pixels.moments[:, 0] = largest * (1.0 + short) / (1.0 + long)
        pixels.moments[:, 1] = largest * (long + short) / (1.0 + long)

    return apply


def _further(name: str, *index: int) -> Apply:
    """Set one number of a further force, or all of them."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        numbers = pixels.further.setdefault(name, np.zeros((len(values), 3)))
        numbers[:, *(index or (slice(None),))] = values if index else values[:, np.newaxis]

    return apply


def _orbit(index: int) -> Apply:
    """Set eccentricity or mean anomaly of the orbit, of which the second semi-axis follows."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        numbers = pixels.further["orbit"]
        known = Orbit.of_numbers(numbers)
        numbers[:, index] = values
        changed = Orbit(known.rate, numbers[:, 1], numbers[:, 2], known.normal, known.periapsis)
        pixels.further["orbit"] = changed.numbers

    return apply


def _ratio(i: int, j: int) -> Apply:
    """Set moment ``i`` to a multiple of moment ``j``."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        with np.errstate(over="ignore"):  # a moment that overflows makes an impossible body
            pixels.moments[:, i] = values * pixels.moments[:, j]

    return apply


def _every_component(name: str) -> Apply:
    """Replace all components of an array by one number."""

    def apply(pixels: PixelValues, values: Floats) -> None:
        getattr(pixels, name)[:] = values[:, np.newaxis]

    return apply


def _nothing(_pixels: PixelValues, _values: Floats) -> None:
    """Set nothing in the pixels: the parameter belongs to the whole request."""


# Where each parameter applies

_ATTITUDE_UNFELT = "the attitude of a free body without a torque in space has no effect"


def _needs_box(scene: Scene, _start: Start) -> str:
    if scene.body.sides is None:
        return "the sides of the body are not known; make it with Body.box(a, b, c)"
    return ""


def _needs_free_body(scene: Scene, _start: Start) -> str:
    if scene.directions:
        return f"a {scene.title} has none; use a FreeBody"
    return ""


def _needs_orbit(scene: Scene, _start: Start) -> str:
    if scene.orbit is None:
        return "the scene has no orbit; give it orbit=rigid.Orbit(rate)"
    return ""


def _needs_vertical(scene: Scene, _start: Start) -> str:
    if not scene.directions:
        return "a free body knows no vertical; use a HeavyTop"
    return ""


def _needs_weight(scene: Scene, _start: Start) -> str:
    if "mgl" not in scene.fields:
        return "a free body feels no weight; use a HeavyTop"
    return ""


def _needs_diagonal_damping(scene: Scene, _start: Start) -> str:
    matrix = np.zeros((3, 3)) if scene.damping is None else np.array(scene.damping)
    if np.any(matrix - np.diag(np.diag(matrix))):
        return "the damping of the scene is not along the body axes"
    return ""


def _needs_constant_torque(scene: Scene, _start: Start) -> str:
    if scene.torque is not None and scene.torque.times:
        return "the torque of the scene is a table"
    return ""


def _needs_spin(_scene: Scene, start: Start) -> str:
    if start.spin is None:
        return "the start is given by omega; use omega1, omega2, omega3 or Start(spin=...)"
    return ""


def _needs_spin_or_attitude(scene: Scene, start: Start) -> str:
    if start.attitude is not None:
        return "the attitude of the start is given; use Start(tilt=...)"
    if start.spin is None and not scene.directions:
        return "the start is given by omega; use Start(spin=...)"
    return ""


def _needs_omega(_scene: Scene, start: Start) -> str:
    return "the start is given by spin; use Start(omega=...)" if start.omega is None else ""


def _needs_size_of_noise(_scene: Scene, start: Start) -> str:
    if start.noise is None:
        return "the start has no noise; give a kind, as in Start(noise=rigid.normal(0))"
    if not isinstance(start.noise, Noise):
        return "the start has given samples, which have no size; use Start(noise=rigid.normal(0))"
    if start.noise.cov is not None:
        return "the noise of the start has a covariance; give it a size"
    if start.noise.is_direction:
        return "the noise of the start has a concentration; use kappa"
    return ""


def _needs_kappa(_scene: Scene, start: Start) -> str:
    if not (isinstance(start.noise, Noise) and start.noise.is_direction):
        return "the start has no noise=rigid.von_mises_fisher(0)"
    return ""


def _needs_attitude_kappa(scene: Scene, start: Start) -> str:
    if not scene.rates_need_attitude:
        return f"{_ATTITUDE_UNFELT}; use kappa"
    if start.attitude_noise is None or not start.attitude_noise.is_direction:
        return "the start has no attitude_noise=rigid.von_mises_fisher(0)"
    return ""


def _needs_noise(scene: Scene, start: Start) -> str:
    reason = _needs_size_of_noise(scene, start)
    if reason:
        return reason
    assert isinstance(start.noise, Noise)
    if isinstance(start.noise.size, tuple):
        return "the noise of the start has a size for each component; give it a single one"
    return ""


def _needs_attitude_noise(scene: Scene, start: Start) -> str:
    reason = _needs_size_of_attitude_noise(scene, start)
    if reason:
        return reason
    assert start.attitude_noise is not None
    if isinstance(start.attitude_noise.size, tuple):
        return "the attitude noise has a size for each component; give it a single one"
    return ""


def _needs_size_of_attitude_noise(scene: Scene, start: Start) -> str:
    if not scene.rates_need_attitude:
        return f"{_ATTITUDE_UNFELT}; use noise"
    if start.attitude_noise is None:
        return (
            "the start has no attitude noise; give a kind, "
            "as in Start(attitude_noise=rigid.normal(0))"
        )
    if start.attitude_noise.cov is not None:
        return "the attitude noise has a covariance; give it a size"
    if start.attitude_noise.is_direction:
        return "the attitude noise has a concentration; use attitude_kappa"
    if start.attitude_noise.kind == "uniform_attitude":
        return "uniform_attitude() has no size"
    return ""


PARAMETERS: Mapping[str, Parameter] = {
    **{
        f"I{i}": Parameter(
            f"$I_{i}$",
            "kg m²",
            "principal moment",
            _component("moments", i - 1),
            sets=f"I{i}",
            describes="moments",
        )
        for i in (1, 2, 3)
    },
    **{
        f"I{i}/I{j}": Parameter(
            f"$I_{i}/I_{j}$",
            "1",
            "ratio of principal moments",
            _ratio(i - 1, j - 1),
            sets=f"I{i}",
            reads=f"I{j}",
            describes="moments",
        )
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i != j
    },
    **{
        name: Parameter(
            f"side ${name}$",
            "m",
            "side of the box",
            _box(_component("sides", k)),
            _needs_box,
            describes="box",
            lowest=0.0,
            open_end=True,
        )
        for k, name in enumerate("abc")
    },
    "mass": Parameter(
        "mass",
        "kg",
        "mass of the box",
        _box(_whole("mass")),
        _needs_box,
        describes="box",
        lowest=0.0,
        open_end=True,
    ),
    **{
        name: Parameter(
            f"${name}$",
            "1",
            "ratio of the semi-axes a ≥ b ≥ c, along axes 1, 2, 3, of the homogeneous ellipsoid "
            "with these moments; I3 stays",
            _shape(index, power),
            describes="semi-axes",
            lowest=1.0,
        )
        for name, index, power in (("a/b", 0, 1), ("b/c", 1, -1))
    },
    "mgl": Parameter(
        "$mgl$",
        "J",
        "weight times distance of the centre of mass",
        _own("mgl"),
        _needs_weight,
        lowest=0.0,
    ),
    **{
        f"com{k}": Parameter(
            f"$c_{k}$",
            "1",
            f"component {k} towards the centre of mass; only the direction counts",
            _com_component(k - 1),
            _needs_weight,
            sets="com",
            describes="com component",
        )
        for k in (1, 2, 3)
    },
    "com_tilt": Parameter(
        "tilt of the centre of mass",
        "rad",
        "angle from axis 3 to the centre of mass",
        _com("com_tilt"),
        _needs_weight,
        sets="com",
        describes="com angle",
        lowest=0.0,
        highest=pi,
    ),
    "com_turn": Parameter(
        "turn of the centre of mass",
        "rad",
        "azimuth of the centre of mass, from axis 1 towards axis 2",
        _com("com_turn"),
        _needs_weight,
        sets="com",
        describes="com angle",
        lowest=-2.0 * pi,
        highest=2.0 * pi,
    ),
    **{
        f"damping{k}": Parameter(
            f"damping about axis {k}, $D_{{{k}{k}}}$",
            "N m s",
            f"damping about body axis {k}",
            _component("damping", k - 1, k - 1),
            _needs_diagonal_damping,
            describes="damping",
            lowest=0.0,
        )
        for k in (1, 2, 3)
    },
    **{
        f"torque{k}": Parameter(
            f"$N_{k}$",
            "N m",
            f"constant torque about body axis {k}",
            _component("torque", k - 1),
            _needs_constant_torque,
            describes="torque",
        )
        for k in (1, 2, 3)
    },
    **{
        f"rotor{k}": Parameter(
            f"$h_{k}$",
            "kg m²/s",
            f"angular momentum of the rotor about body axis {k}",
            _further("rotor", k - 1),
            _needs_free_body,
            sets="rotor",
            force="rotor",
        )
        for k in (1, 2, 3)
    },
    "dissipation": Parameter(
        "$P$",
        "kg m² s",
        "coefficient of the energy sink, the same along all axes",
        _further("dissipation"),
        _needs_free_body,
        force="dissipation",
        lowest=0.0,
    ),
    "eccentricity": Parameter(
        "eccentricity $e$",
        "1",
        "eccentricity of the orbit",
        _orbit(1),
        _needs_orbit,
        force="orbit",
        lowest=0.0,
        highest=MOST_ECCENTRIC,
    ),
    "anomaly": Parameter(
        "$M_0$",
        "rad",
        "mean anomaly of the orbit at t = 0",
        _orbit(2),
        _needs_orbit,
        force="orbit",
    ),
    "spin": Parameter(
        "spin", "rad/s", "rate about the axis of the start", _whole("spin"), _needs_spin
    ),
    "tilt": Parameter(
        "tilt",
        "rad",
        "angle to the axis of the start",
        _whole("tilt"),
        _needs_spin_or_attitude,
        lowest=-pi,
        highest=pi,
    ),
    "energy": Parameter(
        "energy",
        "J",
        "energy of the start without noise; the rates are scaled, with `l_gamma` their other part",
        _whole("energy"),
    ),
    "l_gamma": Parameter(
        r"$L\cdot\gamma$",
        "kg m²/s",
        "vertical angular momentum of the start without noise: the part of the rates along the "
        "vertical is set",
        _whole("l_gamma"),
        _needs_vertical,
    ),
    **{
        f"omega{k}": Parameter(
            rf"$\omega_{k}$",
            "rad/s",
            "rate in body components",
            _component("omega", k - 1),
            _needs_omega,
        )
        for k in (1, 2, 3)
    },
    "noise": Parameter(
        "perturbation of the rates",
        "rad/s",
        "size of the rate noise",
        _every_component("omega_size"),
        _needs_noise,
        describes="noise",
        lowest=0.0,
    ),
    **{
        f"noise{k}": Parameter(
            rf"perturbation of $\omega_{k}$",
            "rad/s",
            f"size of the noise of rate {k}",
            _component("omega_size", k - 1),
            _needs_size_of_noise,
            describes="noise component",
            lowest=0.0,
        )
        for k in (1, 2, 3)
    },
    "attitude_noise": Parameter(
        "perturbation of the attitude",
        "rad",
        "size of the attitude noise",
        _every_component("attitude_size"),
        _needs_attitude_noise,
        describes="attitude noise",
        lowest=0.0,
    ),
    **{
        f"attitude_noise{k}": Parameter(
            f"perturbation of the attitude about axis {k}",
            "rad",
            f"size of component {k} of the rotation vector of the attitude noise",
            _component("attitude_size", k - 1),
            _needs_size_of_attitude_noise,
            describes="attitude noise component",
            lowest=0.0,
        )
        for k in (1, 2, 3)
    },
    "kappa": Parameter(
        r"$\kappa$",
        "1",
        "concentration of the direction of the rates",
        _every_component("omega_size"),
        _needs_kappa,
        lowest=0.0,
    ),
    "attitude_kappa": Parameter(
        r"$\kappa$ of the attitude",
        "1",
        "concentration of the direction of the axis of the start",
        _every_component("attitude_size"),
        _needs_attitude_kappa,
        lowest=0.0,
    ),
    "limit": Parameter(
        "limit",
        "rad",
        "angle that the criterion allows",
        _nothing,
        lowest=0.0,
        highest=pi,
        open_end=True,
        of_run=True,
    ),
    "t_end": Parameter(
        "$t_{end}$", "s", "horizon", _nothing, lowest=0.0, open_end=True, of_run=True
    ),
}
"""The parameters by name, in the order of messages and of the documentation."""

MOST_AXES = 32
"""Most axes of a map: all versions of NumPy allow as many."""

EXCLUSIVE = (
    ("box", "moments", "the moments of a box follow from its sides"),
    ("semi-axes", "moments", "the moments of an ellipsoid follow from its semi-axes"),
    ("semi-axes", "box", "both say which shape the body has"),
    ("com angle", "com component", "both say where the centre of mass is"),
    ("noise", "noise component", "both say how large the noise is"),
    ("attitude noise", "attitude noise component", "both say how large the noise is"),
)
"""Kinds of parameters that exclude each other, and why."""


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
    return Parameter(name, "1", "argument of the function of the scene", _nothing)


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
        first, second = (
            [axis.name for axis in axes if axis.parameter.describes == kind]
            for kind in (one, other)
        )
        if first and second:
            raise ValueError(f"axes: {second[0]!r} and {first[0]!r} exclude each other: {reason}")
    _check_moments([axis for axis in axes if axis.parameter.describes == "moments"])


def _check_moments(axes: Sequence[Axis]) -> None:
    """Raise ValueError if axes set one moment twice or give a ratio of moments twice."""
    setters: dict[str, Axis] = {}
    for axis in axes:
        moment = axis.parameter.sets
        assert moment is not None
        if moment in setters:
            raise ValueError(f"axes: {setters[moment].name!r} and {axis.name!r} both set {moment}")
        setters[moment] = axis
    for axis in axes:
        seen, at = [axis.name], axis.parameter.reads
        while at in setters:
            if setters[at] is axis:
                both = " and ".join(map(repr, seen))
                what = "the same ratio" if len(seen) == 2 else "ratios that depend on each other"
                raise ValueError(f"axes: {both} set {what}")
            seen.append(setters[at].name)
            at = setters[at].parameter.reads


def in_order(axes: Iterable[Axis]) -> list[int]:
    """Positions of axes in an order in which each moment is set before it is read."""
    every = list(axes)
    setters = {axis.parameter.sets: axis for axis in every}

    def depth(axis: Axis) -> int:
        before = setters.get(axis.parameter.reads) if axis.parameter.reads else None
        return 0 if before is None else 1 + depth(before)

    return sorted(range(len(every)), key=lambda place: depth(every[place]))


def axis_letter(place: int) -> str:
    """The name of an axis by its place, for tables, files and pictures: x, y, z, axis4, ..."""
    return "xyz"[place] if place < 3 else f"axis{place + 1}"
