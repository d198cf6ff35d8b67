"""Normal noise with a covariance: the draws are NumPy's, and have the covariance."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from drawn_again import EPS, box_muller, uniforms
from map_texts import FREE, map_text
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from small_maps import Floats, small_map

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)
SEED = 2**64 + 5
RATES = np.array([[0.04, 0.01, -0.02], [0.01, 0.09, 0.03], [-0.02, 0.03, 0.05]])
HALF = np.array(
    [
        [0.3, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.1, 0.2, 0.0, 0.0, 0.0, 0.0],
        [-0.2, 0.1, 0.25, 0.0, 0.0, 0.0],
        [0.05, 0.0, 0.1, 0.2, 0.0, 0.0],
        [0.0, -0.1, 0.0, 0.05, 0.1, 0.0],
        [0.1, 0.0, 0.0, -0.05, 0.02, 0.15],
    ]
)
BOTH = HALF @ HALF.T
BOTH = 0.5 * (BOTH + BOTH.T)


def tops(samples: int = 40, **start: Any) -> rigid.StabilityMap:
    return small_map(
        TOP,
        axes={"mgl": [1.0, 1.5]},
        start=rigid.Start(omega=(0.3, -0.2, 4.0), **start),
        stable=rigid.tilt_below(1.0),
        samples=samples,
        t_end=0.01,
        rng=SEED,
    )


def normals(block: int, samples: int) -> NDArray[np.longdouble]:
    """Three standard normals of each body, shape (2, samples, 3), from NumPy."""
    return box_muller(uniforms(SEED, block, 2, samples))


def turns(attitude: Floats) -> Floats:
    """Rotation vectors of attitudes."""
    vectors: Floats = Rotation.from_quat(attitude, scalar_first=True).as_rotvec()
    return vectors


def test_rates_with_a_covariance_follow_numpy() -> None:
    got = tops(noise=rigid.normal(cov=RATES)).starts(range(40)).omega
    factor = np.linalg.cholesky(RATES)
    expected = [0.3, -0.2, 4.0] + normals(0, 40).astype(np.float64) @ factor.T
    # Factor, deviates and their sum: 8 roundings of numbers below 1, and one of the rate.
    np.testing.assert_allclose(got, expected, rtol=EPS, atol=16.0 * EPS)


def test_attitudes_with_a_covariance_follow_numpy() -> None:
    got = tops(attitude_noise=rigid.normal(cov=RATES)).starts(range(40)).attitude
    expected = normals(1, 40).astype(np.float64) @ np.linalg.cholesky(RATES).T
    # A rotation vector is read from a quaternion: its angle loses the roundings of sine and cosine.
    np.testing.assert_allclose(turns(got.reshape(-1, 4)), expected.reshape(-1, 3), atol=40.0 * EPS)


def test_rates_and_attitude_hang_together() -> None:
    result = tops(noise=rigid.normal(cov=BOTH))
    starts = result.starts(range(40))
    both = np.concatenate([normals(0, 40), normals(1, 40)], axis=-1).astype(np.float64)
    expected = both @ np.linalg.cholesky(BOTH).T
    np.testing.assert_allclose(
        starts.omega, [0.3, -0.2, 4.0] + expected[..., :3], rtol=EPS, atol=32.0 * EPS
    )
    np.testing.assert_allclose(
        turns(starts.attitude.reshape(-1, 4)), expected[..., 3:].reshape(-1, 3), atol=64.0 * EPS
    )
    assert result.theory() is None


def test_a_diagonal_covariance_is_a_size_of_each_component() -> None:
    sizes = np.array([0.25, 0.5, 0.0])  # whose squares and roots are exact
    one = tops(noise=rigid.normal(sizes)).starts(range(40)).omega
    other = tops(noise=rigid.normal(cov=np.diag(sizes**2))).starts(range(40)).omega
    np.testing.assert_array_equal(one, other)


def test_a_covariance_may_have_directions_without_noise() -> None:
    along = np.array([3.0, 4.0, 12.0]) / 130.0
    starts = tops(noise=rigid.normal(cov=np.outer(along, along))).starts(range(40)).omega
    deviates = (starts - [0.3, -0.2, 4.0]).reshape(-1, 3)
    np.testing.assert_allclose(np.cross(deviates, along), 0.0, atol=1e-15)
    assert np.std(deviates @ along) > 1e-3


def test_tables_say_a_covariance() -> None:
    text = map_text(
        scene=FREE,
        start='noise = { kind = "normal", cov = [[1, 0, 0], [0, 2, 1], [0, 1, 4]] }',
        stable='criterion = "no_flip"',
    )
    noise = rigid.normal(cov=[[1, 0, 0], [0, 2, 1], [0, 1, 4]])
    assert parse_spec(text, "a.toml").start.starts[0].noise == noise


test_matrices_that_are_no_covariance = refuses(
    [
        (np.eye(2), "cov: expected shape (3, 3) or (6, 6), got (2, 2)"),
        (np.full((3, 3), np.nan), "cov[0, 0] = nan: must be finite"),
        ([[1, 2, 0], [0, 1, 0], [0, 0, 1]], "cov[0, 1] = 2: must be symmetric; the entry across"),
        ([[1, 2, 0], [2, 1, 0], [0, 0, 1]], "cov: must be positive semi-definite"),
        ([[0, 1, 0], [1, 1, 0], [0, 0, 1]], "cov: must be positive semi-definite"),
        (-np.eye(3), "cov: must be positive semi-definite"),
        (None, "size, cov: give one of the two to normal()"),
    ],
    literal=True,
    by=lambda cov: rigid.normal(cov=cov),
)


test_covariances_that_do_not_fit = refuses(
    [
        (
            lambda: rigid.Noise("uniform", cov=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))),
            "cov: belongs to normal noise",
        ),
        (
            lambda: rigid.Start(spin=1.0, attitude_noise=rigid.normal(cov=np.eye(6))),
            "attitude_noise: a covariance of rates and attitude is a noise",
        ),
        (
            lambda: small_map(start=rigid.Start(spin=1.0, noise=rigid.normal(cov=np.eye(6)))),
            "noise = normal(cov 6 x 6): the attitude of a free body",
        ),
        (
            lambda: small_map(
                axes={"noise": [1.0]},
                start=rigid.Start(spin=1.0, noise=rigid.normal(cov=np.eye(3))),
            ),
            "the noise of the start has a covariance; give it a size",
        ),
    ],
    literal=True,
)
