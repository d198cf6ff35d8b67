"""The nominal start of every pixel of a map, as arrays with one row for each pixel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..model.body import Body
from ..model.scene import Scene
from ..model.start import Start, tilted_attitude, tilted_rates
from ..model.torque import Torque, checked_damping, forcing_of
from ..solve.batch import Batch
from .parameters import Axis, PixelValues

__all__ = ["NominalStarts", "grid_shape", "nominal_starts"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalStarts:
    """Bodies and starts of all P pixels in C order of the grid, as read-only arrays of `float64`.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
        The scene whose numbers the axes replace.
    moments : (P, 3) principal moments
    weight : (P, 3) ``mgl * com``, zero for a free body
    own : the numbers of the scene's own that may vary, such as ``mgl``, (P,) or (P, 3) each
    omega, omega_size : (P, 3) nominal rates and size of their noise, rad/s
    attitude : (P, 4) nominal attitude (w, x, y, z)
    tilt, attitude_size : (P,) rad
    damping : (P, 3, 3), or None if nothing damps
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

    def __post_init__(self) -> None:
        for column in fields(self):
            array = getattr(self, column.name)
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @cached_property
    def forcings(self) -> list[_core.Forcing] | None:
        """Applied torque and damping of each pixel; None if no pixel has any."""
        torque = self.scene.torque
        satellite = self.scene.satellite
        if self.damping is None and torque is None and satellite is None:
            return None
        damping = np.zeros((1, 3, 3)) if self.damping is None else self.damping
        # Pixels of a row mostly share theirs.
        known, of_pixel = np.unique(damping.reshape(-1, 9), axis=0, return_inverse=True)
        # Under a torque of zero, bodies without damping are integrated like their neighbours.
        none = Torque.body((0.0, 0.0, 0.0))
        made = [
            forcing_of(torque or none, checked_damping(matrix.reshape(3, 3)), satellite=satellite)
            for matrix in known
        ]
        every = [one for one in made if one is not None]
        return [every[k] for k in np.broadcast_to(of_pixel.ravel(), len(self.moments))]

    def batches_by_forcing(
        self, of_pixel: NDArray[np.intp], omega: Floats, attitude: Floats
    ) -> Iterator[tuple[list[int], Batch]]:
        """Bodies of these pixels in batches under one forcing.

        Parameters
        ----------
        of_pixel : ndarray of int, shape (n,)
            The pixel of each body.
        omega, attitude : ndarray, shapes (n, 3), (n, 4)
            Starts of the bodies: rad/s in the body; quaternions (w, x, y, z).

        Yields
        ------
        list of int, Batch
            The indices of the bodies of a batch among those given, and the batch.
        """
        groups: dict[_core.Forcing | None, list[int]] = {}
        for index, pixel in enumerate(of_pixel):
            forcing = None if self.forcings is None else self.forcings[pixel]
            groups.setdefault(forcing, []).append(index)
        for forcing, mine in groups.items():
            batch = Batch(
                kind=self.scene.kind,
                moments=self.moments[of_pixel[mine]],
                weight=self.weight[of_pixel[mine]],
                omega=omega[mine],
                attitude=attitude[mine],
                forcing=forcing,
            )
            yield mine, batch

    def scene_of(self, pixel: int) -> Scene:
        """The scene of one pixel, with the numbers that the axes set."""
        i1, i2, i3 = self.moments[pixel].tolist()
        damping = None if self.damping is None else self.damping[pixel]
        own = {
            name: float(column[pixel]) if column.ndim == 1 else tuple(column[pixel].tolist())
            for name, column in self.own.items()
        }
        return self.scene.replaced(Body((i1, i2, i3)), damping, **own)


def grid_shape(axes: tuple[Axis, ...]) -> tuple[int, ...]:
    """Shape of the arrays of a map: ``(ny, nx)`` or ``(nx,)``."""
    return tuple(len(axis.values) for axis in reversed(axes))


def nominal_starts(
    scene: Scene,
    start: Start,
    axes: tuple[Axis, ...] = (),
    index: NDArray[np.int64] | None = None,
) -> NominalStarts:
    """The nominal start of every pixel of a grid that :func:`check_applicable` accepts.

    Without axes there is one pixel: the nominal start of the scene. With ``index`` only the pixels
    with these numbers in C order are made, a row for each.
    """
    shape = grid_shape(axes)
    flat = np.arange(prod(shape)) if index is None else index
    count = len(flat)
    pixels = _without_axes(scene, start, count)
    places = reversed(np.unravel_index(flat, shape)) if axes else ()
    settings = [
        (axis.parameter, np.array(axis.values)[place])
        for axis, place in zip(axes, places, strict=True)
    ]
    moments_set = {parameter.sets for parameter, _ in settings} - {None}
    for parameter, values in sorted(settings, key=lambda one: one[0].reads in moments_set):
        parameter.apply(pixels, values)
    upright = np.zeros(count)
    if scene.directions:
        attitude, rates_tilt = tilted_attitude(start.axis, pixels.tilt), upright
    else:
        attitude, rates_tilt = tilted_attitude(3, upright), pixels.tilt
    omega = pixels.omega
    if start.omega is None:
        omega = tilted_rates(pixels.spin, start.axis, rates_tilt)
    damped = any(parameter.describes == "damping" for parameter, _ in settings)
    return NominalStarts(
        scene=scene,
        moments=pixels.moments,
        weight=scene.weights(pixels.own, count),
        own=pixels.own,
        omega=omega,
        omega_size=pixels.omega_size,
        attitude=attitude,
        tilt=pixels.tilt,
        attitude_size=pixels.attitude_size,
        damping=pixels.damping if damped or scene.damping is not None else None,
    )


def _without_axes(scene: Scene, start: Start, count: int) -> PixelValues:
    """The numbers of the scene and the start, in every pixel."""
    body = scene.body
    noise = 0.0 if start.noise is None else start.noise.size
    attitude_noise = 0.0 if start.attitude_noise is None else start.attitude_noise.size

    def each(value: ArrayLike) -> Floats:
        one = np.asarray(value, dtype=np.float64)
        return np.broadcast_to(one, (count, *one.shape)).copy()

    com_tilt, com_turn = _angles_of_com(scene)
    return PixelValues(
        moments=each(body.moments),
        sides=each((np.nan,) * 3 if body.sides is None else body.sides),
        mass=each(np.nan if body.mass is None else body.mass),
        own={
            name: each(getattr(scene, name)) for name, field in scene.fields.items() if field.varies
        },
        com_tilt=each(com_tilt),
        com_turn=each(com_turn),
        damping=each(np.zeros((3, 3)) if scene.damping is None else scene.damping),
        spin=each(start.spin or 0.0),
        tilt=each(start.tilt),
        omega=each(start.omega or (0.0, 0.0, 0.0)),
        omega_size=each(np.broadcast_to(noise, (3,))),
        attitude_size=each(attitude_noise),
    )


def _angles_of_com(scene: Scene) -> tuple[tuple[float, float], tuple[float, float]]:
    """Cosine and sine of both angles of the centre of mass; on axis 3 its azimuth is 0."""
    first, second, along = getattr(scene, "com", (0.0, 0.0, 1.0))
    across = math.sqrt(first * first + second * second)
    return (along, across), (first / across, second / across) if across > 0.0 else (1.0, 0.0)
