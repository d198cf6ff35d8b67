"""Many bodies of a map again: their starts, their outcomes and their sensitivity to the start."""

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
from ..solve.sensitivity import amplification
from ..solve.status import Status
from .data import MapData
from .job import to_core
from .replay import named_outcomes, pixel_index
from .spec import MapPart, MapSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    draws: Ints | None


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
    flips: Ints
    steps: Ints
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
    omega, attitude = np.empty((len(flat), 3)), np.empty((len(flat), 4))
    drawn = {one.name: np.empty(len(flat)) for one in spec.vary}
    draws = np.zeros(len(flat), dtype=np.int64)
    for part, mine, own, sample in in_parts(spec, flat):
        omega[mine], attitude[mine] = _drawn(part, own, sample)
        if spec.vary:
            bodies = part.spec.bodies(spec.start.starts[0], own, sample)
            assert bodies.draws is not None
            draws[mine] = bodies.draws
            for name, values in bodies.drawn.items():
                drawn[name][mine] = values

    def each(values: NDArray[Any], nothing: float) -> NDArray[Any]:
        every = np.full((possible.size, *values.shape[1:]), nothing, dtype=values.dtype)
        every[possible] = values
        return every.reshape((*shape, *values.shape[1:]))

    return Starts(
        omega=each(omega, np.nan),
        attitude=each(attitude, np.nan),
        parameters={name: each(values, np.nan) for name, values in drawn.items()},
        draws=each(draws, 0) if spec.vary else None,
    )


def in_parts(spec: MapSpec, flat: Ints) -> Iterator[tuple[MapPart, NDArray[np.intp], Ints, Ints]]:
    """Bodies by their numbers: each part, the places of its bodies, their pixels and samples."""
    pixel, sample = np.divmod(flat, spec.samples)
    for part, mine, own in spec.by_part(pixel):
        yield part, mine, own, sample[mine]


def _numbers(part: MapPart, pixel: Ints, sample: Ints) -> NDArray[np.uint64]:
    """The numbers of bodies among all of a part, as the core reads them."""
    return (pixel * part.spec.samples + sample).astype(np.uint64)


def _drawn(part: MapPart, pixel: Ints, sample: Ints) -> tuple[Floats, Floats]:
    """Rates and attitudes of bodies of a part."""
    rates, rotations = to_core(part.spec).starts(_numbers(part, pixel, sample))
    return rates.reshape(-1, 3), rotations.reshape(-1, 4)


def condition(data: MapData, samples: int, threads: int) -> Floats:
    """The median condition of the first samples of each pixel; see ``StabilityMap.condition``."""
    spec = data.spec
    flat, possible = _flat(data, np.arange(samples))
    factors = np.empty(len(flat))
    for part, mine, own, sample in in_parts(spec, flat):
        every = part.spec.bodies(spec.start.starts[0], own, sample)
        bodies = every.bodies(np.arange(len(own)), *_drawn(part, own, sample))
        factors[mine] = amplification(bodies, np.array([part.spec.t_end]), threads)[:, 0]
    layer = np.full(spec.shape, np.nan)
    layer.flat[np.flatnonzero(possible[::samples])] = np.median(
        factors.reshape(-1, samples), axis=1
    )
    return layer


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
    found: dict[str, NDArray[Any]] = {}
    for part, mine, own, sample in in_parts(spec, asked):
        job = to_core(part.spec, fixed=part.fixed)
        for name, every in job.outcomes(_numbers(part, own, sample), threads).items():
            found.setdefault(name, np.empty((len(asked), *every.shape[1:]), dtype=every.dtype))
            found[name][mine] = every
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


def _samples(sample: ArrayLike, count: int) -> Ints:
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
    data: MapData, numbers: Ints, pixel: int | tuple[int, ...] | None = None
) -> tuple[Ints, NDArray[np.bool_]]:
    """Numbers among all samples of the map, and which of the requested bodies are possible."""
    spec = data.spec
    pixels = np.arange(math.prod(spec.shape))
    if pixel is not None:
        pixels = np.array([np.ravel_multi_index(pixel_index(pixel, spec.shape), spec.shape)])
    flat = (pixels[:, np.newaxis] * spec.samples + numbers.ravel()).ravel()
    possible = (data.status.ravel()[pixels] == 0).repeat(numbers.size)
    return flat[possible], possible
