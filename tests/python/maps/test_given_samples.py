"""Starts from a list: each body takes the entry that NumPy's numbers tell."""

from typing import Any

import numpy as np
import pytest

import rigid
from drawn_again import uniforms
from refusals import refuses
from rigid.rotations.quaternions import quaternion_product
from small_maps import Floats, small_map

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)
SEED = 2**64 + 5
COUNT = 7


def listed() -> tuple[Floats, Floats]:
    random = np.random.default_rng(3)
    attitude = random.normal(size=(COUNT, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, np.newaxis]
    return random.normal(size=(COUNT, 3)), attitude


def tops(given: rigid.Samples, samples: int = 50, **options: Any) -> rigid.StabilityMap:
    return small_map(
        TOP,
        axes={"mgl": [1.0, 1.5]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0), noise=given),
        stable=rigid.tilt_below(1.0),
        samples=samples,
        t_end=0.01,
        rng=SEED,
        **options,
    )


def indices(shares: Floats, samples: int) -> np.ndarray[Any, Any]:
    """The entry of each body, shape (2, samples), from the uniforms of NumPy."""
    first = uniforms(SEED, 0, 2, samples)[..., 0]
    return np.searchsorted(shares, first, side="right")


@pytest.mark.parametrize("weights", [None, [1.0, 0.0, 3.0, 0.5, 0.0, 2.0, 0.0]])
def test_bodies_take_the_entries_that_numpy_draws(weights: list[float] | None) -> None:
    omega, attitude = listed()
    starts = tops(rigid.samples(omega, attitude, weights)).starts(range(50))
    chances = np.ones(COUNT) if weights is None else np.array(weights)
    taken = indices(np.cumsum(chances) / chances.sum(), 50)
    np.testing.assert_array_equal(starts.omega, omega[taken])
    np.testing.assert_array_equal(starts.attitude, attitude[taken])
    assert set(taken.ravel()) == set(np.flatnonzero(chances))


def test_samples_in_order_begin_again_after_the_last() -> None:
    omega, attitude = listed()
    starts = tops(rigid.samples(omega, attitude, in_order=True)).starts(range(50))
    order = np.arange(50) % COUNT
    np.testing.assert_array_equal(starts.omega[1], omega[order])
    np.testing.assert_array_equal(starts.attitude[0], attitude[order])


def test_samples_are_added_to_the_nominal_start() -> None:
    omega, attitude = listed()
    start = rigid.Start(spin=2.0, tilt=0.3, noise=rigid.samples(omega, attitude, in_order=True))
    result = small_map(TOP, axes={"spin": [2.0]}, start=start, stable=rigid.tilt_below(3.0))
    starts = result.starts(range(COUNT))
    np.testing.assert_array_equal(starts.omega[0], omega + np.array([0.0, 0.0, 2.0]))
    nominal = (np.cos(0.15), np.sin(0.15), 0.0, 0.0)
    expected = quaternion_product(nominal, attitude)
    # A product of unit quaternions: three roundings, and that of the nominal one.
    np.testing.assert_allclose(starts.attitude[0], expected, atol=1e-15)


def test_bodies_of_one_energy_are_stable_as_each_is_alone() -> None:
    omega, attitude = rigid.top.on_surface(TOP, energy=2.0, l_gamma=0.4, count=30, rng=1)
    given = rigid.samples(omega, attitude, in_order=True)
    result = small_map(
        TOP,
        axes={"t_end": [3.0]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0), noise=given),
        stable=rigid.tilt_below(2.3),
        samples=30,
        method="auto",
    )
    t = np.linspace(0.0, 3.0, 3001)
    gamma: Any = rigid.simulate(TOP, omega, attitude, t=t, method="dop853").gamma
    largest = np.arccos(np.clip(gamma[..., 2], -1.0, 1.0)).max(axis=-1)
    clear = abs(largest - 2.3) > 1e-3
    assert clear.all()
    assert result.stable.item() == (largest < 2.3).sum()
    assert 0 < result.stable.item() < 30


test_samples_that_do_not_fit = refuses(
    [
        (lambda: rigid.samples(), "samples() needs omega, attitude or both"),
        (lambda: rigid.samples([1.0, 2.0, 3.0]), "omega: expected shape (n, 3), got (3,)"),
        (lambda: rigid.samples(np.zeros((0, 3))), "omega: 0 samples, must be 1 to 100,000"),
        (lambda: rigid.samples([[1.0, np.nan, 0.0]]), "omega[0, 1] = nan: must be finite"),
        (
            lambda: rigid.samples(np.zeros((2, 3)), [[1.0, 0.0, 0.0, 0.0]]),
            "attitude: 1 samples, but omega has 2",
        ),
        (
            lambda: rigid.samples(None, [[0.0, 0.0, 0.0, 0.0]]),
            "attitude[0] = [0.0, 0.0, 0.0, 0.0]: a zero quaternion is no attitude",
        ),
        (
            lambda: rigid.samples(np.zeros((2, 3)), weights=[[1.0, 2.0]]),
            "weights: expected shape (n,), got (1, 2)",
        ),
        (lambda: rigid.samples(np.zeros((2, 3)), weights=[1.0]), "weights: 1 samples, but omega"),
        (
            lambda: rigid.samples(np.zeros((2, 3)), weights=[1.0, -1.0]),
            "weights: must be finite, not negative, and not all zero",
        ),
        (
            lambda: rigid.samples(np.zeros((2, 3)), weights=[1.0, 1.0], in_order=True),
            "weights: samples that are used in order have none",
        ),
        (
            lambda: rigid.Start(
                spin=1.0, noise=rigid.samples(*listed()), attitude_noise=rigid.normal(1.0)
            ),
            "attitude_noise: the noise perturbs the attitude already",
        ),
        (
            lambda: small_map(start=rigid.Start(spin=1.0, noise=rigid.samples(*listed()))),
            "noise = 7 given samples with attitudes: the attitude of a free body",
        ),
        (
            lambda: small_map(
                axes={"noise": [1.0]}, start=rigid.Start(spin=1.0, noise=rigid.samples(listed()[0]))
            ),
            "the start has given samples, which have no size",
        ),
        (
            lambda: rigid.samples([[1.0, 0.0, 0.0]], in_order=1),  # type: ignore[arg-type]
            TypeError,
            "in_order = 1: must be True or False",
        ),
    ],
    literal=True,
)
