"""The pixels of a map: a scene of many bodies, one for each pixel, and their nominal starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import prod
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.float_environment import in_standard_floats
from .._moments import box_moments, rods, without_spin
from ..model.body import Body, rates_of_rods
from ..model.forces import FORCES, EnergySink
from ..model.leading import axes_of
from ..model.orbit import Orbit
from ..model.scene import Scene
from ..model.start import Noise, Start, tilted_attitude, tilted_rates
from ..model.torque import Torque, forces_of
from ..rotations.apply import to_body
from ..solve.bodies import Bodies
from .parameters import PLACES, Axis, in_order

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Pixels:
    """Bodies and starts of all P pixels in C order of the grid, as read-only arrays of `float64`.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
        The scene of P bodies. A sphere stands where no body can have the moments.
    moments : (P, 3) principal moments, possible or not
    weight : (P, 3) ``mgl * com``; zero for free bodies
    omega, omega_size : (P, 3) nominal rates and size of their noise, rad/s
    attitude : (P, 4) nominal attitude (w, x, y, z)
    tilt : (P,) rad
    attitude_size : (P, 3) sizes of the rotation vectors of the attitude noise, rad
    acting : the names of the forces that act in some pixel of the whole map
    """

    scene: Scene
    moments: Floats
    weight: Floats
    omega: Floats
    omega_size: Floats
    attitude: Floats
    tilt: Floats
    attitude_size: Floats
    acting: tuple[str, ...]

    def __post_init__(self) -> None:
        for column in fields(self):
            array = getattr(self, column.name)
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def physical(self) -> bool:
        """Whether a body must be able to have the moments."""
        return self.scene.body.physical

    @cached_property
    def moving(self) -> Floats:
        """The moments, shape (P, 3), by which the core moves the bodies: rods as spheres."""
        return without_spin(self.moments)

    @cached_property
    def status(self) -> NDArray[np.uint8]:
        """The status of the moments of each pixel: 0 where they are taken, else the broken rule."""
        return _core.moment_status(self.moving, self.physical)

    @property
    def possible(self) -> NDArray[np.bool_]:
        """Where a body can have the moments."""
        known: NDArray[np.bool_] = self.status == 0
        return known

    @property
    def damping(self) -> Floats:
        """The damping matrices, shape (P, 3, 3); zero where nothing damps."""
        known = self.scene.damping
        return _each(np.zeros((3, 3)) if known is None else known, 2, len(self.moments))

    @cached_property
    def _forces(self) -> _core.Forces | None:
        """The forces on all pixels; None if no pixel has any."""
        if not self.acting:
            return None
        scene, torque = self.scene, self.scene.torque
        # Under a torque of zero, bodies without damping are integrated like their neighbours. Under
        # an orbit alone all bodies are integrated without a balance.
        if torque is None and {*self.acting} != {"orbit"}:
            torque = Torque.body((0.0, 0.0, 0.0))
        return forces_of(torque, scene.damping, scene.shape, further=scene.further_numbers())

    @cached_property
    def forces(self) -> list[_core.Forces] | None:
        """The forces on each pixel; None if no pixel has any."""
        if self._forces is None:
            return None
        torque, count = self.scene.torque, len(self.moments)
        parts: list[tuple[Any, int]] = [
            (self.scene.damping, 2),
            *((n, 1) for n in self.scene.further_numbers().values()),
        ]
        if torque is not None:
            parts += [(torque.in_body, 2), (torque.in_space, 2)]
            parts += [] if torque.function is None else [(torque.function.data, 1)]
        rows = [_each(part, width, count) for part, width in parts if axes_of(part, width)]
        if not rows:
            return [self._forces] * count
        # Pixels of a row mostly share theirs.
        every = np.concatenate([row.reshape(count, -1) for row in rows], axis=1)
        _, first, of_pixel = np.unique(every, axis=0, return_index=True, return_inverse=True)
        known = [self._forces.select(np.array([pixel])) for pixel in first]
        return [known[k] for k in of_pixel.ravel()]

    def bodies(self, of_pixel: NDArray[np.intp], omega: Floats, attitude: Floats) -> Bodies:
        """Bodies of these pixels, shape (n,), with their starts.

        Parameters
        ----------
        of_pixel : ndarray of int, shape (n,)
            The pixel of each body.
        omega, attitude : ndarray, shapes (n, 3), (n, 4)
            Rad/s in the body; quaternions (w, x, y, z).

        Returns
        -------
        Bodies
        """
        return Bodies(
            kind=self.scene.kind,
            shape=(len(of_pixel),),
            moments=self.moving[of_pixel],
            weight=self.weight[of_pixel],
            omega=omega,
            attitude=attitude,
            forces=None if self._forces is None else self._forces.select(of_pixel),
        )

    def of_pixels(self, pixels: NDArray[np.int64]) -> Pixels:
        """The rows of some pixels."""
        columns = {column.name: getattr(self, column.name) for column in fields(self)}
        some: dict[str, Any] = {
            name: column[pixels]
            for name, column in columns.items()
            if isinstance(column, np.ndarray)
        }
        return replace(self, scene=self.scene[pixels], **some)


def grid_shape(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """Shape of the arrays of a map: ``(..., ny, nx)``, the first axis last."""
    return tuple(len(axis.values) for axis in reversed(axes))


def acting_forces(scene: Scene, axes: tuple[Axis, ...]) -> tuple[str, ...]:
    """The names of the forces of a scene, and of those that axes set."""
    varied = {axis.parameter.place for axis in axes}
    further = (name for name in ("torque", "damping", *FORCES) if name in varied)
    return tuple(dict.fromkeys((*scene.forces, *further)))


@in_standard_floats
def nominal_starts(
    scene: Scene,
    start: Start,
    axes: tuple[Axis, ...] = (),
    index: NDArray[np.int64] | None = None,
    given: Mapping[str, Floats] = MappingProxyType({}),
) -> Pixels:
    """The pixels of a grid that :func:`check_applicable` accepts.

    Without axes there is one pixel: the nominal start of the scene. With ``index`` only the pixels
    with these numbers in C order are made, a row for each. If a function of the user makes the
    scene, it is the scene of all pixels, and ``given`` has the rates and attitudes of all pixels
    that the function gives.
    """
    shape = grid_shape(axes)
    flat = np.arange(prod(shape)) if index is None else index
    count, forces, acting = len(flat), scene.forces, acting_forces(scene, axes)
    if index is not None:
        scene = scene[index] if scene.shape else scene
        given = {name: rows[index] for name, rows in given.items()}
    values = _values(scene, start, {axis.parameter.place for axis in axes}, count)
    if "omega" in given:
        values["omega"] = given["omega"].copy()
    places = list(reversed(np.unravel_index(flat, shape))) if axes else []
    for k in in_order(axes):
        axes[k].parameter.put(values, np.array(axes[k].values)[places[k]])
    moments = _moments(values)
    possible = _core.moment_status(without_spin(moments), scene.body.physical) == 0
    body = Body(np.where(possible[:, np.newaxis], moments, 1.0), physical=scene.body.physical)
    damping = values.get("damping", scene.damping)
    if damping is not None:
        damping = _each(damping, 2, count)
    scene = scene.replaced(body, damping, **_changes(scene, values))
    upright = np.zeros(count)
    if scene.directions:
        attitude, rates_tilt = tilted_attitude(start.axis, values["tilt"]), upright
    else:
        attitude, rates_tilt = tilted_attitude(3, upright), values["tilt"]
    if start.attitude is not None:
        attitude = np.tile(start.attitude, (count, 1))
    attitude = given["attitude"].copy() if "attitude" in given else attitude
    omega = values["omega"]
    if start.omega is None:
        omega = tilted_rates(values["spin"], start.axis, rates_tilt)
    weight = _each(scene.weight, 1, count)
    moments, omega = _on_surface(values, moments, weight, omega, attitude)
    omega = rates_of_rods("start: omega", omega, moments, weight, forces)
    _check_noise_of_rods(moments, values["noise"], start.noise)
    return Pixels(
        scene=scene,
        moments=moments,
        weight=weight,
        omega=omega,
        omega_size=values["noise"],
        attitude=attitude,
        tilt=values["tilt"],
        attitude_size=values["attitude_noise"],
        acting=acting,
    )


def _each(value: ArrayLike, width: int, count: int) -> Floats:
    """A copy of a value of all bodies, or of each; ``width`` counts the axes of one body."""
    array = np.asarray(value, dtype=np.float64)
    return np.broadcast_to(array, (count, *array.shape[array.ndim - width :])).copy()


def _values(scene: Scene, start: Start, varied: set[str], count: int) -> dict[str, Floats]:
    """The numbers of moments and start, and the others that axes set, in every pixel."""
    needed = {"moments", "spin", "tilt", "energy", "l_gamma", "omega", "noise", "attitude_noise"}
    return {
        name: _each(place.read(scene, start), place.width, count)
        for name, place in PLACES.items()
        if name in needed | varied
    }


def _moments(values: Mapping[str, Floats]) -> Floats:
    """The principal moments that the axes give."""
    if "box" in values:
        return box_moments(*values["box"].T)
    moments = values["moments"]
    if "semi-axes" in values:
        a, c = values["semi-axes"].T
        long, short, largest = a * a, c * c, moments[:, 2].copy()
        moments[:, 0] = largest * (1.0 + short) / (1.0 + long)
        moments[:, 1] = largest * (long + short) / (1.0 + long)
    return moments


def _changes(scene: Scene, values: Mapping[str, Floats]) -> dict[str, Any]:
    """The parts of the scene that the axes set, besides body and damping."""
    changes: dict[str, Any] = {name: values[name] for name in ("mgl", "rotor") if name in values}
    if "com angles" in values:
        (along, across), (first, second) = np.moveaxis(values["com angles"], 0, -1)
        changes["com"] = np.stack([across * first, across * second, along], axis=1)
    if "com" in values:
        first, second, third = values["com"].T
        with np.errstate(invalid="ignore", over="ignore"):
            length = np.sqrt(first * first + second * second + third * third)
            changes["com"] = values["com"] / length[:, np.newaxis]
        if not np.isfinite(changes["com"]).all():
            raise ValueError("axes: com1, com2 and com3 must not all be zero: they are a direction")
    if "torque" in values:
        part = Torque.body(values["torque"])
        if scene.torque is not None:
            in_space = np.broadcast_to(scene.torque.in_space, np.shape(part.in_body))
            part = replace(part, in_space=in_space, function=scene.torque.function)
        changes["torque"] = part
    if "dissipation" in values:
        changes["dissipation"] = EnergySink(values["dissipation"])
    if "orbit" in values:
        known = scene.orbit
        assert known is not None
        e, anomaly = values["orbit"].T
        changes["orbit"] = Orbit(known.rate, e, anomaly, known.normal, known.periapsis)
    return changes


def _check_noise_of_rods(moments: Floats, size: Floats, noise: object) -> None:
    """Raise ValueError if noise would spin a rod about its axis."""
    thin = rods(moments)[:, np.newaxis] & (moments == 0.0)
    if noise is None or not thin.any():
        return
    is_known = isinstance(noise, Noise) and noise.kind in ("normal", "uniform") and not noise.cov
    if not is_known or np.any(size[thin] != 0.0):
        axis = int(thin.any(axis=0).argmax()) + 1
        raise ValueError(
            f"noise: a rod has no moment about its axis and cannot spin; give normal or uniform "
            f"noise of three sizes, with 0 for axis {axis}"
        )


def _on_surface(
    values: Mapping[str, Floats], moments: Floats, weight: Floats, omega: Floats, attitude: Floats
) -> tuple[Floats, Floats]:
    """Moments, and the rates with the energies and the vertical momenta that the axes give.

    With the momentum the rates are ``l gamma / (gamma·I gamma) + s u``, ``u`` the rest of them
    without their vertical momentum: both parts are at right angles in the kinetic energy. A pixel
    without such a start gets moments that no body has.
    """
    energy, l_gamma = values["energy"], values["l_gamma"]
    of_energy, of_momentum = (~np.isnan(part) for part in (energy, l_gamma))
    if not (of_energy.any() or of_momentum.any()):
        return moments, omega
    gamma = to_body(attitude, np.array([0.0, 0.0, 1.0]))

    def product(a: Floats, b: Floats) -> Floats:
        """``a·I b``, in a fixed order."""
        first, second, third = (moments * a * b).T
        return np.asarray(first + second + third)

    upright = product(gamma, gamma)
    momentum = np.where(of_momentum, l_gamma, 0.0)
    share = np.where(of_momentum, product(omega, gamma) / upright, 0.0)
    rest = omega - share[:, np.newaxis] * gamma
    first, second, third = (weight * gamma).T
    left = energy - (first + second + third) - 0.5 * momentum * momentum / upright
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(of_energy, np.sqrt(2.0 * left / product(rest, rest)), 1.0)
    scale = np.where(of_energy & (left == 0.0), 0.0, scale)
    none = ~np.isfinite(scale)
    along = np.where(of_momentum, momentum / upright, 0.0)
    found = along[:, np.newaxis] * gamma + np.where(none, 0.0, scale)[:, np.newaxis] * rest
    return np.where(none[:, np.newaxis], np.nan, moments), np.asarray(found)
