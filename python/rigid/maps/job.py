"""The request of a map as the core reads it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .grid import nominal_starts
from .sequential import LOOK
from .spec import MapSpec

__all__ = ["Work", "spans", "to_core"]


def to_core(
    spec: MapSpec,
    pixels: NDArray[np.int64] | None = None,
    samples: range | None = None,
) -> _core.MapJob:
    """The request of a specification, as the core reads it.

    Parameters
    ----------
    spec : MapSpec
    pixels : ndarray of int64, optional
        Numbers of the pixels in C order of the grid, a row of the request for each; default all.
        Their samples have the bits that they have in the whole map.
    samples : range, optional
        The samples of each pixel, by default all. The first is a multiple of 64.
    """
    samples = samples or range(spec.samples)
    grid = spec.grid
    if pixels is not None:
        grid = nominal_starts(spec.scene, spec.start, spec.axes, pixels)
    criterion, axis, limits = spec.stable.core()
    noise, attitude_noise = spec.start.noise, spec.start.attitude_noise
    return _core.MapJob(
        scene=spec.scene.kind,
        method=spec.method,
        moments=grid.moments,
        weight=grid.weight,
        omega=grid.omega,
        omega_noise="none" if noise is None else noise.kind,
        omega_size=grid.omega_size,
        attitude=grid.attitude,
        attitude_noise="none" if attitude_noise is None else attitude_noise.kind,
        attitude_size=grid.attitude_size,
        criterion=criterion,
        axis=axis,
        limits=limits,
        t_end=spec.t_end,
        step=spec.step,
        max_steps=spec.max_steps,
        samples=len(samples),
        checked=spec.checked_samples(samples),
        seed=spec.seed,
        forcing=grid.forcings,
        numbers=None if pixels is None else pixels.astype(np.uint64),
        first=samples.start,
    )


def spans(spec: MapSpec, samples: range) -> list[range]:
    """Parts of these samples, one for each request to the core.

    If some bodies of each look are checked, a request has one look.
    """
    if spec.looks is None or spec.check in (None, 0.0, 1.0):
        return [samples]
    return [range(begin, begin + LOOK) for begin in range(samples.start, samples.stop, LOOK)]


class Work:
    """The samples of possible bodies; ``_core.MapJob`` counts those of all pixels.

    A chunk is a number of possible bodies: impossible ones must not upset the pace.

    Parameters
    ----------
    possible : ndarray of bool, shape (P,)
        Pixels with a possible body.
    samples : int
        Bodies per pixel.
    """

    __slots__ = ("_before", "_samples", "total")

    def __init__(self, possible: NDArray[np.bool_], samples: int) -> None:
        through = np.cumsum(possible, dtype=np.int64) * samples
        self._before = through - possible * np.int64(samples)
        self._samples = samples
        self.total = int(through[-1])

    def flat(self, done: int) -> int:
        """Index of possible body number ``done`` among all samples in pixel-major order."""
        pixel = int(np.searchsorted(self._before, done, side="right")) - 1
        return pixel * self._samples + done - int(self._before[pixel])
