"""The grid of a map: parameter names and their values -> arrays with one row for each pixel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import pi, prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import nearest, numbers
from .bodies import box_moments
from .forces import Damping, Torque, checked_damping, outside_of
from .scenes import FreeBody, HeavyTop, Scene
from .starts import Start, tilted_attitude, tilted_rates

Floats = NDArray[np.float64]

__all__ = ["PARAMETERS", "Axis", "Pixels", "make_axes", "outsides", "pixels", "tables"]

_SIDES = ("a", "b", "c")
_MOMENTS = ("I1", "I2", "I3")
_RATES = ("omega1", "omega2", "omega3")
_DAMPINGS = ("damping1", "damping2", "damping3")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A name that an axis of a map may carry."""

    symbol: str
    unit: str
    meaning: str
    lowest: float = -np.inf
    highest: float = np.inf
    open_end: bool = False

    @property
    def rule(self) -> str:
        """What the values must be, in words."""
        if self.highest < np.inf:
            return f"must lie in [{self.lowest:.6g}, {self.highest:.6g}]"
        return "must be positive" if self.open_end else "must not be negative"

    def rejects(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which values are outside the range."""
        low = values <= self.lowest if self.open_end else values < self.lowest
        outside: NDArray[np.bool_] = low | (values > self.highest)
        return outside


PARAMETERS: Mapping[str, Parameter] = {
    **{name: Parameter(f"$I_{name[1]}$", "kg m²", "principal moment") for name in _MOMENTS},
    **{
        f"I{i}/I{j}": Parameter(f"$I_{i}/I_{j}$", "1", "ratio of principal moments")
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i != j
    },
    **{
        name: Parameter(f"side ${name}$", "m", "side of the box", 0.0, open_end=True)
        for name in _SIDES
    },
    "mass": Parameter("mass", "kg", "mass of the box", 0.0, open_end=True),
    "mgl": Parameter("$mgl$", "J", "weight times distance of the centre of mass", 0.0),
    **{
        f"damping{k}": Parameter(f"$c_{k}$", "N m s", f"damping about body axis {k}", 0.0)
        for k in (1, 2, 3)
    },
    "spin": Parameter("spin", "rad/s", "rate about the axis of the start"),
    "tilt": Parameter("tilt", "rad", "angle to the axis of the start", -pi, pi),
    **{
        name: Parameter(rf"$\omega_{name[-1]}$", "rad/s", "rate in body components")
        for name in _RATES
    },
    "noise": Parameter("perturbation of the rates", "rad/s", "size of the rate noise", 0.0),
    "attitude_noise": Parameter(
        "perturbation of the attitude", "rad", "size of the attitude noise", 0.0
    ),
}


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a map: a parameter name and its values, increasing or decreasing."""

    name: str
    values: tuple[float, ...]

    @property
    def unit(self) -> str:
        """Unit of the values (SI, or any consistent set)."""
        return PARAMETERS[self.name].unit

    @property
    def label(self) -> str:
        """Symbol and unit for a plot."""
        parameter = PARAMETERS[self.name]
        return parameter.symbol if self.unit == "1" else f"{parameter.symbol} ({self.unit})"

    @property
    def geometric(self) -> bool:
        """Whether the values form a geometric progression, to be drawn on a logarithmic axis."""
        values = np.array(self.values)
        if values.size < 3 or values.min() <= 0.0:
            return False
        steps = np.diff(np.log(values))
        return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        count = f"{len(self.values)} values{', geometric' if self.geometric else ''}"
        return f"{self.name} from {self.values[0]:g} to {self.values[-1]:g}{unit} ({count})"


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """What every pixel starts from, in C order of the grid: P rows, `float64`.

    Attributes
    ----------
    moments : (P, 3) principal moments
    weight : (P, 3) ``mgl * com``, zero for a free body
    mgl : (P,)
    omega, omega_size : (P, 3) nominal rates and size of their noise, rad/s
    attitude : (P, 4) nominal attitude (w, x, y, z)
    tilt, attitude_size : (P,) rad
    damping : (P, 3, 3), or None if nothing damps
    """

    moments: NDArray[np.float64]
    weight: NDArray[np.float64]
    mgl: NDArray[np.float64]
    omega: NDArray[np.float64]
    omega_size: NDArray[np.float64]
    attitude: NDArray[np.float64]
    tilt: NDArray[np.float64]
    attitude_size: NDArray[np.float64]
    damping: NDArray[np.float64] | None = None


def make_axes(axes: Mapping[str, ArrayLike]) -> tuple[Axis, ...]:
    """The axes of a map from names and values; x first, then y.

    Raises
    ------
    ValueError
        For an unknown name, more than two axes, or values that are not finite, not one-dimensional,
        not strictly increasing or decreasing, or out of the range of the parameter.
    """
    if not isinstance(axes, Mapping):
        raise TypeError(f"axes = {axes!r}: must be a dict of names and values")
    if len(axes) not in (1, 2):
        raise ValueError(f"axes: expected 1 or 2 parameters (x, then y), got {len(axes)}")
    return tuple(_axis(name, values) for name, values in axes.items())


def _axis(name: str, values: ArrayLike) -> Axis:
    if name not in PARAMETERS:
        raise ValueError(
            f"axes: unknown parameter {name!r}{nearest(name, PARAMETERS)}"
            f" (known: {', '.join(PARAMETERS)})"
        )
    array = numbers(f"axes[{name!r}]", values)
    if array.ndim != 1 or array.size == 0:
        raise ValueError(f"axes[{name!r}]: expected shape (n,) with n >= 1, got {array.shape}")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array))[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]}: must be finite")
    steps = np.diff(array)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError(f"axes[{name!r}]: must increase or decrease strictly")
    outside = np.flatnonzero(PARAMETERS[name].rejects(array))
    if outside.size:
        bad = int(outside[0])
        raise ValueError(f"axes[{name!r}][{bad}] = {array[bad]:g}: {PARAMETERS[name].rule}")
    return Axis(name, tuple(array.tolist()))


