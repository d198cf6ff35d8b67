"""Random numbers of the core from the uniforms of NumPy, as the tests of draws share them."""

import numpy as np
from numpy.typing import NDArray

EPS = 2.0**-52


def uniforms(seed: int, block: int, pixels: int, samples: int) -> NDArray[np.longdouble]:
    """The four uniforms of each sample in a block of its draws, shape (pixels, samples, 4)."""

    def four(pixel: int, sample: int) -> NDArray[np.float64]:
        philox = np.random.Philox(key=seed, counter=[block, sample, pixel, 0])
        return np.random.Generator(philox).random(4)

    rows = [[four(pixel, sample) for sample in range(samples)] for pixel in range(pixels)]
    return np.array(rows, dtype=np.longdouble)


def turn(u: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    """The angle of a uniform, rounded to a double as the core rounds it."""
    return (2.0 * np.pi * u.astype(np.float64)).astype(np.longdouble)


def box_muller(u: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    """Three standard normals from four uniforms."""
    first, second = (np.sqrt(-2.0 * np.log(1.0 - u[..., k])) for k in (0, 2))
    return np.stack(
        [
            first * np.cos(turn(u[..., 1])),
            first * np.sin(turn(u[..., 1])),
            second * np.cos(turn(u[..., 3])),
        ],
        axis=-1,
    )
