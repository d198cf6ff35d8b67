"""The nominal start of every pixel of a map, as arrays with one row for each pixel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.float_environment import in_standard_floats
from .._moments import rods, without_spin
from ..model.body import Body, rates_of_rods
from ..model.forces import FORCES
from ..model.scene import Scene
from ..model.start import Noise, Start, tilted_attitude, tilted_rates
from ..model.torque import Torque, checked_damping, forces_of
from ..rotations.apply import to_body
from ..solve.bodies import Bodies
from .parameters import Axis, PixelValues, in_order

__all__ = ["Made", "NominalStarts", "grid_shape", "nominal_starts"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """The values that a function of the user makes for all P pixels.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
        Of one body, or of P bodies.
    omega, attitude : ndarray, shapes (P, 3), (P, 4), or None
        Nominal rates and attitudes, if the function gives them.
    """

    scene: Scene
    omega: Floats | None = None
    attitude: Floats | None = None

    def of_pixels(self, pixels: NDArray[np.int64]) -> Made:
        """The values of some pixels."""
        omega, attitude = (
            None if part is None else part[pixels] for part in (self.omega, self.attitude)
        )
        return Made(self.scene[pixels] if self.scene.shape else self.scene, omega, attitude)


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalStarts:
    """Bodies and starts of all P pixels in C order of the grid, as read-only arrays of `float64`.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
        The scene whose numbers the axes replace.
    made : FreeBody or HeavyTop, or None
        The scene of all pixels, if a function of the user made it.
    moments : (P, 3) principal moments
    weight : (P, 3) ``mgl * com``, zero for a free body
    own : the numbers of the scene's own that may vary, such as ``mgl``, (P,) or (P, 3) each
    omega, omega_size : (P, 3) nominal rates and size of their noise, rad/s
    attitude : (P, 4) nominal attitude (w, x, y, z)
    tilt : (P,) rad
    attitude_size : (P, 3) sizes of the rotation vectors of the attitude noise, rad
    damping : (P, 3, 3), or None if nothing damps
    torque : (P, 3) constant torque in the body, or None if the axes set none
    further : the numbers of the further forces that the axes set, such as ``rotor``, (P, 3) each
    acting : the names of the forces of the scene that act in some pixel of the whole map
    """

    scene: Scene
    moments: Floats
    weight: Floats
    own: Mapping[str, Floats]
    omega: Floats
    omega_size: Floats
    attitude: Floats
    tilt: Floats
    attitude_size: Floats
    damping: Floats | None
    torque: Floats | None
    further: Mapping[str, Floats]
    acting: tuple[str, ...]
    made: Scene | None = None

    def __post_init__(self) -> None:
        for column in fields(self):
            array = getattr(self, column.name)
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def physical(self) -> bool:
        """Whether a body must be able to have the moments."""
        return (self.scene if self.made is None else self.made).body.physical

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

    @cached_property
    def forces(self) -> list[_core.Forces] | None:
        """Applied torque and damping of each pixel; None if no pixel has any."""
        scene = self.scene
        if self.made is not None:
            return self._forces_of_each(self.made)
        if not (self.acting or self.further) and self.damping is None and self.torque is None:
            return None
        count = len(self.moments)
        damping = np.zeros((count, 3, 3)) if self.damping is None else self.damping
        torque = np.zeros((count, 3)) if self.torque is None else self.torque
        rows = np.concatenate([damping.reshape(-1, 9), torque, *self.further.values()], axis=1)
        # Pixels of a row mostly share theirs.
        known, of_pixel = np.unique(rows, axis=0, return_inverse=True)
        # Under a torque of zero, bodies without damping are integrated like their neighbours.
        none = None if self._has_orbits_alone else Torque.body((0.0, 0.0, 0.0))
        alike = scene.further_numbers()
        ends = np.cumsum([12, *(each.shape[1] for each in self.further.values())])

        def in_the_form_of_a_scene(name: str, rows: Floats) -> Floats:
            """The numbers of a further force in all rows."""
            made = FORCES[name].made(rows)
            if made is None:
                return rows
            return np.broadcast_to(np.asarray(FORCES[name].numbers(made)), rows.shape)

        parts = zip(self.further, np.split(known, ends, axis=1)[1:-1], strict=True)
        varied = {name: in_the_form_of_a_scene(name, rows) for name, rows in parts}
        made = [
            forces_of(
                self._torque(row[9:12]) or none,
                checked_damping(row[:9].reshape(3, 3)),
                further={**alike, **{name: rows[k] for name, rows in varied.items()}},
            )
            for k, row in enumerate(known)
        ]
        every = [one for one in made if one is not None]
        return [every[k] for k in of_pixel.ravel()]

    def _forces_of_each(self, made: Scene) -> list[_core.Forces] | None:
        """Applied torque and damping of each pixel, where all of these may differ."""
        if not (self.acting or self.further) and self.damping is None and self.torque is None:
            return None
        zero = Torque.body((0.0, 0.0, 0.0))
        none = forces_of(zero, None)
        assert none is not None
        forces = []
        for pixel in range(len(self.moments)):
            scene = self.scene_of(pixel)
            acting = scene.acting() or none
            if scene.forces == ("orbit",) and not self._has_orbits_alone:
                acting = forces_of(zero, None, further=scene.further_numbers()) or none
            forces.append(acting)
        return forces

    @property
    def _has_orbits_alone(self) -> bool:
        """Whether all bodies move under the gravity gradient of an orbit and under nothing else.

        They are integrated without a balance then, whichever pixels the core is given together.
        """
        varied = self.damping is not None or self.torque is not None or {*self.further} - {"orbit"}
        return self.acting == ("orbit",) and not varied

    def _torque(self, in_body: Floats) -> Torque | None:
        """The torque of a pixel whose axes set the part of the given name."""
        given = self.scene.torque
        if self.torque is None:
            return given
        part = Torque.body(in_body)
        return part if given is None else replace(given, in_body=part.in_body)

    def batches_by_forces(
        self, of_pixel: NDArray[np.intp], omega: Floats, attitude: Floats
    ) -> Iterator[tuple[list[int], Bodies]]:
        """Bodies of these pixels in batches under the same forces.

        Parameters
        ----------
        of_pixel : ndarray of int, shape (n,)
            The pixel of each body.
        omega, attitude : ndarray, shapes (n, 3), (n, 4)
            Starts of the bodies: rad/s in the body; quaternions (w, x, y, z).

        Yields
        ------
        list of int, Bodies
            The indices of the bodies of a batch among those given, and the batch.
        """
        groups: dict[_core.Forces | None, list[int]] = {}
        for index, pixel in enumerate(of_pixel):
            forces = None if self.forces is None else self.forces[pixel]
            groups.setdefault(forces, []).append(index)
        for forces, mine in groups.items():
            batch = Bodies(
                kind=self.scene.kind,
                shape=(len(mine),),
                moments=self.moving[of_pixel[mine]],
                weight=self.weight[of_pixel[mine]],
                omega=omega[mine],
                attitude=attitude[mine],
                forces=forces,
            )
            yield mine, batch

    def of_pixels(self, pixels: NDArray[np.int64]) -> NominalStarts:
        """The rows of some pixels."""
        columns = {column.name: getattr(self, column.name) for column in fields(self)}
        some: dict[str, Any] = {
            name: column[pixels]
            for name, column in columns.items()
            if isinstance(column, np.ndarray)
        }
        own = {name: column[pixels] for name, column in self.own.items()}
        made = self.made[pixels] if self.made is not None and self.made.shape else self.made
        further = {name: column[pixels] for name, column in self.further.items()}
        return replace(self, own=own, made=made, further=further, **some)

    def scene_of(self, pixel: int) -> Scene:
        """The scene of one pixel, with the values of the axes there."""
        i1, i2, i3 = self.moments[pixel].tolist()
        damping = None if self.damping is None else self.damping[pixel]
        own: dict[str, Any] = {
            name: float(column[pixel]) if column.ndim == 1 else tuple(column[pixel].tolist())
            for name, column in self.own.items()
        }
        own |= {name: FORCES[name].made(column[pixel]) for name, column in self.further.items()}
        base = self.scene if self.made is None or not self.made.shape else self.made[pixel]
        body = Body((i1, i2, i3), physical=self.physical)
        scene = base.replaced(body, damping, **own)
        if self.torque is not None:
            object.__setattr__(scene, "torque", self._torque(self.torque[pixel]))
        return scene


def grid_shape(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """Shape of the arrays of a map: ``(..., ny, nx)``, the first axis last."""
    return tuple(len(axis.values) for axis in reversed(axes))


@in_standard_floats
def nominal_starts(
    scene: Scene,
    start: Start,
    axes: tuple[Axis, ...] = (),
    index: NDArray[np.int64] | None = None,
    made: Made | None = None,
) -> NominalStarts:
    """The nominal start of every pixel of a grid that :func:`check_applicable` accepts.

    Without axes there is one pixel: the nominal start of the scene. With ``index`` only the pixels
    with these numbers in C order are made, a row for each. ``made`` is what a function of the user
    made of all pixels.
    """
    shape = grid_shape(axes)
    flat = np.arange(prod(shape)) if index is None else index
    count = len(flat)
    acting = (scene if made is None else made.scene).forces
    if made is not None and index is not None:
        made = made.of_pixels(index)
    base = scene if made is None else made.scene
    pixels = _without_axes(base, start, count)
    if made is not None and made.omega is not None:
        pixels.omega = made.omega.copy()
    places = list(reversed(np.unravel_index(flat, shape))) if axes else []
    for k in in_order(axes):
        axes[k].parameter.apply(pixels, np.array(axes[k].values)[places[k]])
    if "com" in pixels.own and not np.isfinite(pixels.own["com"]).all():
        raise ValueError("axes: com1, com2 and com3 must not all be zero: they are a direction")
    kinds = {axis.parameter.describes for axis in axes}
    forces = {axis.parameter.force for axis in axes}
    upright = np.zeros(count)
    if scene.directions:
        attitude, rates_tilt = tilted_attitude(start.axis, pixels.tilt), upright
    else:
        attitude, rates_tilt = tilted_attitude(3, upright), pixels.tilt
    if start.attitude is not None:
        attitude = np.tile(start.attitude, (count, 1))
    if made is not None and made.attitude is not None:
        attitude = made.attitude.copy()
    omega = pixels.omega
    if start.omega is None:
        omega = tilted_rates(pixels.spin, start.axis, rates_tilt)
    weight = scene.weights(pixels.own, count)
    omega = _on_surface(pixels, weight, omega, attitude)
    omega = rates_of_rods("start: omega", omega, pixels.moments, weight, acting)
    _check_noise_of_rods(pixels, start.noise)
    return NominalStarts(
        scene=scene,
        moments=pixels.moments,
        weight=weight,
        own=pixels.own,
        omega=omega,
        omega_size=pixels.omega_size,
        attitude=attitude,
        tilt=pixels.tilt,
        attitude_size=pixels.attitude_size,
        damping=pixels.damping if "damping" in kinds or base.damping is not None else None,
        torque=pixels.torque if "torque" in kinds else None,
        further={name: pixels.further[name] for name in FORCES if name in forces},
        acting=acting,
        made=None if made is None else made.scene,
    )


def _without_axes(scene: Scene, start: Start, count: int) -> PixelValues:
    """The numbers of the scene and the start, in every pixel."""
    body = scene.body
    noise = start.noise.size if isinstance(start.noise, Noise) else 0.0
    attitude_noise = 0.0 if start.attitude_noise is None else start.attitude_noise.size
    if start.joint:
        attitude_noise = 1.0

    def each(value: ArrayLike, width: int = 0) -> Floats:
        """A number of all bodies, or of each; ``width`` counts the axes of one body."""
        array = np.asarray(value, dtype=np.float64)
        shape = array.shape[array.ndim - width :]
        return np.broadcast_to(array, (count, *shape)).copy()

    torque = np.zeros(3) if scene.torque is None else np.asarray(scene.torque.in_body)[..., 0, :]
    com = each(getattr(scene, "com", (0.0, 0.0, 1.0)), 1)
    moments = each(body.moments, 1)
    com_tilt, com_turn = _angles_of_com(com)
    return PixelValues(
        moments=moments,
        sides=each((np.nan,) * 3 if body.sides is None else body.sides, 1),
        mass=each(np.nan if body.mass is None else body.mass),
        shape=_semi_axes(moments),
        own={
            name: each(getattr(scene, name), int(field.width > 1))
            for name, field in scene.fields.items()
            if field.varies
        },
        com=com,
        com_tilt=com_tilt,
        com_turn=com_turn,
        damping=each(np.zeros((3, 3)) if scene.damping is None else scene.damping, 2),
        torque=each(torque, 1),
        further={force.name: each(force.numbers(value), 1) for force, value in scene.further()},
        spin=each(start.spin or 0.0),
        tilt=each(start.tilt),
        energy=each(np.nan),
        l_gamma=each(np.nan),
        omega=each(start.omega or (0.0, 0.0, 0.0), 1),
        omega_size=each(np.broadcast_to(noise, (3,)), 1),
        attitude_size=each(np.broadcast_to(attitude_noise, (3,)), 1),
    )


def _check_noise_of_rods(pixels: PixelValues, noise: object) -> None:
    """Raise ValueError if noise would spin a rod about its axis."""
    thin = rods(pixels.moments)[:, np.newaxis] & (pixels.moments == 0.0)
    if noise is None or not thin.any():
        return
    is_known = isinstance(noise, Noise) and noise.kind in ("normal", "uniform") and not noise.cov
    if not is_known or np.any(pixels.omega_size[thin] != 0.0):
        axis = int(thin.any(axis=0).argmax()) + 1
        raise ValueError(
            f"noise: a rod has no moment about its axis and cannot spin; give normal or uniform "
            f"noise of three sizes, with 0 for axis {axis}"
        )


def _on_surface(pixels: PixelValues, weight: Floats, omega: Floats, attitude: Floats) -> Floats:
    """The rates with the energies and the vertical momenta that the axes give.

    With the momentum the rates are ``l gamma / (gamma·I gamma) + s u``, ``u`` the rest of them
    without their vertical momentum: both parts are at right angles in the kinetic energy. A pixel
    without such a start gets moments that no body has.
    """
    of_energy, of_momentum = (~np.isnan(part) for part in (pixels.energy, pixels.l_gamma))
    if not (of_energy.any() or of_momentum.any()):
        return omega
    gamma = to_body(attitude, np.array([0.0, 0.0, 1.0]))
    moments = pixels.moments

    def product(a: Floats, b: Floats) -> Floats:
        """``a·I b``, in a fixed order."""
        first, second, third = (moments * a * b).T
        return np.asarray(first + second + third)

    upright = product(gamma, gamma)
    momentum = np.where(of_momentum, pixels.l_gamma, 0.0)
    share = np.where(of_momentum, product(omega, gamma) / upright, 0.0)
    rest = omega - share[:, np.newaxis] * gamma
    first, second, third = (weight * gamma).T
    left = pixels.energy - (first + second + third) - 0.5 * momentum * momentum / upright
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(of_energy, np.sqrt(2.0 * left / product(rest, rest)), 1.0)
    scale = np.where(of_energy & (left == 0.0), 0.0, scale)
    none = ~np.isfinite(scale)
    pixels.moments = np.where(none[:, np.newaxis], np.nan, moments)
    along = np.where(of_momentum, momentum / upright, 0.0)
    found = along[:, np.newaxis] * gamma + np.where(none, 0.0, scale)[:, np.newaxis] * rest
    return np.asarray(found)


def _semi_axes(moments: Floats) -> Floats:
    """``a/b`` and ``c/b`` of homogeneous ellipsoids with these moments; NaN if there is none."""
    squares = moments.sum(axis=1, keepdims=True) - 2.0 * moments
    with np.errstate(all="ignore"):
        ratios: Floats = np.sqrt(squares[:, [0, 2]] / squares[:, [1]])
    return ratios


def _angles_of_com(com: Floats) -> tuple[Floats, Floats]:
    """Cosine and sine of both angles of centres of mass; on axis 3 the azimuth is 0."""
    first, second, along = com.T
    across = np.sqrt(first * first + second * second)
    off = across > 0.0
    length = np.where(off, across, 1.0)
    turn = np.where(off, first / length, 1.0), np.where(off, second / length, 0.0)
    return np.stack([along, across], axis=1), np.stack(turn, axis=1)
