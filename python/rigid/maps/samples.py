"""Many bodies of a map again: their starts and their outcomes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief
from .._checks.quantities import plain
from .._checks.shown import short_repr
from ..solve.status import Status
from .data import MapData
from .grid import Pixels
from .job import to_core
from .replay import named_outcomes, pixel_index
from .spec import MapSpec

Floats = NDArray[np.float64]


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Starts:
    """Starts of bodies of a map, as the map drew them; NaN where no body is possible.

    Attributes
    ----------
    omega : ndarray, shape ``(*grid, *sample, 3)``, of one pixel ``(*sample, 3)``
        Rates in the body, rad/s.
    attitude : ndarray, shape ``(*grid, *sample, 4)``, of one pixel ``(*sample, 4)``
        Quaternions (w, x, y, z).
    parameters : dict of str to ndarray, shape ``(*grid, *sample)``, of one pixel ``sample``
        The values of the parameters that vary, by their names.
    draws : ndarray of int64 of this shape, or None
        How often these parameters were drawn until a body could have them; None if none varies.
    """

    omega: Floats
    attitude: Floats
    parameters: dict[str, Floats]
    draws: NDArray[np.int64] | None


@short_repr
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outcomes:
    """Outcomes of bodies of a map, each as the map classified it.

    All arrays have the shape ``(*grid, *sample)``, or ``sample`` for one pixel.

    Attributes
    ----------
    outcome : ndarray of str
        ``"stable"``, ``"unstable"``, ``"undecided"`` or ``"failed"``; empty where no body is
        possible.
    left : ndarray
        Time at which a body left stability, s; NaN if it did not.
    tilt : ndarray
        Largest observed tilt (rad), NaN if the criterion is not a tilt limit.
    exponent, mean_megno : ndarray
        Exponent (1/s) and mean MEGNO at the end, NaN if no deviation vector was integrated.
    flips, steps : ndarray of int64
        Sign changes, and time steps taken.
    status : ndarray of uint8
        Codes of :class:`rigid.Status` at the end of the integration.
    method : ndarray of str
        ``"exact"`` for a closed form, else the method.
    energy_drift, momentum_drift, unit_drift : ndarray
        Drifts as in :class:`Replay`; NaN by closed form.
    step : ndarray
        Time step, s; NaN by closed form.
    measures : dict of str to ndarray
        The value of each measure of the map by its name; NaN for none.
    """

    outcome: NDArray[np.str_]
    left: Floats
    tilt: Floats
    exponent: Floats
    mean_megno: Floats
    flips: NDArray[np.int64]
    steps: NDArray[np.int64]
    status: NDArray[np.uint8]
    method: NDArray[np.str_]
    energy_drift: Floats
    momentum_drift: Floats
    unit_drift: Floats
    step: Floats
    measures: dict[str, Floats]


def starts(data: MapData, sample: ArrayLike, pixel: int | tuple[int, ...] | None = None) -> Starts:
    """Starts of bodies; see :meth:`rigid.StabilityMap.starts`."""
    spec = data.spec
    numbers = _samples(sample, spec.samples)
    flat, possible = _flat(data, numbers, pixel)
    shape = numbers.shape if pixel is not None else (*spec.shape, *numbers.shape)
    found = [
        part.reshape(-1, width)
        for part, width in zip(to_core(spec).starts(flat), (3, 4), strict=True)
    ]

    def each(values: NDArray[Any], nothing: float) -> NDArray[Any]:
        every = np.full((possible.size, *values.shape[1:]), nothing, dtype=values.dtype)
        every[possible] = values
        return every.reshape((*shape, *values.shape[1:]))

    drawn, draws = _drawn(spec, flat.astype(np.int64))
    return Starts(
        omega=each(found[0], np.nan),
        attitude=each(found[1], np.nan),
        parameters={name: each(values, np.nan) for name, values in drawn.items()},
        draws=each(draws, 0) if spec.vary else None,
    )


def _drawn(spec: MapSpec, flat: NDArray[np.int64]) -> tuple[dict[str, Floats], NDArray[np.int64]]:
    """The values of the parameters that vary, of bodies by their numbers, and their draws."""
    values = {one.name: np.empty(len(flat)) for one in spec.vary}
    draws = np.zeros(len(flat), dtype=np.int64)
    for mine, bodies in bodies_of(spec, flat) if spec.vary else ():
        assert bodies.draws is not None
        draws[mine] = bodies.draws
        for name, every in bodies.drawn.items():
            values[name][mine] = every
    return values, draws


def bodies_of(spec: MapSpec, flat: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.intp], Pixels]]:
    """Bodies by their numbers, with the parameters that they have: their places, and the bodies."""
    pixel, sample = np.divmod(flat, spec.samples)
    for part in spec.parts:
        mine = np.flatnonzero(np.isin(pixel, part.pixels))
        own = np.searchsorted(part.pixels, pixel[mine])
        yield mine, part.spec.bodies(part.spec.start.starts[0], own, sample[mine])


def outcomes(
    data: MapData,
    sample: ArrayLike,
    pixel: int | tuple[int, ...] | None,
    threads: int,
) -> Outcomes:
    """Outcomes of bodies; see :meth:`rigid.StabilityMap.outcomes`."""
    spec = data.spec
    numbers = _samples(sample, spec.samples)
    flat, possible = _flat(data, numbers, pixel)
    asked, of_each = np.unique(flat, return_inverse=True)
    found = to_core(spec).outcomes(asked, threads)
    shape = numbers.shape if pixel is not None else (*spec.shape, *numbers.shape)

    def each(values: NDArray[Any], nothing: object) -> NDArray[Any]:
        every = np.full(possible.shape, nothing, dtype=values.dtype)
        every[possible] = values[of_each]
        return every.reshape(shape)

    nothing = {"outcome": "", "method": "", "status": Status.NOT_FINITE, "flips": 0, "steps": 0}
    named = named_outcomes(spec, found)
    measures = {name: each(values, np.nan) for name, values in named.pop("measures").items()}
    values = {name: each(of_all, nothing.get(name, np.nan)) for name, of_all in named.items()}
    return Outcomes(measures=measures, **values)


def _samples(sample: ArrayLike, count: int) -> NDArray[np.int64]:
    """Numbers of samples, each of 0 .. count - 1."""
    numbers = np.asarray(plain("sample", sample))
    if numbers.dtype.kind not in "iu":
        raise TypeError(f"sample = {brief(sample)}: must be a whole number, or an array of them")
    outside = (numbers < 0) | (numbers >= count)
    if outside.any():
        bad = int(numbers[outside].flat[0])
        raise IndexError(f"sample = {bad}: must lie in 0 .. {count - 1}")
    return numbers.astype(np.int64)


def _flat(
    data: MapData, numbers: NDArray[np.int64], pixel: int | tuple[int, ...] | None = None
) -> tuple[NDArray[np.uint64], NDArray[np.bool_]]:
    """Numbers among all samples of the map, and which of the requested bodies are possible."""
    spec = data.spec
    pixels = np.arange(math.prod(spec.shape))
    if pixel is not None:
        pixels = np.array([np.ravel_multi_index(pixel_index(pixel, spec.shape), spec.shape)])
    flat = (pixels[:, np.newaxis] * spec.samples + numbers.ravel()).ravel()
    possible = (data.status.ravel()[pixels] == 0).repeat(numbers.size)
    return flat[possible].astype(np.uint64), possible
