"""Sensitivity of the bodies of a map to where they start."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..solve.sensitivity import amplification
from .job import to_core
from .spec import MapSpec

Floats = NDArray[np.float64]


def map_condition(spec: MapSpec, samples: int, threads: int) -> Floats:
    """The median condition of the first samples of each pixel at the horizon of a map."""
    if len(spec.parts) > 1:
        whole = np.empty(math.prod(spec.shape))
        for part in spec.parts:
            whole[part.pixels] = map_condition(part.spec, samples, threads).ravel()
        return whole.reshape(spec.shape)
    job = to_core(spec)
    possible = np.flatnonzero(job.status == 0)
    of_pixel = np.repeat(possible, samples)
    drawn = of_pixel * spec.samples + np.tile(np.arange(samples), len(possible))
    rates, rotations = job.starts(drawn.astype(np.uint64))
    omega, attitude = rates.reshape(-1, 3), rotations.reshape(-1, 4)
    sample = np.tile(np.arange(samples), len(possible))
    every = spec.bodies(spec.start.starts[0], of_pixel, sample)
    bodies = every.bodies(np.arange(len(of_pixel)), omega, attitude)
    factors = amplification(bodies, np.array([spec.t_end]), threads)[:, 0]
    layer = np.full(spec.shape, np.nan)
    layer.flat[possible] = np.median(factors.reshape(-1, samples), axis=1)
    return layer
