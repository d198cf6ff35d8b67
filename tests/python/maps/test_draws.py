"""The random starts: NumPy's Philox gives every draw again, each law is what it is called."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from drawn_again import EPS, box_muller, turn, uniforms
from refusals import refuses
from rigid import _core
from rigid.maps.core_request import CoreRequest, CoreStarts
from rigid.maps.plan import map_plan
from rigid.rotations.quaternions import quaternion_product
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


# Starts from a list: each body takes the entry that NumPy's numbers tell.


TOP = rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0)
SEED = 2**64 + 5
COUNT = 7


def listed() -> tuple[Floats, Floats]:
    random = np.random.default_rng(3)
    attitude = random.normal(size=(COUNT, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, np.newaxis]
    return random.normal(size=(COUNT, 3)), attitude


def begun(**start: Any) -> rigid.Starts:
    """The starts of 50 tops in each of two pixels."""
    result = small_map(
        TOP,
        axes={"mgl": [1.0, 1.5]},
        start=rigid.Start(**{"omega": (0.3, -0.2, 4.0), **start}),
        stable=rigid.tilt_below(1.0),
        samples=50,
        t_end=0.01,
        rng=SEED,
    )
    assert result.theory() is None
    return result.starts(range(50))


@pytest.mark.parametrize("weights", [None, [1.0, 0.0, 3.0, 0.5, 0.0, 2.0, 0.0]])
def test_bodies_take_the_entries_that_numpy_draws(weights: list[float] | None) -> None:
    omega, attitude = listed()
    starts = begun(omega=(0.0, 0.0, 0.0), noise=rigid.samples(omega, attitude, weights))
    chances = np.ones(COUNT) if weights is None else np.array(weights)
    shares, first = np.cumsum(chances) / chances.sum(), uniforms(SEED, 0, 2, 50)[..., 0]
    taken = np.searchsorted(shares, first, side="right")
    np.testing.assert_array_equal(starts.omega, omega[taken])
    np.testing.assert_array_equal(starts.attitude, attitude[taken])
    assert set(taken.ravel()) == set(np.flatnonzero(chances))


def test_samples_in_order_begin_again_after_the_last() -> None:
    omega, attitude = listed()
    given = rigid.samples(omega, attitude, in_order=True)
    starts = begun(omega=(0.0, 0.0, 0.0), noise=given)
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


# Normal noise with a covariance: the draws are NumPy's, and have the covariance.


COVARIANCE = np.array([[0.04, 0.01, -0.02], [0.01, 0.09, 0.03], [-0.02, 0.03, 0.05]])
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


def normals(block: int) -> Floats:
    """Three standard normals of each body, shape (2, 50, 3), from NumPy."""
    return box_muller(uniforms(SEED, block, 2, 50)).astype(np.float64)


def turns(attitude: Floats) -> Floats:
    """Rotation vectors of attitudes."""
    vectors: Floats = Rotation.from_quat(attitude, scalar_first=True).as_rotvec()
    return vectors


def test_rates_with_a_covariance_follow_numpy() -> None:
    got = begun(noise=rigid.normal(cov=COVARIANCE)).omega
    factor = np.linalg.cholesky(COVARIANCE)
    expected = [0.3, -0.2, 4.0] + normals(0) @ factor.T
    # Factor, deviates and their sum: 8 roundings of numbers below 1, and one of the rate.
    np.testing.assert_allclose(got, expected, rtol=EPS, atol=16.0 * EPS)


def test_attitudes_with_a_covariance_follow_numpy() -> None:
    got = begun(attitude_noise=rigid.normal(cov=COVARIANCE)).attitude
    expected = normals(1) @ np.linalg.cholesky(COVARIANCE).T
    # A rotation vector is read from a quaternion: its angle loses the roundings of sine and cosine.
    np.testing.assert_allclose(turns(got.reshape(-1, 4)), expected.reshape(-1, 3), atol=40.0 * EPS)


def test_rates_and_attitude_hang_together() -> None:
    starts = begun(noise=rigid.normal(cov=BOTH))
    both = np.concatenate([normals(0), normals(1)], axis=-1)
    expected = both @ np.linalg.cholesky(BOTH).T
    np.testing.assert_allclose(
        starts.omega, [0.3, -0.2, 4.0] + expected[..., :3], rtol=EPS, atol=32.0 * EPS
    )
    np.testing.assert_allclose(
        turns(starts.attitude.reshape(-1, 4)), expected[..., 3:].reshape(-1, 3), atol=64.0 * EPS
    )


def test_a_diagonal_covariance_is_a_size_of_each_component() -> None:
    sizes = np.array([0.25, 0.5, 0.0])  # whose squares and roots are exact
    one = begun(noise=rigid.normal(sizes)).omega
    other = begun(noise=rigid.normal(cov=np.diag(sizes**2))).omega
    np.testing.assert_array_equal(one, other)


def test_a_covariance_may_have_directions_without_noise() -> None:
    along = np.array([3.0, 4.0, 12.0]) / 130.0
    starts = begun(noise=rigid.normal(cov=np.outer(along, along))).omega
    deviates = (starts - [0.3, -0.2, 4.0]).reshape(-1, 3)
    np.testing.assert_allclose(np.cross(deviates, along), 0.0, atol=1e-15)
    assert np.std(deviates @ along) > 1e-3


def test_a_component_of_a_covariance_may_have_no_variance() -> None:
    assert rigid.normal(cov=np.diag([4.0, 0.0, 1.0])).cov == ((4, 0, 0), (0, 0, 0), (0, 0, 1))
    # Of a single direction, to rounding.
    assert rigid.normal(cov=np.outer([0.1, 0.3, 0.7], [0.1, 0.3, 0.7]))


test_matrices_that_are_no_covariance = refuses(
    [
        (np.eye(2), "cov: expected shape (3, 3) or (6, 6), got (2, 2)"),
        (np.full((3, 3), np.nan), "cov[0, 0] = nan: must be finite"),
        ([[1, 2, 0], [0, 1, 0], [0, 0, 1]], "cov[0, 1] = 2: must be symmetric; the entry across"),
        ([[1, 2, 0], [2, 1, 0], [0, 0, 1]], "cov: must be positive semi-definite"),
        ([[0, 1, 0], [1, 1, 0], [0, 0, 1]], "cov: must be positive semi-definite"),
        (-np.eye(3), "cov: must be positive semi-definite"),
        # More than rounding, beside small variances.
        ([[1, 1, 1e-9], [1, 1, 0], [1e-9, 0, 0]], "cov: must be positive semi-definite"),
        ([[1, 1, 1e-8], [1, 1, 0], [1e-8, 0, 1e-6]], "cov: must be positive semi-definite"),
        (None, "size, cov: give one of the two to normal()"),
    ],
    literal=True,
    by=lambda cov: rigid.normal(cov=cov),
)


# Mixtures of starts: which start a body takes, and that nothing else depends on the others.


QUIET = rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.1))
WILD = rigid.Start(
    spin=1.0, tilt=0.4, noise=rigid.uniform(2.0), attitude_noise=rigid.von_mises_fisher(2.0)
)
GIVEN = rigid.Start(
    omega=(0.0, 0.0, 2.0), noise=rigid.samples(np.diag([0.1, 0.2, 0.3]), weights=[1, 2, 1])
)
JOINT = rigid.Start(spin=2.0, noise=rigid.normal(cov=np.diag([1, 2, 3, 4, 5, 6]) * 1e-2))
MIXED = rigid.mixture([QUIET, WILD, GIVEN, JOINT], weights=[4.0, 3.0, 2.0, 1.0])
AXES: dict[str, Any] = {"mgl": [0.5, 1.0, 2.0]}
MANY = 500
NO_START: Any = 3


def mixed(start: Any, **options: Any) -> rigid.StabilityMap:
    chosen: dict[str, Any] = {
        "axes": AXES,
        "samples": MANY,
        "t_end": 1e-6,
        "stable": rigid.tilt_below(0.8),
        "rng": 77,
        "check": 0.0,
    }
    return rigid.stability_map(TOP, start=start, **{**chosen, **options})


def test_each_body_begins_as_in_a_map_of_its_start_alone() -> None:
    """NumPy tells which: block 2 of the draws of the sample."""
    both = mixed(MIXED).starts(range(MANY))
    alone = [mixed(start).starts(range(MANY)) for start in MIXED.starts]
    shares = MIXED.shares()
    assert shares[-1] == 1.0
    for pixel, u in enumerate(uniforms(77, 2, 3, MANY)[..., 0]):
        taken = np.searchsorted(shares, u, side="right")
        for number, one in enumerate(alone):
            mine = taken == number
            assert mine.any()
            for name in ("omega", "attitude"):
                np.testing.assert_array_equal(
                    getattr(both, name)[pixel, mine], getattr(one, name)[pixel, mine]
                )


def test_judged_bodies_and_horizons_of_a_mixture() -> None:
    def rises(states: rigid.States) -> Any:
        assert states.gamma is not None
        return states.gamma[:, -1, 2] > 0.5

    t = [0.0, 1.0, 3.0]
    axes = {"mgl": [0.5, 1.0], "t_end": [1.0, 3.0]}
    asked: dict[str, Any] = {"samples": 60, "axes": axes, "t_end": None}
    result = mixed(MIXED, stable=rigid.judged(rises, t), **asked)
    single = mixed(
        MIXED, stable=rigid.judged(rises, t[:2]), **{**asked, "axes": {"mgl": [0.5, 1.0]}}
    )
    np.testing.assert_array_equal(result.stable[0], single.stable)
    assert mixed(MIXED, samples=1).theory() is None


def test_an_axis_sets_its_number_in_every_start() -> None:
    both = rigid.mixture([rigid.Start(spin=s, noise=rigid.normal(n)) for s, n in ((1, 1), (2, 2))])
    starts = small_map(start=both, axes={"spin": [3.0], "noise": [0.0]}, samples=50).starts(
        range(50)
    )
    assert (starts.omega == [0.0, 0.0, 3.0]).all()
    # The plan is that of the fastest start.
    fast = rigid.mixture([rigid.Start(spin=1.0, axis=2), rigid.Start(spin=9.0, axis=2)])
    slow = rigid.Start(spin=1.0, axis=2)
    steps = [
        map_plan(small_map(start=one, axes={"I2/I1": [1.5]}, samples=1).spec).steps or 0
        for one in (slow, fast)
    ]
    assert steps[1] > 5.0 * steps[0]


# Directions of von Mises and Fisher: the bits of each draw. Their law is tested with all others.


KAPPAS = [0.0, 1e-300, 1e-9, 0.3, 3.0, 20.0, 500.0, 1e6, 1e300]


def turned(axis: int, tilt: float = 0.0, **start: Any) -> rigid.StabilityMap:
    name = "kappa" if "noise" in start else "attitude_kappa"
    return rigid.stability_map(
        TOP,
        axes={name: KAPPAS},
        samples=SAMPLES,
        t_end=1e-9,
        stable=rigid.tilt_below(3.0),
        start=rigid.Start(spin=2.0, axis=axis, tilt=tilt, **start),
        method="rk4",
        check=0.0,
        rng=2026,
    )


def versines(block: int) -> tuple[Floats, Floats]:
    """1 - cos of each body by the inverse of the distribution, and its azimuth, from NumPy."""
    u = uniforms(2026, block, len(KAPPAS), SAMPLES)
    kappa = np.array(KAPPAS, dtype=np.longdouble)[:, np.newaxis]
    with np.errstate(invalid="ignore"):  # without a concentration Archimedes' law
        concentrated = -np.log1p(u[..., 0] * np.expm1(-2.0 * kappa)) / kappa
    off = np.where(kappa > 0.0, concentrated, 2.0 * u[..., 0])
    return off.astype(np.float64), turn(u[..., 1]).astype(np.float64)


@pytest.mark.parametrize(("axis", "tilt"), [(3, 0.0), (1, 0.0), (2, 1.1)])
def test_numpy_draws_each_axis_again(axis: int, tilt: float) -> None:
    """To some roundings: the angle is 2 asin(sqrt(versine / 2)), its azimuth 2 pi u."""
    result = turned(axis, tilt, attitude_noise=rigid.von_mises_fisher(1.0))
    assert (result.status == 0).all()
    off, azimuth = versines(ATTITUDE)
    half = 0.5 * off
    parts = [np.sqrt(half) * np.cos(azimuth), np.sqrt(half) * np.sin(azimuth), 0.0 * half]
    vector = np.roll(np.stack(parts, axis=-1), axis, axis=-1)
    turns = np.concatenate([np.sqrt(1.0 - half)[..., np.newaxis], vector], axis=-1)
    expected = quaternion_product(result.spec.grid.attitude[0], turns)
    # sqrt halves the 8 ulp of the versine; a sine has 1e-16 of its argument besides. A turn of the
    # nominal attitude rounds four products.
    found = result.starts(range(SAMPLES)).attitude
    if tilt:
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-15)
    else:
        small = 4e-16 * np.sqrt(half)[..., np.newaxis]
        assert (abs(found - expected) <= 2e-15 * abs(expected) + small).all()


@pytest.mark.parametrize(
    "nominal", [(0.0, 2.0, 0.0), (1.0, -2.0, 0.5), (0.0, 0.0, -2.0), (0.0, 0.0, 0.0)]
)
def test_numpy_draws_each_angle_of_the_rates_again(nominal: tuple[float, float, float]) -> None:
    """They keep their length, also opposite to the third axis, where one across it turns."""
    law = rigid.von_mises_fisher(1.0)
    spec = turned(3, noise=law).spec.replace(start=rigid.Start(omega=nominal, noise=law))
    omega = rigid.stability_map(spec, progress=False).starts(range(SAMPLES)).omega
    length, (off, _) = math.hypot(*nominal), versines(RATES)
    np.testing.assert_allclose(np.linalg.norm(omega, axis=-1), length, rtol=2e-15)
    # 1 - cos of small angles too; each component is rounded to an ulp of the length.
    chord = np.linalg.norm(omega - nominal, axis=-1)
    np.testing.assert_allclose(chord, length * np.sqrt(2.0 * off), rtol=4e-15, atol=2e-15)


test_what_no_start_can_draw_from = refuses(
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
        (lambda: rigid.mixture([QUIET]), "starts: 1 are given, must be 2 to 16"),
        (lambda: rigid.mixture([QUIET] * 17), "starts: 17 are given, must be 2 to 16"),
        (
            lambda: rigid.mixture([QUIET, NO_START]),
            TypeError,
            "starts[1] = 3: must be a rigid.Start",
        ),
        (
            lambda: rigid.mixture([QUIET, WILD], [1.0]),
            "weights: expected shape (2,), one for each start, got (1,)",
        ),
        (
            lambda: rigid.mixture([QUIET, WILD], [1.0, 0.0]),
            "weights[1] = 0: must be positive and finite",
        ),
        (
            lambda: small_map(
                start=rigid.mixture([rigid.Start(spin=1.0, axis=k) for k in (1, 2)]),
                axes={"spin": [1.0]},
            ),
            "stable: the starts of the mixture turn about different axes; give axis=...",
        ),
        (lambda: rigid.von_mises_fisher(-1.0), "kappa = -1.0: must not be negative"),
        (lambda: rigid.von_mises_fisher(math.inf), "kappa = inf: must be finite"),
        (
            lambda: rigid.Start(
                spin=1.0, noise=type(rigid.normal(1.0))("von_mises_fisher", (1.0, 2.0, 3.0))
            ),
            "kappa: expected a single concentration, got 3 numbers",
        ),
        (
            lambda: turned(3, noise=rigid.normal(1.0)),
            "axes: 'kappa' does not apply: the start has no noise=rigid.von_mises_fisher",
        ),
        (
            lambda: turned(3, attitude_noise=rigid.normal(1.0)),
            "axes: 'attitude_kappa' does not apply: the start has no attitude_noise=rigid.von",
        ),
        (
            lambda: turned(3, noise=rigid.von_mises_fisher(1.0)).spec.replace(
                axes={"noise": [1.0]}
            ),
            "axes: 'noise' does not apply: the noise of the start has a concentration; use kappa",
        ),
        (
            lambda: turned(3, attitude_noise=rigid.von_mises_fisher(1.0)).spec.replace(
                axes={"attitude_noise": [1.0]}
            ),
            "the attitude noise has a concentration; use attitude_kappa",
        ),
    ],
    literal=True,
)
