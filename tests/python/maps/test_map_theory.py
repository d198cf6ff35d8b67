"""Where theory knows the answer: predictions against closed forms, and maps against predictions."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk
from scipy.stats import binom, norm

import rigid
from free_motions import of_jacobi
from rigid.maps.theory import Agreement, Theory, agreement, predict
from small_maps import Floats, small_map, spec_of

FREE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))


def prediction(**options: Any) -> Theory:
    """The prediction for the map of this request, which must exist."""
    theory = predict(spec_of(**options))
    assert theory is not None
    return theory


def curve(theory: Theory, word: str) -> Floats:
    """The field of the curve with that word in its label."""
    (found,) = (one for one in theory.curves if word in one.label)
    return found.field


def assert_agrees(result: rigid.StabilityMap, *, compared: int) -> None:
    """Theory and map disagree no more often than 95 % intervals miss a true share by chance.

    Each compared pixel misses with a chance of at most about 5 %, and with none where the share is
    0 or 1: so their number exceeds the binomial quantile below once in a thousand seeds.
    """
    theory: Any = result.theory()
    known = ~np.isnan(theory.share) & ~np.isnan(result.share)
    assert known.sum() >= compared
    assert result.disagreement().sum() <= binom.ppf(0.999, int(known.sum()), 0.05)
    assert not (result.disagreement() & ~known).any()


# The free body without noise: the separatrix


@pytest.mark.parametrize("axis", [1, 2, 3])
@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_the_separatrix_tells_who_keeps_its_sign(order: tuple[int, ...], axis: int) -> None:
    # Random rates: the sign of 2 E I2 - L² says which axis a body circulates about. About that one
    # nothing changes sign; everything else has done so after half a period.
    generator = np.random.default_rng(17)
    moments = np.array([1.0, 1.5, 2.0])[list(order)]
    ascending = np.argsort(moments)
    rates = np.sort(generator.uniform(-2.0, 2.0, 40))
    horizon = 20.0
    for _ in range(4):
        omega = generator.uniform(-1.0, 1.0, 3)
        name = f"omega{order.index(0) + 1}"  # the smallest axis
        theory = prediction(
            scene=rigid.FreeBody(rigid.Body(moments)),
            axes={name: rates},
            start=rigid.Start(omega=tuple(omega.tolist())),
            stable=rigid.no_flip(axis),
            t_end=horizon,
        )
        for rate, share in zip(rates, theory.share, strict=True):
            omega[order.index(0)] = rate
            energy = 0.5 * (moments * omega**2).sum()
            momentum = ((moments * omega) ** 2).sum()
            about = ascending[0] if 2.0 * energy * 1.5 > momentum else ascending[2]
            if axis - 1 == about:
                assert share == 1.0
            else:
                m, p, _ = of_jacobi(moments[ascending], omega[ascending])
                known = 2.0 * float(ellipk(m)) / p <= horizon
                np.testing.assert_array_equal(share, 0.0 if known else np.nan)


def test_the_separatrix_is_drawn_where_it_is() -> None:
    # A spin about axis 3, tilted towards axis 2: I3 (I3 - I2) w3² - I1 (I2 - I1) w1² with w1 = 0.
    # Tilted away from axis 1 instead it is zero at tan² = I1 (I2 - I1)/(I3 (I3 - I2)).
    tilt = np.linspace(0.1, 1.5, 1401)
    theory = prediction(
        axes={"tilt": tilt}, start=rigid.Start(spin=1.0, axis=1), stable=rigid.no_flip(1)
    )
    field = curve(theory, "separatrix")
    # omega = (cos, 0, sin): about axis 1 while I1 (I2 - I1) cos² > I3 (I3 - I2) sin².
    zero = math.atan(math.sqrt(1.0 * 0.5 / (2.0 * 0.5)))
    np.testing.assert_array_equal(field > 0.0, tilt < zero)
    np.testing.assert_array_equal(theory.share == 1.0, tilt < zero)
    # omega = (w1, 0, 1): about axis 3 while I3 (I3 - I2) > I1 (I2 - I1) w1².
    rates = np.linspace(0.01, 3.0, 301)
    about_large = prediction(
        axes={"omega1": rates}, start=rigid.Start(omega=(0.1, 0.0, 1.0)), stable=rigid.no_flip(3)
    )
    inside = 1.0 * 0.5 * rates**2 < 2.0 * 0.5
    np.testing.assert_array_equal(curve(about_large, "separatrix") > 0.0, inside)


def test_maps_without_noise_follow_the_separatrix_exactly() -> None:
    result = small_map(
        axes={"I2": np.linspace(0.8, 2.4, 30), "tilt": np.linspace(0.0, 1.5, 25)},
        start=rigid.Start(spin=1.0, axis=2),
        samples=1,
        t_end=20.0,
    )
    theory: Any = result.theory()
    known = ~np.isnan(theory.share)
    assert known.sum() > 500
    assert 0.1 < np.nanmean(theory.share) < 0.9
    np.testing.assert_array_equal(result.share[known], theory.share[known])


def test_about_a_principal_axis_no_other_rate_flips() -> None:
    result = small_map(
        axes={"omega1": [0.0, 0.1]},
        start=rigid.Start(omega=(0.0, 0.0, 0.5)),
        stable=rigid.no_flip(1),
        samples=1,
        t_end=50.0,
    )
    theory: Any = result.theory()
    np.testing.assert_array_equal(result.share, [1.0, 0.0])
    np.testing.assert_array_equal(theory.share, [np.nan, 0.0])


def test_a_flip_is_predicted_when_the_slowest_of_the_noise_has_flipped() -> None:
    # A rate that begins at zero is back there after half a period, pi over the rate of its small
    # oscillation about axis 3, which grows with the spin. The noise of the spin reaches 4 sizes.
    spin, size, (i1, i2, i3) = 2.0, 0.1, FREE.body.moments
    half = math.pi / math.sqrt((i3 - i1) * (i3 - i2) / (i1 * i2))
    start = rigid.Start(omega=(1e-6, 0.0, spin), noise=rigid.normal((0.0, 0.0, size)))
    ends = half / np.array([spin, spin - 3.9 * size, spin - 4.1 * size])
    theory = prediction(axes={"t_end": ends}, start=start, stable=rigid.no_flip(2))
    np.testing.assert_array_equal(theory.share, [np.nan, np.nan, 0.0])


def test_noise_within_reach_of_the_separatrix_makes_the_answer_unknown() -> None:
    # About axis 3 with w1 = 0.02, w3 = 1: I1 (I2 - I1) w1² reaches I3 (I3 - I2) w3² at w1 = 1.41.
    # Normal noise reaches 4 sizes, the others one.
    sizes = np.geomspace(1e-3, 3.0, 30)
    for noise, reach in ((rigid.normal(0.0), 4.0), (rigid.uniform(0.0), 1.0)):
        start = rigid.Start(omega=(0.0, 0.0, 1.0), noise=noise)
        theory = prediction(axes={"noise": sizes}, start=start, stable=rigid.no_flip(3))
        far, near = reach * sizes, np.maximum(1.0 - reach * sizes, 0.0)
        keeps = (2.0 * 0.5 * near**2 > 1.0 * 0.5 * far**2) & (near > 0.0)
        np.testing.assert_array_equal(theory.share == 1.0, keeps)
        assert np.isnan(theory.share[~keeps]).all()
        assert 5 < keeps.sum() < 25


# The free body about its middle axis: the heteroclinic flip time


def growth(moments: Floats, spin: float) -> tuple[float, float, float]:
    """Rate of growth, and the amplitudes of the rates about the smallest and the largest axis."""
    i1, i2, i3 = moments
    rate = spin * math.sqrt((i3 - i2) * (i2 - i1) / (i1 * i3))
    a1 = spin * math.sqrt(i2 * (i3 - i2) / (i1 * (i3 - i1)))
    a3 = spin * math.sqrt(i2 * (i2 - i1) / (i3 * (i3 - i1)))
    return rate, a1, a3


def flipping(sizes: Floats, t_end: float, spin: float = 1.3) -> Theory | None:
    """The prediction of what spins about its middle axis, with noise of these sizes."""
    start = rigid.Start(spin=spin, axis=2, noise=rigid.normal(0.0))
    stable = rigid.no_flip(2)
    return predict(spec_of(axes={"noise": sizes}, start=start, stable=stable, t_end=t_end))


@pytest.mark.parametrize("t_end", [8.0, 15.0, 25.0])
def test_the_law_of_the_middle_axis(t_end: float) -> None:
    # u = (w1 -+ w3 A1/A3)/2 is normal; no flip until t if |u| < 2 A1 exp(-rate t).
    sizes = np.geomspace(1e-6, 0.02, 15)
    theory: Any = flipping(sizes, t_end)
    rate, a1, a3 = growth(np.array([1.0, 1.5, 2.0]), 1.3)
    spread = 0.5 * sizes * math.hypot(1.0, a1 / a3)
    expected = 1.0 - 2.0 * norm.sf(2.0 * a1 * math.exp(-rate * t_end) / spread)
    np.testing.assert_allclose(theory.share, expected, rtol=1e-12, atol=1e-15)


def test_the_law_is_silent_where_noise_of_the_spin_changes_the_growth() -> None:
    """The exponent is proportional to the spin: here its spread is a quarter of one or less."""
    sizes, t_end = np.array([0.02, 0.0282, 0.0284, 0.035]), 25.0
    theory: Any = flipping(sizes, t_end)
    rate, a1, a3 = growth(np.array([1.0, 1.5, 2.0]), 1.3)
    assert sizes.max() < 0.05 * min(a1, a3)  # not what the other bound leaves out
    spread = sizes / 1.3 * rate * t_end
    np.testing.assert_array_equal(np.isfinite(theory.share), spread <= 0.25)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_growing_direction_has_the_right_sign(order: tuple[int, ...], sign: float) -> None:
    # Both other rates are given: along the growing direction they add, along the decaying one they
    # cancel. A wrong sign would put the long-lived bodies at the other end of the axis.
    moments = np.array([1.0, 1.5, 2.0])[list(order)]
    small, middle, large = (order.index(k) for k in range(3))
    _, a1, a3 = growth(np.sort(moments), 1.0)
    omega = [0.0, 0.0, 0.0]
    omega[middle], omega[large] = sign, 0.01
    result = small_map(
        rigid.FreeBody(rigid.Body(moments)),
        axes={f"omega{small + 1}": np.linspace(-0.035, 0.035, 41)},
        start=rigid.Start(omega=(omega[0], omega[1], omega[2]), noise=rigid.normal(0.002)),
        stable=rigid.no_flip(middle + 1),
        samples=200,
        t_end=18.0,
    )
    theory: Any = result.theory()
    assert np.nanmax(theory.share) > 0.5
    assert np.nanmin(theory.share) < 0.01
    assert_agrees(result, compared=35)
    # The decaying direction: w1 = +-w3 A1/A3 survives longest.
    rates = np.array(result.spec.axes[0].values)
    assert abs((rates * result.share).sum() / result.share.sum()) == pytest.approx(
        0.01 * a1 / a3, abs=0.001
    )


def test_maps_follow_the_law_of_the_middle_axis() -> None:
    result = small_map(
        axes={"I2/I1": np.linspace(1.1, 1.9, 15), "noise": np.geomspace(1e-4, 0.02, 15)},
        samples=150,
        t_end=18.0,
    )
    assert_agrees(result, compared=150)
    theory: Any = result.theory()
    between = (theory.share > 0.1) & (theory.share < 0.9)
    assert between.sum() > 30
    # And the mean deviation there is that of counting: each share scatters by sqrt(p (1 - p)/150).
    p = theory.share[between]
    pull = (result.share[between] - p) / np.sqrt(p * (1.0 - p) / 150)
    assert abs(pull.mean()) < 4.0 / math.sqrt(between.sum())
    assert 0.7 < pull.std() < 1.3


def test_half_have_flipped_on_the_curve() -> None:
    noise = np.geomspace(1e-5, 0.02, 200)
    theory = prediction(
        axes={"noise": noise, "spin": [0.9, 1.0]},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0)),
        stable=rigid.no_flip(2),
        t_end=20.0,
    )
    field = curve(theory, "half have flipped by t = 20 s, for small perturbations")
    np.testing.assert_array_equal(field > 0.0, theory.share > 0.5)
    assert (field > 0.0).any()
    assert (field < 0.0).any()


def test_large_noise_is_beyond_the_law() -> None:
    _, a1, a3 = growth(np.array([1.0, 1.5, 2.0]), 1.0)
    limit = 0.05 * min(a1, a3)
    for size, known in ((0.99 * limit, True), (1.01 * limit, False)):
        assert (flipping(np.array([size]), 5.0, spin=1.0) is not None) is known


# The symmetric top


def top(**options: Any) -> dict[str, Any]:
    """A request for tops that start upright, mgl I1 = 2.2, I3 = 0.6."""
    return {
        "scene": rigid.HeavyTop(rigid.Body((1.1, 1.1, 0.6)), mgl=2.0),
        "axes": {"spin": np.linspace(3.0, 7.0, 81)},
        "start": rigid.Start(spin=1.0, attitude_noise=rigid.normal(1e-6)),
        "stable": rigid.tilt_below(0.3),
        "t_end": 1e4,
        **options,
    }


def test_a_top_sleeps_above_the_bound() -> None:
    # omega3 = 2 sqrt(mgl I1)/I3, for vanishing tilt and limit and for ever: a tilt of 1e-9 and a
    # limit of 1e-3 rad shift it by less than 1e-6, well below the 0.05 between the pixels.
    bound = 2.0 * math.sqrt(2.0 * 1.1) / 0.6
    spin = np.concatenate([-np.linspace(3.0, 7.0, 81)[::-1], np.linspace(3.0, 7.0, 81)])
    start = rigid.Start(spin=1.0, attitude_noise=rigid.normal(1e-9))
    stable = rigid.tilt_below(1e-3)
    theory = prediction(**top(axes={"spin": spin}, start=start, stable=stable))
    np.testing.assert_array_equal(theory.share > 0.5, abs(spin) > bound)
    np.testing.assert_array_equal(theory.share < 0.5, abs(spin) < bound)
    assert 3.0 < bound < 7.0
    np.testing.assert_array_equal(curve(theory, "sleeping-top bound") > 0.0, abs(spin) > bound)


@pytest.mark.parametrize("damping", [None, (0.0, 0.0, 1e-5)])
def test_an_asymmetric_top_has_no_line_of_symmetric_tops(damping: Any) -> None:
    # 2 sqrt(mgl I) / I3 would be 4.000 or 4.733 rad/s. By the linear equations of the first two
    # rates and of the first two components of the vertical neither is the bound.
    def growth(spin: float) -> float:
        rates = [
            [0.0, (1.4 - 0.5) * spin, 0.0, 1.0],
            [(0.5 - 1.0) * spin / 1.4, 0.0, -1 / 1.4, 0.0],
        ]
        vertical = [[0.0, -1.0, 0.0, spin], [1.0, 0.0, -spin, 0.0]]
        return float(np.linalg.eigvals(np.array(rates + vertical)).real.max())

    assert growth(4.1) > 0.1
    assert growth(4.5) < 1e-6
    scene = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.5)), mgl=1.0, damping=damping)
    assert predict(spec_of(**top(scene=scene))) is None


def largest_tilt(spin: float, tilt: float) -> float:
    """Where the nutation of that top turns round, from the conserved quantities alone.

    Released with its axis at rest: energy and both momenta at the turning point x give
    (I3 w)² (cos th - cos x)²/(2 I1 sin² x) = mgl (cos th - cos x).
    """
    i1, i3, mgl = 1.1, 0.6, 2.0

    def excess(x: float) -> float:
        drop = math.cos(tilt) - math.cos(x)
        return (i3 * spin) ** 2 * drop / (2.0 * i1 * math.sin(x) ** 2) - mgl

    return float(brentq(excess, tilt * (1 + 1e-9) + 1e-12, math.pi - 1e-9))


@pytest.mark.parametrize("spin", [4.0, 5.0, 5.5, 7.0])
def test_tops_released_at_rest_nutate_to_the_predicted_tilt(spin: float) -> None:
    tilt = np.linspace(0.02, 0.28, 53)
    theory = prediction(**top(axes={"tilt": tilt}, start=rigid.Start(spin=spin)))
    below = np.array([largest_tilt(spin, th) < 0.3 for th in tilt])
    np.testing.assert_array_equal(theory.share, below)


@pytest.mark.parametrize("t_end", [0.5, 2.0, 60.0])
def test_maps_of_tops_without_noise_follow_the_nutation_exactly(t_end: float) -> None:
    # The grid has no point on the boundary. Near the bound of sleeping the way to the limit takes
    # long: the horizon is part of the prediction. A short one does not tell which tops will fall.
    request = top(
        axes={"spin": np.linspace(3.0, 7.0, 21), "tilt": np.linspace(0.01, 0.4, 20)},
        start=rigid.Start(spin=1.0),
        t_end=t_end,
    )
    result = small_map(**request, samples=1)
    theory: Any = result.theory()
    known = ~np.isnan(theory.share)
    assert known.all() == (t_end == 60.0)
    assert 0.1 < np.mean(theory.share == 1.0) < 0.9
    np.testing.assert_array_equal(result.share[known], theory.share[known])


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_maps_of_noisy_tops_follow_the_rayleigh_law(axis: int) -> None:
    moments, com = np.full(3, 1.0), np.zeros(3)
    moments[axis - 1], com[axis - 1] = 0.5, 1.0
    result = small_map(
        rigid.HeavyTop(rigid.Body(moments), mgl=1.0, com=com),
        axes={"spin": np.linspace(3.5, 5.5, 12), "attitude_noise": np.geomspace(1e-3, 0.2, 10)},
        start=rigid.Start(spin=4.0, axis=axis, attitude_noise=rigid.normal(0.0)),
        stable=rigid.tilt_below(0.5, axis=axis),
        samples=150,
        t_end=40.0,
    )
    theory: Any = result.theory()
    assert ((theory.share > 0.05) & (theory.share < 0.95)).sum() >= 12
    assert_agrees(result, compared=110)


def falling_time(tilt: float, spin: float, limit: float) -> float:
    """Time in which a top (1, 1, 0.5) with mgl = 1 nutates from rest at a tilt to the limit.

    x'² = 2 (cos th - cos x) - (I3 w)² (cos th - cos x)²/sin² x, integrated over x = th cosh s,
    which takes the root at the start away.
    """

    def slowness(s: float) -> float:
        x = tilt * math.cosh(s)
        drop = 2.0 * math.sin(0.5 * (x - tilt)) * math.sin(0.5 * (x + tilt))
        square = drop * (2.0 - (0.5 * spin) ** 2 * drop / math.sin(x) ** 2)
        return tilt * math.sinh(s) / math.sqrt(square)

    end = math.acosh(limit / tilt)
    return float(quad(slowness, 1e-9, end, epsabs=1e-10, epsrel=1e-10, limit=200)[0])


@pytest.mark.parametrize("spin", [0.5, 2.0, 3.0, 3.6])
@pytest.mark.parametrize("t_end", [15.0, 25.0])
def test_the_horizon_of_a_falling_top_is_that_of_the_exact_motion(
    spin: float, t_end: float
) -> None:
    # The law matches the homoclinic orbit, with its crest at a tilt of about 2 g, to the linear
    # stage: good to the square of the tilt in units of the crest, times the logarithm of the two.
    released = np.geomspace(1e-12, 0.4, 300)
    theory = prediction(
        scene=rigid.HeavyTop,
        axes={"tilt": released},
        start=rigid.Start(spin=spin),
        stable=rigid.tilt_below(0.5),
        t_end=t_end,
    )
    critical = float((curve(theory, "passes 0.5 rad") + released)[0])
    exact = math.exp(
        brentq(lambda log: falling_time(math.exp(log), spin, 0.5) - t_end, -40.0, math.log(0.4))
    )
    growth_squared = 1.0 - (0.25 * spin) ** 2
    assert critical == pytest.approx(exact, rel=max(1e-6, 10.0 * exact**2 / growth_squared))
    np.testing.assert_array_equal(theory.share, released < critical)


# Where nothing is known

HEAVY: dict[str, Any] = {
    "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0),
    "axes": {"spin": [5.0]},
    "start": rigid.Start(spin=5.0, attitude_noise=rigid.normal(1e-3)),
    "stable": rigid.tilt_below(0.5),
}
ASYMMETRIC = rigid.HeavyTop(rigid.Body((1.0, 1.1, 0.5)), mgl=1.0)
LEANING = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.6, 0.0, 0.8))
UNIFORM = rigid.Start(spin=5.0, attitude_noise=rigid.uniform(1e-3))
TILTED = rigid.Start(spin=5.0, tilt=0.1, noise=rigid.normal(1e-3))


@pytest.mark.parametrize(
    "options",
    [
        {"stable": rigid.tilt_below(0.5)},  # a free body's tilt
        {**HEAVY, "stable": rigid.no_flip()},  # a top's flip
        {**HEAVY, "stable": rigid.tilt_below(0.5, axis=1)},
        {**HEAVY, "stable": rigid.tilt_below(0.5, reference="start")},
        {**HEAVY, "scene": LEANING},
        {**HEAVY, "scene": ASYMMETRIC},
        {**HEAVY, "start": UNIFORM},
        {**HEAVY, "start": TILTED},
    ],
)
def test_nothing_is_claimed_where_nothing_is_known(options: dict[str, Any]) -> None:
    result = small_map(**{**options, "samples": 1, "t_end": 0.1})
    assert result.theory() is None
    assert not result.disagreement().any()
    assert "none is known for this map" in result.summary()


def test_impossible_and_degenerate_pixels_are_unknown() -> None:
    theory = prediction(
        axes={"I1": [0.3, 0.9, 1.5, 2.0, 3.6]},
        start=rigid.Start(spin=1.0, axis=2, tilt=0.01),
        stable=rigid.no_flip(2),
        t_end=100.0,
    )
    # Impossible; middle axis; symmetric about 3, where a rate about axis 2 must turn over in half a
    # period of the precession; symmetric about 2, which keeps its rate; impossible.
    assert np.isnan(theory.share[[0, 4]]).all()
    assert theory.share[1] == 0.0


def test_disagreement_is_a_prediction_outside_the_interval() -> None:
    result = small_map()
    theory = result.theory()
    assert theory is not None
    shares = np.full(result.spec.shape, np.nan)
    shares[0, :3] = result.lower[0, 0] - 1e-9, result.lower[0, 1], result.upper[0, 2] + 1e-9
    pretended = Theory("pretended", shares, ())
    expected = np.zeros(result.spec.shape, dtype=bool)
    expected[0, [0, 2]] = True
    np.testing.assert_array_equal(result.disagreement(pretended), expected)


def test_horizons_beyond_the_law_of_the_middle_axis_have_the_separatrix_alone() -> None:
    theory = prediction(
        axes={"tilt": [0.0, 1.2], "t_end": [15.0, 500.0]},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.01)),
    )
    assert theory.label.endswith("the middle axis, and so for the other horizons and limits")
    np.testing.assert_array_equal(np.isnan(theory.share), [[False, False], [True, False]])


@pytest.mark.parametrize("band", [1, 50, 2**16])
def test_agreement_counted_in_bands_is_that_of_the_whole_map(
    band: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = {"I2": np.linspace(0.9, 2.1, 7), "noise": np.geomspace(1e-3, 0.5, 6), "spin": [0.5, 3.0]}
    start = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1))
    for options in (
        {"scene": FREE, "start": start, "axes": axes, "stable": rigid.no_flip(2), "t_end": 9.0},
        {"scene": FREE, "axes": {"t_end": [1.0, 5.0, 20.0], "spin": [0.5, 2.0]}},
    ):
        result = small_map(samples=3, **options)
        theory: Any = result.theory()
        known, sampled = ~np.isnan(theory.share), ~np.isnan(result.share)
        monkeypatch.setattr("rigid.maps.theory.BAND", band)
        wrong = known & sampled
        wrong[1::2] = False
        result.lower[wrong], result.upper[wrong] = 0.4, 0.6
        found = agreement(result)
        assert found == Agreement(
            label=theory.label,
            compared=int((known & sampled).sum()),
            disagree=int(result.disagreement(theory).sum()),
            unknown=int((sampled & ~known).sum()),
        )
        assert found.disagree >= wrong.sum() > 0
