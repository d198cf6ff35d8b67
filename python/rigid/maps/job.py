"""The request of a map as the core reads it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import one_of
from .._checks.arrays import Floats
from ..model.mixture import Mixture
from ..model.noise import Noise, Samples
from ..model.start import Start
from ..solve.methods import AUTO, EXACT, map_methods, series_methods
from .core_request import CoreRequest, CoreStarts
from .grid import Pixels
from .judge import BlockedJob, CustomJob
from .sequential import LOOK
from .spec import MapPart, MapSpec

Ints = NDArray[np.int64]


BLOCK = 2**14
"""Bodies of a varying map that a request to the core has: some tens of milliseconds or more."""


class VaryingJob(BlockedJob):
    """The request of a map whose bodies vary: in the core each body is a pixel with one sample.

    Parameters
    ----------
    spec : MapSpec
        Of one horizon and one limit.
    pixels : ndarray of int64, shape (P,)
        Numbers of the pixels, a row for each.
    count : int
        Samples of each row.
    first : ndarray of int64, shape (P,)
        Number of the first sample of each row.
    fixed : dict of str to float
        Values of further axes of the whole map.
    """

    def __init__(
        self, spec: MapSpec, pixels: Ints, count: int, first: Ints, fixed: Mapping[str, float]
    ) -> None:
        status = spec.bodies(spec.start.starts[0], pixels).status
        super().__init__(status, count, len(spec.measure), BLOCK)
        self._spec, self._pixels, self._first, self._fixed = spec, pixels, first, fixed
        self._checked = spec.checked_before(count, first)

    def starts(self, samples: NDArray[np.uint64]) -> list[NDArray[np.float64]]:
        """As ``MapJob.starts``."""
        parts = [
            self._of(flat).starts(np.arange(len(flat), dtype=np.uint64))
            for flat in self._blocks(samples)
        ]
        return [np.concatenate(columns) for columns in zip(*parts, strict=True)]

    def _counted(
        self, flat: Ints, threads: int, interrupted: Callable[[], bool] | None
    ) -> dict[str, Any] | None:
        return self._of(flat).run(0, len(flat), threads, interrupted)

    def _found(self, flat: Ints, threads: int) -> dict[str, NDArray[Any]]:
        return self._of(flat).outcomes(np.arange(len(flat), dtype=np.uint64), threads)

    def _of(self, flat: Ints) -> _core.MapJob | CustomJob:
        """The request of these samples."""
        row, within = np.divmod(flat, self._samples)
        spec, pixels, number = self._spec, self._pixels[row], self._first[row] + within
        grids = [spec.bodies(start, pixels, number) for start in spec.start.starts]
        return _of_rows(spec, grids, pixels, (1, number), self._checked, self._fixed)


def of_pixels(bins: NDArray[np.int64], pixels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Bins of some pixels, numbered from 0, renumbered to these numbers of pixels."""
    return np.concatenate([pixels[bins[:, :1]], bins[:, 1:]], axis=1)


def to_core(
    spec: MapSpec,
    pixels: Ints | None = None,
    count: int | None = None,
    first: int | Ints = 0,
    fixed: Mapping[str, float] = MappingProxyType({}),
) -> _core.MapJob | CustomJob | VaryingJob:
    """The request of a specification of one horizon and one limit, as the core reads it.

    Parameters
    ----------
    spec : MapSpec
        The only part of a map, or one of :attr:`MapSpec.parts`.
    pixels : ndarray of int64, optional
        Numbers of the pixels in C order of the grid, a row of the request for each; default all.
        Their samples have the bits that they have in the whole map.
    count : int, optional
        Samples of each row, by default all.
    first : int or ndarray of int64
        Number of the first sample of the rows, or of each: a multiple of 64.
    fixed : dict of str to float
        Values of further axes of the whole map.

    Raises
    ------
    ValueError
        If its method is not one of maps, or its torque is a function that is not known.
    """
    one_of("method", spec.method, map_methods())
    spec.require_torque()
    count = spec.samples if count is None else count
    every = np.arange(math.prod(spec.shape)) if pixels is None else pixels
    begins = np.broadcast_to(first, every.shape)
    if spec.vary:
        return VaryingJob(spec, every, count, begins, fixed)
    grids = [spec.bodies(start, pixels) for start in spec.start.starts]
    checked = spec.checked_before(count, begins)
    return _of_rows(spec, grids, every, (count, begins), checked, fixed)