def check_applicable(scene: Scene, start: Start, axes: Iterable[Axis]) -> None:
    """Raise ValueError, saying why, if an axis or a part of the start has no meaning here."""
    names = [axis.name for axis in axes]
    if isinstance(scene, FreeBody) and start.attitude_noise is not None:
        raise ValueError("attitude_noise has no effect on a free body: only its rates matter")
    if isinstance(scene, FreeBody) and start.omega is not None and start.tilt != 0.0:
        raise ValueError("tilt has no effect on a free body started by omega; use Start(spin=...)")
    for name in names:
        reason = _why_not(name, scene, start)
        if reason:
            raise ValueError(f"axes: {name!r} does not apply: {reason}")
    boxes = [name for name in names if name in (*_SIDES, "mass")]
    moments = [name for name in names if name.startswith("I")]
    if boxes and moments:
        raise ValueError(
            f"axes: {moments[0]!r} and {boxes[0]!r} exclude each other: "
            "the moments of a box follow from its sides"
        )
    targets = [name[:2] for name in moments]
    if len(targets) == 2 and targets[0] == targets[1]:
        raise ValueError(f"axes: {moments[0]!r} and {moments[1]!r} both set {targets[0]}")
    if len(moments) == 2 and all("/" in name and name[-2:] in targets for name in moments):
        raise ValueError(f"axes: {moments[0]!r} and {moments[1]!r} set the same ratio")


def _why_not(name: str, scene: Scene, start: Start) -> str:
    if name in (*_SIDES, "mass") and scene.body.sides is None:
        return "the sides of the body are not known; make it with Body.box(a, b, c)"
    if name in _DAMPINGS and scene.damping is not None and not _is_diagonal(scene.damping):
        return "the damping of the scene is not along the body axes"
    if name == "mgl" and isinstance(scene, FreeBody):
        return "a free body feels no weight; use a HeavyTop"
    if name == "spin" and start.spin is None:
        return "the start is given by omega; use omega1, omega2, omega3 or Start(spin=...)"
    if name == "tilt" and start.spin is None and isinstance(scene, FreeBody):
        return "the start is given by omega; use Start(spin=...)"
    if name in _RATES and start.omega is None:
        return "the start is given by spin; use Start(omega=...)"
    if name == "noise" and start.noise is None:
        return "the start has no noise; say its kind, as in Start(noise=rigid.normal(0))"
    if name == "noise" and start.noise is not None and isinstance(start.noise.size, tuple):
        return "the noise of the start has a size for each component; give it a single one"
    if name == "attitude_noise":
        if isinstance(scene, FreeBody):
            return "the attitude of a free body has no effect; use noise"
        if start.attitude_noise is None:
            return (
                "the start has no attitude noise; say its kind, "
                "as in Start(attitude_noise=rigid.normal(0))"
            )
        if start.attitude_noise.kind == "uniform_attitude":
            return "uniform_attitude() has no size"
    return ""


