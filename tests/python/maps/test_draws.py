"""The random starts: NumPy's Philox gives every draw again, each law is what it is called."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from drawn_again import EPS, box_muller, turn, uniforms
from rigid import _core
from rigid.maps.core_request import CoreRequest, CoreStarts
from small_maps import Floats, small_map

RATES, ATTITUDE = 0, 1  # blocks of draws
SEEDS = (0, 2026, 2**64 - 1, 2**64 + 5, 3 << 64, 2**128 - 1)
PIXELS, SAMPLES = 3, 5
OMEGA = np.array([[0.7, -1.1, 0.4], [0.0, 0.0, 0.0], [5.0, 1e-3, -2.0]])
OMEGA_SIZE = np.array([[0.3, 0.3, 0.3], [0.1, 2.0, 0.0], [1e-3, 1e-3, 1e-3]])
NOMINAL = Rotation.from_rotvec([[0.0, 0.0, 0.0], [0.4, -1.0, 2.0], [np.pi, 0.0, 0.0]])
ATTITUDE_SIZE = np.array([0.3, 1e-4, 1.5])


def job(
    *, rates: str = "none", attitude: str = "none", seed: int = 1, samples: int = SAMPLES
) -> _core.MapJob:
    """Tops at the nominal starts above, perturbed by these laws; they hardly move."""
    starts = CoreStarts(
        omega=OMEGA,
        omega_noise=rates,
        omega_size=OMEGA_SIZE,
        attitude=np.ascontiguousarray(NOMINAL.as_quat(scalar_first=True)),
        attitude_noise=attitude,
        attitude_size=np.repeat(ATTITUDE_SIZE[:, None], 3, axis=1),
    )
    request = CoreRequest(
        scene="top",
        method="rk4",
        moments=np.tile([1.0, 1.0, 0.5], (PIXELS, 1)),
        weight=np.tile([0.0, 0.0, 1.0], (PIXELS, 1)),
        starts=[starts],
        conditions=[("no_flip", 3, ())],
        logic="0",
        measures=[],
        t_end=1e-3,
        step=None,
        max_steps=10**6,
        samples=samples,
        checked=0,
        seed=seed,
    )
    return _core.MapJob(request)


def drawn(what: str, samples: int = SAMPLES, **options: Any) -> Floats:
    """``omega`` or ``attitude`` of all samples, shape (pixels, samples, 3 or 4)."""
    every = np.arange(PIXELS * samples, dtype=np.uint64)
    found = job(samples=samples, **options).starts(every)
    return found[what == "attitude"].reshape(PIXELS, samples, -1)


def isotropic(u: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    """A unit vector from two of the uniforms (Archimedes: its height is uniform)."""
    z = 2.0 * u[..., 0] - 1.0
    radius = np.sqrt((1.0 - z) * (1.0 + z))
    return np.stack(
        [radius * np.cos(turn(u[..., 1])), radius * np.sin(turn(u[..., 1])), z], axis=-1
    )


LAWS = {
    "normal": box_muller,
    "uniform": lambda u: 2.0 * u[..., :3] - 1.0,
    "direction": isotropic,
}


def rounded_once(size: Floats, deviate: Floats, nominal: Floats) -> Floats:
    """``size * deviate + nominal`` with a single rounding, in whole numbers."""
    each = np.broadcast(size, deviate, nominal)
    exact = [
        float(Fraction(float(s)) * Fraction(float(d)) + Fraction(float(n))) for s, d, n in each
    ]
    return np.array(exact).reshape(each.shape)


@pytest.mark.parametrize("seed", SEEDS)
def test_uniform_rates_are_those_of_numpy_to_the_bit(seed: int) -> None:
    # 2 u - 1 is exact for a uniform of 53 bits, so the one rounding of the fma is all there is.
    deviates = (2.0 * uniforms(seed, RATES, PIXELS, SAMPLES)[..., :3] - 1.0).astype(np.float64)
    expected = rounded_once(OMEGA_SIZE[:, None], deviates, OMEGA[:, None])
    np.testing.assert_array_equal(drawn("omega", rates="uniform", seed=seed), expected)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("law", LAWS)
def test_rates_follow_numpy(law: str, seed: int) -> None:
    # In the core: the logarithm is within 1 ulp, halved by the root, which rounds by 1/2; sine or
    # cosine 1; their product 1/2: a deviate is good to 2.5 ulp, 2.5 eps. The fma adds half an ulp
    # of the sum. Where longdouble is no wider than double the reference adds as much again.
    deviates = LAWS[law](uniforms(seed, RATES, PIXELS, SAMPLES))
    expected = OMEGA[:, None] + OMEGA_SIZE[:, None] * deviates
    allowed = 5.0 * EPS * (OMEGA_SIZE[:, None] * abs(deviates)) + 0.5 * EPS * abs(expected)
    error = abs(drawn("omega", rates=law, seed=seed) - expected)
    assert (error <= allowed).all(), (error / allowed).max()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("law", LAWS)
def test_attitudes_are_turned_by_a_rotation_vector_on_the_body_side(law: str, seed: int) -> None:
    # The vectors are good to 2.5 eps, at most 1.5 * 4 long, and enter by half their angle: 7.5 eps.
    # Sine and cosine, and four products a component, add 3 on either side.
    vectors = ATTITUDE_SIZE[:, None, None] * LAWS[law](uniforms(seed, ATTITUDE, PIXELS, SAMPLES))
    nominal = Rotation.from_quat(np.repeat(NOMINAL.as_quat(), SAMPLES, axis=0))
    turned = nominal * Rotation.from_rotvec(vectors.astype(np.float64).reshape(-1, 3))
    expected = turned.as_quat(scalar_first=True).reshape(PIXELS, SAMPLES, 4)
    got = drawn("attitude", attitude=law, seed=seed)
    sign = np.sign((got * expected).sum(axis=-1, keepdims=True))  # q and -q are one attitude
    np.testing.assert_allclose(got, sign * expected, rtol=0.0, atol=14.0 * EPS)
    np.testing.assert_allclose(np.linalg.norm(got, axis=-1), 1.0, rtol=4.0 * EPS)


@pytest.mark.parametrize("seed", SEEDS)
def test_uniform_attitudes_are_those_of_shoemake(seed: int) -> None:
    # Root, sine or cosine, and their product: 2 ulp; as much for the reference.
    u = uniforms(seed, ATTITUDE, PIXELS, SAMPLES)
    a, b = np.sqrt(1.0 - u[..., 0]), np.sqrt(u[..., 0])
    first, second = turn(u[..., 1]), turn(u[..., 2])
    expected = [a * np.sin(first), a * np.cos(first), b * np.sin(second), b * np.cos(second)]
    got = drawn("attitude", attitude="uniform_attitude", seed=seed)
    np.testing.assert_allclose(
        got, np.stack(expected, axis=-1).astype(np.float64), rtol=4.0 * EPS, atol=0.0
    )


def test_both_words_of_the_key_count() -> None:
    seeds = (5, 5 + (1 << 64), 5 << 64, 6)
    starts = {drawn("omega", rates="uniform", seed=seed).tobytes() for seed in seeds}
    assert len(starts) == len(seeds)


def test_the_law_of_the_rates_changes_no_attitude_and_the_other_way_round() -> None:
    laws = ("none", "normal", "uniform", "direction")
    attitudes = {
        drawn("attitude", rates=law, attitude="uniform_attitude").tobytes() for law in laws
    }
    rates = {
        drawn("omega", rates="normal", attitude=law).tobytes()
        for law in (*laws, "uniform_attitude")
    }
    assert len(attitudes) == len(rates) == 1


def test_no_law_leaves_the_nominal_start() -> None:
    np.testing.assert_array_equal(drawn("omega"), np.repeat(OMEGA[:, None], SAMPLES, axis=1))
    nominal = NOMINAL.as_quat(scalar_first=True)[:, None]
    np.testing.assert_array_equal(drawn("attitude"), np.repeat(nominal, SAMPLES, axis=1))


def test_samples_do_not_depend_on_their_number() -> None:
    few, many = (drawn("omega", samples, rates="normal") for samples in (2, 1000))
    np.testing.assert_array_equal(few, many[:, :2])


def test_replay_starts_where_numpy_says() -> None:
    seed = 2**64 + 5
    result = small_map(
        rigid.HeavyTop,
        axes={"spin": [4.0, 5.0], "mgl": [1.0, 1.5]},
        start=rigid.Start(
            spin=5.0, noise=rigid.uniform(0.5), attitude_noise=rigid.uniform_attitude()
        ),
        stable=rigid.tilt_below(1.0),
        samples=3,
        t_end=0.1,
        rng=seed,
    )
    for y, x, sample in ((0, 0, 0), (0, 1, 2), (1, 0, 1)):
        body = result.replay((y, x), sample)
        pixel = 2 * y + x
        philox = np.random.Philox(key=seed, counter=[RATES, sample, pixel, 0])
        deviates = 2.0 * np.random.Generator(philox).random(4)[:3] - 1.0
        nominal = np.array([0.0, 0.0, result.spec.axes[0].values[x]])
        assert body.omega.tolist() == (0.5 * deviates + nominal).tolist()  # 0.5 * is exact
        philox = np.random.Philox(key=seed, counter=[ATTITUDE, sample, pixel, 0])
        u = np.random.Generator(philox).random(4)
        w = np.sqrt(1.0 - u[0]) * np.sin(2.0 * np.pi * u[1])
        assert body.attitude[0] == pytest.approx(w, rel=4.0 * EPS)


def test_a_generator_and_a_seed_sequence_give_128_bits() -> None:
    for source in (np.random.default_rng, np.random.SeedSequence):
        seeds = {small_map(samples=1, t_end=1e-3, rng=source(k)).spec.seed for k in (1, 1, 2)}
        assert len(seeds) == 2
        assert all(2**64 < seed < 2**128 for seed in seeds)


def test_fresh_entropy_is_kept() -> None:
    one, other = (small_map(samples=1, t_end=1e-3, rng=None) for _ in range(2))
    assert one.spec.seed != other.spec.seed
    again = small_map(samples=1, t_end=1e-3, rng=one.spec.seed)
    assert again.replay(3, 0).omega.tolist() == one.replay(3, 0).omega.tolist()