def _of_rows(
    spec: MapSpec,
    grids: list[Pixels],
    pixels: Ints,
    samples: tuple[int, Ints],
    checked: int | None,
    fixed: Mapping[str, float],
) -> _core.MapJob | CustomJob:
    """The request of rows of so many samples, each from the number of its first sample on."""
    grid, (count, first) = grids[0], samples
    # What draws for a function classifies nothing, may have no closed form, and measures.
    is_left = spec.is_judged and spec.method in (EXACT, *series_methods())
    request = CoreRequest(
        scene=spec.scene.kind,
        method=AUTO if is_left else spec.method,
        moments=grid.moving,
        physical=grid.physical,
        weight=grid.weight,
        starts=[_starts(*one) for one in zip(spec.start.starts, grids, strict=True)],
        shares=spec.start.shares().tolist() if isinstance(spec.start, Mixture) else (1.0,),
        conditions=spec.stable.conditions(),
        logic=" ".join(map(str, spec.stable.logic())),
        measures=[one.core() for one in spec.measure],
        t_end=spec.t_end,
        step=spec.step,
        max_steps=spec.max_steps,
        samples=count,
        checked=checked,
        seed=spec.seed,
        forces=grid.forces,
        numbers=pixels.astype(np.uint64),
        first=first.astype(np.uint64),
    )
    job = _core.MapJob(request)
    return CustomJob(spec, job, request, pixels, fixed, grid) if spec.is_judged else job


def _starts(start: Start, grid: Pixels) -> CoreStarts:
    """A start and its perturbations in each pixel, as the core reads them."""
    noise = start.noise
    return CoreStarts(
        omega=grid.omega,
        omega_noise=_law(start, noise) if isinstance(noise, Noise) else "none",
        omega_size=grid.omega_size,
        attitude=grid.attitude,
        attitude_noise=_attitude_law(start),
        attitude_size=grid.attitude_size,
        **(_given(noise) if isinstance(noise, Samples) else _mix(start)),
    )


def _attitude_law(start: Start) -> str:
    if start.joint:
        return "normal" if isinstance(start.noise, Noise) else "none"
    return "none" if start.attitude_noise is None else _law(start, start.attitude_noise)


def _law(start: Start, noise: Noise) -> str:
    """The name of a distribution in the core, for a direction with the number of its body axis."""
    return f"{noise.kind}{start.axis}" if noise.is_direction else noise.kind


def _given(samples: Samples) -> dict[str, Any]:
    """A list of perturbations, as the core reads it."""
    attitude = None if samples.attitude is None else np.array(samples.attitude)
    return {
        "given_omega": np.array(samples.omega),
        "given_attitude": attitude,
        "given_shares": samples.shares(),
    }


def _mix(start: Start) -> dict[str, Any]:
    """The factor of the covariance of rates and attitude, and which of the two it perturbs."""
    factor, mixed = np.zeros((6, 6)), [False, start.joint]
    for k, noise in enumerate((start.noise, start.attitude_noise)):
        if isinstance(noise, Noise) and noise.cov is not None:
            part = noise.factor()
            mine = slice(3 * k, 3 * k + len(part))
            factor[mine, mine] = part
            mixed[k] = True
    return {"mix": factor, "mixed": mixed} if any(mixed) else {}


def spans(spec: MapSpec, samples: range) -> list[range]:
    """Parts of these samples, one for each request to the core.

    If some bodies of each look are checked, a request has one look.
    """
    if spec.looks is None or spec.check in (None, 0.0, 1.0):
        return [samples]
    return [range(begin, begin + LOOK) for begin in range(samples.start, samples.stop, LOOK)]


@dataclass(frozen=True, slots=True, eq=False)
class SomeBodies:
    """Some bodies of a map, which one request to the core has.

    Attributes
    ----------
    part : MapPart
    places : ndarray of int
        Which of all requested bodies they are.
    pixels, samples : ndarray of int64
        Number of the pixel of each in the part, and of its sample.
    span : range
        The samples of a pixel that are classified together.
    """

    part: MapPart
    places: NDArray[np.intp]
    pixels: Ints
    samples: Ints
    span: range

    def request(self) -> tuple[_core.MapJob | CustomJob | VaryingJob, NDArray[np.uint64]]:
        """The request of their pixels, and their numbers there."""
        pixels, row = np.unique(self.pixels, return_inverse=True)
        count, first = len(self.span), self.span.start
        # The whole grid is kept.
        some = pixels if len(pixels) < math.prod(self.part.spec.shape) else None
        job = to_core(self.part.spec, some, count, first, self.part.fixed)
        return job, (row * count + self.samples - first).astype(np.uint64)

    def starts(self) -> tuple[Floats, Floats]:
        """Rates and attitudes at the start, shapes (n, 3) and (n, 4)."""
        job, numbers = self.request()
        omega, attitude = job.starts(numbers)
        return omega.reshape(-1, 3), attitude.reshape(-1, 4)

    def bodies(self) -> Pixels:
        """The bodies, with the parameters that vary."""
        spec = self.part.spec
        return spec.bodies(spec.start.starts[0], self.pixels, self.samples)


def requests(spec: MapSpec, flat: Ints) -> Iterator[SomeBodies]:
    """The requests for bodies by their numbers among all of a map."""
    pixel, sample = np.divmod(flat, spec.samples)
    every = spans(spec, range(spec.samples))
    of_span = np.searchsorted([span.start for span in every], sample, side="right") - 1
    for part, mine, own in spec.by_part(pixel):
        for number in np.unique(of_span[mine]):
            some = of_span[mine] == number
            places = mine[some]
            yield SomeBodies(part, places, own[some], sample[places], every[number])