def grid_shape(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """Shape of the arrays of a map: ``(ny, nx)`` or ``(nx,)``."""
    return tuple(len(axis.values) for axis in reversed(axes))


def pixels(scene: Scene, start: Start, axes: tuple[Axis, ...]) -> Pixels:
    """The nominal start of every pixel of a grid that :func:`check_applicable` accepts."""
    shape = grid_shape(axes)
    count = prod(shape)
    grids = np.meshgrid(*(np.array(axis.values) for axis in axes))
    values: dict[str, NDArray[np.float64]] = {
        axis.name: grid.ravel() for axis, grid in zip(axes, grids, strict=True)
    }

    def column(name: str, default: float) -> NDArray[np.float64]:
        return values.get(name, np.full(count, default))

    tilt = column("tilt", start.tilt)
    upright = np.zeros(count)
    if isinstance(scene, HeavyTop):
        mgl, com = column("mgl", scene.mgl), scene.com
        attitude, rates_tilt = tilted_attitude(start.axis, tilt), upright
    else:
        mgl, com = np.zeros(count), (0.0, 0.0, 0.0)
        attitude, rates_tilt = tilted_attitude(3, upright), tilt
    if start.omega is not None:
        omega = np.stack(
            [column(name, rate) for name, rate in zip(_RATES, start.omega, strict=True)], axis=-1
        )
    else:
        omega = tilted_rates(column("spin", start.spin or 0.0), start.axis, rates_tilt)
    noise_size = 0.0 if start.noise is None else start.noise.size
    omega_size = np.broadcast_to(np.asarray(noise_size, dtype=np.float64), (count, 3)).copy()
    if "noise" in values:
        omega_size[:] = values["noise"][:, np.newaxis]
    attitude_size = 0.0 if start.attitude_noise is None else start.attitude_noise.size
    assert isinstance(attitude_size, float)  # Start admits nothing else
    return Pixels(
        moments=_moments(scene, values, count),
        weight=mgl[:, np.newaxis] * np.array(com),
        mgl=mgl,
        omega=omega,
        omega_size=omega_size,
        attitude=attitude,
        tilt=tilt,
        attitude_size=column("attitude_noise", attitude_size),
        damping=_damping(scene, values, count),
    )


def _is_diagonal(damping: Damping) -> bool:
    matrix = np.array(damping)
    return not np.any(matrix - np.diag(np.diag(matrix)))


def _damping(
    scene: Scene, values: Mapping[str, NDArray[np.float64]], count: int
) -> NDArray[np.float64] | None:
    varied = [name for name in _DAMPINGS if name in values]
    if scene.damping is None and not varied:
        return None
    own = np.zeros((3, 3)) if scene.damping is None else np.array(scene.damping)
    damping: NDArray[np.float64] = np.tile(own, (count, 1, 1))
    for name in varied:
        k = _DAMPINGS.index(name)
        damping[:, k, k] = values[name]
    return damping


def outsides(scene: Scene, rows: Pixels) -> list[_core.Outside] | None:
    """What acts from outside in each pixel; None if nothing does in any."""
    if rows.damping is None and scene.torque is None:
        return None
    damping = np.zeros((1, 3, 3)) if rows.damping is None else rows.damping
    # Pixels of a row mostly share theirs.
    known, places = np.unique(damping.reshape(-1, 9), axis=0, return_inverse=True)
    still = Torque.body((0.0, 0.0, 0.0))
    made = [
        outside_of(scene.torque or still, checked_damping(matrix.reshape(3, 3))) for matrix in known
    ]
    every = [one for one in made if one is not None]
    return [every[place] for place in np.broadcast_to(places.ravel(), len(rows.moments))]


def tables(
    scene: Scene, rows: Pixels, of_pixel: NDArray[np.intp], omega: Floats, attitude: Floats
) -> Iterator[tuple[list[int], dict[str, Any]]]:
    """Bodies of these pixels as the core reads them, those together on which the same acts.

    With each table come the places of its bodies among those given.
    """
    every = outsides(scene, rows)
    groups: dict[_core.Outside | None, list[int]] = {}
    for place, pixel in enumerate(of_pixel):
        groups.setdefault(None if every is None else every[pixel], []).append(place)
    for acting, mine in groups.items():
        table: dict[str, Any] = {
            "scene": scene.kind,
            "moments": rows.moments[of_pixel[mine]],
            "weight": rows.weight[of_pixel[mine]],
            "omega": omega[mine],
            "attitude": attitude[mine],
        }
        yield mine, table if acting is None else {**table, "outside": acting}


def _moments(
    scene: Scene, values: Mapping[str, NDArray[np.float64]], count: int
) -> NDArray[np.float64]:
    body = scene.body
    moments: NDArray[np.float64] = np.tile(np.array(body.moments), (count, 1))
    if body.sides is not None and any(name in values for name in (*_SIDES, "mass")):
        a, b, c = (
            values.get(name, np.full(count, side))
            for name, side in zip(_SIDES, body.sides, strict=True)
        )
        mass = values.get("mass", np.full(count, body.mass))
        moments = box_moments(a, b, c, mass)
    for index, name in enumerate(_MOMENTS):
        if name in values:
            moments[:, index] = values[name]
    ratios = [name for name in values if "/" in name]
    targets = {name[:2] for name in ratios}
    # A ratio whose denominator another ratio sets has to wait for it.
    with np.errstate(over="ignore"):  # a moment that overflows makes an impossible body
        for name in sorted(ratios, key=lambda ratio: ratio[-2:] in targets):
            moments[:, int(name[1]) - 1] = values[name] * moments[:, int(name[4]) - 1]
    return moments
