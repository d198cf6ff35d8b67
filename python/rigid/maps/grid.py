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
from .._checks.arrays import Floats
from .._checks.float_environment import in_standard_floats
from .._checks.moments import can_move, rods, without_spin
from ..model.bodies import Bodies
from ..model.body import rates_of_rods
from ..model.forces import FORCES
from ..model.noise import Noise
from ..model.parameters import OF_START, PLACES, moments_of, numbers_of, scene_of
from ..model.scene import Scene
from ..model.start import Start, tilted_attitude, tilted_rates
from ..model.torque import Torque, forces_of
from ..rotations.apply import to_body
from .axes import Axis, in_order
from .vary import Draws, Varied


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
    drawn : the values, shape (P,), of the parameters that were drawn at random
    draws : (P,) int64, the draws of these parameters until a body could have them
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
    drawn: Mapping[str, Floats]
    draws: NDArray[np.int64] | None

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
    def forces(self) -> _core.Forces | None:
        """The forces on the pixels, or those on all; None if no pixel has any."""
        if not self.acting:
            return None
        scene, torque = self.scene, self.scene.torque
        # Under a torque of zero, bodies without damping are integrated like their neighbours. Under
        # an orbit alone all bodies are integrated without a balance.
        if torque is None and {*self.acting} != {"orbit"}:
            torque = Torque.body((0.0, 0.0, 0.0))
        return forces_of(torque, scene.damping, scene.shape, further=scene.further_numbers())

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
            forces=None if self.forces is None else self.forces.select(of_pixel),
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


_NEEDED = {"moments", *OF_START}
"""The places whose numbers every pixel has."""


def grid_shape(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """Shape of the arrays of a map: ``(..., ny, nx)``, the first axis last."""
    return tuple(len(axis.values) for axis in reversed(axes))


def acting_forces(
    scene: Scene, axes: tuple[Axis, ...], vary: tuple[Varied, ...]
) -> tuple[str, ...]:
    """The names of the forces of a scene, and of those that axes set or that vary."""
    every: tuple[Axis | Varied, ...] = (*axes, *vary)
    varied = {one.parameter.place for one in every}
    further = (name for name in ("torque", "damping", *FORCES) if name in varied)
    return tuple(dict.fromkeys((*scene.forces, *further)))


@in_standard_floats
def nominal_starts(
    scene: Scene,
    start: Start,
    axes: tuple[Axis, ...] = (),
    index: NDArray[np.int64] | None = None,
    given: Mapping[str, Floats] = MappingProxyType({}),
    draws: Draws | None = None,
) -> Pixels:
    """The pixels of a grid that :func:`check_applicable` accepts.

    Without axes there is one pixel: the nominal start of the scene. With ``index`` only the pixels
    with these numbers in C order are made, a row for each. If a function of the user makes the
    scene, it is the scene of all pixels, and ``given`` has the rates and attitudes of all pixels
    that the function gives. With ``draws`` each row is a body whose parameters are drawn.
    """
    shape = grid_shape(axes)
    flat = np.arange(prod(shape)) if index is None else index
    vary = () if draws is None else draws.vary
    count, forces, acting = len(flat), scene.forces, acting_forces(scene, axes, vary)
    if index is not None:
        scene = scene[index] if scene.shape else scene
        given = {name: rows[index] for name, rows in given.items()}
    every: tuple[Axis | Varied, ...] = (*axes, *vary)
    varied = {one.parameter.place for one in every}
    values = numbers_of(scene, start, PLACES.keys() & (varied | _NEEDED), count)
    if "omega" in given:
        values["omega"] = given["omega"].copy()
    places = list(reversed(np.unravel_index(flat, shape))) if axes else []
    for k in in_order(axes):
        axes[k].parameter.put(values, np.array(axes[k].values)[places[k]])
    drawn, number = ({}, None) if draws is None else draws.put(values, scene.body.physical)
    moments = moments_of(values)
    possible = can_move(moments, scene.body.physical)
    scene = scene_of(scene, values, np.where(possible[:, np.newaxis], moments, 1.0))
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
        drawn=drawn,
        draws=number,
    )


def _each(value: ArrayLike, width: int, count: int) -> Floats:
    """A copy of a value of all bodies, or of each; ``width`` counts the axes of one body."""
    array = np.asarray(value, dtype=np.float64)
    return np.broadcast_to(array, (count, *array.shape[array.ndim - width :])).copy()


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
