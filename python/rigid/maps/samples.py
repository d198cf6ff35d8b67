"""Many bodies of a map again: their starts, their outcomes and their sensitivity to the start."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief
from .._checks.arrays import Floats
from .._checks.quantities import plain
from .._checks.shown import short_repr
from ..solve.status import Status
from ..solve.tangent import amplification
from .data import MapData
from .job import requests
from .replay import named_outcomes, pixel_index

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
    flat, on_grid = _asked(data, sample, pixel)
    omega, attitude = np.empty((len(flat), 3)), np.empty((len(flat), 4))
    drawn = {one.name: np.empty(len(flat)) for one in spec.vary}
    draws = np.zeros(len(flat), dtype=np.int64)
    for some in requests(spec, flat):
        omega[some.places], attitude[some.places] = some.starts()
        if spec.vary:
            bodies = some.bodies()
            assert bodies.draws is not None
            draws[some.places] = bodies.draws
            for name, values in bodies.drawn.items():
                drawn[name][some.places] = values

    return Starts(
        omega=on_grid(omega, np.nan),
        attitude=on_grid(attitude, np.nan),
        parameters={name: on_grid(values, np.nan) for name, values in drawn.items()},
        draws=on_grid(draws, 0) if spec.vary else None,
    )


def condition(data: MapData, samples: int, threads: int) -> Floats:
    """The median condition of the first samples of each pixel; see ``StabilityMap.condition``."""
    spec = data.spec
    flat, on_grid = _asked(data, np.arange(samples), None)
    factors = np.empty(len(flat))
    for some in requests(spec, flat):
        bodies = some.bodies().bodies(np.arange(len(some.pixels)), *some.starts())
        ends = np.array([some.part.spec.t_end])
        factors[some.places] = amplification(bodies, ends, threads)[:, 0]
    return np.asarray(np.median(on_grid(factors, np.nan), axis=-1))


def outcomes(
    data: MapData,
    sample: ArrayLike,
    pixel: int | tuple[int, ...] | None,
    threads: int,
) -> Outcomes:
    """Outcomes of bodies; see :meth:`rigid.StabilityMap.outcomes`."""
    spec = data.spec
    flat, on_grid = _asked(data, sample, pixel)
    asked, of_each = np.unique(flat, return_inverse=True)
    found = _core.unknown_outcomes(len(asked))
    found["measures"] = np.empty((len(asked), len(spec.measure)))
    for some in requests(spec, asked):
        job, numbered = some.request()
        of_some = job.outcomes(numbered, threads)
        for name, every in found.items():
            every[some.places] = of_some[name]

    def each(values: NDArray[Any], nothing: object) -> NDArray[Any]:
        return on_grid(values[of_each], nothing)

    nothing = {"outcome": "", "method": "", "status": Status.NOT_FINITE, "flips": 0, "steps": 0}
    named = named_outcomes(spec, found)
    measures = {name: each(values, np.nan) for name, values in named.pop("measures").items()}
    values = {name: each(of_all, nothing.get(name, np.nan)) for name, of_all in named.items()}
    return Outcomes(measures=measures, **values)


def _asked(
    data: MapData, sample: ArrayLike, pixel: int | tuple[int, ...] | None
) -> tuple[Ints, Callable[[NDArray[Any], object], NDArray[Any]]]:
    """Numbers of the possible bodies among all of the map, and what puts values into their axes."""
    spec = data.spec
    numbers = np.asarray(plain("sample", sample))
    if numbers.dtype.kind not in "iu":
        raise TypeError(f"sample = {brief(sample)}: must be a whole number, or an array of them")
    outside = (numbers < 0) | (numbers >= spec.samples)
    if outside.any():
        bad = int(numbers[outside].flat[0])
        raise IndexError(f"sample = {bad}: must lie in 0 .. {spec.samples - 1}")
    pixels, shape = np.arange(math.prod(spec.shape)), (*spec.shape, *numbers.shape)
    if pixel is not None:
        index = pixel_index(pixel, spec.shape)
        pixels, shape = np.array([np.ravel_multi_index(index, spec.shape)]), numbers.shape
    flat = pixels[:, np.newaxis] * spec.samples + numbers.ravel().astype(np.int64)
    possible = np.broadcast_to((data.status.ravel()[pixels] == 0)[:, np.newaxis], flat.shape)

    def on_grid(values: NDArray[Any], nothing: object) -> NDArray[Any]:
        every = np.full((*flat.shape, *values.shape[1:]), nothing, dtype=values.dtype)
        every[possible] = values
        return every.reshape((*shape, *values.shape[1:]))

    return flat[possible], on_grid
